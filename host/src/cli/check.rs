//! `varsac check`: the recorded inputs to views, the rest is [`crate::check`].

use std::path::Path;

use super::Outcome;
use crate::{
    check::{CheckArgs, RecordedView},
    cloud::Cloud,
    decimate::decimate,
    error::InputError,
    frame::Frame,
    fruit::Fruit,
    locate::{Camera, RegionSource, views_of},
    region_view::{RegionView, ViewOptions},
    segment::preset,
};

/// Runs the command. A difference ends with exit code 1.
pub(super) fn run(args: &CheckArgs) -> Result<Outcome, InputError> {
    let mut recorded = Vec::new();
    for path in &args.inputs {
        read(path, &mut recorded)?;
    }
    Ok(if args.execute(recorded) { Outcome::Found } else { Outcome::NothingFound })
}

/// The views of one input: of a frame, those of its regions of jujube colour.
fn read(path: &Path, recorded: &mut Vec<RecordedView>) -> Result<(), InputError> {
    let name = path.display().to_string();
    let views = if path.is_dir() {
        let colour = RegionSource::Colour(preset(Fruit::Jujube.name()));
        let frame = Frame::read(path)?;
        let options = ViewOptions::of(&Fruit::Jujube.config());
        views_of(&Camera::of(&frame)?, &name, &frame, &colour, &options)?
    } else {
        vec![RegionView::of_cloud(
            decimate(&Cloud::read(path, None)?.points_mm, ViewOptions::CAPACITY).points,
        )]
    };
    for view in views {
        recorded.push(RecordedView { name: name.clone(), view });
    }
    Ok(())
}
