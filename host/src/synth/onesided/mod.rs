//! Seeded families of one-sided views: one fruit (and perhaps a neighbour) as a depth camera sees it, with the truth.
//!
//! This is the light generator for tens of thousands of scenes: it renders only the pixels around the fruit, by
//! analytic rays. Everything is drawn from one seed; unit millimetres, camera optical frame.

pub mod patch;
pub mod shapes;
mod view;

use self::patch::{Body, Draws, Patch, Sensor, Window, first_hit, record};
use self::shapes::{Pose, Shape, V3, along, cross, dot, length, minus, unit};
use crate::image::{Image, LabelImage};

/// Focal length of an ideal Kinect v2 depth camera, pixels.
pub const FOCAL_PX: f64 = 365.456;

/// What stands where the fruit should be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Subject {
    /// A fruit: semi-axes drawn around these means with these standard deviations of the logarithms.
    Fruit {
        /// Mean semi-axes, mm.
        mean_mm: V3,
        /// Standard deviation of `ln a`.
        sd_long: f64,
        /// Standard deviation of `(ln b + ln c) / 2`.
        sd_short: f64,
        /// Standard deviation of `ln b - ln c`.
        sd_ratio: f64,
        /// Exponent of the super-ellipsoid, 2 = ellipsoid.
        exponent: f64,
    },
    /// A ball of this radius range.
    Ball(f64, f64),
    /// A flat ellipse in the fruit's colour with the fruit's outline.
    Disc,
    /// A branch in the fruit's colour, radius range.
    Branch(f64, f64),
}

/// The jujube of the paper: 22 x 11 x 11 mm, spread as in the size prior.
pub const JUJUBE: Subject = Subject::Fruit {
    mean_mm: [21.75, 10.9, 10.9],
    sd_long: 0.035,
    sd_short: 0.042,
    sd_ratio: 0.058,
    exponent: 2.0,
};

/// A family of scenes: every pair is a range drawn from uniformly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Family {
    /// Name in tables.
    pub name: &'static str,
    /// What is in the middle.
    pub subject: Subject,
    /// True when the subject is not the fruit that is looked for: the scene has no truth.
    pub decoy: bool,
    /// Distance of its centre from the camera, mm.
    pub distance_mm: (f64, f64),
    /// Axial noise, mm.
    pub axial_mm: (f64, f64),
    /// Growth of the noise with the angle of incidence, 1 = Kinect v2.
    pub slant: f64,
    /// Lateral noise, pixels.
    pub lateral_px: (f64, f64),
    /// Depth counts, mm.
    pub quantum_mm: f64,
    /// Covered share of the pixels it would show alone.
    pub occlusion: (f64, f64),
    /// Chance of a second fruit near it.
    pub neighbour: f64,
    /// Further fruit that touch it or each other.
    pub touching: (f64, f64),
    /// Leaves and twigs around and behind it.
    pub clutter: (f64, f64),
    /// Distance of the background behind the fruit, mm.
    pub background_mm: (f64, f64),
    /// Chance of flying pixels, of holes at edges, of holes anywhere.
    pub defects: [f64; 3],
    /// Rays across a pixel, each way ([`Sensor::rays`]).
    pub rays: u32,
    /// The region is the fruit-coloured mask grown by so many pixels.
    pub margin_px: (f64, f64),
}

/// Nothing in the way, little noise, 0.5-0.9 m.
pub const CLEAN: Family = Family {
    name: "clean",
    subject: JUJUBE,
    decoy: false,
    distance_mm: (500.0, 900.0),
    axial_mm: (0.4, 0.6),
    slant: 0.0,
    lateral_px: (0.0, 0.1),
    quantum_mm: 0.0,
    occlusion: (0.0, 0.0),
    neighbour: 0.0,
    touching: (0.0, 0.0),
    clutter: (0.0, 0.0),
    background_mm: (100.0, 400.0),
    defects: [0.0, 0.5, 0.0],
    rays: 1,
    margin_px: (0.0, 1.0),
};

/// 0.6-1.2 m, noise to 1.5 mm, half with a neighbour, leaves, about 44 % outliers in the region.
pub const HARD: Family = Family {
    name: "hard",
    subject: JUJUBE,
    decoy: false,
    distance_mm: (600.0, 1200.0),
    axial_mm: (0.4, 1.5),
    slant: 1.0,
    lateral_px: (0.0, 0.3),
    quantum_mm: 1.0,
    occlusion: (0.0, 0.0),
    neighbour: 0.5,
    touching: (0.0, 0.0),
    clutter: (0.0, 4.0),
    background_mm: (30.0, 300.0),
    defects: [0.4, 0.3, 0.01],
    rays: 1,
    margin_px: (0.0, 2.0),
};

