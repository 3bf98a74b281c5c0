//! PLY (Turk 1994): a text header that lists elements and their properties, then the elements, as text or binary.
//!
//! Points are the x, y and z of the element `vertex`; everything else is walked over, lists included, so that a file
//! cut short anywhere is noticed.

use super::collect::{Collector, Mistake, Spot, number};
use super::lines::Lines;
use super::scalar::{ByteOrder, Scalar};
use crate::error::InputError;
use crate::file::quoted;

const BROKEN: &str = "save the cloud as PLY again";
const CUT: &str = "the file ends before it is complete";
const CUT_SHORT: &str = "copy it again, it is cut short or its header is wrong";

struct Header {
    /// None: text.
    binary: Option<ByteOrder>,
    elements: Vec<Element>,
}

struct Element {
    name: String,
    count: usize,
    properties: Vec<Property>,
}

struct Property {
    name: String,
    /// The type of the number that states a list's length; none: the property is one value.
    length: Option<Scalar>,
    value: Scalar,
}

/// Which properties of an element are x, y and z.
type Axes = [usize; 3];
/// x, y and z of one element, or what is wrong with it.
type Row = Result<[f64; 3], Mistake>;

/// Reads the vertices of a PLY file.
pub(super) fn parse(bytes: &[u8], points: &mut Collector) -> Result<(), InputError> {
    let mut lines = Lines::of_header(bytes);
    let header = Header::parse(&mut lines, points)?;
    lines.leave_header();
    let mut cursor = Cursor { bytes, position: lines.offset() };
    let mut vertices_seen = false;
    for element in header.elements.iter().filter(|element| !element.properties.is_empty()) {
        let axes = if element.name == "vertex" { Some(element.axes(points)?) } else { None };
        // The last line of a text may go without its line end.
        let present = if header.binary.is_some() { cursor.rest() } else { lines.rest().len() + 1 };
        element.check_room(header.binary.is_some(), present, points)?;
        if axes.is_some() {
            vertices_seen = true;
            points.reserve(element.count);
        }
        for index in 0..element.count {
            let (xyz, spot) = if let Some(order) = header.binary {
                let spot = Spot::Byte(cursor.position);
                (element.binary_row(&mut cursor, order, axes), spot)
            } else if let Some(line) = lines.next_filled() {
                (element.text_row(&line.text, axes), Spot::Line(line.number))
            } else {
                (Err((CUT.to_owned(), CUT_SHORT)), Spot::Byte(bytes.len()))
            };
            let xyz = xyz.map_err(|(what, remedy)| (format!("{} {index}: {what}", element.name), remedy));
            let xyz = points.at(&spot, xyz)?;
            if axes.is_some() {
                points.add(xyz, &spot)?;
            }
        }
    }
    if !vertices_seen {
        return Err(points.error("has no element vertex", "give a PLY file with vertices"));
    }
    match lines.next_filled() {
        Some(line) if header.binary.is_none() => {
            let what = "comes after everything that the header announces";
            Err(points.error_at(&Spot::Line(line.number), what, "correct the header"))
        }
        _ => Ok(()),
    }
}

impl Header {
    fn parse(lines: &mut Lines, points: &Collector) -> Result<Self, InputError> {
        if lines.next().is_none_or(|line| line.text != "ply") {
            return Err(points.error("does not begin with the line ply", "give a PLY file"));
        }
        let mut binary = None;
        let mut elements: Vec<Element> = Vec::new();
        for line in lines.by_ref() {
            let words: Vec<&str> = line.text.split_ascii_whitespace().collect();
            let known = match words[..] {
                ["comment" | "obj_info", ..] | [] => true,
                ["format", name, "1.0"] => {
                    binary = match name {
                        "ascii" => Some(None),
                        "binary_little_endian" => Some(Some(ByteOrder::Little)),
                        "binary_big_endian" => Some(Some(ByteOrder::Big)),
                        _ => None,
                    };
                    binary.is_some()
                }
                ["element", name, count] => match count.parse() {
                    // Two elements of vertices would be two clouds; other names do not matter.
                    Ok(count) if name != "vertex" || elements.iter().all(|element| element.name != name) => {
                        elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
                        true
                    }
                    _ => false,
                },
                ["property", ref property @ ..] => match (elements.last_mut(), Property::parse(property)) {
                    (Some(element), Some(property)) => {
                        element.properties.push(property);
                        true
                    }
                    _ => false,
                },
                ["end_header"] => {
                    return match binary {
                        Some(binary) => Ok(Self { binary, elements }),
                        None => Err(points.error("has no format line", BROKEN)),
                    };
                }
                _ => false,
            };
            if !known {
                let what = format!("{} is no valid header line", quoted(&line.text));
                return Err(points.error_at(&Spot::Line(line.number), what, BROKEN));
            }
        }
        Err(points.error("has no end_header line", CUT_SHORT))
    }
}

