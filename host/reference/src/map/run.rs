//! A run of the default search: contract, chapter M3.

use super::fruit::{Fruit, Standing, claimed, search};
use super::judge::{MapDetection, judged};
use super::neighbours::{joint_rounds, standings};
use super::view::{MapConfig, View, Viewpoint};
use crate::cloud::{CloudError, check_cloud};
use crate::{Event, Finish, Stream, live_points};

/// Everything a run found.
#[derive(Clone, Debug, PartialEq)]
pub struct MapRun {
    /// The fruit in the order found, accepted and refused.
    pub detections: Vec<MapDetection>,
    /// For each point of the cloud the target that has it, 0 for none.
    pub labels: Vec<u8>,
    /// Why it ended.
    pub finish: Finish,
}

/// M3: all fruit of a view.
///
/// # Errors
/// A view that M2 does not allow.
pub fn run_map(view: &View, config: &MapConfig, seed: u64) -> Result<MapRun, CloudError> {
    trace_map(view, config, seed, &mut |_| {})
}

/// [`run_map`], with each intermediate result of every stage as an event (M22).
///
/// # Errors
/// A view that M2 does not allow.
pub fn trace_map(
    view: &View,
    config: &MapConfig,
    seed: u64,
    observe: &mut dyn FnMut(Event),
) -> Result<MapRun, CloudError> {
    check_view(view)?;
    let view = &as_seen(view, config.viewpoint);
    let mut stream = Stream::seeded(seed);
    let mut labels = vec![0; view.points.len()];
    let (mut fruit, finish) = all_fruit(view, &mut labels, config, &mut stream, observe);

    standings(&mut fruit, &mut labels);
    observe(Event::Labels(labels.clone()));
    joint_rounds(view, &mut labels, &mut fruit, config, observe);

    let mut detections = Vec::new();
    for index in 0..fruit.len() {
        let detection = judged(view, &labels, &fruit, index, config, observe);
        if detection.refusal.is_none() {
            fruit[index].standing = Standing::Accepted;
        }
        observe(Event::MapDetection(Box::new(detection)));
        detections.push(detection);
    }
    Ok(MapRun { detections, labels, finish })
}

/// M2: the points as in chapter 2, and at most 4096 rays.
///
/// # Errors
/// The first thing that is wrong.
pub fn check_view(view: &View) -> Result<(), CloudError> {
    check_cloud(&view.points)?;
    if view.outline.len() > 4096 {
        return Err(CloudError::TooManyRays(view.outline.len()));
    }
    Ok(())
}

/// M2: what counts of a view.
pub(crate) fn as_seen(view: &View, viewpoint: Viewpoint) -> View {
    let mut seen = view.clone();
    if seen.in_mask > seen.points.len() {
        seen.in_mask = seen.points.len();
    }
    if viewpoint == Viewpoint::None {
        seen.outline.clear();
        seen.pitch = 0.0;
    }
    seen
}

/// M3.1: search after search.
fn all_fruit(
    view: &View,
    labels: &mut [u8],
    config: &MapConfig,
    stream: &mut Stream,
    observe: &mut dyn FnMut(Event),
) -> (Vec<Fruit>, Finish) {
    let mut fruit: Vec<Fruit> = Vec::new();
    let mut failures = 0;
    loop {
        if let Some(finish) = ended(view, labels, config, fruit.len(), failures) {
            return (fruit, finish);
        }
        let label = fruit.len() as u8 + 1;
        let found = match search(view, labels, label, config, stream, observe) {
            Ok(found) => found,
            Err(report) => {
                failures += 1;
                observe(Event::Missed(report));
                continue;
            }
        };
        let points = claimed(view, labels, &found, config);
        if points.is_empty() {
            failures += 1;
            observe(Event::Missed(found.report));
            continue;
        }
        for index in points {
            labels[index as usize] = label;
        }
        observe(Event::Labels(labels.to_vec()));
        fruit.push(found);
    }
}

/// M3.1: the three tests in their order.
fn ended(view: &View, labels: &[u8], config: &MapConfig, targets: usize, failures: u32) -> Option<Finish> {
    if targets == config.max_targets as usize || targets == 32 {
        return Some(Finish::Targets);
    }
    if failures >= config.max_failures {
        return Some(Finish::Failures);
    }
    (live_points(&labels[..view.in_mask]).len() < 8).then_some(Finish::Points)
}

#[cfg(test)]
#[path = "run_tests.rs"]
mod tests;
