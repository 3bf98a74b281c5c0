//! The hosted side of varsac.
pub mod cloud;
pub mod decimate;
pub mod error;
pub mod file;
pub mod frame;
pub mod image;
pub mod kinect;

#[cfg(test)]
mod testing;
