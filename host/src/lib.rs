//! The hosted side of varsac.
pub mod baseline;
pub mod cloud;
pub mod decimate;
pub mod draw;
pub mod error;
pub mod eval;
pub mod file;
pub mod frame;
pub mod image;
pub mod kinect;
pub mod ply_out;
pub mod similarity;
pub mod simulate;

#[cfg(test)]
mod testing;
