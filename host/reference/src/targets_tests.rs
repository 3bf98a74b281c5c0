//! Facts about whole runs on clouds whose answer is known.

use super::*;
use crate::{Constraint, digest};

fn config() -> Config {
    Config {
        confidence: 0.95,
        sizes: vec![9, 10, 11, 12],
        shell: 0.05,
        radius: f32::INFINITY,
        semi_axis_min: 0.5,
        semi_axis_max: 6.0,
        max_trials: 3000,
        refits: 3,
        min_inliers: 30,
        min_ratio: 0.0,
        max_targets: 4,
        max_failures: 2,
        constraint: Constraint::Trace,
    }
}

/// A number in -1..1.
fn unit(stream: &mut Stream) -> f32 {
    stream.below(1 << 20) as f32 / (1 << 19) as f32 - 1.0
}

/// `count` points on the ellipsoid with the semi-axes 3, 2 and 1 around `centre`.
fn surface_points(count: usize, centre: Point, stream: &mut Stream) -> Vec<Point> {
    let mut points = Vec::new();
    while points.len() < count {
        let v = [unit(stream), unit(stream), unit(stream)];
        let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        if length > 0.1 && length <= 1.0 {
            points.push([
                centre[0] + 3.0 * v[0] / length,
                centre[1] + 2.0 * v[1] / length,
                centre[2] + v[2] / length,
            ]);
        }
    }
    points
}

/// Two ellipsoids of 100 points each, 20 apart, and 20 points of clutter around the first.
fn scene() -> Vec<Point> {
    let mut stream = Stream::seeded(99);
    let mut cloud = surface_points(100, [1.0, 1.0, 1.0], &mut stream);
    cloud.extend(surface_points(100, [21.0, 1.0, 1.0], &mut stream));
    for _ in 0..20 {
        cloud.push([4.0 * unit(&mut stream), 4.0 * unit(&mut stream), 4.0 * unit(&mut stream)]);
    }
    cloud
}

#[test]
fn both_ellipsoids_of_a_scene_are_found() {
    let cloud = scene();
    let found = run(&cloud, &Config { radius: 6.5, ..config() }, 1).expect("a valid cloud");
    assert!(found.detections.len() >= 2);
    for detection in &found.detections[..2] {
        let [x, y, z] = detection.ellipsoid.centre;
        assert!((x - 1.0).abs() < 1e-3 || (x - 21.0).abs() < 1e-3, "x = {x}");
        assert!((y - 1.0).abs() < 1e-3 && (z - 1.0).abs() < 1e-3);
        for (found, expected) in detection.ellipsoid.semi_axes.into_iter().zip([3.0, 2.0, 1.0]) {
            assert!((found - expected).abs() < 1e-3);
        }
        assert!(detection.score.inliers >= 100);
        let report = detection.report;
        let r = report.rejections;
        let rejected = r.too_few_points + r.degenerate + r.not_ellipsoid + r.size + r.support;
        assert_eq!(report.trials, report.scored + rejected);
        assert!(report.trials >= report.bound);
    }
    assert_ne!(found.labels[0], found.labels[100]);
    assert_eq!(found.detections[0].score.candidates, 220);
    assert_eq!(found.detections[1].score.candidates, 220 - found.detections[0].score.inliers);
}

#[test]
fn the_same_seed_gives_the_same_digest_and_a_trace_changes_nothing() {
    let cloud = scene();
    let first = run(&cloud, &config(), 5).expect("a valid cloud");
    let mut detections = Vec::new();
    let second = trace(&cloud, &config(), 5, &mut |event| {
        if let Event::Detection(detection) = event {
            detections.push(detection);
        }
    })
    .expect("a valid cloud");
    assert_eq!(first, second);
    assert_eq!(first.detections, detections);
    assert_eq!(digest(&first), digest(&second));
    assert_ne!(digest(&first), digest(&run(&cloud, &config(), 6).expect("a valid cloud")));
}

#[test]
fn a_run_ends_by_the_first_test_that_holds() {
    let cloud = scene();
    let finish = |config: &Config, cloud: &[Point]| run(cloud, config, 3).expect("a valid cloud").finish;
    assert_eq!(finish(&Config { max_targets: 0, max_failures: 0, ..config() }, &[]), Finish::Targets);
    assert_eq!(finish(&Config { max_failures: 0, ..config() }, &[]), Finish::Failures);
    assert_eq!(finish(&config(), &[]), Finish::Points);
    assert_eq!(finish(&config(), &cloud[..8]), Finish::Points);
    assert_eq!(finish(&config(), &[[1.0; 3]; 40]), Finish::Failures);
    assert_eq!(finish(&Config { max_targets: 1, ..config() }, &cloud[..100]), Finish::Targets);
    // The first target takes 100 of 100 points: fewer are left than it has.
    assert_eq!(finish(&config(), &cloud[..100]), Finish::Points);
}

#[test]
fn a_cloud_that_is_not_allowed_is_refused() {
    assert!(run(&[[f32::NAN; 3]], &config(), 1).is_err());
}
