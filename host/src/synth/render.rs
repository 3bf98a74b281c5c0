//! Renders a scene through the two cameras of a Kinect v2, or through one camera that both images share.
//!
//! Ray casting, analytic: a tile of the image knows which bodies may lie behind it. The colour image takes four more
//! rays for each pixel on an outline; the depth image goes through the sensor (`sensor`). The raw depth
//! image of a Kinect is produced where the sensor has its pixels: each raw pixel looks along the ideal ray that its
//! lens leads there.

use nalgebra::{Point2, Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::foliage::{self, Backdrop};
use super::fruit::FruitKind;
use super::noise::Noise;
use super::scene::Scene;
use super::sensor::{Echo, measure};
use super::shade::{Light, shade, sunward, to_display};
use super::shape::{Ball, Hit, Ray};
use super::tiles::{Rectangle, Tiles};
use crate::backproject::Pinhole;
use crate::eval::EllipsoidF64;
use crate::image::{ColourImage, DepthImage, Image, LabelImage};
use crate::kinect::calibration::IrParameters;
use crate::kinect::{
    COLOUR_HEIGHT, COLOUR_WIDTH, ColourCamera, DEPTH_HEIGHT, DEPTH_WIDTH, DepthCamera, FactoryCalibration,
};

/// Edge of a tile of the image, pixels; of the shadow grid, millimetres.
const TILE: f64 = 8.0;
/// A surface lifts its shadow ray by this much, millimetres.
const SHADOW_LIFT_MM: f64 = 0.05;
/// Places within a pixel on an outline, a rotated square.
const OUTLINE_SAMPLES: [(f64, f64); 4] = [(-0.125, -0.375), (0.375, -0.125), (0.125, 0.375), (-0.375, 0.125)];

/// The demo's Kinect v2: a depth camera with distortion, and a colour camera that is a pinhole beside it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KinectRig {
    /// Depth camera.
    pub ir: IrParameters,
    /// Focal length of the colour camera, pixels.
    pub colour_focal_px: f64,
    /// Principal point of the colour camera, pixels.
    pub colour_centre_px: (f64, f64),
    /// The colour camera stands this far to the left, axes parallel, millimetres.
    pub baseline_mm: f64,
}

impl Default for KinectRig {
    /// An invented device with values typical of the sensor.
    fn default() -> Self {
        Self {
            ir: IrParameters {
                fx: 366.4,
                fy: 366.4,
                cx: 256.9,
                cy: 206.6,
                k1: 0.0893,
                k2: -0.2697,
                k3: 0.0958,
                p1: 0.0,
                p2: 0.0,
            },
            colour_focal_px: 1081.0,
            colour_centre_px: (959.5, 539.5),
            baseline_mm: 52.0,
        }
    }
}

impl KinectRig {
    /// The factory parameters that such a device would store; they describe it exactly.
    pub fn calibration(&self) -> FactoryCalibration {
        let colour = ColourCamera::parallel_pinhole(
            self.colour_focal_px,
            self.colour_centre_px,
            self.baseline_mm,
            &self.ir,
        );
        FactoryCalibration { ir: self.ir, colour }
    }
}

/// One fruit of a rendered frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TrueFruit {
    /// Kind of fruit.
    pub kind: FruitKind,
    /// Shape and place, depth camera frame.
    pub ellipsoid: EllipsoidF64,
    /// Pixels of the depth image in which it is the nearest.
    pub visible_px: u32,
    /// The same as a share of the pixels it would take alone; 0 outside the image.
    pub visible_fraction: f64,
}

/// An unregistered pair of a Kinect v2, with truth.
#[derive(Debug, Clone, PartialEq)]
pub struct KinectFrame {
    /// 1920x1080.
    pub colour: ColourImage,
    /// 512x424, millimetres, on the sensor's own grid with distortion.
    pub raw_depth: DepthImage,
    /// For each colour pixel the fruit it shows: 1 for the first of `fruits`, 0 = none.
    pub instances: LabelImage,
    /// The device.
    pub calibration: FactoryCalibration,
    /// All fruit of the scene, hidden ones too.
    pub fruits: Vec<TrueFruit>,
}