/// One fruit, 0-50 % of it behind leaves.
pub const OCCLUDED: Family = Family {
    name: "occluded",
    distance_mm: (500.0, 1000.0),
    axial_mm: (0.4, 1.2),
    occlusion: (0.0, 0.5),
    neighbour: 0.0,
    margin_px: (0.0, 2.0),
    clutter: (0.0, 2.0),
    ..HARD
};

/// Everything at once over the whole range: the family the gate is measured on.
pub const ORCHARD: Family = Family {
    name: "orchard",
    distance_mm: (500.0, 1300.0),
    occlusion: (0.0, 0.6),
    neighbour: 0.3,
    margin_px: (1.0, 3.0),
    ..HARD
};

/// Two to four fruit that touch, nothing in front of them.
pub const TOUCHING: Family = Family {
    name: "touching",
    distance_mm: (500.0, 1000.0),
    axial_mm: (0.4, 1.2),
    neighbour: 0.0,
    touching: (1.0, 3.999),
    clutter: (0.0, 2.0),
    ..HARD
};

/// The same behind leaves.
pub const TOUCHING_LEAVES: Family = Family { name: "touching-leaves", occlusion: (0.0, 0.4), ..TOUCHING };

impl Family {
    /// The same family with another subject.
    pub const fn of(self, name: &'static str, subject: Subject) -> Self {
        Self { name, subject, ..self }
    }

    /// The same family with a subject that must not be taken for the fruit, whatever it is.
    pub const fn decoy(self, name: &'static str, subject: Subject) -> Self {
        Self { name, subject, decoy: true, ..self }
    }
}

/// A jujube scaled by a factor: the decoys of 0.7 and 1.3 times the size.
pub const fn scaled_jujube(factor: f64) -> Subject {
    Subject::Fruit {
        mean_mm: [21.75 * factor, 10.9 * factor, 10.9 * factor],
        sd_long: 0.035,
        sd_short: 0.042,
        sd_ratio: 0.058,
        exponent: 2.0,
    }
}

/// A jujube with the shape of a super-ellipsoid.
pub const fn boxy_jujube(exponent: f64) -> Subject {
    Subject::Fruit {
        mean_mm: [21.75, 10.9, 10.9],
        sd_long: 0.035,
        sd_short: 0.042,
        sd_ratio: 0.058,
        exponent,
    }
}

/// Jujubes whose size varies by +-15 % (standard deviation) as a whole and 6 % in shape.
pub const VARIED_JUJUBE: Subject = Subject::Fruit {
    mean_mm: [21.75, 10.9, 10.9],
    sd_long: 0.15,
    sd_short: 0.15,
    sd_ratio: 0.058,
    exponent: 2.0,
};

/// The true fruit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Centre and axes, longest first.
    pub pose: Pose,
    /// Semi-axes in the same order, mm.
    pub semi_axes_mm: V3,
    /// Visible share of the pixels it would show alone.
    pub visible: f64,
}

/// One scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// What the camera recorded.
    pub patch: Patch,
    /// The camera.
    pub sensor: Sensor,
    /// The bodies; `patch.owner` counts them from one.
    pub bodies: Vec<Body>,
    /// The fruit of the scene, the subject first; empty where the subject is a decoy.
    pub fruit: Vec<Truth>,
    /// Where a colour threshold would say fruit: 255, else 0.
    pub mask: LabelImage,
    /// The region grows the mask by so many pixels.
    pub margin_px: i64,
}

/// Pixels rendered around the subject beyond its own extent.
const BORDER_PX: i64 = 14;
/// Attempts to place a leaf or a neighbour.
const ATTEMPTS: usize = 80;

