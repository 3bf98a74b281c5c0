//! The whole search in `f32` against its twin in 64 bits, on one-sided views: same draws, same events, other rounding.

use varsac_core::{Config, Constraint, Detection, Detector, Point3, Workspace};
use varsac_tests::{
    body::wide,
    random::Dice,
    scene::{Trouble, View},
    statistics::Sample,
    tolerance as limit, twin,
};

/// The targets of a run and the points of each.
fn detections(config: &Config, cloud: &[Point3], seed: u64) -> Vec<(Detection, Vec<u16>)> {
    let detector = Detector::new(config.clone()).unwrap();
    let mut workspace = Workspace::<4096>::new();
    let mut run = detector.detect(cloud, workspace.scratch(), seed).unwrap();
    let found: Vec<Detection> = run.by_ref().collect();
    let of = |target: u8| {
        let labels = run.labels().iter().enumerate();
        labels.filter(|&(_, &label)| label == target).map(|(index, _)| index as u16).collect()
    };
    found.iter().map(|&detection| (detection, of(detection.target))).collect()
}

/// Figures of one family of views.
#[derive(Default)]
struct Figures {
    /// 1 for a view where both find the same targets with the same points, 0 otherwise.
    same: Sample,
    /// Distance between the centres of targets with the same number; infinite where one side has none.
    centre: Sample,
    /// 1 where both needed as many trials.
    trials: Sample,
    /// Views where both find nothing.
    empty: u32,
}

fn compare(name: &str, config: &Config, trouble: &Trouble, views: u64) -> Figures {
    let mut figures = Figures::default();
    for case in 0..views {
        let mut dice = Dice::new(name, case);
        let view = View::jujube(&mut dice, trouble);
        let seed = dice.bits();
        let ours = detections(config, &view.cloud, seed);
        let judge = twin::search(config, &view.cloud, seed);
        let same = ours.len() == judge.len() && ours.iter().zip(&judge).all(|(a, b)| a.1 == b.inliers);
        figures.same.push(f64::from(u8::from(same)));
        figures.empty += u32::from(ours.is_empty() && judge.is_empty());
        for k in 0..ours.len().max(judge.len()) {
            let (Some((detection, _)), Some(target)) = (ours.get(k), judge.get(k)) else {
                figures.centre.push(f64::INFINITY);
                continue;
            };
            figures.centre.push((wide(&detection.ellipsoid.centre) - target.surface.centre).norm());
            figures.trials.push(f64::from(u8::from(detection.report.trials == target.trials)));
        }
    }
    figures
}

/// Compares and prints one family, and holds it to the limits.
fn hold(name: &str, config: &Config, trouble: &Trouble, views: u64) {
    let figures = compare(name, config, trouble, views);
    let share = |sample: &Sample| sample.share_above(0.5);
    let Figures { same, centre, trials, empty } = &figures;
    println!(
        "{name}: {views} views, nothing in {empty}; as many trials {:.4}; centre {}",
        share(trials),
        centre.summary()
    );
    limit::SEARCH_SAME.check_for(name, share(same));
    limit::SEARCH_CENTRE.check_for(name, centre.quantile(0.99));
}

const NOISY: Trouble = Trouble { axial_noise_mm: 1.3, outlier_share: 0.0, neighbour: false, leaf: false };
const CLUTTERED: Trouble = Trouble { outlier_share: 0.3, ..NOISY };

fn first(config: Config) -> Config {
    Config { max_targets: 1, ..config }
}

#[test]
fn f32_and_f64_find_the_same_in_plain_views() {
    let config = first(Config::jujube().paper());
    hold("clean", &config, &Trouble::default(), 400);
    hold("noise 0.3 mm", &config, &Trouble { axial_noise_mm: 0.3, ..Trouble::default() }, 400);
    hold("noise 1.3 mm", &config, &NOISY, 400);
    hold("noise 1.3 mm, trace", &Config { constraint: Constraint::Trace, ..config }, &NOISY, 400);
}

#[test]
fn f32_and_f64_find_the_same_in_clutter() {
    let config = first(Config::jujube().paper());
    hold("clutter", &config, &CLUTTERED, 200);
    hold("clutter, Table 5", &first(Config::table5()), &CLUTTERED, 150);
    hold("clutter, 10 refits", &Config { refits: 10, ..config }, &CLUTTERED, 150);
    let orchard = Trouble { neighbour: true, leaf: true, axial_noise_mm: 0.5, outlier_share: 0.1 };
    let two = Config { max_targets: 2, min_ratio: 0.3, ..Config::jujube().paper() };
    hold("neighbour and leaf", &two, &orchard, 50);
}
