//! The reference against the truth: what it finds is what was put into the cloud.

use super::*;
use crate::mixture::MixtureGate;

fn surface() -> MixtureConfig {
    MixtureConfig {
        max_targets: 8,
        max_failures: 1,
        viewpoint: Viewpoint::None,
        noise: Noise { axial: 1.0, lateral: 0.001 },
        sample: 400,
        starts: 10,
        area_weight: 0.5,
        shape_spread: f32::INFINITY,
        outline_offset: 0.0004,
        inflation: 1.1,
        inflation_thin: 2.0,
        inflation_outliers: 0.0,
        gate: MixtureGate {
            min_points: 20.0,
            gain: 0.1,
            flat: 1.75,
            coverage: 0.7,
            misfit: 0.025,
            uncertain: 0.3,
        },
    }
}

/// Points on an ellipsoid about `centre`, in a spiral from pole to pole, every other one a little outside.
fn ellipsoid(centre: [f32; 3], [a, b, c]: [f32; 3], n: usize) -> Vec<[f32; 3]> {
    let mut points = Vec::new();
    for k in 0..n {
        let z = 1.0 - (2 * k + 1) as f32 / n as f32;
        let (r, t) = ((1.0 - z * z).sqrt(), 2.4 * k as f32);
        let far = if k.is_multiple_of(2) { 1.005 } else { 0.995 };
        points.push([
            centre[0] + far * a * r * t.cos(),
            centre[1] + far * b * r * t.sin(),
            centre[2] + far * c * z,
        ]);
    }
    points
}

#[test]
fn a_whole_surface_is_found_and_accepted() {
    let points = ellipsoid([100.0, -50.0, 700.0], [40.0, 30.0, 20.0], 600);
    let view = View { in_mask: points.len(), points, ..View::default() };
    let run = run_mixture(&view, &surface(), 1).expect("a valid view");
    let body = run.detections[0];
    assert_eq!(body.refusal, None);
    for (found, expected) in body.ellipsoid.semi_axes.iter().zip([40.0, 30.0, 20.0]) {
        assert!((found - expected).abs() < 0.3, "{found} {expected}");
    }
    assert!(body.score.inliers > 550 && body.covariance.is_some());
    let labelled: u32 = run.labels.iter().map(|&label| u32::from(label == 1)).sum();
    assert_eq!(labelled, body.score.inliers);
}

#[test]
fn two_surfaces_are_two_bodies() {
    let mut points = ellipsoid([0.0; 3], [40.0, 30.0, 20.0], 400);
    points.extend(ellipsoid([100.0, 0.0, 0.0], [25.0, 25.0, 25.0], 400));
    let view = View { in_mask: points.len(), points, ..View::default() };
    let run = run_mixture(&view, &surface(), 1).expect("a valid view");
    let accepted: Vec<_> = run.detections.iter().filter(|body| body.refusal.is_none()).collect();
    assert_eq!(accepted.len(), 2);
}

#[test]
fn a_cloud_of_equal_points_and_one_of_few_points_end_at_once() {
    let of = |n| View { in_mask: n, points: vec![[1.0, 2.0, 3.0]; n], ..View::default() };
    let run = run_mixture(&of(30), &surface(), 1).expect("a valid view");
    assert_eq!((run.detections.len(), run.finish), (0, Finish::Failures));
    let run = run_mixture(&of(11), &surface(), 1).expect("a valid view");
    assert_eq!((run.detections.len(), run.finish), (0, Finish::Points));
}
