//! Composes a scene: branches across the view, shoots with fruit and leaves, leaves before fruit, leaves far behind.
//!
//! Solid bodies keep apart: fruit never touch wood or, by [`SceneOptions::gap_mm`], each other. Each search for a
//! place is bounded, so that a crowded scene has fewer fruit than asked for and building it always ends.

use nalgebra::{Matrix3, Point3, Vector3};

use super::fruit::{FruitKind, Pole};
use super::noise::Noise;
use super::sensor::SensorOptions;
use super::shade::Material;
use super::shape::{Capsule, Ellipsoid, Shape};
use crate::eval::EllipsoidF64;

/// Places tried for one fruit.
const FRUIT_TRIES: usize = 300;
/// Straight pieces of a branch.
const BRANCH_PIECES: usize = 28;
/// Branches, shoots or leaves a scene may have of each kind.
const MAX_COUNT: usize = 500;
/// Bodies a scene may have beside its fruit: they are numbered by `u16`. What would come later is left out.
const MAX_BODIES: usize = 65_000;

/// The light of the colour image; the depth camera brings its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Daylight {
    /// The sun behind the camera, with shadows.
    #[default]
    Sun,
    /// The sky alone, exposed accordingly.
    Overcast,
    /// A low sun: dimmer and warmer.
    Evening,
}

impl Daylight {
    /// Whether the sun shines.
    pub(super) fn has_sun(self) -> bool {
        self != Self::Overcast
    }

    /// Factors on linear red, green and blue: exposure and tint.
    pub(super) fn exposure(self) -> Vector3<f32> {
        match self {
            Self::Sun => Vector3::new(1.0, 1.0, 1.0),
            Self::Overcast => Vector3::new(2.2, 2.3, 2.5),
            Self::Evening => Vector3::new(0.62, 0.45, 0.28),
        }
    }
}

/// What a scene is made of and how the sensor sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SceneOptions {
    /// Every seed is valid; the same seed gives the same scene.
    pub seed: u64,
    /// Kind of fruit.
    pub kind: FruitKind,
    /// Fruit asked for, at most 255.
    pub fruit_count: usize,
    /// Nearest and farthest depth of a fruit's centre, millimetres.
    pub distance_mm: (f64, f64),
    /// Half-width and half-height of the part of the view in which fruit hang, as slopes x/z and y/z.
    pub view_slopes: (f64, f64),
    /// Least gap between two fruit, millimetres; measured between capsules around them.
    pub gap_mm: f64,
    /// Branches that cross the view. Without any, fruit hang from nothing anywhere in it.
    pub branch_count: usize,
    /// Shoots without fruit, each with up to ten leaves.
    pub shoot_count: usize,
    /// Single leaves on branches and shoots.
    pub leaf_count: usize,
    /// Leaves hung before a fruit each, some 10 to 40 mm nearer, covering part of it.
    pub occluding_leaf_count: usize,
    /// Share of leaves that have withered to the brown of fruit, 0 to 1: what colour alone takes for fruit.
    pub withered_share: f64,
    /// Leafy branches of other trees behind the scene.
    pub far_branch_count: usize,
    /// The light of the colour image.
    pub daylight: Daylight,
    /// The depth sensor.
    pub sensor: SensorOptions,
}

impl Default for SceneOptions {
    /// The demo: fourteen jujubes at 0.48 to 0.68 m.
    fn default() -> Self {
        Self {
            seed: 1,
            kind: FruitKind::Jujube,
            fruit_count: 14,
            distance_mm: (480.0, 680.0),
            view_slopes: (0.48, 0.36),
            gap_mm: 1.0,
            branch_count: 3,
            shoot_count: 18,
            leaf_count: 80,
            occluding_leaf_count: 5,
            withered_share: 0.02,
            far_branch_count: 4,
            daylight: Daylight::Sun,
            sensor: SensorOptions::default(),
        }
    }
}

/// A body with its look.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    pub(super) shape: Shape,
    pub(super) material: Material,
    /// Index of the fruit that this is.
    pub(super) fruit: Option<u8>,
    /// No point of it is nearer than this along z, millimetres.
    pub(super) front_mm: f64,
}

/// Bodies with their places, and the truth about the fruit among them.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(super) options: SceneOptions,
    /// In ascending order of `front_mm`: a ray may stop asking at the first body that begins behind what it has met.
    pub(super) bodies: Vec<Body>,
    pub(super) fruits: Vec<EllipsoidF64>,
    /// What the far background looks like.
    pub(super) backdrop_field: u32,
}

