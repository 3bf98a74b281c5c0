//! Vectors, symmetric matrices and the nine equations of a step: contract, chapter M1.

use crate::fit::{Factors, factor, solve};
use crate::quadric::adjugate;
use crate::{Rejection, Symmetric};

pub(crate) type Vector = [f32; 3];

/// The lower triangle of a symmetric matrix; what lies above the diagonal is never looked at.
pub(crate) type Lower = [[f32; 9]; 9];

pub(crate) const SQRT2: f32 = f32::from_bits(0x3fb5_04f3);
pub(crate) const E1: f32 = f32::from_bits(0x3f35_04f3);
pub(crate) const E2: f32 = f32::from_bits(0x3ed1_05ec);
pub(crate) const PI: f32 = f32::from_bits(0x4049_0fdb);

pub(crate) fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a - b`.
pub(crate) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn unit(v: Vector) -> Vector {
    let length = libm::sqrtf(dot(v, v));
    [v[0] / length, v[1] / length, v[2] / length]
}

/// The exponential of each component.
pub(crate) fn exponentials(x: Vector) -> Vector {
    [libm::expf(x[0]), libm::expf(x[1]), libm::expf(x[2])]
}

/// `m v`.
pub(crate) fn product(m: &Symmetric, v: Vector) -> Vector {
    [
        m.xx * v[0] + m.xy * v[1] + m.xz * v[2],
        m.xy * v[0] + m.yy * v[1] + m.yz * v[2],
        m.xz * v[0] + m.yz * v[1] + m.zz * v[2],
    ]
}

/// Chapter 6.
pub(crate) fn det(m: &Symmetric) -> f32 {
    m.xx * (m.yy * m.zz - m.yz * m.yz) - m.xy * (m.xy * m.zz - m.yz * m.xz)
        + m.xz * (m.xy * m.yz - m.yy * m.xz)
}

/// Chapter 5.8.
pub(crate) fn adj(m: &Symmetric) -> Symmetric {
    adjugate(m)
}

/// A matrix entry by entry from two others.
pub(crate) fn entrywise(a: &Symmetric, b: &Symmetric, f: impl Fn(f32, f32) -> f32) -> Symmetric {
    Symmetric {
        xx: f(a.xx, b.xx),
        yy: f(a.yy, b.yy),
        zz: f(a.zz, b.zz),
        xy: f(a.xy, b.xy),
        xz: f(a.xz, b.xz),
        yz: f(a.yz, b.yz),
    }
}

/// The matrix with the damping of the three turns (M10, M19, M20), factored; none where it is singular.
pub(crate) fn damped(matrix: &Lower) -> Option<Factors> {
    let mut copy = *matrix;
    for k in 3..6 {
        copy[k][k] += 1.216;
    }
    factor(&copy).ok()
}

/// The solution of 5.4 and 5.5 in one go.
pub(crate) fn solution(matrix: &Lower, rhs: &[f32; 9]) -> Result<[f32; 9], Rejection> {
    Ok(solve(&factor(matrix)?, rhs))
}

/// Nine solves, of which the lower triangle is kept.
pub(crate) fn inverse(factors: &Factors) -> Lower {
    let mut inverse = [[0.0; 9]; 9];
    for j in 0..9 {
        let mut e = [0.0; 9];
        e[j] = 1.0;
        let column = solve(factors, &e);
        for i in j..9 {
            inverse[i][j] = column[i];
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_constants_are_the_nearest_f32() {
        assert_eq!(SQRT2, 2_f32.sqrt());
        assert_eq!(E1, (0.5_f64).sqrt() as f32);
        assert_eq!(E2, (1.0_f64 / 6.0).sqrt() as f32);
        assert_eq!(PI, std::f32::consts::PI);
    }

    #[test]
    fn a_matrix_times_its_adjugate_is_its_determinant() {
        let m = Symmetric { xx: 2.0, yy: 3.0, zz: 4.0, xy: 1.0, xz: 0.0, yz: 1.0 };
        assert_eq!(det(&m), 18.0);
        let a = adj(&m);
        assert_eq!(product(&m, [a.xx, a.xy, a.xz]), [18.0, 0.0, 0.0]);
        assert_eq!(product(&m, [a.xz, a.yz, a.zz]), [0.0, 0.0, 18.0]);
    }

    #[test]
    fn the_inverse_of_a_diagonal_is_the_reciprocal() {
        let mut m = [[0.0; 9]; 9];
        for k in 0..9 {
            m[k][k] = f32::powi(2.0, k as i32);
        }
        m[4][4] -= 1.216;
        let factors = damped(&m).expect("a regular matrix");
        let inverse = inverse(&factors);
        assert_eq!((inverse[0][0], inverse[8][8], inverse[8][0]), (1.0, 1.0 / 256.0, 0.0));
        assert_eq!(inverse[4][4], 1.0 / 16.0);
    }
}
