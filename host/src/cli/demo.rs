//! `varsac demo`: the whole way from a rendered Kinect v2 pair to a picture, in one command.

use std::path::PathBuf;

use clap::Args;

use super::{Outcome, print};
use crate::{demo, error::InputError, frame::Frame, picture};

/// Options of `varsac demo`.
#[derive(Debug, Args)]
pub(super) struct DemoArgs {
    /// Seed of the scene and of the search.
    #[arg(long, default_value_t = demo::SEED)]
    seed: u64,
    /// Where to draw the result.
    #[arg(long, value_name = "FILE.png", default_value = demo::PICTURE)]
    draw: PathBuf,
    /// Also save the rendered frame as a folder that `varsac locate` reads.
    #[arg(long, value_name = "FOLDER")]
    save_frame: Option<PathBuf>,
}

impl Default for DemoArgs {
    fn default() -> Self {
        Self { seed: demo::SEED, draw: demo::PICTURE.into(), save_frame: None }
    }
}

/// Runs the command.
pub(super) fn run(args: &DemoArgs) -> Result<Outcome, InputError> {
    let demo = demo::run(args.seed)?;
    if let Some(folder) = &args.save_frame {
        Frame::write(&demo.frame, folder)?;
    }
    picture::of_frame(&demo.frame, &demo.camera, &demo.located, &args.draw)?;
    print(&demo.table())?;
    print(&format!("Picture: {}\n", args.draw.display()))?;
    Ok(if demo.located.accepted().next().is_some() { Outcome::Found } else { Outcome::NothingFound })
}