/// Colour and depth on one grid, with truth.
#[derive(Debug, Clone, PartialEq)]
pub struct RegisteredFrame {
    /// Colour.
    pub colour: ColourImage,
    /// Millimetres.
    pub depth: DepthImage,
    /// For each pixel the fruit it shows: 1 for the first of `fruits`, 0 = none.
    pub instances: LabelImage,
    /// All fruit of the scene, hidden ones too.
    pub fruits: Vec<TrueFruit>,
}

/// Renders what a Kinect v2 would record of the scene. `O(pixels * bodies in sight of each)`.
pub fn render_kinect(scene: &Scene, rig: &KinectRig) -> KinectFrame {
    let depth_camera = DepthCamera::new(rig.ir);
    let corner = depth_camera.ray(0.0, 0.0);
    let depth_eye = Eye {
        position: Point3::origin(),
        focal: (rig.ir.fx, rig.ir.fy),
        principal: (-corner.x * rig.ir.fx, -corner.y * rig.ir.fy),
    };
    let colour_eye = Eye {
        position: Point3::new(-rig.baseline_mm, 0.0, 0.0),
        focal: (rig.colour_focal_px, rig.colour_focal_px),
        principal: rig.colour_centre_px,
    };
    let place = |u: f64, v: f64| depth_camera.undistort(u, v);
    let backdrop = Backdrop::paint(scene.backdrop_field);
    let (raw_depth, fruits) = render_depth(scene, &backdrop, &depth_eye, (DEPTH_WIDTH, DEPTH_HEIGHT), place);
    let (colour, instances) = render_colour(scene, &backdrop, &colour_eye, (COLOUR_WIDTH, COLOUR_HEIGHT));
    KinectFrame { colour, raw_depth, instances, calibration: rig.calibration(), fruits }
}

/// Renders the scene through one pinhole that colour and depth share: for experiments that need no registration.
pub fn render_depth_patch(scene: &Scene, camera: &Pinhole, width: usize, height: usize) -> RegisteredFrame {
    let corner = camera.ray(0.0, 0.0);
    let focal = camera.focal_px();
    let eye =
        Eye { position: Point3::origin(), focal, principal: (-corner.x * focal.0, -corner.y * focal.1) };
    let backdrop = Backdrop::paint(scene.backdrop_field);
    let (depth, fruits) = render_depth(scene, &backdrop, &eye, (width, height), |u, v| Some((u, v)));
    let (colour, instances) = render_colour(scene, &backdrop, &eye, (width, height));
    RegisteredFrame { colour, depth, instances, fruits }
}

/// A pinhole somewhere in the plane z = 0, looking along z.
#[derive(Debug, Clone, Copy)]
struct Eye {
    position: Point3<f64>,
    focal: (f64, f64),
    principal: (f64, f64),
}

impl Eye {
    fn ray(&self, u: f64, v: f64) -> Ray {
        let direction =
            Vector3::new((u - self.principal.0) / self.focal.0, (v - self.principal.1) / self.focal.1, 1.0);
        Ray { origin: self.position, direction }
    }

