//! Single stages on inputs made for their ties and edges, where a whole search would hardly ever go: points exactly on
//! a bound of the shell, semi-axes exactly at a limit, draws that must be redrawn, shapes that are nearly diagonal.

use super::cases::{Case, Dice};
use super::core_side::CoreObserver;
use super::record::{Recorder, Stage};
use super::{convert, reference_side};
use varsac_core::jacobi::Symmetric3;
use varsac_core::{CentralQuadric, Constraint, Method, Point3, fit, rng, tebc::Shell, trials};
use varsac_reference as reference;

/// The inputs of all single stages in one case.
struct Parts {
    /// Bounds for `below`, population and size for `sample`.
    bounds: Vec<u32>,
    samples: Vec<(u32, u32)>,
    /// A cloud, lists of its points, and how to fit them.
    cloud: Vec<Point3>,
    lists: Vec<(Vec<u16>, Constraint)>,
    /// Shapes to decompose.
    shapes: Vec<CentralQuadric>,
    /// Shapes with limits of their semi-axes.
    sizes: Vec<(CentralQuadric, [f32; 2])>,
    /// Surfaces with the half-width of their shell and a point.
    shells: Vec<(CentralQuadric, f32, Point3)>,
    /// Confidence, sample sizes, ratio and maximum.
    bounds_on_trials: Vec<(f32, Vec<u8>, f32, u32)>,
}

impl Parts {
    fn generate(case: &Case) -> Self {
        let dice = &mut Dice::new(case.seed, 0);
        Self {
            bounds: (0..40).map(|_| dice.word() >> dice.below(33).min(31)).collect(),
            samples: (0..6).map(|_| (dice.below(40), 9 + dice.below(24))).collect(),
            cloud: cloud(dice),
            lists: (0..8).map(|_| list(dice)).collect(),
            shapes: (0..12).map(|_| surface(dice)).collect(),
            sizes: (0..12).map(|_| (round_surface(dice), [1.0, dice.pick(&[2.0, 4.0, 8.0])])).collect(),
            shells: (0..40).map(|_| shell(dice)).collect(),
            bounds_on_trials: (0..12).map(|_| bound(dice)).collect(),
        }
    }
}

/// Sixty points: on a coarse grid or not, here or far away.
fn cloud(dice: &mut Dice) -> Vec<Point3> {
    let (grid, far) = (dice.below(2) == 0, dice.pick(&[0.0, 1000.0, 1e8]));
    let coordinate = |dice: &mut Dice| {
        let value = dice.between(-20.0, 20.0);
        far + if grid { libm::roundf(value) } else { value }
    };
    (0..60).map(|_| Point3::new(coordinate(dice), coordinate(dice), coordinate(dice))).collect()
}

/// A list of 8 to 40 of the points in any order, some of them more than once.
fn list(dice: &mut Dice) -> (Vec<u16>, Constraint) {
    let members = (0..8 + dice.below(33)).map(|_| dice.below(60) as u16).collect();
    (members, dice.pick(&[Constraint::A11, Constraint::Trace]))
}

/// A surface with any symmetric shape: diagonal, nearly diagonal, of rank one, or full.
fn surface(dice: &mut Dice) -> CentralQuadric {
    let magnitude = dice.pick(&[1.0, 1e-3, 1e-12, 1e12, 1e-37]);
    let off = dice.pick(&[0.0, 1e-8, 1e-4, 1.0, 30.0]);
    let kind = dice.below(5);
    let mut entry = |size: f32| magnitude * size * dice.between(-1.0, 1.0);
    let centre = Point3::new(entry(9.0), entry(9.0), entry(9.0));
    let [xy, xz, yz] = [entry(off), entry(off), entry(off)];
    let mut diagonal = || libm::fabsf(entry(4.0));
    let mut shape = Symmetric3 { xx: diagonal(), yy: diagonal(), zz: diagonal(), xy, xz, yz };
    match kind {
        0 => shape.yy = shape.xx,
        1 => (shape.yy, shape.zz) = (shape.xx, shape.xx),
        2 => (shape.yy, shape.zz, shape.xy, shape.xz, shape.yz) = (shape.xx, shape.xx, shape.xx, 0.0, 0.0),
        _ => {}
    }
    CentralQuadric { centre, shape }
}

/// A surface whose semi-axes and centre are small powers of two or integers: everything about it is exact in `f32`.
fn round_surface(dice: &mut Dice) -> CentralQuadric {
    let mut entry = || dice.pick(&[1.0, 0.25, 0.0625, 0.015_625]);
    let shape = Symmetric3 { xx: entry(), yy: entry(), zz: entry(), ..Symmetric3::default() };
    let mut integer = || dice.below(9) as f32 - 4.0;
    CentralQuadric { centre: Point3::new(integer(), integer(), integer()), shape }
}

