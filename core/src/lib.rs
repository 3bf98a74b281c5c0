//! Finds ellipsoids in point clouds on small machines: no heap, no panics, bounded work, the same bits everywhere.
//!
//! # The way of a point
//!
//! 1. A **cloud** of [`Point3`] comes in: millimetres, camera optical frame. [`Detector::detect`] checks it once.
//! 2. [`kdtree`] arranges the live points; a **seed point** is drawn ([`rng`]) and its neighbourhood looked up.
//! 3. A **sample** of the neighbourhood is fitted ([`fit`]): local frame, 9x9 normal equations ([`linalg`]), a general
//!    [`Quadric`], its invariants, and if it is a real ellipsoid of the right size its [`CentralQuadric`].
//! 4. The **hypothesis** is scored by counting points between two scaled copies of itself ([`tebc`]); the best
//!    one so far tells how many trials are enough ([`trials`]).
//! 5. The best is **refitted** on its inliers and becomes a [`Detection`] with an [`Ellipsoid`]: centre, semi-axes and
//!    axes ([`jacobi`]), attitude. Its points leave the cloud, and the search for the next one begins.
//!
//! ```
//! use varsac_core::{Config, Detector, Point3, PointBuffer, Workspace};
//!
//! // The visible half of a jujube, 22 x 11 x 11 mm, 700 mm from the camera.
//! let mut cloud: PointBuffer<256> = PointBuffer::new();
//! for k in 0..200 {
//!     let depth = 1.0 - (k as f32 + 0.5) / 200.0; // 1 at the nearest point, 0 at the rim
//!     let (sin, cos) = (2.4 * k as f32).sin_cos();
//!     let rim = (1.0 - depth * depth).sqrt();
//!     cloud.push(Point3::new(22.0 * rim * cos, 11.0 * rim * sin, 700.0 - 11.0 * depth)).unwrap();
//! }
//!
//! let detector = Detector::new(Config::jujube()).unwrap();
//! let mut workspace = Workspace::<256>::new();
//! let fruit = detector.detect(&cloud, workspace.scratch(), 1).unwrap().next().unwrap();
//! assert!((fruit.ellipsoid.centre.z - 700.0).abs() < 0.1);
//! assert!((fruit.ellipsoid.semi_axes[0] - 22.0).abs() < 0.1);
//! ```
//!
//! # Numbers
//!
//! One scalar, `f32`; sums in a fixed order; no fused multiply-add; square roots, logarithms and arc functions from
//! `libm`. The order of every operation is written down in `core/docs/numerics.md` and held by an independent program
//! that shares no code with this crate. Equation numbers refer to the paper; `core/docs/paper.md` maps them to items.
//!
//! # Limits
//!
//! At most 65 535 points a cloud and 255 targets. A result is only as good as its view: the least squares of the paper
//! on one-sided, noisy views is weak, and its detections carry no uncertainty.
//!
//! # Features
//!
//! `serde` and `defmt` add traits to public types; `link` adds the wire protocol between a host and a co-processor that
//! runs this crate. No feature changes a bit of a result.
#![no_std]

pub mod accept;
mod config;
mod covariance;
mod detect;
mod ellipsoid;
mod field;
pub mod fit;
mod foot;
pub mod geometric;
mod hypothesis;
pub mod jacobi;
pub mod kdtree;
pub mod linalg;
#[cfg(feature = "link")]
pub mod link;
mod map;
pub mod mixture;
mod moments;
mod nuisance;
mod observe;
mod order;
mod outline;
mod paper;
pub mod point;
mod prior;
mod quadric;
mod refine;
pub mod residual;
pub mod rng;
mod size;
pub mod tebc;
pub mod trials;
mod varsac;
pub mod visibility;
mod workspace;

pub use accept::{Findings, Gate, Refusal, RefusalCode};
pub use config::{
    Config, ConfigError, MAX_REFITS, MAX_SAMPLE, MAX_SIZES, MAX_TARGETS, MAX_TRIALS, MapConfig, Method,
};
pub use covariance::{Covariance, Inflation};
pub use detect::{Detection, Detections, Detector, Finish, Status, Step};
pub use ellipsoid::Ellipsoid;
pub use field::View;
pub use fit::Constraint;
pub use map::{Finds, MAX_FRUIT};
pub use observe::{Observer, Stage};
pub use outline::{MAX_OUTLINE, OutlineRay};
pub use point::{CloudError, Point3, PointBuffer, Vector3};
pub use prior::SizePrior;
pub use quadric::{CentralQuadric, Invariants, Quadric};
pub use refine::Estimate;
pub use residual::{Noise, Viewpoint};
pub use tebc::Score;
pub use varsac::{Rejection, VarsacReport};
pub use visibility::Support;
pub use workspace::{Scratch, Workspace};

/// Version of this crate: major, minor, patch.
pub const VERSION: [u8; 3] = [
    number(env!("CARGO_PKG_VERSION_MAJOR")),
    number(env!("CARGO_PKG_VERSION_MINOR")),
    number(env!("CARGO_PKG_VERSION_PATCH")),
];

const fn number(text: &str) -> u8 {
    match u8::from_str_radix(text, 10) {
        Ok(number) => number,
        Err(_) => panic!("a part of the version is above 255"),
    }
}