impl Scene {
    /// The scene of `family` that belongs to `seed`.
    pub fn new(family: &Family, seed: u64) -> Self {
        let mut draws = Draws::new(seed);
        let range = |draws: &mut Draws, (low, high)| draws.uniform(low, high);
        let distance = range(&mut draws, family.distance_mm);
        let (x, y) = (draws.uniform(-0.4, 0.4), draws.uniform(-0.35, 0.35));
        let centre = along([0.0; 3], distance, unit([x, y, 1.0]));
        let subject = subject(&family.subject, centre, &mut draws);
        let extent = extent(&subject);
        let sensor = Sensor {
            focal_px: FOCAL_PX,
            axial_mm: range(&mut draws, family.axial_mm),
            slant: family.slant,
            lateral_px: range(&mut draws, family.lateral_px),
            quantum_mm: family.quantum_mm,
            flying: family.defects[0],
            edge_hole: family.defects[1],
            hole: family.defects[2],
            rays: family.rays,
        };
        let mut bodies = vec![subject];
        if draws.chance(family.neighbour) {
            place_neighbour(&mut bodies, family, &mut draws);
        }
        let others = range(&mut draws, family.touching) as usize;
        place_touching(&mut bodies, others, family, &mut draws);
        let behind = range(&mut draws, family.background_mm);
        place_clutter(&mut bodies, range(&mut draws, family.clutter) as usize, &mut draws);
        let tilt = unit([draws.uniform(-0.5, 0.5), draws.uniform(-0.5, 0.5), 1.0]);
        let back = along(centre, (extent + behind) / distance, centre);
        bodies.push(Body {
            pose: Pose { centre: back, axes: frame_of(tilt) },
            shape: Shape::Plane,
            fruit_coloured: false,
        });
        let wanted = range(&mut draws, family.occlusion);
        place_leaves(&mut bodies, wanted, &mut draws);

        let pixels = |mm: f64| mm / centre[2] * FOCAL_PX;
        let reach = (0..=others).fold(extent, |reach, k| {
            bodies
                .get(k)
                .filter(|body| body.fruit_coloured)
                .map_or(reach, |body| reach.max(length(minus(body.pose.centre, centre)) + extent))
        });
        let half = pixels(1.3 * reach) as i64 + BORDER_PX;
        let (column, row) = (pixels(centre[0]) as i64, pixels(centre[1]) as i64);
        let side = (2 * half + 1) as usize;
        let window = Window { left: column - half, top: row - half, width: side, height: side };
        let patch = record(&bodies, &sensor, window, &mut draws);
        let mask = colour_mask(&patch, &bodies, &mut draws);
        let fruit = (0..bodies.len()).filter_map(|k| truth(&bodies, k)).collect::<Vec<_>>();
        let wanted = !family.decoy && matches!(family.subject, Subject::Fruit { .. });
        let fruit = if wanted { fruit } else { Vec::new() };
        let margin_px = libm::rint(range(&mut draws, family.margin_px)) as i64;
        Self { patch, sensor, bodies, fruit, mask, margin_px }
    }

    /// The mask moved by `shift` pixels and grown (or, negative, shrunk) by `grow` pixels, city-block distance in
    /// steps of one.
    pub fn mask_with(&self, grow: i64, shift: (i64, i64)) -> LabelImage {
        let mut mask = Image::filled(self.mask.width, self.mask.height, 0_u8);
        for v in 0..mask.height as i64 {
            for u in 0..mask.width as i64 {
                mask.set(u, v, self.mask.get(u - shift.0, v - shift.1).unwrap_or(0));
            }
        }
        for _ in 0..grow.abs() {
            mask = grown(&mask, grow > 0);
        }
        mask
    }

    /// Back-projected points of the region: the points of the mask first, then those of its margin; row by row.
    /// Returns them with the number of the former.
    pub fn cloud(&self, mask: &LabelImage) -> (Vec<[f32; 3]>, usize) {
        let mut region = mask.clone();
        for _ in 0..self.margin_px {
            region = grown(&region, true);
        }
        let mut inside = Vec::new();
        let mut margin = Vec::new();
        for v in 0..mask.height as i64 {
            for u in 0..mask.width as i64 {
                let depth = self.patch.depth.get(u, v).unwrap_or(0.0);
                if depth <= 0.0 || region.get(u, v) != Some(255) {
                    continue;
                }
                let point = self.point(u, v, depth);
                if mask.get(u, v) == Some(255) { inside.push(point) } else { margin.push(point) }
            }
        }
        let count = inside.len();
        inside.append(&mut margin);
        (inside, count)
    }

    /// The point that a pixel of the patch shows.
    pub fn point(&self, u: i64, v: i64, depth_mm: f32) -> [f32; 3] {
        let window = &self.patch.window;
        let (x, y) = ((window.left + u) as f32, (window.top + v) as f32);
        let focal = self.sensor.focal_px as f32;
        [x * depth_mm / focal, y * depth_mm / focal, depth_mm]
    }
}

