//! Quadric surfaces: the general equation, its invariants, and the central form of an ellipsoid.
//!
//! General equation, Eq. (3):
//! `0 = a11 x^2 + a22 y^2 + a33 z^2 + a14 x + a24 y + a34 z + a44 + a12 xy + a13 xz + a23 yz`
//! (the mixed and linear coefficients are not halved, as in the paper).
//!
//! Central form: `(p - centre)^T S (p - centre) = 1` with `S` positive definite, the form that scoring works on.

use crate::{Point3, jacobi::Symmetric3};

/// Coefficients of the general equation, Eq. (3).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[allow(missing_docs, reason = "the names are the coefficients of Eq. (3)")]
pub struct Quadric {
    pub a11: f32,
    pub a22: f32,
    pub a33: f32,
    pub a12: f32,
    pub a13: f32,
    pub a23: f32,
    pub a14: f32,
    pub a24: f32,
    pub a34: f32,
    pub a44: f32,
}

/// Invariants of a quadric under rotation and translation, Eq. (6)-(9).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Invariants {
    /// Trace of the quadratic part, Eq. (6).
    pub i1: f32,
    /// Sum of its principal 2x2 minors, Eq. (7).
    pub i2: f32,
    /// Its determinant, Eq. (8).
    pub i3: f32,
    /// Determinant of the full 4x4 form, Eq. (9).
    pub i4: f32,
}

impl Invariants {
    /// True for a real ellipsoid: `I1, I2, I3 > 0` and `I4 < 0`.
    ///
    /// The paper asks for the first three only; they also hold for imaginary ellipsoids (`x^2 + y^2 + z^2 + 1 = 0`),
    /// which the sign of `I4` tells apart. NaN makes it false.
    #[inline]
    pub fn is_real_ellipsoid(&self) -> bool {
        self.i1 > 0.0 && self.i2 > 0.0 && self.i3 > 0.0 && self.i4 < 0.0
    }
}

impl Quadric {
    /// Quadratic part `A`, the 3x3 matrix of Eq. (10).
    #[inline]
    pub fn quadratic_part(&self) -> Symmetric3 {
        Symmetric3 {
            xx: self.a11,
            yy: self.a22,
            zz: self.a33,
            xy: 0.5 * self.a12,
            xz: 0.5 * self.a13,
            yz: 0.5 * self.a23,
        }
    }

    /// Half of the linear part, `b` of `x^T A x + 2 b^T x + a44 = 0`.
    #[inline]
    pub fn half_linear_part(&self) -> [f32; 3] {
        [0.5 * self.a14, 0.5 * self.a24, 0.5 * self.a34]
    }

    /// `I1..I4`, Eq. (6)-(9), from the adjugate: `I3 = a11 C11 + a12/2 C12 + a13/2 C13`, and by expanding Eq. (9)
    /// along its border `I4 = a44 I3 - b^T adj(A) b`. About 60 flops.
    #[inline]
    pub fn invariants(&self) -> Invariants {
        self.invariants_and_adjugate_times_b().0
    }

    #[inline]
    fn invariants_and_adjugate_times_b(&self) -> (Invariants, [f32; 3]) {
        let a = self.quadratic_part();
        let b = self.half_linear_part();
        let adjugate = a.adjugate();
        let g = adjugate.times(b);
        let i1 = a.xx + a.yy + a.zz;
        let i2 = adjugate.zz + adjugate.yy + adjugate.xx;
        let i3 = a.xx * adjugate.xx + a.xy * adjugate.xy + a.xz * adjugate.xz;
        let i4 = self.a44 * i3 - (b[0] * g[0] + b[1] * g[1] + b[2] * g[2]);
        (Invariants { i1, i2, i3, i4 }, g)
    }

    /// The central form of a real ellipsoid: centre by Eq. (10), `x = -adj(A) b / I3`, and
    /// `S = A / (-I4 / I3)`. `None` when the invariants say it is no real ellipsoid.
    #[inline]
    pub fn central(&self) -> Option<CentralQuadric> {
        let (invariants, g) = self.invariants_and_adjugate_times_b();
        if !invariants.is_real_ellipsoid() {
            return None;
        }
        let a = self.quadratic_part();
        // Eq. (12): the constant term in the frame of the centre is I4 / I3.
        let scale = -(invariants.i3 / invariants.i4);
        let central = CentralQuadric {
            centre: Point3::new(-(g[0] / invariants.i3), -(g[1] / invariants.i3), -(g[2] / invariants.i3)),
            shape: Symmetric3 {
                xx: a.xx * scale,
                yy: a.yy * scale,
                zz: a.zz * scale,
                xy: a.xy * scale,
                xz: a.xz * scale,
                yz: a.yz * scale,
            },
        };
        central.is_finite().then_some(central)
    }

