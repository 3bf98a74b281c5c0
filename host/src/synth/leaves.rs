//! Leaves of a scene: along shoots, singly on the wood, before fruit, and on trees behind.

use nalgebra::{Matrix3, Point3, Vector3};

use super::scene::Composer;
use super::shade::Material;
use super::shape::{Capsule, Leaf, Shape};

/// Places tried for one leaf.
const LEAF_TRIES: usize = 6;
/// Straight pieces of a shoot, each with two leaves.
const SHOOT_PIECES: usize = 5;
/// Downwards; the image's y.
const DOWN: Vector3<f64> = Vector3::new(0.0, 1.0, 0.0);
/// Distance of the trees behind, nearest and farthest, as multiples of the scene's farthest; their brightness there.
const FAR_DISTANCES: (f64, f64) = (1.4, 2.6);
const FAR_BRIGHTNESS: (f32, f32) = (0.60, 0.30);
/// Shoots of a branch behind.
const FAR_SHOOTS: usize = 9;

impl Composer {
    /// A shoot of the nearest trees, arching from a branch.
    pub(super) fn add_shoot(&mut self) {
        let Some(root) = self.place_on_wood() else { return };
        let heading = self.noise.direction() + DOWN * 0.3;
        self.grow_shoot(root, heading, 15.0, 1.0);
    }

    /// A branch of the trees behind, in the shade, with shoots of its own.
    pub(super) fn add_far_branch(&mut self) {
        let (near, far) = FAR_DISTANCES;
        let share = self.noise.uniform();
        let z = self.options.distance_mm.1 * (near + (far - near) * share);
        let (bright, dark) = FAR_BRIGHTNESS;
        let brightness = bright + (dark - bright) * share as f32;
        let level = self.noise.between(-0.6, 0.55);
        let field = self.field();
        let pieces = self.branch(z, level, 7.0);
        for &piece in &pieces {
            self.push(Shape::Capsule(piece), Material::Bark { field, brightness });
        }
        for _ in 0..FAR_SHOOTS {
            let piece = pieces[self.noise.below(pieces.len())];
            let heading = self.noise.direction() + DOWN * 0.2;
            self.grow_shoot(piece.to, heading, 24.0, brightness);
        }
    }

    /// Wood from `root` towards `heading`, bending down with its weight, leaves to either side in turn.
    fn grow_shoot(&mut self, root: Point3<f64>, heading: Vector3<f64>, piece_mm: f64, brightness: f32) {
        let mut heading = heading.normalize();
        let mut from = root;
        for k in 0..SHOOT_PIECES {
            heading = (heading + DOWN * 0.16 + self.noise.normal_vector() * 0.08).normalize();
            let to = from + heading * (piece_mm * self.noise.between(0.8, 1.2));
            let piece = Capsule { from, to, radius: 1.6 - 0.2 * k as f64 };
            if self.hulls.iter().any(|hull| hull.gap(&piece) < 1.0) {
                return;
            }
            self.push(Shape::Capsule(piece), Material::Stem { brightness });
            let side = self.noise.direction().cross(&heading).normalize();
            for (node, side) in [(nalgebra::center(&from, &to), side), (to, -side)] {
                self.hang_leaf(node, heading * 0.75 + side, brightness);
            }
            from = to;
        }
    }

    /// A leaf somewhere on the wood.
    pub(super) fn add_leaf(&mut self) {
        for _ in 0..LEAF_TRIES {
            let Some(root) = self.place_on_wood() else { return };
            let along = self.noise.direction() + Vector3::new(0.0, 0.35, -0.1);
            if self.hang_leaf(root, along, 1.0) {
                return;
            }
        }
    }

    /// A leaf with its stalk from `root` towards `along`, its face turned up to the light, if no fruit is in the way.
    fn hang_leaf(&mut self, root: Point3<f64>, along: Vector3<f64>, brightness: f32) -> bool {
        let noise = &mut self.noise;
        let along = along.normalize();
        let face = Vector3::new(0.0, -0.65, -0.6) + noise.direction() * 0.75;
        let half_length = noise.between(15.0, 28.0);
        let stalk = noise.between(3.0, 7.0);
        let leaf = self.leaf(root + along * (half_length + stalk), along, face, half_length);
        let free = self.keeps_off_fruit(&leaf);
        if free {
            let stem = Capsule { from: root, to: leaf.point(-0.97, 0.0), radius: 0.7 };
            self.push(Shape::Capsule(stem), Material::Stem { brightness });
            self.push_leaf(leaf, brightness);
        }
        free
    }

    /// A leaf between the camera and a fruit, off its centre so that part of the fruit stays in sight.
    pub(super) fn add_occluding_leaf(&mut self) {
        if self.fruits.is_empty() {
            return;
        }
        let chosen = self.noise.below(self.fruits.len());
        let fruit = self.fruits[chosen];
        for _ in 0..LEAF_TRIES {
            let noise = &mut self.noise;
            let centre = Point3::from(fruit.centre_mm);
            let view = centre.coords.normalize();
            let aside = noise.axes_about(view).row(1).transpose();
            let before = fruit.semi_axes_mm[0] + noise.between(4.0, 24.0);
            let beside = noise.between(0.9, 1.7) * fruit.semi_axes_mm[1];
            let along = (noise.direction() + DOWN * 0.5).normalize();
            let face = noise.direction() * 0.5 - view;
            let half_length = noise.between(17.0, 26.0);
            let leaf = self.leaf(centre - view * before + aside * beside, along, face, half_length);
            if self.keeps_off_fruit(&leaf) {
                self.push_leaf(leaf, 1.0);
                return;
            }
        }
    }

    fn leaf(
        &mut self,
        centre: Point3<f64>,
        along: Vector3<f64>,
        face: Vector3<f64>,
        half_length: f64,
    ) -> Leaf {
        let noise = &mut self.noise;
        // Whatever part of the face is across the leaf; a face along it gets any direction across.
        let across = face.cross(&along);
        let axes = if across.norm_squared() < 1e-3 {
            noise.axes_about(along)
        } else {
            let across = across.normalize();
            Matrix3::from_rows(&[along.transpose(), across.transpose(), along.cross(&across).transpose()])
        };
        let half_width = half_length * noise.between(0.42, 0.55);
        let bend = noise.between(-0.010, 0.003);
        let fold = noise.between(0.12, 0.45);
        Leaf { centre, axes, half_length, half_width, bend, fold }
    }

    fn push_leaf(&mut self, leaf: Leaf, brightness: f32) {
        let ripeness = self.noise.uniform() as f32;
        let withered = self.noise.uniform() < self.options.withered_share;
        let field = self.field();
        self.push(Shape::Leaf(leaf), Material::Leaf { ripeness, withered, brightness, field });
    }

    /// Whether no sampled point of a leaf lies in a fruit or within a tenth of its size of one.
    fn keeps_off_fruit(&self, leaf: &Leaf) -> bool {
        (-4..=4).all(|i| {
            (-2..=2).all(|j| {
                let point = leaf.point(f64::from(i) / 4.0, f64::from(j) / 2.0);
                self.fruits.iter().all(|fruit| fruit.level(&point) > 1.1)
            })
        })
    }
}
