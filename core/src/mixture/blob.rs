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

/// Deviations of the blobs about points, local units, in turns: a small one finds a body beside a dense neighbour, a large
/// one a body of which few points are left.
const DEVIATIONS: [f32; 2] = [0.2, 0.4];
/// Shares that the first blob and the others begin with.
const SHARES: (f32, f32) = (0.5, 0.8);
/// Added to the variances: a blob that collapses on a plane is still one.
const SOFTENING: f32 = 1e-4;
/// `(2 pi)^(3/2)`.
const NORMALISATION: f32 = 15.749_61;
/// `e^(-q / 2)` beyond this `q` is below a millionth: not the blob's.
const FAR: f32 = 28.0;
/// `ln 3 / 2`.
const LN_SQRT_3: f32 = 0.549_306_15;

impl Blob {
    /// The blob of start 0: a round one of the size of all, about the mean of the listed points.
    pub(crate) fn around(cloud: &[Point3], list: &[u16], frame: &Frame) -> Self {
        let mut sum = [0.0_f32; 3];
        for &index in list {
            let p = frame.local(&at(cloud, index));
            sum[0] += p.x;
            sum[1] += p.y;
            sum[2] += p.z;
        }
        Self { mean: sum.map(|s| s / list.len() as f32), covariance: round(1.0), share: SHARES.0 }
    }

    /// The blob of a later start: a small round one about a point.
    pub(crate) fn at(centre: &Point3, start: u8) -> Self {
        let deviation = DEVIATIONS[usize::from(start) % DEVIATIONS.len()];
        Self { mean: [centre.x, centre.y, centre.z], covariance: round(deviation), share: SHARES.1 }
    }

    /// One step over the listed points. `None` when nothing is left of the blob.
    pub(crate) fn step(&self, cloud: &[Point3], list: &[u16], frame: &Frame) -> Option<Self> {
        let determinant = self.covariance.determinant();
        if !(determinant > 0.0) {
            return None;
        }
        let adjugate = self.covariance.adjugate();
        let inverse = 1.0 / determinant;
        let odds =
            ((self.share * frame.volume) / (1.0 - self.share)) / (NORMALISATION * libm::sqrtf(determinant));
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
        let half_log =
            |value: f32| 0.5 * libm::logf(if value > SOFTENING { value } else { SOFTENING }) + LN_SQRT_3;
        let ln_axes = [e.values[2], e.values[1], e.values[0]].map(half_log);
        let axes = crate::ellipsoid::right_handed([c, b, a]);
        (Estimate { centre: self.mean, axes, ln_axes, boxiness: 0.0 }, self.share)
    }
}

fn round(deviation: f32) -> Symmetric3 {
    let v = deviation * deviation;
    Symmetric3 { xx: v, yy: v, zz: v, ..Symmetric3::default() }
}

/// From one side the blob's centre lies on the surface: moves it back along its ray by two thirds of its extent in depth.
pub(crate) fn push_back(estimate: &mut Estimate) {
    let c = estimate.centre;
    let range = libm::sqrtf(dot(c, c));
    let mut square = 0.0;
    for (row, ln_axis) in estimate.axes.iter().zip(estimate.ln_axes) {
        let along = libm::expf(ln_axis) * (dot(*row, c) / range);
        square += along * along;
    }
    let factor = 1.0 + (2.0 / 3.0) * (libm::sqrtf(square) / range);
    estimate.centre = c.map(|x| x * factor);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{residual::Viewpoint, rng::Stream};

    #[test]
    fn a_sphere_among_strays_is_found() {
        let mut stream = Stream::new(6);
        let mut draw = || stream.below(20_001) as f32 / 10_000.0 - 1.0;
        let cloud: [Point3; 300] = core::array::from_fn(|k| {
            let v = [draw(), draw(), draw()];
            if k % 4 == 0 {
                return Point3::new(4.0 * v[0], 4.0 * v[1], 4.0 * v[2]);
            }
            let n = libm::sqrtf(dot(v, v));
            Point3::new(1.0 + v[0] / n, v[1] / n, v[2] / n)
        });
        let mut list: [u16; 300] = core::array::from_fn(|k| k as u16);
        let frame = Frame::around(&cloud, &mut list, Viewpoint::None).unwrap();
        let mut blob = Blob::around(&cloud, &list, &frame);
        for _ in 0..20 {
            blob = blob.step(&cloud, &list, &frame).unwrap();
        }
        let (estimate, share) = blob.shell();
        let centre = frame.cloud(&Point3::new(estimate.centre[0], estimate.centre[1], estimate.centre[2]));
        assert!((centre - Point3::new(1.0, 0.0, 0.0)).norm() < 0.2, "{centre}");
        for ln_axis in estimate.ln_axes {
            assert!((libm::expf(ln_axis) * frame.unit - 1.0).abs() < 0.25, "{estimate:?}");
        }
        assert!((share - 0.75).abs() < 0.1);
    }
}
