//! The same bits in every build: a few hundred whole searches over clouds made here, and a digest of everything that
//! came out of them, compared with `tests/vectors/digest.txt`.
//!
//! It uses nothing but this crate and `libm`, so that it can run where nothing else does: core alone or in the
//! workspace, debug or release, any `target-cpu`, any feature. `VARSAC_BLESS=1` rewrites the file, which is right only
//! together with a new version of the numeric contract.

use varsac_core::{
    CentralQuadric, Config, Constraint, Detection, Detector, Finish, Observer, Point3, Quadric, Step,
    VarsacReport, Workspace, rng::Stream,
};

/// Version of `core/docs/numerics.md` that the digests belong to.
const CONTRACT_VERSION: u32 = 2;
const VECTORS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/vectors/digest.txt");

// ---- Clouds ----

/// Random numbers in `f32`, from the core's own stream: exact integers, scaled by a power of two.
struct Dice(Stream);

impl Dice {
    /// Uniform in [0, 1).
    fn unit(&mut self) -> f32 {
        self.0.below(1 << 24) as f32 / 16_777_216.0
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Nearly normal: twelve uniform numbers less six.
    fn normal(&mut self) -> f32 {
        (0..12).fold(-6.0, |sum, _| sum + self.unit())
    }

    /// Uniform unit vector: Archimedes' cylinder.
    fn direction(&mut self) -> [f32; 3] {
        let (z, turn) = (self.between(-1.0, 1.0), self.between(0.0, core::f32::consts::TAU));
        let r = libm::sqrtf(1.0 - z * z);
        [r * libm::cosf(turn), r * libm::sinf(turn), z]
    }
}

/// An ellipsoid: centre, semi-axes, and a rotation of `turn` about a unit vector (Rodrigues).
struct Body {
    centre: [f32; 3],
    semi_axes: [f32; 3],
    about: [f32; 3],
    turn: f32,
}

impl Body {
    fn random(dice: &mut Dice, centre: [f32; 3], semi_axes: [f32; 3]) -> Self {
        Self { centre, semi_axes, about: dice.direction(), turn: dice.between(0.0, 3.0) }
    }

