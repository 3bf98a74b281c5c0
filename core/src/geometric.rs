//! One ellipsoid, all points good: a turned magnetometer, a clean scan. No sampling, no outliers, one call.
//!
//! * [`Criterion::Algebraic`]: least squares of the trace-normalised quadric ([`crate::fit`]), the form widely used for
//!   magnetometers. Points far out weigh more.
//! * [`Criterion::Geometric`]: least sum of squared distances from the surface (`foot`), by Levenberg and
//!   Marquardt's method from the algebraic answer. What a caliper would say.
//!
//! Both come with the covariance that their own residuals imply, `s^2 = sum d^2 / (n - 9)`. The geometric one is
//! `s^2 H^-1`; the algebraic one weighs the squares with the slope of its error, `|g|^2`, and has the covariance
//! `s^2 M^-1 B M^-1` with `M = sum |g|^2 J J^T`, `B = sum |g|^4 J J^T`.

use crate::{
    Constraint, Ellipsoid, Point3, Rejection,
    covariance::{Covariance, congruence, covariance, in_cloud},
    fit::{self, LocalFrame},
    linalg::{N, Symmetric9, packed},
    moments::Moments,
    point::at,
    refine::{Estimate, Normal, ROTATION_INFORMATION},
    residual::{Noise, RayModel, Viewpoint},
};

/// What is made least.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Criterion {
    /// Squared error of the equation of the quadric with `a11 + a22 + a33 = 3`.
    Algebraic,
    /// Squared distance from the surface.
    #[default]
    Geometric,
}

/// A fitted ellipsoid.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Fitted {
    /// Frame and unit of the cloud.
    pub ellipsoid: Ellipsoid,
    /// None where nine points leave no residual to judge by, or the equations are singular.
    pub covariance: Option<Covariance>,
    /// Root mean square of the distances, unit of the cloud.
    pub rms: f32,
}

/// Passes over the points at most.
pub const MAX_PASSES: u32 = 40;
/// A step that promises less than this part of the sum of squares is the last.
const SETTLED: f32 = 1e-7;
/// First damping, its factors after a step that failed and one that did not, and where it ends.
const DAMPING: f32 = 1e-3;
const HARDER: f32 = 10.0;
const EASIER: f32 = 0.1;
const HARDEST: f32 = 1e6;
/// Longest move of the centre in one step, over the longest semi-axis.
const CENTRE_LIMIT: f32 = 0.5;

/// Fits the listed points, which are summed in this order. `O(n)` with at most [`MAX_PASSES`] passes.
///
/// ```
/// use varsac_core::{Point3, geometric::{Criterion, fit}};
/// let cloud: Vec<Point3> = (0..60).map(|k| {
///     let (t, z) = (2.4 * k as f32, (k as f32 - 29.5) / 30.0);
///     let r = (1.0 - z * z).sqrt();
///     Point3::new(5.0 + 3.0 * r * t.cos(), 2.0 * r * t.sin(), 1.5 * z)
/// }).collect();
/// let all: Vec<u16> = (0..60).collect();
/// let fitted = fit(&cloud, &all, Criterion::Geometric).unwrap();
/// assert!((fitted.ellipsoid.semi_axes[0] - 3.0).abs() < 1e-4);
/// assert!(fitted.rms < 1e-5);
/// ```
///
/// # Errors
/// As [`crate::fit::fit`]: too few points, degenerate, or the algebraic answer is no ellipsoid.
pub fn fit(cloud: &[Point3], list: &[u16], criterion: Criterion) -> Result<Fitted, Rejection> {
    let start = Ellipsoid::from(&fit::fit(cloud, list, Constraint::Trace)?);
    let frame = LocalFrame::around(cloud, list).ok_or(Rejection::Degenerate)?;
    let centre = frame.to_local(&start.centre);
    let estimate = Estimate {
        centre: [centre.x, centre.y, centre.z],
        axes: start.axes,
        ln_axes: start.semi_axes.map(|a| libm::logf(a * frame.scale)),
        boxiness: 0.0,
    };
    let mut best = Sums::at(estimate, cloud, list, &frame);
    if criterion == Criterion::Geometric {
        best = descend(best, cloud, list, &frame);
    }
    Ok(best.fitted(&frame, list.len(), criterion))
}

