//! The covariance of centre, axes and semi-axes: contract, chapter M20.

use super::algebra::{Lower, damped, inverse};
use super::model::Estimate;
use super::normal::Normal;
use crate::Symmetric;
use crate::fault::{self, Fault};
use crate::jacobi::{ascending, eigen};

/// M20: the lower triangle by rows; none where the matrix is singular or an entry is not finite.
pub(crate) fn covariance(
    estimate: &Estimate,
    normal: &Normal,
    inflation: f32,
    semi_axes: [f32; 3],
    order: [usize; 3],
) -> Option<[f32; 45]> {
    let mut b = inverse(&damped(&normal.matrix)?);
    for i in 0..9 {
        for j in 0..=i {
            if !fault::is(Fault::Covariance) {
                b[i][j] *= inflation;
            }
            b[j][i] = b[i][j];
        }
    }
    let inflation = if fault::is(Fault::Covariance) { inflation } else { 1.0 };
    of_the_ellipsoid(&b, estimate, semi_axes, order).map(|entries| entries.map(|entry| inflation * entry))
}

/// M20, from `B` on (all of it, both halves).
pub(crate) fn of_the_ellipsoid(
    b: &Lower,
    estimate: &Estimate,
    semi_axes: [f32; 3],
    order: [usize; 3],
) -> Option<[f32; 45]> {
    let mut t = [[0.0; 9]; 9];
    for i in 0..3 {
        for k in 0..3 {
            t[i][k] = estimate.axes[k][i];
            t[6 + i][3 + k] = -estimate.axes[k][i];
        }
        t[3 + i][6 + order[i]] = semi_axes[i];
    }
    let mut w = [[0.0; 9]; 9];
    for i in 0..9 {
        for j in 0..9 {
            for k in 0..9 {
                w[i][j] += t[i][k] * b[k][j];
            }
        }
    }
    let mut covariance = [0.0; 45];
    let mut next = 0;
    for i in 0..9 {
        for j in 0..=i {
            let mut sum = 0.0;
            for k in 0..9 {
                sum += w[i][k] * t[j][k];
            }
            covariance[next] = sum;
            next += 1;
        }
    }
    covariance.iter().all(|entry| entry.is_finite()).then_some(covariance)
}

/// M18.9: the largest standard deviation of the centre.
pub(crate) fn sigma_mm(covariance: Option<&[f32; 45]>) -> f32 {
    let Some(&[xx, xy, yy, xz, yz, zz, ..]) = covariance else { return f32::INFINITY };
    let largest = ascending(&eigen(&Symmetric { xx, yy, zz, xy, xz, yz })).values[2];
    if largest > 0.0 { libm::sqrtf(largest) } else { f32::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sigma_of_the_centre_is_that_of_its_worst_direction() {
        let mut covariance = [0.0; 45];
        [covariance[0], covariance[2], covariance[5]] = [1.0, 4.0, 2.0];
        assert_eq!(sigma_mm(Some(&covariance)), 2.0);
        covariance[2] = -1.0;
        covariance[5] = -1.0;
        covariance[0] = -1.0;
        assert_eq!(sigma_mm(Some(&covariance)), f32::INFINITY);
        assert_eq!(sigma_mm(None), f32::INFINITY);
    }
}
