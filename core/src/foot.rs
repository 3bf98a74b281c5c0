//! The point of an ellipsoid nearest to a given point.
//!
//! In unit-sphere coordinates (`w` of the point, `u` of its foot, `k_i` one over the square of the i-th semi-axis) the line
//! from the foot to the point is along the gradient: `w_i = u_i (1 + t k_i)`, and `|u(t)| = 1` determines `t`; the distance
//! is `t |D^-1 u|`, negative inside. `1 / |u(t)|` is nearly linear in `t`, so Newton's method on `1 / |u(t)| - 1` (More
//! and Sorensen 1983) converges in two to four steps from `t = F / |g|^2` of the radial projection:
//! `t += S (sqrt(S) - 1) / Q`, `S = sum u_i^2`, `Q = sum u_i^2 k_i / (1 + t k_i)`. The root is never below
//! `t_0 = max_i (|w_i| - 1) / k_i`, where one of the `u_i` is 1: steps that overshoot end there.

use crate::residual::dot;

/// The nearest point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Foot {
    /// Unit-sphere coordinates.
    pub(crate) u: [f32; 3],
    /// Distance over length of the gradient at the foot, signed.
    pub(crate) t: f32,
}

/// Newton steps at most.
pub(crate) const MAX_STEPS: u32 = 6;
/// `|sqrt(S) - 1|` below this is rounding.
const CLOSE: f32 = 1e-6;
/// `1 + t k_i` is at least this.
const SMALLEST: f32 = 1e-6;

/// Foot of the point with unit-sphere coordinates `w`; `k` as above. At most [`MAX_STEPS`] steps of three divisions, two
/// more and a square root.
#[inline]
pub(crate) fn foot(w: [f32; 3], k: [f32; 3]) -> Foot {
    let mut lowest = f32::NEG_INFINITY;
    for i in 0..3 {
        let t = (libm::fabsf(w[i]) - 1.0) / k[i];
        lowest = if t > lowest { t } else { lowest };
    }
    let square = dot(w, w);
    let size = libm::sqrtf(square);
    // F / |g|^2 with g at w / |w|.
    let slope = dot(w, [w[0] * k[0], w[1] * k[1], w[2] * k[2]]);
    let mut t = ((size - 1.0) * square) / slope;
    let mut step = 0;
    loop {
        // NaN (a point at the centre) starts at the lowest.
        t = if t > lowest { t } else { lowest };
        let mut u = w;
        let mut q = 0.0;
        for i in 0..3 {
            let stretch = 1.0 + t * k[i];
            let inverse = 1.0 / if stretch > SMALLEST { stretch } else { SMALLEST };
            u[i] = w[i] * inverse;
            q += (u[i] * u[i]) * (k[i] * inverse);
        }
        let s = dot(u, u);
        let length = libm::sqrtf(s);
        let excess = length - 1.0;
        step += 1;
        // NaN ends it too.
        let open = libm::fabsf(excess) > CLOSE;
        if !open || step >= MAX_STEPS {
            let scale = 1.0 / length;
            return Foot { u: u.map(|x| x * scale), t };
        }
        t += (s * excess) / q;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(foot: &Foot, k: [f32; 3]) -> f32 {
        let g: f32 = (0..3).map(|i| foot.u[i] * foot.u[i] * k[i]).sum();
        foot.t * g.sqrt()
    }

    #[test]
    fn points_put_at_a_distance_have_it() {
        let axes = [3.0_f32, 1.0, 0.3];
        let k = axes.map(|a| 1.0 / (a * a));
        let mut stream = crate::rng::Stream::new(9);
        let mut draw = || stream.below(20_001) as f32 / 10_000.0 - 1.0;
        for case in 0..4000 {
            let v = [draw(), draw(), draw()];
            let size = dot(v, v).sqrt();
            let u = v.map(|x| x / size);
            let g: [f32; 3] = core::array::from_fn(|i| u[i] / axes[i]);
            let n = dot(g, g).sqrt();
            // Inside not beyond the smallest radius of curvature, c^2 / a.
            let d = if case % 2 == 0 { 0.8 * draw().abs() } else { -0.028 * draw().abs() };
            let w: [f32; 3] = core::array::from_fn(|i| (axes[i] * u[i] + d * g[i] / n) / axes[i]);
            let foot = foot(w, k);
            assert!((distance(&foot, k) - d).abs() < 3e-5, "case {case}: {d} {foot:?}");
        }
    }

    #[test]
    fn the_centre_is_the_short_semi_axis_away() {
        let k = [1.0 / 9.0, 1.0, 4.0];
        let foot = foot([0.0, 0.0, 1e-7], k);
        assert!((distance(&foot, k) + 0.5).abs() < 1e-3, "{foot:?}");
        let at_centre = super::foot([0.0; 3], k);
        assert!(at_centre.t.is_finite());
    }
}
