//! Views of the check for the default search, one function a family. Each one sets the configuration to suit its view.

use super::cases::Dice;
use super::scenes;
use crate::{
    region_view::RegionView,
    synth::onesided::{
        MaskBias, Scene, Sighting, Subject, boxy_jujube,
        families::{CLEAN, Family, HARD, OCCLUDED, ORCHARD, TOUCHING, TOUCHING_LEAVES},
        scaled_jujube,
    },
};
use varsac_core::{Config, Gate, MapConfig, Method, Noise, OutlineRay, Point3, SizePrior, Viewpoint};

/// A configuration of the default search with every field at random within what finds something now and then.
pub(super) fn any_config(dice: &mut Dice) -> Config {
    let mut config = Config { method: Method::Map, ..Config::jujube() };
    vary(&mut config, dice);
    let (ab, bc) = (dice.pick(&[f32::INFINITY, 0.05, 0.5]), dice.pick(&[f32::INFINITY, 0.08, 0.08, 0.3]));
    let prior = SizePrior::of([21.75, 10.9, 10.9], dice.between(0.02, 0.2), ab, bc);
    config.map.prior = dice.pick(&[SizePrior::JUJUBE, SizePrior::JUJUBE, prior]);
    config.map.noise = Noise {
        axial_mm: dice.pick(&[1.0, 1.0, 0.4, 3.0]),
        lateral_rad: dice.pick(&[0.001, 0.001, 0.000_2, 0.004]),
    };
    config.map.boxiness = dice.pick(&[0.0, 0.08, 0.08, 0.3, 1.0]);
    config
}

/// What may vary without spoiling a search of a recorded view.
pub(super) fn vary(config: &mut Config, dice: &mut Dice) {
    config.max_targets = dice.pick(&[1, 2, 4, 6, 40]);
    config.max_failures = dice.pick(&[1, 1, 2, 3]);
    let any = dice.between(0.05, 1.0);
    let map = &mut config.map;
    map.independence = dice.pick(&[1.0, 1.0, 0.25, any]);
    map.outline_offset_rad = dice.pick(&[0.000_4, 0.000_4, 1e-9, 0.01]);
    map.hypotheses = dice.pick(&[24, 12, 6, 40]);
    map.hypothesis_steps = dice.pick(&[3, 3, 1, 0, 6]);
    map.kept = dice.pick(&[4, 4, 1, 2, 8]);
    map.refine_steps = dice.pick(&[8, 8, 1, 3]);
    map.final_steps = dice.pick(&[5, 5, 1, 2, 12]);
    map.inflation.per_conflict = dice.pick(&[0.2, 0.0, 1.0]);
    map.inflation.per_clutter = dice.pick(&[5.0, 5.0, 0.0]);
    map.gate = dice.pick(&[Gate::BALANCED, Gate::STRICT, Gate::EAGER, Gate::EAGER]);
    map.gate.min_points = dice.pick(&[20, 12, 40, 1]);
}

/// One fruit, or what is taken for one, behind leaves or not, with its surroundings and outline.
pub(super) fn one_sided(dice: &mut Dice) -> RegionView {
    let balls = HARD.decoy("balls", Subject::Ball(8.0, 30.0));
    let discs = HARD.decoy("discs", Subject::Disc);
    let other = ORCHARD.of("other size", scaled_jujube(f64::from(dice.between(0.7, 1.3))));
    let boxy = CLEAN.of("boxy", boxy_jujube(2.5));
    let families = [CLEAN, HARD, HARD, OCCLUDED, ORCHARD, ORCHARD, balls, discs, other, boxy];
    rendered(&dice.pick(&families), dice)
}

/// Two to four fruit that touch.
pub(super) fn cluster(dice: &mut Dice, config: &mut Config) -> RegionView {
    config.max_targets = dice.pick(&[4, 6, 40, 2]);
    let family = dice.pick(&[TOUCHING, TOUCHING, TOUCHING_LEAVES]);
    rendered(&family, dice)
}

