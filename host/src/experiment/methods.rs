//! The methods that are compared, all asked the same way: one cloud without a viewpoint, one ellipsoid.
//!
//! To add a method, add an entry to [`METHODS`]: every experiment that compares takes its list from there.

use std::time::Instant;

use varsac_core::{
    CentralQuadric, Config, Detector, MapConfig, Point3, SizePrior, Viewpoint, Workspace, residual::Noise,
    tebc::Shell,
};

use crate::{
    baseline::{RansacOptions, neighbours::NeighbourTree, normals::normals, ransac, score::Score},
    eval::EllipsoidF64,
    locate::fit_all,
};

/// What a method is given.
#[derive(Debug, Clone, Copy)]
pub(super) struct Task<'a> {
    /// At most [`CAPACITY`] points.
    pub(super) cloud: &'a [Point3],
    /// Limits, radius, shell, trials: for all methods alike.
    pub(super) config: &'a Config,
    /// Distance threshold of the distance-and-normal score, in the unit of the cloud.
    pub(super) distance: f64,
    /// Seed of the search.
    pub(super) seed: u64,
}

/// What it found.
#[derive(Debug, Clone)]
pub(super) struct Found {
    /// The ellipsoid.
    pub(super) ellipsoid: EllipsoidF64,
    /// Indices of the points that the method counts as its own, ascending.
    pub(super) inliers: Vec<u32>,
    /// Share of the neighbourhood that the best hypothesis explained before the final least squares: w of Eq. (17).
    pub(super) support: f64,
    /// Hypotheses drawn.
    pub(super) trials: u32,
    /// Wall clock of the search, milliseconds: the paper's Time1.
    pub(super) search_ms: f64,
    /// Wall clock of scoring the whole cloud once, microseconds: the paper's Time2.
    pub(super) score_us: f64,
}

