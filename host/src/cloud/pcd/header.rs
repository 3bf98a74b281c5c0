//! The header of a PCD file: which fields a point has, how many points there are, and how they are stored.

use varsac_core::Point3;

use super::super::collect::{Collector, Spot};
use super::super::lines::{Line, Lines};
use super::super::scalar::Scalar;
use super::{BROKEN, CUT_SHORT};
use crate::error::InputError;
use crate::file::quoted;

/// What the header promises; the sizes in it are not yet checked against the file.
pub(super) struct Header {
    pub(super) fields: Vec<Field>,
    /// Columns of the grid.
    pub(super) width: usize,
    /// Rows of the grid; 1: no grid.
    pub(super) height: usize,
    /// `width * height`.
    pub(super) points: usize,
    pub(super) encoding: Encoding,
}

/// One field of a point.
pub(super) struct Field {
    name: String,
    pub(super) scalar: Scalar,
    /// Numbers of this field in a point.
    count: usize,
}

impl Field {
    /// Bytes in a point.
    pub(super) fn size(&self) -> usize {
        self.scalar.size().saturating_mul(self.count)
    }
}

/// How the points are stored.
#[derive(Clone, Copy)]
pub(super) enum Encoding {
    Text,
    Binary,
    Compressed,
}

/// The words of the header lines, as far as they come in any order.
#[derive(Default)]
struct Words {
    fields: Vec<String>,
    sizes: Vec<String>,
    types: Vec<String>,
    counts: Option<Vec<String>>,
    width: Option<usize>,
    height: Option<usize>,
    points: Option<usize>,
}

impl Header {
    /// Reads up to and including the DATA line; a VIEWPOINT goes to `points` at once.
    pub(super) fn parse(lines: &mut Lines, points: &mut Collector) -> Result<Self, InputError> {
        let mut words = Words::default();
        while let Some(line) = lines.next_filled() {
            let Some(encoding) = words.take(&line, points)? else { continue };
            return words.finish(encoding, points);
        }
        Err(points.error("has no DATA line", CUT_SHORT))
    }

    /// The fields x, y and z.
    pub(super) fn axes(&self, points: &Collector) -> Result<[usize; 3], InputError> {
        let mut axes = [0; 3];
        for (axis, name) in axes.iter_mut().zip(["x", "y", "z"]) {
            let mut found =
                self.fields.iter().enumerate().filter(|(_, field)| field.name == name && field.count == 1);
            let (Some((index, _)), None) = (found.next(), found.next()) else {
                let what = format!("does not have exactly one field {name} with COUNT 1");
                return Err(points.error(what, "save it with x, y and z"));
            };
            *axis = index;
        }
        Ok(axes)
    }

    /// Numbers of the fields before `field` in one point.
    pub(super) fn values_before(&self, field: usize) -> usize {
        self.fields.iter().take(field).fold(0, |sum, field| sum.saturating_add(field.count))
    }

    /// Bytes of the fields before `field` in one point.
    pub(super) fn size_before(&self, field: usize) -> usize {
        self.fields.iter().take(field).fold(0, |sum, field| sum.saturating_add(field.size()))
    }
}

impl Words {
    /// Takes one line; the DATA line ends the header with the encoding.
    fn take(&mut self, line: &Line, points: &mut Collector) -> Result<Option<Encoding>, InputError> {
        let bad = |points: &Collector| {
            let what = format!("{} is no valid header line", quoted(&line.text));
            points.error_at(&Spot::Line(line.number), what, BROKEN)
        };
        if line.text.starts_with('#') {
            return Ok(None);
        }
        let (key, rest) = line.text.split_once(char::is_whitespace).unwrap_or((&line.text, ""));
        let values = || rest.split_whitespace().map(str::to_owned).collect();
        let count = || rest.trim().parse().map(Some).map_err(|_| bad(points));
        match key {
            "VERSION" => {}
            "FIELDS" | "COLUMNS" => self.fields = values(),
            "SIZE" => self.sizes = values(),
            "TYPE" => self.types = values(),
            "COUNT" => self.counts = Some(values()),
            "WIDTH" => self.width = count()?,
            "HEIGHT" => self.height = count()?,
            "POINTS" => self.points = count()?,
            "VIEWPOINT" => {
                let pose = rest.split_whitespace().map(|value| value.parse::<f64>().map_err(|_| bad(points)));
                // Translation, then a quaternion, which lines of sight do not need.
                let [x, y, z, _, _, _, _] = pose.collect::<Result<Vec<_>, _>>()?[..] else {
                    return Err(bad(points));
                };
                let position = [x, y, z].map(|value| (value * points.unit.in_mm()) as f32);
                if !position.iter().all(|value| value.is_finite()) {
                    return Err(bad(points));
                }
                points.cloud.viewpoint_mm = Some(Point3::from(position));
            }
            "DATA" => {
                return match rest.trim() {
                    "ascii" => Ok(Some(Encoding::Text)),
                    "binary" => Ok(Some(Encoding::Binary)),
                    "binary_compressed" => Ok(Some(Encoding::Compressed)),
                    _ => Err(bad(points)),
                };
            }
            _ => return Err(bad(points)),
        }
        Ok(None)
    }

    fn finish(self, encoding: Encoding, points: &Collector) -> Result<Header, InputError> {
        let counts = self.counts.unwrap_or_else(|| vec!["1".to_owned(); self.fields.len()]);
        if [self.sizes.len(), self.types.len(), counts.len()] != [self.fields.len(); 3] {
            let what = "its FIELDS, SIZE, TYPE and COUNT lines differ in length";
            return Err(points.error(what, BROKEN));
        }
        let mut fields = Vec::with_capacity(self.fields.len());
        for (((name, size), kind), count) in
            self.fields.into_iter().zip(&self.sizes).zip(&self.types).zip(&counts)
        {
            let (Some(scalar), Ok(count)) = (scalar(kind, size), count.parse()) else {
                let what = format!(
                    "field {} has TYPE {}, SIZE {}, COUNT {}",
                    quoted(&name),
                    quoted(kind),
                    quoted(size),
                    quoted(count)
                );
                return Err(points.error(what, "use TYPE I or U with SIZE 1, 2, 4 or 8, or F with 4 or 8"));
            };
            fields.push(Field { name, scalar, count });
        }
        let height = self.height.unwrap_or(1);
        let Some(width) = self.width.or(self.points) else {
            return Err(points.error("has neither WIDTH nor POINTS", BROKEN));
        };
        match width.checked_mul(height) {
            Some(cells) if self.points.is_none_or(|stated| stated == cells) => {
                Ok(Header { fields, width, height, points: cells, encoding })
            }
            _ => {
                let stated = self.points.map_or("a number that fits".to_owned(), |stated| stated.to_string());
                let what = format!("WIDTH {width} times HEIGHT {height} is not POINTS, {stated}");
                Err(points.error(what, "correct the header"))
            }
        }
    }
}

/// The number type of a TYPE letter and a SIZE in bytes.
fn scalar(kind: &str, size: &str) -> Option<Scalar> {
    Some(match (kind, size) {
        ("I", "1") => Scalar::I8,
        ("U", "1") => Scalar::U8,
        ("I", "2") => Scalar::I16,
        ("U", "2") => Scalar::U16,
        ("I", "4") => Scalar::I32,
        ("U", "4") => Scalar::U32,
        ("I", "8") => Scalar::I64,
        ("U", "8") => Scalar::U64,
        ("F", "4") => Scalar::F32,
        ("F", "8") => Scalar::F64,
        _ => return None,
    })
}
