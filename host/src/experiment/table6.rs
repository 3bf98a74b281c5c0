//! Table 6: jujubes in a tree before a Kinect v2, from colour and depth to ellipsoids, all methods.
//!
//! The paper's recordings are not public, and its truth was measured by hand. Here the frames are rendered, with the
//! sensor's noise, mixed pixels and holes, and the truth is exact; the whole pipeline works on them: hue threshold,
//! regions, registration, back-projection, search. A target is right when its centre is within the short semi-axis of
//! a fruit's; fruit of which less than half can be seen, or fewer than [`LEAST_PX`] depth pixels, need not be found.
//! A target that the default search refuses is neither right nor wrong. Errors are over the fruit that a method found, so that a method that finds little may look good: mind the recall.

use varsac_core::Config;

use super::{
    Context, Experiment, Report,
    figure::{Axis, Chart, Figure, Mark, Series},
    table::{Cell, Column, Table, row},
    trees::{DISTANCES_MM, LEAVES, LIGHTS, Tree, tree},
};
use crate::{
    error::InputError,
    eval::{
        EllipsoidF64,
        attitude::{AxisOrder, EQUAL_AXES_RATIO, angles_of_axes, axis_error_deg},
        criteria::{Criteria, FruitErrors},
        matching::match_centres,
        norm,
        statistics::{mean_and_deviation, quantile},
        subtract,
    },
    fruit::Fruit,
    locate::{Located, Method, Options, RegionSource, locate_frame},
    segment::preset,
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "table6",
    purpose: "Rendered Kinect v2 frames of jujubes in a tree, the whole pipeline: all methods, all criteria, recall.",
    run,
};

/// Farther centres are false targets, millimetres: the short semi-axis.
const GATE_MM: f64 = 11.0;
/// A refused target whose centre is this near to a fruit's was refused wrongly, millimetres.
const RIGHT_MM: f64 = 5.0;
/// Fruit of which less can be seen need not be found.
const LEAST_VISIBLE: f64 = 0.5;
/// Fruit that fill fewer pixels of the depth image need not be found.
const LEAST_PX: u32 = 40;

/// A method with what it is told. To add one, add a line to [`contenders`].
struct Contender {
    name: &'static str,
    method: Method,
    config: Config,
}

fn contenders() -> Vec<Contender> {
    let contender = |name, method, config| Contender { name, method, config };
    vec![
        contender("direct", Method::Direct, Config::table5()),
        contender("RANSAC, Table 5", Method::Ransac, Config::table5()),
        contender("VARSAC+TEBC, Table 5", Method::Varsac, Config::table5()),
        contender("VARSAC+TEBC, our preset", Method::Varsac, Fruit::Jujube.config().paper()),
        contender("default", Method::Map, Fruit::Jujube.config()),
    ]
}

/// Method, score %, RMS-c mm, RMS-s mm, RMS-a rad, iterations, milliseconds a fruit, as printed.
const PRINTED: [(&str, [f64; 6]); 3] = [
    ("direct (paper)", [100.0, 4.34, 7.13, 0.53, 1.0, 11.0]),
    ("RANSAC (paper)", [60.3, 2.09, 2.96, 0.50, 303.0, 2310.0]),
    ("VARSAC+TEBC (paper)", [77.4, 1.80, 1.21, 0.46, 147.0, 588.0]),
];

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(36);
    let contenders = contenders();
    let frames = context.each(&seeds, |&seed| {
        let tree = tree(seed);
        let outcomes: Result<Vec<Outcome>, InputError> =
            contenders.iter().map(|contender| outcome(contender, &tree, seed)).collect();
        outcomes.map(|outcomes| ([tree.distance, tree.light, tree.leaves], outcomes))
    });
    let frames = frames.into_iter().collect::<Result<Vec<_>, _>>()?;

    let mut table = Table::new(format!("Table 6: {} rendered frames", frames.len()), columns("method"));
    for (name, [score, c, s, a, trials, fruit_ms]) in PRINTED {
        let none = || Cell::Missing;
        table.push(row![
            name,
            none(),
            none(),
            none(),
            none(),
            none(),
            score,
            c,
            none(),
            s,
            none(),
            a,
            trials,
            fruit_ms,
            none()
        ]);
    }
    let mut all = Vec::new();
    for (k, contender) in contenders.iter().enumerate() {
        let total = frames.iter().fold(Outcome::default(), |sum, (_, outcomes)| sum.and(&outcomes[k]));
        table.push(total.cells(contender.name));
        all.push(total);
    }
    let ours = contenders.len() - 1;
    let conditions = by_condition(contenders[ours].name, &frames, ours);
    let refusals = refusals(contenders[ours].name, &all[ours]);
    let findings = findings(&contenders, &all);
    Ok(Report {
        findings,
        tables: vec![table, conditions, refusals],
        figures: vec![figure(&contenders, &frames)],
    })
}

