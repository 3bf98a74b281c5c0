//! `varsac check`: the core against the reference, bit for bit, stage by stage.
//!
//! Both sides get the same inputs ([`Family`]) and write down the result of every stage in the same shape; any bit
//! that differs is a difference. The reference (`varsac_reference`) is a program of its own, written from the numeric contract
//! (`core/docs/numerics.md`, `numerics-map.md`, `numerics-mixture.md`), so agreement means that the core computes what the
//! contract says. Whether that is also *accurate* is another question, with other tests (`tests/tests/accuracy.rs`).
//!
//! `varsac check --cases 20000` is a long run of half a minute of processor time, `tests/tests/bit_exact.rs` the short
//! one, with the proof that a difference in any stage is found.

mod bodies;
mod cases;
mod convert;
mod core_side;
mod parts;
mod record;
mod reference_side;
mod report;
mod scenes;
mod singles;
mod views;

pub use cases::{Family, RecordedView};
pub use convert::{reference_config, reference_map_config, reference_mixture_config, reference_view};
pub use record::Stage;
pub use report::{Difference, Outcome};

use cases::Case;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use record::{Parting, Recorder};
use std::time::Instant;

/// Command line of `varsac check`.
#[derive(Clone, Debug, clap::Args)]
pub struct CheckArgs {
    /// Number of cases: clouds that are searched by the core and by the reference
    #[arg(long, default_value_t = 2000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub cases: u32,
    /// Seed of the cases; the same seed gives the same cases on every machine
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Replay this case only
    #[arg(long, value_name = "K")]
    pub case: Option<u32>,
    /// Frame folders or clouds to search as well; every second case is one of them
    #[arg(value_name = "INPUT")]
    pub inputs: Vec<std::path::PathBuf>,
}

/// What a check is to compare.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Number of cases.
    pub cases: u32,
    /// Seed of the cases.
    pub seed: u64,
    /// Only this case.
    pub case: Option<u32>,
    /// Recorded views to search besides the synthetic ones.
    pub recorded: Vec<RecordedView>,
    /// Show a progress bar on stderr.
    pub progress: bool,
}

impl CheckArgs {
    /// Runs the check, prints its summary on stdout and its rate on stderr. `recorded` are the views of
    /// [`Self::inputs`], named as on the command line. True when no bit differed.
    pub fn execute(&self, recorded: Vec<RecordedView>) -> bool {
        let (cases, seed, case) = (self.cases, self.seed, self.case);
        let started = Instant::now();
        let outcome = run(&Options { cases, seed, case, recorded, progress: true });
        let seconds = started.elapsed().as_secs_f64();
        println!("{outcome}");
        let rate = outcome.fits() as f64 / seconds;
        eprintln!(
            "{} fits, {} searches, {} default searches and {} without a size prior by both sides in {seconds:.1} s on {} threads: {rate:.0} fits a second",
            outcome.fits(),
            outcome.searches(),
            outcome.map_searches(),
            outcome.mixture_searches(),
            rayon::current_num_threads(),
        );
        outcome.difference.is_none()
    }
}

/// Compares core and reference over all cases, on all threads of rayon.
pub fn run(options: &Options) -> Outcome {
    let (first, cases) = match options.case {
        Some(case) => (u64::from(case), 1),
        None => (0, u64::from(options.cases)),
    };
    let bar = if options.progress { ProgressBar::new(cases) } else { ProgressBar::hidden() };
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} cases, {eta} left") {
        bar.set_style(style);
    }
    let total = (first..first + cases)
        .into_par_iter()
        .map(|number| {
            let compared = Total::of_case(options, number);
            bar.inc(1);
            compared
        })
        .reduce(Total::default, |a, b| a.join(&b));
    bar.finish_and_clear();
    Outcome {
        cases,
        counts: total.counts,
        digest: total.digest,
        differing: total.differing,
        difference: total.first_differing.and_then(|number| difference(options, number)),
    }
}

/// The sum over some cases; joining is commutative, so the order in which threads finish does not show.
#[derive(Default)]
struct Total {
    counts: [u64; Stage::COUNT],
    digest: u64,
    differing: u64,
    first_differing: Option<u64>,
}

impl Total {
    fn of_case(options: &Options, number: u64) -> Self {
        let case = Case::generate(options.seed, number, &options.recorded);
        let [core, reference] = both_sides(&case, Recorder::new);
        let differs = core.first_difference(&reference).is_some();
        Self {
            counts: core.counts(),
            // Multiplied by an odd number of its own, so that exchanged cases show in the sum.
            digest: core.digest().wrapping_mul(2 * number + 1),
            differing: u64::from(differs),
            first_differing: differs.then_some(number),
        }
    }

    fn join(mut self, other: &Self) -> Self {
        for (count, more) in self.counts.iter_mut().zip(other.counts) {
            *count += more;
        }
        let first_differing = match (self.first_differing, other.first_differing) {
            (Some(a), Some(b)) => Some(a.min(b)),
            (a, b) => a.or(b),
        };
        Self {
            counts: self.counts,
            digest: self.digest.wrapping_add(other.digest),
            differing: self.differing + other.differing,
            first_differing,
        }
    }
}

/// The records of core and reference for one case.
fn both_sides(case: &Case, recorder: impl Fn() -> Recorder) -> [Recorder; 2] {
    let mut sides = [recorder(), recorder()];
    let [core, reference] = &mut sides;
    match case.family {
        Family::Parts => {
            parts::core(case, core);
            parts::reference(case, reference);
        }
        Family::Single => {
            singles::core(case, core);
            singles::reference(case, reference);
        }
        _ => {
            core_side::run(case, core);
            reference_side::run(case, reference);
        }
    }
    sides
}

/// Looks closely at a case that differs: once to find the segment, once to keep its records.
fn difference(options: &Options, number: u64) -> Option<Difference> {
    let case = Case::generate(options.seed, number, &options.recorded);
    let [core, reference] = both_sides(&case, Recorder::new);
    let segment = core.first_difference(&reference)?;
    let [core, reference] = both_sides(&case, || Recorder::keeping(segment));
    let parting = Parting::between(core, reference)?;
    let mut replay = format!("varsac check --seed {} --case {number}", options.seed);
    for view in &options.recorded {
        replay.push(' ');
        replay.push_str(&view.name);
    }
    Some(Difference::new(&parting, number, case.family, replay))
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Args;

    #[test]
    fn the_command_line_is_consistent_and_compares_something() {
        let mut command = CheckArgs::augment_args(clap::Command::new("check"));
        command.clone().debug_assert();
        assert!(command.try_get_matches_from_mut(["check", "--cases", "0"]).is_err());
        assert!(command.try_get_matches_from_mut(["check", "--seed", "7", "--case", "0"]).is_ok());
    }

    #[test]
    fn a_single_case_is_what_it_is_in_a_run() {
        let options = Options { cases: 3, seed: 5, ..Options::default() };
        let all = run(&options);
        assert!(all.difference.is_none(), "{all}");
        let each = (0..3).map(|case| run(&Options { case: Some(case), ..options.clone() }));
        let sum = each.fold(0_u64, |sum, one| sum.wrapping_add(one.digest));
        assert_eq!(sum, all.digest);
    }
}
