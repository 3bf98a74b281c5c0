//! Where the ray of a point meets the model, and what that says: contract, chapters M5 and M6.

use super::algebra::{Vector, dot, minus};
use super::model::Model;
use super::view::Viewpoint;
use crate::Point;
use crate::fault::{self, Fault};

/// M5: where the ray of a point comes closest to the centre, in coordinates of the unit sphere.
pub(crate) struct Approach {
    pub(crate) w: Vector,
    pub(crate) q: Vector,
    pub(crate) inv: f32,
    pub(crate) near: f32,
    pub(crate) e: Vector,
    pub(crate) miss: f32,
}

impl Approach {
    pub(crate) fn new(model: &Model, p: Point) -> Self {
        let w = model.times(minus(p, model.centre));
        let q = model.times(p);
        let inv = 1.0 / dot(q, q);
        let near = -(dot(w, q) * inv);
        let e = [w[0] + near * q[0], w[1] + near * q[1], w[2] + near * q[2]];
        Self { w, q, inv, near, e, miss: dot(e, e) }
    }
}

/// M5: the residual of a point.
#[derive(Clone, Copy)]
pub(crate) struct Contact {
    pub(crate) u: Vector,
    pub(crate) e: Vector,
    pub(crate) miss: f32,
    /// `F`.
    pub(crate) value: f32,
    /// `var`.
    pub(crate) variance: f32,
    pub(crate) gap_mm: f32,
}

impl Contact {
    /// M5: the contact of a point with a model.
    pub(crate) fn new(model: &Model, p: Point) -> Self {
        match model.viewpoint {
            Viewpoint::Origin => Self::along_the_ray(model, p),
            Viewpoint::None => Self::from_the_centre(model, p),
        }
    }

    fn along_the_ray(model: &Model, p: Point) -> Self {
        let Approach { q, inv, near, e, miss, .. } = Approach::new(model, p);
        let inside = 1.0 - miss;
        if inside > 0.0 {
            let half = libm::sqrtf(inside * inv);
            let u = [e[0] - half * q[0], e[1] - half * q[1], e[2] - half * q[2]];
            let slope = dot(u, q);
            let gap = half - near;
            let along = slope * slope;
            let across = model.grad2(u) - along * model.inverse_range2;
            let across = if across > 0.0 { across } else { 0.0 };
            let value = if fault::is(Fault::Contact) { half * slope - near * slope } else { gap * slope };
            let variance = model.axial * along + model.lateral * across;
            Self { u, e, miss, value, variance, gap_mm: gap * model.range }
        } else {
            Self { e, miss, gap_mm: -(near * model.range), ..Self::beside_of(model, e, miss) }
        }
    }

    fn from_the_centre(model: &Model, p: Point) -> Self {
        let e = model.times(minus(p, model.centre));
        let miss = dot(e, e);
        let size = libm::sqrtf(miss);
        let u = if size > 0.0 { [e[0] / size, e[1] / size, e[2] / size] } else { [1.0, 0.0, 0.0] };
        Self { u, e, miss, value: size - 1.0, variance: model.lateral * model.grad2(u), gap_mm: 0.0 }
    }

    /// M5: *beside*.
    pub(crate) fn beside(&self, model: &Model) -> Self {
        Self { gap_mm: self.gap_mm, ..Self::beside_of(model, self.e, self.miss) }
    }

    fn beside_of(model: &Model, e: Vector, miss: f32) -> Self {
        let size = libm::sqrtf(miss);
        let u = [e[0] / size, e[1] / size, e[2] / size];
        Self { u, e, miss, value: size - 1.0, variance: model.lateral * model.grad2(u), gap_mm: 0.0 }
    }

    /// M5: `f2`.
    pub(crate) fn f2(&self) -> f32 {
        (self.value * self.value) / self.variance
    }

    /// M5: within the window.
    pub(crate) fn within(&self, window: f32) -> bool {
        self.gap_mm < window && self.gap_mm > -window
    }

