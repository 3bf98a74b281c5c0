//! One fruit seen from one side: all methods on clean, hard, occluded and mixed views; the default search on variations
//! of the generator, so that nothing is tuned to one.

use varsac_core::RefusalCode;

use super::{
    Case, Method, Outcome, Summary, measure, scenery,
    summary::{cells, columns},
};
use crate::{
    error::InputError,
    eval::statistics::quantile,
    experiment::{
        Context, Experiment, Report,
        figure::{Axis, Chart, Figure, Mark, Series},
        table::{Cell, Column, Table, row},
    },
    synth::onesided::{
        Family, VARIED_JUJUBE, boxy_jujube,
        families::{CLEAN, HARD, OCCLUDED, ORCHARD},
    },
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "one-sided",
    purpose: "One fruit seen from one side: the default search, the paper's, RANSAC and direct least squares.",
    run,
};

/// Views on which all methods are compared.
const COMPARED: [Case; 4] = [Case::of(CLEAN), Case::of(HARD), Case::of(OCCLUDED), Case::of(ORCHARD)];

/// Hard views, each with one thing changed.
const VARIATIONS: [Case; 15] = [
    Case::of(HARD),
    Case::of(HARD.averaged("pixels average")),
    Case::of(Family { distance_mm: (500.0, 700.0), ..HARD.named("0.5-0.7 m") }),
    Case::of(Family { distance_mm: (1100.0, 1300.0), ..HARD.named("1.1-1.3 m") }),
    Case::of(Family { axial_mm: (0.4, 0.4), ..HARD.named("noise 0.4 mm") }),
    Case::of(Family { axial_mm: (1.5, 1.5), ..HARD.named("noise 1.5 mm") }),
    Case::of(Family { quantum_mm: 4.0, ..HARD.named("counts of 4 mm") }),
    Case::of(Family { lateral_px: (0.5, 0.5), ..HARD.named("lateral 0.5 px") }),
    Case::of(Family { defects: [0.8, 0.1, 0.05], ..HARD.named("flying pixels") }),
    Case::of(Family { neighbour: 1.0, ..HARD.named("all with neighbour") }),
    Case::of(Family { clutter: (6.0, 9.0), ..HARD.named("many leaves behind") }),
    Case::of(HARD.of("exponent 2.25", boxy_jujube(2.25))),
    Case::of(HARD.of("exponent 2.5", boxy_jujube(2.5))),
    Case::of(HARD.of("exponent 3", boxy_jujube(3.0))),
    Case::of(HARD.of("sizes +-15 %", VARIED_JUJUBE)).spread(0.15),
];

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(150);
    let compared = measure(context, &COMPARED, &Method::ALL, &seeds);
    let mut table = Table::new(
        format!("All methods on {} views of each kind; RMS over fruit within 5 mm", seeds.len()),
        columns(),
    );
    let mut findings = Vec::new();
    for (case, by_method) in COMPARED.iter().zip(&compared) {
        let summaries: Vec<Summary> = by_method.iter().map(|outcomes| Summary::of(outcomes)).collect();
        for (method, summary) in Method::ALL.iter().zip(&summaries) {
            table.push(cells(case.name, *method, summary));
        }
        findings.push(finding(case.name, &summaries));
    }
    let more = context.seeds(400);
    let varied = measure(context, &VARIATIONS, &Method::OURS, &more);
    let mut variations =
        Table::new(format!("The default search on hard views, {} of each variation", more.len()), columns());
    for (case, by_method) in VARIATIONS.iter().zip(&varied) {
        for (method, outcomes) in Method::OURS.iter().zip(by_method) {
            variations.push(cells(case.name, *method, &Summary::of(outcomes)));
        }
    }
    let mut refused =
        Table::new("Why the default search refuses the subject, % of the scenes", code_columns());
    for (cases, measured) in [(&COMPARED[..], &compared), (&VARIATIONS[1..], &varied[1..].to_vec())] {
        for (case, by_method) in cases.iter().zip(measured) {
            for (method, outcomes) in Method::OURS.iter().zip(by_method) {
                refused.push(code_cells(case.name, *method, outcomes));
            }
        }
    }
    let mixed = &compared[COMPARED.len() - 1];
    Ok(Report {
        findings,
        tables: vec![table, variations, refused, scenery::table(context, &COMPARED, &seeds)],
        figures: vec![errors(mixed)],
    })
}

