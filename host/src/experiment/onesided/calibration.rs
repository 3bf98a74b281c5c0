//! Are the 95 % regions right, and what does accepting more or less cost?
//!
//! Coverage is counted over accepted fits: nobody reaches for the others. The gate is not run again for every strictness:
//! its tests are functions of findings that each detection carries ([`Gate::refusal`]), so one search gives the whole curve.

use varsac_core::Gate;

use super::{
    Case, Method, Outcome, WRONG_MM,
    coverage::BLOCKS,
    gates::{PRESETS, Passed, SCALES, scaled},
    listing,
    measure::measure,
    summary::{LEVEL, coverage},
};
use crate::{
    error::InputError,
    experiment::{
        Context, Experiment, Report,
        figure::{Axis, Chart, DARK, Figure, Mark, Series},
        table::{Cell, Column, Table, row},
    },
    synth::onesided::{
        VARIED_JUJUBE, boxy_jujube,
        families::{CLEAN, HARD, OCCLUDED, ORCHARD},
    },
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "calibration",
    purpose: "Coverage of the 95 % regions, and the acceptance and the errors of stricter and looser gates.",
    run,
};

const CASES: [Case; 8] = [
    Case::of(CLEAN),
    Case::of(HARD),
    Case::of(HARD.averaged("hard, pixels average")),
    Case::of(OCCLUDED),
    Case::of(ORCHARD.averaged("orchard, pixels average")),
    Case::of(HARD.of("exponent 2.5", boxy_jujube(2.5))),
    Case::of(HARD.of("exponent 3", boxy_jujube(3.0))),
    Case::of(HARD.of("sizes +-15 %", VARIED_JUJUBE)).spread(0.15),
];

/// Nominal levels of the curves of coverage.
const LEVELS: [f64; 13] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99];

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(800);
    let measured = measure(context, &CASES, &Method::OURS, &seeds);
    let gate_seeds = context.seeds(5000);
    let gated = measure(context, &[Case::of(ORCHARD)], &Method::OURS, &gate_seeds).concat();
    let (gates, gate_chart, mut findings) = gates(&gated);
    let mut wrong = listing::table("Accepted and wrong on mixed views");
    for (method, outcomes) in Method::OURS.iter().zip(&gated) {
        listing::list(&mut wrong, &Case::of(ORCHARD), *method, outcomes);
    }
    findings.extend(CASES.iter().zip(&measured).filter_map(|(case, by_method)| {
        let [outline, cloud] = [0, 1].map(|k| coverage(&by_method[k], LEVEL));
        let show = |c: [f64; 3]| c.map(|share| format!("{:.1}", 100.0 * share)).join(", ");
        let (outline, cloud) = (show(outline?), show(cloud?));
        Some(format!(
            "{}: the 95 % regions of centre, sizes and long axis hold the truth in {outline} % of the accepted fits with outlines, \
             {cloud} % from the cloud alone.",
            case.name
        ))
    }));
    let caption = "Nominal against counted coverage of accepted fits from the cloud alone; on the line the covariance is right, above \
                   it is too careful.";
    Ok(Report {
        findings,
        tables: vec![coverage_table(&measured), gates, wrong],
        figures: vec![
            Figure::charts("coverage", caption, coverage_charts(&measured)),
            Figure::charts(
                "gates",
                format!(
                    "Every limit of the gate scaled by {:.1} (left) to {:.1} (right), on mixed views; the least share that {} \
                     scenes can show is one in all accepted.",
                    SCALES[0],
                    SCALES[SCALES.len() - 1],
                    gate_seeds.len()
                ),
                vec![gate_chart],
            ),
        ],
    })
}

