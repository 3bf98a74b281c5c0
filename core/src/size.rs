//! Does the view agree with the size prior, and does it tell the size at all?
//!
//! In: normal equations of the fit with the prior, and of the fit with the size set almost free. Out: a chi-squared of
//! three degrees of freedom and a relative standard deviation. With `x` the logarithms of the semi-axes, `m` and `P`
//! mean and information of the prior, `d = x - m`:
//!
//! * at the fit with the prior, `q1 = d^T P d + g'^T H'^-1 g'`, where `H' = H - P` and `g' = g - P d` are the normal
//!   equations without the prior: how much twice the cost would fall, to second order, if the prior were dropped;
//! * at the free fit, `q2 = d^T (S + P^-1)^-1 d` with `S` the covariance of `x` as the view alone tells it.
//!
//! Both are chi-squared for a fruit of the kind; each has its blind spot: at the first, points that do not fit have lost
//! their weight; the second depends on where the free fit ended. The larger counts. `1 / sqrt(1^T S^-1 1)` is the standard
//! deviation of the logarithm of the whole size: where it is large, a fruit of another size would have looked the same.

use crate::{
    jacobi::Symmetric3,
    linalg::N,
    prior::SizeTerm,
    refine::{Normal, ROTATION_INFORMATION},
};

/// What the view says about the size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SizeEvidence {
    /// The larger of `q1` and `q2`.
    pub(crate) conflict: f32,
    /// `1 / sqrt(1^T S^-1 1)`.
    pub(crate) sigma: f32,
}

/// `fitted` are the normal equations at the fit with the prior `tight`, whose logarithms are `fitted_ln`; `free` those at the
/// fit with the prior `loose`. Singular equations tell nothing about the size: infinite conflict and deviation.
// Not inlined, so that its matrices are not on the stack while others are made.
#[inline(never)]
pub(crate) fn size_evidence(
    fitted: &Normal,
    fitted_ln: &[f32; 3],
    free: &Normal,
    free_ln: &[f32; 3],
    tight: &SizeTerm,
    loose: &SizeTerm,
) -> SizeEvidence {
    let dropped = gain_without_prior(fitted, fitted_ln, tight, loose);
    let apart = departure(free, free_ln, tight);
    match (dropped, apart) {
        (Some(dropped), Some((apart, sigma))) => {
            let conflict = if dropped > apart { dropped } else { apart };
            SizeEvidence { conflict: known(conflict), sigma: known(sigma) }
        }
        _ => SizeEvidence { conflict: f32::INFINITY, sigma: f32::INFINITY },
    }
}

/// What is no number is as bad as can be; its bits would differ between machines.
fn known(value: f32) -> f32 {
    if value.is_nan() { f32::INFINITY } else { value }
}

/// `q1`; the loose prior stays, so that the equations have a solution whatever the view.
fn gain_without_prior(
    normal: &Normal,
    ln_axes: &[f32; 3],
    tight: &SizeTerm,
    loose: &SizeTerm,
) -> Option<f32> {
    let d = tight.departure(ln_axes);
    let (p, l) = (&tight.information, &loose.information);
    let (pd, ld) = (p.times(d), l.times(d));
    let mut free = *normal;
    for k in 0..3 {
        free.matrix.add_diagonal(3 + k, ROTATION_INFORMATION);
        free.gradient[6 + k] += ld[k] - pd[k];
    }
    for (i, j, value) in [
        (6, 6, l.xx - p.xx),
        (7, 6, l.xy - p.xy),
        (7, 7, l.yy - p.yy),
        (8, 6, l.xz - p.xz),
        (8, 7, l.yz - p.yz),
        (8, 8, l.zz - p.zz),
    ] {
        free.matrix.add_entry(i, j, value);
    }
    let solution = free.matrix.factor()?.solve(&free.gradient);
    let mut gain = tight.cost(ln_axes) - loose.cost(ln_axes);
    for k in 0..N {
        gain += free.gradient[k] * solution[k];
    }
    Some(gain)
}

/// `q2` and the deviation of the whole size.
fn departure(normal: &Normal, ln_axes: &[f32; 3], tight: &SizeTerm) -> Option<(f32, f32)> {
    let mut matrix = normal.matrix;
    for k in 3..6 {
        matrix.add_diagonal(k, ROTATION_INFORMATION);
    }
    let factors = matrix.factor()?;
    let column = |k: usize| {
        let mut unit = [0.0; N];
        unit[k] = 1.0;
        factors.solve(&unit)
    };
    let (a, b, c) = (column(6), column(7), column(8));
    let view = Symmetric3 { xx: a[6], yy: b[7], zz: c[8], xy: a[7], xz: a[8], yz: b[8] };
    let [ia, ib, ic] = view.adjugate().times([1.0; 3]);
    let information = ((ia + ib) + ic) / view.determinant();
    let prior = tight.information.adjugate();
    let determinant = tight.information.determinant();
    let sum = Symmetric3 {
        xx: view.xx + prior.xx / determinant,
        yy: view.yy + prior.yy / determinant,
        zz: view.zz + prior.zz / determinant,
        xy: view.xy + prior.xy / determinant,
        xz: view.xz + prior.xz / determinant,
        yz: view.yz + prior.yz / determinant,
    };
    let d = tight.departure(ln_axes);
    let g = sum.adjugate().times(d);
    let apart = (d[0] * g[0] + d[1] * g[1] + d[2] * g[2]) / sum.determinant();
    Some((apart, 1.0 / libm::sqrtf(information)))
}
