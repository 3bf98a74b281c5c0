//! How long things take, side by side: what the experiment `speed` and the benchmarks have in common.
//!
//! Times of a machine that does other things as well mean little by themselves. [`race`](mod@race) therefore lets the ways
//! of doing one thing take turns within one run, many rounds of it, and compares them round by round: what slows one
//! down slows the others too, and the ratio stays. The things themselves:
//! * [`kernels`]: scoring points against a model;
//! * [`trees`]: the neighbourhood of a point;
//! * [`searches`]: a hypothesis, a fruit, several fruit;
//! * [`frames`]: a whole frame, and its stages;
//!
//! on the data of [`workload`].

pub mod frames;
pub mod kernels;
pub mod race;
pub mod searches;
pub mod trees;
pub mod workload;

pub use race::{Contender, Lap, race};
