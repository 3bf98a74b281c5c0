//! Outline rays: where in the depth image the fruit ends and something further away begins.
//!
//! Between the last pixel on the fruit and the first one on what is behind it runs the fruit's outline: the ray in the
//! middle touches the fruit, to within a fraction of a pixel. Surface points say little about where a rounded body
//! ends sideways, and this says nothing else. The host finds the rays in the depth image; the core decides for each
//! model which of them can be its own.
//!
//! In the letters of [`crate::residual`], for the ray through the `inner` point: `F = |e| - 1` with the gradient `g` at
//! `e / |e|`; a ray displaced by an angle of `d` rad changes `F` by `k d`, `k = t* |g|`, `t*` the depth of the closest
//! approach. Variance of `F`: `(sigma k)^2`. One displacement `d ~ N(0, s_d^2)` is common to all rays of a view (a mask
//! or a filter that makes everything larger), and is eliminated from the normal equations.

use crate::{
    Point3,
    nuisance::fullness,
    residual::{RayModel, dot},
};

/// Outline rays a view may have.
pub const MAX_OUTLINE: usize = 4096;

/// One ray that touches the fruit's outline. Five floats in this order, also for C.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OutlineRay {
    /// Point of the ray at the depth of the fruit's last pixel, mm, camera frame.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub inner: Point3,
    /// Depth (z) of what is behind, mm; infinity where the camera saw nothing there.
    pub outer_mm: f32,
    /// Standard deviation of the ray's direction, rad.
    pub sigma_rad: f32,
}

/// A ray's demand on a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touch {
    pub(crate) u: [f32; 3],
    pub(crate) value: f32,
    /// `k^2`.
    leverage_squared: f32,
    sigma_squared: f32,
}

/// The inner point must be within this part of the surface: `||w| - 1| < 0.4`.
const INNER: f32 = 0.4;
/// What is behind must be this much behind the closest approach, in units of the shortest semi-axis.
const CLEAR: f32 = 0.36;
/// The inner point may be in front of the closest approach by this much, in units of the longest semi-axis ...
const FRONT: f32 = 1.2;
/// ... and behind it by this much, in units of the shortest.
const BEHIND: f32 = 0.55;

impl OutlineRay {
    /// What the ray demands of the model, if it can be the model's: the fruit's pixel near its surface, the other one
    /// clearly behind. `short` and `long` are the model's semi-axes, `axial_mm` the noise along the ray.
    pub(crate) fn touch(&self, model: &RayModel, short: f32, long: f32, axial_mm: f32) -> Option<Touch> {
        let approach = model.approach(&self.inner);
        let size = libm::sqrtf(dot(approach.w, approach.w));
        let depth = self.inner.z * (1.0 + approach.nearest);
        let slack = 3.0 * axial_mm;
        let behind = self.inner.z - depth;
        let fits = size > 1.0 - INNER
            && size < 1.0 + INNER
            && self.outer_mm > depth + (CLEAR * short + slack)
            && behind > -(FRONT * long)
            && behind < BEHIND * short + slack;
        if !fits {
            return None;
        }
        let distance = libm::sqrtf(approach.miss_squared);
        if !(distance > 0.25) {
            return None;
        }
        let u = approach.e.map(|x| x / distance);
        Some(Touch {
            u,
            value: distance - 1.0,
            leverage_squared: (depth * depth) * model.gradient_squared(u),
            sigma_squared: self.sigma_rad * self.sigma_rad,
        })
    }
}

impl Touch {
    /// The same with a deviation `by` times as large.
    pub(crate) fn widened(self, by: f32) -> Self {
        Self { sigma_squared: self.sigma_squared * (by * by), ..self }
    }

    /// Variance of `F`.
    pub(crate) fn variance(&self) -> f32 {
        self.sigma_squared * self.leverage_squared
    }

    /// `k`: how fast `F` falls as the ray is displaced outward.
    pub(crate) fn lever(&self) -> f32 {
        libm::sqrtf(self.leverage_squared)
    }

    /// `F^2 / variance`, the body's surface at `1 + boxiness phi`.
    pub(crate) fn square(&self, boxiness: f32) -> f32 {
        let value = self.value - boxiness * fullness(self.u);
        (value * value) / self.variance()
    }
}
