//! The fit of one ellipsoid to points that all lie on it: contract, chapter G1.

use super::climb::promise;
use super::foot::orthogonal;
use super::numbers::longest;
use super::run::{scaled, scaled_covariance};
use crate::fault::{self, Fault};
use crate::fit::{Frame, factor, local_frame, solve};
use crate::map::algebra::{Lower, Vector, inverse};
use crate::map::covariance::{covariance, of_the_ellipsoid};
use crate::map::judge::sorted;
use crate::map::model::{Estimate, Model};
use crate::map::normal::{Follower, Normal, Residual, moments};
use crate::map::step::moved;
use crate::map::view::{Noise, Viewpoint};
use crate::{Constraint, Ellipsoid, Point, Rejection, ellipsoid_of, fit};

/// What is made as small as can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Criterion {
    /// The residuals of the quadric.
    Algebraic,
    /// The distances from the surface.
    Geometric,
}

/// A single ellipsoid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Single {
    /// In the frame of the cloud, sorted.
    pub ellipsoid: Ellipsoid,
    /// Lower triangle by rows.
    pub covariance: Option<[f32; 45]>,
    /// Root of the mean square of the distances, mm.
    pub rms: f32,
}

/// G1: the ellipsoid of the points `list` of the cloud, in that order.
///
/// # Errors
/// The rejections of chapter 5.
pub fn fit_single(cloud: &[Point], list: &[u16], criterion: Criterion) -> Result<Single, Rejection> {
    let start = ellipsoid_of(&fit(cloud, list, Constraint::Trace)?);
    let frame = local_frame(cloud, list)?;
    let points: Vec<Vector> = list.iter().map(|&index| frame.local(cloud[index as usize])).collect();
    let x = start.semi_axes.map(|a| libm::logf(a * frame.scale));
    let estimate = Estimate { centre: frame.local(start.centre), axes: start.axes, x, boxiness: 0.0 };
    let sums = Sums::at(&estimate, &points);
    let (estimate, sums) = match criterion {
        Criterion::Algebraic => (estimate, sums),
        Criterion::Geometric => closest(estimate, sums, &points),
    };
    Ok(result(&estimate, &sums, points.len(), &frame, criterion))
}

/// G1: three sets of normal equations, with the weights `1 / var`, `1`, `var`, and the sum of squares.
struct Sums {
    distances: Normal,
    residuals: Normal,
    spread: Normal,
    squares: f32,
}

impl Sums {
    fn at(estimate: &Estimate, points: &[Vector]) -> Self {
        let model = Model::new(estimate, Noise { axial: 1.0, lateral: 0.0 }, Viewpoint::None);
        let mut contacts = Vec::new();
        let mut squares = 0.0;
        for &p in points {
            let contact = orthogonal(&model, p);
            if contact.f2() >= 0.0 {
                contacts.push(contact);
                squares += contact.f2();
            }
        }
        let normal = |weight: fn(f32) -> f32| {
            let mut residuals = Vec::new();
            for c in &contacts {
                residuals.push(Residual::new(c.u, c.value, weight(c.variance)));
            }
            let (matrix, gradient) = moments(&residuals, &model.slopes());
            Normal { matrix, gradient, follower: Follower::default() }
        };
        Self {
            distances: normal(|variance| 1.0 / variance),
            residuals: normal(|_| 1.0),
            spread: normal(|variance| variance),
            squares,
        }
    }
}

/// G1, geometric: the estimate with the smallest sum of squares, and its sums.
fn closest(mut estimate: Estimate, mut sums: Sums, points: &[Vector]) -> (Estimate, Sums) {
    let mut damping = 0.001;
    for _ in 0..40 {
        let Normal { mut matrix, gradient, .. } = sums.distances;
        for k in 0..9 {
            matrix[k][k] += damping * matrix[k][k];
        }
        for k in 3..6 {
            matrix[k][k] += 1.216 * sums.squares;
        }
        let Ok(factors) = factor(&matrix) else { break };
        let d = solve(&factors, &gradient).map(|component| -component);
        if !d.iter().all(|component| component.is_finite()) {
            break;
        }
        let promise = promise(&d, &gradient);
        let tried = moved(&estimate, &d, 0.5 * longest(estimate.x));
        let there = Sums::at(&tried, points);
        if there.squares <= sums.squares {
            (estimate, sums) = (tried, there);
            damping *= if fault::is(Fault::Damping) { 0.5 } else { 0.1 };
        } else {
            damping *= 10.0;
        }
        let goes_on = promise > 1e-7 * sums.squares;
        if !goes_on || damping > 1e6 {
            break;
        }
    }
    (estimate, sums)
}

/// G1, result.
fn result(estimate: &Estimate, sums: &Sums, n: usize, frame: &Frame, criterion: Criterion) -> Single {
    let back = 1.0 / frame.scale;
    let (local, order) = sorted(estimate);
    let f = n as f32 - 9.0;
    let variance = sums.squares / f;
    let covariance = if f > 0.0 {
        match criterion {
            Criterion::Geometric => {
                let mut normal =
                    Normal { follower: Follower::default(), gradient: [0.0; 9], ..sums.distances };
                for row in &mut normal.matrix {
                    *row = row.map(|entry| entry / variance);
                }
                covariance(estimate, &normal, 1.0, local.semi_axes, order)
            }
            Criterion::Algebraic => algebraic_covariance(sums, variance)
                .and_then(|b| of_the_ellipsoid(&b, estimate, local.semi_axes, order)),
        }
    } else {
        None
    };
    Single {
        ellipsoid: scaled(&local, frame.origin, back),
        covariance: covariance
            .map(|entries| scaled_covariance(&entries, back))
            .filter(|entries| entries.iter().all(|entry| entry.is_finite())),
        rms: libm::sqrtf(sums.squares / n as f32) * back,
    }
}

/// G1, algebraic: the `B` of M20; none where `M` is singular.
fn algebraic_covariance(sums: &Sums, variance: f32) -> Option<Lower> {
    let trace = |m: &Lower| m[0][0] + m[1][1] + m[2][2];
    let (mut m, mut b) = (sums.residuals.matrix, sums.spread.matrix);
    if fault::is(Fault::Spread) {
        m = sums.distances.matrix;
    }
    let weight = trace(&b) / trace(&m);
    let gain = 1.216 * (variance * weight);
    for k in 3..6 {
        m[k][k] += gain;
        b[k][k] += gain * weight;
    }
    let i = both_halves(inverse(&factor(&m).ok()?));
    let b = both_halves(b);
    let mut w = [[0.0; 9]; 9];
    let mut result = [[0.0; 9]; 9];
    for row in 0..9 {
        for column in 0..9 {
            for k in 0..9 {
                w[row][column] += i[row][k] * b[k][column];
            }
        }
    }
    for row in 0..9 {
        for column in 0..=row {
            let mut entry = 0.0;
            for k in 0..9 {
                entry += w[row][k] * i[column][k];
            }
            result[row][column] = variance * entry;
        }
    }
    Some(both_halves(result))
}

/// The lower triangle, and above the diagonal its mirror image.
fn both_halves(mut lower: Lower) -> Lower {
    for i in 0..9 {
        for j in 0..i {
            lower[j][i] = lower[i][j];
        }
    }
    lower
}

#[cfg(test)]
#[path = "single_tests.rs"]
mod tests;
