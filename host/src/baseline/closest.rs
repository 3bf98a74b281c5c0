//! The point of an ellipsoid that is closest to a given point, exactly.
//!
//! In body coordinates, first octant, semi-axes e_k, point y: the closest point is x_k = r_k y_k / (tau + q_k) with
//! r_k = (e_k / e_min)^2 and q_k = r_k - 1, where tau >= 0 is the largest root of the secular equation
//! `sum (r_k z_k / (tau + q_k))^2 = 1`, z_k = y_k / e_k.
//! Formulation: D. Eberly, Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid, 2013, with tau
//! measured from the pole, so that no digits are lost beside it. Where he bisects, we take Newton steps on the
//! reciprocal square root of the sum, which is nearly linear in tau and concave: from the left it never overshoots
//! (J. J. Moré, D. C. Sorensen, Computing a trust region step, 1983).

/// Newton steps at most. Two to six are needed; the bound is there because every loop has one.
const MAX_STEPS: u32 = 50;

/// An ellipsoid at the origin, aligned with the axes, prepared for many queries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoint {
    semi_axes: [f64; 3],
    smallest: f64,
    /// r_k.
    ratio: [f64; 3],
    /// q_k, computed so that nearly equal semi-axes lose nothing; exactly 0 for the smallest.
    excess: [f64; 3],
}

impl ClosestPoint {
    /// Prepares for semi-axes in any order; all must be positive and finite.
    pub fn new(semi_axes: [f64; 3]) -> Self {
        let smallest = semi_axes.into_iter().fold(f64::INFINITY, f64::min);
        Self {
            semi_axes,
            smallest,
            ratio: semi_axes.map(|e| (e / smallest) * (e / smallest)),
            excess: semi_axes.map(|e| (e - smallest) / smallest * ((e + smallest) / smallest)),
        }
    }

    /// The closest point to `point`, both in body coordinates. Where several are equally close (a point of the inner
    /// medial surface), one of them, on the positive side of the smallest semi-axis.
    pub fn of(&self, point: [f64; 3]) -> [f64; 3] {
        // By symmetry the first octant is enough; the signs come back at the end.
        let y = point.map(f64::abs);
        let numerator: [f64; 3] = std::array::from_fn(|k| self.ratio[k] * (y[k] / self.semi_axes[k]));
        // Each term alone bounds the root from below.
        let lowest = (0..3).map(|k| numerator[k] - self.excess[k]).fold(0.0, f64::max);
        let octant = if lowest == 0.0 && self.sum_at(0.0, &numerator).0 <= 1.0 {
            self.across_the_flat_side(&numerator)
        } else {
            let tau = self.root(lowest, &numerator);
            std::array::from_fn(|k| self.ratio[k] * y[k] / (tau + self.excess[k]))
        };
        std::array::from_fn(|k| octant[k].copysign(point[k]))
    }

    /// Sum of the squared terms of the secular equation, and minus half its derivative. Terms 0 / 0 are absent ones.
    #[inline]
    fn sum_at(&self, tau: f64, numerator: &[f64; 3]) -> (f64, f64) {
        let (mut sum, mut slope) = (0.0, 0.0);
        for k in 0..3 {
            if numerator[k] > 0.0 {
                let reciprocal = 1.0 / (tau + self.excess[k]);
                let term = numerator[k] * reciprocal;
                sum += term * term;
                slope += term * term * reciprocal;
            }
        }
        (sum, slope)
    }

    /// The largest root, from a starting value at or below it.
    fn root(&self, lowest: f64, numerator: &[f64; 3]) -> f64 {
        // A point on the smallest semi-axes' plane may start on the pole of another, equal one: step off it.
        let mut tau = lowest.max(f64::MIN_POSITIVE);
        for _ in 0..MAX_STEPS {
            let (sum, slope) = self.sum_at(tau, numerator);
            let next = tau + (sum.sqrt() - 1.0) * sum / slope;
            // Rounding ends the climb (and NaN, from a point that is not finite, ends it at once).
            let climbs = next > tau * (1.0 + 2.0 * f64::EPSILON);
            if !climbs {
                break;
            }
            tau = next;
        }
        tau
    }