/// A point on an axis of a round surface, as a rule exactly on the inner or the outer bound of its shell.
fn shell(dice: &mut Dice) -> (CentralQuadric, f32, Point3) {
    let surface = round_surface(dice);
    let d = dice.pick(&[0.125, 0.25, 0.5, 0.75]);
    let times = dice.pick(&[1.0 - d, 1.0 + d, 1.0 + d, 1.0, 1.0 + d + 2e-7]);
    let s = &surface.shape;
    let mut point = surface.centre;
    match dice.below(3) {
        0 => point.x += times / libm::sqrtf(s.xx),
        1 => point.y -= times / libm::sqrtf(s.yy),
        _ => point.z += times / libm::sqrtf(s.zz),
    }
    (surface, d, point)
}

fn bound(dice: &mut Dice) -> (f32, Vec<u8>, f32, u32) {
    let first = 1 + dice.below(30) as u8;
    let sizes = (first..first + dice.below(5) as u8).collect();
    let (any, high) = (dice.between(0.0, 1.0), dice.between(0.9, 1.0));
    let ratio = dice.pick(&[0.0, 1.0, 0.999_95, 1e-5, any, high]);
    (
        dice.pick(&[0.95, 0.98, 1e-7, 0.999_999_9]),
        sizes,
        ratio,
        dice.pick(&[1, 10, 3000, 1_000_000, u32::MAX]),
    )
}

/// The single stages of the core.
pub(crate) fn core(case: &Case, recorder: &mut Recorder) {
    let parts = Parts::generate(case);
    let mut stream = rng::Stream::new(case.seed);
    recorder.integers(Stage::Draws, "below", parts.bounds.iter().map(|&bound| stream.below(bound)));
    for &(population, size) in &parts.samples {
        let mut sample = vec![0; size as usize];
        let members = if stream.sample(population, &mut sample) { sample } else { Vec::new() };
        recorder.integers(Stage::Draws, "sample", members.into_iter().map(u32::from));
    }
    let mut observer = CoreObserver { recorder, limits: [1.0, 50.0], method: Method::Varsac };
    for (list, constraint) in &parts.lists {
        // What a fit comes to is among its records.
        let _ = fit::fit_observed(&parts.cloud, list, *constraint, &mut observer);
    }
    for surface in &parts.shapes {
        observer.shape(surface);
    }
    let sizes = parts.sizes.iter().map(|(surface, [min, max])| surface.semi_axes_within(*min, *max));
    recorder.integers(Stage::Size, "sizes accepted", sizes.map(u32::from));
    let inside = parts.shells.iter().map(|(surface, d, p)| Shell::new(surface, *d).contains(p));
    recorder.integers(Stage::Score, "inside", inside.map(u32::from));
    let bounds =
        parts.bounds_on_trials.iter().map(|(p, sizes, ratio, max)| trials::trials(*p, sizes, *ratio, *max));
    recorder.integers(Stage::Bound, "bounds", bounds);
}

/// The same stages of the reference.
pub(crate) fn reference(case: &Case, recorder: &mut Recorder) {
    let parts = Parts::generate(case);
    let mut stream = reference::Stream::seeded(case.seed);
    recorder.integers(Stage::Draws, "below", parts.bounds.iter().map(|&bound| stream.below(bound)));
    for &(population, size) in &parts.samples {
        recorder.integers(Stage::Draws, "sample", stream.sample(population, size).unwrap_or_default());
    }
    let cloud = convert::points(&parts.cloud);
    for (list, constraint) in &parts.lists {
        let constraint = convert::constraint(*constraint);
        // What a fit comes to is among its records.
        let _ = reference::fit_observed(&cloud, list, constraint, &mut |event| {
            reference_side::record_event(recorder, [1.0, 50.0], &event);
        });
    }
    for surface in &parts.shapes {
        reference_side::shape(recorder, &convert::central(surface));
    }
    let sizes = parts
        .sizes
        .iter()
        .map(|(surface, [min, max])| reference::size_accepted(&convert::central(surface).shape, *min, *max));
    recorder.integers(Stage::Size, "sizes accepted", sizes.map(u32::from));
    let inside = parts
        .shells
        .iter()
        .map(|(surface, d, p)| reference::shell_contains(&convert::central(surface), *d, [p.x, p.y, p.z]));
    recorder.integers(Stage::Score, "inside", inside.map(u32::from));
    let bounds = parts
        .bounds_on_trials
        .iter()
        .map(|(p, sizes, ratio, max)| reference::trials(*p, sizes, *ratio, *max));
    recorder.integers(Stage::Bound, "bounds", bounds);
}
