//! The hosted side of varsac.
pub mod error;
pub mod image;
pub mod outline;
pub mod synth;
