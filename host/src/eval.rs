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

use varsac_core::Ellipsoid;

/// An ellipsoid in double precision: ground truth, or the result of a baseline.
#[derive(Debug, Clone, Copy, PartialEq)]
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
