//! The hosted side of varsac: reads what a depth camera saw, finds fruit in it with `varsac-core`, and shows it.
//!
//! # The way of a frame
//!
//! 1. [`frame`] reads a folder with colour, depth and calibration; [`cloud`] reads point clouds; [`synth`] renders
//!    scenes whose truth is known.
//! 2. [`segment`] finds the regions of fruit colour; [`kinect`] maps the pixels of one camera to those of the other.
//! 3. [`region_view`] turns the depth pixels of each region, and of what surrounds it, into points ([`backproject`]) and finds the rays
//!    along its [`outline`]; [`decimate`] thins clouds that exceed the capacity.
//! 4. [`locate`] searches each region with the core, or with a [`baseline`] to compare with.
//! 5. [`report`] prints tables and JSON, [`picture`] and [`draw`] make pictures, [`ply_out`] writes coloured clouds,
//!    [`eval`] holds results against the truth.
//!
//! [`check`] holds the core bit for bit against the float reference, which shares no code with it.
//! [`experiment`] repeats the paper's experiments and ours, with tables and figures.
//! [`simulate`] has a co-processor do step 4: a thread, an emulated board, or a real one on a serial port.
//! [`speed`] races the ways of doing a thing against each other; [`wide`] runs loops in the widest registers there are.
//! [`cli`] is the command `varsac`; [`demo`] does all of the above on a rendered Kinect v2 pair.
//!
//! Millimetres and the depth camera's optical frame (x right, y down, z forward) everywhere; errors are
//! [`error::InputError`], one sentence each.

pub mod backproject;
pub mod baseline;
pub mod check;
pub mod cli;
pub mod cloud;
pub mod decimate;
pub mod demo;
pub mod digest;
pub mod draw;
pub mod error;
pub mod eval;
pub mod experiment;
pub mod file;
pub mod frame;
pub mod fruit;
pub mod image;
pub mod kinect;
pub mod locate;
pub mod outline;
pub mod picture;
pub mod ply_out;
pub mod region_view;
pub mod report;
pub mod segment;
pub mod similarity;
pub mod simulate;
pub mod speed;
pub mod synth;
pub mod wide;

#[cfg(test)]
mod testing;
