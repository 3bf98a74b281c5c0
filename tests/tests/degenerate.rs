//! Every bad input of the core, and thousands of hostile ones: an error that names what is wrong, or a run that ends
//! within its published bound with nothing but valid detections. Dev builds check every integer operation on the way.

use nalgebra::Vector3;
use varsac_core::{
    CloudError, Config, ConfigError, Constraint, Detection, Detector, Finish, MAX_TRIALS, Point3, Rejection,
    Scratch, Step, VarsacReport, Workspace,
    fit::fit,
    point::{MAX_COORDINATE, MAX_POINTS},
};
use varsac_tests::{
    body::{Body, narrow, wide},
    bound,
    hostile::{self, FAMILIES},
    random::Dice,
    simulation,
};

// ---- The door ----

#[test]
fn a_bad_coordinate_is_refused_with_index_axis_and_value() {
    let detector = Detector::new(Config::jujube()).unwrap();
    let beyond = f32::from_bits(MAX_COORDINATE.to_bits() + 1);
    for value in [f32::NAN, -f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, beyond, -beyond] {
        for axis in 0..3 {
            for index in [0, 7, 29] {
                let mut cloud = vec![Point3::new(0.0, 0.0, 700.0); 30];
                cloud[index][axis] = value;
                // A second one, later: the first is reported.
                cloud[29].z = if index == 29 { cloud[29].z } else { f32::NAN };
                let mut workspace = Workspace::<32>::new();
                let error = detector.detect(&cloud, workspace.scratch(), 1).map(|_| ()).unwrap_err();
                let CloudError::Coordinate { index: at, axis: which, value: what } = error else {
                    panic!("{error}")
                };
                assert_eq!((at, which, what.to_bits()), (index as u32, axis as u8, value.to_bits()));
                let sentence = error.to_string();
                let name = ["x", "y", "z"][axis];
                assert!(sentence.starts_with(&format!("point {index}: {name} is {value}")), "{sentence}");
            }
        }
    }
    // The limit itself is allowed.
    let mut workspace = Workspace::<32>::new();
    let cloud = [Point3::new(MAX_COORDINATE, -MAX_COORDINATE, 0.0); 12];
    assert!(detector.detect(&cloud, workspace.scratch(), 1).is_ok());
}

#[test]
fn more_points_than_the_workspace_holds_are_refused() {
    let detector = Detector::new(Config::jujube()).unwrap();
    let cloud = [Point3::origin(); 17];
    let mut workspace = Workspace::<16>::new();
    let error = detector.detect(&cloud, workspace.scratch(), 1).map(|_| ()).unwrap_err();
    assert_eq!(error, CloudError::TooManyPoints { count: 17, capacity: 16 });
    let sentence = error.to_string();
    assert!(
        sentence.contains("17") && sentence.contains("16") && sentence.contains("decimate"),
        "{sentence}"
    );

    // Lent buffers: the shortest decides. Without any room an empty cloud still is a cloud.
    for shortest in 0..3 {
        let room = |k: usize| if k == shortest { 9 } else { 40 };
        let (mut order, mut members, mut labels) = (vec![0; room(0)], vec![0; room(1)], vec![0; room(2)]);
        let scratch = Scratch::new(&mut order, &mut members, &mut labels);
        let error = detector.detect(&cloud[..10], scratch, 1).map(|_| ()).unwrap_err();
        assert_eq!(error, CloudError::TooManyPoints { count: 10, capacity: 9 });
        let scratch = Scratch::new(&mut order, &mut members, &mut labels);
        assert!(detector.detect(&cloud[..9], scratch, 1).is_ok());
    }
    assert!(detector.detect(&[], Scratch::new(&mut [], &mut [], &mut []), 1).is_ok());
}

#[test]
fn the_largest_cloud_is_searched_and_one_point_more_is_refused() {
    let mut dice = Dice::new("largest cloud", 0);
    let body = Body::jujube(&mut dice, Vector3::new(0.0, 0.0, 700.0));
    let cloud = simulation::surface(&mut dice, &body, MAX_POINTS + 1, 0.0);
    let room = MAX_POINTS + 100;
    let (mut order, mut members, mut labels) = (vec![0; room], vec![0; room], vec![0; room]);
    for radius in [f32::INFINITY, 30.0] {
        let detector = Detector::new(Config { radius, ..Config::jujube() }).unwrap();
        let scratch = Scratch::new(&mut order, &mut members, &mut labels);
        let found = detector.detect(&cloud[1..], scratch, 1).unwrap().next().unwrap();
        assert_eq!(found.score.inliers as usize, MAX_POINTS);
        let scratch = Scratch::new(&mut order, &mut members, &mut labels);
        let error = detector.detect(&cloud, scratch, 1).map(|_| ()).unwrap_err();
        assert_eq!(error, CloudError::TooManyPoints { count: 65_536, capacity: 65_535 });
    }
}

