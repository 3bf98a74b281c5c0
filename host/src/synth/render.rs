//! Renders a scene through the two cameras of a Kinect v2, or through one camera that both images share.
//!
//! Ray casting, analytic: a tile of the image knows which bodies may lie behind it. The colour image takes three more
//! rays for each pixel on an outline; the depth image goes through the sensor with its faults. The raw depth
//! image of a Kinect is produced where the sensor has its pixels: each raw pixel looks along the ideal ray that its
//! lens leads there.

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::foliage::{self, Backdrop};
use super::fruit::FruitKind;
use super::noise::Noise;
use super::scene::Scene;
use super::sensor::{Echo, measure};
use super::shade::{Light, shade, to_display};
use super::sight::{Eye, Sight, Sunlight};
use crate::backproject::Pinhole;
use crate::eval::EllipsoidF64;
use crate::image::{ColourImage, DepthImage, Image, LabelImage};
use crate::kinect::calibration::IrParameters;
use crate::kinect::{
    COLOUR_HEIGHT, COLOUR_WIDTH, ColourCamera, DEPTH_HEIGHT, DEPTH_WIDTH, DepthCamera, FactoryCalibration,
};

/// Places within a pixel on an outline that are looked at beside its centre.
const OUTLINE_SAMPLES: [(f64, f64); 3] = [(-0.35, -0.15), (0.30, -0.30), (0.10, 0.38)];

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
    let backdrop = Backdrop::paint(scene.backdrop_field);
    let camera = DepthCamera::new(rig.ir);
    let eye = Eye::at_origin(camera.focal_px(), &camera.ray(0.0, 0.0));
    let sight = Sight::new(scene, eye, (DEPTH_WIDTH, DEPTH_HEIGHT));
    let (raw_depth, fruits) = render_depth(&sight, &backdrop, |u, v| camera.undistort(u, v));
    let colour_eye = Eye {
        position: Point3::new(-rig.baseline_mm, 0.0, 0.0),
        focal: (rig.colour_focal_px, rig.colour_focal_px),
        principal: rig.colour_centre_px,
    };
    let sight = Sight::new(scene, colour_eye, (COLOUR_WIDTH, COLOUR_HEIGHT));
    let (colour, instances) = render_colour(&sight, &backdrop);
    KinectFrame { colour, raw_depth, instances, calibration: rig.calibration(), fruits }
}

/// Renders the scene through one pinhole that colour and depth share: for experiments that need no registration.
pub fn render_depth_patch(scene: &Scene, camera: &Pinhole, width: usize, height: usize) -> RegisteredFrame {
    let backdrop = Backdrop::paint(scene.backdrop_field);
    let sight = Sight::new(scene, Eye::at_origin(camera.focal_px(), &camera.ray(0.0, 0.0)), (width, height));
    let (depth, fruits) = render_depth(&sight, &backdrop, |u, v| Some((u, v)));
    let (colour, instances) = render_colour(&sight, &backdrop);
    RegisteredFrame { colour, depth, instances, fruits }
}

