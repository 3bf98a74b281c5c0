//! Views of the check for the search without a size prior, and clouds for the single fit, one function a family.

use super::cases::Dice;
use super::{scenes, views};
use crate::region_view::RegionView;
use varsac_core::mixture::{MixtureConfig, MixtureGate};
use varsac_core::{Config, Method, Noise, Point3, Vector3, Viewpoint};

/// Every body passes.
const OPEN: MixtureGate = MixtureGate {
    min_points: 0.0,
    gain: f32::NEG_INFINITY,
    coverage: 0.0,
    flat: 0.0,
    misfit: f32::INFINITY,
    uncertain: f32::INFINITY,
};

/// A configuration of the search without a size prior with every field at random within what finds something now and
/// then.
pub(super) fn any_config(dice: &mut Dice, preset: MixtureConfig) -> Config {
    let mut config = Config { mixture: preset, ..Config::surface() };
    vary(&mut config, dice);
    config
}

/// What may vary without spoiling a search of a recorded view.
pub(super) fn vary(config: &mut Config, dice: &mut Dice) {
    config.method = Method::Mixture;
    config.max_targets = dice.pick(&[1, 2, 4, 40]);
    config.max_failures = dice.pick(&[1, 1, 2, 3]);
    let any = dice.between(0.0, 1.0);
    let shut = shut(dice);
    let mixture = &mut config.mixture;
    mixture.noise =
        Noise { axial_mm: dice.pick(&[1.0, 0.3]), lateral_rad: dice.pick(&[0.001, 0.000_2, 0.05]) };
    mixture.sample = dice.pick(&[400, 200, 100, 50]);
    mixture.starts = dice.pick(&[10, 4, 4, 2, 0, 15]);
    mixture.area_weight = dice.pick(&[mixture.area_weight, 0.5, 0.0, any]);
    mixture.shape_spread = dice.pick(&[mixture.shape_spread, f32::INFINITY, 1.0, 0.1]);
    mixture.outline_offset_rad = dice.pick(&[0.000_4, 0.000_4, 1e-9, 0.01]);
    mixture.inflation = dice.pick(&[mixture.inflation, 1.0, any + 0.1]);
    mixture.inflation_thin = dice.pick(&[2.0, 2.0, 0.0]);
    mixture.inflation_outliers = dice.pick(&[0.0, 4.0]);
    mixture.gate = dice.pick(&[mixture.gate, mixture.gate, OPEN, shut]);
    mixture.gate.min_points = dice.pick(&[20.0, 20.0, 50.0, 0.0]);
}

/// One test that nothing passes, so that what it looks at is shown.
fn shut(dice: &mut Dice) -> MixtureGate {
    dice.pick(&[
        MixtureGate { flat: f32::INFINITY, ..OPEN },
        MixtureGate { gain: f32::INFINITY, ..OPEN },
        MixtureGate { coverage: 2.0, ..OPEN },
        MixtureGate { misfit: -1.0, ..OPEN },
        MixtureGate { uncertain: -1.0, ..OPEN },
    ])
}

/// Whole surfaces of one body or two, as a scanner has them, measured in any unit.
pub(super) fn whole(dice: &mut Dice) -> RegionView {
    let points = if dice.below(2) == 0 {
        scenes::surface(dice, &mut Config::table5())
    } else {
        let semi_axes = [dice.between(15.0, 40.0), dice.between(10.0, 30.0), dice.between(5.0, 20.0)];
        let far = dice.pick(&[0.0, 300.0]);
        scenes::surfaces(dice, semi_axes, Point3::new(0.0, 0.0, far))
    };
    let unit = dice.pick(&[1.0, 1.0, 1e-6, 1e-3, 1e3, 1e6]);
    let points: Vec<Point3> = points.into_iter().map(|p| p * unit).collect();
    let n = points.len();
    RegionView { in_mask: dice.pick(&[n, n, n / 2, 3]), points, ..RegionView::default() }
}

/// One view of bodies whose size nobody tells, with its outline or without.
pub(super) fn unknown(dice: &mut Dice) -> RegionView {
    if dice.below(4) == 0 {
        return RegionView::of_cloud(scenes::view(dice, &mut Config::table5(), 1));
    }
    views::one_sided(dice)
}

/// Views that make no sense, with a viewpoint and without.
pub(super) fn odd(dice: &mut Dice, config: &mut Config) -> RegionView {
    config.mixture.viewpoint = dice.pick(&[Viewpoint::Origin, Viewpoint::None]);
    views::hostile(dice, config)
}

/// Points for single fits: a surface or a part of one, with noise or without; a view; nothing that determines an ellipsoid.
pub(super) fn single(dice: &mut Dice) -> Vec<Point3> {
    let mut lengths = Config::table5();
    let mut points = match dice.below(6) {
        0 => scenes::view(dice, &mut lengths, 1),
        1 => scenes::degenerate(dice, &mut lengths),
        2 => scenes::scaled(dice, &mut lengths),
        3 => scenes::exact(dice, &mut lengths),
        _ => scenes::surface(dice, &mut lengths),
    };
    // What lies behind a plane through the first point is not seen.
    if let (0, Some(&first)) = (dice.below(3), points.first()) {
        let normal = Vector3::new(dice.normal(), dice.normal(), dice.normal());
        points.retain(|p| (p - first).dot(&normal) <= 0.0);
    }
    points
}
