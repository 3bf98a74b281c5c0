//! What the core on this machine finds in the same view, and whether the co-processor found the same bits.

use varsac_core::link::MAX_WIRE;
use varsac_core::link::Message;
use varsac_core::link::payload::{Ending, Target};
use varsac_core::{CloudError, Detector, Point3, Step, View, Workspace, point::MAX_POINTS};
use varsac_firmware_sim::{body, scene, view::Canvas};

use super::client::{Job, Outcome};
use crate::region_view::RegionView;

/// The first thing that differs.
#[derive(Debug, Clone, PartialEq)]
pub enum Difference {
    /// Number of targets: co-processor, host.
    Count(usize, usize),
    /// A target, as both see it: co-processor, host.
    Target(Box<(Target, Target)>),
    /// The ending, or the steps or trials of the search: co-processor, host.
    Course([String; 2]),
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Count(there, here) => write!(f, "the co-processor found {there} targets, the host {here}"),
            Self::Target(both) => write!(f, "co-processor: {:?}; host: {:?}", both.0, both.1),
            Self::Course([there, here]) => {
                write!(f, "the co-processor's search ended so: {there}; the host's: {here}")
            }
        }
    }
}

/// Does the job with the core on this machine and compares: targets bit by bit (status, covariance and findings too), and for a search that ended by its
/// own rule also the ending, the steps and the trials.
///
/// # Errors
/// When the core does not take the cloud; the co-processor should not have either.
pub fn compare(
    detector: &Detector,
    job: &Job<'_>,
    outcome: &Outcome,
) -> Result<Option<Difference>, CloudError> {
    let complete = matches!(outcome.report.ending, Ending::Complete(_));
    let (mut targets, mut steps, mut trials) = (Vec::new(), 0, 0);
    let mut workspace = Box::new(Workspace::<MAX_POINTS>::new());
    let mut run = detector.detect_view(&job.view, workspace.scratch(), job.seed)?;
    let finish = loop {
        if !complete && steps >= outcome.report.steps {
            break None;
        }
        steps += 1;
        match run.step() {
            Step::Working => {}
            Step::Found(detection) => {
                trials += detection.report.trials;
                targets.push(Target::from(&detection));
            }
            Step::Missed(report) => trials += report.trials,
            Step::Finished(finish) => break Some(finish),
        }
    };
    if targets.len() != outcome.targets.len() {
        return Ok(Some(Difference::Count(outcome.targets.len(), targets.len())));
    }
    for (here, there) in targets.into_iter().zip(&outcome.targets) {
        if bytes(&here) != bytes(there) {
            return Ok(Some(Difference::Target(Box::new((*there, here)))));
        }
    }
    let report = &outcome.report;
    let same = match (report.ending, finish) {
        (Ending::Complete(there), Some(here)) => {
            there == here && report.steps == steps && report.trials == trials
        }
        _ => true,
    };
    Ok((!same).then(|| {
        let there = format!("{:?} after {} steps and {} trials", report.ending, report.steps, report.trials);
        Difference::Course([there, format!("{finish:?} after {steps} steps and {trials} trials")])
    }))
}

/// The bits of a target are those of its frame: comparing floats would take 0 and -0 for the same.
fn bytes(target: &Target) -> Vec<u8> {
    let mut wire = vec![0; MAX_WIRE];
    let used = Message::Target(*target).encode(0, 1, &mut wire).unwrap_or(0);
    wire.truncate(used);
    wire
}

/// A cloud for demonstrations of the co-processor: scene `number` of the firmware package, with `points` points.
pub fn demo_cloud(number: u64, points: usize) -> RegionView {
    let mut cloud = vec![Point3::origin(); points];
    scene::scene(number, &mut cloud);
    RegionView::of_cloud(cloud)
}

/// The same of the surfaces seen from all around, for the search without a size prior.
pub fn demo_body(number: u64, points: usize) -> RegionView {
    let mut cloud = vec![Point3::origin(); points];
    body::scene(number, &mut cloud);
    RegionView::of_cloud(cloud)
}

/// View `number` of the firmware package: with mask and outline, for the default search.
pub fn demo_view(number: u64) -> RegionView {
    let mut canvas = Box::new(Canvas::new());
    let View { cloud, in_mask, outline, pitch_rad } = canvas.scene(number);
    RegionView { points: cloud.to_vec(), in_mask, outline: outline.to_vec(), pitch_rad }
}
