//! Figures: charts that say what they show, and pictures. Both become SVG and PNG.

use std::fmt::Write as _;

use super::plot;
use crate::{
    draw::canvas::{Colour, encode_png},
    error::InputError,
    image::ColourImage,
};

/// A figure of a report.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// End of its files' names; the experiment's name comes first.
    pub name: String,
    /// What is to be seen.
    pub caption: String,
    /// What is drawn.
    pub content: Content,
}

/// What a figure consists of.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// Charts, two in a row.
    Charts(Vec<Chart>),
    /// A picture made of pixels.
    Picture(ColourImage),
}

/// Axes and what is drawn between them.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// What it shows.
    pub title: String,
    /// To the right.
    pub x: Axis,
    /// Upwards.
    pub y: Axis,
    /// In the order of drawing.
    pub series: Vec<Series>,
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Ends; nothing to cover the data.
    pub range: Option<[f64; 2]>,
    /// Equal steps are equal factors; what is not positive is left out.
    pub logarithmic: bool,
}

impl Axis {
    /// A linear axis that covers the data.
    pub fn linear(label: impl Into<String>) -> Self {
        Self { label: label.into(), range: None, logarithmic: false }
    }

    /// A logarithmic axis that covers the data.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Self { logarithmic: true, ..Self::linear(label) }
    }

    /// With fixed ends.
    pub fn within(self, low: f64, high: f64) -> Self {
        Self { range: Some([low, high]), ..self }
    }
}

/// How the points of a series are shown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Mark {
    /// Joined by a line.
    Line,
    /// Joined by a dashed line.
    Dashed,
    /// A dot each.
    Dots,
    /// A bar from 0 each, of this width in units of x, around x.
    Bars(f64),
}

/// Points that belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend; empty for none.
    pub name: String,
    /// x and y; points that are not finite are left out.
    pub points: Vec<[f64; 2]>,
    /// How they are shown.
    pub mark: Mark,
    /// Place in [`PALETTE`].
    pub colour: usize,
}

impl Series {
    /// A series.
    pub fn new(name: impl Into<String>, mark: Mark, colour: usize, points: Vec<[f64; 2]>) -> Self {
        Self { name: name.into(), points, mark, colour }
    }
}

/// Colours that colour-blind people can tell apart on white (after Okabe and Ito, Color universal design, 2008), grey
/// last.
pub const PALETTE: [Colour; 8] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [60, 60, 60],
    [150, 150, 150],
];

/// Place of dark grey in [`PALETTE`], for what is theory or truth.
pub const DARK: usize = 6;
/// Place of light grey in [`PALETTE`], for what is context.
pub const LIGHT: usize = 7;

impl Figure {
    /// A figure of charts.
    pub fn charts(name: impl Into<String>, caption: impl Into<String>, charts: Vec<Chart>) -> Self {
        Self { name: name.into(), caption: caption.into(), content: Content::Charts(charts) }
    }

    /// A figure of pixels.
    pub fn picture(name: impl Into<String>, caption: impl Into<String>, picture: ColourImage) -> Self {
        Self { name: name.into(), caption: caption.into(), content: Content::Picture(picture) }
    }

    /// The bytes of an SVG file. A picture is embedded as PNG.
    ///
    /// # Errors
    /// When there is nothing to draw.
    pub fn to_svg(&self) -> Result<String, InputError> {
        match &self.content {
            Content::Charts(charts) => plot::svg(charts).map_err(|error| self.undrawable(&error)),
            Content::Picture(image) => {
                let (width, height, png) = (image.width, image.height, base64(&self.to_png()?));
                let mut svg = String::new();
                let _ = write!(
                    svg,
                    "<svg width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
                     xmlns=\"http://www.w3.org/2000/svg\">\n<image width=\"{width}\" height=\"{height}\" \
                     href=\"data:image/png;base64,{png}\"/>\n</svg>\n"
                );
                Ok(svg)
            }
        }
    }

    /// The bytes of a PNG file.
    ///
    /// # Errors
    /// When there is nothing to draw.
    pub fn to_png(&self) -> Result<Vec<u8>, InputError> {
        let drawn;
        let image = match &self.content {
            Content::Charts(charts) => {
                drawn = plot::pixels(charts).map_err(|error| self.undrawable(&error))?;
                &drawn
            }
            Content::Picture(image) => image,
        };
        encode_png(image).map_err(|error| self.undrawable(&error))
    }

    fn undrawable(&self, error: &dyn std::fmt::Display) -> InputError {
        InputError::at(format!("figure {}", self.name), format!("cannot be drawn ({error})"), "report this")
    }
}

/// Base64 with padding (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |k: usize| u32::from(chunk.get(k).copied().unwrap_or(0));
        let word = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * k) & 63) as usize];
            text.push(if k <= chunk.len() { char::from(digit) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        for (bytes, text) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }

    #[test]
    fn a_picture_becomes_png_and_svg() {
        let figure = Figure::picture("p", "", ColourImage::filled(3, 2, [1, 2, 3]));
        assert!(figure.to_png().unwrap().starts_with(b"\x89PNG"));
        assert!(figure.to_svg().unwrap().contains("viewBox=\"0 0 3 2\""));
        assert!(Figure::picture("p", "", ColourImage::filled(0, 2, [1, 2, 3])).to_png().is_err());
    }
}
