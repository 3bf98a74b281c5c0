//! The mixture: points near the surface of an ellipsoid, and points anywhere.
//!
//! A share `w` of the points lies on the surface, uniform by area, with a normal error `sigma` across it (or along the
//! viewing ray): density `w exp(-d^2 / 2 sigma^2) / (A sigma sqrt(2 pi))`. The others are uniform over the volume `V`. A point
//! belongs to the surface with probability `r = k / (1 + k)`, `k = K exp(-d^2 / 2 sigma^2)`,
//! `K = w V / ((1 - w) A sigma sqrt(2 pi))`; its gain over uniform clutter is `ln(1 - w) + ln(1 + k)`.
//!
//! A pass over the points gives the normal equations of the nine parameters with the `r` as weights, and what the next
//! `sigma` and `w` are made of.

use crate::{
    Point3,
    mixture::{area::ln_area, frame::Frame},
    moments::Moments,
    point::at,
    refine::{Estimate, Normal},
    residual::{Contact, Noise, RayModel, Viewpoint},
};

/// An ellipsoid with its noise and its share of the points; local units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shell {
    pub(crate) estimate: Estimate,
    pub(crate) sigma: f32,
    pub(crate) share: f32,
}

/// How the distance of a point is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Distance {
    /// To first order, at the point's projection from the centre.
    Radial,
    /// To the nearest point of the surface.
    Orthogonal,
    /// Along the viewing ray; lateral noise in rad for each local unit of axial noise.
    Ray { lateral_rad: f32 },
}

/// What a pass over the points came to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pass {
    pub(crate) moments: Moments,
    pub(crate) constants: [f32; 9],
    /// Sum of `r`.
    pub(crate) members: f32,
    /// Sum of `r d^2 / sigma^2`.
    pub(crate) squares: f32,
}

/// `d^2 / sigma^2` beyond which a point is not the surface's: `e^-20`.
const FAR: f32 = 40.0;
/// `ln sqrt(2 pi)`.
const LN_SQRT_2_PI: f32 = 0.918_938_5;

impl Shell {
    /// The model prepared for distances.
    pub(crate) fn model(&self, distance: Distance) -> RayModel {
        let (lateral_rad, viewpoint) = match distance {
            Distance::Ray { lateral_rad } => (lateral_rad * self.sigma, Viewpoint::Origin),
            Distance::Radial | Distance::Orthogonal => (0.0, Viewpoint::None),
        };
        let noise = Noise { axial_mm: self.sigma, lateral_rad };
        RayModel::new(&self.estimate.ellipsoid(), &noise, viewpoint)
    }

    /// `K` with the area given by its logarithm.
    pub(crate) fn odds(&self, volume: f32, ln_area: f32) -> f32 {
        let scale = libm::expf(-(ln_area + LN_SQRT_2_PI)) / self.sigma;
        ((self.share * volume) / (1.0 - self.share)) * scale
    }

    /// Weighs the listed points.
    pub(crate) fn pass(&self, cloud: &[Point3], list: &[u16], frame: &Frame, distance: Distance, ln_area: f32) -> Pass {
        let model = self.model(distance);
        let odds = self.odds(frame.volume, ln_area);
        let mut pass = Pass { moments: Moments::ZERO, constants: model.constants(), members: 0.0, squares: 0.0 };
        for &index in list {
            let contact = contact(&model, &frame.local(&at(cloud, index)), distance);
            let square = contact.square();
            if !(square < FAR) {
                continue;
            }
            let k = odds * libm::expf(-0.5 * square);
            let r = k / (1.0 + k);
            pass.moments.add(contact.u, contact.value, r / contact.variance);
            pass.members += r;
            pass.squares += r * square;
        }
        pass
    }

    /// Gain over uniform clutter, natural logarithm, of all listed points together.
    pub(crate) fn gain(&self, cloud: &[Point3], list: &[u16], frame: &Frame, distance: Distance) -> f32 {
        let model = self.model(distance);
        let odds = self.odds(frame.volume, ln_area(&self.estimate.ln_axes).value);
        let mut sum = 0.0;
        for &index in list {
            let square = contact(&model, &frame.local(&at(cloud, index)), distance).square();
            if square < FAR {
                sum += libm::log1pf(odds * libm::expf(-0.5 * square));
            }
        }
        sum + list.len() as f32 * libm::log1pf(-self.share)
    }
}

/// The contact of a local point with the model.
#[inline(always)]
pub(crate) fn contact(model: &RayModel, p: &Point3, distance: Distance) -> Contact {
    match distance {
        Distance::Orthogonal => model.perpendicular(p),
        Distance::Radial | Distance::Ray { .. } => model.contact(p),
    }
}

impl Pass {
    /// The normal equations, with `weight` of the logarithm of the area for each member: `+ weight sum(r) ln A`.
    pub(crate) fn normal(&self, estimate: &Estimate, weight: f32) -> Normal {
        let mut normal = Normal::new(&self.moments, &self.constants);
        let scale = weight * self.members;
        for (slot, slope) in normal.gradient.iter_mut().skip(6).zip(ln_area(&estimate.ln_axes).slopes) {
            *slot += scale * slope;
        }
        normal
    }
}
