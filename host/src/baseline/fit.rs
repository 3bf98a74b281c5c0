//! Least squares of the quadric with a11 = 1 in double precision: points in, ellipsoid out. Eq. (4) to (13).
//!
//! The nine unknowns (a22, a33, a14, a24, a34, a44, a12, a13, a23) minimise the sum of squares of Eq. (5). The normal
//! equations are formed about the points' mean and in units of their extent, which changes the solution of this
//! constraint by nothing but rounding.

use crate::eval::EllipsoidF64;
use nalgebra::{Cholesky, Matrix3, SMatrix, SVector, SymmetricEigen};

/// Unknowns of the fit, hence points of the smallest sample.
pub const UNKNOWNS: usize = 9;

/// Fits an ellipsoid to the points, any unit. Nothing when there are fewer than nine, when they do not determine a
/// quadric, or when that quadric is no real ellipsoid.
pub fn fit(points: impl ExactSizeIterator<Item = [f64; 3]> + Clone) -> Option<EllipsoidF64> {
    if points.len() < UNKNOWNS {
        return None;
    }
    let count = points.len() as f64;
    let mut mean = [0.0; 3];
    for point in points.clone() {
        for k in 0..3 {
            mean[k] += point[k] / count;
        }
    }
    let offset = |point: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| point[k] - mean[k]) };
    let extent = points
        .clone()
        .map(|p| offset(p).into_iter().fold(0.0, |m: f64, v| m.max(v.abs())))
        .fold(0.0, f64::max);
    // False for NaN too.
    let has_extent = extent > 0.0;
    if !has_extent {
        return None;
    }
    let quadric = least_squares(points.map(|p| offset(p).map(|v| v / extent)))?;
    let (centre, semi_axes, axes) = ellipsoid_of(&quadric)?;
    Some(EllipsoidF64::sorted(
        std::array::from_fn(|k| mean[k] + extent * centre[k]),
        semi_axes.map(|semi_axis| semi_axis * extent),
        axes,
    ))
}

/// Solves Ax = v of the paper. The products are written out, in index order: nalgebra would choose a kernel for a 9x9
/// product at run time.
fn least_squares(points: impl Iterator<Item = [f64; 3]>) -> Option<SVector<f64, UNKNOWNS>> {
    let mut a = SMatrix::<f64, UNKNOWNS, UNKNOWNS>::zeros();
    let mut v = SVector::<f64, UNKNOWNS>::zeros();
    for [x, y, z] in points {
        let row = [y * y, z * z, x, y, z, 1.0, x * y, x * z, y * z];
        for j in 0..UNKNOWNS {
            // The decomposition reads the lower triangle.
            for i in j..UNKNOWNS {
                a[(i, j)] += row[i] * row[j];
            }
            v[j] -= row[j] * (x * x);
        }
    }
    Some(Cholesky::new(a)?.solve(&v))
}

