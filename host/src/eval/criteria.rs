//! The four criteria of the paper, section III: model score, RMS-s, RMS-c and RMS-a.
//!
//! Each of the three errors is the mean absolute value of three components within one fruit, and the root mean
//! square of those means over the fruit. (The paper's "RMS-y" is RMS-s, its "RMS-p" is RMS-c.)

use super::EllipsoidF64;
use super::attitude::{AxisOrder, attitude_error_rad};
use super::statistics::root_mean_square;

/// One fitted fruit beside its truth, reduced to the inner terms of the four criteria.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FruitErrors {
    /// Inliers of the best model, m_i, over the points before fitting, total_i: `[0, 1]`.
    pub model_score: f64,
    /// Mean absolute error of the three semi-axes, millimetres.
    pub size_mm: f64,
    /// Mean absolute error of the three centre coordinates, millimetres.
    pub centre_mm: f64,
    /// Mean absolute error of the three attitude angles, radians.
    pub attitude_rad: f64,
}

impl FruitErrors {
    /// Compares a fit with the truth. `truth_attitude_rad` are the true angles in the convention of
    /// [`super::attitude`], with the semi-axes in the given order. No points at all count as score 0.
    pub fn of(
        truth: &EllipsoidF64,
        truth_attitude_rad: [f64; 3],
        order: AxisOrder,
        fit: &EllipsoidF64,
        inliers: usize,
        total: usize,
    ) -> Self {
        Self {
            model_score: if total == 0 { 0.0 } else { inliers as f64 / total as f64 },
            size_mm: mean_absolute_difference(truth.semi_axes_mm, fit.semi_axes_mm),
            centre_mm: mean_absolute_difference(truth.centre_mm, fit.centre_mm),
            attitude_rad: attitude_error_rad(truth_attitude_rad, fit, order),
        }
    }
}

/// The criteria over all fruit: a row of the paper's Table 4 or 6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Criteria {
    /// Fruit compared, n.
    pub fruit: usize,
    /// Mean model score, `[0, 1]`; the paper prints it in per cent.
    pub model_score: f64,
    /// RMS-s, millimetres.
    pub rms_size_mm: f64,
    /// RMS-c, millimetres.
    pub rms_centre_mm: f64,
    /// RMS-a, radians.
    pub rms_attitude_rad: f64,
}

impl Criteria {
    /// Over the given fruit; nothing when there are none.
    pub fn of(fruit: &[FruitErrors]) -> Option<Self> {
        let rms = |term: fn(&FruitErrors) -> f64| root_mean_square(fruit.iter().map(term));
        Some(Self {
            fruit: fruit.len(),
            model_score: fruit.iter().map(|f| f.model_score).sum::<f64>() / fruit.len() as f64,
            rms_size_mm: rms(|f| f.size_mm)?,
            rms_centre_mm: rms(|f| f.centre_mm)?,
            rms_attitude_rad: rms(|f| f.attitude_rad)?,
        })
    }
}

fn mean_absolute_difference(p: [f64; 3], q: [f64; 3]) -> f64 {
    ((p[0] - q[0]).abs() + (p[1] - q[1]).abs() + (p[2] - q[2]).abs()) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::attitude::axes_of_angles;

    #[test]
    fn table_3_by_hand() {
        let truth = EllipsoidF64::sorted([1.0; 3], [1.0, 2.0, 3.0], axes_of_angles([0.0, 0.0, 1.05]));
        let fit = EllipsoidF64::sorted(
            [0.9647, 0.9740, 0.9545],
            [1.0098, 2.0354, 3.0462],
            axes_of_angles([0.11, -0.10, 1.13]),
        );
        let errors = FruitErrors::of(&truth, [0.0, 0.0, 1.05], AxisOrder::Ascending, &fit, 783, 1000);
        assert!((errors.model_score - 0.783).abs() < 1e-12);
        assert!((errors.size_mm - (0.0098 + 0.0354 + 0.0462) / 3.0).abs() < 1e-12);
        assert!((errors.centre_mm - (0.0353 + 0.0260 + 0.0455) / 3.0).abs() < 1e-12);
        assert!((errors.attitude_rad - 0.29 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn the_root_mean_square_runs_over_the_fruit() {
        let fruit = |e: f64| FruitErrors {
            model_score: e / 10.0,
            size_mm: e,
            centre_mm: 2.0 * e,
            attitude_rad: 0.5 * e,
        };
        let criteria = Criteria::of(&[fruit(1.0), fruit(7.0)]).unwrap();
        // sqrt((1 + 49) / 2) = 5.
        assert_eq!(criteria.fruit, 2);
        assert!((criteria.model_score - 0.4).abs() < 1e-12);
        assert!((criteria.rms_size_mm - 5.0).abs() < 1e-12);
        assert!((criteria.rms_centre_mm - 10.0).abs() < 1e-12);
        assert!((criteria.rms_attitude_rad - 2.5).abs() < 1e-12);
        assert_eq!(Criteria::of(&[]), None);
    }
}