#[test]
fn a_bad_configuration_is_refused_with_field_value_and_range() {
    type Set = fn(&mut Config, f32);
    let open_unit: &[f32] = &[0.0, -0.0, 1.0, -0.5, 1.5, f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    let length: &[f32] = &[0.0, -1.0, f32::NAN, f32::NEG_INFINITY, 1e-30, 2e9];
    let fields: [(&str, Set, &[f32]); 6] = [
        ("confidence", |c, v| c.confidence = v, open_unit),
        ("shell", |c, v| c.shell = v, open_unit),
        ("radius", |c, v| c.radius = v, length),
        ("semi_axis_min", |c, v| c.semi_axis_min = v, &[0.0, -1.0, f32::NAN, f32::INFINITY, 1e-30, 2e9]),
        ("semi_axis_max", |c, v| c.semi_axis_max = v, &[0.0, -1.0, f32::NAN, f32::INFINITY, 2e9, 9.5, 5.0]),
        ("min_ratio", |c, v| c.min_ratio = v, &[-0.1, 1.1, f32::NAN, f32::INFINITY]),
    ];
    for (field, set, values) in fields {
        for &value in values {
            let mut config = Config::jujube();
            set(&mut config, value);
            let error = Detector::new(config).unwrap_err();
            assert_eq!(error.field, field, "{field} = {value}");
            assert!(error.value == f64::from(value) || (error.value.is_nan() && value.is_nan()));
            let sentence = error.to_string();
            assert!(sentence.starts_with(field) && sentence.contains("it must be"), "{sentence}");
        }
    }
    let counts: [(&str, fn(&mut Config), f64); 9] = [
        ("sample_sizes", |c| c.sample_sizes.clear(), 0.0),
        ("sample_sizes", |c| c.sample_sizes[1] = 8, 8.0),
        ("sample_sizes", |c| c.sample_sizes[2] = 0, 0.0),
        ("sample_sizes", |c| c.sample_sizes[3] = 255, 255.0),
        ("max_trials", |c| c.max_trials = 0, 0.0),
        ("max_trials", |c| c.max_trials = MAX_TRIALS + 1, 1_000_001.0),
        ("refits", |c| c.refits = 11, 11.0),
        ("max_targets", |c| c.max_targets = 0, 0.0),
        ("max_failures", |c| c.max_failures = 0, 0.0),
    ];
    for (field, spoil, value) in counts {
        let mut config = Config::jujube();
        spoil(&mut config);
        let ConfigError { field: named, value: given, allowed } = config.check().unwrap_err();
        assert_eq!((named, given), (field, value));
        assert!(!allowed.is_empty());
    }
}

// ---- Poor clouds ----

/// A run to its end, every step counted and every outcome checked against the others.
struct Run {
    found: Vec<Detection>,
    missed: Vec<VarsacReport>,
    finish: Finish,
    steps: u64,
}

fn run(config: &Config, cloud: &[Point3], seed: u64) -> Run {
    let detector = Detector::new(config.clone()).unwrap();
    let mut workspace = Workspace::<512>::new();
    let mut detections = detector.detect(cloud, workspace.scratch(), seed).unwrap();
    let mut run = Run { found: Vec::new(), missed: Vec::new(), finish: Finish::FewPoints, steps: 0 };
    let mut live = cloud.len() as u32;
    loop {
        run.steps += 1;
        assert!(run.steps <= bound::steps(config), "still not finished: {config:?}");
        match detections.step() {
            Step::Working => {}
            Step::Missed(report) => {
                check_report(config, &report);
                run.missed.push(report);
            }
            Step::Found(detection) => {
                check_report(config, &detection.report);
                check_detection(config, &detection);
                run.found.push(detection);
                assert_eq!(usize::from(detection.target), run.found.len());
                assert_eq!(detection.score.candidates, live);
                live -= detection.score.inliers;
                let claimed = detections.labels().iter().filter(|&&label| label == detection.target).count();
                assert_eq!(claimed as u32, detection.score.inliers);
            }
            Step::Finished(finish) => {
                run.finish = finish;
                break;
            }
        }
        assert_eq!(detections.live(), live);
    }
    for _ in 0..3 {
        assert_eq!(detections.step(), Step::Finished(run.finish), "over is over");
    }
    run
}

fn check_report(config: &Config, report: &VarsacReport) {
    assert_eq!(
        report.rejections.iter().sum::<u32>() + report.scored,
        report.trials,
        "every trial is counted"
    );
    assert!(report.trials <= config.max_trials && (1..=config.max_trials).contains(&report.bound));
    assert!(report.scored == 0 || report.support.inliers >= u32::from(config.min_inliers));
}

fn check_detection(config: &Config, detection: &Detection) {
    let e = &detection.ellipsoid;
    assert!(detection.score.inliers >= u32::from(config.min_inliers));
    assert!(e.centre.iter().all(|v| v.is_finite()));
    // The squares of longer spans of semi-axes do not fit into the 24 bits of a shape matrix.
    if config.semi_axis_max <= 500.0 * config.semi_axis_min {
        let (min, max) = (0.999 * config.semi_axis_min, 1.001 * config.semi_axis_max);
        assert!(e.semi_axes.iter().all(|axis| (min..=max).contains(axis)), "{e:?} {config:?}");
        assert!(e.semi_axes.is_sorted_by(|a, b| a >= b), "{e:?}");
        assert!(e.quaternion_xyzw().iter().chain(&e.attitude_rad()).all(|v| v.is_finite()), "{e:?}");
    }
}

fn family(name: &str, case: u64, n: usize) -> Vec<Point3> {
    let (_, make) = FAMILIES.iter().find(|(known, _)| *known == name).expect("a known family");
    make(&mut Dice::new(name, case), n)
}

#[test]
fn fewer_points_than_a_sample_are_no_work() {
    for n in 0..9 {
        let cloud = family("sphere", 1, n);
        let run = run(&Config::jujube(), &cloud, 1);
        assert_eq!((run.finish, run.found.len(), run.missed.len()), (Finish::FewPoints, 0, 0));
        let all: Vec<u16> = (0..n as u16).collect();
        assert_eq!(fit(&cloud, &all, Constraint::A11), Err(Rejection::TooFewPoints));
    }
    // Nine points are a sample of 9 and none of 12, and as many inliers as min_inliers must be there.
    let config = Config { radius: f32::INFINITY, min_inliers: 9, max_trials: 40, ..Config::jujube() };
    let run = run(&config, &family("sphere", 1, 9), 1);
    assert_eq!(run.found.len() + run.missed.len(), 1);
}

#[test]
fn what_determines_no_ellipsoid_yields_none() {
    for name in ["all equal", "two places", "line", "plane", "subnormal spread", "signed zeros"] {
        for case in 0..20 {
            let cloud = family(name, case, 200);
            for constraint in [Constraint::A11, Constraint::Trace] {
                let config = Config { constraint, max_trials: 300, ..Config::generic() };
                let run = run(&config, &cloud, case);
                assert!(run.found.is_empty(), "{name} {case}: {:?}", run.found);
                let rejections = run.missed[0].rejections;
                let hopeless =
                    rejections[Rejection::Degenerate as usize] + rejections[Rejection::NotEllipsoid as usize];
                let few = rejections[Rejection::TooFewPoints as usize];
                assert_eq!(hopeless + few, 300, "{name} {case}: {rejections:?}");
            }
        }
    }
    for name in ["saddle", "all magnitudes", "corners of the allowed cube", "any bits"] {
        for case in 0..20 {
            let run = run(&Config { max_trials: 300, ..Config::jujube() }, &family(name, case, 200), case);
            assert!(run.found.is_empty(), "{name} {case}: {:?}", run.found);
        }
    }
}

#[test]
fn one_point_neighbourhoods_are_counted_as_too_few() {
    let cloud: Vec<Point3> = (0..100).map(|k| Point3::new(100.0 * k as f32, 0.0, 700.0)).collect();
    let run = run(&Config::jujube(), &cloud, 5);
    assert_eq!(run.finish, Finish::Failures);
    assert_eq!(run.missed[0].rejections, [3000, 0, 0, 0, 0]);
}

#[test]
fn a_sphere_is_a_fruit_with_equal_axes() {
    for (seed, radius) in [(0, 30.0), (u64::MAX, 30.0), (0, f32::INFINITY), (u64::MAX, f32::INFINITY)] {
        let run = run(&Config { radius, ..Config::jujube() }, &family("sphere", 3, 300), seed);
        let e = run.found[0].ellipsoid;
        assert_eq!((run.found.len(), run.found[0].score.inliers), (1, 300));
        assert!(e.semi_axes.iter().all(|axis| (axis - 12.0).abs() < 1e-3), "{e:?}");
    }
}

/// Two whole fruit that touch, 200 points each, and some points elsewhere.
fn touching(case: u64, elsewhere: usize) -> ([Body; 2], Vec<Point3>) {
    let mut dice = Dice::new("touching", case);
    let bodies = [0.0, 24.0].map(|x| Body::jujube(&mut dice, Vector3::new(x, 0.0, 700.0)));
    let mut cloud = simulation::surface(&mut dice, &bodies[0], 200, 0.0);
    cloud.extend(simulation::surface(&mut dice, &bodies[1], 200, 0.0));
    cloud.extend((0..elsewhere).map(|_| narrow(&(dice.in_cube(100.0) + Vector3::new(400.0, 0.0, 700.0)))));
    (bodies, cloud)
}

#[test]
fn two_touching_fruit_are_two_targets_as_far_as_step_5_lets_them() {
    let config = Config { refits: 10, min_ratio: 0.0, ..Config::jujube() };
    let hits = |elsewhere: usize| {
        let mut hits = [0, 0];
        for case in 0..20 {
            let (bodies, cloud) = touching(case, elsewhere);
            let run = run(&config, &cloud, case);
            let near =
                |found: &Detection, body: &Body| (wide(&found.ellipsoid.centre) - body.centre).norm() < 1.0;
            hits[0] +=
                u32::from(run.found.first().is_some_and(|found| bodies.iter().any(|body| near(found, body))));
            hits[1] += u32::from(bodies.iter().all(|body| run.found.iter().any(|found| near(found, body))));
        }
        hits
    };
    let (alone, among_others) = (hits(0), hits(80));
    println!("two touching fruit, of 20 clouds: the first right in {}, both in {}", alone[0], alone[1]);
    println!(
        "the same with 80 points elsewhere: the first right in {}, both in {}",
        among_others[0], among_others[1]
    );
    // The paper's Step 5 gives up when fewer points are left than the last target had: of two equal fruit and nothing
    // else, the second is lost whenever the first took a point of it.
    assert!(alone[0] >= 16 && among_others[0] >= 16 && among_others[1] >= 16);
}

// ---- The storm ----

#[test]
fn hostile_clouds_and_configurations_never_break_the_bounds() {
    let (mut found, mut longest) = (0, 0.0_f64);
    let mut finishes = [0_u32; 3];
    for case in 0..4000 {
        let mut dice = Dice::new("storm", case);
        let (_, make) = FAMILIES[case as usize % FAMILIES.len()];
        let points = dice.below(150);
        let cloud = make(&mut dice, points);
        let config = hostile::config(&mut dice, 60);
        let seed = [0, u64::MAX, dice.bits()][dice.below(3)];
        let run = run(&config, &cloud, seed);
        found += run.found.len();
        longest = longest.max(run.steps as f64 / bound::steps(&config) as f64);
        finishes[run.finish as usize] += 1;
    }
    println!("4000 hostile runs: {found} detections; ended by few points, targets, failures: {finishes:?}");
    println!("the longest took {:.1} % of the steps it was allowed", 100.0 * longest);
    assert!(found > 100 && finishes.iter().all(|&count| count > 20), "the storm must reach every ending");
}

#[test]
fn hostile_lists_never_break_a_fit() {
    let (mut fitted, mut rejected) = (0, [0; Rejection::COUNT]);
    for case in 0..20_000 {
        let mut dice = Dice::new("lists", case);
        let (name, make) = FAMILIES[case as usize % FAMILIES.len()];
        let cloud = make(&mut dice, 40);
        // Any indices at all: repeated ones, and ones beyond the cloud (the origin stands in for them).
        let sample: Vec<u16> = (0..dice.below(40)).map(|_| dice.below(42) as u16).collect();
        let constraint = if dice.unit() < 0.5 { Constraint::A11 } else { Constraint::Trace };
        match fit(&cloud, &sample, constraint) {
            Ok(surface) => {
                fitted += 1;
                assert!(surface.centre.iter().all(|v| v.is_finite()), "{name} {case}: {surface:?}");
                // Below this spread 1 / semi-axis^2 leaves the range of f32; the size check of a search refuses it.
                let extent = cloud.iter().flat_map(|p| p.iter()).fold(0.0_f32, |most, v| most.max(v.abs()));
                let s = surface.shape;
                let finite = [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz].iter().all(|v| v.is_finite());
                assert!(finite || extent < 1e-18, "{name} {case}: {surface:?}");
            }
            Err(reason) => rejected[reason as usize] += 1,
        }
    }
    println!("20000 hostile lists: {fitted} ellipsoids; rejected {rejected:?}");
    assert!(fitted > 500 && rejected[0] > 500 && rejected[1] > 500 && rejected[2] > 500);
}

#[test]
fn the_origin_stands_in_for_an_index_that_is_none() {
    let mut dice = Dice::new("no such index", 0);
    let body =
        Body { centre: Vector3::zeros(), semi_axes: Vector3::new(3.0, 2.0, 1.0), axes: dice.rotation() };
    let cloud: Vec<Point3> = (0..12).map(|_| narrow(&body.surface_point(&mut dice))).collect();
    let with_origin = [&cloud[..], &[Point3::origin()]].concat();
    let list: Vec<u16> = (0..13).collect();
    assert_eq!(fit(&cloud, &list, Constraint::Trace), fit(&with_origin, &list, Constraint::Trace));
}
