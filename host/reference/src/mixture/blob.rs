//! A Gaussian in uniform clutter: contract, chapter X4.

use super::moments::Moments;
use super::shell::Shell;
use crate::Symmetric;
use crate::ellipsoid::with_signs;
use crate::fault::{self, Fault};
use crate::jacobi::{ascending, eigen};
use crate::map::algebra::{Vector, adj, det, dot, minus, product};
use crate::map::model::Estimate;

/// Mean, covariance and share.
pub(crate) struct Blob {
    pub(crate) mean: Vector,
    pub(crate) covariance: Symmetric,
    pub(crate) share: f32,
}

impl Blob {
    /// A round one with this deviation.
    pub(crate) fn round(mean: Vector, deviation: f32, share: f32) -> Self {
        let v = deviation * deviation;
        Self { mean, covariance: Symmetric { xx: v, yy: v, zz: v, ..Symmetric::default() }, share }
    }

    /// X4: one step over the local points of the sample; none where the blob is lost.
    pub(crate) fn step(&self, sample: &[Vector], volume: f32) -> Option<Self> {
        let det = det(&self.covariance);
        let regular = det > 0.0;
        if !regular {
            return None;
        }
        let inv = 1.0 / det;
        let odds = ((self.share * volume) / (1.0 - self.share)) / (15.74961 * libm::sqrtf(det));
        let mut n = 0.0;
        let mut moments = Moments::default();
        for &p in sample {
            let d = minus(p, self.mean);
            let h = dot(d, product(&adj(&self.covariance), d)) * inv;
            if h < 28.0 {
                let k = odds * libm::expf(-0.5 * h);
                let r = k / (1.0 + k);
                n += r;
                moments.gain(d, r);
            }
        }
        let enough = n > 4.0;
        if !enough {
            return None;
        }
        let mut covariance = moments.scatter(n);
        let wider = if fault::is(Fault::Blob) { 0.0 } else { 1e-4 };
        covariance.xx += wider;
        covariance.yy += wider;
        covariance.zz += wider;
        let moved = moments.mean(n);
        let share = n / sample.len() as f32;
        Some(Self {
            mean: [self.mean[0] + moved[0], self.mean[1] + moved[1], self.mean[2] + moved[2]],
            covariance,
            share: if share < 0.98 { share } else { 0.98 },
        })
    }

    /// X4: centre, axes and logarithms of the shell of the blob; its noise is not known yet.
    pub(crate) fn shell(&self) -> Shell {
        let sorted = ascending(&eigen(&self.covariance));
        let [v1, v2, v3] = sorted.values;
        let [a1, a2, a3] = sorted.vectors;
        let x = [v3, v2, v1].map(|v| 0.5 * libm::logf(if v > 1e-4 { v } else { 1e-4 }) + 0.549_306_15);
        let axes = with_signs(&[a3, a2, a1]);
        let estimate = Estimate { centre: self.mean, axes, x, boxiness: 0.0 };
        Shell { estimate, sigma: f32::INFINITY, share: self.share }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of a cube about (1, 2, 3), twice.
    fn cube() -> Vec<Vector> {
        let mut points = Vec::new();
        for k in 0..16 {
            let side = |bit: i32| if k & bit == 0 { -1.0 } else { 1.0 };
            points.push([1.0 + side(1), 2.0 + side(2), 3.0 + side(4)]);
        }
        points
    }

    #[test]
    fn a_blob_finds_the_middle_of_its_points() {
        let mut blob = Blob::round([1.5, 2.0, 3.0], 1.0, 0.5);
        for _ in 0..20 {
            blob = blob.step(&cube(), 1000.0).expect("a blob of sixteen points");
        }
        for (found, expected) in blob.mean.iter().zip([1.0, 2.0, 3.0]) {
            assert!((found - expected).abs() < 1e-3, "{found} {expected}");
        }
        assert!((blob.covariance.xx - 1.0).abs() < 0.01 && blob.covariance.xy.abs() < 0.01);
        // The shell of a Gaussian has sqrt(3) times its deviation as semi-axis.
        assert!((libm::expf(blob.shell().estimate.x[0]) - 3.0_f32.sqrt()).abs() < 0.01);
    }

    #[test]
    fn a_blob_without_points_is_lost() {
        assert!(Blob::round([100.0; 3], 1.0, 0.5).step(&cube(), 1000.0).is_none());
        assert!(Blob::round([1.0, 2.0, 3.0], 0.0, 0.5).step(&cube(), 1000.0).is_none());
    }
}