fn coverage_table(measured: &[Vec<Vec<Outcome>>]) -> Table {
    let columns = vec![
        Column::new("case", "scenes", 0),
        Column::new("method", "method", 0),
        Column::new("accepted", "accepted fits", 0),
        Column::new("centre_percent", "centre %", 1),
        Column::new("sizes_percent", "sizes %", 1),
        Column::new("axis_percent", "long axis %", 1),
        Column::new("error_percent", "statistical error %", 1),
    ];
    let mut table = Table::new("Truth within the 95 % region, % of the accepted fits", columns);
    for (case, by_method) in CASES.iter().zip(measured) {
        for (method, outcomes) in Method::OURS.iter().zip(by_method) {
            let accepted = outcomes.iter().filter(|outcome| outcome.accepted().is_some()).count();
            let mut cells: Vec<Cell> = row![case.name, method.name(), accepted];
            let shares = coverage(outcomes, LEVEL);
            cells.extend([0, 1, 2].map(|block| Cell::from(shares.map(|s| 100.0 * s[block]))));
            // Standard deviation of a share that is LEVEL.
            let error = libm::sqrt(LEVEL * (1.0 - LEVEL) / accepted as f64);
            cells.push((100.0 * error).into());
            table.push(cells);
        }
    }
    table
}

fn coverage_charts(measured: &[Vec<Vec<Outcome>>]) -> Vec<Chart> {
    let cloud = Method::OURS.iter().position(|&method| method == Method::Cloud).unwrap_or(0);
    let of_block = |(block, name): (usize, &&str)| {
        let ideal = Series::new("right", Mark::Dashed, DARK, vec![[0.0, 0.0], [1.0, 1.0]]);
        let curves = CASES.iter().zip(measured).take(DARK).enumerate().map(|(place, (case, by_method))| {
            let at = |&level: &f64| Some([level, coverage(&by_method[cloud], level)?[block]]);
            Series::new(case.name, Mark::Line, place, LEVELS.iter().filter_map(at).collect())
        });
        Chart {
            title: format!("Coverage: {name}"),
            x: Axis::linear("nominal").within(0.0, 1.0),
            y: Axis::linear("counted").within(0.0, 1.0),
            series: std::iter::once(ideal).chain(curves).collect(),
        }
    };
    BLOCKS.iter().enumerate().map(of_block).collect()
}

/// Acceptance of the presets and over strictness: table, chart, findings.
fn gates(by_method: &[Vec<Outcome>]) -> (Table, Chart, Vec<String>) {
    let columns = vec![
        Column::new("method", "method", 0),
        Column::new("gate", "gate", 0),
        Column::new("scenes", "scenes", 0),
        Column::new("accepted_percent", "subject accepted %", 1),
        Column::new("accepted_detections", "accepted in all", 0),
        Column::new("wrong", "wrong", 0),
        Column::new("wrong_percent", "wrong %", 2),
        Column::new("far", "far", 0),
    ];
    let mut table = Table::new("Gates on mixed views (orchard)", columns);
    let (mut series, mut findings) = (Vec::new(), Vec::new());
    for (place, (method, outcomes)) in Method::OURS.iter().zip(by_method).enumerate() {
        let mut tell = |name: &str, gate: &Gate| {
            let passed = Passed::of(outcomes, gate);
            let Passed { accepted, wrong, far, .. } = passed;
            let share = 100.0 * passed.subjects as f64 / outcomes.len() as f64;
            let wrong_share = (accepted > 0).then(|| 100.0 * wrong as f64 / accepted as f64);
            table.push(row![method.name(), name, outcomes.len(), share, accepted, wrong, wrong_share, far]);
            (share, wrong_share, passed)
        };
        for (name, gate) in PRESETS {
            let (share, _, Passed { accepted, wrong, .. }) = tell(name, &gate);
            findings.push(format!(
                "Gate {name}, {}: {share:.1} % of {} subjects accepted, {wrong} of {accepted} accepted detections wrong.",
                method.name(),
                outcomes.len()
            ));
        }
        let curve: Vec<[f64; 2]> = SCALES
            .iter()
            .filter_map(|&scale| {
                let (share, wrong, _) = tell(&format!("limits times {scale}"), &scaled(scale));
                Some([share, wrong?])
            })
            .collect();
        series.push(Series::new(method.name(), Mark::Line, place, curve.clone()));
        series.push(Series::new("", Mark::Dots, place, curve));
    }
    let chart = Chart {
        title: format!("Accepted detections off by more than {WRONG_MM} mm, over acceptance"),
        x: Axis::linear("accepted %"),
        y: Axis::linear("wrong %"),
        series,
    };
    (table, chart, findings)
}
