//! The command line: `varsac demo | locate | check | simulate | experiment | completions`.
//!
//! Results go to standard output, notes and progress to standard error. Exit code 0: found, 1: nothing found (or a
//! difference, for `simulate --check`), 2: usage or input that cannot be read.

mod check;
mod demo;
mod experiment;
mod locate;
mod locate_args;
mod simulate;

use clap::{CommandFactory, Parser, Subcommand};

use crate::{check::CheckArgs, error::InputError};

/// Finds ellipsoidal fruit in depth-camera views: where each one is, how big, how it lies.
#[derive(Debug, Parser)]
#[command(
    name = "varsac",
    version,
    after_help = "Exit code: 0 found, 1 nothing found, 2 usage or unreadable input.\nWithout a command: demo."
)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a Kinect v2 view of jujubes, locate every fruit, compare with the truth and draw the result.
    Demo(demo::DemoArgs),
    /// Locate fruit in frame folders and point clouds.
    Locate(Box<locate::LocateArgs>),
    /// Compare the core with the float reference, every stage, bit for bit.
    Check(CheckArgs),
    /// Locate fruit as locate does, but searched by a co-processor: a thread, an emulated board, or a real one.
    Simulate(Box<simulate::SimulateArgs>),
    /// Repeat an experiment of the paper, or one of ours, and write tables, figures and a report.
    Experiment(Box<experiment::ExperimentArgs>),
    /// Print the completions of a shell to standard output.
    Completions {
        /// The shell to complete for.
        shell: clap_complete::Shell,
    },
}

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Exit code 0.
    Found,
    /// Exit code 1.
    NothingFound,
}

/// Runs the program and returns its exit code.
pub fn main() -> u8 {
    match run(Cli::parse()) {
        Ok(Outcome::Found) => 0,
        Ok(Outcome::NothingFound) => 1,
        Err(error) => {
            eprintln!("varsac: {error}");
            2
        }
    }
}

fn run(cli: Cli) -> Result<Outcome, InputError> {
    match cli.command {
        None => demo::run(&demo::DemoArgs::default()),
        Some(Command::Demo(args)) => demo::run(&args),
        Some(Command::Locate(args)) => locate::run(&args),
        Some(Command::Check(args)) => check::run(&args),
        Some(Command::Simulate(args)) => simulate::run(&args),
        Some(Command::Experiment(args)) => experiment::run(&args),
        Some(Command::Completions { shell }) => {
            clap_complete::generate(shell, &mut Cli::command(), "varsac", &mut std::io::stdout());
            Ok(Outcome::Found)
        }
    }
}

/// Writes to standard output; a reader that went away (`| head`) is no error.
fn print(text: &str) -> Result<(), InputError> {
    use std::io::Write as _;
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(InputError::at(
            "standard output",
            format!("cannot be written ({error})"),
            "check where it goes",
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn the_examples_in_the_help_are_commands() {
        let program = Cli::command();
        let mut examples = 0;
        for command in program.get_subcommands() {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            for line in help.lines().filter_map(|line| line.strip_prefix("  varsac ")) {
                // Behind many blanks comes what it is for; what the shell does is not ours.
                let words = line.split("     ").next().unwrap().split(" > ").next().unwrap();
                let words = std::iter::once("varsac").chain(words.split_whitespace());
                let parsed = Cli::try_parse_from(words);
                assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
                examples += 1;
            }
        }
        assert!(examples > 8);
    }
}
