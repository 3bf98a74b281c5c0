//! Clouds made from a number, the same on every machine, and a digest of what was found in them. For the paper's search;
//! see [`crate::view`] for the default one.
//!
//! For proofs on boards without a link: host and board make the same cloud, search it and compare one number. A scene
//! is one to three jujubes seen from one side with half a millimetre of noise, and clutter around them.

use varsac_core::rng::Stream;
use varsac_core::{Config, Constraint, Covariance, Detection, Detector, Point3, Status, Workspace};

/// Points of a scene; a third of them clutter.
pub const SCENE_POINTS: usize = 300;
/// Points of [`one_fruit`].
pub const FRUIT_POINTS: usize = 200;

/// Semi-axes of the fruit, mm: the mean of the Lingwu long jujube.
const SEMI_AXES: [f32; 3] = [21.75, 10.9, 10.9];

/// Fills `cloud` with scene `number`: the fruit share two thirds of the points.
pub fn scene(number: u64, cloud: &mut [Point3]) {
    let mut stream = Stream::new(number);
    let fruit_points = cloud.len() * 2 / 3;
    let count = 1 + (number % 3) as usize;
    let per_fruit = fruit_points / count;
    let fruit: [Fruit; 3] = core::array::from_fn(|_| Fruit::random(&mut stream));
    for (k, slot) in cloud.iter_mut().enumerate() {
        *slot = match fruit.get(k / per_fruit.max(1)) {
            Some(fruit) if k / per_fruit.max(1) < count => fruit.visible_point(&mut stream),
            _ => Point3::new(
                200.0 * uniform(&mut stream) - 100.0,
                200.0 * uniform(&mut stream) - 100.0,
                650.0 + 200.0 * uniform(&mut stream),
            ),
        };
    }
}

/// The nearer half of one jujube on the optical axis, 700 mm away, without noise or clutter: one whole fruit.
pub fn one_fruit(cloud: &mut [Point3]) {
    let mut stream = Stream::new(7);
    let fruit =
        Fruit { centre: [0.0, 0.0, 700.0], axes: [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]] };
    for slot in cloud.iter_mut() {
        *slot = fruit.visible_point(&mut stream);
    }
}

/// What was found, and every bit of it in one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Digested {
    /// Targets.
    pub targets: u32,
    /// Of these, the accepted.
    pub accepted: u32,
    /// FNV-1a over the bits of all targets; 0 without one.
    pub digest: u64,
}

impl Digested {
    /// With one more target: ellipsoid, attitude, counts, status and covariance.
    #[must_use]
    pub fn and(self, detection: &Detection) -> Self {
        let ellipsoid = &detection.ellipsoid;
        let centre: [f32; 3] = ellipsoid.centre.coords.into();
        let quaternion = ellipsoid.quaternion_xyzw();
        let (code, refused) = match detection.status {
            Status::Accepted => (0, [0.0; 2]),
            Status::Refused(refusal) => (1 + refusal.code as u32, [refusal.value, refusal.limit]),
        };
        let covariance = detection.covariance.as_ref().map_or(&[][..], Covariance::packed);
        let floats = centre
            .iter()
            .chain(&ellipsoid.semi_axes)
            .chain(ellipsoid.axes.as_flattened())
            .chain(&quaternion)
            .chain(&refused)
            .chain(covariance);
        let counts = [detection.score.inliers, detection.score.candidates, detection.report.trials, code];
        let words = floats.map(|value| value.to_bits()).chain(counts);
        let digest = words.fold(self.digest ^ 0xCBF2_9CE4_8422_2325, |hash, word| {
            word.to_le_bytes()
                .iter()
                .fold(hash, |hash, &byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3))
        });
        Self { targets: self.targets + 1, accepted: self.accepted + u32::from(code == 0), digest }
    }
}

/// Targets, accepted ones, digest: as boards and host print it.
impl core::fmt::Display for Digested {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} {} {:016x}", self.targets, self.accepted, self.digest)
    }
}

/// How scene `number` is searched: the paper's Table 5 with limits that real fruit keep and few trials, in four
/// variations. Written out here, so that tuning a preset does not move the proofs.
pub fn config(number: u64) -> Config {
    let mut config = Config {
        max_trials: 60,
        semi_axis_min: 9.5,
        semi_axis_max: 24.5,
        min_ratio: 0.6,
        ..Config::table5()
    };
    if number & 1 != 0 {
        config.constraint = Constraint::Trace;
    }
    if number & 2 != 0 {
        config.radius = 22.0;
        config.min_ratio = 0.0;
    }
    config
}

