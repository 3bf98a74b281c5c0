//! The reference made to write down its results, through its events, in the shape of the core's.

use super::cases::Case;
use super::core_side::REJECTIONS;
use super::record::{Recorder, Stage};
use varsac_core::{CentralQuadric, Config, Constraint, Point3};
use varsac_reference as reference;
use varsac_reference::Event;

/// Runs the reference over the same case.
pub(crate) fn run(case: &Case, recorder: &mut Recorder) {
    let limits = [case.config.semi_axis_min, case.config.semi_axis_max];
    let cloud = points(&case.cloud);
    recorder.integers(Stage::Cloud, "accepted", [u32::from(reference::check_cloud(&cloud).is_ok())]);
    let mut observe = |event| record_event(recorder, limits, &event);
    let Ok(run) = reference::trace(&cloud, &config(&case.config), case.seed, &mut observe) else { return };
    let number = match run.finish {
        reference::Finish::Targets => 0,
        reference::Finish::Failures => 1,
        reference::Finish::Points => 2,
    };
    recorder.integers(Stage::Labels, "labels", run.labels.iter().map(|&label| u32::from(label)));
    recorder.integers(Stage::Labels, "finish", [number]);
}

/// The cloud as the reference has it.
pub(crate) fn points(cloud: &[Point3]) -> Vec<reference::Point> {
    cloud.iter().map(|p| [p.x, p.y, p.z]).collect()
}

/// A configuration of the core under the names of the contract, for the reference.
pub fn config(config: &Config) -> reference::Config {
    reference::Config {
        confidence: config.confidence,
        sizes: config.sample_sizes.to_vec(),
        shell: config.shell,
        radius: config.radius,
        semi_axis_min: config.semi_axis_min,
        semi_axis_max: config.semi_axis_max,
        max_trials: config.max_trials,
        refits: u32::from(config.refits),
        min_inliers: u32::from(config.min_inliers),
        min_ratio: config.min_ratio,
        max_targets: config.max_targets,
        max_failures: u32::from(config.max_failures),
        constraint: constraint(config.constraint),
    }
}

/// The constraint of the same name.
pub(crate) fn constraint(constraint: Constraint) -> reference::Constraint {
    match constraint {
        Constraint::A11 => reference::Constraint::A11,
        Constraint::Trace => reference::Constraint::Trace,
    }
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
        Event::Rejected(rejection) => {
            let (stage, name) = REJECTIONS[match rejection {
                reference::Rejection::TooFewPoints => 0,
                reference::Rejection::Degenerate => 1,
                reference::Rejection::NotEllipsoid => 2,
                reference::Rejection::Size => 3,
                reference::Rejection::Support => 4,
            }];
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
            ellipsoid(recorder, &detection.ellipsoid);
            let reference::Score { inliers, candidates } = detection.score;
            let numbers = [u32::from(detection.target), inliers, candidates];
            recorder.integers(
                Stage::Detection,
                "detection",
                numbers.into_iter().chain(report(&detection.report)),
            );
        }
        Event::Missed(found) => recorder.integers(Stage::Detection, "missed", report(found)),
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

/// The surface as the reference has it.
pub(crate) fn central(surface: &CentralQuadric) -> reference::Central {
    let (c, s) = (&surface.centre, &surface.shape);
    reference::Central {
        centre: [c.x, c.y, c.z],
        shape: reference::Symmetric { xx: s.xx, yy: s.yy, zz: s.zz, xy: s.xy, xz: s.xz, yz: s.yz },
    }
}
