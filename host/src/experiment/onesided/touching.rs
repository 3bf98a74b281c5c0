//! Two to four fruit that touch: how many are found, how many accepted, and is anything accepted that is not there?
//!
//! A true fruit counts when at least 40 % of it is to be seen. Detections and fruit are matched one to one, the closest pair
//! first, within 5 mm ([`match_centres`]): *recall* is the share of fruit with a detection, *accepted recall* with an
//! accepted one. An accepted detection is *wrong* when no fruit's centre is within 5 mm, *false* when none is within
//! its short semi-axis, *double* when the fruit near it has a closer detection.

use super::{
    Case, Method, WRONG_MM,
    measure::{distance_mm, each},
    methods::Target,
};
use crate::{
    error::InputError,
    eval::{matching::match_centres, statistics::Distribution},
    experiment::{
        Context, Experiment, Report,
        figure::{Axis, Chart, Figure, Mark, Series},
        table::{Cell, Column, Table, row},
    },
    synth::onesided::{
        Scene,
        families::{TOUCHING, TOUCHING_LEAVES},
    },
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "touching",
    purpose: "Two to four touching fruit, with and without leaves: recall, false targets, errors, time.",
    run,
};

const CASES: [Case; 4] = [
    Case::of(TOUCHING),
    Case::of(TOUCHING.averaged("touching, pixels average")),
    Case::of(TOUCHING_LEAVES),
    Case::of(TOUCHING_LEAVES.averaged("touching, leaves, pixels average")),
];

/// Visible share from which on a fruit is to be found.
const SEEN: f64 = 0.4;

/// What a method made of one bunch.
#[derive(Debug, Clone, PartialEq)]
struct Bunch {
    /// Fruit in the scene.
    size: usize,
    /// Those to be found.
    fruit: usize,
    /// Centre errors of those found, mm.
    errors_mm: Vec<f64>,
    /// Those found and accepted.
    accepted_fruit: usize,
    /// Accepted detections.
    accepted: usize,
    /// Of them wrong, false, double.
    wrong: usize,
    false_targets: usize,
    double: usize,
    micros: f64,
}

impl Bunch {
    fn of(scene: &Scene, targets: &[Target], micros: f64) -> Self {
        let truths: Vec<[f64; 3]> = scene.fruit.iter().map(|truth| truth.ellipsoid.centre_mm).collect();
        let found: Vec<[f64; 3]> = targets.iter().map(|target| target.ellipsoid.centre_mm).collect();
        let matching = match_centres(&truths, &found, WRONG_MM);
        let seen: Vec<_> =
            matching.matches.iter().filter(|pair| scene.fruit[pair.truth].visible >= SEEN).collect();
        let accepted = || targets.iter().enumerate().filter(|(_, target)| target.refusal.is_none());
        let nearest = |target: &Target| {
            let distances = scene.fruit.iter().map(|truth| {
                let distance = distance_mm(&target.ellipsoid, &truth.ellipsoid);
                (distance, distance > truth.ellipsoid.semi_axes_mm[2])
            });
            distances.min_by(|p, q| p.0.total_cmp(&q.0)).unwrap_or((f64::INFINITY, true))
        };
        let unmatched = |k: usize| matching.false_detections.contains(&k);
        Self {
            size: scene.fruit.len(),
            fruit: scene.fruit.iter().filter(|truth| truth.visible >= SEEN).count(),
            errors_mm: seen.iter().map(|pair| pair.distance_mm).collect(),
            accepted_fruit: seen.iter().filter(|pair| targets[pair.detection].refusal.is_none()).count(),
            accepted: accepted().count(),
            wrong: accepted().filter(|(_, target)| nearest(target).0 > WRONG_MM).count(),
            false_targets: accepted().filter(|(_, target)| nearest(target).1).count(),
            double: accepted().filter(|&(k, target)| unmatched(k) && nearest(target).0 <= WRONG_MM).count(),
            micros,
        }
    }
}

/// Figures of many bunches by one method.
#[derive(Debug, Clone, PartialEq)]
pub struct Bunches {
    /// Scenes.
    pub scenes: usize,
    /// Fruit to be found.
    pub fruit: usize,
    /// Share of them with a detection within 5 mm, accepted or not.
    pub recall: f64,
    /// Share of them with an accepted one.
    pub accepted_recall: f64,
    /// Accepted detections.
    pub accepted: usize,
    /// Those without a fruit's centre within 5 mm.
    pub wrong: usize,
    /// Those without one within its short semi-axis.
    pub false_targets: usize,
    /// Those whose fruit has a closer detection.
    pub double: usize,
    /// Centre errors of the fruit found; nothing when none were.
    pub centre: Option<Distribution>,
    /// Median of the time per scene, microseconds.
    pub time_us: f64,
}

