//! Fruit after fruit until the cloud is exhausted: contract, chapter 10; Steps 2 to 5 of the paper.

use crate::cloud::{CloudError, check_cloud};
use crate::fault::{self, Fault};
use crate::{Central, Config, Ellipsoid, Event, Point, Report, Score, Stream};
use crate::{ellipsoid_of, fit_observed, live_points, search_target, shell_contains, size_accepted};

/// One target as it is reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Its number and the label of its points; the first is 1.
    pub target: u8,
    /// The final surface.
    pub surface: Central,
    /// How it lies.
    pub ellipsoid: Ellipsoid,
    /// Its points among all that were live before.
    pub score: Score,
    /// The search that found it.
    pub report: Report,
}

/// Which test of chapter 10.1 ended a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finish {
    /// As many targets as were asked for.
    Targets,
    /// As many failed searches as are allowed.
    Failures,
    /// Fewer live points than the smallest sample or the last target has.
    Points,
}

/// Everything a run found.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The targets in the order found.
    pub detections: Vec<Detection>,
    /// For each point of the cloud the target that claimed it, 0 for none.
    pub labels: Vec<u8>,
    /// Why it ended.
    pub finish: Finish,
}

/// Chapter 10: all targets of a cloud.
///
/// # Errors
/// A cloud that chapter 2 does not allow.
pub fn run(cloud: &[Point], config: &Config, seed: u64) -> Result<Run, CloudError> {
    trace(cloud, config, seed, &mut |_| {})
}

/// [`run`], with each intermediate result of every stage as an event.
///
/// # Errors
/// A cloud that chapter 2 does not allow.
pub fn trace(
    cloud: &[Point],
    config: &Config,
    seed: u64,
    observe: &mut dyn FnMut(Event),
) -> Result<Run, CloudError> {
    check_cloud(cloud)?;
    let mut stream = Stream::seeded(seed);
    let mut labels = vec![0; cloud.len()];
    let mut detections: Vec<Detection> = Vec::new();
    let mut failures = 0;
    let mut last_inliers = 0;
    let finish = loop {
        let live = live_points(&labels).len();
        if let Some(finish) = ended(config, detections.len(), failures, live, last_inliers) {
            break finish;
        }
        let (best, report) = search_target(cloud, &labels, config, &mut stream, observe);
        let Some(best) = best else {
            failures += 1;
            observe(Event::Missed(report));
            continue;
        };
        let surface = refitted(cloud, &labels, config, best, observe);
        let claimed = live_inside(cloud, &labels, config.shell, &surface);
        let tie = fault::is(Fault::Detection) && claimed.len() as u32 == config.min_inliers;
        if (claimed.len() as u32) < config.min_inliers || tie {
            failures += 1;
            observe(Event::Missed(report));
            continue;
        }
        let target = detections.len() as u8 + 1;
        label(cloud, config.shell, &surface, &claimed, target, &mut labels);
        let score = Score { inliers: claimed.len() as u32, candidates: live as u32 };
        last_inliers = claimed.len();
        let detection = Detection { target, surface, ellipsoid: ellipsoid_of(&surface), score, report };
        observe(Event::Detection(detection));
        detections.push(detection);
    };
    Ok(Run { detections, labels, finish })
}

/// Chapter 10.1: the three tests in their order.
fn ended(config: &Config, targets: usize, failures: u32, live: usize, last_inliers: usize) -> Option<Finish> {
    if targets >= config.max_targets as usize {
        return Some(Finish::Targets);
    }
    if failures >= config.max_failures {
        return Some(Finish::Failures);
    }
    let mut smallest = config.sizes[0];
    for &size in &config.sizes {
        if size < smallest {
            smallest = size;
        }
    }
    if live < smallest as usize || live < last_inliers {
        return Some(Finish::Points);
    }
    None
}

/// Chapter 10.3: the surface after at most `refits` refits on the live points of its shell.
fn refitted(
    cloud: &[Point],
    labels: &[u8],
    config: &Config,
    best: Central,
    observe: &mut dyn FnMut(Event),
) -> Central {
    let mut surface = best;
    for _ in 0..config.refits {
        let list = live_inside(cloud, labels, config.shell, &surface);
        let Ok(new) = fit_observed(cloud, &list, config.constraint, observe) else {
            break;
        };
        if !size_accepted(&new.shape, config.semi_axis_min, config.semi_axis_max) {
            break;
        }
        if new == surface && !fault::is(Fault::Refit) {
            break;
        }
        surface = new;
        observe(Event::Refit(surface));
    }
    surface
}

/// Chapters 10.3 and 10.4: the live points inside the shell of a surface, ascending.
fn live_inside(cloud: &[Point], labels: &[u8], shell: f32, surface: &Central) -> Vec<u16> {
    let mut list = Vec::new();
    for index in live_points(labels) {
        if shell_contains(surface, shell, cloud[index as usize]) {
            list.push(index);
        }
    }
    list
}

/// Chapter 10.4: the claimed points get the label of the target.
fn label(cloud: &[Point], shell: f32, surface: &Central, claimed: &[u16], target: u8, labels: &mut [u8]) {
    for &index in claimed {
        labels[index as usize] = target;
    }
    if fault::is(Fault::Labels) {
        for index in 0..cloud.len() {
            if shell_contains(surface, shell, cloud[index]) {
                labels[index] = target;
            }
        }
    }
}

#[cfg(test)]
#[path = "targets_tests.rs"]
mod tests;
