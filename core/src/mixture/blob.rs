//! Where could a body be? Expectation-maximisation of one Gaussian blob against a uniform class.
//!
//! A cloud of points on an ellipsoid has, seen from afar, a mean and a covariance; points uniform over the box are the
//! other class. A step weighs each point with its probability to belong to the blob and takes the weighted mean and
//! covariance. On the sphere of radius `a` each coordinate has the variance `a^2 / 3`, so the semi-axes of the body are
//! sqrt(3) times the blob's deviations.

use crate::{
    Point3,
    jacobi::{Symmetric3, eigen},
    mixture::frame::Frame,
    point::at,
    refine::Estimate,
    residual::dot,
};

/// A Gaussian and its share of the points; local units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Blob {
    mean: [f32; 3],
    covariance: Symmetric3,
    share: f32,
}

/// Added to the variances: a blob that collapses on a plane is still one.
const SOFTENING: f32 = 1e-4;
/// `(2 pi)^(3/2)`.
const NORMALISATION: f32 = 15.749_61;
/// `e^(-q / 2)` beyond this `q` is below a millionth: not the blob's.
const FAR: f32 = 28.0;
/// `ln 3 / 2`.
const LN_SQRT_3: f32 = 0.549_306_15;

impl Blob {
    /// A round blob.
    pub(crate) fn round(centre: &Point3, deviation: f32, share: f32) -> Self {
        let v = deviation * deviation;
        let covariance = Symmetric3 { xx: v, yy: v, zz: v, ..Symmetric3::default() };
        Self { mean: [centre.x, centre.y, centre.z], covariance, share }
    }

    /// One step over the listed points. `None` when nothing is left of the blob.
    pub(crate) fn step(&self, cloud: &[Point3], list: &[u16], frame: &Frame) -> Option<Self> {
        let determinant = self.covariance.determinant();
        if !(determinant > 0.0) {
            return None;
        }
        let adjugate = self.covariance.adjugate();
        let inverse = 1.0 / determinant;
        let odds = ((self.share * frame.volume) / (1.0 - self.share)) / (NORMALISATION * libm::sqrtf(determinant));
        let (mut n, mut sum, mut square) = (0.0_f32, [0.0_f32; 3], Symmetric3::default());
        for &index in list {
            let p = frame.local(&at(cloud, index));
            let d = [p.x - self.mean[0], p.y - self.mean[1], p.z - self.mean[2]];
            let q = dot(d, adjugate.times(d)) * inverse;
            if !(q < FAR) {
                continue;
            }
            let k = odds * libm::expf(-0.5 * q);
            let r = k / (1.0 + k);
            n += r;
            let [x, y, z] = d;
            let (rx, ry, rz) = (r * x, r * y, r * z);
            sum[0] += rx;
            sum[1] += ry;
            sum[2] += rz;
            square.xx += rx * x;
            square.yy += ry * y;
            square.zz += rz * z;
            square.xy += rx * y;
            square.xz += rx * z;
            square.yz += ry * z;
        }
        // Four points' worth: fewer have no covariance.
        if !(n > 4.0) {
            return None;
        }
        let [x, y, z] = sum.map(|s| s / n);
        let covariance = Symmetric3 {
            xx: (square.xx / n - x * x) + SOFTENING,
            yy: (square.yy / n - y * y) + SOFTENING,
            zz: (square.zz / n - z * z) + SOFTENING,
            xy: square.xy / n - x * y,
            xz: square.xz / n - x * z,
            yz: square.yz / n - y * z,
        };
        let share = n / list.len() as f32;
        let share = if share < 0.98 { share } else { 0.98 };
        Some(Self { mean: [self.mean[0] + x, self.mean[1] + y, self.mean[2] + z], covariance, share })
    }

    /// The ellipsoid of the same second moments as a shell, and its share of the points.
    pub(crate) fn shell(&self) -> (Estimate, f32) {
        let e = eigen(&self.covariance);
        let [a, b, c] = e.vectors;
        let half_log = |value: f32| 0.5 * libm::logf(if value > SOFTENING { value } else { SOFTENING }) + LN_SQRT_3;
        let ln_axes = [e.values[2], e.values[1], e.values[0]].map(half_log);
        let axes = crate::ellipsoid::right_handed([c, b, a]);
        (Estimate { centre: self.mean, axes, ln_axes }, self.share)
    }
}
