//! What the view alone says about the size, and how much it disagrees with the prior: contract, chapter M19.

use super::algebra::{Lower, adj, damped, det, dot, entrywise, product};
use super::model::Estimate;
use super::normal::Normal;
use super::prior::Prior;
use crate::Symmetric;
use crate::fault::{self, Fault};
use crate::fit::solve;

/// `conflict` and `size_sigma`.
#[derive(Clone, Copy)]
pub(crate) struct SizeEvidence {
    pub(crate) conflict: f32,
    pub(crate) sigma: f32,
}

/// M19: of a fruit (with `H1`) and of its free fit (with `H2`).
pub(crate) fn size_evidence(
    fruit: (&Estimate, &Normal),
    free: (&Estimate, &Normal),
    tight: &Prior,
    loose: &Prior,
) -> SizeEvidence {
    let both = released(fruit.0, fruit.1, tight, loose).zip(of_the_view(free.0, free.1, tight));
    let Some((q1, (q2, info))) = both else {
        return SizeEvidence { conflict: f32::INFINITY, sigma: f32::INFINITY };
    };
    SizeEvidence { conflict: known(if q1 > q2 { q1 } else { q2 }), sigma: known(1.0 / libm::sqrtf(info)) }
}

/// M19, last sentence.
fn known(value: f32) -> f32 {
    if value.is_nan() { f32::INFINITY } else { value }
}

/// `q1`: what the cost falls by when the tight prior is exchanged for the loose one.
fn released(estimate: &Estimate, normal: &Normal, tight: &Prior, loose: &Prior) -> Option<f32> {
    let d = tight.departure(estimate.x);
    let (pd, ld) = (product(&tight.information, d), product(&loose.information, d));
    let mut matrix: Lower = normal.matrix;
    let mut g = normal.gradient;
    for k in 0..3 {
        g[6 + k] += ld[k] - pd[k];
    }
    let more = entrywise(&loose.information, &tight.information, |l, p| l - p);
    for (i, j, value) in
        [(6, 6, more.xx), (7, 6, more.xy), (7, 7, more.yy), (8, 6, more.xz), (8, 7, more.yz), (8, 8, more.zz)]
    {
        matrix[i][j] += value;
    }
    let y = solve(&damped(&matrix)?, &g);
    let mut q1 = tight.cost(estimate.x) - loose.cost(estimate.x);
    for i in 0..9 {
        q1 += g[i] * y[i];
    }
    Some(q1)
}

/// `q2` and `info`: the size that the view alone tells against the tight prior, and how well it tells it.
fn of_the_view(free: &Estimate, normal: &Normal, tight: &Prior) -> Option<(f32, f32)> {
    let factors = damped(&normal.matrix)?;
    let column = |k: usize| {
        let mut e = [0.0; 9];
        e[k] = 1.0;
        solve(&factors, &e)
    };
    let (a, b, c) = (column(6), column(7), column(8));
    let s = Symmetric { xx: a[6], yy: b[7], zz: c[8], xy: a[7], xz: a[8], yz: b[8] };
    let [i1, i2, i3] = product(&adj(&s), [1.0; 3]);
    let info = ((i1 + i2) + i3) / det(&s);
    let det_p = det(&tight.information);
    let v = entrywise(&s, &adj(&tight.information), |s, p| {
        if fault::is(Fault::SizeEvidence) { s + p * (1.0 / det_p) } else { s + p / det_p }
    });
    let d = tight.departure(free.x);
    let g = product(&adj(&v), d);
    Some((dot(d, g) / det(&v), info))
}
