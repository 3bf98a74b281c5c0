//! Finds ellipsoids in point clouds on small machines: no heap, no panics, bounded work, the same bits everywhere.
//!
//! # The way of a point
//!
//! 1. A **view** comes in: a cloud of [`Point3`] (millimetres, camera optical frame), how many of them lie in the mask, rays along
//!    the outline ([`OutlineRay`]), the pitch of the pixels ([`View`]). [`Detector::detect_view`] checks it once.
//! 2. One of three searches runs, as [`Config::method`] says; each in bounded steps ([`Detections::step`]).
//! 3. A **detection** goes out: [`Ellipsoid`], [`Covariance`], accepted or refused with a reason ([`accept`]).
//!
//! **The default search** ([`Method::Map`]): fruit of about known size seen from one side.
//! A *hypothesis* is a ridge fit of eight points around a seed point, moved to the size of the [`SizePrior`] by a few steps along the viewing
//! rays ([`residual`]); its *support* is what it explains less what is seen through it ([`visibility`]). The best few are *refined*
//! by normal equations made from moments on the unit sphere, with outline rays, a common displacement of theirs and the boxiness of the
//! fruit estimated along and eliminated; the *noise* is estimated from the residuals; fruit near each other are refitted *jointly*;
//! each is *judged* by what its size prior costs, its covariance, its outline and its surroundings.
//!
//! **The search without a size** ([`Method::Mixture`]): whole surfaces, or one view of anything ellipsoidal. A mixture of a thin shell
//! and uniform clutter is climbed from several starts with a shrinking scale; the likeliest is refined on all points by orthogonal distance.
//! [`geometric`] fits one ellipsoid to points that are all good.
//!
//! **The paper's search** ([`Method::Varsac`], Algorithm 1): a seed point ([`rng`]) and its neighbourhood ([`kdtree`]); a sample, fitted by least
//! squares in a local frame ([`fit`], 9x9 normal equations, [`linalg`]); a [`Quadric`], its invariants, its [`CentralQuadric`]; counted between
//! two scaled copies ([`tebc`]); the best one so far tells how many [`trials`] are enough, and is refitted on its inliers. Axes by [`jacobi`].
//!
//! ```
//! use varsac_core::{Config, Detector, Point3, PointBuffer, Status, Workspace};
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
//! assert_eq!(fruit.status, Status::Accepted);
//! assert!((fruit.ellipsoid.centre.z - 700.0).abs() < 0.5);
//! assert!((fruit.ellipsoid.semi_axes[0] - 22.0).abs() < 0.5);
//! assert!(fruit.covariance.unwrap().sigma_centre_mm()[2] < 1.0);
//! ```
//!
//! # Numbers
//!
//! One scalar, `f32`; sums in a fixed order; no fused multiply-add; square roots, logarithms and arc functions from
//! `libm`. The order of every operation is written down in `core/docs/numerics*.md` and held by an independent program
//! that shares no code with this crate. Equation numbers refer to the paper; `core/docs/paper.md` maps them to items.
//!
//! # Limits
//!
//! At most 65 535 points a cloud and 255 targets, 32 of the default search. A result is only as good as its view: the default search
//! needs the size to about 10 %, and the least squares of the paper on one-sided, noisy views is weak and tells no uncertainty.
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
pub use config::{Config, ConfigError, MAX_REFITS, MAX_SAMPLE, MAX_SIZES, MAX_TARGETS, MAX_TRIALS, Method};
pub use covariance::{Covariance, Inflation};
pub use detect::{Detection, Detections, Detector, Finish, Status, Step};
pub use ellipsoid::Ellipsoid;
pub use field::View;
pub use fit::Constraint;
pub use map::{Finds, MAX_FRUIT, MapConfig};
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