/// A scene of the family as the core gets to see it: mask, surroundings, outline, pitch.
fn rendered(family: &Family, dice: &mut Dice) -> RegionView {
    let scene = Scene::new(family, dice.word64());
    let shift_px = [i64::from(dice.below(3)) - 1, 0];
    let Sighting { cloud, in_mask, outline, pitch_rad } =
        scene.sighting(MaskBias { grow_px: dice.pick(&[0, 0, 0, 1, -1]), shift_px });
    let every = dice.pick(&[1, 3, usize::MAX]);
    RegionView {
        points: cloud,
        in_mask,
        outline: outline.into_iter().step_by(every).collect(),
        pitch_rad: pitch_rad * dice.pick(&[1.0, 1.0, 1.0, 0.0]),
    }
}

/// A scan from all around: the whole surface of one or two fruit and stray points, and no viewpoint.
pub(super) fn all_around(dice: &mut Dice, config: &mut Config) -> RegionView {
    config.map.viewpoint = Viewpoint::None;
    let axes = [dice.between(19.0, 24.0), dice.between(10.0, 12.0), dice.between(9.5, 11.5)];
    let far = dice.pick(&[0.0, 300.0]);
    let points = scenes::surfaces(dice, axes, Point3::new(5.0, -20.0, far));
    let in_mask = points.len() * dice.pick(&[4, 4, 3]) / 4;
    // Without a viewpoint a ray means nothing: the search must not look at it.
    let outline = vec![OutlineRay { inner: Point3::new(25.0, 0.0, far), outer_mm: 900.0, sigma_rad: 0.001 }];
    RegionView { points, in_mask, outline, pitch_rad: 0.003 }
}

/// Numbers that a careless host might send.
const ODD: [f32; 10] =
    [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 0.0, -0.0, -1.0, 1e-40, 1e-20, 1e20, 3e38];

/// Clouds that were not made for this search, beside or around the origin, of any scale; masks, rays and pitches that
/// make no sense.
pub(super) fn hostile(dice: &mut Dice, config: &mut Config) -> RegionView {
    // The families of the paper's search set lengths of their own.
    let mut lengths = Config::table5();
    let points = match dice.below(5) {
        0 => scenes::grid(dice, &mut lengths),
        1 => scenes::degenerate(dice, &mut lengths),
        2 => scenes::scaled(dice, &mut lengths),
        3 => scenes::surface(dice, &mut lengths),
        _ => scenes::view(dice, &mut lengths, 1),
    };
    let long = lengths.semi_axis_max.clamp(1e-6, 1e6);
    let short = (lengths.semi_axis_min * dice.pick(&[1.0, 1.5])).clamp(1e-6, long);
    let spread = dice.pick(&[0.05, 0.001, 0.5, 5.0]);
    let gate = config.map.gate;
    config.map = MapConfig {
        prior: SizePrior::of([long, dice.pick(&[long, short]), short], spread, f32::INFINITY, spread),
        noise: Noise {
            axial_mm: long * dice.pick(&[0.05, 1e-6, 10.0]),
            lateral_rad: dice.pick(&[0.001, 1e-9, 1.0]),
        },
        viewpoint: dice.pick(&[Viewpoint::Origin, Viewpoint::Origin, Viewpoint::None]),
        gate: dice.pick(&[gate, Gate { min_points: 1, ..gate }]),
        ..config.map
    };
    config.map.boxiness = dice.pick(&[0.0, 1e-6, 0.08, 1.0]);
    let rays = dice.pick(&[0, 1, 20, 20, 60, 4097]);
    let outline = (0..rays).map(|_| odd_ray(dice, &points, long)).collect();
    let n = points.len();
    let in_mask = dice.pick(&[n, n, n, n / 2, 7, 0, usize::MAX]);
    RegionView { points, in_mask, outline, pitch_rad: dice.pick(&ODD) }
}

/// A ray near the cloud, or one with a number in it that makes no sense.
fn odd_ray(dice: &mut Dice, points: &[Point3], long: f32) -> OutlineRay {
    let at =
        if points.is_empty() { Point3::origin() } else { points[dice.below(points.len() as u32) as usize] };
    let mut ray = OutlineRay {
        inner: at,
        outer_mm: dice.pick(&[f32::INFINITY, at.z + 5.0 * long, at.z]),
        sigma_rad: dice.pick(&[0.001, 0.01]),
    };
    match dice.below(12) {
        0 => ray.inner.x = dice.pick(&ODD),
        1 => ray.inner.z = dice.pick(&ODD),
        2 => ray.outer_mm = dice.pick(&ODD),
        3 => ray.sigma_rad = dice.pick(&ODD),
        _ => {}
    }
    ray
}