    /// A point of the surface with an error, on the side that faces the origin if asked for.
    fn point(&self, dice: &mut Dice, sigma: f32, facing: bool) -> Point3 {
        let unit = dice.direction();
        let v: [f32; 3] = core::array::from_fn(|k| unit[k] * self.semi_axes[k]);
        let (sin, cos, k) = (libm::sinf(self.turn), libm::cosf(self.turn), self.about);
        let along = (k[0] * v[0] + k[1] * v[1] + k[2] * v[2]) * (1.0 - cos);
        let cross = [k[1] * v[2] - k[2] * v[1], k[2] * v[0] - k[0] * v[2], k[0] * v[1] - k[1] * v[0]];
        let mut turned: [f32; 3] = core::array::from_fn(|i| v[i] * cos + cross[i] * sin + k[i] * along);
        if facing && turned[2] > 0.0 {
            // The antipode is a point of the surface too.
            turned = turned.map(|value| -value);
        }
        let [x, y, z] = core::array::from_fn(|i| self.centre[i] + turned[i] + sigma * dice.normal());
        Point3::new(x, y, z)
    }
}

/// A view of one or two fruit of about the given size, with clutter.
fn view(dice: &mut Dice, size: [f32; 3], fruit: usize, sigma: f32, clutter: usize) -> Vec<Point3> {
    let z = dice.between(500.0, 1300.0);
    let mut cloud = Vec::new();
    for k in 0..fruit {
        let centre = [dice.between(-200.0, 200.0), 3.0 * size[0] * k as f32, z];
        let semi_axes = size.map(|axis| axis * dice.between(0.95, 1.05));
        let body = Body::random(dice, centre, semi_axes);
        cloud.extend((0..150).map(|_| body.point(dice, sigma, true)));
    }
    let around = cloud[0];
    let reach = 2.0 * size[0];
    cloud.extend((0..clutter).map(|_| {
        let [x, y, z] = core::array::from_fn(|k| around[k] + dice.between(-reach, reach));
        Point3::new(x, y, z)
    }));
    cloud
}

/// The paper's simulation.
fn simulation(dice: &mut Dice) -> Vec<Point3> {
    let body = Body { centre: [1.0; 3], semi_axes: [1.0, 2.0, 3.0], about: [0.0, 0.0, 1.0], turn: 1.05 };
    let mut cloud: Vec<Point3> = (0..350).map(|_| body.point(dice, 0.05, false)).collect();
    cloud.extend(
        (0..150)
            .map(|_| Point3::new(dice.between(-3.0, 5.0), dice.between(-3.0, 5.0), dice.between(-3.0, 5.0))),
    );
    cloud
}

/// Points that determine little: a lattice, a thin sheet, a line with a speck of noise.
fn poor(dice: &mut Dice) -> Vec<Point3> {
    let kind = dice.0.below(3);
    let point = |dice: &mut Dice| match kind {
        0 => [0; 3].map(|_| 8.0 * dice.0.below(6) as f32),
        1 => [dice.between(-25.0, 25.0), dice.between(-25.0, 25.0), 700.0 + 0.5 * dice.normal()],
        _ => {
            let along = dice.between(-20.0, 20.0);
            [along, 0.5 * along + 0.01 * dice.normal(), 700.0 + 0.01 * dice.normal()]
        }
    };
    (0..200).map(|_| Point3::from(point(dice))).collect()
}

const JUJUBE: [f32; 3] = [22.0, 11.0, 11.0];

/// Name, searches, configuration, cloud.
type Family = (&'static str, u64, fn() -> Config, fn(&mut Dice) -> Vec<Point3>);

const FAMILIES: [Family; 10] = [
    ("jujube-clean", 40, || Config::jujube().paper(), |dice| view(dice, JUJUBE, 1, 0.0, 0)),
    ("jujube-noisy", 40, || Config::jujube().paper(), |dice| view(dice, JUJUBE, 1, 0.5, 40)),
    ("jujubes-trace", 30, trace, |dice| view(dice, JUJUBE, 3, 0.2, 60)),
    ("table5-cluttered", 20, Config::table5, |dice| view(dice, JUJUBE, 1, 1.0, 80)),
    ("apple", 20, || Config::apple().paper(), |dice| view(dice, [40.0, 38.0, 36.0], 1, 1.0, 20)),
    ("generic", 20, Config::generic, |dice| view(dice, [30.0, 22.0, 14.0], 2, 0.3, 30)),
    ("table2", 20, Config::table2, simulation),
    ("table2-wide", 40, Config::table2_wide, simulation),
    ("whole-cloud", 40, whole, simulation),
    ("poor", 40, || Config { max_trials: 300, ..Config::generic() }, poor),
];

fn trace() -> Config {
    Config {
        constraint: Constraint::Trace,
        min_ratio: 0.2,
        refits: 10,
        max_failures: 2,
        ..Config::jujube().paper()
    }
}

fn whole() -> Config {
    Config { radius: f32::INFINITY, refits: 10, constraint: Constraint::Trace, ..Config::table2() }
}

// ---- Digests ----

/// FNV-1a, 64 bits, over little-endian bytes.
struct Digest(u64);

impl Digest {
    const fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    fn bytes(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    fn integer(&mut self, value: u32) {
        self.bytes(&value.to_le_bytes());
    }

    /// The bits of an NaN differ between machines, so all of them count as one.
    fn floats(&mut self, values: &[f32]) {
        for value in values {
            self.integer(if value.is_nan() { 0x7fc0_0000 } else { value.to_bits() });
        }
    }

    fn report(&mut self, report: &VarsacReport) {
        let VarsacReport { trials, rejections, scored, bound, support } = *report;
        for value in
            [trials, scored, bound, support.inliers, support.candidates].into_iter().chain(rejections)
        {
            self.integer(value);
        }
    }

    fn detection(&mut self, detection: &Detection) {
        let e = &detection.ellipsoid;
        assert!(e.semi_axes.iter().all(|axis| axis.is_finite()), "{e:?}");
        self.bytes(&[detection.target]);
        self.floats(e.centre.coords.as_slice());
        self.floats(&e.semi_axes);
        self.floats(e.axes.as_flattened());
        self.floats(&e.quaternion_xyzw());
        self.floats(&e.attitude_rad());
        self.integer(detection.score.inliers);
        self.integer(detection.score.candidates);
        self.report(&detection.report);
    }
}

/// Digests what happens on the way.
struct Stages(Digest);

impl Observer for Stages {
    fn sample(&mut self, members: &[u16]) {
        for &member in members {
            self.0.integer(u32::from(member));
        }
    }

    fn solution(&mut self, x: &[f32; 9]) {
        self.0.floats(x);
    }

    fn quadric(&mut self, quadric: &Quadric) {
        let i = quadric.invariants();
        self.0.floats(&[i.i1, i.i2, i.i3, i.i4]);
    }

    fn hypothesis(&mut self, surface: &CentralQuadric) {
        let (c, s) = (&surface.centre, &surface.shape);
        self.0.floats(&[c.x, c.y, c.z, s.xx, s.yy, s.zz, s.xy, s.xz, s.yz]);
    }
}

/// One line of the file: all searches of a family.
fn line(&(name, searches, config, cloud): &Family) -> String {
    let detector = Detector::new(config()).unwrap();
    let mut workspace = Workspace::<1024>::new();
    let (mut results, mut stages) = (Digest::new(), Stages(Digest::new()));
    let mut targets = 0;
    for seed in 0..searches {
        let cloud = cloud(&mut Dice(Stream::new(1000 + seed)));
        let mut run = detector.detect(&cloud, workspace.scratch(), seed).unwrap();
        let finish = loop {
            match run.step_observed(&mut stages) {
                Step::Working => {}
                Step::Missed(report) => results.report(&report),
                Step::Found(detection) => {
                    targets += 1;
                    results.detection(&detection);
                }
                Step::Finished(finish) => break finish,
            }
        };
        let finish = match finish {
            Finish::FewPoints => 0,
            Finish::Targets => 1,
            Finish::Failures => 2,
        };
        results.integer(finish);
        results.bytes(run.labels());
    }
    format!("{name:<18} {searches:>4} {targets:>4} {:016x} {:016x}\n", results.0, stages.0.0)
}

#[test]
fn every_build_gives_the_same_bits() {
    let mut text = format!(
        "# Digests of whole searches, numeric contract version {CONTRACT_VERSION}.\n\
         # Made by core/tests/digest.rs (clouds from seeds 1000.., searches from seeds 0..); VARSAC_BLESS=1 rewrites it.\n\
         # FNV-1a, 64 bits: of all result bits; of samples, solutions, invariants and hypotheses of every trial.\n\
         # family, searches, targets found, results, stages\n"
    );
    text.extend(FAMILIES.iter().map(line));
    if std::env::var("VARSAC_BLESS").is_ok_and(|value| value == "1") {
        std::fs::write(VECTORS, &text).unwrap();
    }
    let expected = std::fs::read_to_string(VECTORS).unwrap();
    for (ours, golden) in text.lines().zip(expected.lines()) {
        assert_eq!(ours, golden, "the first line that differs from {VECTORS}");
    }
    assert_eq!(text, expected);
}
