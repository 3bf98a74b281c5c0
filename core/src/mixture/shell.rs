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
    nuisance::Nuisances,
    outline::OutlineRay,
    point::at,
    refine::{Estimate, Kernel, Normal, OUTLINE_KERNEL},
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

/// What the shell is fitted to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Data<'a> {
    pub(crate) cloud: &'a [Point3],
    /// The points that count, in the order of the sums.
    pub(crate) list: &'a [u16],
    /// Rays that may touch the outline; with [`Distance::Ray`] only.
    pub(crate) outline: &'a [OutlineRay],
    /// Standard deviation of their common displacement, rad.
    pub(crate) offset_rad: f32,
    pub(crate) frame: &'a Frame,
    pub(crate) distance: Distance,
}

/// What a point is to the surface.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Seen {
    /// Perhaps on it: `d^2 / sigma^2` and `k`.
    Near { square: f32, k: f32 },
    /// Far behind it along its ray.
    Past,
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
    /// Sum of `r B phi`, `B` the curvature of [`RayModel::bend`], at most [`BEND`]; orthogonal distances only.
    bend: [f32; 6],
    rays: Option<Nuisances>,
}

/// `d^2 / sigma^2` beyond which a point is not the surface's: `e^-20`.
const FAR: f32 = 40.0;
/// At the tips of a long body the curvature is too large for a correction to first order: it counts as that of a sphere.
const BEND: f32 = 1.0;
/// Window along the ray over the smallest semi-axis.
const WINDOW: f32 = 0.55;
/// A ray that passes closer to the centre than half way does not ask the model to step aside.
const DEEP: f32 = 0.25;
/// `2^2`, Geman-McClure, of points seen past the model.
const PUSH: Kernel = Kernel::GemanMcClure(4.0);
/// A point seen through the model well inside its rim costs this much of the gain.
const THROUGH: f32 = 1.5;
const WELL_INSIDE: f32 = 0.75;
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

    /// Along the ray a point further from the model's point than this is not the surface's; without rays no point is.
    pub(crate) fn window(&self, distance: Distance) -> f32 {
        match distance {
            Distance::Ray { .. } => WINDOW * smallest(&self.estimate.ln_axes),
            Distance::Radial | Distance::Orthogonal => f32::INFINITY,
        }
    }

    /// `K` with the area given by its logarithm.
    pub(crate) fn odds(&self, volume: f32, ln_area: f32) -> f32 {
        let scale = libm::expf(-(ln_area + LN_SQRT_2_PI)) / self.sigma;
        ((self.share * volume) / (1.0 - self.share)) * scale
    }

    /// Looks at the listed points in order.
    #[inline(always)]
    fn look(&self, data: &Data<'_>, model: &RayModel, ln_area: f32, mut tell: impl FnMut(&Contact, Seen)) {
        let odds = self.odds(data.frame.volume, ln_area);
        let window = self.window(data.distance);
        for &index in data.list {
            let contact = contact(model, &data.frame.local(&at(data.cloud, index)), data.distance);
            if contact.gap_mm > window {
                tell(&contact, Seen::Past);
                continue;
            }
            let square = contact.square();
            if square < FAR && contact.gap_mm >= -window {
                tell(&contact, Seen::Near { square, k: odds * libm::expf(-0.5 * square) });
            }
        }
    }

    /// Weighs the listed points.
    pub(crate) fn pass(&self, data: &Data<'_>, ln_area: f32) -> Pass {
        let model = self.model(data.distance);
        let mut pass = Pass {
            moments: Moments::ZERO,
            constants: model.constants(),
            members: 0.0,
            squares: 0.0,
            bend: [0.0; 6],
            rays: None,
        };
        self.look(data, &model, ln_area, |contact, seen| {
            let Seen::Near { square, k } = seen else {
                push_aside(&mut pass.moments, &model, contact);
                return;
            };
            let r = k / (1.0 + k);
            pass.moments.add(contact.u, contact.value, r / contact.variance);
            if data.distance == Distance::Orthogonal {
                let bend = model.bend(contact.u);
                let share = r * if bend < BEND { bend } else { BEND };
                let [x, y, z] = contact.u;
                for (sum, phi) in pass.bend.iter_mut().zip([x, y, z, y * z, z * x, x * y]) {
                    *sum += share * phi;
                }
            }
            pass.members += r;
            pass.squares += r * square;
        });
        pass.rays = self.touch(data, &model, &mut pass.moments);
        pass
    }

    /// The information of the listed points, the negative second derivative of the log-likelihood: a point that may or may
    /// not be the surface's says less than its `r`, by the factor `1 - (1 - r) d^2 / sigma^2`.
    pub(crate) fn information(&self, data: &Data<'_>, ln_area: f32) -> Normal {
        let model = self.model(data.distance);
        let mut moments = Moments::ZERO;
        self.look(data, &model, ln_area, |contact, seen| {
            let Seen::Near { square, k } = seen else {
                push_aside(&mut moments, &model, contact);
                return;
            };
            let r = k / (1.0 + k);
            moments.add(contact.u, contact.value, (r * (1.0 - (1.0 - r) * square)) / contact.variance);
        });
        let rays = self.touch(data, &model, &mut moments);
        let constants = model.constants();
        let mut normal = Normal::new(&moments, &constants);
        if let Some(rays) = rays {
            rays.eliminate(&mut normal, &constants);
        }
        normal
    }

    /// Gain over uniform clutter, natural logarithm, of all listed points together.
    pub(crate) fn gain(&self, data: &Data<'_>) -> f32 {
        let model = self.model(data.distance);
        let mut sum = 0.0;
        self.look(data, &model, ln_area(&self.estimate.ln_axes).value, |contact, seen| match seen {
            Seen::Near { k, .. } => sum += libm::log1pf(k),
            Seen::Past => sum -= if contact.miss_squared < WELL_INSIDE { THROUGH } else { 0.0 },
        });
        sum + data.list.len() as f32 * libm::log1pf(-self.share)
    }

    /// Adds the outline rays that can be the model's.
    fn touch(&self, data: &Data<'_>, model: &RayModel, moments: &mut Moments) -> Option<Nuisances> {
        if data.outline.is_empty() || !matches!(data.distance, Distance::Ray { .. }) {
            return None;
        }
        let (short, long) = (smallest(&self.estimate.ln_axes), largest(&self.estimate.ln_axes));
        let mut rays = Nuisances::new([data.offset_rad, 0.0], 0.0);
        for ray in data.outline {
            let local = data.frame.local_ray(ray);
            if let Some(touch) = local.touch(model, short, long, self.sigma)
                && let Some(weight) = OUTLINE_KERNEL.weight(touch.square(0.0))
            {
                let w = weight / touch.variance();
                moments.add(touch.u, touch.value, w);
                rays.add_ray(touch.u, touch.value, w, 0.0, touch.lever());
            }
        }
        Some(rays)
    }
}

