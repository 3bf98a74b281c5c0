//! Vectors of the search without a size prior: a dozen clouds and what it finds in them.

use crate::format::{Case, check_file};
use varsac_core::{Config, Detection, Detector, Finds, Finish, OutlineRay, Point3, Scratch, Status, Step};
use varsac_host::check::{reference_mixture_config, reference_view};
use varsac_host::region_view::RegionView;
use varsac_host::synth::onesided::families::{CLEAN, HARD, OCCLUDED, ORCHARD, TOUCHING};
use varsac_host::synth::onesided::{Family, MaskBias, Scene, Sighting};
use varsac_reference as reference;

/// A cloud with the seed of its run; the preset unknown searches it, or the preset surface.
struct Task {
    view: RegionView,
    seed: u64,
    whole: bool,
}

/// What a run comes to, in numbers.
#[derive(Default)]
struct Found {
    ellipsoids: Vec<f32>,
    /// 45 for each body that has one.
    covariances: Vec<f32>,
    /// Code, value, limit; zeros if it is accepted.
    verdicts: Vec<f32>,
    /// Points claimed, points live before, support, for each body.
    scores: Vec<u32>,
    labels: Vec<u32>,
    finish: u32,
}

/// The codes of refusal in the order of X10, from 1.
const CODES: [&str; 6] = ["few_points", "flat", "clutter", "coverage", "shape", "vague"];

fn code_number(name: &str) -> f32 {
    let position = CODES.iter().position(|code| *code == name).expect("a code of X10");
    position as f32 + 1.0
}

impl Task {
    fn config(&self) -> Config {
        if self.whole { Config::surface() } else { Config::unknown() }
    }

    fn case(&self) -> Case {
        let view = &self.view;
        let points: Vec<[f32; 3]> = view.points.iter().map(|p| [p.x, p.y, p.z]).collect();
        let ray = |ray: &OutlineRay| [ray.inner.x, ray.inner.y, ray.inner.z, ray.outer_mm, ray.sigma_rad];
        let rays: Vec<[f32; 5]> = view.outline.iter().map(ray).collect();
        Case::default()
            .integers("whole", [u32::from(self.whole)])
            .integers("seed", [self.seed as u32])
            .floats("points", points.as_flattened())
            .integers("in_mask", [view.in_mask as u32])
            .floats("outline", rays.as_flattened())
    }

    fn read(case: &Case) -> Self {
        let point = |p: &[f32]| Point3::new(p[0], p[1], p[2]);
        let ray = |r: &[f32]| OutlineRay { inner: point(r), outer_mm: r[3], sigma_rad: r[4] };
        let view = RegionView {
            points: case.numbers("points").chunks(3).map(point).collect(),
            in_mask: case.word("in_mask") as usize,
            outline: case.numbers("outline").chunks(5).map(ray).collect(),
            pitch_rad: 0.0,
        };
        Self { view, seed: u64::from(case.word("seed")), whole: case.word("whole") == 1 }
    }

    fn of_the_reference(&self) -> Found {
        let config = reference_mixture_config(&self.config());
        let run = reference::run_mixture(&reference_view(&self.view), &config, self.seed);
        let run = run.expect("a valid view");
        let mut found = Found {
            labels: run.labels.iter().map(|&label| u32::from(label)).collect(),
            finish: match run.finish {
                reference::Finish::Targets => 0,
                reference::Finish::Failures => 1,
                reference::Finish::Points => 2,
            },
            ..Found::default()
        };
        for body in &run.detections {
            let e = &body.ellipsoid;
            found.ellipsoids.extend([&e.centre[..], &e.semi_axes, e.axes.as_flattened()].concat());
            found.covariances.extend(body.covariance.iter().flatten());
            found.verdicts.extend(body.refusal.map_or([0.0; 3], |refusal| {
                [code_number(reference_name(refusal.code)), refusal.value, refusal.limit]
            }));
            found.scores.extend([body.score.inliers, body.score.candidates, body.report.support.inliers]);
        }
        found
    }

    fn of_the_core(&self) -> Found {
        let n = self.view.points.len();
        let (mut order, mut members, mut labels) = (vec![0; n], vec![0; n], vec![0; n]);
        let mut finds = Finds::new();
        let scratch = Scratch::new(&mut order, &mut members, &mut labels, &mut finds);
        let detector = Detector::new(self.config()).expect("a preset");
        let view = self.view.view();
        let mut run = detector.detect_view(&view, scratch, self.seed).expect("a valid view");
        let mut found = Found::default();
        let finish = loop {
            match run.step() {
                Step::Found(detection) => found.gain(&detection),
                Step::Finished(finish) => break finish,
                Step::Working | Step::Missed(_) => {}
            }
        };
        found.finish = match finish {
            Finish::Targets => 0,
            Finish::Failures => 1,
            Finish::FewPoints => 2,
        };
        found.labels = run.labels().iter().map(|&label| u32::from(label)).collect();
        found
    }
}

