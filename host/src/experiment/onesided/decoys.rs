//! What is no jujube and stands where one could be, in the colour of fruit: how often is it taken for one?

use super::{
    Case, Method, Outcome,
    gates::{PRESETS, passes},
    listing, measure,
    one_sided::{code_cells, code_columns},
};
use crate::{
    error::InputError,
    experiment::{
        Context, Experiment, Report,
        figure::{Axis, Chart, Figure, Mark, Series},
        table::{Cell, Column, Table, row},
    },
    synth::onesided::{Subject, families::ORCHARD, scaled_jujube},
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "decoys",
    purpose: "Balls, apples, discs, branches and fruit of another size: how often each is accepted as a jujube.",
    run,
};

/// The decoys, in views like the orchard's.
const DECOYS: [Case; 8] = [
    Case::of(ORCHARD.decoy("ball, 10-17 mm", Subject::Ball(10.0, 17.0))),
    Case::of(ORCHARD.decoy("apple, 32-42 mm", Subject::Ball(32.0, 42.0))),
    Case::of(ORCHARD.decoy("disc", Subject::Disc)),
    Case::of(ORCHARD.decoy("branch, 6-12 mm", Subject::Branch(6.0, 12.0))),
    Case::of(ORCHARD.decoy("0.7x fruit", scaled_jujube(0.7))),
    Case::of(ORCHARD.decoy("0.85x fruit", scaled_jujube(0.85))),
    Case::of(ORCHARD.decoy("1.15x fruit", scaled_jujube(1.15))),
    Case::of(ORCHARD.decoy("1.3x fruit", scaled_jujube(1.3))),
];

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(400);
    let measured = measure(context, &DECOYS, &Method::OURS, &seeds);
    let mut table = Table::new(
        format!("Decoys accepted, of {} scenes each", seeds.len()),
        vec![
            Column::new("decoy", "decoy", 0),
            Column::new("outline_accepted", "accepted, outlines", 0),
            Column::new("outline_percent", "%", 2),
            Column::new("cloud_accepted", "accepted, cloud only", 0),
            Column::new("cloud_percent", "%", 2),
        ],
    );
    let mut codes = Table::new("Why the others are refused, % of the scenes", code_columns());
    let mut presets = Table::new(
        "Decoys accepted by the gates to choose from, % of the scenes",
        vec![
            Column::new("decoy", "decoy", 0),
            Column::new("method", "method", 0),
            Column::new("strict_percent", "strict", 2),
            Column::new("balanced_percent", "balanced", 2),
            Column::new("eager_percent", "eager", 2),
        ],
    );
    let mut taken = listing::table("Decoys that were accepted");
    let mut bars: [Vec<f64>; 2] = [Vec::new(), Vec::new()];
    for (case, by_method) in DECOYS.iter().zip(&measured) {
        let mut cells: Vec<Cell> = row![case.name];
        for (method, (outcomes, bar)) in Method::OURS.iter().zip(by_method.iter().zip(&mut bars)) {
            let accepted = outcomes.iter().filter(|outcome| is_taken(outcome)).count();
            let percent = 100.0 * accepted as f64 / outcomes.len() as f64;
            cells.extend(row![accepted, percent]);
            bar.push(percent);
            codes.push(code_cells(case.name, *method, outcomes));
            listing::list(&mut taken, case, *method, outcomes);
            let [strict, balanced, eager] = PRESETS.map(|(_, gate)| {
                let let_in =
                    |outcome: &&Outcome| outcome.detections.iter().any(|judged| passes(&gate, judged));
                100.0 * outcomes.iter().filter(let_in).count() as f64 / outcomes.len() as f64
            });
            presets.push(row![case.name, method.name(), strict, balanced, eager]);
        }
        table.push(cells);
    }
    let findings = DECOYS.iter().enumerate().map(|(k, case)| {
        let [outline, cloud] = [bars[0][k], bars[1][k]];
        format!(
            "{}: accepted in {outline:.2} % of the scenes with outlines, {cloud:.2} % from the cloud alone.",
            case.name
        )
    });
    let charts = Method::OURS.iter().zip(&bars).map(|(method, bar)| Chart {
        title: format!("Decoys accepted: {}", method.name()),
        x: Axis::linear("decoy"),
        y: Axis::linear("%"),
        series: DECOYS
            .iter()
            .zip(bar)
            .enumerate()
            .map(|(k, (case, &percent))| {
                Series::new(case.name, Mark::Bars(0.8), k, vec![[k as f64 + 1.0, percent]])
            })
            .collect(),
    });
    let caption = "Share of scenes in which a decoy is accepted as a jujube. The size prior has a spread of 3.5 % in length and 6 % in \
                   thickness, so a fruit of 1.15 times the size is the least that can be told.";
    Ok(Report {
        findings: findings.collect(),
        figures: vec![Figure::charts("accepted", caption, charts.collect())],
        tables: vec![table, presets, codes, taken],
    })
}

/// Something in the scene was accepted.
fn is_taken(outcome: &Outcome) -> bool {
    outcome.detections.iter().any(super::measure::Judged::is_accepted)
}
