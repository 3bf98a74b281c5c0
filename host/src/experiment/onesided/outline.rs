//! What outline rays bring, and whether a mask that is too large, too small or displaced takes it away again.

use super::{
    Case, Method, Summary, measure,
    summary::{cells, columns},
};
use crate::{
    error::InputError,
    experiment::{
        Context, Experiment, Report,
        figure::{Axis, Chart, Figure, Mark, Series},
        table::Table,
    },
    synth::onesided::{
        VARIED_JUJUBE,
        families::{HARD, OCCLUDED, ORCHARD},
    },
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "outline",
    purpose: "The default search with and without outline rays, and under a mask that is biased or displaced.",
    run,
};

const CASES: [Case; 6] = [
    Case::of(HARD),
    Case::of(HARD.averaged("hard, pixels average")),
    Case::of(OCCLUDED),
    Case::of(OCCLUDED.averaged("occluded, pixels average")),
    Case::of(ORCHARD),
    Case::of(HARD.of("sizes +-15 %", VARIED_JUJUBE)).spread(0.15),
];

const HARD_AVERAGED: Case = CASES[1];

/// Errors of the mask, by their short names in the figure.
const BIASED: [Case; 8] = [
    HARD_AVERAGED.biased("as it is", 0, [0, 0]),
    HARD_AVERAGED.biased("1 px too large", 1, [0, 0]),
    HARD_AVERAGED.biased("2 px too large", 2, [0, 0]),
    HARD_AVERAGED.biased("1 px too small", -1, [0, 0]),
    HARD_AVERAGED.biased("2 px too small", -2, [0, 0]),
    HARD_AVERAGED.biased("1 px to the right", 0, [1, 0]),
    HARD_AVERAGED.biased("2 px to the right", 0, [2, 0]),
    HARD_AVERAGED.biased("2 px right and down", 0, [2, 2]),
];

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(300);
    let mut findings = Vec::new();
    let mut tables = Vec::new();
    let mut charts = Vec::new();
    for (title, cases) in
        [("With and without outlines", &CASES[..]), ("Under a mask that is wrong", &BIASED[..])]
    {
        let measured = measure(context, cases, &Method::OURS, &seeds);
        let mut table = Table::new(format!("{title}: {} views of each kind", seeds.len()), columns());
        let mut bars = [Vec::new(), Vec::new()];
        for (place, (case, by_method)) in cases.iter().zip(&measured).enumerate() {
            let [outline, cloud] = [0, 1].map(|k| Summary::of(&by_method[k]));
            table.push(cells(case.name, Method::Outline, &outline));
            table.push(cells(case.name, Method::Cloud, &cloud));
            for (bar, summary) in bars.iter_mut().zip([&outline, &cloud]) {
                bar.push(summary.centre_mm);
            }
            findings.push(format!(
                "{}: centre {:.2}/{:.2} mm (median, 90 %) with outlines and {:.2}/{:.2} mm without, long axis {:.1} and {:.1} deg \
                 (median), accepted {:.0} and {:.0} %.",
                numbered(place, case.name),
                outline.centre_mm[0],
                outline.centre_mm[1],
                cloud.centre_mm[0],
                cloud.centre_mm[1],
                outline.axis_deg[0],
                cloud.axis_deg[0],
                100.0 * outline.accepted,
                100.0 * cloud.accepted
            ));
        }
        tables.push(table);
        for (quantile, name) in ["median", "90 %"].into_iter().enumerate() {
            let names = ["with outlines", "cloud only"];
            let series = names.into_iter().zip(&bars).enumerate().map(|(colour, (label, bar))| {
                let shift = 0.4 * colour as f64 - 0.2;
                let points =
                    bar.iter().enumerate().map(|(k, errors)| [k as f64 + 1.0 + shift, errors[quantile]]);
                Series::new(label, Mark::Bars(0.38), colour, points.collect())
            });
            charts.push(Chart {
                title: format!("{title}: centre error, {name}"),
                x: Axis::linear("case"),
                y: Axis::linear("mm"),
                series: series.collect(),
            });
        }
    }
    let list = |cases: &[Case]| {
        let names = cases.iter().enumerate().map(|(place, case)| numbered(place, case.name));
        names.collect::<Vec<String>>().join(", ")
    };
    let caption = format!("Above: {}. Below, the mask of case 2 is {}.", list(&CASES), list(&BIASED));
    Ok(Report { findings, tables, figures: vec![Figure::charts("gain", caption, charts)] })
}

fn numbered(place: usize, name: &str) -> String {
    format!("{} {name}", place + 1)
}
