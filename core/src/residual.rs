//! Where the viewing ray of a point meets the model, and the residual there.
//!
//! In: an ellipsoid and a point, mm, camera frame. Out: `F`, its variance and its derivatives. The camera is at the
//! origin, so the ray of a measured point `p` is `(1 + s) p`, with `s = 0` at the point. With `M = D^-1 R` (rows: axis
//! divided by semi-axis) the model is `|M (x - c)| = 1`. Let `w = M (p - c)` and `q = M p`; along the ray
//! `u(s) = w + s q`. The closest approach is at `s* = -(w.q) / (q.q)`, `e = u(s*)`.
//!
//! * `|e| < 1`, the ray hits: the front point is at `s = s* - h`, `h = sqrt((1 - e.e) / q.q)`, `u = e - h q`. The
//!   residual is the difference in depth times the slope of `|u|` along the ray: `F = -s (u.q)`.
//! * `|e| >= 1`, it misses: the residual is taken at the closest approach, where the slope along the ray vanishes:
//!   `F = |e| - 1`, `u = e / |e|`.
//!
//! Evaluating the residual at the model's point and not at the noisy one is what keeps the fit unbiased: the gradient
//! at a noisy point behind the surface belongs to another, smaller ellipsoid.
//!
//! Variance of `F`, with `g = D^-1 u` the gradient in the body's frame: `s_ax^2 (u.q)^2 / |c|^2 + s_lat^2 |c|^2 |g|^2`,
//! `s_ax` in mm along the ray and `s_lat` in rad across it. The range of the centre stands for that of the point: one
//! division less, and a few per cent of a standard deviation do not matter.
//!
//! Derivatives at `u` in the parameters of `crate::refine`: `dF/dc = -g` (body frame),
//! `dF/dr = (u2 u3 (b/c - c/b), u3 u1 (c/a - a/c), u1 u2 (a/b - b/a))`, `dF/d ln a_k = -u_k^2`: products of `u` and constants.
//!
//! Without a viewpoint (a complete surface from a scanner) there is no ray: `u = w / |w|`, `F = |w| - 1`, and all of
//! the noise counts across the surface.

use crate::{
    Ellipsoid, Point3,
    foot::{Foot, foot},
};

/// How well the camera measures.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Noise {
    /// Standard deviation along the viewing ray, mm.
    pub axial_mm: f32,
    /// Standard deviation across it, radians: pixels divided by the focal length in pixels.
    pub lateral_rad: f32,
}

/// From where the points were seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Viewpoint {
    /// From the origin of the cloud's frame: a depth camera. Fruit show their near side.
    #[default]
    Origin,
    /// From all around: a scanner. Nothing is hidden and nothing is seen through.
    None,
}

/// An ellipsoid prepared for the rays of points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayModel {
    centre: [f32; 3],
    /// `M`, rows.
    to_unit: [[f32; 3]; 3],
    /// `1 / a, 1 / b, 1 / c`.
    inverse_axes: [f32; 3],
    /// `b/c - c/b`, `c/a - a/c`, `a/b - b/a`.
    turning: [f32; 3],
    /// `s_ax^2 / |c|^2`.
    axial: f32,
    /// `s_lat^2 |c|^2`; without a viewpoint `s_ax^2`.
    lateral: f32,
    /// `|c|`, mm.
    range: f32,
    /// `1 / |c|^2`.
    inverse_range_squared: f32,
    viewpoint: Viewpoint,
}

/// The closest approach of a ray, see the head of this module.
pub(crate) struct Approach {
    pub(crate) w: [f32; 3],
    q: [f32; 3],
    inverse: f32,
    /// `s*`.
    pub(crate) nearest: f32,
    pub(crate) e: [f32; 3],
    pub(crate) miss_squared: f32,
}

