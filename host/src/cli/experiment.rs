//! `varsac experiment`: runs experiments by name, prints their tables, writes their files.

use std::path::PathBuf;

use clap::{Args, builder::PossibleValue};

use super::{Outcome, print};
use crate::{
    error::InputError,
    experiment::{Context, EXPERIMENTS, Experiment, Finished, find, write},
    fruit::Fruit,
};

/// Options of `varsac experiment`.
#[derive(Debug, Args)]
pub(super) struct ExperimentArgs {
    /// Which experiment.
    #[arg(value_parser = names())]
    name: String,
    /// Number of runs; each experiment has its own default, chosen for less than a minute.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    seeds: Option<u64>,
    /// Seed of the first run; the others follow.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Where to write tables (Markdown, JSON), figures (SVG, PNG) and the report (HTML).
    #[arg(long, value_name = "DIR", default_value = "varsac-experiments")]
    out: PathBuf,
    /// A frame folder that fig9 and fig10 show beside the rendered one.
    #[arg(long, value_name = "DIR")]
    frame: Option<PathBuf>,
    /// The fruit in that frame.
    #[arg(long, value_enum, default_value_t = Fruit::Jujube)]
    fruit: Fruit,
    /// Mask of one fruit seen from the front, for similarity.
    #[arg(long, value_name = "MASK.png", requires = "bottom")]
    front: Option<PathBuf>,
    /// Mask of the same fruit seen from its bottom, for similarity.
    #[arg(long, value_name = "MASK.png", requires = "front")]
    bottom: Option<PathBuf>,
    /// Print JSON and no tables.
    #[arg(long)]
    json: bool,
}

fn names() -> Vec<PossibleValue> {
    let ours =
        EXPERIMENTS.iter().map(|experiment| PossibleValue::new(experiment.name).help(experiment.purpose));
    ours.chain([
        PossibleValue::new("all").help("Every experiment, into one report."),
        PossibleValue::new("list").help("Print the names and what each shows."),
    ])
    .collect()
}

/// Runs the command.
pub(super) fn run(args: &ExperimentArgs) -> Result<Outcome, InputError> {
    let chosen: Vec<&Experiment> = match args.name.as_str() {
        "list" => {
            let line = |experiment: &Experiment| format!("{:<14}{}\n", experiment.name, experiment.purpose);
            print(&EXPERIMENTS.iter().map(line).collect::<String>())?;
            return Ok(Outcome::Found);
        }
        "all" => EXPERIMENTS.iter().collect(),
        name => find(name).into_iter().collect(),
    };
    let masks = args.front.clone().zip(args.bottom.clone()).map(|(front, bottom)| [front, bottom]);
    let context = Context {
        seed: args.seed,
        seeds: args.seeds,
        frame: args.frame.clone(),
        fruit: args.fruit,
        masks,
        ..Context::default()
    }
    .with_progress();
    let mut finished = Vec::new();
    for experiment in chosen {
        let one = Finished::of(experiment, &context)?;
        if !args.json {
            print(&one.to_text())?;
            print("\n")?;
        }
        finished.push(one);
    }
    let page = write::write(&finished, &args.out)?;
    if args.json {
        let values: Vec<_> = finished.iter().map(Finished::to_json).collect();
        print(&write::pretty(&values.into()))?;
    } else {
        print(&format!("Report: {}\n", page.display()))?;
    }
    Ok(Outcome::Found)
}
