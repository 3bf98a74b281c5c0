//! Synthetic data with known truth: the paper's simulation, and rendered Kinect v2 frames of fruit on a branch.
//!
//! ```text
//! SimulationOptions -> simulation -> points + truth
//! SceneOptions -> scene (fruit, branches, leaves) -> render: the colour camera sees shade's colours,
//!                                                    the depth camera sees sensor's measurements -> frame + truth
//! ```
//!
//! The same seed gives the same bits on every machine. Unit: millimetres; frame: depth camera, x right, y down,
//! z forward.

mod foliage;
pub mod fruit;
mod leaves;
pub mod noise;
pub mod render;
pub mod scene;
mod sensor;
mod shade;
mod shape;
mod sight;
pub mod simulation;
mod tiles;

pub use fruit::FruitKind;
pub use render::{KinectFrame, KinectRig, RegisteredFrame, TrueFruit, render_depth_patch, render_kinect};
pub use scene::{Scene, SceneOptions};
pub use sensor::SensorOptions;
pub use simulation::{Simulation, SimulationOptions, simulate};

use nalgebra::{Matrix3, Point3, Vector3};
use serde::{Deserialize, Serialize};

/// An ellipsoid that is known exactly.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TrueEllipsoid {
    /// Centre, millimetres.
    pub centre_mm: [f64; 3],
    /// Semi-axes a >= b >= c, millimetres.
    pub semi_axes_mm: [f64; 3],
    /// Unit vectors of the semi-axes, one a row, in their order; right-handed.
    pub axes: [[f64; 3]; 3],
}

impl TrueEllipsoid {
    /// Sorts the semi-axes, largest first; `axes` has their unit vectors as rows, in the order given.
    pub fn new(centre_mm: Vector3<f64>, semi_axes_mm: [f64; 3], axes: Matrix3<f64>) -> Self {
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| semi_axes_mm[j].total_cmp(&semi_axes_mm[i]));
        let row = |k: usize| axes.row(order[k]).transpose();
        let (first, second) = (row(0), row(1));
        // Of an odd permutation the last axis turns round.
        let third = first.cross(&second);
        Self {
            centre_mm: centre_mm.into(),
            semi_axes_mm: order.map(|k| semi_axes_mm[k]),
            axes: [first.into(), second.into(), third.into()],
        }
    }

    /// Level of a point: the factor by which the ellipsoid must be scaled to pass through it; 1 on the surface.
    pub fn level(&self, point_mm: &Point3<f64>) -> f64 {
        self.body_coordinates(point_mm).norm()
    }

    /// Distance of a point from the surface to first order, |level - 1| / |gradient of level|, negative inside,
    /// millimetres. Good to a few percent for points nearer than half the smallest semi-axis.
    pub fn distance_mm(&self, point_mm: &Point3<f64>) -> f64 {
        let body = self.body_coordinates(point_mm);
        let level = body.norm();
        // The centre has no gradient; it is the smallest semi-axis away.
        let gradient = body.component_div(&Vector3::from(self.semi_axes_mm)).norm() / level;
        if level > 0.0 { (level - 1.0) / gradient } else { -self.semi_axes_mm[2] }
    }

    /// D^-1 A (p - c): the ellipsoid becomes the unit sphere.
    fn body_coordinates(&self, point_mm: &Point3<f64>) -> Vector3<f64> {
        let offset = point_mm.coords - Vector3::from(self.centre_mm);
        let along = |k: usize| Vector3::from(self.axes[k]).dot(&offset) / self.semi_axes_mm[k];
        Vector3::new(along(0), along(1), along(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_sorted_with_their_lengths_and_stay_right_handed() {
        let truth = TrueEllipsoid::new(Vector3::zeros(), [1.0, 3.0, 2.0], Matrix3::identity());
        assert_eq!(truth.semi_axes_mm, [3.0, 2.0, 1.0]);
        assert_eq!(truth.axes, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
        let odd = TrueEllipsoid::new(Vector3::zeros(), [2.0, 3.0, 1.0], Matrix3::identity());
        assert_eq!(odd.axes, [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]]);
    }

    #[test]
    fn distances_are_signed_millimetres() {
        let truth =
            TrueEllipsoid::new(Vector3::new(0.0, 0.0, 700.0), [22.0, 11.0, 11.0], Matrix3::identity());
        for (point, expected) in [
            (Point3::new(24.0, 0.0, 700.0), 2.0),
            (Point3::new(0.0, 0.0, 688.0), 1.0),
            (Point3::new(0.0, 10.0, 700.0), -1.0),
            (Point3::new(0.0, 0.0, 700.0), -11.0),
        ] {
            assert!((truth.distance_mm(&point) - expected).abs() < 1e-9, "{point}");
        }
    }
}