/// One of the methods.
#[derive(Debug, Clone, Copy)]
pub(super) struct Method {
    /// Name in tables.
    pub(super) name: &'static str,
    /// Whether the sampling radius makes a difference to it.
    pub(super) samples: bool,
    /// Searches.
    pub(super) find: fn(&Task<'_>) -> Option<Found>,
}

/// The methods of the paper's tables, in their order, and the default search.
pub(super) const METHODS: [Method; 4] = [
    Method { name: "direct", samples: false, find: direct },
    Method { name: "RANSAC", samples: true, find: distance_and_normal },
    VARSAC,
    Method { name: "default, size known", samples: false, find: default_search },
];

/// The paper's own.
pub(super) const VARSAC: Method = Method { name: "VARSAC+TEBC", samples: true, find: varsac };

/// Most points of a cloud.
pub(super) const CAPACITY: usize = 4096;

/// Repetitions of a score, the fastest of which is taken: it is far shorter than a turn of the scheduler.
const REPETITIONS: usize = 5;

/// Algorithm 1 with TEBC.
fn varsac(task: &Task<'_>) -> Option<Found> {
    let detector = Detector::new(task.config.clone()).ok()?;
    let mut workspace = Box::new(Workspace::<CAPACITY>::new());
    let started = Instant::now();
    let mut run = detector.detect(task.cloud, workspace.scratch(), task.seed).ok()?;
    let found = run.next()?;
    let search_ms = started.elapsed().as_secs_f64() * 1e3;
    let inliers = claimed(run.labels(), found.target);

    let ellipsoid = EllipsoidF64::from(&found.ellipsoid);
    let all: Vec<u16> = (0..task.cloud.len() as u16).collect();
    let shell = Shell::new(&CentralQuadric::from(&ellipsoid), task.config.shell);
    let score_us = fastest_us(|| shell.score(task.cloud, &all).inliers);
    let support = f64::from(found.report.support.ratio());
    Some(Found { ellipsoid, inliers, support, trials: found.report.trials, search_ms, score_us })
}

/// The default search without a viewpoint, which is told the size that the simulation has, to 15 % as a whole and 10 % in
/// proportions. Its first target counts, accepted or refused.
fn default_search(task: &Task<'_>) -> Option<Found> {
    let map = MapConfig::of(SizePrior::of(KNOWN_SEMI_AXES, 0.15, 0.10, 0.10));
    // The threshold of the others is twice a good guess of the noise.
    let noise = Noise { axial_mm: task.distance as f32 / 2.0, ..map.noise };
    let map = MapConfig { boxiness: 0.0, viewpoint: Viewpoint::None, noise, ..map };
    let config = Config { method: varsac_core::Method::Map, map, ..task.config.clone() };
    let detector = Detector::new(config).ok()?;
    let mut workspace = Box::new(Workspace::<CAPACITY>::new());
    let started = Instant::now();
    let mut run = detector.detect(task.cloud, workspace.scratch(), task.seed).ok()?;
    let found = run.next()?;
    let search_ms = started.elapsed().as_secs_f64() * 1e3;
    let inliers = claimed(run.labels(), found.target);
    Some(Found {
        ellipsoid: EllipsoidF64::from(&found.ellipsoid),
        inliers,
        support: f64::from(found.score.ratio()),
        trials: found.report.trials,
        search_ms,
        // It has no score of its own that could be taken out and timed.
        score_us: f64::NAN,
    })
}

/// Semi-axes of the simulation.
const KNOWN_SEMI_AXES: [f32; 3] = [3.0, 2.0, 1.0];

/// The points with a target's label.
fn claimed(labels: &[u8], target: u8) -> Vec<u32> {
    (0_u32..).zip(labels).filter(|(_, label)| **label == target).map(|(index, _)| index).collect()
}

/// Nine points, distance and normal.
fn distance_and_normal(task: &Task<'_>) -> Option<Found> {
    let options =
        RansacOptions { distance_mm: task.distance, max_targets: 1, ..RansacOptions::from(task.config) };
    let points: Vec<[f32; 3]> = task.cloud.iter().map(|p| [p.x, p.y, p.z]).collect();
    let started = Instant::now();
    let found = ransac(&points, &options, task.seed).into_iter().next()?;
    let search_ms = started.elapsed().as_secs_f64() * 1e3;

    let wide: Vec<[f64; 3]> = points.iter().map(|p| p.map(f64::from)).collect();
    let directions = normals(&NeighbourTree::new(wide.clone()), options.normal_neighbours);
    let score = Score::new(&found.ellipsoid, options.distance_mm, options.normal_cosine);
    let count =
        || wide.iter().zip(&directions).filter(|(point, normal)| score.is_inlier(**point, **normal)).count();
    let score_us = fastest_us(count);
    let support = found.neighbourhood_inliers as f64 / found.neighbourhood as f64;
    let (ellipsoid, inliers, trials) = (found.ellipsoid, found.inliers, found.trials);
    Some(Found { ellipsoid, inliers, support, trials, search_ms, score_us })
}

/// Least squares on all points; all of them are its own.
fn direct(task: &Task<'_>) -> Option<Found> {
    let started = Instant::now();
    let surface = fit_all(task.cloud, task.config.constraint).ok()?;
    let ellipsoid = EllipsoidF64::from(&varsac_core::Ellipsoid::from(&surface));
    let search_ms = started.elapsed().as_secs_f64() * 1e3;
    let inliers = (0..task.cloud.len() as u32).collect();
    Some(Found { ellipsoid, inliers, support: 1.0, trials: 1, search_ms, score_us: 0.0 })
}

fn fastest_us<T>(work: impl Fn() -> T) -> f64 {
    let timed = |_| {
        let started = Instant::now();
        std::hint::black_box(work());
        started.elapsed().as_secs_f64() * 1e6
    };
    (0..REPETITIONS).map(timed).fold(f64::INFINITY, f64::min)
}
