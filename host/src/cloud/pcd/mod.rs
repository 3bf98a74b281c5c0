//! PCD, the Point Cloud Library's file: a text header, then the points, as text, binary, or LZF-compressed.
//!
//! Uncompressed binary stores point after point; `binary_compressed` stores field after field (all x, then all y...).
//! Bytes of a number are little endian, as on every machine that PCL runs on. Whatever follows the last point of a
//! binary body is ignored: PCL's writer pads with zeros.

mod header;

use self::header::{Encoding, Header};
use super::MAX_BYTES;
use super::collect::{Collector, Spot, pick};
use super::lines::Lines;
use super::lzf::{self, Corrupt};
use super::scalar::{ByteOrder, Scalar};
use crate::error::InputError;

const BROKEN: &str = "save the cloud as PCD again";
const CUT_SHORT: &str = "copy it again, it is cut short or its header is wrong";

/// Where one coordinate stands in a binary body, bytes.
struct Column {
    scalar: Scalar,
    /// Of the first point.
    first: usize,
    /// From point to point.
    step: usize,
}

/// Reads the points of a PCD file.
pub(super) fn parse(bytes: &[u8], points: &mut Collector) -> Result<(), InputError> {
    let mut lines = Lines::of_header(bytes);
    let header = Header::parse(&mut lines, points)?;
    lines.leave_header();
    let axes = header.axes(points)?;
    if header.height > 1 {
        points.organise(header.width, header.height);
    }
    let record = header.size_before(header.fields.len());
    match header.encoding {
        Encoding::Text => read_text(&header, axes, lines, points),
        Encoding::Binary => {
            let body = lines.rest();
            check_room(&header, record.saturating_mul(header.points), body.len(), points)?;
            let columns = columns(&header, axes, |_, before| (before, record));
            read_binary(&header, &columns, body, lines.offset(), points)
        }
        Encoding::Compressed => {
            let body = decompress(&header, record, lines.rest(), points)?;
            let columns = columns(&header, axes, |size, before| (before * header.points, size));
            read_binary(&header, &columns, &body, 0, points)
        }
    }
}

/// Refuses a count that the `present` bytes cannot hold, before anything is reserved for it.
fn check_room(header: &Header, needed: usize, present: usize, points: &Collector) -> Result<(), InputError> {
    if needed <= present {
        return Ok(());
    }
    let what = format!("announces {} points, {needed} bytes at least, where {present} are", header.points);
    Err(points.error(what, CUT_SHORT))
}

/// The coordinates' places; `place` makes (first, step) of a field's size and of the bytes before it in a point.
fn columns(header: &Header, axes: [usize; 3], place: impl Fn(usize, usize) -> (usize, usize)) -> [Column; 3] {
    axes.map(|axis| {
        let field = &header.fields[axis];
        let (first, step) = place(field.size(), header.size_before(axis));
        Column { scalar: field.scalar, first, step }
    })
}

/// Reads a body that was checked to hold all points; it begins `offset` bytes into the file.
fn read_binary(
    header: &Header,
    columns: &[Column; 3],
    body: &[u8],
    offset: usize,
    points: &mut Collector,
) -> Result<(), InputError> {
    points.reserve(header.points);
    for index in 0..header.points {
        let at = |column: &Column| column.first + index * column.step;
        let xyz =
            columns.each_ref().map(|column| column.scalar.value(&body[at(column)..], ByteOrder::Little));
        points.add_or_drop(xyz, &Spot::Byte(offset + at(&columns[0])))?;
    }
    Ok(())
}

/// Unpacks the body of a `binary_compressed` file: two sizes, then the packed bytes.
fn decompress(
    header: &Header,
    record: usize,
    body: &[u8],
    points: &Collector,
) -> Result<Vec<u8>, InputError> {
    let Some((sizes, packed)) = body.split_at_checked(8) else {
        return Err(points.error("ends before its compressed points", CUT_SHORT));
    };
    let [packed_size, size] = [0, 4].map(|at| Scalar::U32.value(&sizes[at..], ByteOrder::Little) as usize);
    check_room(header, packed_size, packed.len(), points)?;
    let needed = record.saturating_mul(header.points);
    if size != needed || size as u64 > MAX_BYTES {
        let what = format!(
            "unpacks to {size} bytes where {} points take {needed} and {MAX_BYTES} are accepted",
            header.points
        );
        return Err(points.error(what, BROKEN));
    }
    lzf::decompress(&packed[..packed_size], size).map_err(|corrupt| {
        let what = match corrupt {
            Corrupt::Cut => "its compressed points end early".to_owned(),
            Corrupt::BeforeStart => "its compressed points refer to bytes before the first".to_owned(),
            Corrupt::Length => format!("its {packed_size} compressed bytes do not unpack to {size}"),
        };
        points.error(what, CUT_SHORT)
    })
}

/// Reads a text body, one point a line.
fn read_text(
    header: &Header,
    axes: [usize; 3],
    mut lines: Lines,
    points: &mut Collector,
) -> Result<(), InputError> {
    let values = header.values_before(header.fields.len());
    // A digit and a separator each; the last line may go without its line end.
    let needed = values.saturating_mul(2).saturating_mul(header.points);
    check_room(header, needed, lines.rest().len() + 1, points)?;
    points.reserve(header.points);
    let columns = axes.map(|axis| header.values_before(axis));
    for index in 0..header.points {
        let Some(line) = lines.next_filled() else {
            let what = format!("ends before point {index} of {}", header.points);
            return Err(points.error(what, CUT_SHORT));
        };
        let spot = Spot::Line(line.number);
        let (xyz, found) = points.at(&spot, pick(line.text.split_ascii_whitespace(), columns))?;
        if found != values {
            let what = format!("has {found} values where a point has {values} by the header");
            return Err(points.error_at(&spot, what, BROKEN));
        }
        points.add_or_drop(xyz, &spot)?;
    }
    lines.next_filled().map_or(Ok(()), |line| {
        let what = format!("comes after the {} points of the header", header.points);
        Err(points.error_at(&Spot::Line(line.number), what, "correct the header"))
    })
}
