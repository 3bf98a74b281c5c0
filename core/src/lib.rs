//! varsac-core.
#![no_std]
pub mod jacobi;
pub mod linalg;
pub mod point;
pub mod rng;

pub use point::{Point3, PointBuffer, Vector3};
