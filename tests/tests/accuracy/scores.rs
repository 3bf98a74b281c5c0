//! What a score means: the shell between two scaled bodies against closest-point distances, the size check against
//! eigenvalues.

use nalgebra::Vector3;
use varsac_core::{CentralQuadric, Config, Point3, jacobi::Symmetric3, tebc::Shell};
use varsac_tests::{
    body::{Body, Central64, narrow, wide},
    random::Dice,
    statistics::Sample,
    tolerance as limit,
};

/// The `f32` surface nearest to a body, and the body that this surface is exactly.
fn rounded(body: &Body) -> (CentralQuadric, Body) {
    let c = body.central();
    let s = |i, j| c.shape[(i, j)] as f32;
    let shape = Symmetric3 { xx: s(0, 0), yy: s(1, 1), zz: s(2, 2), xy: s(0, 1), xz: s(0, 2), yz: s(1, 2) };
    let surface = CentralQuadric { centre: narrow(&c.centre), shape };
    (surface, Central64::from(&surface).body())
}

fn some_jujube(dice: &mut Dice) -> (CentralQuadric, Body) {
    let centre =
        Vector3::new(dice.between(-300.0, 300.0), dice.between(-300.0, 300.0), dice.between(500.0, 1300.0));
    rounded(&Body::jujube(dice, centre))
}

#[test]
fn inliers_lie_between_the_scaled_bodies_by_closest_point() {
    let d = Config::jujube().paper().shell;
    let (inner, outer) = (f64::from(1.0 - d), f64::from(1.0 + d));
    let mut wrong_side = Sample::default();
    let (mut inside, mut outside) = (0, 0);
    for case in 0..200 {
        let mut dice = Dice::new("closest point", case);
        let (surface, body) = some_jujube(&mut dice);
        let shell = Shell::new(&surface, d);
        for _ in 0..40 {
            // Around the surface, and as close to one of the two bounds as f32 can tell.
            let rim = if dice.unit() < 0.5 { inner } else { outer };
            let factor = match dice.below(3) {
                0 => dice.between(0.7, 1.3),
                1 => rim + 1e-6 * dice.normal(),
                _ => rim + 1e-4 * dice.normal(),
            };
            let point = narrow(&body.scaled(factor).surface_point(&mut dice));
            let p = wide(&point);
            let within_outer = body.scaled(outer).signed_distance(&p);
            let beyond_inner = -body.scaled(inner).signed_distance(&p);
            let depth = -within_outer.max(beyond_inner);
            if shell.contains(&point) {
                inside += 1;
                wrong_side.push((-depth).max(0.0) / body.semi_axes.max());
            } else {
                outside += 1;
                wrong_side.push(depth.max(0.0) / body.semi_axes.max());
            }
        }
    }
    println!("closest-point distances: {inside} inside the shell, {outside} outside");
    assert!(inside > 1000 && outside > 1000);
    limit::SHELL_DISAGREE.check(wrong_side.max());
}

#[test]
fn the_shell_is_as_thick_as_the_semi_axes_say() {
    // The two bodies are nowhere closer to the surface than d times the shortest semi-axis, and nowhere farther than d
    // times the longest: orthogonal distances below the one are inliers, above the other they are not.
    let d = Config::jujube().paper().shell;
    let mut seen = [0, 0, 0];
    for case in 0..200 {
        let mut dice = Dice::new("thickness", case);
        let (surface, body) = some_jujube(&mut dice);
        let shell = Shell::new(&surface, d);
        let thin = f64::from(d) * body.semi_axes.min();
        let thick = f64::from(d) * body.semi_axes.max();
        for _ in 0..40 {
            let point = narrow(&body.from_sphere(&(dice.direction() * dice.between(0.6, 1.4))));
            let distance = body.signed_distance(&wide(&point)).abs();
            let inlier = shell.contains(&point);
            if distance < 0.9999 * thin {
                assert!(inlier, "case {case}: {distance} mm from the surface and not in the shell");
                seen[0] += 1;
            } else if distance > 1.0001 * thick {
                assert!(!inlier, "case {case}: {distance} mm from the surface and in the shell");
                seen[1] += 1;
            } else {
                seen[2] += 1;
            }
        }
    }
    println!("surely inside, surely outside, depends on the place: {seen:?}");
    assert!(seen.iter().all(|&count| count > 500));
}

#[test]
fn a_score_counts_the_points_of_the_shell() {
    let mut dice = Dice::new("counting", 0);
    let (surface, body) = some_jujube(&mut dice);
    let d = Config::jujube().paper().shell;
    let cloud: Vec<Point3> = (0..500)
        .map(|k| body.scaled(if k % 3 == 0 { 1.0 } else { 0.8 }).surface_point(&mut dice))
        .map(|p| narrow(&p))
        .collect();
    let listed: Vec<u16> = (0..500).filter(|k| k % 5 != 0).collect();
    let score = Shell::new(&surface, d).score(&cloud, &listed);
    // Every third point, less every fifteenth: 167 - 34.
    assert_eq!((score.inliers, score.candidates), (133, 400));
}

#[test]
fn the_size_check_agrees_with_the_eigenvalues() {
    let (min, max) = (9.5_f32, 24.5_f32);
    let mut wrong_side = Sample::default();
    let mut verdicts = [0, 0];
    for case in 0..20_000 {
        let mut dice = Dice::new("size check", case);
        // Two axes anywhere, the third as close to a limit as f32 can tell.
        let rim = f64::from(if dice.unit() < 0.5 { min } else { max });
        let near = rim * (1.0 + [1e-2, 1e-4, 1e-6, 1e-7][dice.below(4)] * dice.normal());
        let semi_axes = Vector3::new(dice.between(9.5, 24.5), dice.between(9.5, 24.5), near);
        let axes = dice.rotation();
        let (surface, body) = rounded(&Body { centre: Vector3::zeros(), semi_axes, axes });
        let inside =
            (body.semi_axes.min() / f64::from(min) - 1.0).min(1.0 - body.semi_axes.max() / f64::from(max));
        let verdict = surface.semi_axes_within(min, max);
        verdicts[usize::from(verdict)] += 1;
        if verdict != (inside > 0.0) {
            wrong_side.push(inside.abs());
        }
    }
    println!("size check: {} refused, {} passed, {} differ", verdicts[0], verdicts[1], wrong_side.len());
    limit::SIZE_DISAGREE.check(wrong_side.max());
}