/// A point far behind the model was seen past it: if its ray passes near the rim the outline has to give way.
#[inline]
fn push_aside(moments: &mut Moments, model: &RayModel, contact: &Contact) {
    if !(contact.miss_squared > DEEP && contact.miss_squared < 1.0) {
        return;
    }
    let beside = model.beside(contact);
    if let Some(weight) = PUSH.weight(beside.square()) {
        moments.add(beside.u, beside.value, weight / beside.variance);
    }
}

/// The smallest semi-axis.
pub(crate) fn smallest(ln_axes: &[f32; 3]) -> f32 {
    let [a, b, c] = *ln_axes;
    libm::expf(if a < b && a < c {
        a
    } else if b < c {
        b
    } else {
        c
    })
}

/// The largest semi-axis.
pub(crate) fn largest(ln_axes: &[f32; 3]) -> f32 {
    let [a, b, c] = *ln_axes;
    libm::expf(if a > b && a > c {
        a
    } else if b > c {
        b
    } else {
        c
    })
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
    /// The normal equations with the correction for the bias of noise across a curved surface.
    ///
    /// Noise in all directions leaves points outside a curved surface by `sigma^2 H` on average, `H` its mean curvature. Over
    /// a whole surface that is `+ 1/2 sum(r) ln A` on the cost, which bears on the semi-axes only and is well behaved for
    /// the thinnest body; where the points cover a part of the surface the centre and the attitude feel it too, through the
    /// curvature at each point. `weight` is 1/2, or less for less.
    pub(crate) fn normal(&self, estimate: &Estimate, weight: f32) -> Normal {
        let mut normal = Normal::new(&self.moments, &self.constants);
        if let Some(rays) = &self.rays {
            rays.eliminate(&mut normal, &self.constants);
        }
        for ((slot, constant), sum) in normal.gradient.iter_mut().zip(self.constants).zip(self.bend) {
            *slot -= (2.0 * weight) * (constant * sum);
        }
        let scale = weight * self.members;
        for (slot, slope) in normal.gradient.iter_mut().skip(6).zip(ln_area(&estimate.ln_axes).slopes) {
            *slot += scale * slope;
        }
        normal
    }
}
