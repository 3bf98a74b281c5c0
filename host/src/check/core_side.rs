//! The core made to write down its results, through its `Observer`.

use super::cases::Case;
use super::record::{Recorder, Stage};
use varsac_core::jacobi::{self, Symmetric3};
use varsac_core::linalg::Symmetric9;
use varsac_core::{
    CentralQuadric, Detection, Detector, Ellipsoid, Estimate, Findings, Finds, Finish, Method, Noise,
    Observer, Quadric, Rejection, Score, Scratch, Stage as Phase, Status, Step, Support, VarsacReport,
};

/// Runs the core over a case.
pub(crate) fn run(case: &Case, recorder: &mut Recorder) {
    let detector = match Detector::new(case.config.clone()) {
        Ok(detector) => detector,
        Err(error) => unreachable!("the generator made an invalid configuration: {error}"),
    };
    let n = case.view.points.len().min(65_535);
    let (mut order, mut members, mut labels) = (vec![0; n], vec![0; n], vec![0; n]);
    let view = case.view.view();
    let mut finds = Finds::new();
    let scratch = Scratch::new(&mut order, &mut members, &mut labels, &mut finds);
    let run = detector.detect_view(&view, scratch, case.seed);
    recorder.integers(Stage::Cloud, "accepted", [u32::from(run.is_ok())]);
    let Ok(mut run) = run else { return };
    let limits = [case.config.semi_axis_min, case.config.semi_axis_max];
    let mut observer = CoreObserver { recorder, limits, method: case.config.method };
    let mut labels = vec![0; run.labels().len()];
    let finish = loop {
        match run.step_observed(&mut observer) {
            Step::Found(detection) if case.config.method == Method::Mixture => observer.body(&detection),
            Step::Working | Step::Found(_) => {}
            Step::Missed(report) => observer.missed(&report),
            Step::Finished(finish) => break finish,
        }
        if case.config.method != Method::Varsac && run.labels() != labels {
            labels.copy_from_slice(run.labels());
            observer.recorder.labels(&labels);
        }
    };
    let number = match finish {
        Finish::Targets => 0,
        Finish::Failures => 1,
        Finish::FewPoints => 2,
    };
    recorder.labels(run.labels());
    recorder.integers(Stage::Labels, "finish", [number]);
}

/// The stage in which a trial ends when it is rejected (in the default search, where that is another), and the name of
/// the record.
pub(crate) fn rejection(reason: usize, method: Method) -> (Stage, &'static str) {
    match (reason, method) {
        (0, _) => (Stage::Draws, "rejected: too few points"),
        (1, Method::Map) => (Stage::Hypothesis, "rejected: degenerate"),
        (1, _) => (Stage::Solution, "rejected: degenerate"),
        (2, _) => (Stage::Invariants, "rejected: no real ellipsoid"),
        (3, _) => (Stage::Size, "rejected: size"),
        (_, Method::Map) => (Stage::Support, "rejected: support"),
        (_, _) => (Stage::Score, "rejected: support"),
    }
}

/// Records what the core shows to its observers.
pub(crate) struct CoreObserver<'a> {
    pub(crate) recorder: &'a mut Recorder,
    /// Limits of the semi-axes, for the size check of every hypothesis.
    pub(crate) limits: [f32; 2],
    /// The search that is observed.
    pub(crate) method: Method,
}

impl CoreObserver<'_> {
    fn missed(&mut self, report: &VarsacReport) {
        let stage = match self.method {
            Method::Varsac => Stage::Detection,
            Method::Map => Stage::Verdict,
            Method::Mixture => Stage::Body,
        };
        self.recorder.integers(stage, "missed", core_report(report));
    }

    fn ellipsoid(&mut self, e: &Ellipsoid) {
        let [a, b, c] = &e.axes;
        self.recorder.floats(
            Stage::Ellipsoid,
            "ellipsoid",
            &[e.centre.coords.as_slice(), &e.semi_axes, a, b, c],
        );
        self.recorder.floats(Stage::Attitude, "attitude", &[&e.quaternion_xyzw(), &e.attitude_rad()]);
    }

    /// The detection of the default search, in the order in which it comes about.
    fn judged(&mut self, detection: &Detection, f: &Findings) {
        self.ellipsoid(&detection.ellipsoid);
        let numbers = [
            f.size_conflict,
            f.end_on,
            f.size_sigma,
            f.rival,
            f.outline,
            f.visible,
            f.colour,
            f.flat,
            f.separation,
            f.clutter,
        ];
        let counts = [f.explained, f.through, f.outline_rays].map(f32::from);
        self.recorder.floats(Stage::Findings, "findings", &[&numbers, &counts]);
        let entries = detection.covariance.as_ref().map_or(&[][..], |covariance| covariance.packed());
        self.recorder.floats(Stage::Covariance, "covariance and sigma", &[entries, &[f.sigma_mm]]);
        if let Status::Refused(refusal) = &detection.status {
            let values = [refusal.value, refusal.limit];
            self.recorder.floats(Stage::Verdict, refusal.code.name(), &[&values]);
        }
        let Score { inliers, candidates } = detection.score;
        let numbers = [u32::from(detection.target), inliers, candidates];
        let numbers = numbers.into_iter().chain(core_report(&detection.report));
        self.recorder.integers(Stage::Verdict, "detection", numbers);
    }

    /// What a search without a size prior found: it shows no more to an observer.
    fn body(&mut self, detection: &Detection) {
        self.ellipsoid(&detection.ellipsoid);
        if let Status::Refused(refusal) = &detection.status {
            let values = [refusal.value, refusal.limit];
            self.recorder.floats(Stage::Findings, refusal.code.name(), &[&values]);
        }
        let entries = detection.covariance.as_ref().map_or(&[][..], |covariance| covariance.packed());
        self.recorder.floats(Stage::Covariance, "covariance", &[entries]);
        let Score { inliers, candidates } = detection.score;
        let numbers = [u32::from(detection.target), inliers, candidates];
        let findings = u32::from(detection.findings.is_some());
        let numbers = numbers.into_iter().chain([findings]).chain(core_report(&detection.report));
        self.recorder.integers(Stage::Body, "body", numbers);
    }

    /// Everything that follows from a shape: eigenpairs, semi-axes, axes, attitude.
    pub(crate) fn shape(&mut self, surface: &CentralQuadric) {
        let eigen = jacobi::eigen(&surface.shape);
        let [a, b, c] = &eigen.vectors;
        self.recorder.floats(Stage::Eigenpairs, "eigenpairs", &[&eigen.values, a, b, c]);
        self.ellipsoid(&Ellipsoid::from(surface));
    }
}

