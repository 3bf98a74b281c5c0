//! How good is a result? Truth against fit, the paper's criteria (section III) and the ones a user asks for.
//!
//! Everything here is a pure function of its arguments, in `f64`: millimetres (or the unit of a unitless cloud),
//! radians inside, degrees only where the name says so. Read on in [`attitude`] (angles of an attitude, error of an
//! axis), [`criteria`] (model score, RMS-s, RMS-c, RMS-a), [`matching`] (which detection is which fruit) and
//! [`statistics`] (quantiles and root mean squares).

pub mod attitude;
pub mod criteria;
pub mod matching;
pub mod statistics;

use nalgebra::{Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};
use varsac_core::{CentralQuadric, Ellipsoid, jacobi::Symmetric3};

/// An ellipsoid in double precision: ground truth, or the result of a baseline.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct EllipsoidF64 {
    /// Centre, millimetres, camera optical frame.
    pub centre_mm: [f64; 3],
    /// Semi-axes a >= b >= c, millimetres.
    pub semi_axes_mm: [f64; 3],
    /// Rows are the unit vectors of the semi-axes, in their order, right-handed.
    pub axes: [[f64; 3]; 3],
}

impl EllipsoidF64 {
    /// From semi-axes in any order: sorts them, largest first (equal ones keep their order), and makes the axes
    /// right-handed by the sign of the third. The axes must be orthonormal.
    pub fn sorted(centre_mm: [f64; 3], semi_axes_mm: [f64; 3], axes: [[f64; 3]; 3]) -> Self {
        let mut order = [0, 1, 2];
        order.sort_by(|&i: &usize, &j: &usize| semi_axes_mm[j].total_cmp(&semi_axes_mm[i]));
        let mut axes = order.map(|k| axes[k]);
        if dot(cross(axes[0], axes[1]), axes[2]) < 0.0 {
            axes[2] = axes[2].map(|component| -component);
        }
        Self { centre_mm, semi_axes_mm: order.map(|k| semi_axes_mm[k]), axes }
    }

    /// [`Self::sorted`] with the axes as the rows of a matrix.
    pub fn of_matrix(centre_mm: Vector3<f64>, semi_axes_mm: [f64; 3], axes: Matrix3<f64>) -> Self {
        let row = |k| axes.row(k).transpose().into();
        Self::sorted(centre_mm.into(), semi_axes_mm, [row(0), row(1), row(2)])
    }

    /// Level of a point: the factor by which the ellipsoid must be scaled to pass through it; 1 on the surface.
    pub fn level(&self, point_mm: &Point3<f64>) -> f64 {
        self.on_unit_sphere(point_mm).norm()
    }

    /// Distance of a point from the surface to first order, `|level - 1| / |gradient of level|`, negative inside,
    /// millimetres. Good to a few percent for points nearer than half the smallest semi-axis.
    pub fn distance_mm(&self, point_mm: &Point3<f64>) -> f64 {
        let body = self.on_unit_sphere(point_mm);
        let level = body.norm();
        // The centre has no gradient; it is the smallest semi-axis away.
        let gradient = body.component_div(&Vector3::from(self.semi_axes_mm)).norm() / level;
        if level > 0.0 { (level - 1.0) / gradient } else { -self.semi_axes_mm[2] }
    }

    /// Body coordinates divided by the semi-axes: the ellipsoid becomes the unit sphere.
    fn on_unit_sphere(&self, point_mm: &Point3<f64>) -> Vector3<f64> {
        let [x, y, z] = self.to_body((*point_mm).into());
        let [a, b, c] = self.semi_axes_mm;
        Vector3::new(x / a, y / b, z / c)
    }

    /// Coordinates of a point along the three axes, from the centre.
    #[inline]
    pub fn to_body(&self, point_mm: [f64; 3]) -> [f64; 3] {
        let offset = subtract(point_mm, self.centre_mm);
        self.axes.map(|axis| dot(axis, offset))
    }

    /// The point whose coordinates along the three axes are given: the inverse of [`Self::to_body`].
    #[inline]
    pub fn from_body(&self, body_mm: [f64; 3]) -> [f64; 3] {
        let [p, q, r] = self.axes;
        std::array::from_fn(|k| {
            self.centre_mm[k] + (p[k] * body_mm[0] + q[k] * body_mm[1] + r[k] * body_mm[2])
        })
    }
}

