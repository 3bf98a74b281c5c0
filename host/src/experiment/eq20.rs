//! Eq. (19)-(22): when does varying the sample size need fewer trials than the smallest sample?
//!
//! VARSAC needs fewer when `prod_j (1 - w_j^n_j)^(1/m) < 1 - w_1^n_1`. Eq. (20) keeps the largest of the terms only, and
//! from Eq. (22) the paper concludes that for n = 9 to 12 it suffices if some w_j exceeds w_1 by 0.2. Here the least
//! sufficient margin is computed for every w_1, trials are simulated at given margins, and the margins that occur are
//! measured: the share of inliers that the best of equally many hypotheses of each size reaches.

use varsac_core::Config;

use super::{
    Context, Experiment, Report,
    families::{KINDS, best_of},
    figure::{Axis, Chart, DARK, Figure, LIGHT, Mark, Series},
    table::{Column, Table, row},
};
use crate::{
    error::InputError,
    eval::statistics::{mean_and_deviation, quantile},
    synth::noise::Noise,
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "eq20",
    purpose: "When VARSAC needs fewer trials than RANSAC: the margin in w that it takes, and the margin that there is.",
    run,
};

const SIZES: [u8; 4] = [9, 10, 11, 12];
const CONFIDENCE: f64 = 0.95;
/// The margin of the paper.
const PAPER_MARGIN: f64 = 0.2;
const SIMULATED_RATIOS: [f64; 4] = [0.5, 0.6, 0.7, 0.8];
const SIMULATED_MARGINS: [f64; 5] = [0.0, 0.05, 0.1, 0.15, 0.2];
/// Hypotheses of each size whose best counts: as many for each, so that no size has more luck.
const HYPOTHESES: u32 = 500;

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(1000);
    let mut trials_chart = Vec::new();
    let mut table = Table::new(
        "Trials of VARSAC over those of RANSAC, when 12 points reach a margin over w_1 and 9 to 11 do not",
        vec![
            Column::new("inliers", "w_1", 2),
            Column::new("margin", "margin", 2),
            Column::new("theory", "k / k, Eq. (17)", 3),
            Column::new("simulated", "simulated", 3),
        ],
    );
    for (colour, w) in SIMULATED_RATIOS.into_iter().enumerate() {
        let curve = (0..=50).map(|k| f64::from(k) * 0.005).filter(|margin| w + margin < 1.0);
        let curve = curve.map(|margin| [margin, of_ransac(&with_margin(w, margin, 3))]).collect();
        trials_chart.push(Series::new(format!("w_1 = {w}"), Mark::Line, colour, curve));
        let needed = quantile_of(context, &seeds, &[(9, w)]);
        let mut dots = Vec::new();
        for margin in SIMULATED_MARGINS.into_iter().filter(|margin| w + margin < 0.999) {
            let family = with_margin(w, margin, 3);
            let simulated = quantile_of(context, &seeds, &family) / needed;
            table.push(row![w, margin, of_ransac(&family), simulated]);
            dots.push([margin, simulated]);
        }
        trials_chart.push(Series::new(if colour == 0 { "simulated" } else { "" }, Mark::Dots, colour, dots));
    }
    trials_chart.push(Series::new("equal", Mark::Dashed, DARK, vec![[0.0, 1.0], [0.25, 1.0]]));

    let (observed, dots) = observed_margins(context, &context.seeds(40));
    let largest_of = |holds: &dyn Fn(f64, f64) -> bool| {
        grid().map(|w| least_margin(w, holds)).filter(|margin| margin.is_finite()).fold(0.0, f64::max)
    };
    let most = largest_of(&|w, m| eq_20(w, m, 3));
    let exact = largest_of(&|w, m| of_ransac(&with_margin(w, m, 3)) < 1.0);
    let pays: Vec<&str> =
        KINDS.iter().zip(&dots).filter(|(_, dot)| dot.pays).map(|((name, _), _)| *name).collect();
    let largest = dots.iter().map(|dot| dot.margin).fold(f64::NEG_INFINITY, f64::max);
    let findings = vec![
        format!(
            "The paper's condition is sufficient: Eq. (20) needs a margin of {most:.3} at most, less than {PAPER_MARGIN}. \
             Exactly, with the other sizes at w_1, {exact:.3} is always enough."
        ),
        format!(
            "At equal w VARSAC takes more trials than RANSAC: {:.2} times as many at w = 0.5.",
            of_ransac(&with_margin(0.5, 0.0, 3))
        ),
        format!(
            "The margins that occur are {largest:.3} at most. With the measured w of all four sizes Eq. (17) gives fewer \
             trials than 9 points alone in {} of {} families{}{}.",
            pays.len(),
            KINDS.len(),
            if pays.is_empty() { "" } else { ": " },
            pays.join("; ")
        ),
    ];
    let charts = vec![
        Chart {
            title: "Trials of VARSAC over trials of RANSAC".into(),
            x: Axis::linear("margin of w (n = 12) over w_1").within(0.0, 0.25),
            y: Axis::linear("ratio of trials"),
            series: trials_chart,
        },
        margins_chart(dots.iter().map(|dot| [dot.inliers, dot.margin]).collect()),
    ];
    let caption = "Left: theory and simulation. Right: the margin it takes and the margin that the simulation's clouds have.";
    let figures = vec![Figure::charts("margin", caption, charts)];
    Ok(Report { findings, tables: vec![table, observed], figures })
}