impl Observer for CoreObserver<'_> {
    fn seed_point(&mut self, index: u16) {
        self.recorder.integers(Stage::Draws, "seed point", [u32::from(index)]);
    }

    fn neighbourhood(&mut self, members: &[u16]) {
        self.recorder.integers(Stage::Neighbourhood, "members", members.iter().map(|&m| u32::from(m)));
    }

    fn sample(&mut self, members: &[u16]) {
        self.recorder.integers(Stage::Draws, "sample", members.iter().map(|&m| u32::from(m)));
    }

    fn normal_equations(&mut self, matrix: &Symmetric9, rhs: &[f32; 9]) {
        self.recorder.floats(Stage::NormalMatrix, "normal equations", &[&matrix.0, rhs]);
    }

    fn solution(&mut self, x: &[f32; 9]) {
        self.recorder.floats(Stage::Solution, "solution", &[x]);
    }

    fn quadric(&mut self, q: &Quadric) {
        let numbers = [q.a11, q.a22, q.a33, q.a12, q.a13, q.a23, q.a14, q.a24, q.a34, q.a44];
        self.recorder.floats(Stage::Quadric, "quadric", &[&numbers]);
        let i = q.invariants();
        self.recorder.floats(Stage::Invariants, "invariants", &[&[i.i1, i.i2, i.i3, i.i4]]);
    }

    fn hypothesis(&mut self, surface: &CentralQuadric) {
        let (centre, shape) = (&surface.centre, shape_numbers(&surface.shape));
        self.recorder.floats(Stage::Hypothesis, "surface", &[centre.coords.as_slice(), &shape]);
        self.shape(surface);
        let accepted = surface.semi_axes_within(self.limits[0], self.limits[1]);
        self.recorder.integers(Stage::Size, "size accepted", [u32::from(accepted)]);
    }

    fn rejected(&mut self, reason: Rejection) {
        let (stage, name) = rejection(reason as usize, self.method);
        self.recorder.integers(stage, name, []);
    }

    fn score(&mut self, score: Score) {
        self.recorder.integers(Stage::Score, "score", [score.inliers, score.candidates]);
    }

    fn bound(&mut self, trials: u32) {
        self.recorder.integers(Stage::Bound, "bound", [trials]);
    }

    fn refit(&mut self, surface: &CentralQuadric) {
        let (centre, shape) = (&surface.centre, shape_numbers(&surface.shape));
        self.recorder.floats(Stage::Refit, "surface", &[centre.coords.as_slice(), &shape]);
    }

    fn estimate(&mut self, phase: Phase, estimate: &Estimate) {
        let stage = match phase {
            Phase::Hypothesis => Stage::Hypothesis,
            Phase::Refined => Stage::Refined,
            Phase::Final => Stage::Final,
            Phase::Joint => Stage::Joint,
            Phase::Free => Stage::Free,
        };
        let Estimate { centre, axes, ln_axes, boxiness } = estimate;
        self.recorder.floats(stage, "estimate", &[centre, axes.as_flattened(), ln_axes, &[*boxiness]]);
    }

    fn support(&mut self, support: &Support) {
        let counts = [support.explained, support.through].map(f32::from);
        self.recorder.floats(Stage::Support, "score, explained, through", &[&[support.score], &counts]);
    }

    fn noise(&mut self, noise: &Noise) {
        self.recorder.floats(Stage::Noise, "noise", &[&[noise.axial_mm, noise.lateral_rad]]);
    }

    fn detection(&mut self, detection: &Detection) {
        if let Some(findings) = &detection.findings {
            self.judged(detection, findings);
            return;
        }
        let Score { inliers, candidates } = detection.score;
        let numbers = [u32::from(detection.target), inliers, candidates];
        self.recorder.integers(
            Stage::Detection,
            "detection",
            numbers.into_iter().chain(core_report(&detection.report)),
        );
        self.ellipsoid(&detection.ellipsoid);
    }
}

fn shape_numbers(s: &Symmetric3) -> [f32; 6] {
    [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz]
}

fn core_report(report: &VarsacReport) -> [u32; 10] {
    let [too_few_points, degenerate, not_ellipsoid, size, support] = report.rejections;
    [
        report.trials,
        too_few_points,
        degenerate,
        not_ellipsoid,
        size,
        support,
        report.scored,
        report.bound,
        report.support.inliers,
        report.support.candidates,
    ]
}
