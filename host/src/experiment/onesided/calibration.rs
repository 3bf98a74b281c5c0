//! Are the 95 % regions right, and what does accepting more or less cost?
//!
//! Coverage is counted over accepted fits: nobody reaches for the others. The gate is not run again for every strictness:
//! its tests are functions of findings that each detection carries ([`Gate::refusal`]), so one search gives the whole curve.

use varsac_core::Gate;

use super::{
    Case, Method, Outcome, WRONG_MM,
    coverage::BLOCKS,
    measure::{gate, measure},
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

/// Strictness: limits are multiplied by it; 1 is the gate in force.
const SCALES: [f64; 9] = [0.4, 0.5, 0.65, 0.8, 1.0, 1.25, 1.6, 2.0, 3.0];
/// Nominal levels of the curves of coverage.
const LEVELS: [f64; 13] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98, 0.99];

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(800);
    let measured = measure(context, &CASES, &Method::OURS, &seeds);
    let gate_seeds = context.seeds(5000);
    let gated = measure(context, &[Case::of(ORCHARD)], &Method::OURS, &gate_seeds).concat();
    let (gates, gate_chart, mut findings) = gates(&gated);
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
        tables: vec![coverage_table(&measured), gates],
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

/// Acceptance over strictness: table, chart, findings.
fn gates(by_method: &[Vec<Outcome>]) -> (Table, Chart, Vec<String>) {
    let columns = vec![
        Column::new("method", "method", 0),
        Column::new("scale", "limits times", 2),
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
        let mut curve = Vec::new();
        for scale in SCALES {
            let Strictness { subjects, accepted, wrong, far } = Strictness::of(outcomes, &scaled(scale));
            let share = 100.0 * subjects as f64 / outcomes.len() as f64;
            let wrong_share = (accepted > 0).then(|| 100.0 * wrong as f64 / accepted as f64);
            table.push(row![method.name(), scale, outcomes.len(), share, accepted, wrong, wrong_share, far]);
            curve.push([share, wrong_share.unwrap_or(f64::NAN)]);
            if scale == 1.0 {
                findings.push(format!(
                    "The gate in force, {}: {share:.1} % of {} subjects accepted, {wrong} of {accepted} accepted detections wrong.",
                    method.name(),
                    outcomes.len()
                ));
            }
        }
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

/// What a gate lets through.
struct Strictness {
    subjects: usize,
    accepted: usize,
    wrong: usize,
    far: usize,
}

impl Strictness {
    fn of(outcomes: &[Outcome], gate: &Gate) -> Self {
        let passes = |judged: &super::measure::Judged| {
            judged.findings.is_some_and(|findings| gate.refusal(&findings).is_none())
        };
        let subjects =
            outcomes.iter().filter(|o| o.fit.is_some_and(|fit| passes(&o.detections[fit.detection])));
        let accepted = || outcomes.iter().flat_map(|o| &o.detections).filter(|judged| passes(judged));
        Self {
            subjects: subjects.count(),
            accepted: accepted().count(),
            wrong: accepted().filter(|judged| judged.error_mm > WRONG_MM).count(),
            far: accepted().filter(|judged| judged.is_far).count(),
        }
    }
}

/// The gate in force with upper limits times `scale` and lower limits divided by it; where the natural bound of a
/// quantity is 1, the distance from 1 is scaled. The number of points stays.
fn scaled(scale: f64) -> Gate {
    let (gate, scale) = (gate(), scale as f32);
    Gate {
        size_conflict: gate.size_conflict * scale,
        size_unknown: gate.size_unknown * scale,
        ambiguous: 1.0 - (1.0 - gate.ambiguous) / scale,
        outline: gate.outline * scale,
        visible: gate.visible / scale,
        colour: gate.colour * scale,
        uncertain_mm: gate.uncertain_mm * scale,
        flat: 1.0 + (gate.flat - 1.0) / scale,
        through: gate.through * scale,
        shared_volume: gate.shared_volume / scale,
        ..gate
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_looser_gate_accepts_whatever_a_stricter_one_does() {
        let outcomes =
            measure(&Context::default(), &[Case::of(ORCHARD)], &[Method::Outline], &[1, 2, 3, 4, 5, 6]);
        let counts = SCALES.map(|scale| Strictness::of(&outcomes[0][0], &scaled(scale)).accepted);
        assert!(counts.is_sorted() && counts[SCALES.len() - 1] > 0, "{counts:?}");
        // At 1 the findings give the verdicts that the search gave.
        let accepted = outcomes[0][0].iter().flat_map(|o| &o.detections).filter(|j| j.is_accepted()).count();
        assert_eq!(Strictness::of(&outcomes[0][0], &scaled(1.0)).accepted, accepted);
    }
}
