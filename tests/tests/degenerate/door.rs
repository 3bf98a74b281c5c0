//! What is refused before any work is done: bad clouds and bad configurations, each named in one sentence.

use nalgebra::Vector3;
use varsac_core::{
    CloudError, Config, ConfigError, Detector, Finds, MAX_TRIALS, Point3, Scratch, Workspace,
    point::{MAX_COORDINATE, MAX_POINTS},
};
use varsac_tests::{body::Body, random::Dice, simulation};

#[test]
fn a_bad_coordinate_is_refused_with_index_axis_and_value() {
    let detector = Detector::new(Config::jujube().paper()).unwrap();
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
    let detector = Detector::new(Config::jujube().paper()).unwrap();
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
    let mut finds = Finds::new();
    for shortest in 0..3 {
        let room = |k: usize| if k == shortest { 9 } else { 40 };
        let (mut order, mut members, mut labels) = (vec![0; room(0)], vec![0; room(1)], vec![0; room(2)]);
        let scratch = Scratch::new(&mut order, &mut members, &mut labels, &mut finds);
        let error = detector.detect(&cloud[..10], scratch, 1).map(|_| ()).unwrap_err();
        assert_eq!(error, CloudError::TooManyPoints { count: 10, capacity: 9 });
        let scratch = Scratch::new(&mut order, &mut members, &mut labels, &mut finds);
        assert!(detector.detect(&cloud[..9], scratch, 1).is_ok());
    }
    assert!(detector.detect(&[], Scratch::new(&mut [], &mut [], &mut [], &mut finds), 1).is_ok());
}

#[test]
fn the_largest_cloud_is_searched_and_one_point_more_is_refused() {
    let mut dice = Dice::new("largest cloud", 0);
    let body = Body::jujube(&mut dice, Vector3::new(0.0, 0.0, 700.0));
    let cloud = simulation::surface(&mut dice, &body, MAX_POINTS + 1, 0.0);
    let room = MAX_POINTS + 100;
    let (mut order, mut members, mut labels) = (vec![0; room], vec![0; room], vec![0; room]);
    let mut finds = Finds::new();
    for radius in [f32::INFINITY, 30.0] {
        let detector = Detector::new(Config { radius, ..Config::jujube().paper() }).unwrap();
        let scratch = Scratch::new(&mut order, &mut members, &mut labels, &mut finds);
        let found = detector.detect(&cloud[1..], scratch, 1).unwrap().next().unwrap();
        assert_eq!(found.score.inliers as usize, MAX_POINTS);
        let scratch = Scratch::new(&mut order, &mut members, &mut labels, &mut finds);
        let error = detector.detect(&cloud, scratch, 1).map(|_| ()).unwrap_err();
        assert_eq!(error, CloudError::TooManyPoints { count: 65_536, capacity: 65_535 });
    }
}

#[test]
fn a_bad_configuration_is_refused_with_field_value_and_range() {
    type Set = fn(&mut Config, f32);
    type Spoil = fn(&mut Config);
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
            let mut config = Config::jujube().paper();
            set(&mut config, value);
            let error = Detector::new(config).unwrap_err();
            assert_eq!(error.field, field, "{field} = {value}");
            assert!(error.value == f64::from(value) || (error.value.is_nan() && value.is_nan()));
            let sentence = error.to_string();
            assert!(sentence.starts_with(field) && sentence.contains("it must be"), "{sentence}");
        }
    }
    let counts: [(&str, Spoil, f64); 9] = [
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
        let mut config = Config::jujube().paper();
        spoil(&mut config);
        let ConfigError { field: named, value: given, allowed } = config.check().unwrap_err();
        assert_eq!((named, given), (field, value));
        assert!(!allowed.is_empty());
    }
}
