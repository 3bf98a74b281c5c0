//! Does varying the sample size pay? The paper's search with one size, another, four and twelve, on families of clouds
//! from easy to hard, everything else equal.
//!
//! Once by the paper's own stopping rule, and once with the same number of hypotheses for every set of sizes, so that
//! only the quality of what they draw differs.

use std::time::Instant;

use varsac_core::{Config, Ellipsoid};

use super::{
    Context, Experiment, Report,
    families::{KINDS, Kind, best_of},
    figure::{Axis, Chart, Figure, Mark, Series},
    methods::{Found, Task, VARSAC},
    table::{Column, Table, row},
};
use crate::{
    error::InputError,
    eval::{
        EllipsoidF64, norm,
        statistics::{mean_and_deviation, quantile},
        subtract,
    },
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "sample-sizes",
    purpose: "Ablation of the variable sample size: {9}, {12}, {9..12}, {9..20} on families of clouds; does it pay, and where.",
    run,
};

const SETS: [(&str, std::ops::RangeInclusive<u8>); 4] =
    [("{9}", 9..=9), ("{12}", 12..=12), ("{9..12}", 9..=12), ("{9..20}", 9..=20)];

/// Hypotheses of a search with a fixed number of them.
const FIXED: u32 = 300;

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(60);
    let mut report = Report::default();
    let mut charts = Vec::new();
    for (title, fixed) in [("the paper's stopping rule", false), ("300 hypotheses each", true)] {
        let mut table = Table::new(
            format!("Sample sizes, {title}: {} clouds a family", seeds.len()),
            vec![
                Column::new("family", "family", 0),
                Column::new("sizes", "sizes", 0),
                Column::new("failed_percent", "failed %", 1),
                Column::new("support", "w", 3),
                Column::new("trials", "trials, median", 0),
                Column::new("centre_median", "centre, median", 4),
                Column::new("centre_p90", "centre, p90", 4),
                Column::new("search_ms", "time ms", 2),
            ],
        );
        let mut medians = vec![Vec::new(); SETS.len()];
        let mut all = Vec::new();
        for (place, (family, kind)) in KINDS.iter().enumerate() {
            for (set, (name, sizes)) in SETS.iter().enumerate() {
                let runs = context.each(&seeds, |&seed| one(kind, sizes.clone(), fixed, seed));
                let summary = Summary::of(&runs, kind.short_semi_axis());
                table.push(row![
                    *family,
                    *name,
                    summary.failed_percent,
                    summary.support,
                    summary.trials,
                    summary.centre_median,
                    summary.centre_p90,
                    summary.search_ms
                ]);
                let value = if fixed { summary.support } else { summary.trials };
                medians[set].push([place as f64 + 1.0, value]);
                all.push(summary);
            }
        }
        report.findings.push(finding(title, &all));
        report.tables.push(table);
        let series = SETS.iter().enumerate().map(|(set, (name, _))| {
            // Side by side within a family.
            let beside = medians[set].iter().map(|[x, y]| [x + 0.18 * (set as f64 - 1.5), *y]).collect();
            Series::new(*name, Mark::Bars(0.16), set, beside)
        });
        charts.push(Chart {
            title: if fixed {
                "w of the best of 300 hypotheses"
            } else {
                "Trials until the search stops, median"
            }
            .into(),
            x: Axis::linear("family, in the order of the table"),
            y: if fixed { Axis::linear("w").within(0.0, 1.0) } else { Axis::linear("trials") },
            series: series.collect(),
        });
    }
    report.figures.push(Figure::charts("sizes", "Trials and share of inliers by sample size.", charts));
    Ok(report)
}

/// One run.
#[derive(Debug, Clone, Copy)]
struct Run {
    /// Distance of the centre from the true one.
    centre: f64,
    /// w: of the neighbourhood under the paper's rule, of the whole cloud otherwise.
    support: f64,
    trials: u32,
    search_ms: f64,
}

/// By the paper's stopping rule, or (`fixed`) the best of [`FIXED`] hypotheses without any final least squares; nothing
/// where nothing is found.
fn one(kind: &Kind, sizes: std::ops::RangeInclusive<u8>, fixed: bool, seed: u64) -> Option<Run> {
    let (cloud, truth) = kind.cloud(seed);
    let config = Config { sample_sizes: sizes.collect(), ..kind.config() };
    let off = |ellipsoid: &EllipsoidF64| norm(subtract(ellipsoid.centre_mm, truth.centre_mm));
    if fixed {
        let started = Instant::now();
        let (surface, support) = best_of(&cloud, &config, FIXED, seed)?;
        let search_ms = started.elapsed().as_secs_f64() * 1e3;
        let ellipsoid = EllipsoidF64::from(&Ellipsoid::from(&surface));
        return Some(Run { centre: off(&ellipsoid), support, trials: FIXED, search_ms });
    }
    let found = (VARSAC.find)(&Task { cloud: &cloud, config: &config, distance: 0.0, seed })?;
    let Found { ellipsoid, support, trials, search_ms, .. } = found;
    Some(Run { centre: off(&ellipsoid), support, trials, search_ms })
}

/// The runs of one set of sizes on one family.
#[derive(Debug, Clone, Copy)]
struct Summary {
    failed_percent: f64,
    support: f64,
    trials: f64,
    centre_median: f64,
    centre_p90: f64,
    search_ms: f64,
}

impl Summary {
    fn of(runs: &[Option<Run>], short: f64) -> Self {
        let values = |value: &dyn Fn(&Run) -> f64| {
            let mut values: Vec<f64> = runs.iter().flatten().map(value).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let at = |values: Vec<f64>, q| quantile(&values, q).unwrap_or(f64::NAN);
        let good = runs.iter().flatten().filter(|run| run.centre < short).count();
        Self {
            failed_percent: 100.0 * (1.0 - good as f64 / runs.len() as f64),
            support: mean_and_deviation(&values(&|run| run.support)).map_or(f64::NAN, |(mean, _)| mean),
            trials: at(values(&|run| f64::from(run.trials)), 0.5),
            centre_median: at(values(&|run| run.centre), 0.5),
            centre_p90: at(values(&|run| run.centre), 0.9),
            search_ms: at(values(&|run| run.search_ms), 0.5),
        }
    }
}

/// {9..12} against {9}, over the families.
fn finding(title: &str, all: &[Summary]) -> String {
    let families = || all.chunks(SETS.len());
    let fewer = families().filter(|sets| sets[2].trials < sets[0].trials).count();
    let stops = if fewer > 0 { format!("needs fewer trials than {{9}} in {fewer}, ") } else { String::new() };
    let better = families().filter(|sets| sets[2].centre_median < sets[0].centre_median).count();
    let safer = families().filter(|sets| sets[2].failed_percent < sets[0].failed_percent).count();
    let gain = families().map(|sets| sets[2].support - sets[0].support).fold(f64::NEG_INFINITY, f64::max);
    format!(
        "With {title}, of {} families {{9..12}} {stops}has a smaller median error of the \
         centre than {{9}} in {better} and fails less often in {safer}; it raises w by {gain:.3} at most.",
        KINDS.len()
    )
}
