//! Families of clouds from easy to hard on which sample sizes are compared, and a search with a given number of
//! hypotheses, whatever the sizes: the paper's stopping rule would give larger samples more of them or fewer.

use varsac_core::{CentralQuadric, Config, Ellipsoid, Point3, fit::fit, rng::Stream, tebc::Shell};

use super::simulated::{self, WHOLE};
use crate::{
    eval::EllipsoidF64,
    synth::onesided::{self, Family},
};

/// Clouds of one kind.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    /// The paper's simulation with this deviation.
    Simulation(f64),
    /// One-sided views of jujubes.
    Views(&'static Family),
}

/// The families, with their names in tables.
pub(super) const KINDS: [(&str, Kind); 7] = [
    ("simulation, sigma 0.02", Kind::Simulation(0.02)),
    ("simulation, sigma 0.05", Kind::Simulation(0.05)),
    ("simulation, sigma 0.1", Kind::Simulation(0.1)),
    ("simulation, sigma 0.15", Kind::Simulation(0.15)),
    ("jujubes, clean", Kind::Views(&onesided::families::CLEAN)),
    ("jujubes, occluded", Kind::Views(&onesided::families::OCCLUDED)),
    ("jujubes, hard", Kind::Views(&onesided::families::HARD)),
];

impl Kind {
    /// The cloud of a seed and the truth: of a view, the points of the fruit-coloured mask.
    pub(super) fn cloud(&self, seed: u64) -> (Vec<Point3>, EllipsoidF64) {
        match self {
            Self::Simulation(sigma) => {
                let simulation = simulated::cloud(seed, *sigma);
                (simulation.points, simulation.truth)
            }
            Self::Views(family) => {
                let scene = onesided::Scene::new(family, seed);
                let mut seen = scene.sighting(onesided::MaskBias::default());
                seen.cloud.truncate(seen.in_mask);
                (seen.cloud, scene.fruit[0].ellipsoid)
            }
        }
    }

    /// What the search is told.
    pub(super) fn config(&self) -> Config {
        match self {
            Self::Simulation(_) => WHOLE.config(),
            Self::Views(_) => Config::jujube().paper(),
        }
    }

    /// The short semi-axis: a centre that is off by more is a failure.
    pub(super) fn short_semi_axis(&self) -> f64 {
        match self {
            Self::Simulation(_) => 1.0,
            Self::Views(_) => 10.9,
        }
    }
}

/// The best of a fixed number of hypotheses from the whole cloud, sample sizes in turn, and its share of inliers. Fit,
/// limits of size and score are the core's.
pub(super) fn best_of(
    cloud: &[Point3],
    config: &Config,
    hypotheses: u32,
    seed: u64,
) -> Option<(CentralQuadric, f64)> {
    let mut stream = Stream::new(seed);
    let mut order: Vec<u16> = (0..cloud.len() as u16).collect();
    let all = order.clone();
    let mut best: Option<(CentralQuadric, u32)> = None;
    for &size in config.sample_sizes.iter().cycle().take(hypotheses as usize) {
        let size = usize::from(size);
        if size > order.len() {
            return None;
        }
        // The beginning of a Fisher-Yates shuffle: a sample without replacement, whatever the order was before.
        for k in 0..size {
            let from = k + stream.below((order.len() - k) as u32) as usize;
            order.swap(k, from);
        }
        let Ok(surface) = fit(cloud, &order[..size], config.constraint) else { continue };
        let [longest, .., shortest] = Ellipsoid::from(&surface).semi_axes;
        if !(shortest > config.semi_axis_min && longest < config.semi_axis_max) {
            continue;
        }
        let inliers = Shell::new(&surface, config.shell).score(cloud, &all).inliers;
        if best.is_none_or(|(_, most)| inliers > most) {
            best = Some((surface, inliers));
        }
    }
    best.map(|(surface, inliers)| (surface, f64::from(inliers) / cloud.len() as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_hypotheses_are_never_worse() {
        let (cloud, truth) = Kind::Simulation(0.02).cloud(5);
        let config = Config { sample_sizes: (9..=12).collect(), ..Kind::Simulation(0.02).config() };
        let shares = [20, 200, 400].map(|n| best_of(&cloud, &config, n, 1).map_or(0.0, |(_, share)| share));
        assert!(shares[0] <= shares[1] && shares[1] <= shares[2] && shares[2] > 0.65, "{shares:?}");
        let (surface, _) = best_of(&cloud, &config, 400, 1).unwrap();
        assert!((f64::from(surface.centre.x) - truth.centre_mm[0]).abs() < 0.1);
        assert!(best_of(&cloud[..8], &config, 400, 1).is_none());
    }

    #[test]
    fn a_view_has_a_truth_of_jujube_size() {
        for (name, kind) in KINDS.iter().filter(|(_, kind)| matches!(kind, Kind::Views(_))) {
            let (cloud, truth) = kind.cloud(2);
            assert!(cloud.len() > 20 && (19.0..25.0).contains(&truth.semi_axes_mm[0]), "{name}");
        }
    }
}