impl Scene {
    /// Composes the scene. `O(fruit^2 + leaves * fruit)`, a few milliseconds.
    pub fn new(options: &SceneOptions) -> Self {
        let noise = Noise::new(options.seed);
        let mut composer = Composer {
            backdrop_field: noise.clone().bits() as u32,
            options: *options,
            noise: noise.apart(),
            bodies: Vec::new(),
            wood: Vec::new(),
            fruits: Vec::new(),
            hulls: Vec::new(),
        };
        for index in 0..options.branch_count.min(MAX_COUNT) {
            composer.add_branch(index);
        }
        for _ in 0..options.fruit_count.min(usize::from(u8::MAX)) {
            composer.add_fruit();
        }
        for _ in 0..options.shoot_count.min(MAX_COUNT) {
            composer.add_shoot();
        }
        for _ in 0..options.leaf_count.min(MAX_COUNT) {
            composer.add_leaf();
        }
        for _ in 0..options.occluding_leaf_count.min(MAX_COUNT) {
            composer.add_occluding_leaf();
        }
        for _ in 0..options.far_branch_count.min(MAX_COUNT) {
            composer.add_far_branch();
        }
        let Composer { mut bodies, fruits, backdrop_field, .. } = composer;
        bodies.sort_by(|a, b| a.front_mm.total_cmp(&b.front_mm));
        Self { options: *options, bodies, fruits, backdrop_field }
    }

    /// The fruit, whether they can be seen or not.
    pub fn fruits(&self) -> &[EllipsoidF64] {
        &self.fruits
    }

    /// The fruit that a body is; nothing for other bodies and for numbers of none.
    pub(super) fn fruit_of(&self, body: u16) -> Option<u8> {
        self.bodies.get(usize::from(body)).and_then(|body| body.fruit)
    }
}

/// A scene in the making.
pub(super) struct Composer {
    pub(super) options: SceneOptions,
    pub(super) noise: Noise,
    bodies: Vec<Body>,
    /// Branches and shoots, from which things hang.
    pub(super) wood: Vec<Capsule>,
    pub(super) fruits: Vec<EllipsoidF64>,
    /// A capsule around each fruit.
    pub(super) hulls: Vec<Capsule>,
    backdrop_field: u32,
}

impl Composer {
    pub(super) fn push(&mut self, shape: Shape, material: Material) {
        if self.bodies.len() < MAX_BODIES {
            self.push_body(shape, material, None);
        }
    }

    fn push_body(&mut self, shape: Shape, material: Material, fruit: Option<u8>) {
        let front_mm = shape.rod().front_mm();
        self.bodies.push(Body { shape, material, fruit, front_mm });
    }

    pub(super) fn add_wood(&mut self, piece: Capsule, field: u32) {
        self.wood.push(piece);
        self.push(Shape::Capsule(piece), Material::Bark { field, brightness: 1.0 });
    }

    pub(super) fn field(&mut self) -> u32 {
        self.noise.bits() as u32
    }

    /// A branch on which fruit hang.
    fn add_branch(&mut self, index: usize) {
        let (near, far) = self.options.distance_mm;
        let z = self.noise.between(near + 0.25 * (far - near), far);
        // From above the view to its middle: fruit hang below.
        let share = (index as f64 + 0.5) / self.options.branch_count as f64;
        let level = (-1.2 + 1.75 * share) * self.options.view_slopes.1 + self.noise.normal() * 0.015;
        let field = self.field();
        for piece in self.branch(z, level, 7.5) {
            self.add_wood(piece, field);
        }
    }

    /// A branch from left to right through the whole view at depth `z`, its middle at slope `level`, sagging, wavy and
    /// tapering.
    pub(super) fn branch(&mut self, z: f64, level: f64, radius: f64) -> Vec<Capsule> {
        let noise = &mut self.noise;
        let (slope, sag) = (noise.between(-0.14, 0.14), noise.between(-0.03, 0.12));
        let waves = [2.3, 5.1, 9.7, 17.0].map(|frequency| {
            let phase = noise.between(0.0, std::f64::consts::TAU);
            (frequency, phase, noise.normal_vector() * (0.045 * z / frequency))
        });
        let place = |k: usize| {
            let along = 2.0 * k as f64 / BRANCH_PIECES as f64 - 1.0;
            let wave: Vector3<f64> = waves
                .iter()
                .map(|(frequency, phase, size)| size * libm::sin(along * frequency + phase))
                .sum();
            let y = level + 1.1 * (slope * along + sag * along * along);
            Point3::new(1.1 * along * z, y * z, z) + wave
        };
        let taper = |k: usize| radius * (1.0 - 0.5 * k as f64 / BRANCH_PIECES as f64);
        (0..BRANCH_PIECES).map(|k| Capsule { from: place(k), to: place(k + 1), radius: taper(k) }).collect()
    }

    /// A random place on the wood; nothing where there is none.
    pub(super) fn place_on_wood(&mut self) -> Option<Point3<f64>> {
        if self.wood.is_empty() {
            return None;
        }
        let piece = self.wood[self.noise.below(self.wood.len())];
        Some(piece.from + (piece.to - piece.from) * self.noise.uniform())
    }

