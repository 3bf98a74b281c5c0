//! One step of a shell uphill: the nine parameters by Gauss and Newton, the scale and the share by expectation.

use crate::{
    linalg::N,
    mixture::{
        MixtureConfig,
        shell::{Pass, Shell, largest, smallest},
    },
    refine::{Estimate, Normal, ROTATION_INFORMATION},
};

/// Limits of the share of the surface.
pub(crate) const SHARE: (f32, f32) = (0.02, 0.99);
/// Limits of the logarithms of the semi-axes (.01 and 6 local units), and of that of their ratio (30).
const LN_AXES: (f32, f32) = (-4.605_170_2, 1.791_759_5);
const LN_ASPECT: f32 = 3.401_197_4;
/// Largest scale over the smallest semi-axis: a shell as thick as its body is a blob.
const THICKEST: f32 = 0.7;
/// Part of the diagonal that is added to it: directions that nothing determines stay where they are.
const DAMPING: f32 = 1e-4;
/// Longest move of the centre over the longest semi-axis.
const CENTRE_LIMIT: f32 = 0.5;

/// Limits of the scale in one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    pub(crate) least: f32,
    pub(crate) most: f32,
}

/// The normal equations with the terms of area and shape.
pub(crate) fn terms(pass: &Pass, estimate: &Estimate, config: &MixtureConfig, area_weight: f32) -> Normal {
    let mut normal = pass.normal(estimate, area_weight);
    let precision = 1.0 / (config.shape_spread * config.shape_spread);
    if precision > 0.0 {
        add_shape(&mut normal, &estimate.ln_axes, precision);
    }
    normal
}

/// `1/2 precision sum_k (x_k - mean x)^2`, `x` the logarithms of the semi-axes.
fn add_shape(normal: &mut Normal, x: &[f32; 3], precision: f32) {
    let mean = (x[0] + x[1] + x[2]) / 3.0;
    let (diagonal, other) = (precision * (2.0 / 3.0), precision / 3.0);
    for k in 0..3 {
        normal.gradient[6 + k] += precision * (x[k] - mean);
        normal.matrix.add_diagonal(6 + k, diagonal);
    }
    for (i, j) in [(7, 6), (8, 6), (8, 7)] {
        normal.matrix.add_entry(i, j, -other);
    }
}

/// The shell after a step over `count` points, and the gain the step promises; `None` where the equations are singular.
pub(crate) fn climb(
    shell: &Shell,
    normal: &Normal,
    pass: &Pass,
    count: usize,
    scale: Scale,
) -> Option<(Shell, f32)> {
    let mut matrix = normal.matrix;
    for k in 3..6 {
        matrix.add_diagonal(k, ROTATION_INFORMATION);
    }
    for k in 0..N {
        let d = matrix.diagonal(k);
        matrix.add_diagonal(k, DAMPING * d);
    }
    let step = matrix.factor()?.solve(&normal.gradient).map(|x| -x);
    let mut promise = 0.0;
    for k in 0..N {
        promise -= step[k] * normal.gradient[k];
    }
    let longest = largest(&shell.estimate.ln_axes);
    let mut estimate = shell.estimate.moved_by(&step, CENTRE_LIMIT * longest)?;
    hold(&mut estimate);
    let thickest = THICKEST * smallest(&estimate.ln_axes);
    let most = if thickest < scale.most { thickest } else { scale.most };
    let sigma = within(shell.sigma * libm::sqrtf(pass.squares / pass.members), (scale.least, most));
    let share = within(pass.members / count as f32, SHARE);
    Some((Shell { estimate, sigma, share }, promise))
}

/// Keeps the semi-axes within their limits.
pub(crate) fn hold(estimate: &mut Estimate) {
    let [a, b, c] = estimate.ln_axes;
    let longest = if a > b && a > c {
        a
    } else if b > c {
        b
    } else {
        c
    };
    let longest = if longest < LN_AXES.1 { longest } else { LN_AXES.1 };
    let bound = longest - LN_ASPECT;
    let least = if bound > LN_AXES.0 { bound } else { LN_AXES.0 };
    estimate.ln_axes = estimate.ln_axes.map(|x| within(x, (least, LN_AXES.1)));
}

/// Within the limits; the lower one where they cross.
pub(crate) fn within(x: f32, (least, most): (f32, f32)) -> f32 {
    let x = if x > most { most } else { x };
    // NaN becomes the lower limit.
    if x > least { x } else { least }
}

/// Where a shell is and how large: enough to tell whether it has been met before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    centre: [f32; 3],
    ln_axes: [f32; 3],
}

impl Place {
    pub(crate) fn of(estimate: &Estimate) -> Self {
        Self { centre: estimate.centre, ln_axes: estimate.ln_axes }
    }
}

/// Two places of one body: centres within this part of the smallest semi-axis, and the logarithms of their volumes.
pub(crate) fn is_same(a: &Place, b: &Place, part: f32) -> bool {
    let d = [a.centre[0] - b.centre[0], a.centre[1] - b.centre[1], a.centre[2] - b.centre[2]];
    let apart = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    let near = part * smallest(&a.ln_axes);
    let size = |e: &Place| e.ln_axes[0] + e.ln_axes[1] + e.ln_axes[2];
    apart < near * near && libm::fabsf(size(a) - size(b)) < part
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_needle_is_held_to_its_limits() {
        let mut estimate = Estimate {
            centre: [0.0; 3],
            axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            ln_axes: [9.0, -9.0, 0.0],
            boxiness: 0.0,
        };
        hold(&mut estimate);
        let [a, b, c] = estimate.ln_axes.map(libm::expf);
        assert!((a - 6.0).abs() < 1e-5 && (c - 1.0).abs() < 1e-5, "{a} {c}");
        assert!((b - 0.2).abs() < 1e-6, "{b}");
    }

    #[test]
    fn crossed_limits_and_nan_give_the_lower_one() {
        assert_eq!(within(5.0, (2.0, 1.0)), 2.0);
        assert_eq!(within(f32::NAN, (2.0, 3.0)), 2.0);
        assert_eq!(within(2.5, (2.0, 3.0)), 2.5);
    }
}
