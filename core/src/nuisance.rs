//! Two quantities that every view of a fruit depends on and nobody asks for, estimated along and eliminated.
//!
//! * The *displacement* `d` of all outline rays, rad: a mask or a filter that makes everything larger. `d ~ N(0, s_d^2)`.
//! * The *boxiness* `k` of the body: real fruit are fuller between their axes than an ellipsoid. The surface is taken at
//!   `|M (x - c)| = 1 + k phi(u)`, `phi = 2 (xx yy + yy zz + zz xx)`, which is 0 on the axes and 2/3 in the corners; a
//!   super-ellipsoid of exponent 2.5 has `k` about 0.15. `k ~ N(0, s_k^2)`. What the size would have to absorb otherwise, and with
//!   it the centre, is absorbed here, and its uncertainty widens theirs.
//!
//! With the nine parameters `x` the normal equations are of eleven unknowns; eliminating first `d`, then `k`, leaves nine:
//! `H_xx - H_xd H_dx / H_dd`, and so on (Schur complement). `k` is linear and is carried from step to step; `d` enters nothing but
//! its own ray residuals and is eliminated afresh each time.

use crate::{linalg::N, refine::Normal};

/// `phi` at `u`: how much further out a fuller body reaches there.
#[inline(always)]
pub(crate) fn fullness([x, y, z]: [f32; 3]) -> f32 {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    2.0 * ((xx * yy + yy * zz) + zz * xx)
}

/// The nine monomials of [`crate::moments`].
#[inline(always)]
fn monomials([x, y, z]: [f32; 3]) -> [f32; N] {
    [x, y, z, y * z, z * x, x * y, x * x, y * y, z * z]
}

/// One row of the normal equations that is to be eliminated, without the constants of the model.
#[derive(Debug, Clone, Copy)]
struct Row {
    information: f32,
    coupling: [f32; N],
    gradient: f32,
}

impl Row {
    /// Only the prior: deviation `sigma`, the value now being `at`.
    fn prior(sigma: f32, at: f32) -> Self {
        let information = 1.0 / (sigma * sigma);
        let gradient = if sigma > 0.0 { information * at } else { 0.0 };
        Self { information, coupling: [0.0; N], gradient }
    }

    /// A residual `value` at `u` with weight `w`, whose derivative in this unknown is `slope`.
    #[inline(always)]
    fn add(&mut self, u: [f32; 3], value: f32, w: f32, slope: f32) {
        let lever = w * slope;
        self.information += lever * slope;
        for (sum, monomial) in self.coupling.iter_mut().zip(monomials(u)) {
            *sum += lever * monomial;
        }
        self.gradient += lever * value;
    }
}

/// Both rows and what couples them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nuisances {
    displacement: Row,
    boxiness: Row,
    both: f32,
}

/// How the boxiness follows a step of the nine parameters: `k' = k - (g_k + h_k . d) / H_kk`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Follower {
    coupling: [f32; N],
    gradient: f32,
    inverse: f32,
}

impl Follower {
    /// Stays where it is.
    pub(crate) const STILL: Self = Self { coupling: [0.0; N], gradient: 0.0, inverse: 0.0 };

    /// The change that goes with the step `d`.
    pub(crate) fn follow(&self, d: &[f32; N]) -> f32 {
        let mut sum = self.gradient;
        for k in 0..N {
            sum += self.coupling[k] * d[k];
        }
        -(sum * self.inverse)
    }
}

impl Nuisances {
    /// Only the priors; `boxiness` is the present value of `k`, `sigmas` are `s_d` and `s_k`.
    pub(crate) fn new(sigmas: [f32; 2], boxiness: f32) -> Self {
        Self {
            displacement: Row::prior(sigmas[0], 0.0),
            boxiness: Row::prior(sigmas[1], boxiness),
            both: 0.0,
        }
    }

    /// A residual of a point: `phi` is [`fullness`] at `u`.
    #[inline(always)]
    pub(crate) fn add_point(&mut self, u: [f32; 3], value: f32, w: f32, phi: f32) {
        self.boxiness.add(u, value, w, -phi);
    }

    /// A residual of an outline ray whose derivative in the displacement is `-lever`.
    pub(crate) fn add_ray(&mut self, u: [f32; 3], value: f32, w: f32, phi: f32, lever: f32) {
        self.displacement.add(u, value, w, -lever);
        self.boxiness.add(u, value, w, -phi);
        self.both += w * (lever * phi);
    }

    /// Eliminates displacement, then boxiness from `normal`; `s` are the constants of the model.
    pub(crate) fn eliminate(&self, normal: &mut Normal, s: &[f32; N]) {
        let scaled = |row: &Row| core::array::from_fn::<f32, N, _>(|k| row.coupling[k] * s[k]);
        let d = scaled(&self.displacement);
        let mut k = scaled(&self.boxiness);
        let inverse = 1.0 / self.displacement.information;
        normal.add(&d, self.displacement.gradient, -inverse);
        let share = self.both * inverse;
        for i in 0..N {
            k[i] -= share * d[i];
        }
        let gradient = self.boxiness.gradient - share * self.displacement.gradient;
        let inverse = 1.0 / (self.boxiness.information - share * self.both);
        normal.add(&k, gradient, -inverse);
        normal.boxiness = Follower { coupling: k, gradient, inverse };
    }
}
