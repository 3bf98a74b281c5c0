//! The reference made to write down its results, through its events, in the shape of the core's.

use super::cases::Case;
use super::convert::{
    points, reference_config, reference_map_config, reference_mixture_config, reference_view,
};
use super::core_side::rejection;
use super::record::{Recorder, Stage};
use varsac_core::Method;
use varsac_reference as reference;
use varsac_reference::{Event, Phase, RefusalCode};

/// Runs the reference over the same case.
pub(crate) fn run(case: &Case, recorder: &mut Recorder) {
    match case.config.method {
        Method::Map => map(case, recorder),
        Method::Varsac => paper(case, recorder),
        Method::Mixture => mixture(case, recorder),
    }
}

/// The paper's search.
fn paper(case: &Case, recorder: &mut Recorder) {
    let limits = [case.config.semi_axis_min, case.config.semi_axis_max];
    let cloud = points(&case.view.points);
    recorder.integers(Stage::Cloud, "accepted", [u32::from(reference::check_cloud(&cloud).is_ok())]);
    let config = reference_config(&case.config);
    let mut observe = |event| record_event(recorder, limits, &event);
    let Ok(run) = reference::trace(&cloud, &config, case.seed, &mut observe) else { return };
    end(recorder, &run.labels, run.finish);
}

/// The default search.
fn map(case: &Case, recorder: &mut Recorder) {
    let view = reference_view(&case.view);
    let config = reference_map_config(&case.config);
    recorder.integers(Stage::Cloud, "accepted", [u32::from(reference::check_view(&view).is_ok())]);
    let mut labels = vec![0; view.points.len()];
    let mut observe = |event| record_map_event(recorder, &mut labels, &event);
    let Ok(run) = reference::trace_map(&view, &config, case.seed, &mut observe) else { return };
    end(recorder, &run.labels, run.finish);
}

/// The search without a size prior.
fn mixture(case: &Case, recorder: &mut Recorder) {
    let view = reference_view(&case.view);
    let config = reference_mixture_config(&case.config);
    recorder.integers(Stage::Cloud, "accepted", [u32::from(reference::check_view(&view).is_ok())]);
    let mut observe = |event| match event {
        Event::Missed(found) => recorder.integers(Stage::Body, "missed", report(&found)),
        Event::MixtureDetection(detection) => body(recorder, &detection),
        Event::Labels(labels) => recorder.labels(&labels),
        _ => unreachable!("no event of this search: {event:?}"),
    };
    let Ok(run) = reference::trace_mixture(&view, &config, case.seed, &mut observe) else { return };
    end(recorder, &run.labels, run.finish);
}

fn end(recorder: &mut Recorder, labels: &[u8], finish: reference::Finish) {
    let number = match finish {
        reference::Finish::Targets => 0,
        reference::Finish::Failures => 1,
        reference::Finish::Points => 2,
    };
    recorder.labels(labels);
    recorder.integers(Stage::Labels, "finish", [number]);
}

/// Records an event; `limits` are those of the semi-axes, for the size check of every hypothesis.
pub(crate) fn record_event(recorder: &mut Recorder, limits: [f32; 2], event: &Event) {
    match event {
        Event::SeedPoint(index) => recorder.integers(Stage::Draws, "seed point", [u32::from(*index)]),
        Event::Neighbourhood(members) => {
            recorder.integers(Stage::Neighbourhood, "members", members.iter().map(|&m| u32::from(m)));
        }
        Event::Sample(members) => {
            recorder.integers(Stage::Draws, "sample", members.iter().map(|&m| u32::from(m)));
        }
        Event::Normal { matrix, rhs } => {
            recorder.floats(Stage::NormalMatrix, "normal equations", &[matrix, rhs]);
        }
        Event::Solution(x) => recorder.floats(Stage::Solution, "solution", &[x]),
        Event::Quadric(numbers) => recorder.floats(Stage::Quadric, "quadric", &[numbers]),
        Event::Invariants(numbers) => recorder.floats(Stage::Invariants, "invariants", &[numbers]),
        Event::Hypothesis(surface) => {
            recorder.floats(Stage::Hypothesis, "surface", &[&surface.centre, &symmetric(&surface.shape)]);
            shape(recorder, surface);
            let accepted = reference::size_accepted(&surface.shape, limits[0], limits[1]);
            recorder.integers(Stage::Size, "size accepted", [u32::from(accepted)]);
        }
        Event::Rejected(reason) => {
            let (stage, name) = rejection(number_of(*reason), Method::Varsac);
            recorder.integers(stage, name, []);
        }
        Event::Score(score) => {
            recorder.integers(Stage::Score, "score", [score.inliers, score.candidates]);
        }
        Event::Bound(trials) => recorder.integers(Stage::Bound, "bound", [*trials]),
        Event::Refit(surface) => {
            recorder.floats(Stage::Refit, "surface", &[&surface.centre, &symmetric(&surface.shape)]);
        }
        Event::Detection(detection) => {
            let reference::Score { inliers, candidates } = detection.score;
            let numbers = [u32::from(detection.target), inliers, candidates];
            recorder.integers(
                Stage::Detection,
                "detection",
                numbers.into_iter().chain(report(&detection.report)),
            );
            ellipsoid(recorder, &detection.ellipsoid);
        }
        Event::Missed(found) => recorder.integers(Stage::Detection, "missed", report(found)),
        Event::Estimate(..)
        | Event::Support(_)
        | Event::Noise(_)
        | Event::Labels(_)
        | Event::MapDetection(_)
        | Event::MixtureDetection(_) => unreachable!("an event of another search: {event:?}"),
    }
}