/// The four sizes at `w`, but the one at `place` at `w + margin`.
fn with_margin(w: f64, margin: f64, place: usize) -> Vec<(u8, f64)> {
    SIZES.iter().enumerate().map(|(k, &n)| (n, if k == place { w + margin } else { w })).collect()
}

/// `ln (1 - w^n)`.
fn log_of_failure((size, w): (u8, f64)) -> f64 {
    libm::log1p(-libm::pow(w, f64::from(size)))
}

/// Trials by Eq. (17) over those of the first size alone, Eq. (15); not rounded.
fn of_ransac(family: &[(u8, f64)]) -> f64 {
    let mean = family.iter().map(|&one| log_of_failure(one)).sum::<f64>() / family.len() as f64;
    log_of_failure(family[0]) / mean
}

/// Eq. (20), when the largest term is that of the size at `place`.
fn eq_20(w: f64, margin: f64, place: usize) -> bool {
    log_of_failure((SIZES[place], w + margin)) / (SIZES.len() as f64) < log_of_failure((SIZES[0], w))
}

/// The least margin with which a condition that is monotonic in it holds; NaN when none does.
fn least_margin(w: f64, holds: &dyn Fn(f64, f64) -> bool) -> f64 {
    let (mut low, mut high) = (0.0, 1.0 - 1e-12 - w);
    if !holds(w, high) {
        return f64::NAN;
    }
    for _ in 0..50 {
        let middle = f64::midpoint(low, high);
        if holds(w, middle) { high = middle } else { low = middle }
    }
    high
}

fn grid() -> impl Iterator<Item = f64> {
    (6..=39).map(|k| f64::from(k) * 0.025)
}

fn margins_chart(observed: Vec<[f64; 2]>) -> Chart {
    let curve = |holds: &dyn Fn(f64, f64) -> bool| grid().map(|w| [w, least_margin(w, holds)]).collect();
    Chart {
        title: "Least margin with which VARSAC needs fewer trials".into(),
        x: Axis::linear("w_1, share of inliers with 9 points").within(0.1, 1.0),
        y: Axis::linear("margin"),
        series: vec![
            Series::new(
                "the paper's 0.2",
                Mark::Dashed,
                DARK,
                vec![[0.1, PAPER_MARGIN], [1.0, PAPER_MARGIN]],
            ),
            Series::new("Eq. (20), n = 12", Mark::Dashed, 0, curve(&|w, m| eq_20(w, m, 3))),
            Series::new(
                "exact, n = 12",
                Mark::Line,
                0,
                curve(&|w, m| of_ransac(&with_margin(w, m, 3)) < 1.0),
            ),
            Series::new(
                "exact, n = 10",
                Mark::Line,
                1,
                curve(&|w, m| of_ransac(&with_margin(w, m, 1)) < 1.0),
            ),
            Series::new("none", Mark::Line, LIGHT, vec![[0.1, 0.0], [1.0, 0.0]]),
            Series::new("measured on the families", Mark::Dots, 2, observed),
        ],
    }
}

