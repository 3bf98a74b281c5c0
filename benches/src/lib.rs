//! The groups of contenders that are benchmarked: those of `varsac experiment speed`, from [`varsac_host::speed`].
//!
//! A group is built when it is wanted and not before: some need a rendered frame.

use std::path::Path;

use varsac_host::error::InputError;
use varsac_host::frame::Frame;
use varsac_host::speed::{
    Contender, frames::Stages, kernels::Scoring, searches, trees::Neighbourhoods, workload,
};

/// Seed of all data.
const SEED: u64 = 1;
/// Points that are scored.
const SCORED: usize = 4096;
/// Points of the cloud whose neighbourhoods are looked up.
const TREE: usize = 4000;
/// One-sided views.
const VIEWS: u64 = 4;
/// Fruit of the frame.
const FRUIT: usize = 10;

/// A group: what is compared with what, by which unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// Scoring a point.
    Point,
    /// A neighbourhood.
    Neighbourhood,
    /// A hypothesis.
    Hypothesis,
    /// A fruit.
    Fruit,
    /// A frame.
    Frame,
}

impl Group {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Point, Self::Neighbourhood, Self::Hypothesis, Self::Fruit, Self::Frame];

    /// Its name, which is that of its unit.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Neighbourhood => "neighbourhood",
            Self::Hypothesis => "hypothesis",
            Self::Fruit => "fruit",
            Self::Frame => "frame",
        }
    }

    /// Hands its contenders to `use_them`. `frame` is a folder with the frame to use.
    ///
    /// # Errors
    /// A frame folder that cannot be read.
    pub fn with<T>(
        self,
        frame: &Path,
        use_them: impl FnOnce(Vec<Contender<'_>>) -> T,
    ) -> Result<T, InputError> {
        Ok(match self {
            Self::Point => use_them(Scoring::new(SCORED, SEED).contenders()),
            Self::Neighbourhood => use_them(Neighbourhoods::new(TREE, SEED).queries()),
            Self::Hypothesis => use_them(searches::hypotheses(&workload::views(VIEWS, SEED))),
            Self::Fruit => use_them(searches::fruit(&workload::views(VIEWS, SEED))),
            Self::Frame => use_them(Stages::of(Frame::read(frame)?)?.contenders()),
        })
    }
}

/// Renders the frame of [`Group::Frame`] into a folder: once, for all who need it.
///
/// # Errors
/// A folder that cannot be written.
pub fn render_frame(folder: &Path) -> Result<(), InputError> {
    workload::frame(FRUIT, SEED).write(folder)
}
