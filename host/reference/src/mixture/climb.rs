//! One step of a shell uphill: contract, chapter X7.

use super::look::Pass;
use super::numbers::{longest, smallest, within};
use super::shell::{Shell, held};
use crate::fault::{self, Fault};
use crate::fit::{factor, solve};
use crate::map::step::moved;

/// A shell after a step, and what the step promised to gain.
pub(crate) struct Climb {
    pub(crate) shell: Shell,
    pub(crate) promise: f32,
}

/// X7: with limits of the scale; none where there is no climb.
pub(crate) fn climb(shell: &Shell, pass: &Pass, least: f32, most: f32) -> Option<Climb> {
    let mut matrix = pass.normal.matrix;
    for k in 3..6 {
        matrix[k][k] += 1.216;
    }
    for k in 0..9 {
        matrix[k][k] += if fault::is(Fault::Climb) { 0.0 } else { 1e-4 * matrix[k][k] };
    }
    let solution = solve(&factor(&matrix).ok()?, &pass.normal.gradient);
    let d = solution.map(|component| -component);
    if !d.iter().all(|component| component.is_finite()) {
        return None;
    }
    let estimate = held(&moved(&shell.estimate, &d, 0.5 * longest(shell.estimate.x)));
    let t = 0.7 * smallest(estimate.x);
    let m = if t < most { t } else { most };
    let sigma = within(shell.sigma * libm::sqrtf(pass.squares / pass.members), least, m);
    let share = within(pass.members / pass.points as f32, 0.02, 0.99);
    Some(Climb { shell: Shell { estimate, sigma, share }, promise: promise(&d, &pass.normal.gradient) })
}

/// X7: the promise of a step.
pub(crate) fn promise(d: &[f32; 9], gradient: &[f32; 9]) -> f32 {
    let mut promise = 0.0;
    for i in 0..9 {
        promise -= d[i] * gradient[i];
    }
    promise
}
