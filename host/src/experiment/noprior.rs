//! What the experiments without a size prior share: the methods side by side, and how an answer is judged.
//!
//! Every method is given the same points and the same limits (none to speak of) and answers with one ellipsoid. It has
//! *failed* when it gives none, or one whose centre is off by more than the true short semi-axis, or one of whose
//! semi-axes is off by more than half.

use std::time::Instant;

use varsac_core::{
    Config, Constraint, Detector, Ellipsoid, Method, Status, View, Workspace, fit::fit,
    mixture::MixtureConfig,
};

use super::table::{Cell, Column, row};
use crate::{
    baseline::{RansacOptions, ransac},
    eval::{EllipsoidF64, statistics::quantile},
    fruit::Fruit,
};

/// Most points of a cloud.
const CAPACITY: usize = 8192;
/// 95 % of a chi-squared of three degrees of freedom.
const CHI_SQUARED: f64 = 7.815;

/// A way to find one ellipsoid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Way {
    /// The search of this project, with this configuration.
    Mixture(MixtureConfig),
    /// The paper's search over the whole cloud, five refits.
    Paper,
    /// The paper's baseline, its distance threshold in the unit of the cloud.
    Ransac(f64),
    /// Least squares of the quadric on all points.
    Direct,
}

impl Way {
    /// Its name in tables.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Mixture(_) => "mixture",
            Self::Paper => "varsac (paper)",
            Self::Ransac(_) => "ransac",
            Self::Direct => "direct",
        }
    }

    /// Its answer.
    pub(super) fn answer(self, view: &View<'_>, truth: &EllipsoidF64, seed: u64) -> Outcome {
        let started = Instant::now();
        let answer = self.search(view, seed);
        let elapsed_ms = started.elapsed().as_secs_f64() * 1e3;
        Outcome::new(answer.as_ref(), truth, elapsed_ms)
    }

    fn search(self, view: &View<'_>, seed: u64) -> Option<Answer> {
        let one = Config { max_targets: 1, max_failures: 1, refits: 5, ..Fruit::None.config() };
        match self {
            Self::Mixture(mixture) => detect(&Config { method: Method::Mixture, mixture, ..one }, view, seed),
            Self::Paper => detect(&Config { method: Method::Varsac, ..one }, view, seed),
            Self::Ransac(distance_mm) => {
                let points: Vec<[f32; 3]> = view.cloud.iter().map(|p| [p.x, p.y, p.z]).collect();
                let options = RansacOptions { distance_mm, ..RansacOptions::from(&one) };
                let found = ransac(&points, &options, seed).into_iter().next()?;
                Some(Answer { ellipsoid: found.ellipsoid, accepted: true, covariance: None })
            }
            Self::Direct => {
                let all: Vec<u16> = (0..view.cloud.len() as u16).collect();
                let ellipsoid = Ellipsoid::from(&fit(view.cloud, &all, Constraint::Trace).ok()?);
                Some(Answer { ellipsoid: EllipsoidF64::from(&ellipsoid), accepted: true, covariance: None })
            }
        }
    }
}

/// The first target of a run.
fn detect(config: &Config, view: &View<'_>, seed: u64) -> Option<Answer> {
    let detector = Detector::new(config.clone()).ok()?;
    let mut workspace = Box::new(Workspace::<CAPACITY>::new());
    let found = detector.detect_view(view, workspace.scratch(), seed).ok()?.next()?;
    let centre = found.covariance.map(|c| nalgebra::Matrix3::from_fn(|i, j| f64::from(c.entry(i, j))));
    let accepted = found.status == Status::Accepted;
    Some(Answer { ellipsoid: EllipsoidF64::from(&found.ellipsoid), accepted, covariance: centre })
}

/// What a method said.
struct Answer {
    ellipsoid: EllipsoidF64,
    accepted: bool,
    /// Of the centre.
    covariance: Option<nalgebra::Matrix3<f64>>,
}

/// An answer beside the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Outcome {
    /// Distance of the centres; infinite without an answer.
    pub(super) centre: f64,
    /// Largest error of a semi-axis; infinite without an answer.
    pub(super) size: f64,
    /// See the head of this module.
    pub(super) failed: bool,
    /// The method itself believes it.
    pub(super) accepted: bool,
    /// Whether the truth lies in the 95 % region of the centre, where one is given.
    pub(super) covered: Option<bool>,
    /// Wall clock.
    pub(super) elapsed_ms: f64,
}

impl Outcome {
    fn new(answer: Option<&Answer>, truth: &EllipsoidF64, elapsed_ms: f64) -> Self {
        let Some(Answer { ellipsoid, accepted, covariance }) = answer else {
            let (centre, size) = (f64::INFINITY, f64::INFINITY);
            return Self { centre, size, failed: true, accepted: false, covered: None, elapsed_ms };
        };
        let offset = nalgebra::Vector3::from(ellipsoid.centre_mm) - nalgebra::Vector3::from(truth.centre_mm);
        let sizes = ellipsoid.semi_axes_mm.iter().zip(truth.semi_axes_mm);
        let size = sizes.clone().map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let share = sizes.map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
        let centre = offset.norm();
        let right = centre <= truth.semi_axes_mm[2] && share <= 0.5;
        let covered = covariance
            .and_then(nalgebra::Matrix::try_inverse)
            .map(|c| offset.dot(&(c * offset)) < CHI_SQUARED);
        Self { centre, size, failed: !right, accepted: *accepted, covered, elapsed_ms }
    }
}

/// Columns of a table of summaries, after those that say of what.
pub(super) fn columns() -> Vec<Column> {
    vec![
        Column::new("centre_median", "centre, median", 4),
        Column::new("centre_p90", "centre, p90", 4),
        Column::new("size_median", "size, median", 4),
        Column::new("size_p90", "size, p90", 4),
        Column::new("failed_percent", "failed %", 2),
        Column::new("accepted_percent", "accepted %", 1),
        Column::new("wrong_percent", "failed of accepted %", 2),
        Column::new("covered_percent", "95 % regions cover %", 1),
        Column::new("search_ms", "time, median ms", 2),
    ]
}

/// The cells of one summary.
pub(super) fn summary(outcomes: &[Outcome]) -> Vec<Cell> {
    let sorted = |value: fn(&Outcome) -> f64, q: f64| {
        let mut values: Vec<f64> = outcomes.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        quantile(&values, q).filter(|value| value.is_finite()).map_or(Cell::Missing, Cell::Number)
    };
    let accepted: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.accepted).collect();
    let covered: Vec<bool> = accepted.iter().filter_map(|outcome| outcome.covered).collect();
    let percent = |part: usize, all: usize| {
        if all == 0 { Cell::Missing } else { Cell::Number(100.0 * part as f64 / all as f64) }
    };
    let failed = outcomes.iter().filter(|outcome| outcome.failed).count();
    let wrong = accepted.iter().filter(|outcome| outcome.failed).count();
    row![
        sorted(|o| o.centre, 0.5),
        sorted(|o| o.centre, 0.9),
        sorted(|o| o.size, 0.5),
        sorted(|o| o.size, 0.9),
        percent(failed, outcomes.len()),
        percent(accepted.len(), outcomes.len()),
        percent(wrong, accepted.len()),
        percent(covered.iter().filter(|&&inside| inside).count(), covered.len()),
        sorted(|o| o.elapsed_ms, 0.5),
    ]
}
