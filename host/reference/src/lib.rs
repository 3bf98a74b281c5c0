//! The float reference: a second, independent program written from the numeric contract (`numerics.md`,
//! `numerics-map.md` and `numerics-mixture.md` in `core/docs`, version 2) and from nothing else.
//!
//! It is naive on purpose. Vectors are fresh, matrices are full, every search is a linear scan, and each function
//! is one paragraph of the contract, named in its comment. It does not depend on `varsac-core`; the two programs
//! share `libm` and the published algorithm of the generator. Where they disagree in a single bit, one of them does
//! not do what the contract says.
//!
//! From a cloud to its fruit, one file a chapter: [`Stream`] (3) draws a seed point, [`neighbourhood`] (4) lists
//! the points around it, [`fit`] (5) turns a sample into a [`Central`] surface, [`size_accepted`] (6) compares it
//! with what is known of the fruit, [`shell_contains`] (7) counts its support, [`trials`] (8) says how long to go
//! on, [`search_target`] (9) is the loop of Algorithm 1, [`run`] (10) takes fruit after fruit out of the cloud, and
//! [`ellipsoid_of`] (11) says how each one lies. [`trace`] is `run` with every intermediate result as an [`Event`].
//!
//! The default search has chapters of its own, M1 to M22: [`run_map`] and [`trace_map`], in the folder `map`. So has
//! the search without a size prior, X1 to X12, with the single fit, G1: [`run_mixture`] and [`fit_single`], in the folder
//! `mixture`.

mod cloud;
mod config;
mod digest;
mod ellipsoid;
mod event;
mod fault;
mod fit;
mod jacobi;
mod map;
mod mixture;
mod neighbourhood;
mod quadric;
mod search;
mod shell;
mod stream;
mod targets;
mod trials;

pub use cloud::{CloudError, Point, check_cloud};
pub use config::{Config, Constraint};
pub use digest::{Fnv1a, digest};
pub use ellipsoid::{Ellipsoid, ellipsoid_of};
pub use event::{Event, Phase, Rejection};
#[cfg(feature = "faults")]
pub use fault::{Fault, inject};
pub use fit::{fit, fit_observed};
pub use jacobi::{Eigen, ascending, eigen};
pub use map::{
    Estimate, Findings, Gate, Inflation, MapConfig, MapDetection, MapRun, Noise, OutlineRay, Refusal,
    RefusalCode, Support, View, Viewpoint, check_view, run_map, trace_map,
};
pub use mixture::{
    Criterion, MixtureConfig, MixtureDetection, MixtureGate, MixtureRun, Single, fit_single, run_mixture,
    trace_mixture,
};
pub use neighbourhood::{live_points, neighbourhood, seed_point};
pub use quadric::{Central, Symmetric, size_accepted};
pub use search::{Rejections, Report, search_target};
pub use shell::{Score, score, shell_contains};
pub use stream::Stream;
pub use targets::{Detection, Finish, Run, run, trace};
pub use trials::trials;