/// Trials within which 95 % of simulated searches draw a good sample, sizes in turn.
fn quantile_of(context: &Context, seeds: &[u64], family: &[(u8, f64)]) -> f64 {
    let mut counts = context.each(seeds, |&seed| {
        let mut noise = Noise::new(seed);
        let is_good = |noise: &mut Noise, (size, w): (u8, f64)| (0..size).all(|_| noise.uniform() < w);
        let mut trial = 0_usize;
        loop {
            trial += 1;
            // The sizes take turns from a random one on: a search is stopped anywhere in a round.
            if is_good(&mut noise, family[(trial + seed as usize) % family.len()]) || trial == 1_000_000 {
                return trial as f64;
            }
        }
    });
    counts.sort_by(f64::total_cmp);
    quantile(&counts, CONFIDENCE).unwrap_or(f64::NAN)
}

/// What one family has.
struct Observed {
    /// w_1, with 9 points.
    inliers: f64,
    /// The largest w of the other sizes less w_1.
    margin: f64,
    /// Whether Eq. (17) with all four gives fewer trials than Eq. (15) with the first.
    pays: bool,
}

/// The share of inliers that the best of [`HYPOTHESES`] of each size reaches, mean over the clouds of each family.
fn observed_margins(context: &Context, seeds: &[u64]) -> (Table, Vec<Observed>) {
    let mut columns = vec![Column::new("family", "family", 0)];
    for (key, size) in ["w_9", "w_10", "w_11", "w_12"].into_iter().zip(SIZES) {
        columns.push(Column::new(key, format!("w, n = {size}"), 3));
    }
    columns.push(Column::new("margin", "largest margin", 3));
    columns.push(Column::new("trials_of_ransac", "k / k, Eq. (17)", 2));
    let title = format!(
        "Mean share of inliers of the best of {HYPOTHESES} hypotheses, {} clouds a family",
        seeds.len()
    );
    let mut table = Table::new(title, columns);
    let mut all = Vec::new();
    for (name, kind) in KINDS {
        let means = SIZES.map(|size| {
            let config = Config { sample_sizes: [size].into_iter().collect(), ..kind.config() };
            let shares = context.each(seeds, |&seed| {
                best_of(&kind.cloud(seed).0, &config, HYPOTHESES, seed).map(|(_, share)| share)
            });
            mean_and_deviation(&shares.into_iter().flatten().collect::<Vec<_>>())
                .map_or(f64::NAN, |(mean, _)| mean)
        });
        let margin = means[1..].iter().fold(f64::NEG_INFINITY, |most, w| most.max(w - means[0]));
        let family: Vec<(u8, f64)> = SIZES.into_iter().zip(means).collect();
        let trials = of_ransac(&family);
        table.push(row![name, means[0], means[1], means[2], means[3], margin, trials]);
        all.push(Observed { inliers: means[0], margin, pays: trials < 1.0 });
    }
    (table, all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_condition_of_the_paper_suffices() {
        for w in grid().filter(|w| w + PAPER_MARGIN < 1.0) {
            for place in 1..4 {
                assert!(eq_20(w, PAPER_MARGIN, place), "w {w}, n {}", SIZES[place]);
                // Eq. (20) implies fewer trials.
                assert!(of_ransac(&with_margin(w, PAPER_MARGIN, place)) < 1.0);
            }
        }
    }

    #[test]
    fn at_equal_ratios_the_smallest_sample_wins() {
        assert!(grid().all(|w| of_ransac(&with_margin(w, 0.0, 0)) > 1.0));
        // One size is RANSAC.
        assert_eq!(of_ransac(&[(9, 0.7)]), 1.0);
    }

    #[test]
    fn the_least_margin_is_the_root() {
        let margin = least_margin(0.6, &|w, m| of_ransac(&with_margin(w, m, 3)) < 1.0);
        assert!((of_ransac(&with_margin(0.6, margin, 3)) - 1.0).abs() < 1e-9, "{margin}");
        assert!(least_margin(0.5, &|_, _| false).is_nan());
    }
}