impl From<&Ellipsoid> for EllipsoidF64 {
    /// The same numbers, widened.
    fn from(ellipsoid: &Ellipsoid) -> Self {
        let centre = ellipsoid.centre;
        Self {
            centre_mm: [centre.x, centre.y, centre.z].map(f64::from),
            semi_axes_mm: ellipsoid.semi_axes.map(f64::from),
            axes: ellipsoid.axes.map(|axis| axis.map(f64::from)),
        }
    }
}

impl From<&EllipsoidF64> for Ellipsoid {
    /// The same numbers, rounded.
    fn from(ellipsoid: &EllipsoidF64) -> Self {
        let [x, y, z] = ellipsoid.centre_mm.map(|value| value as f32);
        Self {
            centre: varsac_core::Point3::new(x, y, z),
            semi_axes: ellipsoid.semi_axes_mm.map(|value| value as f32),
            axes: ellipsoid.axes.map(|axis| axis.map(|value| value as f32)),
        }
    }
}

impl From<&EllipsoidF64> for CentralQuadric {
    /// Centre and shape, rounded: `(p - c)^T S (p - c) = 1` with `S` the sum of `axis axis^T / semi_axis^2`.
    fn from(ellipsoid: &EllipsoidF64) -> Self {
        let entry = |i: usize, j: usize| {
            let terms = ellipsoid.axes.iter().zip(ellipsoid.semi_axes_mm);
            terms.map(|(axis, length)| axis[i] * axis[j] / (length * length)).sum::<f64>() as f32
        };
        let shape = Symmetric3 {
            xx: entry(0, 0),
            yy: entry(1, 1),
            zz: entry(2, 2),
            xy: entry(0, 1),
            xz: entry(0, 2),
            yz: entry(1, 2),
        };
        Self { centre: Ellipsoid::from(ellipsoid).centre, shape }
    }
}

#[inline]
pub(crate) fn dot(p: [f64; 3], q: [f64; 3]) -> f64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

#[inline]
pub(crate) fn cross(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

#[inline]
pub(crate) fn subtract(p: [f64; 3], q: [f64; 3]) -> [f64; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline]
pub(crate) fn norm(p: [f64; 3]) -> f64 {
    dot(p, p).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_signed_millimetres() {
        let truth =
            EllipsoidF64::of_matrix(Vector3::new(0.0, 0.0, 700.0), [22.0, 11.0, 11.0], Matrix3::identity());
        for (point, expected) in [
            (Point3::new(24.0, 0.0, 700.0), 2.0),
            (Point3::new(0.0, 0.0, 688.0), 1.0),
            (Point3::new(0.0, 10.0, 700.0), -1.0),
            (Point3::new(0.0, 0.0, 700.0), -11.0),
        ] {
            assert!((truth.distance_mm(&point) - expected).abs() < 1e-9, "{point}");
        }
    }

    #[test]
    fn the_central_form_is_the_square_of_the_level() {
        let axes = attitude::axes_of_angles([0.3, -0.4, 2.0]);
        let e = EllipsoidF64::sorted([1.0, -2.0, 7.0], [3.0, 2.0, 1.0], axes);
        let central = CentralQuadric::from(&e);
        for [x, y, z] in [[1.0, 0.0, 6.0], [4.0, -2.0, 7.5], [0.0, 0.5, 8.0]] {
            let level = e.level(&Point3::new(x, y, z));
            let value = central.value(&varsac_core::Point3::new(x as f32, y as f32, z as f32));
            assert!((f64::from(value) / (level * level) - 1.0).abs() < 1e-5, "{value} {level}");
        }
    }

    #[test]
    fn semi_axes_are_sorted_and_their_axes_follow_right_handed() {
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let e = EllipsoidF64::sorted([0.0; 3], [1.0, 2.0, 3.0], identity);
        assert_eq!(e.semi_axes_mm, [3.0, 2.0, 1.0]);
        assert_eq!(e.axes, [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]);
    }

    #[test]
    fn body_coordinates_go_there_and_back() {
        let axes = attitude::axes_of_angles([0.3, -0.4, 2.0]);
        let e = EllipsoidF64::sorted([10.0, -20.0, 700.0], [22.0, 12.0, 11.0], axes);
        let tip = e.from_body([22.0, 0.0, 0.0]);
        assert!((norm(subtract(tip, e.centre_mm)) - 22.0).abs() < 1e-12);
        let body = e.to_body(tip);
        assert!((body[0] - 22.0).abs() < 1e-12 && body[1].abs() < 1e-12 && body[2].abs() < 1e-12);
    }
}
