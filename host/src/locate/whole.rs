//! One ellipsoid through all points of a region: no sampling, no outliers, no size check.
//!
//! [`direct`] is the paper's baseline (Tables 4 and 6). [`fitted`] is for clouds of which every point is good, such as a turned
//! magnetometer's: by either criterion of [`varsac_core::geometric`], with the covariance that the residuals imply.

use varsac_core::{
    CentralQuadric, Constraint, Covariance, Ellipsoid, Point3, Rejection, Score, fit,
    geometric::{self, Criterion},
    tebc::Shell,
};

use super::{
    MAX_CAPACITY, Target,
    region::{Found, target},
};
use crate::eval::EllipsoidF64;

/// Least squares on all points, as in the paper.
pub(super) fn direct(cloud: &[Point3], constraint: Constraint, shell: f32) -> Found {
    match fit_all(cloud, constraint) {
        Ok(surface) => found(cloud, &Shell::new(&surface, shell), Ellipsoid::from(&surface), None),
        Err(_) => nothing(cloud),
    }
}

/// The best ellipsoid through all points by `criterion`.
pub(super) fn fitted(cloud: &[Point3], criterion: Criterion, shell: f32) -> Found {
    match geometric::fit(cloud, &every_index(cloud), criterion) {
        Ok(fitted) => {
            let surface = CentralQuadric::from(&EllipsoidF64::from(&fitted.ellipsoid));
            found(cloud, &Shell::new(&surface, shell), fitted.ellipsoid, fitted.covariance)
        }
        Err(_) => nothing(cloud),
    }
}

/// The core's least squares on a whole cloud.
///
/// # Errors
/// Why it is no ellipsoid.
pub fn fit_all(cloud: &[Point3], constraint: Constraint) -> Result<CentralQuadric, Rejection> {
    fit::fit(cloud, &every_index(cloud), constraint)
}

fn every_index(cloud: &[Point3]) -> Vec<u16> {
    (0..cloud.len().min(MAX_CAPACITY)).map(|index| index as u16).collect()
}

fn nothing(cloud: &[Point3]) -> Found {
    (Vec::new(), vec![0; cloud.len()])
}

/// The only target. Its score is counted with the same shell as everybody's.
fn found(cloud: &[Point3], shell: &Shell, ellipsoid: Ellipsoid, covariance: Option<Covariance>) -> Found {
    let labels: Vec<u32> = cloud.iter().map(|point| u32::from(shell.contains(point))).collect();
    let score = Score { inliers: labels.iter().sum(), candidates: cloud.len() as u32 };
    (vec![Target { covariance, ..target(ellipsoid, score, 1) }], labels)
}
