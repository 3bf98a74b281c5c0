//! The 9x9 solver against multi-precision: backward error in units of `u`, forward error against the condition.

use core::cell::RefCell;

use nalgebra::DMatrix;
use varsac_core::{
    Observer,
    fit::fit_observed,
    linalg::{N, Symmetric9, packed},
};
use varsac_tests::{exact, random::Dice, scene::View, statistics::Sample, tolerance as limit};

use super::{BOTH, U, noisy};

/// Backward and forward error of one solve, or `None` when the matrix is refused.
fn judged(a: &Symmetric9, b: &[f32; N]) -> Option<exact::SolveReport> {
    a.factor().and_then(|factors| exact::judge_solution(a, b, &factors.solve(b)))
}

#[test]
fn solver_on_random_positive_definite_matrices() {
    let (mut backward, mut forward, mut refused) = (Sample::default(), Sample::default(), Sample::default());
    for digits in 0..7 {
        for case in 0..60 {
            let dice = RefCell::new(Dice::new("random SPD", 1000 * digits + case));
            let normal = |_, _| dice.borrow_mut().normal();
            let q = DMatrix::from_fn(N, N, normal).qr().q();
            let d = DMatrix::from_fn(N, N, |i, j| {
                if i == j { libm::pow(10.0, -(digits as f64) * i as f64 / 8.0) } else { 0.0 }
            });
            let dense = &q * d * q.transpose();
            let mut a = Symmetric9::ZERO;
            for i in 0..N {
                for j in 0..=i {
                    a.0[packed(i, j)] = dense[(i, j)] as f32;
                }
            }
            let b = core::array::from_fn(|i| normal(i, 0) as f32);
            let report = judged(&a, &b);
            refused.push(f64::from(u8::from(report.is_none())));
            if let Some(report) = report {
                backward.push(report.backward_ulps);
                forward.push(report.forward / (report.condition * U));
            }
        }
    }
    limit::SOLVE_REFUSED.check(refused.share_above(0.5));
    limit::SOLVE_BACKWARD.check_for("random SPD", backward.max());
    limit::SOLVE_FORWARD.check_for("random SPD", forward.max());
}

/// Keeps the normal equations of a fit.
#[derive(Default)]
struct Equations(Option<(Symmetric9, [f32; N])>);

impl Observer for Equations {
    fn normal_equations(&mut self, matrix: &Symmetric9, rhs: &[f32; N]) {
        self.0 = Some((*matrix, *rhs));
    }
}

#[test]
fn solver_on_the_normal_matrices_of_samples() {
    for n in [9, 12, 32, 100] {
        let (mut backward, mut forward, mut conditions) = Default::default();
        let mut refused = 0;
        for case in 0..150 {
            let mut dice = Dice::new("normal matrices", case);
            let view = View::jujube_at(&mut dice, 600.0, &noisy(0.3));
            let sample = dice.sample(view.cloud.len(), n);
            let mut equations = Equations::default();
            let constraint = BOTH[case as usize % 2];
            let _ = fit_observed(&view.cloud, &sample, constraint, &mut equations);
            let (a, b) = equations.0.expect("a view is never degenerate before the solve");
            // The few that are not positive definite even in 320 bits (rounding of the sums) count as refused too.
            let Some(report) = judged(&a, &b) else {
                refused += 1;
                continue;
            };
            Sample::push(&mut backward, report.backward_ulps);
            Sample::push(&mut forward, report.forward / (report.condition * U));
            Sample::push(&mut conditions, report.condition);
        }
        println!("normal matrices, n = {n}: condition {}, refused {refused} of 150", conditions.summary());
        limit::SOLVE_BACKWARD.check_for(&format!("n = {n}"), backward.max());
        limit::SOLVE_FORWARD.check_for(&format!("n = {n}"), forward.max());
    }
}