fn columns(first: &'static str) -> Vec<Column> {
    vec![
        Column::new(first, first, 0),
        Column::new("visible_fruit", "visible fruit", 0),
        Column::new("recall_percent", "recall %", 1),
        Column::new("false_targets", "false targets a frame", 2),
        Column::new("refused", "refused a frame", 2),
        Column::new("recall_ungated_percent", "recall with refused %", 1),
        Column::new("score_percent", "score %", 1),
        Column::new("rms_c_mm", "RMS-c mm", 2),
        Column::new("centre_median_mm", "centre, median mm", 2),
        Column::new("rms_s_mm", "RMS-s mm", 2),
        Column::new("axis_median_deg", "long axis, median deg", 1),
        Column::new("rms_a_rad", "RMS-a rad", 2),
        Column::new("trials", "iterations, mean", 0),
        Column::new("fruit_ms", "time a target ms", 2),
        Column::new("frame_ms", "time a frame ms", 1),
    ]
}

/// What became of some frames with one method.
#[derive(Debug, Clone, Default)]
struct Outcome {
    frames: usize,
    /// Fruit that ought to be found, and those of them that were.
    visible: usize,
    found: usize,
    false_targets: usize,
    /// Of each refused target why, and whether its centre is that of a fruit nevertheless.
    refused: Vec<(&'static str, bool)>,
    /// Fruit found when refused targets count.
    found_ungated: usize,
    errors: Vec<FruitErrors>,
    /// Distances of centres, millimetres, and angles between long axes, degrees.
    centres_mm: Vec<f64>,
    axes_deg: Vec<f64>,
    /// Trials of each target, right or wrong.
    trials: Vec<f64>,
    /// Wall clock of the frames.
    elapsed_ms: Vec<f64>,
}

/// Runs one method on one frame and holds the result against the truth.
fn outcome(contender: &Contender, tree: &Tree, seed: u64) -> Result<Outcome, InputError> {
    let colour = RegionSource::Colour(preset(Fruit::Jujube.name()));
    let options =
        Options { method: contender.method, ..Options::new(contender.config.clone(), colour, seed) };
    Ok(judged(&locate_frame("table6", &tree.frame, &options)?, tree))
}

fn judged(located: &Located, tree: &Tree) -> Outcome {
    let targets: Vec<_> = located.targets.iter().filter(|target| target.refusal.is_none()).collect();
    let truths: Vec<EllipsoidF64> = tree.fruit.iter().map(|fruit| fruit.ellipsoid).collect();
    let fits: Vec<EllipsoidF64> =
        targets.iter().map(|target| EllipsoidF64::from(&target.ellipsoid)).collect();
    let centres = |list: &[EllipsoidF64]| list.iter().map(|e| e.centre_mm).collect::<Vec<_>>();
    let matching = match_centres(&centres(&truths), &centres(&fits), GATE_MM);
    let is_visible = |k: usize| {
        let fruit = &tree.fruit[k];
        fruit.visible_fraction >= LEAST_VISIBLE && fruit.visible_px >= LEAST_PX
    };
    let everything: Vec<[f64; 3]> =
        located.targets.iter().map(|target| EllipsoidF64::from(&target.ellipsoid).centre_mm).collect();
    let ungated = match_centres(&centres(&truths), &everything, GATE_MM);
    let refused = located.targets.iter().zip(&everything).filter_map(|(target, &centre)| {
        let is_right = truths.iter().any(|truth| norm(subtract(truth.centre_mm, centre)) <= RIGHT_MM);
        target.refusal.map(|refusal| (refusal.code, is_right))
    });
    let mut outcome = Outcome {
        frames: 1,
        visible: (0..truths.len()).filter(|&k| is_visible(k)).count(),
        found: matching.matches.iter().filter(|pair| is_visible(pair.truth)).count(),
        false_targets: matching.false_detections.len(),
        refused: refused.collect(),
        found_ungated: ungated.matches.iter().filter(|pair| is_visible(pair.truth)).count(),
        trials: targets.iter().map(|target| f64::from(target.trials)).collect(),
        elapsed_ms: vec![located.elapsed.as_secs_f64() * 1e3],
        ..Outcome::default()
    };
    for pair in &matching.matches {
        let (truth, fit, target) = (&truths[pair.truth], &fits[pair.detection], targets[pair.detection]);
        let (inliers, total) = (target.score.inliers as usize, target.score.candidates as usize);
        let angles = angles_of_axes(&truth.axes);
        outcome.errors.push(FruitErrors::of(truth, angles, AxisOrder::Descending, fit, inliers, total));
        outcome.centres_mm.push(pair.distance_mm);
        outcome.axes_deg.extend(axis_error_deg(truth, fit, EQUAL_AXES_RATIO));
    }
    outcome
}

impl Outcome {
    /// Of these frames and those.
    fn and(mut self, other: &Self) -> Self {
        self.frames += other.frames;
        self.visible += other.visible;
        self.found += other.found;
        self.false_targets += other.false_targets;
        self.refused.extend(&other.refused);
        self.found_ungated += other.found_ungated;
        self.errors.extend(&other.errors);
        self.centres_mm.extend(&other.centres_mm);
        self.axes_deg.extend(&other.axes_deg);
        self.trials.extend(&other.trials);
        self.elapsed_ms.extend(&other.elapsed_ms);
        self
    }

