//! Whole searches: what a hypothesis costs, and what a fruit costs, by method.

use std::hint::black_box;

use varsac_core::{Config, Detector, Point3, Step, Workspace};

use super::{race::Contender, workload};
use crate::baseline::{RansacOptions, ransac};

/// Hypotheses of a run of the comparison method: so many that the normals, estimated once a cloud, do not count.
const RANSAC_TRIALS: u32 = 1000;

/// Points of the largest cloud.
const CAPACITY: usize = varsac_core::point::MAX_POINTS;

/// The core on a cloud, with the memory it needs.
struct Core {
    detector: Detector,
    workspace: Box<Workspace<CAPACITY>>,
}

impl Core {
    fn new(config: Config) -> Self {
        let detector = Detector::new(config).expect("the presets are valid");
        Self { detector, workspace: Box::default() }
    }

    /// Targets that are found.
    fn targets(&mut self, cloud: &[Point3]) -> usize {
        let run = self.detector.detect(cloud, self.workspace.scratch(), 1);
        run.expect("the clouds are finite").count()
    }

    /// Draws the hypotheses of the first target and nothing more; returns how many.
    fn hypotheses(&mut self, cloud: &[Point3], count: u32) -> u32 {
        let mut run =
            self.detector.detect(cloud, self.workspace.scratch(), 1).expect("the clouds are finite");
        // The first step plants the tree.
        let planted = matches!(run.step(), Step::Working);
        let mut drawn = 0;
        while planted && drawn < count && matches!(black_box(run.step()), Step::Working) {
            drawn += 1;
        }
        drawn
    }
}

/// Hypotheses on one-sided views: neighbourhood, sample, model, size check and score. The unit is a hypothesis.
pub fn hypotheses(views: &[Vec<Point3>]) -> Vec<Contender<'_>> {
    let of_core = |name, config: Config, count| {
        let mut core = Core::new(config);
        Contender::new(name, move || views.iter().map(|view| u64::from(core.hypotheses(view, count))).sum())
    };
    // A confidence that no ratio of inliers reaches: as many trials as asked for.
    let paper = Config { max_trials: 200, confidence: 0.999_999, ..workload::paper() };
    let default_search = workload::default_search();
    let drawn = u32::from(default_search.map.hypotheses);
    let options =
        RansacOptions { max_trials: RANSAC_TRIALS, confidence: 1.0, max_targets: 1, ..one_ransac() };
    let clouds: Vec<Vec<[f32; 3]>> = views.iter().map(|view| coordinates(view)).collect();
    vec![
        of_core("VARSAC + TEBC (the paper's)", paper, 100),
        of_core("default search", default_search, drawn),
        Contender::new("RANSAC, distance and normal", move || {
            // No ratio reaches this confidence: every trial asked for is made, whether a target comes of it or not.
            let trials = |cloud: &Vec<[f32; 3]>| {
                black_box(ransac(cloud, &options, 1));
                u64::from(RANSAC_TRIALS)
            };
            clouds.iter().map(trials).sum()
        }),
    ]
}

/// One fruit from one-sided views, from the first hypothesis to the result. The unit is a view.
pub fn fruit(views: &[Vec<Point3>]) -> Vec<Contender<'_>> {
    let of_core = |name, config: Config| {
        let mut core = Core::new(Config { max_targets: 1, ..config });
        Contender::new(name, move || {
            for view in views {
                black_box(core.targets(view));
            }
            views.len() as u64
        })
    };
    let options = RansacOptions { max_targets: 1, ..one_ransac() };
    let clouds: Vec<Vec<[f32; 3]>> = views.iter().map(|view| coordinates(view)).collect();
    vec![
        of_core("VARSAC + TEBC (the paper's)", workload::paper()),
        of_core("default search", workload::default_search()),
        Contender::new("RANSAC, distance and normal", move || {
            for cloud in &clouds {
                black_box(ransac(cloud, &options, 1));
            }
            clouds.len() as u64
        }),
    ]
}

/// `targets` fruit in one cloud, by the paper's search and by the default one. The unit is a cloud.
pub fn in_one_cloud(cloud: &[Point3], targets: u8) -> Vec<Contender<'_>> {
    let of_core = |name, config: Config| {
        let mut core = Core::new(Config { max_targets: targets, ..config });
        Contender::new(name, move || {
            black_box(core.targets(cloud));
            1
        })
    };
    vec![
        of_core("VARSAC + TEBC (the paper's)", workload::paper()),
        of_core("default search", workload::default_search()),
    ]
}

fn one_ransac() -> RansacOptions {
    RansacOptions::from(&workload::paper())
}

fn coordinates(cloud: &[Point3]) -> Vec<[f32; 3]> {
    cloud.iter().map(|p| [p.x, p.y, p.z]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hypotheses_are_counted_and_fruit_are_found() {
        let views = workload::views(3, 2);
        let units: Vec<u64> = hypotheses(&views).iter_mut().map(|contender| (contender.work)()).collect();
        let drawn = 3 * u64::from(workload::default_search().map.hypotheses);
        assert!(units[0] > 100 && units[1] == drawn && units[2] >= u64::from(RANSAC_TRIALS), "{units:?}");
        let wall = workload::wall(4, 1000, 2);
        let mut core = Core::new(Config { max_targets: 4, ..workload::default_search() });
        assert_eq!(core.targets(&wall), 4);
    }
}
