//! Fig. 6: how many trials a search needs, over the share of inliers and the size of the sample, Eq. (15) and (17).
//!
//! Theory is the core's own function. Simulation is independent of it: clouds of [`POINTS`] points of which a share w
//! are inliers are sampled without replacement, sizes in turn, until a sample holds inliers only; the number of trials
//! within which 95 % of the searches succeed is what the equations promise.

use varsac_core::{rng::Stream, trials::trials};

use super::{
    Context, Experiment, Report,
    figure::{Axis, Chart, Figure, Mark, Series},
    table::{Column, Table, row},
};
use crate::{error::InputError, eval::statistics::quantile};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "fig6",
    purpose: "Trials against the share of inliers for each sample size: theory, and 95 % of the searches by simulation.",
    run,
};

const CONFIDENCE: f32 = 0.95;
/// Points of a simulated cloud: as many as a jujube at 0.7 m shows.
const POINTS: u32 = 400;
/// No bound worth the name: the curves of small w shall not be cut.
const MAX_TRIALS: u32 = 1_000_000;
const SIMULATED_PERCENT: [u32; 6] = [50, 60, 70, 80, 90, 95];
/// The sizes that are drawn: each of the paper's alone, and all in turn.
const FAMILIES: [(&str, &[u8]); 5] = [
    ("n = 9", &[9]),
    ("n = 10", &[10]),
    ("n = 11", &[11]),
    ("n = 12", &[12]),
    ("9 to 12 in turn", &[9, 10, 11, 12]),
];

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(2000);
    let mut columns = vec![Column::new("inlier_percent", "w %", 0)];
    let keys = [
        ["k_9", "simulated_9"],
        ["k_10", "simulated_10"],
        ["k_11", "simulated_11"],
        ["k_12", "simulated_12"],
        ["k_9_to_12", "simulated_9_to_12"],
    ];
    for ((name, _), [theory, simulated]) in FAMILIES.iter().zip(keys) {
        columns.push(Column::new(theory, format!("k, {name}"), 0));
        columns.push(Column::new(simulated, "simulated", 0));
    }
    let mut table = Table::new("Trials for a good sample with probability 0.95", columns);
    let mut dots: Vec<Vec<[f64; 2]>> = vec![Vec::new(); FAMILIES.len()];
    let mut worst: f64 = 0.0;
    for percent in SIMULATED_PERCENT {
        let mut cells = row![percent];
        for (family, (_, sizes)) in FAMILIES.iter().enumerate() {
            let theory = trials(CONFIDENCE, sizes, percent as f32 / 100.0, MAX_TRIALS);
            let mut counts = context.each(&seeds, |&seed| f64::from(until_good(seed, sizes, percent)));
            counts.sort_by(f64::total_cmp);
            let simulated = quantile(&counts, f64::from(CONFIDENCE)).unwrap_or(f64::NAN);
            worst =
                worst.max((simulated / f64::from(theory) - 1.0).abs() * f64::from(u8::from(theory >= 10)));
            dots[family].push([f64::from(percent) / 100.0, simulated]);
            cells.extend(row![theory, simulated]);
        }
        table.push(cells);
    }
    let curves = FAMILIES.iter().enumerate().map(|(family, (name, sizes))| {
        let place = |percent: u32| {
            [f64::from(percent), f64::from(trials(CONFIDENCE, sizes, percent as f32 / 100.0, MAX_TRIALS))]
        };
        let points = (40..=99).map(place).map(|[percent, k]| [percent / 100.0, k]).collect();
        Series::new(*name, Mark::Line, family, points)
    });
    let simulated = dots.into_iter().enumerate().map(|(family, points)| {
        Series::new(if family == 0 { "simulated" } else { "" }, Mark::Dots, family, points)
    });
    let chart = Chart {
        title: "Trials until a sample of inliers is drawn with probability 0.95".into(),
        x: Axis::linear("w, share of inliers").within(0.4, 1.0),
        y: Axis::logarithmic("k, trials"),
        series: curves.chain(simulated).collect(),
    };
    let findings = vec![
        format!(
            "At the same w the smallest sample needs the fewest trials, always: at w = 0.774, the paper's score, {} with 9 \
             points and {} with 9 to 12 in turn. Larger samples pay only if they raise w (see eq20, sample-sizes).",
            trials(CONFIDENCE, &[9], 0.774, MAX_TRIALS),
            trials(CONFIDENCE, &[9, 10, 11, 12], 0.774, MAX_TRIALS)
        ),
        format!(
            "Simulated searches on {POINTS} points, drawn without replacement, agree with Eq. (17) to within {:.0} % where \
             k is 10 or more.",
            (100.0 * worst).ceil()
        ),
    ];
    let caption =
        "Curves: Eq. (15) and (17). Dots: trials within which 95 % of simulated searches drew a good sample.";
    Ok(Report {
        findings,
        tables: vec![table],
        figures: vec![Figure::charts("trials", caption, vec![chart])],
    })
}

/// Trials until a sample without outliers is drawn; the first `percent` of the points are the inliers.
fn until_good(seed: u64, sizes: &[u8], percent: u32) -> u32 {
    let inliers = POINTS * percent / 100;
    let mut stream = Stream::new(seed);
    let mut trial = 0;
    loop {
        let size = u32::from(sizes[trial as usize % sizes.len()]);
        trial += 1;
        // Drawing without replacement looks at numbers only: the k-th inlier drawn leaves inliers - k of POINTS - k.
        if (0..size).all(|drawn| stream.below(POINTS - drawn) < inliers - drawn) || trial == MAX_TRIALS {
            return trial;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn simulation_agrees_with_the_equation() {
        let mut counts: Vec<f64> = (0..4000).map(|seed| f64::from(until_good(seed, &[9], 80))).collect();
        counts.sort_by(f64::total_cmp);
        // ln 0.05 / ln(1 - 0.8^9) = 20.8; without replacement w^9 is 3 % less.
        let simulated = quantile(&counts, 0.95).unwrap();
        assert!((19.0..=24.0).contains(&simulated), "{simulated}");
    }

    #[test]
    fn the_table_has_the_known_integers_of_eq_15_and_17() {
        let report = run(&Context { seeds: Some(2), ..Context::default() }).unwrap();
        let rows = report.tables[0].to_json()["rows"].clone();
        let trials = |row: usize, key: &str| rows[row][key].as_u64().unwrap();
        assert_eq!((trials(0, "inlier_percent"), trials(0, "k_9"), trials(0, "k_12")), (50, 1533, 12270));
        assert_eq!((trials(3, "inlier_percent"), trials(3, "k_9"), trials(3, "k_9_to_12")), (80, 21, 29));
    }
}
