//! What a list of points says of a shell: contract, chapter X6.

use super::area::Area;
use super::foot::{orthogonal, squares};
use super::numbers::{longest, smallest};
use super::shell::Shell;
use crate::fault::{self, Fault};
use crate::map::algebra::{Vector, dot};
use crate::map::contact::{Contact, Kernel};
use crate::map::evidence::Touch;
use crate::map::model::Model;
use crate::map::normal::{Follower, Normal, Residual, Row, moments};
use crate::map::view::OutlineRay;

/// X3: how the residual of a point is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Distance {
    /// From the centre outwards.
    Radial,
    /// Along the ray, with the lateral noise as a multiple of the axial.
    Ray { ratio: f32 },
    /// From the surface.
    Orthogonal,
}

/// What does not change while shells are compared.
#[derive(Clone)]
pub(crate) struct Scene {
    /// `V`.
    pub(crate) volume: f32,
    /// Local.
    pub(crate) outline: Vec<OutlineRay>,
    pub(crate) outline_offset: f32,
    pub(crate) distance: Distance,
}

/// What a point is to a shell.
enum Seen {
    /// About on the surface, with its odds `k` to be of it.
    Near(Contact, f32),
    /// Behind it.
    Past(Contact),
}

/// A shell and its points.
pub(crate) struct Look<'a> {
    scene: &'a Scene,
    shell: &'a Shell,
    pub(crate) model: Model,
    /// `K`.
    pub(crate) odds: f32,
    pub(crate) window: f32,
    seen: Vec<Seen>,
    /// Points looked at.
    pub(crate) points: usize,
}

/// X6, pass: what a climb needs to know.
pub(crate) struct Pass {
    pub(crate) normal: Normal,
    pub(crate) members: f32,
    pub(crate) squares: f32,
    pub(crate) points: usize,
}

impl<'a> Look<'a> {
    /// X6: at a list of points, with a given logarithm of the area.
    pub(crate) fn new(scene: &'a Scene, shell: &'a Shell, ln_area: f32, points: &[Vector]) -> Self {
        let model = shell.model(scene.distance);
        let odds = shell.odds(ln_area, scene.volume);
        let window = match scene.distance {
            Distance::Ray { .. } => 0.55 * smallest(shell.estimate.x),
            Distance::Radial | Distance::Orthogonal => f32::INFINITY,
        };
        let mut seen = Vec::new();
        for &p in points {
            let contact = contact(&model, scene.distance, p);
            if contact.gap_mm > window {
                seen.push(Seen::Past(contact));
            } else if contact.f2() < 40.0 && contact.gap_mm >= -window {
                seen.push(Seen::Near(contact, odds * libm::expf(-0.5 * contact.f2())));
            }
        }
        Self { scene, shell, model, odds, window, seen, points: points.len() }
    }

    /// X6, pass, with its normal equations.
    pub(crate) fn pass(&self, area_weight: f32, shape_spread: f32) -> Pass {
        let mut normal = self.normal(|r, _| r);
        let (mut members, mut squares) = (0.0, 0.0);
        let mut bend = [0.0; 6];
        for (contact, k) in self.near() {
            let r = k / (1.0 + k);
            if self.scene.distance == Distance::Orthogonal {
                let h = r * curvature(&self.model, contact.u);
                let [x, y, z] = contact.u;
                for (sum, phi) in bend.iter_mut().zip([x, y, z, y * z, z * x, x * y]) {
                    *sum += h * phi;
                }
            }
            members += r;
            squares += r * contact.f2();
        }
        let x = self.shell.estimate.x;
        add_area(&mut normal, area_weight, members, &bend, &self.model.slopes(), x);
        add_shape(&mut normal, shape_spread, x);
        Pass { normal, members, squares, points: self.points }
    }

    /// X6, gain.
    pub(crate) fn gain(&self) -> f32 {
        let mut sum = 0.0;
        for seen in &self.seen {
            match seen {
                Seen::Near(_, k) => sum += libm::log1pf(*k),
                Seen::Past(contact) => sum -= if contact.miss < 0.75 { 1.5 } else { 0.0 },
            }
        }
        sum + self.points as f32 * libm::log1pf(-self.shell.share)
    }

    /// X6, information.
    pub(crate) fn information(&self) -> Normal {
        self.normal(|r, f2| if fault::is(Fault::Information) { r } else { r * (1.0 - (1.0 - r) * f2) })
    }