/// Depth image and the truth about each fruit. `place` leads from a pixel to where on the ideal grid it looks.
fn render_depth(
    sight: &Sight,
    backdrop: &Backdrop,
    place: impl Fn(f64, f64) -> Option<(f64, f64)>,
) -> (DepthImage, Vec<TrueFruit>) {
    let (scene, (width, height)) = (sight.scene, sight.size);
    let mut noise = Noise::new(scene.options.seed).apart().apart();
    let cast = |x: f64, y: f64| match sight.first(x, y) {
        (ray, Some((surface, hit))) => {
            let cosine = (hit.normal.dot(&ray.direction) / ray.direction.norm()).abs();
            Some(Echo { z_mm: hit.t, cosine, surface })
        }
        (ray, None) => backdrop.echo(&ray),
    };
    let pixels = || (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
    let places: Vec<Option<(f64, f64)>> = pixels().map(|(u, v)| place(u as f64, v as f64)).collect();
    let straight = places.iter().map(|place| place.and_then(|(x, y)| cast(x, y))).collect();
    let straight = Image { width, height, pixels: straight };
    let focal_px = sight.eye.focal.0;
    let depth = pixels().zip(&places).map(|((u, v), place)| {
        let Some((x, y)) = *place else { return 0.0 };
        let around = |dx: f64, dy: f64| cast(x + dx, y + dy);
        measure(&straight, (u as i64, v as i64), around, focal_px, &scene.options.sensor, &mut noise)
    });
    let depth = DepthImage { width, height, pixels: depth.collect() };
    (depth, true_fruits(sight, &places, &straight))
}

/// Counts the pixels in which each fruit is seen first, and at all. `places` and `straight` are where the pixels look
/// and what they see.
fn true_fruits(
    sight: &Sight,
    places: &[Option<(f64, f64)>],
    straight: &Image<Option<Echo>>,
) -> Vec<TrueFruit> {
    let scene = sight.scene;
    let (mut visible, mut alone) = (vec![0_u32; scene.fruits.len()], vec![0_u32; scene.fruits.len()]);
    for (place, echo) in places.iter().zip(&straight.pixels) {
        if let Some(fruit) = echo.and_then(|echo| scene.fruit_of(echo.surface)) {
            visible[usize::from(fruit)] += 1;
        }
        for fruit in place.iter().flat_map(|&(x, y)| sight.fruits_at(x, y)) {
            alone[usize::from(fruit)] += 1;
        }
    }
    let counts = visible.iter().zip(&alone);
    let fruit = |(&ellipsoid, (&visible_px, &alone_px)): (&EllipsoidF64, (&u32, &u32))| {
        let visible_fraction = f64::from(visible_px) / f64::from(alone_px.max(1));
        TrueFruit { kind: scene.options.kind, ellipsoid, visible_px, visible_fraction }
    };
    scene.fruits.iter().zip(counts).map(fruit).collect()
}

/// Colour image, and which fruit each pixel shows at its centre.
fn render_colour(sight: &Sight, backdrop: &Backdrop) -> (ColourImage, LabelImage) {
    let (scene, (width, height)) = (sight.scene, sight.size);
    let sunlight = Sunlight::new(scene);
    let mut noise = Noise::new(scene.options.seed).apart().apart().apart();
    let daylight = scene.options.daylight;
    let exposure = daylight.exposure();
    let look = |u: f64, v: f64| match sight.first(u, v) {
        (ray, Some((body, hit))) => {
            let sunlit = daylight.has_sun() && sunlight.reaches(body, &ray, &hit);
            let light = shade(&scene.bodies[usize::from(body)].material, &hit, &ray, sunlit);
            (Patch { body, sunlit }, light)
        }
        (ray, None) => (Patch { body: foliage::SURFACE, sunlit: true }, backdrop.light(&ray)),
    };
    let pixels = || (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
    let (patches, lights): (Vec<Patch>, Vec<Light>) = pixels().map(|(u, v)| look(u as f64, v as f64)).unzip();
    let patches = Image { width, height, pixels: patches };
    let colour = pixels().zip(lights).map(|((u, v), centre)| {
        let light = if on_outline(&patches, u, v) {
            let samples = OUTLINE_SAMPLES.map(|(du, dv)| look(u as f64 + du, v as f64 + dv).1);
            (samples.iter().sum::<Light>() + centre) / (samples.len() + 1) as f32
        } else {
            centre
        };
        expose(&light.component_mul(&exposure), &mut noise)
    });
    let colour = ColourImage { width, height, pixels: colour.collect() };
    let instance = |patch: &Patch| scene.fruit_of(patch.body).map_or(0, |fruit| fruit + 1);
    let instances = patches.pixels.iter().map(instance).collect();
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
    let (width, last_row) = (patches.width, patches.height - 1);
    let at = |u: usize, v: usize| patches.pixels[v * width + u];
    let own = at(u, v);
    at(u.saturating_sub(1), v) != own
        || at((u + 1).min(width - 1), v) != own
        || at(u, v.saturating_sub(1)) != own
        || at(u, (v + 1).min(last_row)) != own
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

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::super::scene::{Daylight, SceneOptions};
    use super::super::sensor::SensorOptions;
    use super::*;
    use crate::backproject::{PointOptions, View, ViewPoint};
    use crate::kinect::Registration;
    use crate::segment::regions::{AreaLimits, instance_regions};
    use crate::segment::{preset, segment};

    /// Fruit of one kind of colour among green: what passes the gate is fruit, stray bark and noise.
    const OPTIONS: SceneOptions = SceneOptions {
        seed: 5,
        kind: FruitKind::Jujube,
        fruit_count: 10,
        distance_mm: (500.0, 700.0),
        view_slopes: (0.45, 0.33),
        gap_mm: 1.0,
        branch_count: 2,
        shoot_count: 6,
        leaf_count: 30,
        occluding_leaf_count: 3,
        withered_share: 0.0,
        far_branch_count: 1,
        daylight: Daylight::Sun,
        sensor: SensorOptions { noise_scale: 1.0, quantum_mm: 1.0, flying_pixels: true, holes: true },
    };
    const PERFECT: SceneOptions = SceneOptions { sensor: SensorOptions::PERFECT, ..OPTIONS };

    static NOISY: LazyLock<KinectFrame> =
        LazyLock::new(|| render_kinect(&Scene::new(&OPTIONS), &KinectRig::default()));
    static CLEAN: LazyLock<KinectFrame> =
        LazyLock::new(|| render_kinect(&Scene::new(&PERFECT), &KinectRig::default()));

    fn patch(options: &SceneOptions) -> (RegisteredFrame, Pinhole) {
        let camera = Pinhole::new(366.0, 366.0, 255.5, 211.5).unwrap();
        (render_depth_patch(&Scene::new(options), &camera, 512, 424), camera)
    }

    /// Distance to the nearest fruit's surface, millimetres.
    fn error_mm(fruits: &[TrueFruit], point: &ViewPoint) -> f64 {
        let distances = fruits.iter().map(|fruit| fruit.ellipsoid.distance_mm(&point.point_mm.cast()).abs());
        distances.fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn without_faults_every_point_of_an_instance_is_on_its_ellipsoid() {
        let (frame, camera) = patch(&PERFECT);
        let view = View::Registered { depth: &frame.depth, camera };
        let regions = instance_regions(&frame.instances, AreaLimits::ALL);
        assert!(regions.list.len() >= 8);
        let points = view.points(&regions, &PointOptions::default()).unwrap();
        let (mut exact, mut all) = (0, 0);
        for (region, points) in regions.list.iter().zip(&points) {
            let fruit = &frame.fruits[usize::from(region.value) - 1];
            assert_eq!(region.area_px, fruit.visible_px);
            let error = |point: &ViewPoint| fruit.ellipsoid.distance_mm(&point.point_mm.cast()).abs();
            exact += points.iter().filter(|point| error(point) < 1e-3).count();
            all += points.len();
        }
        // The rest are pixels on an outline, most of whose area sees something else.
        assert!(exact * 100 > all * 93, "{exact} of {all}");
    }

    #[test]
    fn colour_and_depth_agree_through_registration() {
        let registration = Registration::new(&CLEAN.calibration);
        let registered = registration.register(&CLEAN.raw_depth).unwrap();
        let view = View::Kinect { depth: &registered, registration: &registration };
        let regions = instance_regions(&CLEAN.instances, AreaLimits::ALL);
        let points = view.points(&regions, &PointOptions::default()).unwrap();
        let (mut near, mut all) = (0, 0);
        for (region, points) in regions.list.iter().zip(&points) {
            let ellipsoid = &CLEAN.fruits[usize::from(region.value) - 1].ellipsoid;
            // The nearest raw pixel is up to half a pixel, 0.7 to 1 mm, from the ideal one.
            let error = |point: &ViewPoint| ellipsoid.distance_mm(&point.point_mm.cast()).abs();
            near += points.iter().filter(|point| error(point) < 1.5).count();
            all += points.len();
        }
        assert!(all > 1000 && near * 100 > all * 93, "{near} of {all}");
        // A fruit in sight is seen by the colour camera where its near pole projects to.
        for (instance, fruit) in
            (1_u8..).zip(&CLEAN.fruits).filter(|(_, fruit)| fruit.visible_fraction > 0.97)
        {
            let centre = Point3::from(fruit.ellipsoid.centre_mm);
            let pole = centre - centre.coords.normalize() * fruit.ellipsoid.semi_axes_mm[1];
            let (column, row) = view.project(&pole).unwrap();
            let seen = CLEAN.instances.get(column.round() as i64, row.round() as i64);
            assert_eq!(seen, Some(instance));
        }
    }

    #[test]
    fn segmented_and_back_projected_points_lie_on_the_fruit() {
        let registration = Registration::new(&NOISY.calibration);
        let registered = registration.register(&NOISY.raw_depth).unwrap();
        let view = View::Kinect { depth: &registered, registration: &registration };
        let regions = segment(&NOISY.colour, &preset("jujube")).unwrap();
        let all = |options: &PointOptions| view.points(&regions, options).unwrap().concat();
        let share = |points: &[ViewPoint]| {
            let near = points.iter().filter(|point| error_mm(&NOISY.fruits, point) < 6.0).count();
            near as f64 / points.len() as f64
        };
        let points = all(&PointOptions::default());
        assert!(points.len() > 1000, "{}", points.len());
        // As they come some are flying, or belong to what is beside the fruit.
        assert!(share(&points) > 0.85, "{}", share(&points));
        // Away from depth edges (spans of 15 mm over 3x3 pixels) nearly none is.
        let steady = all(&PointOptions { flying_span_mm: Some(15.0), ..PointOptions::default() });
        assert!(steady.len() * 2 > points.len(), "{} of {}", steady.len(), points.len());
        assert!(share(&steady) > 0.95, "{}", share(&steady));
    }

    #[test]
    fn every_fruit_in_the_open_is_segmented() {
        let regions = segment(&NOISY.colour, &preset("jujube")).unwrap();
        for (instance, fruit) in (1_u8..).zip(&NOISY.fruits).filter(|(_, fruit)| fruit.visible_fraction > 0.5)
        {
            let (mut own, mut found) = (0, 0);
            for (pixel, label) in NOISY.instances.pixels.iter().zip(&regions.image.pixels) {
                own += u32::from(*pixel == instance);
                found += u32::from(*pixel == instance && *label != 0);
            }
            assert!(found * 100 > own * 85, "{fruit:?}: {found} of {own}");
        }
    }

    #[test]
    fn what_stands_before_a_fruit_takes_from_what_is_seen_of_it() {
        let bare = SceneOptions {
            branch_count: 0,
            shoot_count: 0,
            leaf_count: 0,
            occluding_leaf_count: 0,
            fruit_count: 1,
            ..PERFECT
        };
        let (alone, _) = patch(&bare);
        assert_eq!(alone.fruits.len(), 1);
        assert!(alone.fruits[0].visible_fraction > 0.97, "its stalk alone is before it");
        let (hidden, _) = patch(&SceneOptions { occluding_leaf_count: 3, ..bare });
        let fraction = hidden.fruits[0].visible_fraction;
        assert_eq!(hidden.fruits[0].ellipsoid, alone.fruits[0].ellipsoid);
        assert!(fraction < 0.9, "{fraction}");
    }

    #[test]
    fn the_same_bits_on_every_machine() {
        let options = SceneOptions { fruit_count: 4, shoot_count: 3, leaf_count: 8, ..OPTIONS };
        let camera = Pinhole::new(110.0, 110.0, 79.5, 59.5).unwrap();
        let frame = render_depth_patch(&Scene::new(&options), &camera, 160, 120);
        // FNV-1a over depth bits and colours. It changes with the scene, never with the machine.
        let mut digest = 0xcbf2_9ce4_8422_2325_u64;
        let depth = frame.depth.pixels.iter().flat_map(|z_mm| z_mm.to_bits().to_le_bytes());
        for byte in depth.chain(frame.colour.pixels.iter().flatten().copied()) {
            digest = (digest ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
        assert_eq!(digest, 0x05b7_e86c_b617_b896, "{digest:#018x}");
    }

    #[test]
    fn daylight_changes_the_picture_and_not_the_depth() {
        let frame = |daylight| {
            let options = SceneOptions { fruit_count: 2, shoot_count: 2, leaf_count: 4, daylight, ..OPTIONS };
            let camera = Pinhole::new(365.0, 365.0, 159.5, 119.5).unwrap();
            render_depth_patch(&Scene::new(&options), &camera, 320, 240)
        };
        let [sun, overcast, evening] = [Daylight::Sun, Daylight::Overcast, Daylight::Evening].map(frame);
        assert_eq!(sun.depth, overcast.depth);
        let mean = |frame: &RegisteredFrame, channel: usize| {
            let values = frame.colour.pixels.iter().map(|pixel| f64::from(pixel[channel]));
            values.sum::<f64>() / frame.colour.pixels.len() as f64
        };
        assert!(mean(&evening, 1) < mean(&sun, 1));
        assert!(mean(&evening, 0) / mean(&evening, 2) > mean(&sun, 0) / mean(&sun, 2));
        assert!(mean(&overcast, 1) > 0.5 * mean(&sun, 1) && overcast.colour != sun.colour);
    }
}