impl Property {
    /// From the words after `property`.
    fn parse(words: &[&str]) -> Option<Self> {
        let (length, value, name) = match *words {
            ["list", length, value, name] => {
                (Some(scalar(length).filter(|length| length.is_integer())?), value, name)
            }
            [value, name] => (None, value, name),
            _ => return None,
        };
        Some(Self { name: name.to_owned(), length, value: scalar(value)? })
    }
}

/// The type of a name, in the words of the original and of the later format descriptions.
fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "char" | "int8" => Scalar::I8,
        "uchar" | "uint8" => Scalar::U8,
        "short" | "int16" => Scalar::I16,
        "ushort" | "uint16" => Scalar::U16,
        "int" | "int32" => Scalar::I32,
        "uint" | "uint32" => Scalar::U32,
        "int64" => Scalar::I64,
        "uint64" => Scalar::U64,
        "float" | "float32" => Scalar::F32,
        "double" | "float64" => Scalar::F64,
        _ => return None,
    })
}

impl Element {
    fn axes(&self, points: &Collector) -> Result<Axes, InputError> {
        let mut axes = [0; 3];
        for (axis, name) in axes.iter_mut().zip(["x", "y", "z"]) {
            let mut found =
                self.properties.iter().enumerate().filter(|(_, p)| p.name == name && p.length.is_none());
            let (Some((index, _)), None) = (found.next(), found.next()) else {
                let what = format!("its vertices do not have exactly one property {name}");
                return Err(points.error(what, "save them with x, y and z"));
            };
            *axis = index;
        }
        Ok(axes)
    }

    /// Refuses a count that the `present` bytes cannot hold, before anything is reserved for it.
    fn check_room(&self, binary: bool, present: usize, points: &Collector) -> Result<(), InputError> {
        let least = |property: &Property| {
            // Text: a digit and a separator.
            if binary { property.length.unwrap_or(property.value).size() } else { 2 }
        };
        let needed = self.properties.iter().map(least).sum::<usize>().saturating_mul(self.count);
        if needed <= present {
            return Ok(());
        }
        let (count, name) = (self.count, &self.name);
        let what = format!("announces {count} times {name}, {needed} bytes at least, where {present} are");
        Err(points.error(what, CUT_SHORT))
    }

    /// Walks over one element of a binary body and returns the values of `axes`.
    fn binary_row(&self, cursor: &mut Cursor, order: ByteOrder, axes: Option<Axes>) -> Row {
        let mut xyz = [0.0; 3];
        for (column, property) in self.properties.iter().enumerate() {
            let Some(length_type) = property.length else {
                let value = property.value.value(cursor.take(property.value.size(), 1)?, order);
                if let Some(axis) = axis_of(axes, column) {
                    xyz[axis] = value;
                }
                continue;
            };
            let length = length_type.value(cursor.take(length_type.size(), 1)?, order);
            if length < 0.0 {
                return Err((format!("list {} has length {length}", property.name), BROKEN));
            }
            cursor.take(property.value.size(), length as usize)?;
        }
        Ok(xyz)
    }

    /// Walks over one element of a text body, which is one line, and returns the values of `axes`.
    fn text_row(&self, line: &str, axes: Option<Axes>) -> Row {
        let wrong_count = |how| (format!("the line has {how} values than the header states"), BROKEN);
        let mut tokens = line.split_ascii_whitespace();
        let mut xyz = [0.0; 3];
        for (column, property) in self.properties.iter().enumerate() {
            let token = tokens.next().ok_or_else(|| wrong_count("fewer"))?;
            if property.length.is_some() {
                let not_a_length =
                    |_| (format!("{} is no length of list {}", quoted(token), property.name), BROKEN);
                let length: usize = token.parse().map_err(not_a_length)?;
                if length > 0 {
                    tokens.nth(length - 1).ok_or_else(|| wrong_count("fewer"))?;
                }
            } else if let Some(axis) = axis_of(axes, column) {
                xyz[axis] = number(token)?;
            }
        }
        if tokens.next().is_some() { Err(wrong_count("more")) } else { Ok(xyz) }
    }
}

/// Which of x, y and z a column is.
fn axis_of(axes: Option<Axes>, column: usize) -> Option<usize> {
    axes?.iter().position(|&axis| axis == column)
}

/// Where a binary body has been read to.
struct Cursor<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl<'a> Cursor<'a> {
    /// Bytes left.
    fn rest(&self) -> usize {
        self.bytes.len().saturating_sub(self.position)
    }

    /// The next `count` values of `size` bytes.
    fn take(&mut self, size: usize, count: usize) -> Result<&'a [u8], Mistake> {
        let end = size.checked_mul(count).and_then(|length| self.position.checked_add(length));
        let taken = end.and_then(|end| self.bytes.get(self.position..end));
        let taken = taken.ok_or_else(|| (CUT.to_owned(), CUT_SHORT))?;
        self.position += taken.len();
        Ok(taken)
    }
}
