//! What the three parsers share: where a point goes, what is checked on the way, and how a mistake is worded.

use varsac_core::Point3;
use varsac_core::point::MAX_COORDINATE;

use super::{Cloud, Grid, Unit};
use crate::error::InputError;
use crate::file;

/// Where in a file something stands.
pub(super) enum Spot {
    /// Counted from 1.
    Line(usize),
    /// Counted from 0.
    Byte(usize),
}

impl std::fmt::Display for Spot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(number) => write!(f, "line {number}"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
        }
    }
}

/// What is wrong, and what the user can do; the place is added by whoever knows it.
pub(super) type Mistake = (String, &'static str);

/// The number that a token of a text stands for; "nan" and "inf" are numbers here, [`Collector::add`] judges them.
pub(super) fn number(token: &str) -> Result<f64, Mistake> {
    let remedy = "write numbers with a decimal point, such as -1.5 or 2e3";
    token.parse().map_err(|_| (format!("{} is no number", file::quoted(token)), remedy))
}

/// The numbers in three columns of a line, and how many columns there are; a column that is not there yields 0.
pub(super) fn pick<'t>(
    tokens: impl Iterator<Item = &'t str>,
    columns: [usize; 3],
) -> Result<([f64; 3], usize), Mistake> {
    let (mut xyz, mut found) = ([0.0; 3], 0);
    for (column, token) in tokens.enumerate() {
        if let Some(axis) = columns.iter().position(|&wanted| wanted == column) {
            xyz[axis] = number(token)?;
        }
        found = column + 1;
    }
    Ok((xyz, found))
}

/// What a parser hands its points to: scales, converts and checks them, and knows how to word an error.
pub(super) struct Collector<'a> {
    place: &'a str,
    pub(super) unit: Unit,
    /// Points seen so far, kept or dropped.
    seen: usize,
    pub(super) cloud: Cloud,
}

impl<'a> Collector<'a> {
    pub(super) fn new(place: &'a str, unit: Unit) -> Self {
        let cloud = Cloud {
            name: place.to_owned(),
            points_mm: Vec::new(),
            dropped: 0,
            viewpoint_mm: None,
            grid: None,
        };
        Self { place, unit, seen: 0, cloud }
    }

    /// A mistake of the whole file.
    pub(super) fn error(&self, what: impl Into<String>, remedy: &str) -> InputError {
        InputError::at(self.place, what, remedy)
    }

    /// A mistake at one place of the file.
    pub(super) fn error_at(&self, spot: &Spot, what: impl Into<String>, remedy: &str) -> InputError {
        InputError::at(format!("{}, {spot}", self.place), what, remedy)
    }

    /// Puts a mistake in its place.
    pub(super) fn at<T>(&self, spot: &Spot, result: Result<T, Mistake>) -> Result<T, InputError> {
        result.map_err(|(what, remedy)| self.error_at(spot, what, remedy))
    }

    /// Makes room for `count` points. Call it only once the file is known to hold that many.
    pub(super) fn reserve(&mut self, count: usize) {
        self.cloud.points_mm.reserve_exact(count);
    }

    /// From now on a point belongs to the next cell of a grid.
    pub(super) fn organise(&mut self, width: usize, height: usize) {
        self.cloud.grid = Some(Grid { width, height, cells: Vec::new() });
    }

    /// Takes the next point of the file, which stands at `spot`.
    pub(super) fn add(&mut self, xyz: [f64; 3], spot: &Spot) -> Result<(), InputError> {
        // f64 holds every f32 and its product with 1000 exactly, so f32 metres are rounded once.
        let scaled = xyz.map(|value| (value * self.unit.in_mm()) as f32);
        // NaN is in no range.
        let accepted = -MAX_COORDINATE..=MAX_COORDINATE;
        if let Some(axis) = scaled.iter().position(|value| !accepted.contains(value)) {
            let (name, value) = (["x", "y", "z"][axis], xyz[axis]);
            // Debug, because Display writes 1e300 with all its zeros.
            let what = format!("point {}: {name} is {value:?}", self.seen);
            return Err(if value.is_finite() {
                let what = format!("{what}, beyond the {MAX_COORDINATE:e} mm that are accepted");
                self.error_at(spot, what, "check the unit (--unit mm|m) and the file")
            } else {
                let remedy = "remove the point, or save the cloud as PCD, where it means \"no measurement\"";
                self.error_at(spot, what, remedy)
            });
        }
        if let Some(grid) = &mut self.cloud.grid {
            grid.cells.push(self.seen as u32);
        }
        self.cloud.points_mm.push(Point3::from(scaled));
        self.seen += 1;
        Ok(())
    }

    /// Takes the next point of the file where a coordinate that is not finite means "no measurement".
    pub(super) fn add_or_drop(&mut self, xyz: [f64; 3], spot: &Spot) -> Result<(), InputError> {
        if xyz.iter().all(|value| value.is_finite()) {
            return self.add(xyz, spot);
        }
        self.seen += 1;
        self.cloud.dropped += 1;
        Ok(())
    }

    pub(super) fn finish(self) -> Result<Cloud, InputError> {
        if !self.cloud.points_mm.is_empty() {
            return Ok(self.cloud);
        }
        let what = match self.cloud.dropped {
            0 => "holds no points".to_owned(),
            count => format!("holds {count} points and none of them is a measurement"),
        };
        Err(self.error(what, "give a cloud with points"))
    }
}
