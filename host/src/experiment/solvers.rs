//! The least squares of the quadric solved in every way that was weighed for the core: two precisions, two frames, two
//! constraints, normal equations with and without refinement, and Givens rotations on the design matrix.
//!
//! Everything up to the solution happens in the precision that is asked for; what follows (centre, semi-axes) is done in
//! 64 bits for all, so that only the solution differs.

use nalgebra::{Matrix3, RealField, Vector3, convert};
use varsac_core::Constraint;

/// Unknowns.
const N: usize = 9;

/// How the equations are solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Solver {
    /// Normal equations, LDL^T.
    Normal,
    /// The same with one step of refinement for the residual of the design rows: the core's way.
    Refined,
    /// Givens rotations on the rows of the design matrix.
    Givens,
}

/// Where the equations are formed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Frame {
    /// The camera's coordinates.
    Raw,
    /// About the mean of the points, scaled by a power of two: the core's way.
    Local,
}

/// Centre and semi-axes (descending) of the least squares through some points; nothing when it is no real ellipsoid.
/// `T` is the precision of every step up to the solution.
pub(super) fn solve<T: RealField + Copy>(
    points: &[[f64; 3]],
    frame: Frame,
    constraint: Constraint,
    solver: Solver,
) -> Option<(Vector3<f64>, [f64; 3])> {
    let narrow = |v: f64| -> T { convert(v) };
    let wide = |v: T| -> f64 { v.to_subset().unwrap_or(f64::NAN) };
    let typed: Vec<[T; 3]> = points.iter().map(|p| p.map(narrow)).collect();
    let (origin, scale) = match frame {
        Frame::Raw => ([T::zero(); 3], T::one()),
        Frame::Local => local_frame(&typed)?,
    };
    let rows: Vec<([T; N], T)> = typed
        .iter()
        .map(|p| design(std::array::from_fn(|k| (p[k] - origin[k]) * scale), constraint))
        .collect();
    let x = match solver {
        Solver::Normal => normal_equations(&rows, 0)?,
        Solver::Refined => normal_equations(&rows, 1)?,
        Solver::Givens => givens(&rows)?,
    };
    let (centre, semi_axes) = ellipsoid(&x.map(wide), constraint)?;
    let (origin, scale) = (Vector3::from(origin.map(wide)), wide(scale));
    Some((origin + centre / scale, semi_axes.map(|length| length / scale)))
}

/// Mean of the points, and the power of two that takes the largest coordinate into [1, 2).
fn local_frame<T: RealField + Copy>(points: &[[T; 3]]) -> Option<([T; 3], T)> {
    let count: T = convert(points.len() as f64);
    let mean = |k: usize| points.iter().fold(T::zero(), |sum, p| sum + p[k]) / count;
    let origin = [mean(0), mean(1), mean(2)];
    let offsets = points.iter().flat_map(|p| (0..3).map(|k| (p[k] - origin[k]).abs()));
    let largest: f64 = offsets.fold(T::zero(), T::max).to_subset()?;
    (largest > 0.0).then(|| (origin, convert(libm::exp2(-libm::floor(libm::log2(largest))))))
}

/// A row of the design matrix and its right-hand side, unknowns as in the core.
fn design<T: RealField + Copy>([x, y, z]: [T; 3], constraint: Constraint) -> ([T; N], T) {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    match constraint {
        Constraint::A11 => ([yy, zz, x, y, z, T::one(), x * y, x * z, y * z], -xx),
        Constraint::Trace => ([yy - xx, zz - xx, x, y, z, T::one(), x * y, x * z, y * z], -(xx + yy + zz)),
    }
}

/// LDL^T of the normal matrix, then `steps` of refinement.
fn normal_equations<T: RealField + Copy>(rows: &[([T; N], T)], steps: u32) -> Option<[T; N]> {
    let mut lower = [[T::zero(); N]; N];
    for (row, _) in rows {
        for i in 0..N {
            for j in 0..=i {
                lower[i][j] += row[i] * row[j];
            }
        }
    }
    // In place: the unit lower triangle below, D on the diagonal.
    for j in 0..N {
        for k in 0..j {
            let factor = lower[j][k] * lower[k][k];
            for i in j..N {
                let product = lower[i][k] * factor;
                lower[i][j] -= product;
            }
        }
        if lower[j][j] <= T::zero() || !lower[j][j].is_finite() {
            return None;
        }
        for i in j + 1..N {
            lower[i][j] /= lower[j][j];
        }
    }
    let mut x = [T::zero(); N];
    for _ in 0..=steps {
        let mut y = [T::zero(); N];
        for (row, target) in rows {
            let residual = (0..N).fold(*target, |rest, k| rest - row[k] * x[k]);
            for k in 0..N {
                y[k] += row[k] * residual;
            }
        }
        for i in 0..N {
            y[i] = (0..i).fold(y[i], |rest, k| rest - lower[i][k] * y[k]);
        }
        for i in 0..N {
            y[i] /= lower[i][i];
        }
        for i in (0..N).rev() {
            y[i] = (i + 1..N).fold(y[i], |rest, k| rest - lower[k][i] * y[k]);
        }
        for k in 0..N {
            x[k] += y[k];
        }
    }
    Some(x)
}

