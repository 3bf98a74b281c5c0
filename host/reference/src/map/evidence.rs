//! What a model is held against: members, labels and outline rays (contract, chapters M3 and M7).

use super::algebra::{Vector, dot, minus};
use super::contact::{Approach, phi};
use super::model::Model;
use super::prior::Terms;
use super::view::{OutlineRay, View};
use crate::Point;
use crate::fault::{self, Fault};

/// M3, listing: all points within `radius` of `centre`, ascending.
pub(crate) fn listed(view: &View, centre: Point, radius: f32) -> Vec<u16> {
    let mut list = Vec::new();
    for (index, &p) in view.points.iter().enumerate() {
        let d = minus(p, centre);
        if dot(d, d) <= radius * radius {
            list.push(index as u16);
        }
    }
    list
}

/// The members of a model and its label, among the points of a view and their labels.
#[derive(Clone, Copy)]
pub(crate) struct Evidence<'a> {
    pub(crate) view: &'a View,
    pub(crate) labels: &'a [u8],
    pub(crate) members: &'a [u16],
    pub(crate) label: u8,
}

impl Evidence<'_> {
    pub(crate) fn point(&self, member: u16) -> Point {
        self.view.points[member as usize]
    }

    pub(crate) fn in_mask(&self, member: u16) -> bool {
        (member as usize) < self.view.in_mask
    }

    /// M3: label 0 or the model's.
    pub(crate) fn unclaimed(&self, member: u16) -> bool {
        let label = self.labels[member as usize];
        label == 0 || label == self.label
    }

    /// M3: unclaimed and in the mask.
    pub(crate) fn open(&self, member: u16) -> bool {
        self.unclaimed(member) && self.in_mask(member)
    }

    /// M7: the residuals of all rays that fit, in order.
    pub(crate) fn touching(&self, model: &Model, terms: &Terms) -> Vec<Touch> {
        let mut touching = Vec::new();
        let [first, _, third] = model.semi_axes;
        for ray in &self.view.outline {
            touching.extend(Touch::of(ray, model, [first, third], terms.noise.axial, terms.wider));
        }
        touching
    }
}

/// M7: the residual of an outline ray that fits.
pub(crate) struct Touch {
    pub(crate) u: Vector,
    /// `F`.
    pub(crate) value: f32,
    /// `var`.
    pub(crate) variance: f32,
    pub(crate) lever: f32,
}

impl Touch {
    /// M7: `touch`.
    pub(crate) fn of(
        ray: &OutlineRay,
        model: &Model,
        [first, third]: [f32; 2],
        axial_noise: f32,
        wider: f32,
    ) -> Option<Self> {
        let Approach { w, near, e, miss, .. } = Approach::new(model, ray.inner);
        let size = libm::sqrtf(dot(w, w));
        let depth = ray.inner[2] * (1.0 + near);
        let slack = 3.0 * axial_noise;
        let behind = ray.inner[2] - depth;
        let distance = libm::sqrtf(miss);
        let fits = size > 0.6
            && size < 1.4
            && ray.outer > depth + (0.36 * third + slack)
            && behind > -(1.2 * first)
            && behind < 0.55 * third + slack
            && distance > 0.25;
        if !fits {
            return None;
        }
        let u = [e[0] / distance, e[1] / distance, e[2] / distance];
        let lev2 = if fault::is(Fault::Ray) {
            depth * (depth * model.grad2(u))
        } else {
            (depth * depth) * model.grad2(u)
        };
        Some(Self {
            u,
            value: distance - 1.0,
            variance: ((ray.sigma * ray.sigma) * (wider * wider)) * lev2,
            lever: libm::sqrtf(lev2),
        })
    }

    /// M7: `Fk` on a body of boxiness `k`.
    pub(crate) fn on_body(&self, k: f32) -> f32 {
        self.value - k * phi(self.u)
    }

    /// M7: `f2` on a body of boxiness `k`.
    pub(crate) fn f2(&self, k: f32) -> f32 {
        let value = self.on_body(k);
        (value * value) / self.variance
    }
}
