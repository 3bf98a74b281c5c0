//! `varsac locate`: inputs to results, results to text, JSON, pictures and clouds.

use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};

pub(super) use super::locate_args::LocateArgs;
use super::{Outcome, print};
use crate::{
    cloud::Cloud,
    error::InputError,
    frame::Frame,
    locate::{Camera, Here, LearntSize, Located, Options, Searcher, locate_cloud_with, locate_frame_with},
    picture, ply_out,
    report::{InputReport, table},
};

/// Runs the command. Inputs are worked on one after the other and reported in their order; an input that cannot be
/// read does not keep the others from being worked on, but the exit code says so.
pub(super) fn run(args: &LocateArgs) -> Result<Outcome, InputError> {
    run_with(args, &mut Here)
}

/// [`run`], the regions searched by somebody else.
pub(super) fn run_with(args: &LocateArgs, searcher: &mut dyn Searcher) -> Result<Outcome, InputError> {
    let mut options = args.options()?;
    args.note_idle_options();
    let mut camera = None;
    if args.learn_size {
        let learnt = learn_size(args, &options, searcher, &mut camera);
        options = options.with_learnt_size(learnt);
    }
    let progress = progress(args.inputs.len());
    let mut outcome = Outcome::NothingFound;
    let mut failed = None;
    for path in &args.inputs {
        match one(args, path, &options, searcher, &mut camera) {
            Ok((text, found)) => {
                progress.suspend(|| print(&text))?;
                if found {
                    outcome = Outcome::Found;
                }
            }
            Err(error) if args.inputs.len() == 1 => return Err(error),
            Err(error) => {
                progress.suspend(|| eprintln!("varsac: {error}"));
                failed = Some(error);
            }
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    match failed {
        None => Ok(outcome),
        Some(error) => {
            Err(InputError::at("locate", "not every input could be read", format!("the last was: {error}")))
        }
    }
}

/// The first of two searches of `--learn-size`. What cannot be read is left to the second to name.
fn learn_size(
    args: &LocateArgs,
    options: &Options,
    searcher: &mut dyn Searcher,
    camera: &mut Option<Camera>,
) -> LearntSize {
    let loose = options.clone().with_loose_size();
    let progress = progress(args.inputs.len());
    let mut targets = Vec::new();
    for path in &args.inputs {
        if let Ok((located, _)) = located(args, path, &loose, searcher, camera) {
            targets.extend(located.targets);
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    LearntSize::of(&options.config.map.prior, &targets)
}

/// Progress on a terminal when there is more than a moment's work.
fn progress(inputs: usize) -> ProgressBar {
    if inputs < 3 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} (about {eta} left)");
    ProgressBar::new(inputs as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Reads and searches one input; a frame is returned too.
fn located(
    args: &LocateArgs,
    path: &Path,
    options: &Options,
    searcher: &mut dyn Searcher,
    camera: &mut Option<Camera>,
) -> Result<(Located, Option<Frame>), InputError> {
    let input = path.display().to_string();
    if path.is_dir() {
        let frame = Frame::read(path)?;
        let located = locate_frame_with(searcher, camera, &input, &frame, options)?;
        return Ok((located, Some(frame)));
    }
    Ok((locate_cloud_with(searcher, &input, &Cloud::read(path, args.unit)?, options)?, None))
}

/// Works on one input; returns what to print and whether anything was accepted.
fn one(
    args: &LocateArgs,
    path: &Path,
    options: &Options,
    searcher: &mut dyn Searcher,
    camera: &mut Option<Camera>,
) -> Result<(String, bool), InputError> {
    let (located, frame) = located(args, path, options, searcher, camera)?;
    if let Some(named) = &args.draw {
        let file = args.output(named, &located);
        match (&frame, camera) {
            (Some(frame), Some(camera)) => picture::of_frame(frame, camera, &located, &file)?,
            _ => picture::of_cloud(&located, &file)?,
        }
    }
    if let Some(named) = &args.cloud_out {
        let points: Vec<[f32; 3]> = located.points.iter().map(|p| [p.x, p.y, p.z]).collect();
        ply_out::write_ply(&args.output(named, &located), &points, &located.labels)?;
    }
    let found = located.accepted().next().is_some();
    let text = if args.json {
        let report = InputReport::new(&located);
        format!(
            "{}\n",
            serde_json::to_string(&report).expect("a report of numbers and strings has a JSON form")
        )
    } else {
        table(&located)
    };
    Ok((text, found))
}