impl Bunches {
    fn of<'a>(bunches: impl Iterator<Item = &'a Bunch>) -> Self {
        let bunches: Vec<&Bunch> = bunches.collect();
        let sum = |of: fn(&Bunch) -> usize| bunches.iter().map(|bunch| of(bunch)).sum::<usize>();
        let errors: Vec<f64> = bunches.iter().flat_map(|bunch| &bunch.errors_mm).copied().collect();
        let times: Vec<f64> = bunches.iter().map(|bunch| bunch.micros).collect();
        let fruit = sum(|bunch| bunch.fruit);
        Self {
            scenes: bunches.len(),
            fruit,
            recall: errors.len() as f64 / fruit as f64,
            accepted_recall: sum(|bunch| bunch.accepted_fruit) as f64 / fruit as f64,
            accepted: sum(|bunch| bunch.accepted),
            wrong: sum(|bunch| bunch.wrong),
            false_targets: sum(|bunch| bunch.false_targets),
            double: sum(|bunch| bunch.double),
            centre: Distribution::of(&errors),
            time_us: Distribution::of(&times).map_or(f64::NAN, |time| time.median),
        }
    }
}

/// Figures by case and method.
pub fn bunches(context: &Context, cases: &[Case], methods: &[Method], seeds: &[u64]) -> Vec<Vec<Bunches>> {
    let measured = measure(context, cases, methods, seeds);
    measured.iter().map(|by_method| by_method.iter().map(|list| Bunches::of(list.iter())).collect()).collect()
}

fn measure(context: &Context, cases: &[Case], methods: &[Method], seeds: &[u64]) -> Vec<Vec<Vec<Bunch>>> {
    each(context, cases, methods, seeds, |scene, targets, _, micros| Bunch::of(scene, targets, micros))
}

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(120);
    let mut table = Table::new(format!("{} bunches of each kind", seeds.len()), columns("case", "scenes"));
    let mut slices =
        Table::new("The same by number of fruit, all kinds of scenes together", columns("size", "fruit"));
    let mut findings = Vec::new();
    let mut curves: Vec<Vec<[f64; 2]>> = vec![Vec::new(); Method::ALL.len()];
    let measured = measure(context, &CASES, &Method::ALL, &seeds);
    for (case, by_method) in CASES.iter().zip(&measured) {
        for (method, bunches) in Method::ALL.iter().zip(by_method) {
            let all = Bunches::of(bunches.iter());
            table.push(cells(case.name.into(), *method, &all));
            if Method::OURS.contains(method) {
                findings.push(format!(
                    "{}, {}: of {} fruit {:.1} % found, {:.1} % found and accepted; of {} accepted detections {} wrong, {} false, {} \
                     double.",
                    case.name,
                    method.name(),
                    all.fruit,
                    100.0 * all.recall,
                    100.0 * all.accepted_recall,
                    all.accepted,
                    all.wrong,
                    all.false_targets,
                    all.double
                ));
            }
        }
    }
    for size in 2..=4 {
        for (place, method) in Method::ALL.iter().enumerate() {
            let of_size = measured.iter().flat_map(|by_method| &by_method[place]).filter(|b| b.size == size);
            let slice = Bunches::of(of_size);
            if slice.fruit > 0 {
                curves[place].push([size as f64, 100.0 * slice.accepted_recall]);
                slices.push(cells(size.into(), *method, &slice));
            }
        }
    }
    let series = Method::ALL
        .iter()
        .zip(curves)
        .enumerate()
        .map(|(place, (method, points))| Series::new(method.name(), Mark::Line, place, points));
    let chart = Chart {
        title: "Accepted recall over the number of touching fruit".into(),
        x: Axis::linear("fruit"),
        y: Axis::linear("%").within(0.0, 100.0),
        series: series.collect(),
    };
    Ok(Report {
        findings,
        tables: vec![table, slices],
        figures: vec![Figure::charts("recall", "All four kinds of scenes together.", vec![chart])],
    })
}

fn columns(key: &'static str, heading: &str) -> Vec<Column> {
    vec![
        Column::new(key, heading, 0),
        Column::new("method", "method", 0),
        Column::new("scenes", "number", 0),
        Column::new("fruit", "to be found", 0),
        Column::new("recall_percent", "recall %", 1),
        Column::new("accepted_recall_percent", "accepted recall %", 1),
        Column::new("accepted", "accepted", 0),
        Column::new("wrong", "wrong", 0),
        Column::new("false_targets", "false", 0),
        Column::new("double", "double", 0),
        Column::new("centre_median_mm", "centre median mm", 2),
        Column::new("centre_p90_mm", "90 %", 2),
        Column::new("time_us", "time per scene us", 0),
    ]
}

fn cells(first: Cell, method: Method, figures: &Bunches) -> Vec<Cell> {
    let mut cells = vec![first];
    cells.extend(row![
        method.name(),
        figures.scenes,
        figures.fruit,
        100.0 * figures.recall,
        100.0 * figures.accepted_recall,
        figures.accepted,
        figures.wrong,
        figures.false_targets,
        figures.double,
        figures.centre.map(|centre| centre.median),
        figures.centre.map(|centre| centre.p90),
        figures.time_us,
    ]);
    cells
}
