//! CSV and XYZ: one point a line; `#` begins a comment; blank lines are skipped.
//!
//! A line is split at semicolons if it has any, else at commas, else at blanks and tabs, so that "1,5;2,5;3,5" is an
//! error about the decimal comma and never the point (1, 5, 2). The first line may name the columns: then x, y and z
//! may stand anywhere; without names they are the first three. Other columns are ignored.

use super::collect::{Collector, Spot, pick};
use super::lines::Lines;
use crate::error::InputError;
use crate::file::quoted;

const REMEDY: &str = "give one point a line, such as 1.5,-2,700, parted by comma, semicolon, tab or blanks";

/// Reads the points of a text.
pub(super) fn parse(bytes: &[u8], points: &mut Collector) -> Result<(), InputError> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let mut columns = None;
    for line in Lines::new(bytes) {
        let content = line.text.split('#').next().unwrap_or_default().trim();
        if content.is_empty() {
            continue;
        }
        let spot = Spot::Line(line.number);
        let columns = match columns {
            Some(columns) => columns,
            None => match named_columns(content) {
                Header::Columns(named) => {
                    columns = Some(named);
                    continue;
                }
                Header::Unclear => {
                    let what = format!("{} names columns, but not x, y and z", quoted(content));
                    return Err(points.error_at(&spot, what, "name the three columns x, y and z"));
                }
                Header::None => *columns.insert([0, 1, 2]),
            },
        };
        let (xyz, found) = points.at(&spot, pick(tokens(content), columns))?;
        let needed = 1 + columns.into_iter().max().unwrap_or(0);
        if found < needed {
            let what = format!("has {found} of {needed} values ({})", quoted(content));
            return Err(points.error_at(&spot, what, REMEDY));
        }
        points.add(xyz, &spot)?;
    }
    Ok(())
}

/// What the first line turns out to be.
enum Header {
    /// A point.
    None,
    /// Names; x, y and z stand in these columns.
    Columns([usize; 3]),
    /// Names, but not the three that are needed.
    Unclear,
}

fn named_columns(content: &str) -> Header {
    // CloudCompare writes its names behind slashes.
    let names = content.trim_start_matches('/').trim_start();
    // "1,5" between semicolons is a mistyped number and no name.
    let numeric = |token: &str| {
        token.parse::<f64>().is_ok() || token.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c))
    };
    if tokens(names).any(numeric) {
        return Header::None;
    }
    let column = |wanted: &str| {
        tokens(names).position(|name| name.trim_matches(['"', '\'']).trim().eq_ignore_ascii_case(wanted))
    };
    match (column("x"), column("y"), column("z")) {
        (Some(x), Some(y), Some(z)) => Header::Columns([x, y, z]),
        // Three columns under whatever names are in no doubt.
        _ if tokens(names).count() == 3 => Header::Columns([0, 1, 2]),
        _ => Header::Unclear,
    }
}

/// The values of a line.
fn tokens(content: &str) -> impl Iterator<Item = &str> {
    let separator = [';', ','].into_iter().find(|&separator| content.contains(separator));
    let splits = move |c: char| separator.map_or(c.is_whitespace(), |separator| c == separator);
    content.split(splits).map(str::trim).filter(move |token| separator.is_some() || !token.is_empty())
}