/// The name of a code in the core.
fn reference_name(code: reference::RefusalCode) -> &'static str {
    use reference::RefusalCode as Code;
    match code {
        Code::FewPoints => "few_points",
        Code::Flat => "flat",
        Code::Clutter => "clutter",
        Code::Coverage => "coverage",
        Code::Shape => "shape",
        Code::Vague => "vague",
        _ => panic!("not a code of X10: {code:?}"),
    }
}

impl Found {
    /// A body of the core.
    fn gain(&mut self, body: &Detection) {
        let e = &body.ellipsoid;
        let centre = [e.centre.x, e.centre.y, e.centre.z];
        self.ellipsoids.extend([&centre[..], &e.semi_axes, e.axes.as_flattened()].concat());
        self.covariances.extend(body.covariance.iter().flat_map(varsac_core::Covariance::packed));
        self.verdicts.extend(match &body.status {
            Status::Accepted => [0.0; 3],
            Status::Refused(refusal) => [code_number(refusal.code.name()), refusal.value, refusal.limit],
        });
        self.scores.extend([body.score.inliers, body.score.candidates, body.report.support.inliers]);
    }
}

/// Six rendered views about 1 m away; six scans from all around: one body, two, a flat one, one with a hole, nothing but
/// clutter, a plane.
fn tasks() -> Vec<Task> {
    let families = [CLEAN, CLEAN, HARD, OCCLUDED, ORCHARD, TOUCHING];
    let mut tasks = Vec::new();
    for (family, seed) in families.into_iter().zip(1..) {
        let scene = Scene::new(&Family { distance_mm: (950.0, 1100.0), ..family }, seed);
        let Sighting { cloud, in_mask, outline, .. } =
            scene.sighting(MaskBias { grow_px: 0, shift_px: [0, 0] });
        let view = RegionView { points: cloud, in_mask, outline, pitch_rad: 0.0 };
        tasks.push(Task { view, seed, whole: false });
    }
    let one = spiral([0.0; 3], [3.0, 2.0, 1.0], 120, 1.0);
    let two =
        [spiral([0.0; 3], [3.0, 2.0, 1.0], 100, 1.0), spiral([5.0, 3.0, 0.0], [2.0, 1.5, 1.5], 80, 1.0)];
    let flat = spiral([10.0, 0.0, 5.0], [3.0, 3.0, 0.4], 120, 1.0);
    let open = spiral([0.0; 3], [30.0, 20.0, 20.0], 120, 0.6);
    let clutter: Vec<Point3> = between_limits([10.0, 10.0, 10.0]);
    let plane = between_limits([10.0, 10.0, 0.1]);
    for (points, seed) in [one, two.concat(), flat, open, clutter, plane].into_iter().zip(7..) {
        tasks.push(Task { view: RegionView::of_cloud(points), seed, whole: true });
    }
    tasks
}

/// The first `part` of a spiral of `n` points from pole to pole, every other point 1 % off the surface.
fn spiral(centre: [f32; 3], semi_axes: [f32; 3], n: usize, part: f32) -> Vec<Point3> {
    let mut points = Vec::new();
    for k in 0..n {
        let z = 1.0 - 2.0 * part * (k as f32 + 0.5) / n as f32;
        let rim = libm::sqrtf(1.0 - z * z);
        let far = if k % 2 == 0 { 1.01 } else { 0.99 };
        let u = [rim * libm::cosf(2.4 * k as f32), rim * libm::sinf(2.4 * k as f32), z];
        let at = |axis: usize| centre[axis] + far * semi_axes[axis] * u[axis];
        points.push(Point3::new(at(0), at(1), at(2)));
    }
    points
}

/// A hundred points of a box.
fn between_limits(reach: [f32; 3]) -> Vec<Point3> {
    let mut stream = reference::Stream::seeded(13);
    let mut points = Vec::new();
    for _ in 0..100 {
        let [x, y, z] = reach.map(|reach| crate::between(&mut stream, -reach, reach));
        points.push(Point3::new(x, y, z));
    }
    points
}

#[test]
fn bodies() {
    let mut cases = Vec::new();
    for task in tasks() {
        let found = task.of_the_reference();
        cases.push(
            task.case()
                .floats("ellipsoids", &found.ellipsoids)
                .floats("covariances", &found.covariances)
                .floats("verdicts", &found.verdicts)
                .integers("scores", found.scores)
                .integers("labels", found.labels)
                .integers("finish", [found.finish]),
        );
    }
    let what = "Chapters X1 to X12, the preset surface where `whole` is 1, else the preset unknown: points, outline rays (inner point, \
                outer depth, sigma); of each body ellipsoid (centre, semi-axes, axes), covariance, code of refusal (0: accepted, 1 to 6: \
                in the order of X10) with value and limit, points claimed, points live before, support; labels at the end; finish \
                (0 targets, 1 failures, 2 points).";
    check_file("mixture", what, &cases, |case| {
        let found = Task::read(case).of_the_core();
        case.expect_floats("ellipsoids", &found.ellipsoids);
        case.expect_floats("covariances", &found.covariances);
        case.expect_floats("verdicts", &found.verdicts);
        case.expect_integers("scores", &found.scores);
        case.expect_integers("labels", &found.labels);
        case.expect_integers("finish", &[found.finish]);
    });
}
