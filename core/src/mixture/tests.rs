use super::*;
use crate::{Config, Detector, Point3, Status, Workspace};

/// Uniform draws from -1 to 1.
fn draws(seed: u64) -> impl FnMut() -> f32 {
    let mut stream = Stream::new(seed);
    move || stream.below(20_001) as f32 / 10_000.0 - 1.0
}

/// 600 points: two thirds on an ellipsoid 3, 2, 1 at (10, -20, 5), the others uniform around it; times `scale`.
fn cloud(scale: f32) -> [Point3; 600] {
    let mut draw = draws(11);
    core::array::from_fn(|k| {
        let v = [draw(), draw(), draw()];
        let n = if k % 3 == 0 { 0.6 } else { libm::sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) };
        let mut at = |k: usize, a: f32| a * v[k] / n + 0.02 * draw();
        Point3::new(scale * (10.0 + at(0, 3.0)), scale * (at(1, 2.0) - 20.0), scale * (5.0 + at(2, 1.0)))
    })
}

/// Runs one search; the result, and how many steps it took.
fn search(cloud: &[Point3], seed: u64) -> (MixtureProgress, u32) {
    let mut workspace = Workspace::<1024>::new();
    let mut scratch = workspace.scratch();
    scratch.reset(cloud.len());
    let (mut search, mut stream) = (MixtureSearch::new(), Stream::new(seed));
    let mut steps = 0;
    loop {
        steps += 1;
        match search.step(&MixtureConfig::SURFACE, &View::from(cloud), &mut scratch, &mut stream) {
            MixtureProgress::Working => {}
            result => return (result, steps),
        }
    }
}

#[test]
fn a_body_among_strays_is_found_in_any_unit_and_in_bounded_steps() {
    for scale in [1e-3, 1.0, 1e6] {
        let (MixtureProgress::Found(found), steps) = search(&cloud(scale), 1) else {
            panic!("nothing found")
        };
        assert_eq!(found.refusal, None, "{found:?}");
        for (value, expected) in found.ellipsoid.semi_axes.iter().zip([3.0, 2.0, 1.0]) {
            assert!((value / scale - expected).abs() < 0.02, "{found:?}");
        }
        assert!((found.ellipsoid.centre.y / scale + 20.0).abs() < 0.02);
        let sigma = found.covariance.unwrap().sigma_centre_max_mm() / scale;
        assert!((0.0005..0.01).contains(&sigma), "{sigma}");
        let starts = 1 + u32::from(MixtureConfig::SURFACE.starts);
        let most = starts * u32::from(MAX_START_STEPS)
            + KEPT as u32 * (u32::from(POLISH_STEPS) + 1)
            + u32::from(FINAL_STEPS)
            + 3;
        assert!(steps <= most, "{steps} of {most}");
    }
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    assert_eq!(search(&cloud(1.0), 5), search(&cloud(1.0), 5));
}

#[test]
fn what_is_no_ellipsoid_is_refused_with_a_reason() {
    let mut draw = draws(3);
    let plane: [Point3; 400] =
        core::array::from_fn(|_| Point3::new(5.0 * draw(), 3.0 * draw(), 0.02 * draw()));
    let clutter: [Point3; 400] = core::array::from_fn(|_| Point3::new(5.0 * draw(), 3.0 * draw(), draw()));
    let mut half = cloud(1.0);
    for p in &mut half {
        p.z = if p.z < 5.0 { 10.0 - p.z } else { p.z };
    }
    for (cloud, codes) in [
        // A plane thinner than the thinnest ellipsoid is explained as clutter in a thin box.
        (&plane[..], &[RefusalCode::Flat, RefusalCode::Clutter][..]),
        (&clutter, &[RefusalCode::Clutter, RefusalCode::FewPoints]),
        (&half, &[RefusalCode::Coverage]),
        (&plane[..11], &[RefusalCode::FewPoints]),
        (&[Point3::new(1.0, 2.0, 3.0); 50], &[RefusalCode::FewPoints]),
    ] {
        let refusal = match search(cloud, 1).0 {
            MixtureProgress::Found(found) => found.refusal.unwrap(),
            MixtureProgress::Nothing(refusal) => refusal,
            MixtureProgress::Working => unreachable!(),
        };
        assert!(codes.contains(&refusal.code), "{refusal:?} instead of {codes:?}");
    }
}

#[test]
fn two_bodies_are_found_one_after_the_other() {
    let mut draw = draws(8);
    let cloud: [Point3; 800] = core::array::from_fn(|k| {
        let v = [draw(), draw(), draw()];
        let n = libm::sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        let (aside, size) = if k % 2 == 0 { (0.0, 2.0) } else { (8.0, 1.0) };
        Point3::new(aside + size * v[0] / n, size * v[1] / n, 1.5 * size * v[2] / n)
    });
    let detector = Detector::new(Config { max_targets: 2, ..Config::surface() }).unwrap();
    let mut workspace = Workspace::<800>::new();
    let mut centres = [f32::NAN; 2];
    for fruit in detector.detect(&cloud, workspace.scratch(), 1).unwrap() {
        assert_eq!(fruit.status, Status::Accepted);
        centres[usize::from(fruit.target) - 1] = fruit.ellipsoid.centre.x;
    }
    centres.sort_by(f32::total_cmp);
    assert!(centres[0].abs() < 0.05 && (centres[1] - 8.0).abs() < 0.05, "{centres:?}");
}

#[test]
fn a_search_fits_on_a_small_stack() {
    assert!(size_of::<MixtureSearch>() <= 2048, "{}", size_of::<MixtureSearch>());
}