fn frame_of(third: V3) -> [V3; 3] {
    let helper = if libm::fabs(third[0]) < 0.8 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let first = unit(cross(helper, third));
    [first, cross(third, first), third]
}

fn subject(subject: &Subject, centre: V3, draws: &mut Draws) -> Body {
    let axes = draws.rotation();
    let shape = match *subject {
        Subject::Fruit { mean_mm, sd_long, sd_short, sd_ratio, exponent } => {
            // Truncated at three standard deviations, so that every fruit is within the prior.
            let mut bounded = |sd: f64| sd * draws.normal().clamp(-3.0, 3.0);
            let (long, short, ratio) = (bounded(sd_long), bounded(sd_short), bounded(sd_ratio));
            // Where the size varies as a whole, length and thickness vary together.
            let short = if sd_long > 0.1 { long + 0.3 * short } else { short };
            let thick = [short + 0.5 * libm::fabs(ratio), short - 0.5 * libm::fabs(ratio)];
            let semi_axes = [
                mean_mm[0] * libm::exp(long),
                mean_mm[1] * libm::exp(thick[0]),
                mean_mm[2] * libm::exp(thick[1]),
            ];
            Shape::Superellipsoid { semi_axes, exponent }
        }
        Subject::Ball(low, high) => {
            let radius = draws.uniform(low, high);
            Shape::Superellipsoid { semi_axes: [radius; 3], exponent: 2.0 }
        }
        Subject::Disc => Shape::Disc { radii: [21.75, 10.9] },
        Subject::Branch(low, high) => {
            Shape::Cylinder { radius: draws.uniform(low, high), half_length: draws.uniform(60.0, 200.0) }
        }
    };
    Body { pose: Pose { centre, axes }, shape, fruit_coloured: true }
}

fn extent(body: &Body) -> f64 {
    match body.shape {
        Shape::Superellipsoid { semi_axes, .. } => semi_axes[0],
        _ => 25.0,
    }
}

fn truth(bodies: &[Body], index: usize) -> Option<Truth> {
    let Body { pose, shape: Shape::Superellipsoid { semi_axes, .. }, fruit_coloured: true } = bodies[index]
    else {
        return None;
    };
    Some(Truth { pose, semi_axes_mm: semi_axes, visible: 1.0 - occlusion(bodies, index) })
}

/// Share of a body's own pixels that something else covers.
fn occlusion(bodies: &[Body], index: usize) -> f64 {
    let body = &bodies[index];
    let centre = body.pose.centre;
    let half = (1.3 * extent(body) / centre[2] * FOCAL_PX) as i64 + 1;
    let (column, row) =
        ((centre[0] / centre[2] * FOCAL_PX) as i64, (centre[1] / centre[2] * FOCAL_PX) as i64);
    let (mut own, mut covered) = (0_u32, 0_u32);
    for v in row - half..=row + half {
        for u in column - half..=column + half {
            let ray = [u as f64 / FOCAL_PX, v as f64 / FOCAL_PX, 1.0];
            if body.shape.hit(&body.pose, ray).is_some() {
                own += 1;
                covered += u32::from(first_hit(bodies, ray).is_some_and(|(first, _, _)| first != index));
            }
        }
    }
    f64::from(covered) / f64::from(own.max(1))
}

/// A second fruit within reach of the first, not through it, covering at most a third of it.
fn place_neighbour(bodies: &mut Vec<Body>, family: &Family, draws: &mut Draws) {
    let first = bodies[0];
    for _ in 0..ATTEMPTS {
        let direction = draws.rotation()[0];
        let centre = along(first.pose.centre, draws.uniform(20.0, 46.0), direction);
        let second = subject(&family.subject, centre, draws);
        if touches(&first, &second) {
            continue;
        }
        bodies.push(second);
        if occlusion(bodies, 0) <= 0.35 {
            return;
        }
        bodies.pop();
    }
}