/// Levenberg and Marquardt's descent of the sum of squared distances.
fn descend(mut best: Sums, cloud: &[Point3], list: &[u16], frame: &LocalFrame) -> Sums {
    let mut damping = DAMPING;
    for _ in 0..MAX_PASSES {
        let Some((next, promise)) = best.step(damping) else { break };
        let trial = Sums::at(next, cloud, list, frame);
        if trial.squares <= best.squares {
            best = trial;
            damping *= EASIER;
        } else {
            damping *= HARDER;
        }
        let worth_while = promise > SETTLED * best.squares;
        if !worth_while || damping > HARDEST {
            break;
        }
    }
    best
}

/// An estimate and the sums over the points there; local units.
struct Sums {
    estimate: Estimate,
    /// `sum J J^T` and `sum d J`.
    normal: Normal,
    /// With the weights `|g|^2` and `|g|^4`, see the head of the module.
    algebraic: [Normal; 2],
    /// `sum d^2`.
    squares: f32,
}

impl Sums {
    fn at(estimate: Estimate, cloud: &[Point3], list: &[u16], frame: &LocalFrame) -> Self {
        let unit = Noise { axial_mm: 1.0, lateral_rad: 0.0 };
        let model = RayModel::new(&estimate.ellipsoid(), &unit, Viewpoint::None);
        let (mut moments, mut weighed, mut twice) = (Moments::ZERO, Moments::ZERO, Moments::ZERO);
        let mut squares = 0.0;
        for &index in list {
            let contact = model.perpendicular(&frame.to_local(&at(cloud, index)));
            let square = contact.square();
            // A point at the very centre has no nearest point.
            if square >= 0.0 {
                moments.add(contact.u, contact.value, 1.0 / contact.variance);
                weighed.add(contact.u, contact.value, 1.0);
                twice.add(contact.u, contact.value, contact.variance);
                squares += square;
            }
        }
        let constants = model.constants();
        Self {
            estimate,
            normal: Normal::new(&moments, &constants),
            algebraic: [Normal::new(&weighed, &constants), Normal::new(&twice, &constants)],
            squares,
        }
    }

    /// The estimate after a damped step, and by how much the step promises to lessen the squares.
    fn step(&self, damping: f32) -> Option<(Estimate, f32)> {
        let mut matrix = self.normal.matrix;
        for k in 0..N {
            let d = matrix.diagonal(k);
            matrix.add_diagonal(k, damping * d);
        }
        for k in 3..6 {
            matrix.add_diagonal(k, ROTATION_INFORMATION * self.squares);
        }
        let step = matrix.factor()?.solve(&self.normal.gradient).map(|x| -x);
        let mut promise = 0.0;
        for k in 0..N {
            promise -= step[k] * self.normal.gradient[k];
        }
        let [a, b, c] = self.estimate.ln_axes;
        let largest = libm::expf(if a > b && a > c {
            a
        } else if b > c {
            b
        } else {
            c
        });
        Some((self.estimate.moved_by(&step, CENTRE_LIMIT * largest)?, promise))
    }

    fn fitted(&self, frame: &LocalFrame, count: usize, criterion: Criterion) -> Fitted {
        let back = 1.0 / frame.scale;
        let (local, order) = self.estimate.sorted();
        let (n, freedom) = (count as f32, count as f32 - N as f32);
        let variance = self.squares / freedom;
        let covariance = if freedom > 0.0 {
            match criterion {
                Criterion::Geometric => {
                    let normal = divided(&self.normal, variance);
                    covariance(&normal, &self.estimate, &local, order, 1.0)
                }
                Criterion::Algebraic => sandwich(&self.algebraic, variance)
                    .and_then(|body| in_cloud(&body, &self.estimate, &local, order)),
            }
        } else {
            None
        };
        Fitted {
            ellipsoid: Ellipsoid {
                centre: frame.point_to_cloud(&local.centre),
                semi_axes: local.semi_axes.map(|a| a * back),
                axes: local.axes,
            },
            covariance: covariance.map(|c| c.scaled(back)),
            rms: libm::sqrtf(self.squares / n) * back,
        }
    }
}

