//! One kind of table for all experiments, and its four renderings: Markdown, JSON, HTML and plain text.

use std::fmt::Write as _;

use serde_json::{Map, Value};

/// How the keys of values end that depend on the clock: times, and quotients of times.
pub(super) const TIMING_SUFFIXES: [&str; 3] = ["_ms", "_us", "_ratio"];

/// A column: how JSON calls it, how people read it, how its numbers are rounded for them.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Key in JSON: lower case with underscores, with the unit. Keys that end in `_ms`, `_us` or `_ratio` hold times
    /// and their quotients, which differ from run to run; see [`Column::is_timing`].
    pub key: &'static str,
    /// Heading, with the unit.
    pub heading: String,
    /// Decimals shown; JSON has them all.
    pub decimals: usize,
}

impl Column {
    /// A column.
    pub fn new(key: &'static str, heading: impl Into<String>, decimals: usize) -> Self {
        Self { key, heading: heading.into(), decimals }
    }

    /// Whether its values depend on the clock.
    pub fn is_timing(&self) -> bool {
        TIMING_SUFFIXES.iter().any(|suffix| self.key.ends_with(suffix))
    }
}

/// A value in a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Words.
    Text(String),
    /// An exact count.
    Count(u64),
    /// A measured number.
    Number(f64),
    /// There is none.
    Missing,
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<u64> for Cell {
    fn from(count: u64) -> Self {
        Self::Count(count)
    }
}

impl From<u32> for Cell {
    fn from(count: u32) -> Self {
        Self::Count(count.into())
    }
}

impl From<usize> for Cell {
    fn from(count: usize) -> Self {
        Self::Count(count as u64)
    }
}

impl<T: Into<Self>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Self::Missing, Into::into)
    }
}

/// A row of anything that becomes a [`Cell`].
macro_rules! row {
    ($($cell:expr),+ $(,)?) => { vec![$($crate::experiment::table::Cell::from($cell)),+] };
}
pub(crate) use row;

/// A table.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// Columns.
    pub columns: Vec<Column>,
    /// Rows, each as long as there are columns.
    pub rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table without rows.
    pub fn new(title: impl Into<String>, columns: Vec<Column>) -> Self {
        Self { title: title.into(), columns, rows: Vec::new() }
    }

    /// Adds a row.
    ///
    /// # Panics
    /// When it is not as long as there are columns.
    pub fn push(&mut self, row: Vec<Cell>) {
        assert_eq!(
            row.len(),
            self.columns.len(),
            "a row of {} has another length than its heading",
            self.title
        );
        self.rows.push(row);
    }

    /// An object with `title` and `rows`, each row an object. What is not finite is null.
    pub fn to_json(&self) -> Value {
        let rows = self.rows.iter().map(|row| {
            let named =
                self.columns.iter().zip(row).map(|(column, cell)| (column.key.to_owned(), json(cell)));
            Value::Object(named.collect::<Map<_, _>>())
        });
        serde_json::json!({"title": self.title, "rows": rows.collect::<Vec<_>>()})
    }

    /// A heading and a pipe table.
    pub fn to_markdown(&self) -> String {
        let mut text = format!("## {}\n\n", self.title);
        let escaped =
            |cells: Vec<String>| cells.iter().map(|c| c.replace('|', "\\|")).collect::<Vec<_>>().join(" | ");
        let _ = writeln!(text, "| {} |", escaped(self.headings()));
        let rules: Vec<&str> =
            (0..self.columns.len()).map(|k| if self.is_text(k) { "---" } else { "---:" }).collect();
        let _ = writeln!(text, "| {} |", rules.join(" | "));
        for row in self.shown() {
            let _ = writeln!(text, "| {} |", escaped(row));
        }
        text
    }

    /// A `<table>` with a caption.
    pub fn to_html(&self) -> String {
        let mut text = format!("<table>\n<caption>{}</caption>\n<tr>", escape_html(&self.title));
        let class = |k| if self.is_text(k) { " class=\"words\"" } else { "" };
        for (k, heading) in self.headings().iter().enumerate() {
            let _ = write!(text, "<th{}>{}</th>", class(k), escape_html(heading));
        }
        text.push_str("</tr>\n");
        for row in self.shown() {
            text.push_str("<tr>");
            for (k, cell) in row.iter().enumerate() {
                let _ = write!(text, "<td{}>{}</td>", class(k), escape_html(cell));
            }
            text.push_str("</tr>\n");
        }
        text.push_str("</table>\n");
        text
    }

    /// Aligned columns for a terminal.
    pub fn to_text(&self) -> String {
        let lines: Vec<Vec<String>> = std::iter::once(self.headings()).chain(self.shown()).collect();
        let width = |k: usize| lines.iter().map(|line| line[k].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        let mut text = format!("{}\n", self.title);
        for line in &lines {
            let mut padded = String::new();
            for (k, cell) in line.iter().enumerate() {
                let _ = if self.is_text(k) {
                    write!(padded, "  {cell:<width$}", width = widths[k])
                } else {
                    write!(padded, "  {cell:>width$}", width = widths[k])
                };
            }
            let _ = writeln!(text, "{}", padded.trim_end());
        }
        text
    }

    fn headings(&self) -> Vec<String> {
        self.columns.iter().map(|column| column.heading.clone()).collect()
    }

    fn shown(&self) -> impl Iterator<Item = Vec<String>> + '_ {
        self.rows
            .iter()
            .map(|row| self.columns.iter().zip(row).map(|(column, cell)| shown(cell, column)).collect())
    }

    fn is_text(&self, column: usize) -> bool {
        self.rows.iter().any(|row| matches!(row[column], Cell::Text(_)))
    }
}

