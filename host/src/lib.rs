//! The hosted side of varsac.
pub mod backproject;
pub mod error;
pub mod image;
pub mod kinect;
pub mod segment;
pub mod synth;