    /// One fruit on a shoot of its own, if a free place is found.
    fn add_fruit(&mut self) {
        let model = self.options.kind.model();
        let semi_axes = model.draw_semi_axes(&mut self.noise);
        let pole_length = if model.pole == Pole::Longest { semi_axes[0] } else { semi_axes[2] };
        for _ in 0..FRUIT_TRIES {
            let stalk = (Vector3::new(0.0, -1.0, 0.0) + self.noise.direction() * 0.75).normalize();
            let Some((root, centre)) = self.fruit_place(pole_length) else { continue };
            let axes = match model.pole {
                Pole::Longest => self.noise.axes_about(stalk),
                Pole::Shortest => {
                    let about = self.noise.axes_about(stalk);
                    // The cyclic order keeps the axes right-handed.
                    Matrix3::from_rows(&[about.row(1), about.row(2), about.row(0)])
                }
            };
            let fruit = Ellipsoid { centre, semi_axes, axes };
            let hull = fruit.capsule();
            let tip = centre + stalk * pole_length;
            let knee = tip + stalk * self.noise.between(5.0, 9.0);
            let bow = nalgebra::center(&root, &knee) + self.noise.normal_vector() * 5.0;
            let shoot =
                [(root, bow, 1.7), (bow, knee, 1.3)].map(|(from, to, radius)| Capsule { from, to, radius });
            let free = self.hulls.iter().all(|other| hull.gap(other) >= self.options.gap_mm)
                && self.wood.iter().all(|wood| hull.gap(wood) >= 1.0)
                && shoot.iter().all(|piece| self.hulls.iter().all(|other| piece.gap(other) >= 1.0))
                && shoot.iter().all(|piece| hull.gap(piece) >= 0.5);
            if free {
                let field = self.field();
                for piece in shoot {
                    self.add_wood(piece, field);
                }
                let stem = Capsule { from: knee, to: tip - stalk * 1.5, radius: 0.9 };
                self.push(Shape::Capsule(stem), Material::Stem { brightness: 1.0 });
                let material = Material::Skin { skin: model.skin, pole: model.pole, field: self.field() };
                self.push_body(Shape::Ellipsoid(fruit), material, Some(self.fruits.len() as u8));
                self.fruits.push(EllipsoidF64::of_matrix(centre.coords, semi_axes.into(), axes));
                self.hulls.push(hull);
                return;
            }
        }
    }

    /// Where a shoot starts and where the centre of its fruit would hang, within the view and the range of distance.
    fn fruit_place(&mut self, pole_length: f64) -> Option<(Point3<f64>, Point3<f64>)> {
        let (near, far) = self.options.distance_mm;
        let (slope_x, slope_y) = self.options.view_slopes;
        let root = self.place_on_wood().unwrap_or_else(|| {
            let z = self.noise.between(near, far);
            let (x, y) = (self.noise.between(-slope_x, slope_x), self.noise.between(-slope_y, slope_y));
            Point3::new(x * z, y * z, z)
        });
        let noise = &mut self.noise;
        let drop = pole_length + noise.between(12.0, 75.0);
        let centre = root + Vector3::new(noise.normal() * 24.0, drop, noise.normal() * 22.0 - 8.0);
        let inside = (near..=far).contains(&centre.z)
            && centre.x.abs() <= slope_x * centre.z
            && centre.y.abs() <= slope_y * centre.z;
        inside.then_some((root, centre))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fruit_hang_in_view_and_apart() {
        for seed in 0..20 {
            let options = SceneOptions { seed, fruit_count: 20, ..SceneOptions::default() };
            let scene = Scene::new(&options);
            assert!(scene.fruits().len() >= 15, "seed {seed}: {}", scene.fruits().len());
            for (k, fruit) in scene.fruits().iter().enumerate() {
                let [x, y, z] = fruit.centre_mm;
                assert!((480.0..=680.0).contains(&z) && x.abs() <= 0.48 * z && y.abs() <= 0.36 * z);
                let [a, b, c] = fruit.semi_axes_mm;
                assert!(a >= b && b >= c);
                for other in &scene.fruits()[k + 1..] {
                    // Points on the surface of one fruit are outside of the other.
                    for axis in 0..3 {
                        for side in [-1.0, 1.0] {
                            let tip = Vector3::from(other.axes[axis]) * other.semi_axes_mm[axis] * side;
                            assert!(fruit.level(&(Point3::from(other.centre_mm) + tip)) > 1.0);
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_seed_is_a_scene() {
        let scene = |seed| Scene::new(&SceneOptions { seed, ..SceneOptions::default() });
        assert_eq!(scene(3).fruits, scene(3).fruits);
        assert_ne!(scene(3).fruits, scene(4).fruits);
    }

    #[test]
    fn building_ends_where_nothing_fits() {
        let crowded = SceneOptions { gap_mm: 1e6, fruit_count: 1000, ..SceneOptions::default() };
        assert_eq!(Scene::new(&crowded).fruits().len(), 1);
        let bare = SceneOptions { branch_count: 0, ..SceneOptions::default() };
        assert!(Scene::new(&bare).fruits().len() > 5);
    }

    #[test]
    fn every_kind_can_be_had() {
        for kind in FruitKind::ALL {
            let options = SceneOptions { kind, fruit_count: 3, ..SceneOptions::default() };
            let scene = Scene::new(&options);
            assert!(!scene.fruits().is_empty(), "{}", kind.name());
            for fruit in scene.fruits() {
                let axes = fruit.axes.map(Vector3::from);
                assert!((axes[0].cross(&axes[1]) - axes[2]).norm() < 1e-12);
            }
        }
    }
}
