//! Facts about whole runs on views whose answer is known.

use super::*;
use crate::{Event, Gate, Inflation, Noise, OutlineRay, Phase, Point};

/// Jujubes before a Kinect v2.
fn config() -> MapConfig {
    MapConfig {
        max_targets: 4,
        max_failures: 2,
        semi_axes: [21.75, 10.9, 10.9],
        spread: [0.035, 0.06, 0.06],
        spread_ab: f32::INFINITY,
        spread_bc: 0.08,
        boxiness: 0.05,
        noise: Noise { axial: 1.0, lateral: 0.001 },
        independence: 1.0,
        viewpoint: Viewpoint::Origin,
        outline_offset: 0.0004,
        hypotheses: 20,
        hypothesis_steps: 3,
        kept: 4,
        refine_steps: 8,
        final_steps: 5,
        inflation: Inflation { base: 0.75, per_conflict: 0.2, per_clutter: 5.0 },
        gate: Gate {
            min_points: 20,
            size_conflict: 10.0,
            size_conflict_end_on: 10.0,
            size_unknown: 0.5,
            ambiguous: 0.95,
            outline: 1.5,
            visible: 0.3,
            colour: 0.4,
            uncertain: 3.0,
            flat: 1.2,
            through: 0.2,
            shared_volume: 0.75,
        },
    }
}

/// Pixels 1/365 rad apart on the near side of jujubes along x, 700 mm away, with a wall 100 mm behind.
fn view(centres: &[Point]) -> View {
    let pitch = 1.0 / 365.0;
    let (mut fruit, mut wall, mut outline) = (Vec::new(), Vec::new(), Vec::new());
    for row in -12..=12 {
        let mut last = None;
        for column in -40..=40 {
            let ray = [column as f32 * pitch, row as f32 * pitch, 1.0];
            let hit = centres.iter().filter_map(|&c| depth(ray, c)).fold(f32::INFINITY, f32::min);
            let point = ray.map(|component| component * if hit.is_finite() { hit } else { 800.0 });
            if let (Some(inner), false) = (last, hit.is_finite()) {
                let middle = (column as f32 - 0.5) * pitch;
                let inner: Point = inner;
                let inner = [middle * inner[2], inner[1], inner[2]];
                outline.push(OutlineRay { inner, outer: 800.0, sigma: 0.4 * pitch });
            }
            last = hit.is_finite().then_some(point);
            if hit.is_finite() { fruit.push(point) } else { wall.push(point) }
        }
    }
    let in_mask = fruit.len();
    fruit.extend(wall);
    View { points: fruit, in_mask, outline, pitch }
}

/// Depth at which a ray enters the jujube 22 x 11 x 11 mm around `c`.
fn depth(ray: Point, c: Point) -> Option<f32> {
    let scaled = |v: Point| [v[0] / 22.0, v[1] / 11.0, v[2] / 11.0];
    let (r, c) = (scaled(ray), scaled(c));
    let dot = |a: Point, b: Point| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (rr, rc, cc) = (dot(r, r), dot(r, c), dot(c, c));
    let inside = rc * rc - rr * (cc - 1.0);
    (inside >= 0.0).then(|| (rc - inside.sqrt()) / rr)
}

#[test]
fn a_jujube_before_a_wall_is_found_and_accepted() {
    let found = run_map(&view(&[[5.0, 0.0, 700.0]]), &config(), 1).expect("a valid view");
    assert_eq!(found.detections.len(), 1, "{found:?}");
    let jujube = &found.detections[0];
    assert_eq!(jujube.refusal, None, "{:?}", jujube.findings);
    let e = &jujube.ellipsoid;
    for (found, truth) in e.centre.into_iter().zip([5.0, 0.0, 700.0]) {
        assert!((found - truth).abs() < 1.0, "{e:?}");
    }
    assert!(e.axes[0][0] > 0.99 && jujube.findings.rays > 6);
    let sigma = jujube.findings.sigma_mm;
    assert!(sigma > 0.05 && sigma < 1.0, "{sigma}");
    assert!(jujube.findings.colour == 0.0 && jujube.findings.visible > 0.8);
}

#[test]
fn neighbours_are_refitted_beside_each_other() {
    let view = view(&[[-23.0, 0.0, 700.0], [23.0, 2.0, 702.0]]);
    let mut joint = 0;
    let mut observe = |event| joint += u32::from(matches!(event, Event::Estimate(Phase::Joint, _)));
    let found = trace_map(&view, &config(), 3, &mut observe).expect("a valid view");
    assert_eq!(found.detections.iter().filter(|found| found.refusal.is_none()).count(), 2, "{found:?}");
    assert!(joint >= 2 * 3, "each of two fruit has three turns of one to five steps: {joint}");
    for detection in &found.detections {
        assert!((detection.ellipsoid.centre[0].abs() - 23.0).abs() < 1.0);
    }
}

#[test]
fn the_same_seed_gives_the_same_run_and_a_trace_changes_nothing() {
    let view = view(&[[0.0, 0.0, 600.0]]);
    let mut detections = Vec::new();
    let traced = trace_map(&view, &config(), 5, &mut |event| {
        if let Event::MapDetection(found) = event {
            detections.push(*found);
        }
    });
    let traced = traced.expect("a valid view");
    assert_eq!(traced.detections, detections);
    assert_eq!(traced, run_map(&view, &config(), 5).expect("a valid view"));
}

#[test]
fn a_run_ends_by_the_first_test_that_holds() {
    let finish = |view: &View, config: &MapConfig| run_map(view, config, 1).expect("a valid view").finish;
    let jujube = view(&[[0.0, 0.0, 700.0]]);
    assert_eq!(finish(&View::default(), &config()), Finish::Points);
    assert_eq!(finish(&View { in_mask: 7, ..jujube.clone() }, &config()), Finish::Points);
    assert_eq!(finish(&jujube, &MapConfig { max_targets: 1, ..config() }), Finish::Targets);
    let equal = View { points: vec![[0.0, 0.0, 700.0]; 40], in_mask: 99, ..View::default() };
    assert_eq!(finish(&equal, &config()), Finish::Failures);
}

#[test]
fn too_many_rays_are_refused() {
    let ray = OutlineRay { inner: [0.0; 3], outer: 1.0, sigma: 1.0 };
    let view = |count: usize| View { outline: vec![ray; count], ..View::default() };
    assert!(run_map(&view(4096), &config(), 1).is_ok());
    assert_eq!(run_map(&view(4097), &config(), 1), Err(CloudError::TooManyRays(4097)));
}