/// Makes scene `number`, searches it to the end by the paper's search, and digests all that was found.
pub fn search_digest(
    number: u64,
    cloud: &mut [Point3; SCENE_POINTS],
    workspace: &mut Workspace<SCENE_POINTS>,
) -> Digested {
    scene(number, cloud);
    let Ok(detector) = Detector::new(config(number)) else { return Digested::default() };
    let Ok(run) = detector.detect(cloud, workspace.scratch(), number) else { return Digested::default() };
    run.fold(Digested::default(), |before, detection| before.and(&detection))
}

/// A jujube.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fruit {
    pub(crate) centre: [f32; 3],
    /// Row k: unit vector of semi-axis k.
    pub(crate) axes: [[f32; 3]; 3],
}

impl Fruit {
    pub(crate) fn random(stream: &mut Stream) -> Self {
        let centre =
            [120.0 * uniform(stream) - 60.0, 120.0 * uniform(stream) - 60.0, 680.0 + 120.0 * uniform(stream)];
        let long = direction(stream);
        let other = direction(stream);
        let second = unit(cross(long, other));
        Self { centre, axes: [long, second, cross(long, second)] }
    }

    /// Depth at which the ray through (x, y, 1) meets it, mm.
    pub(crate) fn depth_mm(&self, [x, y]: [f32; 2]) -> Option<f32> {
        let (mut ray_ray, mut ray_centre, mut centre_centre) = (0.0, 0.0, 0.0);
        for (axis, semi_axis) in self.axes.iter().zip(SEMI_AXES) {
            let ray = (axis[0] * x + axis[1] * y + axis[2]) / semi_axis;
            let [cx, cy, cz] = self.centre;
            let centre = (axis[0] * cx + axis[1] * cy + axis[2] * cz) / semi_axis;
            ray_ray += ray * ray;
            ray_centre += ray * centre;
            centre_centre += centre * centre;
        }
        let discriminant = ray_centre * ray_centre - ray_ray * (centre_centre - 1.0);
        (discriminant > 0.0).then(|| (ray_centre - libm::sqrtf(discriminant)) / ray_ray)
    }

    /// A point of the side that faces the camera, moved along its ray by noise. A side that is turned away 64 times in
    /// a row is taken all the same: the loop has to end.
    fn visible_point(&self, stream: &mut Stream) -> Point3 {
        let mut point = self.centre;
        for _ in 0..64 {
            let u = direction(stream);
            let mut normal = [0.0; 3];
            point = self.centre;
            for ((axis, semi_axis), u) in self.axes.iter().zip(SEMI_AXES).zip(u) {
                for k in 0..3 {
                    point[k] += axis[k] * (semi_axis * u);
                    normal[k] += axis[k] * (u / semi_axis);
                }
            }
            if normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2] < 0.0 {
                break;
            }
        }
        // Sum of four: close to a normal distribution of 0.5 mm.
        let sum = uniform(stream) + uniform(stream) + uniform(stream) + uniform(stream);
        let scale = 1.0 + (sum - 2.0) * 0.87 / point[2];
        Point3::new(point[0] * scale, point[1] * scale, point[2] * scale)
    }
}

/// In [0, 1), 24 bits.
pub(crate) fn uniform(stream: &mut Stream) -> f32 {
    stream.below(1 << 24) as f32 / (1 << 24) as f32
}

/// A unit vector, equally likely in all directions.
pub(crate) fn direction(stream: &mut Stream) -> [f32; 3] {
    let z = 2.0 * uniform(stream) - 1.0;
    let angle = core::f32::consts::TAU * uniform(stream);
    let rim = libm::sqrtf(1.0 - z * z);
    [rim * libm::cosf(angle), rim * libm::sinf(angle), z]
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let norm = libm::sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    v.map(|x| x / norm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fruit_is_seen_from_one_side() {
        let mut cloud = [Point3::origin(); 200];
        one_fruit(&mut cloud);
        assert!(cloud.iter().all(|point| point.z < 702.0 && point.z > 687.0), "{cloud:?}");
    }

    #[test]
    fn scenes_differ() {
        let mut first = [Point3::origin(); SCENE_POINTS];
        let mut second = first;
        scene(1, &mut first);
        scene(2, &mut second);
        assert!(first.iter().zip(&second).all(|(a, b)| a != b));
        scene(1, &mut second);
        assert_eq!(first, second);
    }
}