    /// The near points and their odds.
    fn near(&self) -> impl Iterator<Item = (&Contact, f32)> {
        self.seen.iter().filter_map(|seen| match seen {
            Seen::Near(contact, k) => Some((contact, *k)),
            Seen::Past(_) => None,
        })
    }

    /// X6: matrix and gradient of points and rays, with the displacement of the rays eliminated. The weight of a near
    /// point is made of its responsibility and `f2`.
    fn normal(&self, weight: impl Fn(f32, f32) -> f32) -> Normal {
        let mut residuals = Vec::new();
        for seen in &self.seen {
            match seen {
                Seen::Near(contact, k) => {
                    let weight = weight(k / (1.0 + k), contact.f2()) / contact.variance;
                    residuals.push(Residual::new(contact.u, contact.value, weight));
                }
                Seen::Past(contact) => {
                    let counts = contact.miss > 0.25 && contact.miss < 1.0 && !fault::is(Fault::Past);
                    let c = contact.beside(&self.model);
                    let weight = Kernel::GemanMcClure(4.0).weight(c.f2());
                    if let (true, Some(weight)) = (counts, weight) {
                        residuals.push(Residual::new(c.u, c.value, weight / c.variance));
                    }
                }
            }
        }
        let s = self.model.slopes();
        let rays = matches!(self.scene.distance, Distance::Ray { .. }) && !self.scene.outline.is_empty();
        if !rays {
            let (matrix, gradient) = moments(&residuals, &s);
            return Normal { matrix, gradient, follower: Follower::default() };
        }
        let mut displacement = Row::new(self.scene.outline_offset, 0.0);
        let mut boxiness = Row::new(0.0, 0.0);
        let mut both = 0.0;
        for touch in self.touching() {
            if let Some(weight) = Kernel::GemanMcClure(9.0).weight(touch.f2(0.0)) {
                let weight = weight / touch.variance;
                let residual = Residual::new(touch.u, touch.value, weight);
                displacement.gain(&residual, -touch.lever);
                boxiness.gain(&residual, -0.0);
                residuals.push(residual);
                both += weight * (touch.lever * 0.0);
            }
        }
        let (matrix, gradient) = moments(&residuals, &s);
        let mut normal = Normal { matrix, gradient, follower: Follower::default() };
        normal.eliminate(&displacement, &boxiness, both, &s);
        normal
    }

    /// M7: the local rays that fit.
    fn touching(&self) -> Vec<Touch> {
        let x = self.shell.estimate.x;
        let mut touching = Vec::new();
        if fault::is(Fault::Rays) {
            return touching;
        }
        for ray in &self.scene.outline {
            touching.extend(Touch::of(ray, &self.model, [longest(x), smallest(x)], self.shell.sigma, 1.0));
        }
        touching
    }
}

/// X5: the contact of a local point.
pub(crate) fn contact(model: &Model, distance: Distance, p: Vector) -> Contact {
    match distance {
        Distance::Radial | Distance::Ray { .. } => Contact::new(model, p),
        Distance::Orthogonal => orthogonal(model, p),
    }
}

/// X6: `B`, the mean curvature of the surface at `u` over the size of its gradient.
fn curvature(model: &Model, u: Vector) -> f32 {
    let k = squares(model);
    let v = [u[0] * k[0], u[1] * k[1], u[2] * k[2]];
    let g = dot(u, v);
    let b = 0.5 * (((k[0] + k[1] + k[2]) - dot(v, v) / g) / g);
    if b < 1.0 || fault::is(Fault::Bend) { b } else { 1.0 }
}

/// X6: what the area says, with its weight `y`.
fn add_area(normal: &mut Normal, y: f32, members: f32, bend: &[f32; 6], s: &[f32; 9], x: Vector) {
    for j in 0..6 {
        normal.gradient[j] -= (2.0 * y) * (s[j] * bend[j]);
    }
    let h = y * members;
    for (j, slope) in Area::of(x).slopes.into_iter().enumerate() {
        normal.gradient[6 + j] += h * slope;
    }
}

/// X6: what is known of the shape.
fn add_shape(normal: &mut Normal, spread: f32, x: Vector) {
    const C: f32 = 2.0 / 3.0;
    let p = 1.0 / (spread * spread);
    if p > 0.0 {
        let m = (x[0] + x[1] + x[2]) / 3.0;
        for j in 0..3 {
            normal.gradient[6 + j] += p * (x[j] - m);
            normal.matrix[6 + j][6 + j] += p * C;
        }
        for (i, j) in [(7, 6), (8, 6), (8, 7)] {
            normal.matrix[i][j] -= p / 3.0;
        }
    }
}
