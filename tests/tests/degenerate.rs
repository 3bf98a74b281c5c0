//! Every bad input of the core, and thousands of hostile ones: an error that names what is wrong, or a run that ends
//! within its published bound with nothing but valid detections. Dev builds check every integer operation on the way.

#[path = "degenerate/clouds.rs"]
mod clouds;
#[path = "degenerate/door.rs"]
mod door;
#[path = "degenerate/storm.rs"]
mod storm;

use varsac_core::{Config, Detection, Detector, Finish, Point3, Step, VarsacReport, Workspace};
use varsac_tests::bound;

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
                let claimed = detections.labels().iter().map(|&label| u32::from(label == detection.target));
                assert_eq!(claimed.sum::<u32>(), detection.score.inliers);
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
