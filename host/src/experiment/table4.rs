//! Table 4: the methods on the simulated ellipsoid, by the paper's criteria, under each reading of the sampling radius.
//!
//! The paper leaves open the number of points (here 1000), the size of their errors (here a deviation of 0.1 on each
//! coordinate, and a second table over the deviation), where the random points lie (here in the bounding box enlarged
//! by a quarter), and the thresholds of its RANSAC (here a distance of 0.2 and a cosine of 0.8).

use varsac_core::Constraint;

use super::{
    Context, Experiment, Report,
    methods::{METHODS, Method, VARSAC},
    simulated::{READINGS, Reading, Summary, WHOLE, cloud, errors, search},
    table::{Cell, Column, Table, row},
};
use crate::error::InputError;

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "table4",
    purpose: "The simulation: direct fit, RANSAC, VARSAC with TEBC, default search; three readings of r_s.",
    run,
};

/// Deviation of the points' errors.
const SIGMA: f64 = 0.1;
/// Reading of the methods that have no sampling radius.
const ALL_POINTS: &str = "all points";
const SIGMAS: [f64; 4] = [0.02, 0.05, 0.1, 0.15];

/// Method, score %, RMS-c, RMS-s, RMS-a, iterations, milliseconds in all and of a score, as printed.
const PRINTED: [(&str, [f64; 7]); 3] = [
    ("direct", [100.0, 0.54, 0.61, 0.87, 1.0, 13.0, 0.0]),
    ("RANSAC", [61.2, 0.07, 0.08, 0.43, 282.0, 2002.0, 5.0]),
    ("VARSAC+TEBC", [78.3, 0.02, 0.02, 0.11, 133.0, 505.0, 2.0]),
];

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(100);
    let mut table =
        Table::new(format!("Table 4: {} clouds of 1000 points, sigma {SIGMA}", seeds.len()), columns());
    for (method, [score, c, s, a, trials, search_ms, score_ms]) in PRINTED {
        let count = Cell::from(trials);
        table.push(row![
            "the paper's values",
            method,
            None::<f64>,
            score,
            c,
            None::<f64>,
            s,
            a,
            count,
            search_ms,
            1e3 * score_ms
        ]);
    }
    let mut summaries = Vec::new();
    let mut compare = |method: &Method, reading: &Reading, shown: &str| {
        let summary = summary(context, &seeds, method, reading, SIGMA);
        table.push(cells(shown.to_owned(), method.name, &summary));
        summaries.push((shown.to_owned(), method.name, summary));
    };
    for method in METHODS.iter().filter(|method| !method.samples) {
        compare(method, &WHOLE, ALL_POINTS);
    }
    for reading in &READINGS {
        // The baseline knows a11 = 1 only.
        let knows = |method: &&Method| reading.constraint == Constraint::A11 || method.name == VARSAC.name;
        for method in METHODS.iter().filter(|method| method.samples).filter(knows) {
            compare(method, reading, reading.name);
        }
    }
    let mut sweep = Table::new(
        format!("The whole cloud, over the points' error: {} clouds each", seeds.len()),
        columns(),
    );
    for sigma in SIGMAS {
        for method in METHODS.iter().filter(|method| method.name != "direct") {
            let summary = summary(context, &seeds, method, &WHOLE, sigma);
            sweep.push(cells(format!("sigma {sigma}"), method.name, &summary));
        }
    }
    Ok(Report { findings: findings(&summaries), tables: vec![table, sweep], ..Report::default() })
}

fn columns() -> Vec<Column> {
    vec![
        Column::new("reading", "reading", 0),
        Column::new("method", "method", 0),
        Column::new("failed_percent", "failed %", 1),
        Column::new("score_percent", "score %", 1),
        Column::new("rms_c", "RMS-c", 4),
        Column::new("centre_median", "centre, median", 4),
        Column::new("rms_s", "RMS-s", 4),
        Column::new("rms_a_rad", "RMS-a rad", 3),
        Column::new("trials", "iterations", 0),
        Column::new("search_ms", "Time1 ms", 2),
        Column::new("score_us", "Time2 us", 1),
    ]
}

fn summary(context: &Context, seeds: &[u64], method: &Method, reading: &Reading, sigma: f64) -> Summary {
    let config = reading.config();
    let runs = context.each(seeds, |&seed| {
        let simulation = cloud(seed, sigma);
        let found = search(method, &simulation, &config, seed)?;
        Some((errors(&simulation, &found), found))
    });
    Summary::of(&runs)
}

fn cells(reading: String, method: &str, summary: &Summary) -> Vec<Cell> {
    let criteria = summary.criteria;
    row![
        reading,
        method,
        100.0 * summary.failed,
        criteria.map(|c| 100.0 * c.model_score),
        criteria.map(|c| c.rms_centre_mm),
        summary.centre_median,
        criteria.map(|c| c.rms_size_mm),
        criteria.map(|c| c.rms_attitude_rad),
        summary.trials,
        summary.search_ms,
        summary.score_us,
    ]
}

fn findings(summaries: &[(String, &str, Summary)]) -> Vec<String> {
    let of = |reading: &str, method: &str| {
        let found = summaries.iter().find(|(r, m, _)| *r == reading && *m == method);
        found.map(|(_, _, summary)| summary.clone()).unwrap_or_default()
    };
    let rms = |summary: &Summary| summary.criteria.map_or(f64::NAN, |c| c.rms_centre_mm);
    let printed = READINGS[0].name;
    let [narrow, varsac, ransac, direct, default] = [
        of(printed, "VARSAC+TEBC"),
        of(WHOLE.name, "VARSAC+TEBC"),
        of(WHOLE.name, "RANSAC"),
        of(ALL_POINTS, "direct"),
        of(ALL_POINTS, "default, size known"),
    ];
    vec![
        format!(
            "Table 2's r_s = 1 cannot be what was run: its neighbourhoods do not span semi-axes up to 3, and {:.0} % of the \
             searches fail. Sampling the whole cloud fails in {:.0} %.",
            100.0 * narrow.failed,
            100.0 * varsac.failed
        ),
        format!(
            "Direct least squares is as poor as printed: it fails in {:.0} %, RMS-c {:.2} (paper 0.54), RMS-s {:.2} (0.61).",
            100.0 * direct.failed,
            rms(&direct),
            direct.criteria.map_or(f64::NAN, |c| c.rms_size_mm)
        ),
        format!(
            "VARSAC+TEBC reaches the paper's accuracy: RMS-c {:.3} (paper 0.02). RANSAC does too, {:.3} (0.07), once its \
             thresholds are as wide as the shell: the gap between the two in the paper is one of thresholds.",
            rms(&varsac),
            rms(&ransac)
        ),
        format!(
            "The default search, told the size to 15 %, reaches RMS-c {:.4}, RMS-s {:.4}, RMS-a {:.3} rad.",
            rms(&default),
            default.criteria.map_or(f64::NAN, |c| c.rms_size_mm),
            default.criteria.map_or(f64::NAN, |c| c.rms_attitude_rad)
        ),
        format!(
            "Trials, median: {:.0} for VARSAC+TEBC, {:.0} for RANSAC (paper 133 and 282). Samples of 9 to 12 do not stop the \
             search sooner than samples of 9; what makes VARSAC+TEBC fast is the score, see Time2 and sample-sizes.",
            varsac.trials.unwrap_or(f64::NAN),
            ransac.trials.unwrap_or(f64::NAN)
        ),
    ]
}
