//! The default search, one file for each thing that the chapters M1 to M22 of `core/docs/numerics-map.md` define.
//!
//! [`run_map`] (M3) searches a [`View`] (M2) for fruit after fruit. A search draws samples and makes an [`Estimate`] (M4)
//! of each (`hypothesis`, M11), holds it against points (`contact`, M5 and M6) and outline rays (`evidence`, M7), counts
//! what speaks for it (`support`, M8), and improves the best by steps (M10) along their normal equations (M9): first
//! several `candidates` (M12), then one `fruit` (M13) with the noise that it shows (M14). When all are found, neighbours
//! are refitted beside each other (`neighbours`, M16 and M17), and each fruit is judged (M18 to M21).

pub(crate) mod accept;
pub(crate) mod algebra;
mod candidates;
pub(crate) mod contact;
pub(crate) mod covariance;
pub(crate) mod evidence;
mod fruit;
mod hypothesis;
pub(crate) mod judge;
pub(crate) mod model;
mod neighbours;
mod noise;
pub(crate) mod normal;
mod prior;
pub(crate) mod run;
mod size_evidence;
pub(crate) mod step;
mod support;
pub(crate) mod view;

pub use accept::{Findings, Refusal, RefusalCode};
pub use judge::MapDetection;
pub use model::Estimate;
pub use run::{MapRun, check_view, run_map, trace_map};
pub use support::Support;
pub use view::{Gate, Inflation, MapConfig, Noise, OutlineRay, View, Viewpoint};
