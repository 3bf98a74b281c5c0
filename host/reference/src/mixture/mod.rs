//! The search without a size prior, and the fit of a single ellipsoid: one file for each chapter X1 to X12 and G1 of
//! `core/docs/numerics-mixture.md`.
//!
//! [`run_mixture`] (X12) searches a view for body after body. A search measures its points in a `frame` of their own (X3),
//! follows a `blob` (X4) from each of several `starts` (X8) to a `shell` (X5) with noise and share of its own, improves it
//! by `climb` (X7) on what a `look` (X6) at the points says, chooses the best (`candidates`, X9), judges it (`findings`,
//! X10) and takes it back to the cloud (X11). [`fit_single`] (G1) fits one ellipsoid to points that all lie on it.

mod area;
mod blob;
mod candidates;
mod cells;
mod climb;
mod config;
mod findings;
mod foot;
mod frame;
mod look;
mod moments;
mod numbers;
mod run;
mod shell;
mod single;
mod starts;

pub use config::{MixtureConfig, MixtureGate};
pub use run::{MixtureDetection, MixtureRun, run_mixture, trace_mixture};
pub use single::{Criterion, Single, fit_single};
