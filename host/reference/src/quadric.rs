//! From the solution to a central surface, and its size: contract, chapter 5, steps 7 to 9, and chapter 6;
//! Eq. (6) to (10).

use crate::fault::{self, Fault};
use crate::{Constraint, Rejection};

/// A symmetric 3x3 matrix under the names of the contract.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Symmetric {
    /// Row 0, column 0.
    pub xx: f32,
    /// Row 1, column 1.
    pub yy: f32,
    /// Row 2, column 2.
    pub zz: f32,
    /// Row 0, column 1.
    pub xy: f32,
    /// Row 0, column 2.
    pub xz: f32,
    /// Row 1, column 2.
    pub yz: f32,
}

/// The surface `(p - centre)^T shape (p - centre) = 1`; mm and 1/mm^2 in the frame of the cloud.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Central {
    /// Centre.
    pub centre: [f32; 3],
    /// Shape matrix, positive definite for an ellipsoid.
    pub shape: Symmetric,
}

/// The ten coefficients of Eq. (3).
pub(crate) struct Quadric {
    pub(crate) a11: f32,
    pub(crate) a22: f32,
    pub(crate) a33: f32,
    pub(crate) a12: f32,
    pub(crate) a13: f32,
    pub(crate) a23: f32,
    pub(crate) a14: f32,
    pub(crate) a24: f32,
    pub(crate) a34: f32,
    pub(crate) a44: f32,
}

/// Chapter 5.7.
pub(crate) fn quadric(x: &[f32; 9], constraint: Constraint) -> Quadric {
    let [u, v, a14, a24, a34, a44, a12, a13, a23] = *x;
    let (a11, a22, a33) = match constraint {
        Constraint::A11 => (1.0, u, v),
        Constraint::Trace if fault::is(Fault::Quadric) => (1.0 - (u + v), 1.0 + u, 1.0 + v),
        Constraint::Trace => ((1.0 - u) - v, 1.0 + u, 1.0 + v),
    };
    Quadric { a11, a22, a33, a12, a13, a23, a14, a24, a34, a44 }
}

/// The invariants with the matrix `A` and the vector `g = C b` they were made from.
pub(crate) struct Invariants {
    pub(crate) i1: f32,
    pub(crate) i2: f32,
    pub(crate) i3: f32,
    pub(crate) i4: f32,
    a: Symmetric,
    g: [f32; 3],
}

/// Chapter 5.8: everything but the test.
pub(crate) fn invariants(q: &Quadric) -> Invariants {
    let a = Symmetric { xx: q.a11, yy: q.a22, zz: q.a33, xy: 0.5 * q.a12, xz: 0.5 * q.a13, yz: 0.5 * q.a23 };
    let b = [0.5 * q.a14, 0.5 * q.a24, 0.5 * q.a34];
    let c = adjugate(&a);
    let g = [
        (c.xx * b[0] + c.xy * b[1]) + c.xz * b[2],
        (c.xy * b[0] + c.yy * b[1]) + c.yz * b[2],
        (c.xz * b[0] + c.yz * b[1]) + c.zz * b[2],
    ];
    let i1 = a.xx + a.yy + a.zz;
    let i2 = if fault::is(Fault::Invariants) { c.xx + c.yy + c.zz } else { c.zz + c.yy + c.xx };
    let i3 = a.xx * c.xx + a.xy * c.xy + a.xz * c.xz;
    let i4 = q.a44 * i3 - (b[0] * g[0] + b[1] * g[1] + b[2] * g[2]);
    Invariants { i1, i2, i3, i4, a, g }
}

/// Chapter 5.8: the adjugate `C` of `A`.
pub(crate) fn adjugate(a: &Symmetric) -> Symmetric {
    Symmetric {
        xx: a.yy * a.zz - a.yz * a.yz,
        yy: a.xx * a.zz - a.xz * a.xz,
        zz: a.xx * a.yy - a.xy * a.xy,
        xy: a.xz * a.yz - a.xy * a.zz,
        xz: a.xy * a.yz - a.xz * a.yy,
        yz: a.xy * a.xz - a.xx * a.yz,
    }
}

