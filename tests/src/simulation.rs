//! The paper's simulation: semi-axes 1, 2, 3 about (1, 1, 1), turned by 1.05 rad about z, and random points around it.
//!
//! The paper leaves open how many points there are, how large the error is and where the random points lie. Here: the
//! number and the error are the caller's, the error is a normal deviate on each coordinate, points on the surface are
//! uniform by area, and the random ones are uniform in a cube of side 8 about the centre, after the others in the cloud.

use nalgebra::{Matrix3, Rotation3, Vector3};
use varsac_core::{Ellipsoid, Point3};

use crate::{
    body::{Body, axis_angle_deg, long_axis, narrow, wide},
    random::Dice,
};

/// The ellipsoid of the simulation: 1, 2 and 3 along its own x, y and z.
pub fn body() -> Body {
    let axes: Matrix3<f64> = Rotation3::from_axis_angle(&Vector3::z_axis(), 1.05).into_inner();
    Body { centre: Vector3::new(1.0, 1.0, 1.0), semi_axes: Vector3::new(1.0, 2.0, 3.0), axes }
}

/// `points` points of which `outlier_share` are random ones, with normal errors of deviation `sigma`.
pub fn cloud(dice: &mut Dice, points: usize, sigma: f64, outlier_share: f64) -> Vec<Point3> {
    let body = body();
    let outliers = libm::round(points as f64 * outlier_share) as usize;
    let mut cloud = surface(dice, &body, points - outliers, sigma);
    cloud.extend((0..outliers).map(|_| narrow(&(body.centre + dice.in_cube(4.0)))));
    cloud
}

/// Points of a whole surface, uniform by area, with normal errors of deviation `sigma` on each coordinate.
pub fn surface(dice: &mut Dice, body: &Body, points: usize, sigma: f64) -> Vec<Point3> {
    (0..points).map(|_| narrow(&(body.surface_point(dice) + sigma * dice.normal3()))).collect()
}

/// The paper's criteria for one result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Mean absolute error of the three coordinates of the centre: the inside of RMS-c.
    pub centre: f64,
    /// Mean absolute error of the three semi-axes: the inside of RMS-s.
    pub size: f64,
    /// Angle between the long axes.
    pub axis_deg: f64,
    /// Distance between the centres.
    pub centre_distance: f64,
}

impl Errors {
    /// Result against truth.
    pub fn of(result: &Ellipsoid, truth: &Body) -> Self {
        let offset = wide(&result.centre) - truth.centre;
        let sizes = result.semi_axes.iter().zip(truth.sorted_semi_axes());
        Self {
            centre: offset.abs().sum() / 3.0,
            size: sizes.map(|(&a, b)| (f64::from(a) - b).abs()).sum::<f64>() / 3.0,
            axis_deg: axis_angle_deg(&long_axis(result), &truth.long_axis()),
            centre_distance: offset.norm(),
        }
    }
}
