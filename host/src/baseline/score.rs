//! The distance-and-normal score of the RANSAC baseline: is a point an inlier of an ellipsoid?
//!
//! Yes, when it lies nearer to the surface than a limit, and its local normal and the surface's at the closest point
//! agree up to sign. The normal is looked at only where the distance holds.

use super::closest::ClosestPoint;
use crate::eval::{EllipsoidF64, dot, norm, subtract};

/// The distance-and-normal test against one ellipsoid.
#[derive(Debug, Clone)]
pub struct Score<'a> {
    ellipsoid: &'a EllipsoidF64,
    closest: ClosestPoint,
    distance_mm: f64,
    normal_cosine: f64,
    inverse_squares: [f64; 3],
}

impl<'a> Score<'a> {
    /// The test against an ellipsoid: points nearer than `distance_mm` whose normal has a cosine above `normal_cosine`.
    pub fn new(ellipsoid: &'a EllipsoidF64, distance_mm: f64, normal_cosine: f64) -> Self {
        let semi_axes = ellipsoid.semi_axes_mm;
        Self {
            ellipsoid,
            closest: ClosestPoint::new(semi_axes),
            distance_mm,
            normal_cosine,
            inverse_squares: semi_axes.map(|e| 1.0 / (e * e)),
        }
    }

    /// Whether a point, with its unit normal (any sign; zero for none), is an inlier.
    pub fn is_inlier(&self, point: [f64; 3], normal: [f64; 3]) -> bool {
        let body = self.ellipsoid.to_body(point);
        // The point lies on the ellipsoid scaled by n. Scaling moves no surface point by less than c |n - 1|, so that
        // is a bound from below on the distance; it settles most outliers without the closest point.
        let scale = dot(body, std::array::from_fn(|k| body[k] * self.inverse_squares[k])).sqrt();
        if self.ellipsoid.semi_axes_mm[2] * (scale - 1.0).abs() > self.distance_mm * (1.0 + 1e-9) {
            return false;
        }
        let on_surface = self.closest.of(body);
        if norm(subtract(body, on_surface)) >= self.distance_mm {
            return false;
        }
        let gradient: [f64; 3] = std::array::from_fn(|k| on_surface[k] * self.inverse_squares[k]);
        let normal_in_body = self.ellipsoid.axes.map(|axis| dot(axis, normal));
        dot(gradient, normal_in_body).abs() > self.normal_cosine * norm(gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_and_normal_must_both_hold() {
        let upright = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let e =
            EllipsoidF64 { centre_mm: [0.0, 0.0, 700.0], semi_axes_mm: [22.0, 11.0, 10.0], axes: upright };
        let score = Score::new(&e, 1.5, 0.8);
        let towards = [0.0, 0.0, -1.0];
        for (z, expected) in [(690.0, true), (688.6, true), (688.5, false), (691.4, true), (691.6, false)] {
            assert_eq!(score.is_inlier([0.0, 0.0, z], towards), expected, "z {z}");
        }
        // cos 36 and 38 degrees are .809 and .788; the sign of a normal means nothing, no normal is no inlier.
        let tilted = |deg: f64| [libm::sin(deg.to_radians()), 0.0, libm::cos(deg.to_radians())];
        for (normal, expected) in
            [(tilted(36.0), true), (tilted(38.0), false), (tilted(180.0), true), ([0.0; 3], false)]
        {
            assert_eq!(score.is_inlier([0.0, 0.0, 690.0], normal), expected, "{normal:?}");
        }
    }
}