    fn recall(&self) -> Option<f64> {
        (self.visible > 0).then(|| self.found as f64 / self.visible as f64)
    }

    fn false_a_frame(&self) -> f64 {
        self.false_targets as f64 / self.frames.max(1) as f64
    }

    fn cells(&self, name: &str) -> Vec<Cell> {
        let criteria = Criteria::of(&self.errors);
        let median = |values: &[f64]| {
            let mut values = values.to_vec();
            values.sort_by(f64::total_cmp);
            quantile(&values, 0.5)
        };
        let total_ms: f64 = self.elapsed_ms.iter().sum();
        row![
            name,
            self.visible,
            self.recall().map(|recall| 100.0 * recall),
            self.false_a_frame(),
            self.refused.len() as f64 / self.frames.max(1) as f64,
            (self.visible > 0).then(|| 100.0 * self.found_ungated as f64 / self.visible as f64),
            criteria.map(|c| 100.0 * c.model_score),
            criteria.map(|c| c.rms_centre_mm),
            median(&self.centres_mm),
            criteria.map(|c| c.rms_size_mm),
            median(&self.axes_deg),
            criteria.map(|c| c.rms_attitude_rad),
            mean_and_deviation(&self.trials).map(|(mean, _)| mean),
            total_ms / self.trials.len() as f64,
            median(&self.elapsed_ms),
        ]
    }
}

type Frames = [([usize; 3], Vec<Outcome>)];

/// The outcome of contender `k` over the frames that a condition holds for.
fn of_frames(frames: &Frames, k: usize, holds: impl Fn(&[usize; 3]) -> bool) -> Outcome {
    let chosen = frames.iter().filter(|(conditions, _)| holds(conditions));
    chosen.fold(Outcome::default(), |sum, (_, outcomes)| sum.and(&outcomes[k]))
}

fn by_condition(name: &str, frames: &Frames, k: usize) -> Table {
    let mut table = Table::new(format!("{name} by distance, light and leaves"), columns("condition"));
    for (place, (near, far)) in DISTANCES_MM.iter().enumerate() {
        let outcome = of_frames(frames, k, |conditions| conditions[0] == place);
        table.push(outcome.cells(&format!("{:.2} to {:.2} m", near / 1e3, far / 1e3)));
    }
    for (place, (light, _)) in LIGHTS.iter().enumerate() {
        table.push(of_frames(frames, k, |conditions| conditions[1] == place).cells(light));
    }
    for (place, leaves) in LEAVES.iter().enumerate() {
        let outcome = of_frames(frames, k, |conditions| conditions[2] == place);
        table.push(outcome.cells(&format!("{leaves} leaves before fruit")));
    }
    table
}

/// Why targets are refused, in the order of the alphabet.
fn refusals(name: &str, outcome: &Outcome) -> Table {
    let mut table = Table::new(
        format!("{name}: refused targets"),
        vec![
            Column::new("reason", "reason", 0),
            Column::new("targets", "targets", 0),
            Column::new("right", format!("of them within {RIGHT_MM} mm of a fruit"), 0),
        ],
    );
    let mut counts = std::collections::BTreeMap::new();
    for &(code, is_right) in &outcome.refused {
        let (targets, right) = counts.entry(code).or_insert((0_usize, 0_usize));
        *targets += 1;
        *right += usize::from(is_right);
    }
    for (code, (targets, right)) in counts {
        table.push(row![code, targets, right]);
    }
    table
}

/// Recall over distance, and the distribution of the error of the centre, of every contender.
fn figure(contenders: &[Contender], frames: &Frames) -> Figure {
    let (mut recall, mut errors) = (Vec::new(), Vec::new());
    for (k, contender) in contenders.iter().enumerate() {
        let points = DISTANCES_MM.iter().enumerate().filter_map(|(place, (near, far))| {
            let share = of_frames(frames, k, |conditions| conditions[0] == place).recall()?;
            Some([f64::midpoint(*near, *far) / 1e3, 100.0 * share])
        });
        recall.push(Series::new(contender.name, Mark::Line, k, points.collect()));
        let all = of_frames(frames, k, |_| true);
        let within = |limit: f64| all.centres_mm.iter().filter(|error| **error <= limit).count() as f64;
        let curve = (0..=44).map(|k| f64::from(k) * GATE_MM / 44.0);
        let curve = curve.map(|limit| [limit, 100.0 * within(limit) / all.visible.max(1) as f64]).collect();
        errors.push(Series::new(contender.name, Mark::Line, k, curve));
    }
    let charts = vec![
        Chart {
            title: "Visible fruit found".into(),
            x: Axis::linear("distance m"),
            y: Axis::linear("recall %").within(0.0, 100.0),
            series: recall,
        },
        Chart {
            title: "Fruit whose centre is found within a distance, per visible fruit".into(),
            x: Axis::linear("distance from the true centre mm").within(0.0, GATE_MM),
            y: Axis::linear("%"),
            series: errors,
        },
    ];
    Figure::charts(
        "recall",
        "Left: recall over distance. Right: error of the centre; higher is better.",
        charts,
    )
}

fn findings(contenders: &[Contender], all: &[Outcome]) -> Vec<String> {
    let of = |contender: &Contender, outcome: &Outcome| {
        let criteria = Criteria::of(&outcome.errors);
        format!(
            "{}: recall {:.0} %, {:.1} false targets a frame, RMS-c {:.2} mm, RMS-s {:.2} mm.",
            contender.name,
            100.0 * outcome.recall().unwrap_or(f64::NAN),
            outcome.false_a_frame(),
            criteria.map_or(f64::NAN, |c| c.rms_centre_mm),
            criteria.map_or(f64::NAN, |c| c.rms_size_mm)
        )
    };
    contenders.iter().zip(all).map(|(contender, outcome)| of(contender, outcome)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_truth_itself_would_be_perfect() {
        let tree = tree(1);
        let target = |fruit: &crate::synth::TrueFruit| crate::locate::Target {
            region: 1,
            refusal: None,
            ellipsoid: varsac_core::Ellipsoid::from(&fruit.ellipsoid),
            score: varsac_core::Score { inliers: 9, candidates: 10 },
            trials: 5,
            covariance: None,
        };
        let located = Located {
            input: String::new(),
            name: String::new(),
            method: Method::Varsac,
            seed: 1,
            points: Vec::new(),
            labels: Vec::new(),
            targets: tree.fruit.iter().map(target).collect(),
            learnt_size: None,
            notes: Vec::new(),
            elapsed: std::time::Duration::ZERO,
        };
        let outcome = judged(&located, &tree);
        assert!(outcome.visible > 3 && outcome.recall() == Some(1.0) && outcome.false_targets == 0);
        let criteria = Criteria::of(&outcome.errors).unwrap();
        assert!(criteria.rms_centre_mm < 1e-3 && criteria.rms_attitude_rad < 1e-3, "{criteria:?}");
        // Nothing found: nothing right, nothing wrong.
        let empty = judged(&Located { targets: Vec::new(), ..located }, &tree);
        assert_eq!((empty.recall(), empty.false_targets), (Some(0.0), 0));
    }
}