/// The information of the same sums if each distance has this variance.
fn divided(normal: &Normal, variance: f32) -> Normal {
    let mut result = *normal;
    result.matrix.0 = result.matrix.0.map(|x| x / variance);
    result
}

/// `v M^-1 B M^-1`. Rotations that the points do not determine get the variance that [`ROTATION_INFORMATION`] stands for:
/// with `m` the mean weight, `M` gains `l = v m R` and `B` gains `l m`, so that alone they give `v l m / l^2 = 1 / R`.
fn sandwich([m, b]: &[Normal; 2], variance: f32) -> Option<Symmetric9> {
    let (mut m, mut b) = (m.matrix, b.matrix);
    let trace = |matrix: &Symmetric9| matrix.diagonal(0) + matrix.diagonal(1) + matrix.diagonal(2);
    let weight = trace(&b) / trace(&m);
    let gain = ROTATION_INFORMATION * (variance * weight);
    for k in 3..6 {
        m.add_diagonal(k, gain);
        b.add_diagonal(k, gain * weight);
    }
    let inverse = m.factor()?.inverse();
    let mut rows = [[0.0; N]; N];
    for i in 0..N {
        for j in 0..N {
            rows[i][j] = inverse.0[if i >= j { packed(i, j) } else { packed(j, i) }];
        }
    }
    let mut result = Symmetric9::ZERO;
    for (slot, value) in result.0.iter_mut().zip(congruence(&rows, &b).as_flattened()) {
        *slot = variance * value;
    }
    Some(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    /// Points of an ellipsoid 3, 2, 1.5 with uniform errors of the given half width.
    fn cloud(width: f32, scale: f32) -> [Point3; 200] {
        let mut stream = Stream::new(4);
        let mut draw = || stream.below(20_001) as f32 / 10_000.0 - 1.0;
        core::array::from_fn(|_| {
            let v = [draw(), draw(), draw()];
            let n = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
            let mut at = |k: usize, a: f32| scale * (a * v[k] / n + width * draw());
            Point3::new(at(0, 3.0) + 10.0 * scale, at(1, 2.0), at(2, 1.5))
        })
    }

    #[test]
    fn both_criteria_find_the_body_in_any_unit() {
        let list: [u16; 200] = core::array::from_fn(|k| k as u16);
        for scale in [1e-4, 1.0, 1e6] {
            for criterion in [Criterion::Algebraic, Criterion::Geometric] {
                let fitted = fit(&cloud(0.01, scale), &list, criterion).unwrap();
                for (value, expected) in fitted.ellipsoid.semi_axes.iter().zip([3.0, 2.0, 1.5]) {
                    assert!((value / scale - expected).abs() < 0.005, "{criterion:?} {fitted:?}");
                }
                let sigma = fitted.covariance.unwrap().sigma_centre_mm()[0] / scale;
                assert!((0.0004..0.0012).contains(&sigma), "{criterion:?} {sigma}");
            }
        }
    }

    #[test]
    fn nine_points_have_a_fit_and_no_uncertainty() {
        let cloud = cloud(0.0, 1.0);
        let list = [0, 20, 40, 60, 80, 100, 120, 140, 160];
        if let Ok(fitted) = fit(&cloud, &list, Criterion::Geometric) {
            assert!(fitted.covariance.is_none() && fitted.rms < 1e-3);
        }
        assert_eq!(fit(&cloud, &list[..8], Criterion::Geometric).err(), Some(Rejection::TooFewPoints));
    }
}
