//! A run of the search without a size prior: contract, chapters X11 and X12.

use super::candidates::{best, final_fit};
use super::config::MixtureConfig;
use super::findings::{Body, judged};
use super::frame::{Frame, sample};
use super::look::{Distance, contact};
use super::starts::{Sample, kept};
use crate::cloud::CloudError;
use crate::ellipsoid::{angles, quaternion};
use crate::fault::{self, Fault};
use crate::map::accept::{Refusal, RefusalCode};
use crate::map::algebra::Vector;
use crate::map::model::Model;
use crate::map::run::{as_seen, check_view};
use crate::map::view::{Noise, View, Viewpoint};
use crate::{Ellipsoid, Event, Finish, Report, Score, Stream, live_points};

/// A body as it is reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixtureDetection {
    /// The label of its points.
    pub target: u8,
    /// Its ellipsoid, sorted.
    pub ellipsoid: Ellipsoid,
    /// Points claimed among all that were live before.
    pub score: Score,
    /// The search that found it.
    pub report: Report,
    /// Why it is refused, if it is.
    pub refusal: Option<Refusal>,
    /// Lower triangle by rows.
    pub covariance: Option<[f32; 45]>,
}

/// Everything a run found.
#[derive(Clone, Debug, PartialEq)]
pub struct MixtureRun {
    /// The bodies in the order found, accepted and refused.
    pub detections: Vec<MixtureDetection>,
    /// For each point of the cloud the target that has it, 0 for none.
    pub labels: Vec<u8>,
    /// Why it ended.
    pub finish: Finish,
}

/// X12: all bodies of a view.
///
/// # Errors
/// A view that M2 does not allow.
pub fn run_mixture(view: &View, config: &MixtureConfig, seed: u64) -> Result<MixtureRun, CloudError> {
    trace_mixture(view, config, seed, &mut |_| {})
}

/// [`run_mixture`], with the end of each search as events: `Missed`, or `MixtureDetection` and `Labels`.
///
/// # Errors
/// A view that M2 does not allow.
pub fn trace_mixture(
    view: &View,
    config: &MixtureConfig,
    seed: u64,
    observe: &mut dyn FnMut(Event),
) -> Result<MixtureRun, CloudError> {
    check_view(view)?;
    let view = &as_seen(view, config.viewpoint);
    let mut stream = Stream::seeded(seed);
    let mut labels = vec![0; view.points.len()];
    let mut detections = Vec::new();
    let mut failures = 0;
    loop {
        let live = live_points(&labels);
        if let Some(finish) = ended(config, detections.len(), failures, live.len()) {
            return Ok(MixtureRun { detections, labels, finish });
        }
        let mut report = Report {
            trials: 1 + u32::from(config.starts),
            bound: 1 + u32::from(config.starts),
            support: Score { inliers: 0, candidates: live.len() as u32 },
            ..Report::default()
        };
        let Some(body) = search(view, &live, config, &mut stream) else {
            failures += 1;
            observe(Event::Missed(report));
            continue;
        };
        report.support.inliers = body.members as u32;
        let nothing = body
            .refusal
            .is_some_and(|refusal| matches!(refusal.code, RefusalCode::FewPoints | RefusalCode::Clutter));
        let claimed =
            if nothing && !detections.is_empty() { Vec::new() } else { claimed(view, &live, &body, config) };
        if claimed.is_empty() {
            failures += 1;
            observe(Event::Missed(report));
            continue;
        }
        let target = detections.len() as u8 + 1;
        for &index in &claimed {
            labels[index as usize] = target;
        }
        failures += u32::from(nothing);
        let detection = MixtureDetection {
            target,
            ellipsoid: body.ellipsoid,
            score: Score { inliers: claimed.len() as u32, candidates: live.len() as u32 },
            report,
            refusal: body.refusal,
            covariance: body.covariance,
        };
        observe(Event::MixtureDetection(Box::new(detection)));
        observe(Event::Labels(labels.clone()));
        detections.push(detection);
    }
}