fn shown(cell: &Cell, column: &Column) -> String {
    match cell {
        Cell::Text(text) => text.clone(),
        Cell::Count(count) => count.to_string(),
        Cell::Number(value) if value.is_finite() => format!("{value:.*}", column.decimals),
        Cell::Number(_) | Cell::Missing => "-".to_owned(),
    }
}

fn json(cell: &Cell) -> Value {
    match cell {
        Cell::Text(text) => text.as_str().into(),
        Cell::Count(count) => (*count).into(),
        Cell::Number(value) => (*value).into(),
        Cell::Missing => Value::Null,
    }
}

/// Text for between HTML or SVG tags.
pub(crate) fn escape_html(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let columns = vec![
            Column::new("method", "method", 0),
            Column::new("centre_mm", "RMS-c mm", 2),
            Column::new("trials", "trials", 0),
        ];
        let mut table = Table::new("a < b", columns);
        table.push(row!["x|y", 1.2345, 7_u32]);
        table.push(row!["direct", f64::NAN, None::<u64>]);
        table
    }

    #[test]
    fn markdown_aligns_numbers_and_escapes_pipes() {
        let expected = "## a < b\n\n| method | RMS-c mm | trials |\n| --- | ---: | ---: |\n\
                        | x\\|y | 1.23 | 7 |\n| direct | - | - |\n";
        assert_eq!(table().to_markdown(), expected);
    }

    #[test]
    fn json_has_all_decimals_and_null_for_what_is_missing() {
        let expected = serde_json::json!({"title": "a < b", "rows": [
            {"method": "x|y", "centre_mm": 1.2345, "trials": 7},
            {"method": "direct", "centre_mm": null, "trials": null}]});
        assert_eq!(table().to_json(), expected);
    }

    #[test]
    fn html_is_escaped_and_text_is_aligned() {
        let html = table().to_html();
        assert!(
            html.contains("<caption>a &lt; b</caption>") && html.contains("<td class=\"words\">x|y</td>")
        );
        assert_eq!(
            table().to_text(),
            "a < b\n  method  RMS-c mm  trials\n  x|y         1.23       7\n  direct         -       -\n"
        );
    }

    #[test]
    fn times_are_known_by_their_keys() {
        assert!(Column::new("time_ms", "", 0).is_timing() && Column::new("speed_ratio", "", 0).is_timing());
        assert!(!Column::new("rms_c_mm_share", "", 0).is_timing());
    }

    #[test]
    #[should_panic(expected = "another length")]
    fn a_short_row_is_a_mistake() {
        table().push(row!["x"]);
    }
}
