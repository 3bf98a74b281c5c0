//! What must not change the answer: turning, shifting and scaling the cloud, points far away, the buffers' history, the
//! way the run is driven. And what may change it in one direction only: a thicker shell, a better inlier ratio.

use nalgebra::{Matrix3, Vector3};
use proptest::{
    prelude::*,
    test_runner::{Config as Cases, RngSeed},
};
use varsac_core::{
    CentralQuadric, Config, Constraint, Detection, Detector, Observer, Point3, Step, Workspace, fit::fit,
    kdtree, point::distance_squared, tebc::Shell, trials::trials,
};
use varsac_tests::{
    body::{Body, narrow, wide},
    random::Dice,
    scene::{Trouble, View},
    simulation,
    statistics::Sample,
    tolerance as limit,
};

/// Every detection of a run, and the labels it leaves.
fn detect(config: &Config, cloud: &[Point3], seed: u64) -> (Vec<Detection>, Vec<u8>) {
    let detector = Detector::new(config.clone()).unwrap();
    let mut workspace = Workspace::<2048>::new();
    let mut run = detector.detect(cloud, workspace.scratch(), seed).unwrap();
    let found = run.by_ref().collect();
    (found, run.labels().to_vec())
}

fn noisy_view(test: &str, case: u64, axial_noise_mm: f64) -> View {
    View::jujube(&mut Dice::new(test, case), &Trouble { axial_noise_mm, ..Trouble::default() })
}

/// The fit of all points of a cloud.
fn fit_all(cloud: &[Point3], constraint: Constraint) -> Option<CentralQuadric> {
    let all: Vec<u16> = (0..cloud.len() as u16).collect();
    fit(cloud, &all, constraint).ok()
}