    /// The point lies in the plane across the smallest semi-axis, so deep inside that the closest surface is above or
    /// below the plane: tau = 0, and the component along the smallest semi-axis takes what is left of 1.
    fn across_the_flat_side(&self, numerator: &[f64; 3]) -> [f64; 3] {
        let mut unit = [0.0; 3];
        let mut left: f64 = 1.0;
        for k in 0..3 {
            if numerator[k] > 0.0 {
                unit[k] = numerator[k] / self.excess[k];
                left -= unit[k] * unit[k];
            }
        }
        let flat = (0..3).rev().find(|&k| self.semi_axes[k] == self.smallest).unwrap_or(2);
        unit[flat] = left.max(0.0).sqrt();
        std::array::from_fn(|k| unit[k] * self.semi_axes[k])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use varsac_core::rng::Stream;

    fn distance(p: [f64; 3], q: [f64; 3]) -> f64 {
        ((p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2) + (p[2] - q[2]).powi(2)).sqrt()
    }

    fn uniform(stream: &mut Stream) -> f64 {
        f64::from(stream.below(2_000_001)) / 1e6 - 1.0
    }

    /// On the surface, and the offset is along the normal there.
    fn check(semi: [f64; 3], point: [f64; 3]) {
        let x = ClosestPoint::new(semi).of(point);
        let level: f64 = (0..3).map(|k| (x[k] / semi[k]).powi(2)).sum();
        assert!((level - 1.0).abs() < 1e-9, "{semi:?} {point:?} -> {x:?}: level {level}");
        let normal: [f64; 3] = std::array::from_fn(|k| x[k] / (semi[k] * semi[k]));
        let offset: [f64; 3] = std::array::from_fn(|k| point[k] - x[k]);
        let cross = crate::eval::cross(normal, offset);
        let bound = 1e-9 * crate::eval::norm(normal) * (crate::eval::norm(offset) + semi[0]);
        assert!(crate::eval::norm(cross) < bound, "{semi:?} {point:?} -> {x:?}: {cross:?}");
    }

    #[test]
    fn known_points() {
        let ball = ClosestPoint::new([2.0; 3]);
        assert_eq!(ball.of([0.0, 0.0, 5.0]), [0.0, 0.0, 2.0]);
        assert_eq!(ball.of([0.0; 3]), [0.0, 0.0, 2.0]);
        let e = ClosestPoint::new([3.0, 2.0, 1.0]);
        assert_eq!(e.of([-7.0, 0.0, 0.0]), [-3.0, 0.0, 0.0]);
        assert_eq!(e.of([0.0, 0.0, -0.25]), [0.0, 0.0, -1.0]);
        assert_eq!(e.of([0.0; 3]), [0.0, 0.0, 1.0]);
        // In the plane across c, inside: by hand x = a^2 y / (a^2 - c^2) = 9 / 8 for y = (1, 0, 0).
        let x = e.of([1.0, 0.0, 0.0]);
        assert!((x[0] - 1.125).abs() < 1e-12 && (x[2] - (1.0 - 0.375_f64.powi(2)).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn the_offset_is_normal_to_the_surface_everywhere() {
        let mut stream = Stream::new(11);
        for semi in
            [[22.0, 11.0, 11.0], [3.0, 2.0, 1.0], [40.0, 40.0, 4.0], [1.0; 3], [10.0, 10.0 - 1e-9, 1e-2]]
        {
            for scale in [1e-6, 0.1, 1.0, 30.0] {
                for _ in 0..500 {
                    let point: [f64; 3] =
                        std::array::from_fn(|k| 2.0 * scale * semi[k] * uniform(&mut stream));
                    check(semi, point);
                    check(semi, [point[0], point[1], 0.0]);
                    check(semi, [point[0], 0.0, point[2] * 1e-12]);
                }
            }
        }
    }

    #[test]
    fn no_sampled_surface_point_is_closer() {
        let semi = [22.0, 12.0, 9.0];
        let closest = ClosestPoint::new(semi);
        let mut stream = Stream::new(5);
        for _ in 0..200 {
            let point: [f64; 3] = std::array::from_fn(|k| 1.3 * semi[k] * uniform(&mut stream));
            let best = distance(point, closest.of(point));
            for _ in 0..500 {
                let direction: [f64; 3] = std::array::from_fn(|_| uniform(&mut stream));
                let length = crate::eval::norm(direction);
                let surface: [f64; 3] = std::array::from_fn(|k| semi[k] * direction[k] / length);
                assert!(length == 0.0 || distance(point, surface) >= best - 1e-9);
            }
        }
    }

    #[test]
    fn nonsense_ends() {
        let _ = ClosestPoint::new([3.0, 2.0, 1.0]).of([f64::NAN, f64::INFINITY, 0.0]);
    }
}
