//! The point of an ellipsoid that is closest to a given one: contract, chapters X5 and X5.1.

use crate::Point;
use crate::fault::{self, Fault};
use crate::map::algebra::{Vector, dot, minus};
use crate::map::contact::Contact;
use crate::map::model::Model;

/// X5: the contact of a point by its distance from the surface.
pub(crate) fn orthogonal(model: &Model, p: Point) -> Contact {
    let w = model.times(minus(p, model.centre));
    let (u, t) = foot(w, squares(model));
    let g = model.grad2(u);
    Contact { u, e: w, miss: dot(w, w), value: t * g, variance: model.lateral * g, gap_mm: 0.0 }
}

/// X5: `k`, the squares of the inverse semi-axes.
pub(crate) fn squares(model: &Model) -> Vector {
    model.inverse.map(|i| i * i)
}

/// X5.1: `u` and `t` of a point `w`, both in coordinates of the unit sphere.
fn foot(w: Vector, k: Vector) -> (Vector, f32) {
    let mut lowest = f32::NEG_INFINITY;
    for i in 0..3 {
        let c = (libm::fabsf(w[i]) - 1.0) / k[i];
        if c > lowest {
            lowest = c;
        }
    }
    let q = dot(w, w);
    let size = libm::sqrtf(q);
    let slope = dot(w, [w[0] * k[0], w[1] * k[1], w[2] * k[2]]);
    let mut t = ((size - 1.0) * q) / slope;
    let mut time = if fault::is(Fault::Foot) { 2 } else { 1 };
    loop {
        t = if t > lowest { t } else { lowest };
        let mut u = [0.0; 3];
        let mut sum = 0.0;
        for i in 0..3 {
            let h = 1.0 + t * k[i];
            let v = 1.0 / if h > 1e-6 { h } else { 1e-6 };
            u[i] = w[i] * v;
            sum += (u[i] * u[i]) * (k[i] * v);
        }
        let s = dot(u, u);
        let l = libm::sqrtf(s);
        let x = l - 1.0;
        let far = libm::fabsf(x) > 1e-6;
        if !far || time == 6 {
            let inv = 1.0 / l;
            return ([u[0] * inv, u[1] * inv, u[2] * inv], t);
        }
        t += (s * x) / sum;
        time += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_foot_of_a_point_beyond_a_pole_is_the_pole() {
        let (u, t) = foot([0.0, 3.0, 0.0], [1.0, 0.25, 4.0]);
        assert_eq!(u, [0.0, 1.0, 0.0]);
        // The point is 2 * 3 = 6 away from the centre, 4 from the surface: 4 = t * |gradient| = t * (1 / 2).
        assert!((t - 8.0).abs() < 1e-5);
    }

    #[test]
    fn from_the_foot_to_the_point_is_the_normal() {
        let (semi_axes, p): ([f32; 3], [f32; 3]) = ([3.0, 2.0, 1.0], [2.0, 1.5, 1.25]);
        let w = [p[0] / 3.0, p[1] / 2.0, p[2]];
        let (u, t) = foot(w, [1.0 / 9.0, 0.25, 1.0]);
        assert!((dot(u, u) - 1.0).abs() < 1e-6);
        for i in 0..3 {
            let normal = u[i] / semi_axes[i];
            assert!((p[i] - u[i] * semi_axes[i] - t * normal).abs() < 1e-5);
        }
    }

    #[test]
    fn the_centre_has_no_foot() {
        assert!(foot([0.0; 3], [1.0, 1.0, 1.0]).0[0].is_nan());
    }
}
