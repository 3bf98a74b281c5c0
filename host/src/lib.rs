//! The hosted side of varsac.
pub mod check;
pub mod error;
pub mod image;