/// Chapter 5.8, the test, and 5.9: the local central form of a real ellipsoid.
pub(crate) fn central(i: &Invariants) -> Result<Central, Rejection> {
    let real_ellipsoid = i.i1 > 0.0 && i.i2 > 0.0 && i.i3 > 0.0 && i.i4 < 0.0;
    if !real_ellipsoid {
        return Err(Rejection::NotEllipsoid);
    }
    let k = -(i.i3 / i.i4);
    let mut centre = [0.0; 3];
    for axis in 0..3 {
        centre[axis] =
            if fault::is(Fault::Hypothesis) { -(i.g[axis] * (1.0 / i.i3)) } else { -(i.g[axis] / i.i3) };
    }
    let shape = Symmetric {
        xx: i.a.xx * k,
        yy: i.a.yy * k,
        zz: i.a.zz * k,
        xy: i.a.xy * k,
        xz: i.a.xz * k,
        yz: i.a.yz * k,
    };
    for number in
        [centre[0], centre[1], centre[2], shape.xx, shape.yy, shape.zz, shape.xy, shape.xz, shape.yz]
    {
        if !number.is_finite() {
            return Err(Rejection::NotEllipsoid);
        }
    }
    Ok(Central { centre, shape })
}

/// Chapter 6: whether all semi-axes lie between `min` and `max`.
pub fn size_accepted(shape: &Symmetric, min: f32, max: f32) -> bool {
    let low = 1.0 / (max * max);
    let high = 1.0 / (min * min);
    let p = Symmetric {
        xx: shape.xx - low,
        yy: shape.yy - low,
        zz: shape.zz - low,
        xy: shape.xy,
        xz: shape.xz,
        yz: shape.yz,
    };
    let q = Symmetric {
        xx: high - shape.xx,
        yy: high - shape.yy,
        zz: high - shape.zz,
        xy: -shape.xy,
        xz: -shape.xz,
        yz: -shape.yz,
    };
    positive_definite(&p) && positive_definite(&q)
}

/// Chapter 6, last paragraph: Sylvester's criterion.
fn positive_definite(s: &Symmetric) -> bool {
    let second = s.xx * s.yy - s.xy * s.xy;
    let det = s.xx * (s.yy * s.zz - s.yz * s.yz) - s.xy * (s.xy * s.zz - s.yz * s.xz)
        + s.xz * (s.xy * s.yz - s.yy * s.xz);
    if fault::is(Fault::Size) {
        return s.xx >= 0.0 && second >= 0.0 && det >= 0.0;
    }
    s.xx > 0.0 && second > 0.0 && det > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 9 x^2 + 4 y^2 + z^2 - 18 x - 27 = 0: centre (1, 0, 0), semi-axes 2, 3 and 6.
    const AXIS_ALIGNED: [f32; 10] = [9.0, 4.0, 1.0, 0.0, 0.0, 0.0, -18.0, 0.0, 0.0, -27.0];

    fn of([a11, a22, a33, a12, a13, a23, a14, a24, a34, a44]: [f32; 10]) -> Invariants {
        invariants(&Quadric { a11, a22, a33, a12, a13, a23, a14, a24, a34, a44 })
    }

    #[test]
    fn the_invariants_of_an_axis_aligned_ellipsoid_are_those_of_its_diagonal() {
        let i = of(AXIS_ALIGNED);
        assert_eq!((i.i1, i.i2, i.i3), (14.0, 9.0 * 4.0 + 9.0 + 4.0, 36.0));
        // I4 = det [[9, -9], [-9, -27]] * 4 * 1 = (-243 - 81) * 4.
        assert_eq!(i.i4, -1296.0);
        let surface = central(&i).expect("a real ellipsoid");
        assert_eq!(surface.centre, [1.0, 0.0, 0.0]);
        let shape = Symmetric { xx: 0.25, yy: 4.0 * (1.0 / 36.0), zz: 1.0 / 36.0, ..Symmetric::default() };
        assert_eq!(surface.shape, shape);
    }

    #[test]
    fn the_invariants_of_a_full_matrix_are_its_symmetric_functions() {
        // A = [[2, 1, 0], [1, 3, 1], [0, 1, 4]]: sum of principal minors 5 + 8 + 11, determinant 18.
        let i = of([2.0, 3.0, 4.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, -1.0]);
        assert_eq!((i.i1, i.i2, i.i3, i.i4), (9.0, 24.0, 18.0, -18.0));
    }

    #[test]
    fn imaginary_ellipsoids_and_cones_are_rejected() {
        let mut imaginary = AXIS_ALIGNED;
        imaginary[9] = 27.0;
        assert_eq!(central(&of(imaginary)), Err(Rejection::NotEllipsoid));
        let cone = [1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(central(&of(cone)), Err(Rejection::NotEllipsoid));
    }

    #[test]
    fn the_limits_of_the_size_are_excluded() {
        // Semi-axes 1, 2 and 4, all powers of two.
        let shape = Symmetric { xx: 1.0, yy: 0.25, zz: 0.0625, ..Symmetric::default() };
        assert!(size_accepted(&shape, 0.9, 4.1));
        assert!(!size_accepted(&shape, 1.0, 4.1));
        assert!(!size_accepted(&shape, 0.9, 4.0));
    }
}
