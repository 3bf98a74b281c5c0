//! Lines of sight: what a camera sees along the ray of a pixel, and what stands between a place and the sun.
//!
//! Both ask only the bodies whose bounds touch the ray's tile ([`super::tiles`]).

use nalgebra::{Point2, Point3, Vector2, Vector3};

use super::scene::Scene;
use super::shade::sunward;
use super::shape::{Hit, Ray, Rod, Shape};
use super::tiles::{Footprint, Rectangle, Tiles};

/// Edge of a tile of an image, pixels.
const TILE_PX: f64 = 6.0;
/// Edge of a tile of what the sun sees, millimetres.
const SUN_TILE_MM: f64 = 4.0;
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

    /// What is seen of a rod. A point within r of (X, Y, Z) is seen within f r sqrt(1 + (X^2 + Y^2) / Z^2) / (Z - r)
    /// of where that is; endless when the rod reaches the eye or lies behind it.
    fn footprint(&self, rod: &Rod) -> Footprint {
        let front_mm = rod.front_mm();
        if front_mm <= 0.0 {
            return Footprint { points: [Point2::origin(); 3], radius: f64::INFINITY };
        }
        let slopes = rod.points.map(|point| (point - self.position).xy() / point.z);
        let steepest = slopes.iter().map(Vector2::norm_squared).fold(0.0, f64::max);
        let radius = self.focal.0.max(self.focal.1) * rod.radius * (1.0 + steepest).sqrt() / front_mm;
        let pixel = |slope: Vector2<f64>| {
            Point2::new(slope.x * self.focal.0 + self.principal.0, slope.y * self.focal.1 + self.principal.1)
        };
        Footprint { points: slopes.map(pixel), radius }
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
        let footprints = scene.bodies.iter().map(|body| eye.footprint(&body.shape.rod()));
        Self { scene, eye, size, tiles: Tiles::new(area, TILE_PX, footprints) }
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

    /// The fruit that a pixel would see if they stood alone.
    pub(super) fn fruits_at(&self, u: f64, v: f64) -> impl Iterator<Item = u8> {
        let bodies = self.tiles.at(u, v).iter().map(|&body| &self.scene.bodies[usize::from(body)]);
        bodies.filter_map(move |body| {
            let fruit = body.fruit?;
            body.shape.hit(&self.eye.ray(u, v)).map(|_| fruit)
        })
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
        let footprints = scene.bodies.iter().map(|body| {
            let Rod { points, radius } = body.shape.rod();
            let seen = |point: Point3<f64>| Point2::from(across.map(|axis| axis.dot(&point.coords)));
            Footprint { points: points.map(seen), radius }
        });
        let area = footprints.clone().map(|footprint| footprint.bounds()).reduce(Rectangle::join);
        let area =
            area.unwrap_or(Rectangle { min: Point2::origin(), max: Point2::new(SUN_TILE_MM, SUN_TILE_MM) });
        Self { scene, sun, across, tiles: Tiles::new(area, SUN_TILE_MM, footprints) }
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

#[cfg(test)]
mod tests {
    use super::super::noise::Noise;
    use super::super::scene::SceneOptions;
    use super::*;

    #[test]
    fn tiles_miss_nothing() {
        let scene = Scene::new(&SceneOptions { shoot_count: 8, leaf_count: 30, ..SceneOptions::default() });
        let position = Point3::new(-52.0, 0.0, 0.0);
        let eye = Eye { position, focal: (1080.0, 1081.0), principal: (959.5, 539.5) };
        let sight = Sight::new(&scene, eye, (1920, 1080));
        let sunlight = Sunlight::new(&scene);
        let mut noise = Noise::new(11);
        let mut hits = 0;
        for _ in 0..4000 {
            let (u, v) = (noise.between(-20.0, 1940.0), noise.between(-20.0, 1100.0));
            let (ray, first) = sight.first(u, v);
            let all = (0_u16..).zip(&scene.bodies).filter_map(|(k, body)| Some((k, body.shape.hit(&ray)?.t)));
            let nearest = all.reduce(|a, b| if b.1 < a.1 { b } else { a });
            assert_eq!(first.map(|(body, hit)| (body, hit.t)), nearest, "at ({u}, {v})");
            let Some((body, hit)) = first else { continue };
            hits += 1;
            assert!(
                scene.fruit_of(body).is_none_or(|fruit| sight.fruits_at(u, v).any(|other| other == fruit))
            );
            // Whatever a body that shades itself does, the sun is blocked only by what a full search finds.
            let place = ray.origin + ray.direction * hit.t;
            let side = hit.normal * hit.normal.dot(&sunlight.sun).signum() * SHADOW_LIFT_MM;
            let to_sun = Ray { origin: place + side, direction: sunlight.sun };
            let blocked = scene.bodies.iter().any(|body| body.shape.hit(&to_sun).is_some());
            let away = hit.normal.dot(&sunlight.sun) <= 0.0
                && !matches!(scene.bodies[usize::from(body)].shape, Shape::Leaf(_));
            assert_eq!(sunlight.reaches(body, &ray, &hit), !blocked && !away);
        }
        assert!(hits > 500, "{hits}");
    }

    #[test]
    fn a_rod_that_reaches_the_eye_may_be_anywhere() {
        let eye = Eye { position: Point3::origin(), focal: (366.0, 366.0), principal: (256.0, 206.0) };
        let rod = |z: f64| Rod { points: [Point3::new(0.0, 0.0, z); 3], radius: 5.0 };
        assert_eq!(eye.footprint(&rod(4.0)).radius, f64::INFINITY);
        assert!((eye.footprint(&rod(371.0)).radius - 5.0).abs() < 1e-12);
    }
}