    /// M5: sight.
    pub(crate) fn sight(&self, window: f32) -> Sight {
        let f2 = self.f2();
        if f2 < 6.25 && self.within(window) {
            Sight::Explained(f2)
        } else if self.gap_mm > 0.0 && f2 >= 6.25 && self.miss < 0.75 {
            Sight::Through
        } else {
            Sight::Unrelated
        }
    }
}

/// M5: what a point is to a model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sight {
    /// Of the surface, with `f2`.
    Explained(f32),
    /// Seen through it.
    Through,
    /// Neither.
    Unrelated,
}

/// M6: fullness.
pub(crate) fn phi([x, y, z]: Vector) -> f32 {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    2.0 * ((xx * yy + yy * zz) + zz * xx)
}

/// M6: how a residual is weighted.
#[derive(Clone, Copy)]
pub(crate) enum Kernel {
    GemanMcClure(f32),
    Tukey(f32),
}

impl Kernel {
    /// M6: the weight at `f2`, if there is one.
    pub(crate) fn weight(self, f2: f32) -> Option<f32> {
        match self {
            Self::GemanMcClure(m) => {
                let h = 1.0 + f2 / m;
                let weight =
                    if fault::is(Fault::GemanMcClure) { (1.0 / h) * (1.0 / h) } else { 1.0 / (h * h) };
                (f2 < 100.0).then_some(weight)
            }
            Self::Tukey(m) => {
                let h = 1.0 - f2 / m;
                let weight = if fault::is(Fault::Tukey) { h } else { h * h };
                (f2 < m).then_some(weight)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::model::Estimate;
    use super::super::view::Noise;
    use super::*;

    /// A sphere of radius 10, 100 mm away, seen with a noise of 1 mm along the ray.
    fn sphere(viewpoint: Viewpoint) -> Model {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let x = [libm::logf(10.0); 3];
        let estimate = Estimate { centre: [0.0, 0.0, 100.0], axes, x, boxiness: 0.0 };
        Model::new(&estimate, Noise { axial: 1.0, lateral: 0.001 }, viewpoint)
    }

    #[test]
    fn a_point_behind_the_pole_has_its_distance_as_residual() {
        let c = Contact::new(&sphere(Viewpoint::Origin), [0.0, 0.0, 93.0]);
        assert!((c.gap_mm - 3.0 * 100.0 / 93.0).abs() < 1e-2 && c.miss < 1e-9);
        assert!((c.value + 0.3).abs() < 1e-4, "behind the surface: inside of it, by 3 of 10 mm");
        assert!((c.f2() - c.gap_mm * c.gap_mm).abs() < 0.05, "deviations of 1 mm");
        assert_eq!(c.sight(5.5), Sight::Through);
        let c = Contact::new(&sphere(Viewpoint::Origin), [0.0, 0.0, 90.5]);
        assert!(matches!(c.sight(5.5), Sight::Explained(f2) if (f2 - 0.305).abs() < 0.001));
    }

    #[test]
    fn a_ray_that_misses_has_the_closest_approach() {
        let c = Contact::new(&sphere(Viewpoint::Origin), [12.0, 0.0, 100.0]);
        assert!(c.miss > 1.4 && c.value > 0.18 && c.value < 0.2);
        assert_eq!(c.sight(5.5), Sight::Unrelated);
    }

    #[test]
    fn without_a_viewpoint_the_distance_from_the_centre_counts() {
        let model = sphere(Viewpoint::None);
        let c = Contact::new(&model, [0.0, 5.0, 100.0]);
        assert!((c.value + 0.5).abs() < 1e-6 && c.gap_mm == 0.0);
        assert_eq!(Contact::new(&model, [0.0, 0.0, 100.0]).u, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn kernels_end_where_they_say() {
        assert_eq!(Kernel::GemanMcClure(4.0).weight(4.0), Some(0.25));
        assert_eq!(Kernel::GemanMcClure(4.0).weight(100.0), None);
        assert_eq!(Kernel::Tukey(16.0).weight(8.0), Some(0.25));
        assert_eq!(Kernel::Tukey(16.0).weight(f32::NAN), None);
        assert_eq!(phi([1.0, 0.0, 0.0]), 0.0);
    }
}
