//! The paper's experiments and ours: seeded runs that end in tables, figures and one report to read.
//!
//! An experiment is a name, one sentence and a function from a [`Context`] to a [`Report`]; [`EXPERIMENTS`] lists them
//! all and each has a file of its own. The function decides nothing about files: [`write`](mod@write) puts tables
//! ([`table`]) and figures ([`figure`]) into a folder and everything into one page ([`html`]).
//!
//! The same seed gives the same report, whatever the number of threads: runs are independent, each draws from its own
//! seed, and results are gathered in the order of the seeds. Times are the exception; they stand in columns whose key
//! ends in `_ms` or `_us` (a quotient of times: in `_ratio`) and in no finding and no figure.

#![allow(clippy::unnecessary_wraps, reason = "every experiment has the signature of the registry")]

pub mod figure;
pub mod html;
mod on_canvas;
pub mod onesided;
mod plot;
mod scale;
pub mod table;
pub mod write;

mod eq20;
mod families;
mod fig10;
mod fig5;
mod fig6;
mod fig7;
mod fig8;
mod fig9;
mod frames;
mod methods;
mod noprior;
mod one_sided_noprior;
mod precision;
mod sample_sizes;
mod similarity;
mod simulated;
mod solvers;
mod speed;
mod surface;
mod table3;
mod table4;
mod table6;
mod trees;

use std::{fmt::Write as _, path::PathBuf, time::Instant};

use indicatif::{ProgressBar, ProgressStyle};
use rayon::prelude::*;
use serde_json::{Value, json};

use crate::{error::InputError, fruit::Fruit};
use figure::Figure;
use table::Table;

/// All experiments, in the order of the paper.
pub const EXPERIMENTS: &[Experiment] = &[
    similarity::EXPERIMENT,
    fig5::EXPERIMENT,
    fig6::EXPERIMENT,
    eq20::EXPERIMENT,
    sample_sizes::EXPERIMENT,
    table3::EXPERIMENT,
    table4::EXPERIMENT,
    fig7::EXPERIMENT,
    fig8::EXPERIMENT,
    table6::EXPERIMENT,
    fig9::EXPERIMENT,
    fig10::EXPERIMENT,
    precision::EXPERIMENT,
    speed::EXPERIMENT,
    onesided::ONE_SIDED,
    onesided::OUTLINE,
    onesided::DECOYS,
    onesided::CALIBRATION,
    onesided::TOUCHING,
    surface::EXPERIMENT,
    one_sided_noprior::EXPERIMENT,
];

/// One experiment.
#[derive(Debug, Clone, Copy)]
pub struct Experiment {
    /// Name on the command line, and the beginning of its files' names.
    pub name: &'static str,
    /// What it shows, in one sentence.
    pub purpose: &'static str,
    /// Does it.
    pub run: fn(&Context) -> Result<Report, InputError>,
}

/// The experiment of that name.
pub fn find(name: &str) -> Option<&'static Experiment> {
    EXPERIMENTS.iter().find(|experiment| experiment.name == name)
}

/// What an experiment is told, and where it says how far it is.
#[derive(Debug, Clone)]
pub struct Context {
    /// Seed of the first run; the others follow.
    pub seed: u64,
    /// Number of runs; nothing for each experiment's own default.
    pub seeds: Option<u64>,
    /// A frame folder for those experiments that can show a given frame.
    pub frame: Option<PathBuf>,
    /// The fruit in that frame.
    pub fruit: Fruit,
    /// Masks of one fruit, from the front and from the bottom, for the similarity of Eq. (1) and (2).
    pub masks: Option<[PathBuf; 2]>,
    /// Counts runs.
    pub progress: ProgressBar,
}

impl Default for Context {
    /// Seed 1, default numbers of runs, no files, silent.
    fn default() -> Self {
        Self {
            seed: 1,
            seeds: None,
            frame: None,
            fruit: Fruit::Jujube,
            masks: None,
            progress: ProgressBar::hidden(),
        }
    }
}

impl Context {
    /// Shows progress on standard error, if that is a terminal.
    pub fn with_progress(self) -> Self {
        let style = ProgressStyle::with_template("{msg:<14} [{bar:40}] {pos}/{len} runs")
            .unwrap_or_else(|_| ProgressStyle::default_bar())
            .progress_chars("=> ");
        Self { progress: ProgressBar::new(0).with_style(style), ..self }
    }

    /// The seeds of the runs: as many as the user asks for, else `default`. At least one.
    pub fn seeds(&self, default: u64) -> Vec<u64> {
        let count = self.seeds.unwrap_or(default).max(1);
        (0..count).map(|k| self.seed.wrapping_add(k)).collect()
    }

    /// Runs every job, on all cores, and returns the results in the order of the jobs.
    pub fn each<J: Sync, T: Send>(&self, jobs: &[J], run: impl Fn(&J) -> T + Sync) -> Vec<T> {
        self.progress.inc_length(jobs.len() as u64);
        let counted = |job| {
            let result = run(job);
            self.progress.inc(1);
            result
        };
        jobs.par_iter().map(counted).collect()
    }
}

/// What an experiment found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Report {
    /// Sentences with numbers, computed from this very run; no times.
    pub findings: Vec<String>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Figures.
    pub figures: Vec<Figure>,
}

/// A report and where it comes from.
#[derive(Debug, Clone)]
pub struct Finished {
    /// The experiment.
    pub experiment: Experiment,
    /// Its report.
    pub report: Report,
    /// Seed of the first run.
    pub seed: u64,
    /// Wall clock, milliseconds.
    pub elapsed_ms: f64,
}

impl Finished {
    /// Runs an experiment.
    ///
    /// # Errors
    /// Files named by the user that cannot be worked with.
    pub fn of(experiment: &Experiment, context: &Context) -> Result<Self, InputError> {
        context.progress.reset();
        context.progress.set_length(0);
        context.progress.set_message(experiment.name);
        let started = Instant::now();
        let report = (experiment.run)(context)?;
        context.progress.finish_and_clear();
        let elapsed_ms = started.elapsed().as_secs_f64() * 1e3;
        Ok(Self { experiment: *experiment, report, seed: context.seed, elapsed_ms })
    }

    /// Everything but the figures.
    pub fn to_json(&self) -> Value {
        json!({
            "experiment": self.experiment.name,
            "purpose": self.experiment.purpose,
            "seed": self.seed,
            "findings": self.report.findings,
            "tables": self.report.tables.iter().map(Table::to_json).collect::<Vec<_>>(),
            "elapsed_ms": self.elapsed_ms,
        })
    }

    /// For a terminal.
    pub fn to_text(&self) -> String {
        let mut text = format!("{}: {}\n\n", self.experiment.name, self.experiment.purpose);
        for table in &self.report.tables {
            text.push_str(&table.to_text());
            text.push('\n');
        }
        for finding in &self.report.findings {
            text.push_str(finding);
            text.push('\n');
        }
        text
    }

    /// For a document.
    pub fn to_markdown(&self) -> String {
        let mut text = format!("# {}\n\n{}\n", self.experiment.name, self.experiment.purpose);
        for finding in &self.report.findings {
            let _ = write!(text, "\n* {finding}");
        }
        text.push('\n');
        for table in &self.report.tables {
            text.push('\n');
            text.push_str(&table.to_markdown());
        }
        let _ =
            writeln!(text, "\nMade by `varsac experiment {} --seed {}`.", self.experiment.name, self.seed);
        text
    }
}

#[cfg(test)]
mod tests;
