//! Experiments on one-sided views: a method is given what a depth camera saw of a fruit, and is held to the truth.
//!
//! * [`methods`]: the default search with and without outlines, the paper's, RANSAC, direct least squares; asked alike.
//! * [`measure`](mod@measure): scenes in, for each method and scene an [`Outcome`]: errors, verdict, findings, time.
//! * [`coverage`]: how far out in its own covariance the truth lies.
//! * [`summary`]: quantiles, acceptance and errors of many outcomes: a row of a table.
//! * The experiments: `one_sided`, `outline`, `decoys`, `calibration`, `touching`.
//!
//! How the criteria are read:
//! * of a scene the *subject* counts, the fruit in its middle; of what a method found, accepted or not, the detection
//!   nearest to it. A subject without any counts as an infinite error in quantiles;
//! * RMS-c and RMS-s are the paper's (mean absolute value of three components, root mean square over fruit), over the
//!   subjects whose centre is within [`WRONG_MM`]: one fruit mistaken for a leaf would drown all others. What
//!   share these are stands beside them; the same holds for the RMS of the long axis;
//! * an accepted detection is *wrong* when no true fruit, seen or not, has its centre within [`WRONG_MM`], and
//!   *far* when none has it within its own short semi-axis;
//! * a method without a gate (the paper's, RANSAC, direct) accepts whatever it finds.

mod calibration;
pub mod coverage;
mod decoys;
mod gates;
mod listing;
pub mod measure;
pub mod methods;
mod one_sided;
mod outline;
mod scenery;
pub mod summary;
mod touching;

pub use measure::{Case, Outcome, measure};
pub use methods::Method;
pub use summary::Summary;
pub use touching::{Bunches, bunches};

use super::Experiment;

/// A centre further off than this is a wrong answer, mm: half of a jujube's thickness.
pub const WRONG_MM: f64 = 5.0;

/// The entries of the registry.
pub(super) const ONE_SIDED: Experiment = one_sided::EXPERIMENT;
pub(super) const OUTLINE: Experiment = outline::EXPERIMENT;
pub(super) const DECOYS: Experiment = decoys::EXPERIMENT;
pub(super) const CALIBRATION: Experiment = calibration::EXPERIMENT;
pub(super) const TOUCHING: Experiment = touching::EXPERIMENT;
