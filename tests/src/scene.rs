//! One-sided views of jujubes: what a depth camera at the origin (x right, y down, z forward, millimetres) sees.

use nalgebra::Vector3;
use varsac_core::Point3;

use crate::{
    body::{Body, narrow},
    random::Dice,
};

/// Focal length of the depth camera in pixels (Kinect v2: 365 to 369).
pub const FOCAL_PX: f64 = 365.0;

/// What makes a view hard. The default is none of it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Trouble {
    /// Standard deviation of the depth, along the ray.
    pub axial_noise_mm: f64,
    /// Part of all points that is clutter: pixels around the fruit with a depth uniform within 40 mm of its centre's.
    pub outlier_share: f64,
    /// A second fruit touches the first one.
    pub neighbour: bool,
    /// A leaf, 25 mm in front of the centre, hides what lies beyond a random line, a third of the outline on average.
    pub leaf: bool,
}

/// A view and its truth.
#[derive(Debug, Clone)]
pub struct View {
    /// The fruit the view is about.
    pub fruit: Body,
    /// Pixels in row-major order, then the clutter.
    pub cloud: Vec<Point3>,
}

impl View {
    /// A jujube of random attitude, 0.5 to 1.3 m from the camera, up to 22 degrees off its axis.
    pub fn jujube(dice: &mut Dice, trouble: &Trouble) -> Self {
        let z = dice.between(500.0, 1300.0);
        Self::jujube_at(dice, z, trouble)
    }

    /// The same at a given depth of the centre.
    pub fn jujube_at(dice: &mut Dice, z: f64, trouble: &Trouble) -> Self {
        let centre = Vector3::new(dice.between(-0.4, 0.4) * z, dice.between(-0.4, 0.4) * z, z);
        let fruit = Body::jujube(dice, centre);
        let mut bodies = vec![fruit];
        if trouble.neighbour {
            // The outlines touch where both fruit are thinnest, so bodies of other attitudes overlap a little.
            let turn = dice.between(0.0, core::f64::consts::TAU);
            let side = Vector3::new(libm::cos(turn), libm::sin(turn), 0.0);
            bodies.push(Body::jujube(dice, centre + 24.0 * side));
        }
        let leaf = trouble.leaf.then(|| Leaf::over(&fruit, dice));
        let reach = 50.0 / z;
        let mut cloud = Vec::new();
        for v in pixels(centre.y / z, reach) {
            for u in pixels(centre.x / z, reach) {
                let ray = Vector3::new(f64::from(u) / FOCAL_PX, f64::from(v) / FOCAL_PX, 1.0);
                let hidden = leaf.as_ref().and_then(|leaf| leaf.depth(&ray));
                let seen = bodies.iter().filter_map(|body| body.first_hit(&ray)).reduce(f64::min);
                if let Some(depth) = hidden.or(seen) {
                    cloud.push(narrow(&(ray * (depth + trouble.axial_noise_mm * dice.normal()))));
                }
            }
        }
        let clutter = cloud.len() as f64 * trouble.outlier_share / (1.0 - trouble.outlier_share);
        for _ in 0..libm::round(clutter) as usize {
            let lateral = dice.in_cube(40.0);
            let depth = z + lateral.z;
            cloud.push(narrow(&(Vector3::new(centre.x + lateral.x, centre.y + lateral.y, z) * (depth / z))));
        }
        Self { fruit, cloud }
    }
}

/// Integer pixel coordinates within `reach` of `middle`, both as tangents.
fn pixels(middle: f64, reach: f64) -> core::ops::RangeInclusive<i32> {
    libm::ceil(FOCAL_PX * (middle - reach)) as i32..=libm::floor(FOCAL_PX * (middle + reach)) as i32
}

/// A plane sheet parallel to the image that covers one side of a line.
struct Leaf {
    /// Points with `normal . (x/z, y/z) > offset` are covered.
    normal: [f64; 2],
    offset: f64,
    depth_mm: f64,
}

impl Leaf {
    fn over(fruit: &Body, dice: &mut Dice) -> Self {
        let turn = dice.between(0.0, core::f64::consts::TAU);
        let normal = [libm::cos(turn), libm::sin(turn)];
        let c = fruit.centre;
        let middle = normal[0] * c.x / c.z + normal[1] * c.y / c.z;
        Self { normal, offset: middle + dice.between(0.0, 10.0) / c.z, depth_mm: c.z - 25.0 }
    }

    fn depth(&self, ray: &Vector3<f64>) -> Option<f64> {
        (self.normal[0] * ray.x + self.normal[1] * ray.y > self.offset).then_some(self.depth_mm)
    }
}