    /// Which bodies lie behind which tile, a tile beyond the image on every side.
    fn tiles(&self, scene: &Scene, (width, height): (usize, usize)) -> Tiles {
        let area = Rectangle {
            min: Point2::new(-TILE, -TILE),
            max: Point2::new(width as f64 + TILE, height as f64 + TILE),
        };
        let bounds = scene.bodies.iter().map(|body| {
            let [a, b, c] = body.shape.hull().map(|ball| self.bounds(&ball));
            a.join(b).join(c)
        });
        Tiles::new(area, TILE, bounds)
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

/// The body that a ray from an eye meets first, of those named, which are in the scene's order.
fn nearest(scene: &Scene, candidates: &[u16], ray: &Ray) -> Option<(u16, Hit)> {
    let mut first: Option<(u16, Hit)> = None;
    for &index in candidates {
        let body = &scene.bodies[usize::from(index)];
        // Eyes are at z = 0 and rays of slope 1 in z, so that the ray parameter is z.
        if first.is_some_and(|(_, other)| other.t < body.front_mm) {
            break;
        }
        if let Some(hit) = body.shape.hit(ray)
            && first.is_none_or(|(_, other)| hit.t < other.t)
        {
            first = Some((index, hit));
        }
    }
    first
}

/// Depth image and the truth about each fruit. `place` leads from a pixel to where on the ideal grid it looks.
fn render_depth(
    scene: &Scene,
    backdrop: &Backdrop,
    eye: &Eye,
    size: (usize, usize),
    place: impl Fn(f64, f64) -> Option<(f64, f64)>,
) -> (DepthImage, Vec<TrueFruit>) {
    let (width, height) = size;
    let tiles = eye.tiles(scene, size);
    let mut noise = Noise::new(scene.options.seed).apart().apart();
    let cast = |x: f64, y: f64| {
        let ray = eye.ray(x, y);
        match nearest(scene, tiles.at(x, y), &ray) {
            Some((surface, hit)) => {
                let cosine = (hit.normal.dot(&ray.direction) / ray.direction.norm()).abs();
                Some(Echo { z_mm: hit.t, cosine, surface })
            }
            None => backdrop.echo(&ray),
        }
    };
    let pixels = || (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
    let places: Vec<Option<(f64, f64)>> = pixels().map(|(u, v)| place(u as f64, v as f64)).collect();
    let straight = places.iter().map(|place| place.and_then(|(x, y)| cast(x, y))).collect();
    let straight = Image { width, height, pixels: straight };
    let depth = pixels().zip(&places).map(|((u, v), place)| {
        let Some((x, y)) = *place else { return 0.0 };
        let around = |dx: f64, dy: f64| cast(x + dx, y + dy);
        measure(&straight, (u as i64, v as i64), around, eye.focal.0, &scene.options.sensor, &mut noise)
    });
    let depth = DepthImage { width, height, pixels: depth.collect() };
    let fruits = (0_u16..).zip(&scene.bodies).filter_map(|(index, body)| Some((index, body, body.fruit?)));
    let fruits = fruits.map(|(index, body, fruit)| {
        let first = |echo: &Option<Echo>| echo.and_then(|echo| scene.fruit_of(echo.surface)) == Some(fruit);
        let visible_px = straight.pixels.iter().filter(|echo| first(echo)).count();
        let at_all = |&(x, y): &(f64, f64)| {
            tiles.at(x, y).contains(&index) && body.shape.hit(&eye.ray(x, y)).is_some()
        };
        let alone_px = places.iter().flatten().filter(|place| at_all(place)).count();
        TrueFruit {
            kind: scene.options.kind,
            ellipsoid: scene.fruits[usize::from(fruit)],
            visible_px: visible_px as u32,
            visible_fraction: visible_px as f64 / alone_px.max(1) as f64,
        }
    });
    let fruits = fruits.collect();
    (depth, fruits)
}

/// Colour image, and which fruit each pixel shows at its centre.
fn render_colour(
    scene: &Scene,
    backdrop: &Backdrop,
    eye: &Eye,
    size: (usize, usize),
) -> (ColourImage, LabelImage) {
    let (width, height) = size;
    let tiles = eye.tiles(scene, size);
    let shadows = Shadows::new(scene);
    let mut noise = Noise::new(scene.options.seed).apart().apart().apart();
    let look = |u: f64, v: f64| -> (Patch, Light) {
        let ray = eye.ray(u, v);
        match nearest(scene, tiles.at(u, v), &ray) {
            Some((body, hit)) => {
                let sunlit = !shadows.reach(&ray, &hit);
                let light = shade(&scene.bodies[usize::from(body)].material, &hit, &ray, sunlit);
                (Patch { body, sunlit }, light)
            }
            None => (Patch { body: foliage::SURFACE, sunlit: true }, backdrop.light(&ray)),
        }
    };
    let mut patches = Vec::with_capacity(width * height);
    let mut lights = Vec::with_capacity(width * height);
    for v in 0..height {
        for u in 0..width {
            let (patch, light) = look(u as f64, v as f64);
            patches.push(patch);
            lights.push(light);
        }
    }
    let patches = Image { width, height, pixels: patches };
    let mut colour = ColourImage::filled(width, height, [0; 3]);
    for v in 0..height {
        for u in 0..width {
            let mut light = lights[v * width + u];
            if on_outline(&patches, u, v) {
                let samples = OUTLINE_SAMPLES.map(|(du, dv)| look(u as f64 + du, v as f64 + dv).1);
                light = samples.iter().sum::<Light>() / samples.len() as f32;
            }
            colour.pixels[v * width + u] = expose(&light, &mut noise);
        }
    }
    let instances =
        patches.pixels.iter().map(|patch| scene.fruit_of(patch.body).map_or(0, |fruit| fruit + 1)).collect();
    (colour, LabelImage { width, height, pixels: instances })
}

/// What a pixel shows: where it differs from its neighbour runs an outline, of a body or of a shadow.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Patch {
    body: u16,
    sunlit: bool,
}

/// Whether a neighbour above, below, left or right shows another patch.
fn on_outline(patches: &Image<Patch>, u: usize, v: usize) -> bool {
    let (u, v) = (u as i64, v as i64);
    let own = patches.get(u, v);
    [(1, 0), (-1, 0), (0, 1), (0, -1)]
        .iter()
        .any(|&(du, dv)| patches.get(u + du, v + dv).is_some_and(|other| Some(other) != own))
}

/// A pixel of the picture, with the noise of the colour sensor: triangular, standard deviation about 1.6 counts.
fn expose(light: &Light, noise: &mut Noise) -> [u8; 3] {
    let bits = noise.bits().to_le_bytes();
    let display = to_display(light);
    std::array::from_fn(|channel| {
        let grain = (f32::from(bits[2 * channel]) - f32::from(bits[2 * channel + 1])) * (4.0 / 256.0);
        // The cast saturates at 0 and 255.
        (display[channel] + grain + 0.5) as u8
    })
}

/// Which places the sun does not reach.
struct Shadows<'a> {
    scene: &'a Scene,
    sun: Vector3<f64>,
    across: [Vector3<f64>; 2],
    tiles: Tiles,
}

impl<'a> Shadows<'a> {
    fn new(scene: &'a Scene) -> Self {
        let sun = sunward();
        let first = sun.cross(&Vector3::z()).normalize();
        let across = [first, sun.cross(&first)];
        let seen_from_sun = |point: &Point3<f64>| Point2::from(across.map(|axis| axis.dot(&point.coords)));
        let bounds = scene.bodies.iter().map(|body| {
            let [a, b, c] =
                body.shape.hull().map(|ball| Rectangle::of_circle(seen_from_sun(&ball.centre), ball.radius));
            a.join(b).join(c)
        });
        let area = bounds.clone().reduce(Rectangle::join);
        let tiles = Tiles::new(area.unwrap_or(Rectangle::of_circle(Point2::origin(), 1.0)), TILE, bounds);
        Self { scene, sun, across, tiles }
    }

    /// Whether something stands between a hit and the sun.
    fn reach(&self, ray: &Ray, hit: &Hit) -> bool {
        // The side that the sun shines on, if it shines at all.
        let lift = if hit.normal.dot(&self.sun) > 0.0 { SHADOW_LIFT_MM } else { -SHADOW_LIFT_MM };
        let origin = ray.origin + ray.direction * hit.t + hit.normal * lift;
        let [x, y] = self.across.map(|axis| axis.dot(&origin.coords));
        let to_sun = Ray { origin, direction: self.sun };
        self.tiles
            .at(x, y)
            .iter()
            .any(|&body| self.scene.bodies[usize::from(body)].shape.hit(&to_sun).is_some())
    }
}
