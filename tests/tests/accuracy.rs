//! The second judge: the core against known truth, 64-bit and multi-precision oracles. Limits and their reasons stand
//! in `varsac_tests::tolerance`; `--nocapture` prints every figure beside its limit.

#[path = "accuracy/eigen.rs"]
mod eigen;
#[path = "accuracy/fits.rs"]
mod fits;
#[path = "accuracy/scalars.rs"]
mod scalars;
#[path = "accuracy/scores.rs"]
mod scores;
#[path = "accuracy/search.rs"]
mod search;
#[path = "accuracy/solver.rs"]
mod solver;

use varsac_core::Constraint;
use varsac_tests::scene::Trouble;

/// Unit roundoff of `f32`.
const U: f64 = 1.0 / 16_777_216.0;

const BOTH: [Constraint; 2] = [Constraint::A11, Constraint::Trace];

fn noisy(axial_noise_mm: f64) -> Trouble {
    Trouble { axial_noise_mm, ..Trouble::default() }
}