/// Further fruit, each pushed towards one of those already there until it touches, none through another and none covering
/// more than half of another.
fn place_touching(bodies: &mut Vec<Body>, count: usize, family: &Family, draws: &mut Draws) {
    for _ in 0..count {
        for _ in 0..ATTEMPTS {
            let anchor = bodies[(draws.uniform(0.0, bodies.len() as f64) as usize).min(bodies.len() - 1)];
            let direction = draws.rotation()[0];
            let free = subject(&family.subject, anchor.pose.centre, draws);
            let at = |distance: f64| Body {
                pose: Pose { centre: along(anchor.pose.centre, distance, direction), ..free.pose },
                ..free
            };
            let (mut near, mut far) = (5.0, 60.0);
            for _ in 0..12 {
                let middle = 0.5 * (near + far);
                if touches(&anchor, &at(middle)) { near = middle } else { far = middle }
            }
            let new = at(far + draws.uniform(0.0, 1.0));
            if bodies.iter().any(|body| touches(body, &new)) {
                continue;
            }
            bodies.push(new);
            if (0..bodies.len()).all(|k| occlusion(bodies, k) <= 0.5) {
                break;
            }
            bodies.pop();
        }
    }
}

/// True when two super-ellipsoids share volume: points of the second's surface inside the first, and the reverse.
fn touches(first: &Body, second: &Body) -> bool {
    let inside = |body: &Body, point: V3| {
        let Shape::Superellipsoid { semi_axes, exponent } = body.shape else { return false };
        let offset = minus(point, body.pose.centre);
        let sum: f64 = (0..3)
            .map(|k| libm::pow(libm::fabs(dot(body.pose.axes[k], offset)) / semi_axes[k], exponent))
            .sum();
        sum < 1.0
    };
    let surface = |body: &Body, other: &Body| {
        let Shape::Superellipsoid { semi_axes, .. } = body.shape else { return false };
        let steps = 24;
        (0..steps * steps).any(|k| {
            let (i, j) = (k % steps, k / steps);
            let polar = core::f64::consts::PI * (f64::from(i) + 0.5) / f64::from(steps);
            let around = core::f64::consts::TAU * f64::from(j) / f64::from(steps);
            let local = [
                libm::cos(polar) * semi_axes[0],
                libm::sin(polar) * libm::cos(around) * semi_axes[1],
                libm::sin(polar) * libm::sin(around) * semi_axes[2],
            ];
            let point = (0..3).fold(body.pose.centre, |p, axis| along(p, local[axis], body.pose.axes[axis]));
            inside(other, point)
        })
    };
    inside(first, second.pose.centre) || surface(first, second) || surface(second, first)
}

/// Leaves and twigs beside and behind the subject, none in front of it.
fn place_clutter(bodies: &mut Vec<Body>, count: usize, draws: &mut Draws) {
    let centre = bodies[0].pose.centre;
    let reach = extent(&bodies[0]);
    let away = unit(centre);
    for _ in 0..count {
        for _ in 0..ATTEMPTS {
            let sideways = frame_of(away);
            let (side, angle) = (draws.uniform(0.3, 1.6) * reach, draws.uniform(0.0, core::f64::consts::TAU));
            let at = along(centre, side * libm::cos(angle), sideways[0]);
            let at = along(at, side * libm::sin(angle), sideways[1]);
            let at = along(at, draws.uniform(-0.5, 2.5) * reach, away);
            let axes = draws.rotation();
            let shape = if draws.chance(0.4) {
                Shape::Cylinder { radius: draws.uniform(1.5, 6.0), half_length: draws.uniform(30.0, 120.0) }
            } else {
                Shape::Disc { radii: [draws.uniform(12.0, 30.0), draws.uniform(8.0, 16.0)] }
            };
            let free = occlusion(bodies, 0);
            bodies.push(Body { pose: Pose { centre: at, axes }, shape, fruit_coloured: false });
            if occlusion(bodies, 0) <= free + 0.02 {
                break;
            }
            bodies.pop();
        }
    }
}

/// Leaves in front until the wanted share is covered, within three hundredths where it can be had.
fn place_leaves(bodies: &mut Vec<Body>, wanted: f64, draws: &mut Draws) {
    if wanted <= 0.0 {
        return;
    }
    let centre = bodies[0].pose.centre;
    let reach = extent(&bodies[0]);
    let away = unit(centre);
    let sideways = frame_of(away);
    for _ in 0..ATTEMPTS {
        let covered = occlusion(bodies, 0);
        if covered >= wanted - 0.03 {
            return;
        }
        let (side, angle) = (draws.uniform(0.0, 1.6) * reach, draws.uniform(0.0, core::f64::consts::TAU));
        let at = along(centre, side * libm::cos(angle), sideways[0]);
        let at = along(at, side * libm::sin(angle), sideways[1]);
        let at = along(at, -(reach + draws.uniform(-6.0, 60.0)), away);
        let lean =
            along(along(away, draws.uniform(-0.8, 0.8), sideways[0]), draws.uniform(-0.8, 0.8), sideways[1]);
        let shape = Shape::Disc { radii: [draws.uniform(8.0, 22.0), draws.uniform(5.0, 13.0)] };
        let mut axes = frame_of(unit(lean));
        let turn = draws.uniform(0.0, core::f64::consts::TAU);
        let first = along([0.0; 3], libm::cos(turn), axes[0]);
        axes[0] = along(first, libm::sin(turn), axes[1]);
        axes[1] = cross(axes[2], axes[0]);
        bodies.push(Body { pose: Pose { centre: at, axes }, shape, fruit_coloured: false });
        if occlusion(bodies, 0) > wanted + 0.03 {
            bodies.pop();
        }
    }
}

