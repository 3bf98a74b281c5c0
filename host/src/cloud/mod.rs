//! Reads point clouds: PLY, PCD and plain text (CSV, XYZ), from a file or from standard input.
//!
//! In: bytes in any of the three formats, in millimetres or metres. Out: [`Cloud`], `f32` millimetres, in file order.
//! A header's promises are checked against the bytes that are really there before anything is reserved for them.
//!
//! *Missing measurements.* A point of a PCD file with a NaN or infinite coordinate is a pixel without a measurement
//! (organised clouds carry them); it is dropped and counted. In PLY and text the same is a mistake and is refused with
//! index and value. Recorders that write `0 0 0` instead are served by [`Cloud::drop_origin`].

mod collect;
mod lines;
mod lzf;
mod pcd;
mod ply;
mod scalar;
mod text;

use std::path::Path;

use varsac_core::Point3;

use self::collect::Collector;
use crate::error::InputError;
use crate::file;

/// Largest input, bytes: about 80 million binary points, a thousand times a camera image.
const MAX_BYTES: u64 = 1 << 30;

/// The unit in which a file states its coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Unit {
    /// Coordinates are taken as they are. Also right for data without a length unit: simulation, magnetometer.
    #[value(name = "mm")]
    Millimetre,
    /// Coordinates are multiplied by 1000.
    #[value(name = "m")]
    Metre,
}

impl Unit {
    /// Millimetres in one unit.
    pub fn in_mm(self) -> f64 {
        match self {
            Self::Millimetre => 1.0,
            Self::Metre => 1000.0,
        }
    }
}

/// The formats a cloud may come in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Polygon file format (Turk 1994), ascii or binary of either byte order.
    Ply,
    /// Point Cloud Library file, ascii, binary or `binary_compressed`.
    Pcd,
    /// One point a line, numbers parted by comma, semicolon, tab or blanks.
    Text,
}

impl Format {
    /// The format that the file name states, if it states one.
    pub fn of_name(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
            "ply" => Some(Self::Ply),
            "pcd" => Some(Self::Pcd),
            "csv" | "xyz" => Some(Self::Text),
            _ => None,
        }
    }

    /// The format that the first bytes look like: the magic words of PLY and PCD, else text unless there are bytes
    /// that no text has.
    pub fn of_content(bytes: &[u8]) -> Option<Self> {
        let start = &bytes[..bytes.len().min(512)];
        let begins = |word: &[u8]| start.starts_with(word);
        if begins(b"ply\n") || begins(b"ply\r") {
            Some(Self::Ply)
        } else if begins(b"# .PCD") || begins(b"VERSION ") || begins(b"FIELDS ") {
            Some(Self::Pcd)
        } else if start.iter().any(|&byte| byte < b'\t') {
            None
        } else {
            Some(Self::Text)
        }
    }

    /// The unit taken when the user names none. The one place where this is decided: PCD files come from RGB-D
    /// recorders of the PCL and ROS family, whose convention is metres; scanners and loggers write millimetres.
    pub fn default_unit(self) -> Unit {
        match self {
            Self::Pcd => Unit::Metre,
            Self::Ply | Self::Text => Unit::Millimetre,
        }
    }
}

/// The image grid of an organised cloud, row-major.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grid {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// For each point kept, its cell: `row * width + column`, ascending.
    pub cells: Vec<u32>,
}

/// A point cloud as read from one input.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloud {
    /// The file name without folder and extension.
    pub name: String,
    /// Finite points, millimetres, in file order; never empty when returned by [`Self::read`].
    pub points_mm: Vec<Point3>,
    /// Points of the file that carried no measurement and were dropped.
    pub dropped: usize,
    /// Where the sensor stood, millimetres, in the frame of the points; only PCD files say so.
    pub viewpoint_mm: Option<Point3>,
    /// The grid, when the file has more than one row of points.
    pub grid: Option<Grid>,
}

impl Cloud {
    /// Reads a cloud; `-` is standard input. The format follows from the extension, else from the content; without
    /// `unit`, [`Format::default_unit`] holds.
    ///
    /// # Errors
    /// One sentence with file, line or byte, the offending value and a remedy: unreadable, unknown, truncated or
    /// contradictory file, no x y z, no points, a coordinate that is not finite or beyond
    /// [`varsac_core::point::MAX_COORDINATE`].
    pub fn read(path: &Path, unit: Option<Unit>) -> Result<Self, InputError> {
        if path.as_os_str() == "-" {
            let place = "standard input";
            let bytes = file::read_stream(std::io::stdin().lock(), place, MAX_BYTES)?;
            return Self::parse(place, &bytes, Format::of_content(&bytes), unit);
        }
        let bytes = file::read_whole(path, MAX_BYTES)?;
        let format = Format::of_name(path).or_else(|| Format::of_content(&bytes));
        let mut cloud = Self::parse(&path.display().to_string(), &bytes, format, unit)?;
        cloud.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(cloud)
    }

    /// [`Self::read`] for bytes already in memory; `place` names them in errors and becomes the cloud's name.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(
        place: &str,
        bytes: &[u8],
        format: Option<Format>,
        unit: Option<Unit>,
    ) -> Result<Self, InputError> {
        let Some(format) = format else {
            let remedy = "give a .ply, .pcd, .csv or .xyz file, or a frame folder";
            return Err(InputError::at(place, "is no point cloud in a known format", remedy));
        };
        let mut points = Collector::new(place, unit.unwrap_or(format.default_unit()));
        match format {
            Format::Ply => ply::parse(bytes, &mut points)?,
            Format::Pcd => pcd::parse(bytes, &mut points)?,
            Format::Text => text::parse(bytes, &mut points)?,
        }
        points.finish()
    }

    /// Drops points at exactly (0, 0, 0) and counts them. For clouds in camera coordinates, where the origin is the
    /// camera itself and some recorders write it for "no measurement"; wrong for complete surfaces and for logs.
    pub fn drop_origin(&mut self) {
        let keep: Vec<bool> = self.points_mm.iter().map(|point| *point != Point3::origin()).collect();
        self.dropped += keep.iter().filter(|&&kept| !kept).count();
        retain(&mut self.points_mm, &keep);
        if let Some(grid) = &mut self.grid {
            retain(&mut grid.cells, &keep);
        }
    }
}

fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut kept = keep.iter();
    values.retain(|_| kept.next() == Some(&true));
}

#[cfg(test)]
mod tests;