/// Rotates each row into a triangle, one entry after the other, then substitutes back.
fn givens<T: RealField + Copy>(rows: &[([T; N], T)]) -> Option<[T; N]> {
    let mut triangle = [[T::zero(); N + 1]; N];
    for (row, target) in rows {
        let mut row: [T; N + 1] = std::array::from_fn(|k| if k < N { row[k] } else { *target });
        for i in 0..N {
            if row[i] == T::zero() {
                continue;
            }
            let length = (triangle[i][i] * triangle[i][i] + row[i] * row[i]).sqrt();
            let (cos, sin) = (triangle[i][i] / length, row[i] / length);
            for k in i..=N {
                let (above, below) = (triangle[i][k], row[k]);
                triangle[i][k] = cos * above + sin * below;
                row[k] = cos * below - sin * above;
            }
        }
    }
    let mut x = [T::zero(); N];
    for i in (0..N).rev() {
        let rest = (i + 1..N).fold(triangle[i][N], |rest, k| rest - triangle[i][k] * x[k]);
        if triangle[i][i] == T::zero() {
            return None;
        }
        x[i] = rest / triangle[i][i];
    }
    Some(x)
}

/// Centre and semi-axes, descending, Eq. (6)-(13).
fn ellipsoid(x: &[f64; N], constraint: Constraint) -> Option<(Vector3<f64>, [f64; 3])> {
    let [u, v, a14, a24, a34, a44, a12, a13, a23] = *x;
    let (a11, a22, a33) = match constraint {
        Constraint::A11 => (1.0, u, v),
        Constraint::Trace => (1.0 - u - v, 1.0 + u, 1.0 + v),
    };
    let leading =
        Matrix3::new(a11, a12 / 2.0, a13 / 2.0, a12 / 2.0, a22, a23 / 2.0, a13 / 2.0, a23 / 2.0, a33);
    let half = Vector3::new(a14, a24, a34) / 2.0;
    let minors = [a11, a11 * a22 - a12 * a12 / 4.0, leading.determinant()];
    if !minors.iter().all(|minor| *minor > 0.0) {
        return None;
    }
    let centre = -(leading.try_inverse()? * half);
    // I4 / I3, the value at the centre.
    let constant = a44 + half.dot(&centre);
    if constant >= 0.0 || !constant.is_finite() {
        return None;
    }
    let mut roots: [f64; 3] = leading.symmetric_eigenvalues().into();
    roots.sort_by(f64::total_cmp);
    Some((centre, roots.map(|root| (-constant / root).sqrt())))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of an ellipsoid 22 x 12 x 11 about (10, -20, 700).
    fn points() -> Vec<[f64; 3]> {
        (0..40)
            .map(|k| {
                let w = 1.0 - 2.0 * (f64::from(k) + 0.5) / 40.0;
                let (sin, cos) = libm::sincos(2.4 * f64::from(k));
                let r = (1.0 - w * w).sqrt();
                [10.0 + 22.0 * r * cos, 12.0 * r * sin - 20.0, 700.0 + 11.0 * w]
            })
            .collect()
    }

    #[test]
    fn every_way_finds_an_exact_ellipsoid_in_64_bits() {
        for frame in [Frame::Raw, Frame::Local] {
            for constraint in [Constraint::A11, Constraint::Trace] {
                for solver in [Solver::Normal, Solver::Refined, Solver::Givens] {
                    let (centre, semi_axes) = solve::<f64>(&points(), frame, constraint, solver).unwrap();
                    let case = format!("{frame:?} {constraint:?} {solver:?}");
                    assert!((centre - Vector3::new(10.0, -20.0, 700.0)).norm() < 1e-2, "{case}: {centre}");
                    for (length, truth) in semi_axes.into_iter().zip([22.0, 12.0, 11.0]) {
                        assert!((length - truth).abs() < 1e-2, "{case}: {length}");
                    }
                }
            }
        }
    }

    #[test]
    fn what_is_no_ellipsoid_is_nothing() {
        let plane: Vec<[f64; 3]> = (0..20).map(|k| [f64::from(k % 5), f64::from(k / 5), 700.0]).collect();
        assert!(solve::<f32>(&plane, Frame::Local, Constraint::Trace, Solver::Normal).is_none());
        assert!(solve::<f64>(&[[1.0; 3]; 12], Frame::Local, Constraint::A11, Solver::Givens).is_none());
    }
}
