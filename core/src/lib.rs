//! varsac-core.
#![no_std]
pub mod jacobi;
pub mod linalg;
#[cfg(feature = "link")]
pub mod link;
pub mod point;
pub mod rng;

pub use point::{Point3, PointBuffer, Vector3};