fn finding(name: &str, summaries: &[Summary]) -> String {
    let share = |summary: &Summary| 100.0 * summary.right;
    let [outline, cloud, varsac, ransac, direct] = summaries else { return String::new() };
    format!(
        "{name}: centre within 5 mm in {:.1} % of the views with outlines, {:.1} % from the cloud alone; VARSAC+TEBC {:.1} %, \
         RANSAC {:.1} %, direct {:.1} %. From the cloud: RMS-c {:.2} mm, RMS-s {:.2} mm, long axis {:.1} deg (median); \
         {:.0} % accepted, {} of {} accepted detections wrong.",
        share(outline),
        share(cloud),
        share(varsac),
        share(ransac),
        share(direct),
        cloud.rms_c_mm,
        cloud.rms_s_mm,
        cloud.axis_deg[0],
        100.0 * cloud.accepted,
        cloud.wrong_detections,
        cloud.accepted_detections
    )
}

/// In the order of the tests.
const CODES: [RefusalCode; 12] = [
    RefusalCode::FewPoints,
    RefusalCode::SizeConflict,
    RefusalCode::SizeUnknown,
    RefusalCode::Ambiguous,
    RefusalCode::Outline,
    RefusalCode::Visible,
    RefusalCode::Colour,
    RefusalCode::Uncertain,
    RefusalCode::Flat,
    RefusalCode::Through,
    RefusalCode::SharedVolume,
    RefusalCode::Singular,
];

/// Columns of [`code_cells`].
pub(super) fn code_columns() -> Vec<Column> {
    let mut columns = vec![
        Column::new("case", "scenes", 0),
        Column::new("method", "method", 0),
        Column::new("nothing_found", "nothing found", 1),
    ];
    columns.extend(CODES.map(|code| Column::new(code.name(), code.name().replace('_', " "), 1)));
    columns
}

/// For each code the share of the scenes in which the subject (in a scene without: the first detection) is refused with it.
pub(super) fn code_cells(case: &str, method: Method, outcomes: &[Outcome]) -> Vec<Cell> {
    let percent = |count: usize| 100.0 * count as f64 / outcomes.len() as f64;
    let judged = || outcomes.iter().map(|o| o.detections.get(o.fit.map_or(0, |fit| fit.detection)));
    let mut cells = row![case, method.name(), percent(judged().filter(Option::is_none).count())];
    for code in CODES {
        let refused = judged().flatten().filter(|judged| judged.refusal == Some(code));
        cells.push(percent(refused.count()).into());
    }
    cells
}

/// Bins of the curves.
const BINS: usize = 6;

/// Error over occlusion and over distance, for every method.
fn errors(by_method: &[Vec<Outcome>]) -> Figure {
    type Coordinate = ([&'static str; 2], fn(&Outcome) -> f64, [f64; 2]);
    let coordinates: [Coordinate; 2] = [
        (["cover", "covered share"], |outcome| 1.0 - outcome.visible, [0.0, 0.6]),
        (["distance", "m"], |outcome| 1e-3 * outcome.distance_mm, [0.5, 1.3]),
    ];
    let mut charts = Vec::new();
    for ([over, label], of, ends) in coordinates {
        let curve = |name: &str, y: Axis, value: fn(&[&Outcome]) -> f64| Chart {
            title: format!("{name} over {over}"),
            x: Axis::linear(label).within(ends[0], ends[1]),
            y,
            series: Method::ALL
                .iter()
                .zip(by_method)
                .enumerate()
                .map(|(place, (method, outcomes))| {
                    Series::new(method.name(), Mark::Line, place, binned(outcomes, of, ends, value))
                })
                .collect(),
        };
        charts.push(curve("centre error, median", Axis::logarithmic("mm"), |bin| {
            let mut ascending: Vec<f64> = bin.iter().map(|outcome| outcome.centre_mm()).collect();
            ascending.sort_by(f64::total_cmp);
            quantile(&ascending, 0.5).unwrap_or(f64::NAN)
        }));
        charts.push(curve("centre within 5 mm", Axis::linear("%").within(0.0, 100.0), |bin| {
            100.0 * bin.iter().filter(|outcome| outcome.right().is_some()).count() as f64 / bin.len() as f64
        }));
    }
    let caption = "Mixed views (orchard): 0.5-1.3 m, 0-60 % covered, neighbours, noise 0.4-1.5 mm. Every fruit counts, accepted \
                   or not; where the median is missing, more than half were not found.";
    Figure::charts("errors", caption, charts)
}

fn binned(
    outcomes: &[Outcome],
    of: fn(&Outcome) -> f64,
    [low, high]: [f64; 2],
    value: fn(&[&Outcome]) -> f64,
) -> Vec<[f64; 2]> {
    let width = (high - low) / BINS as f64;
    // An empty bin has no point, not one that is no number.
    let of_bin = |bin: usize| {
        let from = low + bin as f64 * width;
        let inside: Vec<&Outcome> =
            outcomes.iter().filter(|o| (from..from + width).contains(&of(o))).collect();
        (!inside.is_empty()).then(|| [from + 0.5 * width, value(&inside)])
    };
    (0..BINS).filter_map(of_bin).collect()
}
