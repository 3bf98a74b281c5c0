//! How sure: the 9x9 covariance of centre, semi-axes and attitude.
//!
//! The inverse of the normal matrix at the solution is the covariance if the residuals are independent and the model
//! is right. Where that is less than true it shows: fruit that are no ellipsoids pull against the size prior, and points
//! that lie near the model without fitting it are somebody else's, some of whose neighbours fit by chance. So
//! `C = (base + per_conflict q + per_clutter m) H^-1`, with `q` the size conflict ([`crate::size`]) and `m` the number of
//! near but unexplained points over the explained ones; the three factors are calibrated on synthetic views.
//! The twist of a spheroid, which nothing determines, carries the variance of a uniform angle.

use crate::{
    Ellipsoid,
    linalg::{N, Symmetric9, packed},
    refine::{Estimate, Normal, ROTATION_INFORMATION},
};

/// Covariance of `(x, y, z, a, b, c, rx, ry, rz)`: centre in mm in the frame of the cloud, semi-axes in mm in the order
/// of [`Ellipsoid::semi_axes`], rotation vector in rad in the frame of the cloud (the true axes are the reported ones
/// turned by it). 45 numbers, see [`Self::packed`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Covariance([[f32; N]; N.div_ceil(2)]);

/// Factors of the inflation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Inflation {
    /// Factor on `H^-1` where nothing is wrong.
    pub base: f32,
    /// Added for each unit of size conflict.
    pub per_conflict: f32,
    /// Added for as many near but unexplained points as explained ones.
    pub per_clutter: f32,
}

impl Covariance {
    /// The 45 numbers, lower triangle by rows: entry (i, j), j <= i, at `i (i + 1) / 2 + j`.
    pub fn packed(&self) -> &[f32] {
        self.0.as_flattened()
    }

    /// Entry (i, j) of the symmetric matrix; 0 outside 0..9.
    pub fn entry(&self, i: usize, j: usize) -> f32 {
        let (row, column) = if i >= j { (i, j) } else { (j, i) };
        if row >= N { 0.0 } else { self.packed().get(packed(row, column)).copied().unwrap_or(0.0) }
    }

    /// The covariance of the same body in a unit of length `1 / factor` times as long: lengths grow by `factor`, angles do
    /// not. Row and column of each length are multiplied one after the other.
    pub(crate) fn scaled(&self, factor: f32) -> Self {
        let mut result = *self;
        let by = |index: usize| if index < 6 { factor } else { 1.0 };
        for i in 0..N {
            for j in 0..=i {
                if let Some(entry) = result.0.as_flattened_mut().get_mut(packed(i, j)) {
                    *entry = (*entry * by(i)) * by(j);
                }
            }
        }
        result
    }

    /// The full matrix, rows.
    pub fn rows(&self) -> [[f32; N]; N] {
        core::array::from_fn(|i| core::array::from_fn(|j| self.entry(i, j)))
    }

    /// Standard deviations of the centre's coordinates, mm.
    pub fn sigma_centre_mm(&self) -> [f32; 3] {
        [0, 1, 2].map(|k| libm::sqrtf(self.entry(k, k)))
    }

    /// Largest standard deviation of the centre in any direction, mm.
    pub fn sigma_centre_max_mm(&self) -> f32 {
        let block = crate::jacobi::Symmetric3 {
            xx: self.entry(0, 0),
            yy: self.entry(1, 1),
            zz: self.entry(2, 2),
            xy: self.entry(1, 0),
            xz: self.entry(2, 0),
            yz: self.entry(2, 1),
        };
        let [_, _, largest] = crate::jacobi::eigen(&block).values;
        if largest > 0.0 { libm::sqrtf(largest) } else { f32::INFINITY }
    }
}

/// Covariance from the normal equations at `estimate`, for the axes in the order of `ellipsoid` (the sorted form of the
/// same body; `order[k]` is the index in the estimate of its k-th semi-axis). `None` when the matrix is singular or the result not finite.
// Not inlined, so that its matrices are not on the stack while others are made.
#[inline(never)]
pub(crate) fn covariance(
    normal: &Normal,
    estimate: &Estimate,
    ellipsoid: &Ellipsoid,
    order: [usize; 3],
    inflation: f32,
) -> Option<Covariance> {
    let mut matrix = normal.matrix;
    for k in 3..6 {
        matrix.add_diagonal(k, ROTATION_INFORMATION);
    }
    let mut body = matrix.factor()?.inverse();
    for entry in &mut body.0 {
        *entry *= inflation;
    }
    in_cloud(&body, estimate, ellipsoid, order)
}

/// Covariance of the body parameters (see [`Estimate`]) in the terms of [`Covariance`]; `None` when it is not finite.
pub(crate) fn in_cloud(
    body: &Symmetric9,
    estimate: &Estimate,
    ellipsoid: &Ellipsoid,
    order: [usize; 3],
) -> Option<Covariance> {
    // y = T x: centre and rotation from the body's axes into the frame of the cloud (the turn of the axes is the
    // reverse of the turn of the coordinates, hence the sign), logarithms into millimetres.
    let mut transform = [[0.0_f32; N]; N];
    for i in 0..3 {
        for k in 0..3 {
            let component = estimate.axes[k][i];
            transform[i][k] = component;
            transform[6 + i][3 + k] = -component;
        }
        for k in 0..3 {
            if order[i] == k {
                transform[3 + i][6 + k] = ellipsoid.semi_axes[i];
            }
        }
    }
    let covariance = Covariance(congruence(&transform, body));
    covariance.packed().iter().all(|entry| entry.is_finite()).then_some(covariance)
}

/// `T S T^T`, lower triangle; each entry of `T S` and of the product is summed in ascending order.
pub(crate) fn congruence(transform: &[[f32; N]; N], s: &Symmetric9) -> [[f32; N]; N.div_ceil(2)] {
    let mut half = [[0.0_f32; N]; N];
    for i in 0..N {
        for j in 0..N {
            let mut sum = 0.0;
            for k in 0..N {
                let entry = if k >= j { s.entry(k, j) } else { s.entry(j, k) };
                sum += transform[i][k] * entry;
            }
            half[i][j] = sum;
        }
    }
    let mut result = [[0.0; N]; N.div_ceil(2)];
    let mut slots = result.as_flattened_mut().iter_mut();
    for i in 0..N {
        for j in 0..=i {
            let mut sum = 0.0;
            for k in 0..N {
                sum += half[i][k] * transform[j][k];
            }
            if let Some(slot) = slots.next() {
                *slot = sum;
            }
        }
    }
    result
}
