//! How far out in its own covariance the truth lies: the calibration of uncertainty.
//!
//! With an error `x` of k components and its covariance `C`, `x^T C^-1 x` follows the chi-squared distribution of k degrees
//! of freedom if `C` is right. Its distribution function turns it into the level of the smallest region that
//! holds the truth; these levels are then uniform in `[0, 1]`, and the region of 95 % holds the truth in 95 % of cases.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use varsac_core::Covariance;

use crate::eval::{EllipsoidF64, dot, subtract};

/// What is looked at, in the order of [`levels`].
pub const BLOCKS: [&str; 3] = ["centre", "sizes", "long axis"];

/// The levels of the smallest regions of centre (3 dimensions), semi-axes (3) and direction of the long axis (2) that hold
/// the truth; 1 where a block of the covariance is singular.
pub fn levels(fit: &EllipsoidF64, covariance: &Covariance, truth: &EllipsoidF64) -> [f64; 3] {
    let rows = covariance.rows().map(|row| row.map(f64::from));
    let block = |at: usize| Matrix3::from_fn(|i, j| rows[at + i][at + j]);
    let solid = |at: usize, error: [f64; 3]| {
        let error = Vector3::from(error);
        block(at).try_inverse().map_or(1.0, |inverse| chi_squared_3(error.dot(&(inverse * error))))
    };
    // A turn by the small vector w moves the long axis by w x p: along q by w.r, along r by -w.q.
    let [p, q, r] = fit.axes;
    let turn = block(6);
    let (along_q, along_r) = (Vector3::from(r), -Vector3::from(q));
    let plane = Matrix2::new(
        along_q.dot(&(turn * along_q)),
        along_q.dot(&(turn * along_r)),
        along_r.dot(&(turn * along_q)),
        along_r.dot(&(turn * along_r)),
    );
    let sign = if dot(p, truth.axes[0]) < 0.0 { -1.0 } else { 1.0 };
    let lean = sign * Vector2::new(dot(q, truth.axes[0]), dot(r, truth.axes[0]));
    [
        solid(0, subtract(truth.centre_mm, fit.centre_mm)),
        solid(3, subtract(truth.semi_axes_mm, fit.semi_axes_mm)),
        plane.try_inverse().map_or(1.0, |inverse| chi_squared_2(lean.dot(&(inverse * lean)))),
    ]
}

/// Distribution function of chi-squared with two degrees of freedom.
fn chi_squared_2(x: f64) -> f64 {
    -libm::expm1(-0.5 * x)
}

/// The same with three: `erf(sqrt(x / 2)) - sqrt(2 x / pi) exp(-x / 2)`.
fn chi_squared_3(x: f64) -> f64 {
    libm::erf(libm::sqrt(0.5 * x)) - libm::sqrt(2.0 * x / core::f64::consts::PI) * libm::exp(-0.5 * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distribution_functions_have_the_values_of_the_tables() {
        // Abramowitz and Stegun 1964, table 26.8; its six digits leave 2e-6 of the level open.
        for (x, level) in [(5.99146, 0.95), (9.21034, 0.99), (1.38629, 0.5)] {
            assert!((chi_squared_2(x) - level).abs() < 2e-6, "{x}");
        }
        for (x, level) in [(7.81473, 0.95), (11.3449, 0.99), (2.36597, 0.5)] {
            assert!((chi_squared_3(x) - level).abs() < 2e-6, "{x}");
        }
    }
}