/// The number of a rejection in the reports of the core.
pub(crate) fn number_of(reason: reference::Rejection) -> usize {
    match reason {
        reference::Rejection::TooFewPoints => 0,
        reference::Rejection::Degenerate => 1,
        reference::Rejection::NotEllipsoid => 2,
        reference::Rejection::Size => 3,
        reference::Rejection::Support => 4,
    }
}

/// Records an event of the default search; `labels` are those recorded last.
fn record_map_event(recorder: &mut Recorder, labels: &mut Vec<u8>, event: &Event) {
    match event {
        Event::Rejected(reason) => {
            let (stage, name) = rejection(number_of(*reason), Method::Map);
            recorder.integers(stage, name, []);
        }
        Event::Missed(found) => recorder.integers(Stage::Verdict, "missed", report(found)),
        Event::Estimate(phase, estimate) => {
            let stage = match phase {
                Phase::Hypothesis => Stage::Hypothesis,
                Phase::Refined => Stage::Refined,
                Phase::Final => Stage::Final,
                Phase::Joint => Stage::Joint,
                Phase::Free => Stage::Free,
            };
            let reference::Estimate { centre, axes, x, boxiness } = estimate;
            recorder.floats(stage, "estimate", &[centre, axes.as_flattened(), x, &[*boxiness]]);
        }
        Event::Support(support) => {
            let counts = [support.explained, support.through].map(|count| count as f32);
            recorder.floats(Stage::Support, "score, explained, through", &[&[support.score], &counts]);
        }
        Event::Noise(noise) => {
            recorder.floats(Stage::Noise, "noise", &[&[noise.axial, noise.lateral]]);
        }
        Event::Labels(new) if new == labels => {}
        Event::Labels(new) => {
            labels.clone_from(new);
            recorder.labels(labels);
        }
        Event::MapDetection(detection) => judged(recorder, detection),
        // The draws are those of the paper's search.
        _ => record_event(recorder, [0.0; 2], event),
    }
}

/// The detection of the default search, in the order in which it comes about.
fn judged(recorder: &mut Recorder, detection: &reference::MapDetection) {
    ellipsoid(recorder, &detection.ellipsoid);
    let f = &detection.findings;
    let numbers = [
        f.conflict,
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
    let counts = [f.explained, f.through, f.rays].map(|count| count as f32);
    recorder.floats(Stage::Findings, "findings", &[&numbers, &counts]);
    let entries = detection.covariance.as_ref().map_or(&[][..], |covariance| covariance);
    recorder.floats(Stage::Covariance, "covariance and sigma", &[entries, &[f.sigma_mm]]);
    if let Some(refusal) = &detection.refusal {
        recorder.floats(Stage::Verdict, code_name(refusal.code), &[&[refusal.value, refusal.limit]]);
    }
    let reference::Score { inliers, candidates } = detection.score;
    let numbers = [u32::from(detection.target), inliers, candidates];
    recorder.integers(Stage::Verdict, "detection", numbers.into_iter().chain(report(&detection.report)));
}

/// What a search without a size prior found.
fn body(recorder: &mut Recorder, detection: &reference::MixtureDetection) {
    ellipsoid(recorder, &detection.ellipsoid);
    if let Some(refusal) = &detection.refusal {
        recorder.floats(Stage::Findings, code_name(refusal.code), &[&[refusal.value, refusal.limit]]);
    }
    let entries = detection.covariance.as_ref().map_or(&[][..], |covariance| covariance);
    recorder.floats(Stage::Covariance, "covariance", &[entries]);
    let reference::Score { inliers, candidates } = detection.score;
    // There are no findings.
    let numbers = [u32::from(detection.target), inliers, candidates, 0];
    recorder.integers(Stage::Body, "body", numbers.into_iter().chain(report(&detection.report)));
}

/// The name of a code in the core.
fn code_name(code: RefusalCode) -> &'static str {
    match code {
        RefusalCode::FewPoints => "few_points",
        RefusalCode::SizeConflict => "size_conflict",
        RefusalCode::SizeUnknown => "size_unknown",
        RefusalCode::Ambiguous => "ambiguous",
        RefusalCode::Outline => "outline",
        RefusalCode::Visible => "visible",
        RefusalCode::Colour => "colour",
        RefusalCode::Uncertain => "uncertain",
        RefusalCode::Flat => "flat",
        RefusalCode::Through => "through",
        RefusalCode::SharedVolume => "shared_volume",
        RefusalCode::Singular => "singular",
        RefusalCode::Clutter => "clutter",
        RefusalCode::Coverage => "coverage",
        RefusalCode::Shape => "shape",
        RefusalCode::Vague => "vague",
    }
}

/// Everything that follows from a shape: eigenpairs, semi-axes, axes, attitude.
pub(crate) fn shape(recorder: &mut Recorder, surface: &reference::Central) {
    let eigen = reference::ascending(&reference::eigen(&surface.shape));
    let [a, b, c] = &eigen.vectors;
    recorder.floats(Stage::Eigenpairs, "eigenpairs", &[&eigen.values, a, b, c]);
    ellipsoid(recorder, &reference::ellipsoid_of(surface));
}

fn ellipsoid(recorder: &mut Recorder, e: &reference::Ellipsoid) {
    let [a, b, c] = &e.axes;
    recorder.floats(Stage::Ellipsoid, "ellipsoid", &[&e.centre, &e.semi_axes, a, b, c]);
    recorder.floats(Stage::Attitude, "attitude", &[&e.quaternion, &e.angles]);
}

fn symmetric(s: &reference::Symmetric) -> [f32; 6] {
    [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz]
}

fn report(found: &reference::Report) -> [u32; 10] {
    let r = &found.rejections;
    [
        found.trials,
        r.too_few_points,
        r.degenerate,
        r.not_ellipsoid,
        r.size,
        r.support,
        found.scored,
        found.bound,
        found.support.inliers,
        found.support.candidates,
    ]
}
