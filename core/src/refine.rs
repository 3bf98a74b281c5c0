//! One Gauss-Newton step of the nine parameters, and the state it moves.
//!
//! Parameters, in this order: centre along the body's axes (mm), rotation about the body's axes (rad), logarithms of
//! the semi-axes. The cost is `1/2 sum w F^2 / var + 1/2 (x - m)^T P (x - m)` ([`crate::residual`], [`crate::prior`]);
//! its normal equations are `H d = -g`, `H = sum (w / var) J J^T + P`, `g = sum (w F / var) J + P (x - m)`.

use crate::{
    Ellipsoid, Point3,
    linalg::{N, Symmetric9},
    prior::SizeTerm,
    residual::{Contact, RayModel},
};

/// A model on its way: centre, axes (rows, orthonormal, in the order of the prior) and logarithms of the semi-axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Centre, mm, frame of the cloud.
    pub centre: [f32; 3],
    /// Row k is the unit vector of the k-th semi-axis.
    pub axes: [[f32; 3]; 3],
    /// `ln a, ln b, ln c`.
    pub ln_axes: [f32; 3],
}

/// Normal equations under construction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    /// `H`.
    pub matrix: Symmetric9,
    /// `g`.
    pub gradient: [f32; N],
}

/// Added to the diagonal of the rotations, rad^-2: turning a spheroid about its long axis changes nothing it can be
/// measured by, and the step must not run away along it.
const ROTATION_DAMPING: f32 = 1.0;
/// Longest move of the centre in one step, in units of the shortest semi-axis.
const CENTRE_LIMIT: f32 = 0.5;
/// Largest turn in one step, rad.
const ROTATION_LIMIT: f32 = 0.5;
/// Largest change of a logarithm in one step.
const SIZE_LIMIT: f32 = 0.3;

impl Normal {
    /// No information.
    pub const ZERO: Self = Self { matrix: Symmetric9::ZERO, gradient: [0.0; N] };

    /// Adds one residual `F` with weight `w / var`.
    #[inline]
    pub fn add(&mut self, derivatives: &[f32; N], value: f32, weight: f32) {
        self.matrix.add_outer(derivatives, weight);
        let scaled = weight * value;
        for k in 0..N {
            self.gradient[k] += scaled * derivatives[k];
        }
    }

    /// Adds a ray's contact.
    #[inline]
    pub fn add_contact(&mut self, model: &RayModel, contact: &Contact, weight: f32) {
        self.add(&model.derivatives(contact.u), contact.value, weight / contact.variance);
    }

    /// Adds the size prior.
    pub fn add_prior(&mut self, prior: &SizeTerm, ln_axes: &[f32; 3]) {
        let p = &prior.information;
        let d = p.times(prior.departure(ln_axes));
        for (k, value) in [(0, p.xx), (1, p.yy), (2, p.zz)] {
            self.matrix.add_diagonal(6 + k, value);
            self.gradient[6 + k] += d[k];
        }
        for (i, j, value) in [(7, 6, p.xy), (8, 6, p.xz), (8, 7, p.yz)] {
            self.matrix.0[crate::linalg::packed(i, j)] += value;
        }
    }
}

fn limited(step: [f32; 3], limit: f32) -> [f32; 3] {
    let square = step[0] * step[0] + step[1] * step[1] + step[2] * step[2];
    if square > limit * limit {
        let scale = limit / libm::sqrtf(square);
        step.map(|x| x * scale)
    } else {
        step
    }
}

impl Estimate {
    /// The ellipsoid it stands for, axes in the order of the prior.
    pub fn ellipsoid(&self) -> Ellipsoid {
        let [x, y, z] = self.centre;
        Ellipsoid { centre: Point3::new(x, y, z), semi_axes: self.ln_axes.map(libm::expf), axes: self.axes }
    }

    /// Solves the normal equations and moves. `None` when they are singular or the step is not finite.
    pub fn step(&self, normal: &Normal) -> Option<Self> {
        let mut matrix = normal.matrix;
        for k in 3..6 {
            matrix.add_diagonal(k, ROTATION_DAMPING);
        }
        let solution = matrix.factor()?.solve(&normal.gradient);
        let d = solution.map(|x| -x);
        let smallest = libm::expf(self.ln_axes[2]);
        let centre = limited([d[0], d[1], d[2]], CENTRE_LIMIT * smallest);
        let rotation = limited([d[3], d[4], d[5]], ROTATION_LIMIT);
        let sizes = limited([d[6], d[7], d[8]], SIZE_LIMIT);
        let next = Self {
            centre: moved(&self.centre, &self.axes, centre),
            axes: turned(&self.axes, rotation),
            ln_axes: [self.ln_axes[0] + sizes[0], self.ln_axes[1] + sizes[1], self.ln_axes[2] + sizes[2]],
        };
        d.iter().all(|x| x.is_finite()).then_some(next)
    }
}

/// `c + R^T d`, each component summed over the axes in order.
fn moved(centre: &[f32; 3], axes: &[[f32; 3]; 3], d: [f32; 3]) -> [f32; 3] {
    let mut result = *centre;
    for k in 0..3 {
        result[k] += d[0] * axes[0][k] + d[1] * axes[1][k] + d[2] * axes[2][k];
    }
    result
}

/// `Q R` with the Cayley transform `Q = I + 2 / (1 + w.w) (W + W W)`, `W` the cross-product matrix of `w = r / 2`: a
/// rotation by `r` to third order, exactly orthogonal but for rounding, without sine and cosine.
/// Row by row: `Q y = y + (2 / (1 + w.w)) (w x y + w x (w x y))`, applied to the columns of `R`.
fn turned(axes: &[[f32; 3]; 3], r: [f32; 3]) -> [[f32; 3]; 3] {
    let w = r.map(|x| 0.5 * x);
    let scale = 2.0 / (1.0 + (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]));
    let mut result = *axes;
    for k in 0..3 {
        let y = [axes[0][k], axes[1][k], axes[2][k]];
        let once = cross(w, y);
        let twice = cross(w, once);
        for i in 0..3 {
            result[i][k] = y[i] + scale * (once[i] + twice[i]);
        }
    }
    result
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