/// Chance that a colour threshold is wrong at a pixel of the mask's border, and anywhere.
const BORDER_ERROR: f64 = 0.2;
const COLOUR_ERROR: f64 = 0.01;

/// Pixels whose centre shows a fruit-coloured body, with errors at the border and a few elsewhere.
fn colour_mask(patch: &Patch, bodies: &[Body], draws: &mut Draws) -> LabelImage {
    let coloured = |u: i64, v: i64| match patch.owner.get(u, v) {
        Some(owner @ 1..) => bodies[usize::from(owner) - 1].fruit_coloured,
        _ => false,
    };
    let mut mask = Image::filled(patch.owner.width, patch.owner.height, 0_u8);
    for v in 0..mask.height as i64 {
        for u in 0..mask.width as i64 {
            let here = coloured(u, v);
            let border =
                [(1, 0), (-1, 0), (0, 1), (0, -1)].iter().any(|&(du, dv)| coloured(u + du, v + dv) != here);
            let error = if border { BORDER_ERROR } else { COLOUR_ERROR };
            // Far from fruit a threshold makes no blobs that region growing would keep.
            let wrong = draws.chance(error) && (border || here);
            mask.set(u, v, if here != wrong { 255 } else { 0 });
        }
    }
    mask
}

/// One step of dilation (or of erosion) with the four neighbours.
fn grown(mask: &LabelImage, grow: bool) -> LabelImage {
    let mut result = mask.clone();
    let joins = if grow { 255 } else { 0 };
    for v in 0..mask.height as i64 {
        for u in 0..mask.width as i64 {
            let near = [(1, 0), (-1, 0), (0, 1), (0, -1)];
            if near.iter().any(|&(du, dv)| mask.get(u + du, v + dv) == Some(joins)) {
                result.set(u, v, joins);
            }
        }
    }
    result
}

/// Angle between two undirected axes, degrees.
pub fn axis_angle_deg(a: V3, b: V3) -> f64 {
    let (along, across) = (libm::fabs(dot(a, b)), length(cross(a, b)));
    libm::atan2(across, along).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_is_a_scene() {
        assert_eq!(Scene::new(&HARD, 3), Scene::new(&HARD, 3));
        assert_ne!(Scene::new(&HARD, 3).patch.depth, Scene::new(&HARD, 4).patch.depth);
    }

    #[test]
    fn clean_points_lie_on_the_true_surface() {
        let quiet = Family { axial_mm: (0.0, 0.0), lateral_px: (0.0, 0.0), ..CLEAN };
        for seed in 0..20 {
            let scene = Scene::new(&quiet, seed);
            let Truth { pose, semi_axes_mm, visible } = scene.fruit[0];
            assert_eq!(visible, 1.0);
            let mut on = 0;
            let (cloud, _) = scene.cloud(&scene.mask);
            for point in &cloud {
                let offset = minus(point.map(f64::from), pose.centre);
                let squares: f64 =
                    (0..3).map(|k| libm::pow(dot(pose.axes[k], offset) / semi_axes_mm[k], 2.0)).sum();
                on += usize::from(libm::fabs(libm::sqrt(squares) - 1.0) < 0.05);
            }
            // The rest is background behind wrongly coloured border pixels, and mixed pixels.
            assert!(5 * on > 3 * cloud.len(), "seed {seed}: {on} of {}", cloud.len());
        }
    }

    #[test]
    fn leaves_cover_what_was_asked_for() {
        let mut worst: f64 = 0.0;
        for seed in 0..20 {
            let family = Family { occlusion: (0.4, 0.4), ..OCCLUDED };
            worst = worst.max(libm::fabs(Scene::new(&family, seed).fruit[0].visible - 0.6));
        }
        assert!(worst < 0.06, "{worst}");
    }
}