/// Where a ray meets the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Unit-sphere coordinates of the model's point.
    pub u: [f32; 3],
    /// The same of the closest approach, `e`.
    pub e: [f32; 3],
    /// `e.e`: how centrally the ray passes, 0 = through the centre, 1 = grazing.
    pub miss_squared: f32,
    /// `F`, dimensionless: negative where the measured point is behind the surface.
    pub value: f32,
    /// Variance of `F`.
    pub variance: f32,
    /// How far the measured point is behind the model's along the ray, mm.
    pub gap_mm: f32,
}

impl Contact {
    /// `F^2 / variance`.
    #[inline(always)]
    pub fn square(&self) -> f32 {
        (self.value * self.value) / self.variance
    }
}

/// Inner product, summed from the left.
#[inline(always)]
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl RayModel {
    /// Prepares an ellipsoid; semi-axes in any order.
    pub fn new(ellipsoid: &Ellipsoid, noise: &Noise, viewpoint: Viewpoint) -> Self {
        let at = &ellipsoid.centre;
        let centre = [at.x, at.y, at.z];
        let [a, b, c] = ellipsoid.semi_axes;
        let [ia, ib, ic] = [1.0 / a, 1.0 / b, 1.0 / c];
        let row = |axis: [f32; 3], inverse: f32| axis.map(|x| x * inverse);
        let [ra, rb, rc] = ellipsoid.axes;
        let range_squared = dot(centre, centre);
        let (axial, lateral) = match viewpoint {
            Viewpoint::Origin => (
                (noise.axial_mm * noise.axial_mm) / range_squared,
                (noise.lateral_rad * noise.lateral_rad) * range_squared,
            ),
            Viewpoint::None => (0.0, noise.axial_mm * noise.axial_mm),
        };
        Self {
            centre,
            to_unit: [row(ra, ia), row(rb, ib), row(rc, ic)],
            inverse_axes: [ia, ib, ic],
            turning: [b * ic - c * ib, c * ia - a * ic, a * ib - b * ia],
            axial,
            lateral,
            range: libm::sqrtf(range_squared),
            inverse_range_squared: 1.0 / range_squared,
            viewpoint,
        }
    }

    /// `M x`.
    #[inline(always)]
    fn unit(&self, x: [f32; 3]) -> [f32; 3] {
        let m = &self.to_unit;
        [dot(m[0], x), dot(m[1], x), dot(m[2], x)]
    }

    /// `|g|^2` at `u`.
    #[inline(always)]
    pub(crate) fn gradient_squared(&self, u: [f32; 3]) -> f32 {
        let g = [u[0] * self.inverse_axes[0], u[1] * self.inverse_axes[1], u[2] * self.inverse_axes[2]];
        dot(g, g)
    }

    /// The closest approach of the ray of `p` to the centre, in unit-sphere coordinates. About 60 flops, one division.
    #[inline(always)]
    pub(crate) fn approach(&self, p: &Point3) -> Approach {
        let w = self.unit([p.x - self.centre[0], p.y - self.centre[1], p.z - self.centre[2]]);
        let q = self.unit([p.x, p.y, p.z]);
        let inverse = 1.0 / dot(q, q);
        let nearest = -(dot(w, q) * inverse);
        let e = [w[0] + nearest * q[0], w[1] + nearest * q[1], w[2] + nearest * q[2]];
        Approach { w, q, inverse, nearest, e, miss_squared: dot(e, e) }
    }

    /// Meets the ray of `p` with the model. About 95 flops, two divisions, one square root.
    #[inline(always)]
    pub fn contact(&self, p: &Point3) -> Contact {
        if self.viewpoint == Viewpoint::None {
            let d = [p.x - self.centre[0], p.y - self.centre[1], p.z - self.centre[2]];
            return self.radial(self.unit(d));
        }
        let Approach { q, inverse, nearest, e, miss_squared, .. } = self.approach(p);
        let inside = 1.0 - miss_squared;
        if inside > 0.0 {
            let half = libm::sqrtf(inside * inverse);
            let u = [e[0] - half * q[0], e[1] - half * q[1], e[2] - half * q[2]];
            let slope = dot(u, q);
            let gap = half - nearest;
            let along = slope * slope;
            let across = self.gradient_squared(u) - along * self.inverse_range_squared;
            let variance = self.axial * along + self.lateral * if across > 0.0 { across } else { 0.0 };
            Contact { u, e, miss_squared, value: gap * slope, variance, gap_mm: gap * self.range }
        } else {
            let size = libm::sqrtf(miss_squared);
            let u = e.map(|x| x / size);
            let variance = self.lateral * self.gradient_squared(u);
            Contact { u, e, miss_squared, value: size - 1.0, variance, gap_mm: -(nearest * self.range) }
        }
    }

    /// The contact at the point of the surface nearest to `p`: `F` is the distance times `|g|`, and all of the noise counts
    /// across the surface.
    #[inline]
    pub(crate) fn perpendicular(&self, p: &Point3) -> Contact {
        let w = self.unit([p.x - self.centre[0], p.y - self.centre[1], p.z - self.centre[2]]);
        let Foot { u, t } = foot(w, self.inverse_axes.map(|inverse| inverse * inverse));
        let gradient_squared = self.gradient_squared(u);
        let variance = self.lateral * gradient_squared;
        Contact { u, e: w, miss_squared: dot(w, w), value: t * gradient_squared, variance, gap_mm: 0.0 }
    }

    /// Mean curvature over `|g|` at `u`: 1 on a sphere, and 1 on average over the area of any ellipsoid. With `k` one over
    /// the squares of the semi-axes, `G = sum u_i^2 k_i = |g|^2` and `Q = sum u_i^2 k_i^2` it is `(sum k_i - Q / G) / 2 G`.
    #[inline]
    pub(crate) fn bend(&self, u: [f32; 3]) -> f32 {
        let k = self.inverse_axes.map(|inverse| inverse * inverse);
        let v = [u[0] * k[0], u[1] * k[1], u[2] * k[2]];
        let g = dot(u, v);
        0.5 * (((k[0] + k[1] + k[2]) - dot(v, v) / g) / g)
    }

    /// The contact on the line from the centre: there is no ray.
    fn radial(&self, w: [f32; 3]) -> Contact {
        let miss_squared = dot(w, w);
        let size = libm::sqrtf(miss_squared);
        let u = if size > 0.0 { w.map(|x| x / size) } else { [1.0, 0.0, 0.0] };
        let variance = self.lateral * self.gradient_squared(u);
        Contact { u, e: w, miss_squared, value: size - 1.0, variance, gap_mm: 0.0 }
    }

    /// The contact as if the ray had to pass beside the model: taken at the closest approach whether it hits or not.
    /// This is what a point far behind the model demands of the model's outline.
    #[inline]
    pub fn beside(&self, contact: &Contact) -> Contact {
        let size = libm::sqrtf(contact.miss_squared);
        let u = contact.e.map(|x| x / size);
        let variance = self.lateral * self.gradient_squared(u);
        Contact { u, value: size - 1.0, variance, ..*contact }
    }

    /// The part of the contact's variance that comes from noise across the ray, 0..=1.
    pub(crate) fn lateral_share(&self, contact: &Contact) -> f32 {
        if self.viewpoint == Viewpoint::None {
            return 0.0;
        }
        let slope =
            if contact.miss_squared < 1.0 { contact.value / (contact.gap_mm / self.range) } else { 0.0 };
        1.0 - self.axial * (slope * slope) / contact.variance
    }

    /// The constants `s` of the derivatives `J_k = s_k phi_k(u)`, see [`crate::moments`]: centre (body frame, per mm),
    /// rotation (body frame, per rad), logarithms of the semi-axes.
    pub(crate) fn constants(&self) -> [f32; 9] {
        let [ia, ib, ic] = self.inverse_axes;
        let [t1, t2, t3] = self.turning;
        [-ia, -ib, -ic, t1, t2, t3, -1.0, -1.0, -1.0]
    }
}
