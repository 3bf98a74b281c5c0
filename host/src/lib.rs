//! The hosted side of varsac.
pub mod baseline;
pub mod error;
pub mod eval;
pub mod image;
pub mod similarity;
