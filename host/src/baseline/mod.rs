//! What a user could pick instead: the paper's comparison method, implemented honestly.
//!
//! [`ransac()`] is RANSAC with nine points and the distance-and-normal score, in `f64` throughout; all it has from the
//! core is the random stream. Normals are computed once a cloud ([`normals`], on the exact nearest neighbours of
//! [`neighbours`]), the closest point on the ellipsoid is exact ([`closest`]), and every shortcut leaves the result as
//! it is.
//! Direct least squares on all points needs no code of its own: it is the core's fit on the whole cloud.

pub mod closest;
pub mod fit;
pub mod neighbours;
pub mod normals;
pub mod ransac;
pub mod score;

pub use ransac::{BaselineTarget, RansacOptions, ransac};