    /// Left-hand side of Eq. (3): the error `e` of Eq. (5) when `a11 = 1`.
    #[inline]
    pub fn value(&self, p: &Point3) -> f32 {
        let [gx, gy, gz] = self.quadratic_part().times([p.x, p.y, p.z]);
        let [bx, by, bz] = self.half_linear_part();
        (p.x * (gx + 2.0 * bx) + p.y * (gy + 2.0 * by) + p.z * (gz + 2.0 * bz)) + self.a44
    }
}

/// An ellipsoid as `(p - centre)^T shape (p - centre) = 1`: nine numbers, unique, no square roots.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CentralQuadric {
    /// Centre, in the frame and unit of the cloud.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub centre: Point3,
    /// `S`, eigenvalues `1 / semi-axis^2`.
    pub shape: Symmetric3,
}

impl CentralQuadric {
    /// `f(p) = (p - c)^T S (p - c)`: 1 on the surface, `s^2` on the surface scaled by `s` (Eq. 26). 20 flops:
    /// `f = dx (sxx dx + 2 sxy dy + 2 sxz dz) + dy (syy dy + 2 syz dz) + szz dz dz`, summed from the left.
    #[inline(always)]
    pub fn value(&self, p: &Point3) -> f32 {
        let s = &self.shape;
        let (dx, dy, dz) = (p.x - self.centre.x, p.y - self.centre.y, p.z - self.centre.z);
        let x = s.xx * dx + (2.0 * s.xy) * dy + (2.0 * s.xz) * dz;
        let y = s.yy * dy + (2.0 * s.yz) * dz;
        dx * x + dy * y + (s.zz * dz) * dz
    }

    /// True when all semi-axes lie strictly between the limits, by two Sylvester tests and no eigenvalues:
    /// `S - I / max^2` and `I / min^2 - S` are positive definite. About 40 flops.
    #[inline]
    pub fn semi_axes_within(&self, min: f32, max: f32) -> bool {
        let s = &self.shape;
        let (low, high) = (1.0 / (max * max), 1.0 / (min * min));
        let not_too_long = Symmetric3 { xx: s.xx - low, yy: s.yy - low, zz: s.zz - low, ..*s };
        let not_too_short =
            Symmetric3 { xx: high - s.xx, yy: high - s.yy, zz: high - s.zz, xy: -s.xy, xz: -s.xz, yz: -s.yz };
        not_too_long.is_positive_definite() && not_too_short.is_positive_definite()
    }

    fn is_finite(&self) -> bool {
        let (c, s) = (&self.centre, &self.shape);
        [c.x, c.y, c.z, s.xx, s.yy, s.zz, s.xy, s.xz, s.yz].into_iter().all(f32::is_finite)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// x^2/9 + y^2/4 + z^2 = 1 moved to (1, 2, 3) and multiplied by 36.
    fn example() -> Quadric {
        Quadric {
            a11: 4.0,
            a22: 9.0,
            a33: 36.0,
            a12: 0.0,
            a13: 0.0,
            a23: 0.0,
            a14: -8.0,
            a24: -36.0,
            a34: -216.0,
            a44: 4.0 + 36.0 + 324.0 - 36.0,
        }
    }

    #[test]
    fn invariants_of_an_axis_aligned_ellipsoid() {
        let i = example().invariants();
        assert_eq!((i.i1, i.i2, i.i3), (49.0, 36.0 + 144.0 + 324.0, 1296.0));
        assert_eq!(i.i4, -36.0 * 1296.0);
        assert!(i.is_real_ellipsoid());
    }

    #[test]
    fn the_central_form_has_centre_and_size() {
        let c = example().central().unwrap();
        assert_eq!(c.centre, Point3::new(1.0, 2.0, 3.0));
        assert!((c.shape.xx - 1.0 / 9.0).abs() < 1e-7);
        assert!((c.shape.zz - 1.0).abs() < 1e-7);
        assert!(c.semi_axes_within(0.99, 3.01));
        assert!(!c.semi_axes_within(1.01, 3.01));
        assert!(!c.semi_axes_within(0.99, 2.99));
        assert!((c.value(&Point3::new(4.0, 2.0, 3.0)) - 1.0).abs() < 1e-6);
        assert!((c.value(&Point3::new(1.0, 2.0, 3.5)) - 0.25).abs() < 1e-6);
    }

    #[test]
    fn what_is_not_a_real_ellipsoid_has_no_central_form() {
        let imaginary = Quadric { a44: 1000.0, ..example() };
        assert!(imaginary.invariants().i3 > 0.0);
        assert!(imaginary.central().is_none());
        let hyperboloid = Quadric { a33: -36.0, ..example() };
        assert!(hyperboloid.central().is_none());
        let cylinder = Quadric { a33: 0.0, a34: 0.0, ..example() };
        assert!(cylinder.central().is_none());
        assert!(Quadric { a12: f32::NAN, ..example() }.central().is_none());
    }

    #[test]
    fn the_general_equation_vanishes_on_the_surface() {
        assert_eq!(example().value(&Point3::new(4.0, 2.0, 3.0)), 0.0);
        assert_eq!(example().value(&Point3::new(1.0, 2.0, 3.0)), -36.0);
    }
}
