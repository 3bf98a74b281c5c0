//! The paper's simulation as the experiments of section III.A share it: clouds, readings of r_s, errors.

use varsac_core::{Config, Constraint};

use super::methods::{Found, Method, Task};
use crate::{
    eval::{
        attitude::AxisOrder,
        criteria::{Criteria, FruitErrors},
        statistics::quantile,
    },
    synth::{Simulation, SimulationOptions, simulate},
};

/// A result whose centre is farther than this from the truth is a failure: a tenth of the mean semi-axis.
pub(super) const FAILED: f64 = 0.2;

/// Distance threshold of the baseline: the half thickness of the TEBC shell on the mean semi-axis. The paper gives none.
const DISTANCE: f64 = 0.2;

/// A reading of Table 2's sampling radius.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    /// In tables.
    pub(super) name: &'static str,
    /// r_s.
    pub(super) radius: f32,
    /// Least squares on the inliers at the end, one after the other.
    pub(super) refits: u8,
    /// How the least squares fix the scale of the quadric; the paper's is a11 = 1.
    pub(super) constraint: Constraint,
}

/// As printed; spanning the body from any of its points; without limit; with the refits that whole surfaces reward; and
/// with the constraint that no frame is special to.
pub(super) const READINGS: [Reading; 5] = [
    Reading { name: "r_s = 1, as printed", radius: 1.0, refits: 1, constraint: Constraint::A11 },
    Reading { name: "r_s = 6.5", radius: 6.5, refits: 1, constraint: Constraint::A11 },
    Reading { name: "whole cloud", radius: f32::INFINITY, refits: 1, constraint: Constraint::A11 },
    Reading {
        name: "whole cloud, 10 refits",
        radius: f32::INFINITY,
        refits: 10,
        constraint: Constraint::A11,
    },
    Reading { name: "the same, trace = 3", radius: f32::INFINITY, refits: 10, constraint: Constraint::Trace },
];

/// The reading that reproduces the paper: the whole cloud, one refit.
pub(super) const WHOLE: Reading = READINGS[2];

impl Reading {
    /// Table 2 with this reading.
    pub(super) fn config(&self) -> Config {
        Config { radius: self.radius, refits: self.refits, constraint: self.constraint, ..Config::table2() }
    }
}

/// A cloud of 1000 points, 30 % of them random.
pub(super) fn cloud(seed: u64, sigma: f64) -> Simulation {
    simulate(&SimulationOptions { seed, sigma, ..SimulationOptions::default() })
        .expect("the defaults are valid")
}

/// Searches a simulated cloud.
pub(super) fn search(method: &Method, simulation: &Simulation, config: &Config, seed: u64) -> Option<Found> {
    (method.find)(&Task { cloud: &simulation.points, config, distance: DISTANCE, seed })
}

/// The paper's errors of one result.
pub(super) fn errors(simulation: &Simulation, found: &Found) -> FruitErrors {
    let attitude_rad = SimulationOptions::default().attitude_rad;
    let (inliers, total) = (found.inliers.len(), simulation.points.len());
    FruitErrors::of(&simulation.truth, attitude_rad, AxisOrder::Ascending, &found.ellipsoid, inliers, total)
}

/// Many results of one method, in the order of the seeds; nothing where it found nothing.
#[derive(Debug, Clone, Default)]
pub(super) struct Summary {
    /// The paper's criteria over all results.
    pub(super) criteria: Option<Criteria>,
    /// Share without a result or with a failed one.
    pub(super) failed: f64,
    /// Median of the inner term of RMS-c.
    pub(super) centre_median: Option<f64>,
    /// Medians.
    pub(super) trials: Option<f64>,
    pub(super) search_ms: Option<f64>,
    pub(super) score_us: Option<f64>,
}

impl Summary {
    /// Of the runs of one method.
    pub(super) fn of(runs: &[Option<(FruitErrors, Found)>]) -> Self {
        let found = || runs.iter().flatten();
        let errors: Vec<FruitErrors> = found().map(|(errors, _)| *errors).collect();
        let good = errors.iter().filter(|e| e.centre_mm <= FAILED).count();
        let median = |value: &dyn Fn(&(FruitErrors, Found)) -> f64| {
            let mut values: Vec<f64> = found().map(value).collect();
            values.sort_by(f64::total_cmp);
            quantile(&values, 0.5)
        };
        Self {
            criteria: Criteria::of(&errors),
            failed: 1.0 - good as f64 / runs.len().max(1) as f64,
            centre_median: median(&|run| run.0.centre_mm),
            trials: median(&|run| f64::from(run.1.trials)),
            search_ms: median(&|run| run.1.search_ms),
            score_us: median(&|run| run.1.score_us),
        }
    }
}
