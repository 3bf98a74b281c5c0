//! Lines of sight: what a camera sees along the ray of a pixel, and what stands between a place and the sun.
//!
//! Both ask only the bodies whose bounds touch the ray's tile ([`super::tiles`]).

use nalgebra::{Point2, Point3, Vector3};

use super::scene::Scene;
use super::shade::sunward;
use super::shape::{Ball, Hit, Ray, Shape};
use super::tiles::{Rectangle, Tiles};

/// Edge of a tile: pixels of an image, millimetres of what the sun sees.
const TILE: f64 = 8.0;
/// Rays may look past the image by this much: a lens without distortion would see more than one with it.
const MARGIN_PX: f64 = 64.0;
/// A surface lifts its shadow ray by this much, millimetres.
const SHADOW_LIFT_MM: f64 = 0.05;

/// A pinhole somewhere in the plane z = 0, looking along z.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eye {
    pub(super) position: Point3<f64>,
    pub(super) focal: (f64, f64),
    pub(super) principal: (f64, f64),
}

impl Eye {
    /// An eye at the origin, given the direction of pixel (0, 0).
    pub(super) fn at_origin(focal: (f64, f64), corner: &Vector3<f64>) -> Self {
        let principal = (-corner.x * focal.0, -corner.y * focal.1);
        Self { position: Point3::origin(), focal, principal }
    }

    pub(super) fn ray(&self, u: f64, v: f64) -> Ray {
        let direction =
            Vector3::new((u - self.principal.0) / self.focal.0, (v - self.principal.1) / self.focal.1, 1.0);
        Ray { origin: self.position, direction }
    }

    /// Bounds of a ball in the image: x/z of its box, each at the depth that is worse.
    fn bounds(&self, ball: &Ball) -> Rectangle {
        let offset = ball.centre - self.position;
        // A ball that reaches the eye, or lies behind it, is given the eye's own plane: it may cover everything.
        let near = (offset.z - ball.radius).max(1e-6);
        let far = (offset.z + ball.radius).max(near);
        let low = |x: f64| (x / near).min(x / far);
        let high = |x: f64| (x / near).max(x / far);
        let corner = |x: f64, y: f64| {
            Point2::new(x * self.focal.0 + self.principal.0, y * self.focal.1 + self.principal.1)
        };
        Rectangle {
            min: corner(low(offset.x - ball.radius), low(offset.y - ball.radius)),
            max: corner(high(offset.x + ball.radius), high(offset.y + ball.radius)),
        }
    }
}

/// A scene as one eye sees it.
#[derive(Debug)]
pub(super) struct Sight<'a> {
    pub(super) scene: &'a Scene,
    pub(super) eye: Eye,
    /// Width and height of the image, pixels.
    pub(super) size: (usize, usize),
    tiles: Tiles,
}

impl<'a> Sight<'a> {
    pub(super) fn new(scene: &'a Scene, eye: Eye, size: (usize, usize)) -> Self {
        let area = Rectangle {
            min: Point2::new(-MARGIN_PX, -MARGIN_PX),
            max: Point2::new(size.0 as f64 + MARGIN_PX, size.1 as f64 + MARGIN_PX),
        };
        let bounds = scene.bodies.iter().map(|body| {
            let [a, b, c] = body.shape.hull().map(|ball| eye.bounds(&ball));
            a.join(b).join(c)
        });
        Self { scene, eye, size, tiles: Tiles::new(area, TILE, bounds) }
    }

    /// The body that the ray of a pixel meets first, with the ray itself.
    pub(super) fn first(&self, u: f64, v: f64) -> (Ray, Option<(u16, Hit)>) {
        let ray = self.eye.ray(u, v);
        let mut first: Option<(u16, Hit)> = None;
        for &index in self.tiles.at(u, v) {
            let body = &self.scene.bodies[usize::from(index)];
            // The eye is at z = 0 and the ray of slope 1 in z, so that the ray parameter is z.
            if first.is_some_and(|(_, other)| other.t < body.front_mm) {
                break;
            }
            if let Some(hit) = body.shape.hit(&ray)
                && first.is_none_or(|(_, other)| hit.t < other.t)
            {
                first = Some((index, hit));
            }
        }
        (ray, first)
    }

    /// Whether a body would be seen in a pixel if it stood alone.
    pub(super) fn meets(&self, body: u16, u: f64, v: f64) -> bool {
        let shape = &self.scene.bodies[usize::from(body)].shape;
        self.tiles.at(u, v).contains(&body) && shape.hit(&self.eye.ray(u, v)).is_some()
    }
}

/// A scene as the sun sees it.
#[derive(Debug)]
pub(super) struct Sunlight<'a> {
    scene: &'a Scene,
    sun: Vector3<f64>,
    across: [Vector3<f64>; 2],
    tiles: Tiles,
}

impl<'a> Sunlight<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        let sun = sunward();
        let first = sun.cross(&Vector3::z()).normalize();
        let across = [first, sun.cross(&first)];
        let circle = |ball: Ball| {
            let centre = across.map(|axis| axis.dot(&ball.centre.coords));
            Rectangle::of_circle(Point2::from(centre), ball.radius)
        };
        let bounds = scene.bodies.iter().map(|body| {
            let [a, b, c] = body.shape.hull().map(circle);
            a.join(b).join(c)
        });
        let area = bounds.clone().reduce(Rectangle::join);
        let area = area.unwrap_or(Rectangle::of_circle(Point2::origin(), TILE));
        Self { scene, sun, across, tiles: Tiles::new(area, TILE, bounds) }
    }

    /// Whether the sun shines on the place where a ray hits a body, from either side if the body is a leaf.
    pub(super) fn reaches(&self, body: u16, ray: &Ray, hit: &Hit) -> bool {
        let facing = hit.normal.dot(&self.sun) > 0.0;
        let thin = matches!(self.scene.bodies[usize::from(body)].shape, Shape::Leaf(_));
        if !facing && !thin {
            return false;
        }
        let lift = if facing { SHADOW_LIFT_MM } else { -SHADOW_LIFT_MM };
        let origin = ray.origin + ray.direction * hit.t + hit.normal * lift;
        let [x, y] = self.across.map(|axis| axis.dot(&origin.coords));
        let to_sun = Ray { origin, direction: self.sun };
        let blocks = |&body: &u16| self.scene.bodies[usize::from(body)].shape.hit(&to_sun).is_some();
        !self.tiles.at(x, y).iter().any(blocks)
    }
}
