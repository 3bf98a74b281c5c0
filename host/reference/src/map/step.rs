//! One step of an estimate along its normal equations: contract, chapter M10.

use super::algebra::{Vector, cross, damped, dot};
use super::model::Estimate;
use super::normal::Normal;
use crate::fault::{self, Fault};
use crate::fit::solve;

/// M10: the estimate after a step; none where there is no step.
pub(crate) fn step(estimate: &Estimate, normal: &Normal) -> Option<Estimate> {
    let solution = solve(&damped(&normal.matrix)?, &normal.gradient);
    let mut d = [0.0; 9];
    for i in 0..9 {
        d[i] = -solution[i];
        if !d[i].is_finite() {
            return None;
        }
    }
    let follower = &normal.follower;
    let mut q = follower.gradient;
    for i in 0..9 {
        q += follower.b[i] * d[i];
    }
    let boxiness = estimate.boxiness + (-(q * follower.inverse));
    Some(Estimate { boxiness, ..moved(estimate, &d, 0.5 * libm::expf(estimate.x[2])) })
}

/// M10: the estimate moved by `d`, its centre by no more than `limit`; the boxiness stays.
pub(crate) fn moved(estimate: &Estimate, d: &[f32; 9], limit: f32) -> Estimate {
    let axes = &estimate.axes;
    let v = limited([d[0], d[1], d[2]], limit);
    let mut centre = estimate.centre;
    for i in 0..3 {
        centre[i] = if fault::is(Fault::Step) {
            centre[i] + v[0] * axes[0][i] + v[1] * axes[1][i] + v[2] * axes[2][i]
        } else {
            centre[i] + (v[0] * axes[0][i] + v[1] * axes[1][i] + v[2] * axes[2][i])
        };
    }
    let z = limited([d[6], d[7], d[8]], 0.3);
    let x = [estimate.x[0] + z[0], estimate.x[1] + z[1], estimate.x[2] + z[2]];
    Estimate { centre, axes: turned(axes, limited([d[3], d[4], d[5]], 0.5)), x, ..*estimate }
}

/// M10: `limited(v, limit)`.
fn limited(v: Vector, limit: f32) -> Vector {
    let q = dot(v, v);
    if q > limit * limit {
        let f = limit / libm::sqrtf(q);
        return [v[0] * f, v[1] * f, v[2] * f];
    }
    v
}

/// M10: the axes turned by `r`, column by column.
fn turned(axes: &[[f32; 3]; 3], r: Vector) -> [[f32; 3]; 3] {
    let w = [0.5 * r[0], 0.5 * r[1], 0.5 * r[2]];
    let f = 2.0 / (1.0 + dot(w, w));
    let mut turned = *axes;
    for j in 0..3 {
        let y = [axes[0][j], axes[1][j], axes[2][j]];
        let o = cross(w, y);
        let t = cross(w, o);
        for i in 0..3 {
            turned[i][j] = y[i] + f * (o[i] + t[i]);
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vector_is_shortened_to_its_limit_and_not_turned() {
        assert_eq!(limited([0.0, 3.0, 4.0], 5.0), [0.0, 3.0, 4.0]);
        assert_eq!(limited([0.0, 3.0, 4.0], 2.5), [0.0, 1.5, 2.0]);
    }

    #[test]
    fn turned_axes_stay_unit_vectors_at_right_angles() {
        let axes = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
        let [a, b, c] = turned(&axes, [0.3, -0.2, 0.1]);
        for (v, w, expected) in [(a, a, 1.0), (b, b, 1.0), (c, c, 1.0), (a, b, 0.0), (b, c, 0.0), (a, c, 0.0)]
        {
            assert!((dot(v, w) - expected).abs() < 1e-6);
        }
    }
}
