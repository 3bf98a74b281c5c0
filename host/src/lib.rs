//! The hosted side of varsac.
pub mod baseline;
pub mod draw;
pub mod error;
pub mod eval;
pub mod image;
pub mod ply_out;
pub mod similarity;
