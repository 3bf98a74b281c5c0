//! Shared pieces of the tests between the parts: seeded scenes with known truth, judges in 64 bits and in
//! multi-precision, and the one table of tolerances; golden files of figures, and a bad line for the link.
//!
//! Scenes and judges compute in `f64` with `libm` (directly, or through nalgebra with `libm-force`), so that they are the
//! same on every machine. No judge shares code with the core; where one follows the core's algorithm on purpose (the
//! twin of the search) it takes from it the configuration and the stream of random integers and nothing else.

pub mod bad_line;
pub mod body;
pub mod bound;
pub mod exact;
pub mod golden;
pub mod hostile;
pub mod least_squares;
pub mod random;
pub mod scene;
pub mod simulation;
pub mod statistics;
pub mod sweeps;
pub mod tolerance;
pub mod twin;
