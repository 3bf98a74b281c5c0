//! The single fit against the truth.

use super::*;

/// A quarter of an ellipsoid of 30, 20 and 10 mm, every other point a little outside.
fn cap() -> Vec<Point> {
    let mut points = Vec::new();
    for k in 0..120 {
        let z = 1.0 - k as f32 / 120.0;
        let (r, t) = ((1.0 - z * z).sqrt(), 2.4 * k as f32);
        let far = if k % 2 == 0 { 1.002 } else { 0.998 };
        points.push([5.0 + far * 30.0 * r * t.cos(), far * 20.0 * r * t.sin(), 500.0 + far * 10.0 * z]);
    }
    points
}

#[test]
fn both_criteria_find_the_ellipsoid_of_a_cap() {
    let cloud = cap();
    let list: Vec<u16> = (0..120).collect();
    let algebraic = fit_single(&cloud, &list, Criterion::Algebraic).expect("an ellipsoid");
    let geometric = fit_single(&cloud, &list, Criterion::Geometric).expect("an ellipsoid");
    for single in [&algebraic, &geometric] {
        for (found, expected) in single.ellipsoid.semi_axes.iter().zip([30.0, 20.0, 10.0]) {
            assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}");
        }
        let variance = single.covariance.expect("a covariance")[0];
        assert!(variance > 0.0 && variance < 0.1, "{variance}");
    }
    assert!(geometric.rms <= algebraic.rms && geometric.rms > 0.01);
}

#[test]
fn nine_points_have_no_covariance() {
    // On a sphere, spread evenly.
    let mut cloud = Vec::new();
    for k in 0..10 {
        let z = 0.9 - 0.2 * k as f32;
        let (r, t) = ((1.0 - z * z).sqrt(), 2.4 * k as f32);
        cloud.push([r * t.cos(), r * t.sin(), z]);
    }
    let of = |count: u16| fit_single(&cloud, &(0..count).collect::<Vec<_>>(), Criterion::Geometric);
    assert!(of(9).is_ok_and(|single| single.covariance.is_none()));
    assert!(of(10).is_ok_and(|single| single.covariance.is_some()));
    assert_eq!(of(8), Err(Rejection::TooFewPoints));
}
