//! Runs of the default search, of core and reference, in one shape.

use crate::maps::Task;
use varsac_core::{
    Detection, Detector, Estimate, Finds, Noise, Observer, Scratch, Stage, Status, Step, Support,
};
use varsac_host::check::{reference_map_config, reference_view};
use varsac_reference as reference;
use varsac_reference::{Event, Phase};

/// Centre, axes, logarithms of the semi-axes, boxiness.
type Numbers = [f32; 16];

/// One result of a run.
#[derive(Debug, PartialEq)]
pub(crate) enum Entry {
    Hypothesis(Numbers),
    Refined(Numbers),
    Final(Numbers),
    Joint(Numbers),
    Free(Numbers),
    /// Score, explained, through.
    Support([f32; 3]),
    Noise([f32; 2]),
    Judged(Box<Judged>),
}

/// A fruit as it is reported, in numbers.
#[derive(Debug, PartialEq)]
pub(crate) struct Judged {
    pub(crate) ellipsoid: [f32; 15],
    pub(crate) findings: [f32; 14],
    /// 45, or none.
    pub(crate) covariance: Vec<f32>,
    /// Code, value, limit; zeros if it is accepted.
    pub(crate) refusal: [f32; 3],
}

/// A whole run.
pub(crate) struct Trace {
    pub(crate) entries: Vec<Entry>,
    pub(crate) labels: Vec<u8>,
}

/// Numbers one after the other, as many as there are.
fn joined<const N: usize>(parts: &[&[f32]]) -> [f32; N] {
    parts.concat().try_into().expect("as many numbers as parts have")
}

/// The run of the reference.
pub(crate) fn of_the_reference(task: &Task) -> Trace {
    let mut entries = Vec::new();
    let config = reference_map_config(&task.config());
    let run = reference::trace_map(&reference_view(&task.view), &config, task.seed, &mut |event| {
        entries.extend(entry(&event));
    });
    Trace { entries, labels: run.expect("a valid view").labels }
}

fn entry(event: &Event) -> Option<Entry> {
    Some(match event {
        Event::Estimate(phase, e) => {
            let numbers = joined(&[&e.centre, e.axes.as_flattened(), &e.x, &[e.boxiness]]);
            match phase {
                Phase::Hypothesis => Entry::Hypothesis(numbers),
                Phase::Refined => Entry::Refined(numbers),
                Phase::Final => Entry::Final(numbers),
                Phase::Joint => Entry::Joint(numbers),
                Phase::Free => Entry::Free(numbers),
            }
        }
        Event::Support(s) => Entry::Support([s.score, s.explained as f32, s.through as f32]),
        Event::Noise(noise) => Entry::Noise([noise.axial, noise.lateral]),
        Event::MapDetection(found) => {
            let (e, f) = (&found.ellipsoid, &found.findings);
            let refusal = found.refusal.map_or([0.0; 3], |r| [1.0 + r.code as u8 as f32, r.value, r.limit]);
            Entry::Judged(Box::new(Judged {
                ellipsoid: joined(&[&e.centre, &e.semi_axes, e.axes.as_flattened()]),
                findings: [
                    f.explained as f32,
                    f.through as f32,
                    f.conflict,
                    f.end_on,
                    f.size_sigma,
                    f.rival,
                    f.rays as f32,
                    f.outline,
                    f.visible,
                    f.colour,
                    f.sigma_mm,
                    f.flat,
                    f.separation,
                    f.clutter,
                ],
                covariance: found.covariance.map_or_else(Vec::new, |entries| entries.to_vec()),
                refusal,
            }))
        }
        _ => return None,
    })
}

/// The run of the core.
pub(crate) fn of_the_core(task: &Task) -> Trace {
    let n = task.view.points.len();
    let (mut order, mut members, mut labels) = (vec![0; n], vec![0; n], vec![0; n]);
    let mut finds = Finds::new();
    let detector = Detector::new(task.config()).expect("a preset");
    let scratch = Scratch::new(&mut order, &mut members, &mut labels, &mut finds);
    let view = task.view.view();
    let mut run = detector.detect_view(&view, scratch, task.seed).expect("a valid view");
    let mut entries = Entries(Vec::new());
    while !matches!(run.step_observed(&mut entries), Step::Finished(_)) {}
    Trace { entries: entries.0, labels: run.labels().to_vec() }
}

struct Entries(Vec<Entry>);

impl Observer for Entries {
    fn estimate(&mut self, stage: Stage, e: &Estimate) {
        let numbers = joined(&[&e.centre, e.axes.as_flattened(), &e.ln_axes, &[e.boxiness]]);
        self.0.push(match stage {
            Stage::Hypothesis => Entry::Hypothesis(numbers),
            Stage::Refined => Entry::Refined(numbers),
            Stage::Final => Entry::Final(numbers),
            Stage::Joint => Entry::Joint(numbers),
            Stage::Free => Entry::Free(numbers),
        });
    }

    fn support(&mut self, s: &Support) {
        self.0.push(Entry::Support([s.score, f32::from(s.explained), f32::from(s.through)]));
    }

    fn noise(&mut self, noise: &Noise) {
        self.0.push(Entry::Noise([noise.axial_mm, noise.lateral_rad]));
    }

    fn detection(&mut self, found: &Detection) {
        let (e, f) = (&found.ellipsoid, found.findings.expect("the default search has findings"));
        let refusal = match found.status {
            Status::Accepted => [0.0; 3],
            Status::Refused(refusal) => [1.0 + refusal.code as u8 as f32, refusal.value, refusal.limit],
        };
        self.0.push(Entry::Judged(Box::new(Judged {
            ellipsoid: joined(&[e.centre.coords.as_slice(), &e.semi_axes, e.axes.as_flattened()]),
            findings: [
                f32::from(f.explained),
                f32::from(f.through),
                f.size_conflict,
                f.end_on,
                f.size_sigma,
                f.rival,
                f32::from(f.outline_rays),
                f.outline,
                f.visible,
                f.colour,
                f.sigma_mm,
                f.flat,
                f.separation,
                f.clutter,
            ],
            covariance: found.covariance.as_ref().map_or_else(Vec::new, |c| c.packed().to_vec()),
            refusal,
        })));
    }
}