/// Centre, semi-axes and their axes (rows), in the order of the characteristic roots; nothing unless I1, I2, I3 > 0
/// and I4 < 0 (without the last the ellipsoid may be imaginary).
#[expect(clippy::type_complexity, reason = "the three parts of an ellipsoid before they are sorted")]
fn ellipsoid_of(q: &SVector<f64, UNKNOWNS>) -> Option<([f64; 3], [f64; 3], [[f64; 3]; 3])> {
    let (a11, a22, a33, a44) = (1.0, q[0], q[1], q[5]);
    let (half_a14, half_a24, half_a34) = (q[2] / 2.0, q[3] / 2.0, q[4] / 2.0);
    let (half_a12, half_a13, half_a23) = (q[6] / 2.0, q[7] / 2.0, q[8] / 2.0);
    // Cofactors of the leading 3x3 matrix of Eq. (8); the diagonal ones sum to I2, Eq. (7).
    let c11 = a22 * a33 - half_a23 * half_a23;
    let c22 = a11 * a33 - half_a13 * half_a13;
    let c33 = a11 * a22 - half_a12 * half_a12;
    let c12 = half_a13 * half_a23 - half_a12 * a33;
    let c13 = half_a12 * half_a23 - half_a13 * a22;
    let c23 = half_a12 * half_a13 - a11 * half_a23;
    let i1 = a11 + a22 + a33;
    let i2 = c11 + c22 + c33;
    let i3 = a11 * c11 + half_a12 * c12 + half_a13 * c13;
    // False for NaN too.
    let is_ellipsoid = i1 > 0.0 && i2 > 0.0 && i3 > 0.0;
    if !is_ellipsoid {
        return None;
    }
    // Eq. (10) by the cofactors.
    let centre = [
        -(c11 * half_a14 + c12 * half_a24 + c13 * half_a34) / i3,
        -(c12 * half_a14 + c22 * half_a24 + c23 * half_a34) / i3,
        -(c13 * half_a14 + c23 * half_a24 + c33 * half_a34) / i3,
    ];
    // I4 / I3 is the value of the quadric at its centre.
    let i4_over_i3 = a44 + (half_a14 * centre[0] + half_a24 * centre[1] + half_a34 * centre[2]);
    let is_real = i4_over_i3 < 0.0;
    if !is_real {
        return None;
    }
    let leading = Matrix3::new(a11, half_a12, half_a13, half_a12, a22, half_a23, half_a13, half_a23, a33);
    let eigen = SymmetricEigen::new(leading);
    let roots = [eigen.eigenvalues[0], eigen.eigenvalues[1], eigen.eigenvalues[2]];
    // Three positive invariants mean three positive roots, up to rounding.
    if !roots.iter().all(|&root| root > 0.0) {
        return None;
    }
    let axis = |k| {
        let column = eigen.eigenvectors.column(k);
        [column[0], column[1], column[2]]
    };
    // Eq. (13).
    Some((centre, roots.map(|root| (-i4_over_i3 / root).sqrt()), [axis(0), axis(1), axis(2)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::attitude::{angle_between_lines_deg, axes_of_angles};

    fn surface(truth: &EllipsoidF64, count: u32) -> Vec<[f64; 3]> {
        (0..count)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
                let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963_229_728_653);
                let ring = (1.0 - z * z).sqrt();
                let [a, b, c] = truth.semi_axes_mm;
                truth.from_body([a * ring * cos, b * ring * sin, c * z])
            })
            .collect()
    }

    fn jujube() -> EllipsoidF64 {
        EllipsoidF64::sorted([31.0, -45.0, 712.0], [21.7, 11.2, 10.6], axes_of_angles([0.4, -0.8, 1.9]))
    }

    #[test]
    fn exact_points_give_the_ellipsoid_back() {
        let truth = jujube();
        for count in [9, 12, 500] {
            let points = surface(&truth, count);
            let found = fit(points.iter().copied()).unwrap();
            for k in 0..3 {
                assert!((found.centre_mm[k] - truth.centre_mm[k]).abs() < 1e-6, "{count}: {found:?}");
                assert!((found.semi_axes_mm[k] - truth.semi_axes_mm[k]).abs() < 1e-6, "{count}: {found:?}");
                assert!(angle_between_lines_deg(found.axes[k], truth.axes[k]) < 1e-4, "{count}: {found:?}");
            }
        }
    }

    #[test]
    fn other_surfaces_are_refused() {
        let plane = (0..100).map(|i| [f64::from(i % 10), f64::from(i / 10), 700.0]);
        assert!(fit(plane).is_none());
        // A hyperboloid of one sheet, x^2 + y^2 - z^2 = 100.
        let hyperboloid: Vec<[f64; 3]> = (0..200)
            .map(|i| {
                let z = f64::from(i) / 20.0 - 5.0;
                let (sin, cos) = libm::sincos(f64::from(i) * 2.4);
                let ring = (100.0 + z * z).sqrt();
                [ring * cos, ring * sin, z]
            })
            .collect();
        assert!(fit(hyperboloid.iter().copied()).is_none());
        assert!(fit(std::iter::repeat_n([1.0, 2.0, 3.0], 20)).is_none());
        assert!(fit(surface(&jujube(), 9).into_iter().take(8)).is_none());
        assert!(fit(std::iter::repeat_n([f64::NAN; 3], 20)).is_none());
    }
}
