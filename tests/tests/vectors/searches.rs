//! Vectors of whole searches, and the digest of a check.

use crate::format::{Case, check_file};
use crate::{points_read, view};
use varsac_core::{Config, Detector, Finds, Scratch};
use varsac_host::check::{self, Options};
use varsac_reference as reference;

#[test]
fn whole_searches() {
    let jujube = Config::jujube().paper();
    let config = check::reference_config(&jujube);
    let mut stream = reference::Stream::seeded(8);
    let cases = [1, 2].map(|seed| {
        let points = view(&mut stream, 60);
        let run = reference::run(&points, &config, seed).expect("a valid cloud");
        let found = run.detections.first().expect("a jujube");
        let e = &found.ellipsoid;
        Case::default()
            .floats("points", points.as_flattened())
            .integers("seed", [seed as u32])
            .floats("centre", &e.centre)
            .floats("semi_axes", &e.semi_axes)
            .floats("axes", e.axes.as_flattened())
            .floats("quaternion_xyzw", &e.quaternion)
            .floats("angles_xyz", &e.angles)
            .integers("score", [found.score.inliers, found.score.candidates])
            .integers("trials", [found.report.trials])
            .integers("labels", run.labels.iter().map(|&label| u32::from(label)))
    });
    let what =
        "Chapters 9 and 10, the preset jujube: points, seed, the first detection, the labels at the end.";
    check_file("searches", what, &cases, |case| {
        let cloud = points_read(case);
        let (mut order, mut members, mut labels) = (vec![0; 60], vec![0; 60], vec![0; 60]);
        let detector = Detector::new(jujube.clone()).expect("a preset");
        let mut finds = Finds::new();
        let scratch = Scratch::new(&mut order, &mut members, &mut labels, &mut finds);
        let mut run = detector.detect(&cloud, scratch, u64::from(case.word("seed"))).expect("a valid cloud");
        let found = run.next().expect("a jujube");
        while run.next().is_some() {}
        let e = &found.ellipsoid;
        case.expect_floats("centre", &[e.centre.x, e.centre.y, e.centre.z]);
        case.expect_floats("semi_axes", &e.semi_axes);
        case.expect_floats("axes", e.axes.as_flattened());
        case.expect_floats("quaternion_xyzw", &e.quaternion_xyzw());
        case.expect_floats("angles_xyz", &e.attitude_rad());
        case.expect_integers("score", &[found.score.inliers, found.score.candidates]);
        case.expect_integers("trials", &[found.report.trials]);
        case.expect_integers("labels", &run.labels().iter().map(|&l| u32::from(l)).collect::<Vec<_>>());
    });
}

/// One number for some thousands of fits of all families. Every build must arrive at it: debug, release, with the
/// instructions of any processor, on any number of threads.
#[test]
fn digest_of_a_check() {
    let outcome = check::run(&Options { cases: 200, seed: 1, ..Options::default() });
    assert_eq!(outcome.difference, None);
    let halves = |digest: u64| [digest as u32, (digest >> 32) as u32];
    let case = Case::default()
        .integers("seed", [1])
        .integers("cases", [200])
        .integers("fits", [outcome.fits() as u32])
        .integers("digest", halves(outcome.digest));
    let what = "All stages: the digest (low word first) of `varsac check --seed 1 --cases 200`.";
    check_file("check", what, &[case], |case| case.expect_integers("digest", &halves(outcome.digest)));
}