fn mapped(cloud: &[Point3], map: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Vec<Point3> {
    cloud.iter().map(|p| narrow(&map(wide(p)))).collect()
}

/// How far the centre of the mapped cloud's fit is from the mapped centre, over many views where both are ellipsoids.
fn centre_moves(
    noise_mm: f64,
    constraint: Constraint,
    map: impl Fn(&mut Dice) -> Box<dyn Fn(Vector3<f64>) -> Vector3<f64>>,
) -> Sample {
    let mut off = Sample::default();
    for case in 0..400 {
        let view = noisy_view("moved views", case, noise_mm);
        let map = map(&mut Dice::new("moves", case));
        let moved = mapped(&view.cloud, &map);
        if let (Some(before), Some(after)) = (fit_all(&view.cloud, constraint), fit_all(&moved, constraint)) {
            off.push((wide(&after.centre) - map(wide(&before.centre))).norm());
        }
    }
    assert!(off.len() > 50, "only {} views gave an ellipsoid", off.len());
    off
}

#[test]
fn a_turned_cloud_has_its_fruit_turned() {
    let turn = |dice: &mut Dice| -> Box<dyn Fn(Vector3<f64>) -> Vector3<f64>> {
        let r: Matrix3<f64> = dice.rotation();
        Box::new(move |p| r * p)
    };
    let trace = centre_moves(0.5, Constraint::Trace, turn);
    let a11 = centre_moves(0.5, Constraint::A11, turn);
    println!(
        "turned views, noise 0.5 mm: centre moves, trace {} mm; a11 = 1 {} mm",
        trace.summary(),
        a11.summary()
    );
    limit::ROTATED_TRACE.check(trace.quantile(0.99));
    limit::ROTATED_A11.check(a11.quantile(0.5));
}

#[test]
fn a_shifted_cloud_has_its_fruit_shifted() {
    for constraint in [Constraint::A11, Constraint::Trace] {
        let off = centre_moves(0.3, constraint, |dice| {
            let shift = dice.in_cube(1000.0);
            Box::new(move |p| p + shift)
        });
        limit::SHIFTED.check_for(&format!("{constraint:?}"), off.quantile(0.99));
    }
}

#[test]
fn a_shift_that_rounds_nothing_changes_no_bit_of_the_shape() {
    // Coordinates are multiples of 1/64 mm and the count is a power of two, so sums, means and differences are exact.
    for case in 0..200 {
        let mut dice = Dice::new("exact shift", case);
        let body = Body::jujube(&mut dice, Vector3::zeros());
        let on_grid = |p: Vector3<f64>| p.map(|v| libm::round(64.0 * v) / 64.0);
        let cloud: Vec<Point3> = (0..64).map(|_| narrow(&on_grid(body.surface_point(&mut dice)))).collect();
        let shift = on_grid(dice.in_cube(900.0));
        let moved = mapped(&cloud, |p| p + shift);
        let before = fit_all(&cloud, Constraint::A11).unwrap();
        let after = fit_all(&moved, Constraint::A11).unwrap();
        assert_eq!(before.shape, after.shape, "case {case}");
        let off = (wide(&after.centre) - wide(&before.centre) - shift).amax();
        assert!(off <= 6.2e-5, "case {case}: one rounding of a coordinate below 1024 mm, not {off}");
    }
}

#[test]
fn a_power_of_two_scales_every_bit() {
    // Factors for which no product of three entries of a shape matrix (about 1e-7 here, times factor^-6) leaves the
    // normal range of f32.
    for exponent in [-16, -10, -1, 1, 7, 12] {
        let factor = libm::exp2f(exponent as f32);
        for case in 0..40 {
            let mut dice = Dice::new("powers of two", case);
            let trouble = Trouble { axial_noise_mm: 0.8, outlier_share: 0.2, ..Trouble::default() };
            let view = View::jujube(&mut dice, &trouble);
            let scaled: Vec<Point3> = view.cloud.iter().map(|p| p * factor).collect();
            let config = Config { max_targets: 1, ..Config::jujube().paper() };
            let large = Config {
                radius: config.radius * factor,
                semi_axis_min: config.semi_axis_min * factor,
                semi_axis_max: config.semi_axis_max * factor,
                ..config.clone()
            };
            let (mut expected, labels) = detect(&config, &view.cloud, case);
            for detection in &mut expected {
                detection.ellipsoid.centre *= factor;
                detection.ellipsoid.semi_axes = detection.ellipsoid.semi_axes.map(|axis| axis * factor);
            }
            assert_eq!(detect(&large, &scaled, case), (expected, labels), "2^{exponent}, case {case}");
        }
    }
}

#[test]
fn a_fit_scales_by_any_power_of_two() {
    // Fourth powers of these lengths lie far outside the range of f32: the scale of the local frame keeps them in it.
    for exponent in [-60, -40, 19] {
        let factor = libm::exp2f(exponent as f32);
        let square = 1.0 / (factor * factor);
        for case in 0..40 {
            let cloud = noisy_view("fits of any size", case, 0.2).cloud;
            let scaled: Vec<Point3> = cloud.iter().map(|p| p * factor).collect();
            let expected = fit_all(&cloud, Constraint::Trace).map(|surface| {
                let s = surface.shape;
                [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz].map(|value| value * square)
            });
            let shape = fit_all(&scaled, Constraint::Trace).map(|surface| {
                let s = surface.shape;
                [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz]
            });
            assert_eq!(shape, expected, "2^{exponent}, case {case}");
        }
    }
}

#[test]
fn another_factor_scales_the_answer() {
    for factor in [0.001, 0.3, 3.0, 1000.0] {
        for constraint in [Constraint::A11, Constraint::Trace] {
            let off = centre_moves(0.3, constraint, |_| Box::new(move |p| p * factor));
            limit::STRETCHED.check_for(&format!("{factor} {constraint:?}"), off.quantile(0.99) / factor);
        }
    }
}

#[test]
fn lone_points_far_away_may_stand_anywhere_in_any_order() {
    // A seed point among them has no neighbours and takes one draw whichever it is, so not a bit may change.
    for case in 0..100 {
        let mut dice = Dice::new("far points", case);
        let view = View::jujube(&mut dice, &Trouble { axial_noise_mm: 0.5, ..Trouble::default() });
        let far = |k: usize, start: f32| Point3::new(start + 100.0 * k as f32, -5000.0, 2000.0);
        let mut cloud = view.cloud.clone();
        cloud.extend((0..60).map(|k| far(k, 0.0)));
        let (expected, labels) = detect(&Config::jujube().paper(), &cloud, case);
        assert!(!expected.is_empty());

        let mut elsewhere = view.cloud.clone();
        elsewhere.extend(dice.sample(60, 60).into_iter().map(|k| far(usize::from(k), -40_000.0)));
        assert_eq!(detect(&Config::jujube().paper(), &elsewhere, case), (expected, labels), "case {case}");
    }
}

#[test]
fn points_outside_the_list_do_not_touch_a_fit() {
    let mut dice = Dice::new("outside the list", 0);
    let mut cloud = noisy_view("outside the list", 1, 0.3).cloud;
    let sample = dice.sample(cloud.len(), 20);
    let before = fit(&cloud, &sample, Constraint::Trace);
    for (index, point) in cloud.iter_mut().enumerate() {
        if !sample.contains(&(index as u16)) {
            *point = narrow(&dice.in_cube(1e6));
        }
    }
    assert_eq!(fit(&cloud, &sample, Constraint::Trace), before);
}

#[test]
fn the_same_seed_gives_the_same_bits_however_the_run_is_driven() {
    struct Watching;
    impl Observer for Watching {}
    for case in 0..30 {
        let mut dice = Dice::new("same seed", case);
        let cloud = simulation::cloud(&mut dice, 400, 0.05, 0.3);
        let config = Config::table2_wide();
        let expected = detect(&config, &cloud, case);

        // A larger workspace, full of what another run left there; one step at a time, observed.
        let detector = Detector::new(config).unwrap();
        let mut workspace = Workspace::<4096>::new();
        let other = simulation::cloud(&mut dice, 4000, 0.1, 0.5);
        detector.detect(&other, workspace.scratch(), 99).unwrap().next();
        let mut run = detector.detect(&cloud, workspace.scratch(), case).unwrap();
        let mut found = Vec::new();
        loop {
            match run.step_observed(&mut Watching) {
                Step::Found(detection) => found.push(detection),
                Step::Finished(_) => break,
                Step::Working | Step::Missed(_) => {}
            }
        }
        assert_eq!((found, run.labels().to_vec()), expected, "case {case}");
    }
}

/// How far the centres that other seeds find are from that of seed 0, over thirty clouds.
fn centres_of_seeds(config: &Config, cloud: impl Fn(u64) -> Vec<Point3>) -> Sample {
    let mut apart = Sample::default();
    for case in 0..30 {
        let cloud = cloud(case);
        let first = |seed| wide(&detect(config, &cloud, seed).0[0].ellipsoid.centre);
        let reference = first(0);
        for seed in 1..20 {
            apart.push((first(seed) - reference).norm());
        }
    }
    println!("centres of other seeds apart: {}", apart.summary());
    apart
}

#[test]
fn other_seeds_give_similar_answers() {
    let views = |noise_mm| move |case| noisy_view("other seeds", case, noise_mm).cloud;
    let clean = centres_of_seeds(&Config::jujube().paper(), views(0.0));
    limit::OTHER_SEED_CLEAN.check(clean.max());
    let noisy = centres_of_seeds(&Config::jujube().paper(), views(0.3));
    limit::OTHER_SEED_NOISY.check(noisy.quantile(0.5));
    let whole = Config { refits: 10, ..Config::table2_wide() };
    let whole = centres_of_seeds(&whole, |case| {
        simulation::cloud(&mut Dice::new("other seeds", case), 500, 0.05, 0.3)
    });
    limit::OTHER_SEED_WHOLE.check(whole.quantile(0.9));
}

/// Seeded, so that a run can be repeated; PROPTEST_RNG_SEED goes elsewhere.
fn cases(cases: u32) -> Cases {
    let default = Cases::default();
    let rng_seed = match default.rng_seed {
        RngSeed::Random => RngSeed::Fixed(3),
        chosen @ RngSeed::Fixed(_) => chosen,
    };
    Cases { cases, rng_seed, failure_persistence: None, ..default }
}

proptest! {
    #![proptest_config(cases(2000))]

    #[test]
    fn a_thicker_shell_loses_no_inlier(
        seed in any::<u64>(), thin in 1e-6_f32..0.98, more in prop_oneof![Just(0.0_f32), 1e-7_f32..1e-5, 1e-5_f32..1.0],
    ) {
        let thick = (thin + more).min(0.999);
        let mut dice = Dice::new("shells", seed);
        let view_point = Vector3::new(dice.between(-300.0, 300.0), dice.between(-300.0, 300.0), 800.0);
        let body = Body::jujube(&mut dice, view_point);
        let cloud = simulation::surface(&mut dice, &body, 30, 1.0);
        let Some(surface) = fit_all(&cloud, Constraint::Trace) else { return Ok(()) };
        let (inner, outer) = (Shell::new(&surface, thin), Shell::new(&surface, thick));
        for _ in 0..50 {
            // Around the rim of the thin shell, where a wrong rounding would show.
            let rim = 1.0 + f64::from(thin) * if dice.unit() < 0.5 { 1.0 } else { -1.0 };
            let point = narrow(&body.scaled(rim * (1.0 + 1e-6 * dice.normal())).surface_point(&mut dice));
            prop_assert!(!inner.contains(&point) || outer.contains(&point));
        }
    }

    #[test]
    fn trials_fall_with_the_ratio_and_rise_with_the_confidence(
        ratios in (0.0_f32..=1.0, 0.0_f32..=1.0), confidences in (1e-6_f32..0.999_999, 1e-6_f32..0.999_999),
        sizes in prop::collection::vec(9_u8..=32, 1..=16),
    ) {
        let (low, high) = (ratios.0.min(ratios.1), ratios.0.max(ratios.1));
        let (loose, strict) = (confidences.0.min(confidences.1), confidences.0.max(confidences.1));
        prop_assert!(trials(loose, &sizes, high, 3000) <= trials(loose, &sizes, low, 3000));
        prop_assert!(trials(loose, &sizes, low, 3000) <= trials(strict, &sizes, low, 3000));
        let larger: Vec<u8> = sizes.iter().map(|size| size + 1).collect();
        prop_assert!(trials(loose, &sizes, low, 3000) <= trials(loose, &larger, low, 3000));
    }

    #[test]
    fn neighbours_do_not_depend_on_how_the_tree_grew(
        seed in any::<u64>(), count in 1_usize..200, radius in 0.0_f32..12.0,
    ) {
        // A coarse lattice: many equal coordinates and many distances exactly at the radius.
        let mut dice = Dice::new("trees", seed);
        let cloud: Vec<Point3> = (0..count)
            .map(|_| Point3::new(dice.below(9) as f32, dice.below(9) as f32, dice.below(9) as f32))
            .collect();
        let centre = cloud[dice.below(count)];
        let radius = if dice.unit() < 0.5 { radius } else { radius.floor() };
        let expected: Vec<u16> = (0..count as u16)
            .filter(|&k| distance_squared(&cloud[usize::from(k)], &centre) <= radius * radius)
            .collect();
        for _ in 0..2 {
            let mut order = dice.sample(count, count);
            kdtree::build(&cloud, &mut order);
            let mut members = vec![0; count];
            let found = kdtree::within(&cloud, &order, &centre, radius, &mut members).unwrap();
            prop_assert_eq!(&members[..found], &expected[..]);
        }
    }
}

#[test]
fn neighbouring_ratios_never_need_more_trials() {
    // Every f32 next to the ones where log1p and the product round differently.
    for start in [0.3_f32, 0.5, 0.75, 0.774, 0.9, 0.99, 0.999] {
        let mut last = u32::MAX;
        for step in 0..20_000 {
            let k = trials(0.95, &[9, 10, 11, 12], f32::from_bits(start.to_bits() + step), 1_000_000);
            assert!(k <= last, "ratio {start} + {step} ulps: {k} after {last}");
            last = k;
        }
    }
}
