//! Where the viewing ray of a point meets the model, and the residual there.
//!
//! The camera is at the origin, so the ray of a measured point `p` is `t p`, with `t = 1` at the point. With
//! `M = D^-1 R` (rows: axis / semi-axis) the model is `|M (x - c)| = 1`. Let `w = M (p - c)`, `q = M p`; along the ray
//! `u(s) = w + s q`, `s = t - 1`. The closest approach is at `s* = -(w.q) / (q.q)`, `e = u(s*)`.
//!
//! * `|e| < 1`, the ray hits: the front point is `s = s* - h`, `h = sqrt((1 - e.e) / q.q)`, `u = e - h q`. The residual
//!   is the difference in depth times the slope of `F = |u| - 1` along the ray: `F = -s (u.q)`.
//! * `|e| >= 1`, it misses: the residual is taken at the closest approach: `F = |e| - 1`, `u = e / |e|`; the slope
//!   along the ray vanishes there.
//!
//! Evaluating the residual at the model's point and not at the noisy one is what keeps the fit unbiased: at a noisy
//! point behind the surface the gradient of a small ellipsoid is already another one.
//!
//! Variance of `F`: `s_ax^2 (u.q)^2 / |c|^2 + s_lat^2 |c|^2 |g|^2`, with `g = D^-1 u` the gradient in the body's frame,
//! `s_ax` in mm along the ray and `s_lat` in rad across it; the range of the centre stands for that of the point (one
//! division less, and a few per cent of a standard deviation do not matter).
//!
//! Derivatives at `u`, in the nine parameters of [`crate::refine`]: `dF/dc = -g` (body frame),
//! `dF/dr = (u2 u3 (b/c - c/b), u3 u1 (c/a - a/c), u1 u2 (a/b - b/a))`, `dF/d ln a_k = -u_k^2`.

use crate::{Ellipsoid, Point3};

/// How well the camera measures.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Noise {
    /// Standard deviation along the viewing ray, mm.
    pub axial_mm: f32,
    /// Standard deviation across it, radians (pixels divided by the focal length in pixels).
    pub lateral_rad: f32,
}

/// An ellipsoid prepared for rays from the origin.
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
    /// `s_lat^2 |c|^2`.
    lateral: f32,
}

/// Where a ray meets the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Unit-sphere coordinates of the model's point.
    pub u: [f32; 3],
    /// `F`, dimensionless: negative where the measured point is behind the surface.
    pub value: f32,
    /// Variance of `F`.
    pub variance: f32,
    /// How far the measured point is behind the model's, in units of its own range.
    pub gap: f32,
    /// `e.e`: how centrally the ray passes, 0 = through the centre, 1 = grazing.
    pub miss_squared: f32,
}

#[inline(always)]
fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl RayModel {
    /// Prepares an ellipsoid; semi-axes in any order.
    pub fn new(ellipsoid: &Ellipsoid, noise: &Noise) -> Self {
        let c = &ellipsoid.centre;
        let centre = [c.x, c.y, c.z];
        let [a, b, c] = ellipsoid.semi_axes;
        let inverse_axes = [1.0 / a, 1.0 / b, 1.0 / c];
        let [ia, ib, ic] = inverse_axes;
        let row = |axis: [f32; 3], inverse: f32| axis.map(|x| x * inverse);
        let [ra, rb, rc] = ellipsoid.axes;
        let range_squared = dot(centre, centre);
        Self {
            centre,
            to_unit: [row(ra, ia), row(rb, ib), row(rc, ic)],
            inverse_axes,
            turning: [b * ic - c * ib, c * ia - a * ic, a * ib - b * ia],
            axial: (noise.axial_mm * noise.axial_mm) / range_squared,
            lateral: (noise.lateral_rad * noise.lateral_rad) * range_squared,
        }
    }

    /// Meets the ray of `p` with the model. About 95 flops, three divisions, one square root.
    #[inline(always)]
    pub fn contact(&self, p: &Point3) -> Contact {
        let ray = [p.x, p.y, p.z];
        let d = [p.x - self.centre[0], p.y - self.centre[1], p.z - self.centre[2]];
        let m = &self.to_unit;
        let w = [dot(m[0], d), dot(m[1], d), dot(m[2], d)];
        let q = [dot(m[0], ray), dot(m[1], ray), dot(m[2], ray)];
        let inverse = 1.0 / dot(q, q);
        let nearest = -(dot(w, q) * inverse);
        let e = [w[0] + nearest * q[0], w[1] + nearest * q[1], w[2] + nearest * q[2]];
        let miss_squared = dot(e, e);
        let inside = 1.0 - miss_squared;
        let (u, value, slope, gap);
        if inside > 0.0 {
            let half = libm::sqrtf(inside * inverse);
            u = [e[0] - half * q[0], e[1] - half * q[1], e[2] - half * q[2]];
            slope = dot(u, q);
            gap = half - nearest;
            value = gap * slope;
        } else {
            let size = libm::sqrtf(miss_squared);
            let unit = 1.0 / size;
            u = [e[0] * unit, e[1] * unit, e[2] * unit];
            slope = 0.0;
            gap = -nearest;
            value = size - 1.0;
        }
        let g = [u[0] * self.inverse_axes[0], u[1] * self.inverse_axes[1], u[2] * self.inverse_axes[2]];
        let variance = self.axial * (slope * slope) + self.lateral * dot(g, g);
        Contact { u, value, variance, gap, miss_squared }
    }

    /// The closest approach of the ray of `p`, whether it hits or misses: `F = |e| - 1`, negative where it hits.
    #[inline(always)]
    pub fn passing(&self, p: &Point3) -> Contact {
        let ray = [p.x, p.y, p.z];
        let d = [p.x - self.centre[0], p.y - self.centre[1], p.z - self.centre[2]];
        let m = &self.to_unit;
        let w = [dot(m[0], d), dot(m[1], d), dot(m[2], d)];
        let q = [dot(m[0], ray), dot(m[1], ray), dot(m[2], ray)];
        let inverse = 1.0 / dot(q, q);
        let nearest = -(dot(w, q) * inverse);
        let e = [w[0] + nearest * q[0], w[1] + nearest * q[1], w[2] + nearest * q[2]];
        let miss_squared = dot(e, e);
        let size = libm::sqrtf(miss_squared);
        let unit = 1.0 / size;
        let u = [e[0] * unit, e[1] * unit, e[2] * unit];
        let gap = -nearest;
        let g = [u[0] * self.inverse_axes[0], u[1] * self.inverse_axes[1], u[2] * self.inverse_axes[2]];
        Contact { u, value: size - 1.0, variance: self.lateral * dot(g, g), gap, miss_squared }
    }

    /// Derivatives of `F` at the contact: centre (body frame, per mm), rotation (body frame, per rad), logarithms of
    /// the semi-axes.
    #[inline(always)]
    pub fn derivatives(&self, u: [f32; 3]) -> [f32; 9] {
        let [i1, i2, i3] = self.inverse_axes;
        let [t1, t2, t3] = self.turning;
        [
            -(u[0] * i1),
            -(u[1] * i2),
            -(u[2] * i3),
            (u[1] * u[2]) * t1,
            (u[2] * u[0]) * t2,
            (u[0] * u[1]) * t3,
            -(u[0] * u[0]),
            -(u[1] * u[1]),
            -(u[2] * u[2]),
        ]
    }
}