/// X12: the three tests in their order.
fn ended(config: &MixtureConfig, targets: usize, failures: u32, live: usize) -> Option<Finish> {
    if targets >= usize::from(config.max_targets) {
        return Some(Finish::Targets);
    }
    if failures >= config.max_failures {
        return Some(Finish::Failures);
    }
    (live < 12).then_some(Finish::Points)
}

/// X3 to X11: one search; its body is in the frame of the cloud.
fn search(view: &View, live: &[u16], config: &MixtureConfig, stream: &mut Stream) -> Option<Body> {
    let point = |index: u16| view.points[index as usize];
    let frame = Frame::of(&live.iter().map(|&index| point(index)).collect::<Vec<_>>(), config.viewpoint)?;
    let local = |list: &[u16]| list.iter().map(|&index| frame.local(point(index))).collect::<Vec<_>>();
    let points = local(live);
    let scene = frame.scene(&points, view, config);
    let drawn = sample(live, config.sample, stream);
    let in_mask: Vec<u16> = drawn.iter().copied().filter(|&index| (index as usize) < view.in_mask).collect();
    let sample = Sample { points: local(&drawn), seeds: local(&in_mask) };
    let best = best(&kept(&scene, &sample, config), &scene, &sample.points, config)?;
    let mut scene = scene;
    if scene.distance == Distance::Radial {
        scene.distance = Distance::Orthogonal;
    }
    let shell = final_fit(best, &scene, &points, config);
    Some(in_the_cloud(&judged(&shell, &scene, &points, config), &frame))
}

/// X11.
fn in_the_cloud(body: &Body, frame: &Frame) -> Body {
    Body {
        ellipsoid: scaled(&body.ellipsoid, frame.origin, frame.unit),
        sigma: body.sigma * frame.unit,
        covariance: body.covariance.map(|entries| scaled_covariance(&entries, frame.unit)),
        ..*body
    }
}

/// X11: the ellipsoid in the frame of the cloud.
pub(crate) fn scaled(local: &Ellipsoid, origin: Vector, unit: f32) -> Ellipsoid {
    let c = local.centre;
    Ellipsoid {
        centre: [origin[0] + c[0] * unit, origin[1] + c[1] * unit, origin[2] + c[2] * unit],
        semi_axes: local.semi_axes.map(|a| a * unit),
        axes: local.axes,
        quaternion: quaternion(&local.axes),
        angles: angles(&local.axes),
    }
}

/// X11: the covariance in the frame of the cloud.
pub(crate) fn scaled_covariance(entries: &[f32; 45], unit: f32) -> [f32; 45] {
    let f = |index: usize| if index < 6 { unit } else { 1.0 };
    let mut scaled = [0.0; 45];
    let mut next = 0;
    for i in 0..9 {
        for j in 0..=i {
            scaled[next] = (entries[next] * f(i)) * f(j);
            next += 1;
        }
    }
    scaled
}

/// X12: the live points that a body claims, ascending.
fn claimed(view: &View, live: &[u16], body: &Body, config: &MixtureConfig) -> Vec<u16> {
    let Noise { axial, lateral } = config.noise;
    let noise = Noise { axial: body.sigma, lateral: body.sigma * (lateral / axial) };
    let e = &body.ellipsoid;
    let model = Model::of(e.centre, &e.axes, e.semi_axes, noise, config.viewpoint);
    let distance = match config.viewpoint {
        Viewpoint::None => Distance::Orthogonal,
        Viewpoint::Origin => Distance::Ray { ratio: lateral / axial },
    };
    let h = 0.55 * e.semi_axes[2];
    let limit = if fault::is(Fault::Claimed) { 6.25 } else { 9.0 };
    let mut claimed = Vec::new();
    for &index in live {
        let contact = contact(&model, distance, view.points[index as usize]);
        if contact.f2() < limit && contact.within(h) {
            claimed.push(index);
        }
    }
    claimed
}

#[cfg(test)]
#[path = "run_tests.rs"]
mod tests;
