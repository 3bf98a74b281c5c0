//! A picture to draw on: anti-aliased strokes, filled boxes, PNG.
//!
//! Coordinates are pixels, x right, y down, pixel centres at integers, like everywhere in the product. A stroke covers
//! a pixel by as much as a disc of its width around the nearest point of the line overlaps it; the coverage of a whole
//! polyline is gathered first and blended once, so that a translucent line has no dark joints.

use std::path::Path;

use crate::error::{InputError, write_whole};
use crate::image::ColourImage;

/// Red, green, blue.
pub type Colour = [u8; 3];

/// A position on the canvas, pixels.
pub type Position = (f64, f64);

/// How a line looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    /// Width in pixels, at least what can be seen.
    pub width_px: f64,
    /// Colour.
    pub colour: Colour,
    /// 0 = invisible, 1 = covers what is below.
    pub opacity: f64,
    /// Lengths of stroke and gap in pixels; `None` for a solid line.
    pub dash_px: Option<(f64, f64)>,
}

impl Stroke {
    /// A solid, opaque line.
    pub fn solid(width_px: f64, colour: Colour) -> Self {
        Self { width_px, colour, opacity: 1.0, dash_px: None }
    }
}

/// A rectangle on the canvas, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Left edge.
    pub left: f64,
    /// Upper edge.
    pub top: f64,
    /// Extent to the right.
    pub width: f64,
    /// Extent downwards.
    pub height: f64,
}

impl Frame {
    /// The smallest frame around some positions; nothing around none.
    pub fn around(positions: &[Position]) -> Option<Self> {
        let (&(x, y), rest) = positions.split_first()?;
        let mut corners = (x, y, x, y);
        for &(x, y) in rest {
            corners = (corners.0.min(x), corners.1.min(y), corners.2.max(x), corners.3.max(y));
        }
        let (left, top, right, bottom) = corners;
        Some(Self { left, top, width: right - left, height: bottom - top })
    }

    /// Distance between the edges of two frames, pixels; 0 where they touch or overlap.
    pub fn distance(&self, other: &Self) -> f64 {
        let apart =
            |a: f64, a_extent: f64, b: f64, b_extent: f64| (b - a - a_extent).max(a - b - b_extent).max(0.0);
        let across = apart(self.left, self.width, other.left, other.width);
        across.hypot(apart(self.top, self.height, other.top, other.height))
    }

    /// Area shared with another frame, square pixels.
    pub fn overlap(&self, other: &Self) -> f64 {
        let shared =
            |a: f64, a_extent: f64, b: f64, b_extent: f64| (a + a_extent).min(b + b_extent) - a.max(b);
        let across = shared(self.left, self.width, other.left, other.width);
        let down = shared(self.top, self.height, other.top, other.height);
        across.max(0.0) * down.max(0.0)
    }
}

/// A picture being drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Canvas {
    image: ColourImage,
    /// Coverage of the stroke in hand, 0 to 255; all 0 between strokes.
    coverage: Vec<u8>,
}

impl Canvas {
    /// Begins with a picture.
    pub fn new(image: ColourImage) -> Self {
        let coverage = vec![0; image.pixels.len()];
        Self { image, coverage }
    }

    /// The picture.
    pub fn finish(self) -> ColourImage {
        self.image
    }

    /// Columns, rows.
    pub fn size(&self) -> (usize, usize) {
        (self.image.width, self.image.height)
    }

    /// Mixes a colour into one pixel; outside the picture nothing happens.
    #[inline]
    pub fn blend(&mut self, u: i64, v: i64, colour: Colour, opacity: f64) {
        if let Some(below) = self.image.get(u, v) {
            let share = opacity.clamp(0.0, 1.0);
            let mixed = |k: usize| f64::from(below[k]) + share * (f64::from(colour[k]) - f64::from(below[k]));
            self.image.set(u, v, [mixed(0), mixed(1), mixed(2)].map(|value| value.round() as u8));
        }
    }

    /// Draws a polyline with round ends and joints. One position draws a dot; positions that are not finite end the
    /// line and begin another.
    pub fn stroke(&mut self, line: &[Position], stroke: &Stroke) {
        let pieces = stroke.dash_px.map_or_else(|| segments(line), |dash| dashed(&segments(line), dash));
        let reach = stroke.width_px / 2.0 + 0.5;
        let mut touched: Option<[i64; 4]> = None;
        for piece in pieces {
            let Some(area) = self.pixels_near(&piece, reach) else { continue };
            self.cover(&piece, reach, area);
            let [left, top, right, bottom] = touched.unwrap_or(area);
            touched = Some([left.min(area[0]), top.min(area[1]), right.max(area[2]), bottom.max(area[3])]);
        }
        let Some([left, top, right, bottom]) = touched else { return };
        for v in top..=bottom {
            for u in left..=right {
                let at = v as usize * self.image.width + u as usize;
                let coverage = std::mem::take(&mut self.coverage[at]);
                if coverage > 0 {
                    self.blend(u, v, stroke.colour, stroke.opacity * f64::from(coverage) / 255.0);
                }
            }
        }
    }

    /// Draws an opaque dot: what [`Self::stroke`] does with one position, without its overhead.
    pub fn dot(&mut self, centre: Position, width_px: f64, colour: Colour) {
        let reach = width_px / 2.0 + 0.5;
        let Some([left, top, right, bottom]) = self.pixels_near(&[centre, centre], reach) else { return };
        for v in top..=bottom {
            for u in left..=right {
                let distance = (u as f64 - centre.0).hypot(v as f64 - centre.1);
                self.blend(u, v, colour, reach - distance);
            }
        }
    }

    /// Draws a polyline on a dark rim, so that it shows on any background.
    pub fn stroke_with_halo(&mut self, line: &[Position], stroke: &Stroke) {
        let halo =
            Stroke { width_px: stroke.width_px * 1.5 + 2.0, colour: [0; 3], opacity: 0.55, dash_px: None };
        self.stroke(line, &halo);
        self.stroke(line, stroke);
    }

    /// Fills a box with rounded corners.
    pub fn fill(&mut self, frame: &Frame, corner_px: f64, colour: Colour, opacity: f64) {
        let (half_width, half_height) = (frame.width / 2.0, frame.height / 2.0);
        let (x, y) = (frame.left + half_width, frame.top + half_height);
        let corner = corner_px.min(half_width).min(half_height).max(0.0);
        let Some([left, top, right, bottom]) = self.clipped(
            frame.left - 1.0,
            frame.top - 1.0,
            frame.left + frame.width + 1.0,
            frame.top + frame.height + 1.0,
        ) else {
            return;
        };
        for v in top..=bottom {
            for u in left..=right {
                // Distance from the box that the corner's circle sweeps out: positive outside.
                let dx = (u as f64 - x).abs() - (half_width - corner);
                let dy = (v as f64 - y).abs() - (half_height - corner);
                let outside = dx.max(0.0).hypot(dy.max(0.0)) + dx.max(dy).min(0.0) - corner;
                self.blend(u, v, colour, opacity * (0.5 - outside).clamp(0.0, 1.0));
            }
        }
    }

    /// First and last column and row of the pixels between two corners; nothing when all are outside the picture.
    fn clipped(&self, left: f64, top: f64, right: f64, bottom: f64) -> Option<[i64; 4]> {
        let (last_u, last_v) = (self.image.width as f64 - 1.0, self.image.height as f64 - 1.0);
        // `max` and `min` would take the other value for NaN: the whole picture.
        let finite = [left, top, right, bottom].iter().all(|value| value.is_finite());
        let area = [
            left.floor().max(0.0),
            top.floor().max(0.0),
            right.ceil().min(last_u),
            bottom.ceil().min(last_v),
        ];
        (finite && area[0] <= area[2] && area[1] <= area[3]).then(|| area.map(|value| value as i64))
    }

    fn pixels_near(&self, piece: &Segment, reach: f64) -> Option<[i64; 4]> {
        let [(x0, y0), (x1, y1)] = *piece;
        self.clipped(x0.min(x1) - reach, y0.min(y1) - reach, x0.max(x1) + reach, y0.max(y1) + reach)
    }

    fn cover(&mut self, piece: &Segment, reach: f64, area: [i64; 4]) {
        let [(x0, y0), (x1, y1)] = *piece;
        let (dx, dy) = (x1 - x0, y1 - y0);
        let squared_length = dx * dx + dy * dy;
        let [left, top, right, bottom] = area;
        for v in top..=bottom {
            for u in left..=right {
                let (px, py) = (u as f64 - x0, v as f64 - y0);
                let along = if squared_length > 0.0 {
                    ((px * dx + py * dy) / squared_length).clamp(0.0, 1.0)
                } else {
                    0.0
                };
                let (off_x, off_y) = (px - along * dx, py - along * dy);
                let distance = (off_x * off_x + off_y * off_y).sqrt();
                let covered = ((reach - distance).clamp(0.0, 1.0) * 255.0).round() as u8;
                let slot = &mut self.coverage[v as usize * self.image.width + u as usize];
                *slot = covered.max(*slot);
            }
        }
    }
}

type Segment = [Position; 2];

/// The straight pieces of a polyline, those of them that are finite.
fn segments(line: &[Position]) -> Vec<Segment> {
    let finite = |&(x, y): &Position| x.is_finite() && y.is_finite();
    if let [dot] = line {
        return if finite(dot) { vec![[*dot, *dot]] } else { Vec::new() };
    }
    line.windows(2).filter(|pair| pair.iter().all(finite)).map(|pair| [pair[0], pair[1]]).collect()
}

/// Dashes a polyline may have at most: beyond that (a body that fills the view) it is drawn solid.
const MAX_DASHES: f64 = 4096.0;

/// Cuts pieces into dashes, counted along the whole polyline so that corners do not start a new dash.
fn dashed(pieces: &[Segment], (on, off): (f64, f64)) -> Vec<Segment> {
    let total: f64 = pieces.iter().map(|[p, q]| (q.0 - p.0).hypot(q.1 - p.1)).sum();
    let period = on + off;
    let drawable = on > 0.0 && off > 0.0 && total / period < MAX_DASHES;
    if !drawable {
        return pieces.to_vec();
    }
    let mut dashes = Vec::new();
    let mut travelled = 0.0;
    for [p, q] in pieces {
        let length = (q.0 - p.0).hypot(q.1 - p.1);
        let at = |distance: f64| {
            let share = if length > 0.0 { ((distance - travelled) / length).clamp(0.0, 1.0) } else { 0.0 };
            (p.0 + share * (q.0 - p.0), p.1 + share * (q.1 - p.1))
        };
        let mut start = (travelled / period).floor() * period;
        while start < travelled + length {
            if start + on > travelled {
                dashes.push([at(start), at(start + on)]);
            }
            start += period;
        }
        travelled += length;
    }
    dashes
}

/// Writes a picture as PNG, whole or not at all.
///
/// # Errors
/// When the file cannot be written, or the picture has no pixels (PNG cannot hold that).
pub fn write_png(path: &Path, image: &ColourImage) -> Result<(), InputError> {
    let bytes = encode_png(image).map_err(|error| {
        InputError::in_file(path, format!("the picture cannot be encoded ({error})"), "check its size")
    })?;
    write_whole(path, &bytes)
}

/// A picture as the bytes of a PNG file.
///
/// # Errors
/// When the picture has no pixels.
pub fn encode_png(image: &ColourImage) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, image.width as u32, image.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(image.pixels.as_flattened())?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WHITE: Colour = [255; 3];

    fn black(width: usize, height: usize) -> Canvas {
        Canvas::new(ColourImage::filled(width, height, [0; 3]))
    }

    fn light(image: &ColourImage) -> f64 {
        image.pixels.iter().map(|pixel| f64::from(pixel[0]) / 255.0).sum()
    }

    #[test]
    fn a_line_covers_its_own_area() {
        // Whatever its angle: length times width, plus the two half discs at the ends.
        for (x, y) in [(90.0, 50.0), (50.0, 90.0), (78.3, 78.3), (84.0, 71.5)] {
            let mut canvas = black(101, 101);
            canvas.stroke(&[(50.0, 50.0), (x, y)], &Stroke::solid(4.0, WHITE));
            let expected = 4.0 * (x - 50.0_f64).hypot(y - 50.0) + std::f64::consts::PI * 4.0;
            let covered = light(&canvas.finish());
            assert!((covered / expected - 1.0).abs() < 0.02, "({x}, {y}): {covered} of {expected}");
        }
    }

    #[test]
    fn a_dot_is_a_stroke_of_one_position() {
        let (mut dotted, mut stroked) = (black(30, 30), black(30, 30));
        dotted.dot((14.3, 15.8), 7.5, WHITE);
        stroked.stroke(&[(14.3, 15.8)], &Stroke::solid(7.5, WHITE));
        let (dotted, stroked) = (dotted.finish(), stroked.finish());
        assert!(dotted.pixels.iter().zip(&stroked.pixels).all(|(p, q)| p[0].abs_diff(q[0]) <= 1));
        let area = std::f64::consts::PI * 7.5 * 7.5 / 4.0;
        assert!((light(&dotted) / area - 1.0).abs() < 0.03);
    }

    #[test]
    fn a_translucent_polyline_has_no_dark_joints() {
        let mut canvas = black(40, 40);
        let stroke = Stroke { opacity: 0.5, ..Stroke::solid(6.0, WHITE) };
        canvas.stroke(&[(5.0, 20.0), (20.0, 20.0), (35.0, 20.0)], &stroke);
        let image = canvas.finish();
        assert_eq!(image.get(20, 20), image.get(10, 20));
        assert_eq!(image.get(20, 20), Some([128; 3]));
    }

    #[test]
    fn dashes_have_their_lengths_round_corners_too() {
        let pieces = segments(&[(0.0, 0.0), (7.0, 0.0), (7.0, 30.0)]);
        let dashes = dashed(&pieces, (4.0, 2.0));
        let lengths: f64 = dashes.iter().map(|[p, q]| (q.0 - p.0).hypot(q.1 - p.1)).sum();
        // 37 pixels: six periods of 6 and the first pixel of a seventh dash.
        assert!((lengths - 25.0).abs() < 1e-9, "{dashes:?}");
        assert_eq!(dashes[1], [(6.0, 0.0), (7.0, 0.0)]);
        assert_eq!(dashes[2], [(7.0, 0.0), (7.0, 3.0)]);
    }

    #[test]
    fn nothing_outside_the_picture_and_nothing_that_is_not_finite_is_drawn() {
        let mut canvas = black(20, 20);
        let stroke = Stroke { dash_px: Some((3.0, 3.0)), ..Stroke::solid(3.0, WHITE) };
        for line in [
            vec![(f64::NAN, 1.0), (5.0, 5.0)],
            vec![(-50.0, -50.0), (-10.0, -10.0)],
            vec![(1e300, 1e300), (1e300, -1e300)],
            vec![(f64::INFINITY, 5.0)],
            Vec::new(),
        ] {
            canvas.stroke_with_halo(&line, &stroke);
            for &position in &line[..line.len().min(1)] {
                canvas.dot(position, 3.0, WHITE);
            }
        }
        canvas.fill(&Frame { left: 30.0, top: 30.0, width: 5.0, height: 5.0 }, 1.0, WHITE, 1.0);
        assert_eq!(light(&canvas.finish()), 0.0);
        // A line that crosses the picture from far away does show.
        let mut canvas = black(20, 20);
        canvas.stroke(&[(-1e6, 10.0), (1e6, 10.0)], &stroke);
        assert!(light(&canvas.finish()) > 50.0);
    }

    #[test]
    fn a_box_covers_its_area() {
        let mut canvas = black(60, 60);
        canvas.fill(&Frame { left: 10.0, top: 10.0, width: 30.5, height: 20.0 }, 0.0, WHITE, 1.0);
        let square = light(&canvas.finish());
        assert!((square - 610.0).abs() < 16.0, "{square}");
        let mut canvas = black(60, 60);
        canvas.fill(&Frame { left: 10.0, top: 10.0, width: 40.0, height: 40.0 }, 20.0, WHITE, 1.0);
        let disc = light(&canvas.finish());
        assert!((disc / (std::f64::consts::PI * 400.0) - 1.0).abs() < 0.02, "{disc}");
    }

    #[test]
    fn a_png_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        let mut image = ColourImage::filled(5, 3, [1, 2, 3]);
        image.set(4, 2, [250, 0, 9]);
        write_png(&path, &image).unwrap();
        let mut reader = png::Decoder::new(std::io::BufReader::new(std::fs::File::open(&path).unwrap()))
            .read_info()
            .unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        assert_eq!(bytes, image.pixels.as_flattened());
        let error = write_png(&path, &ColourImage::filled(0, 3, [0; 3])).unwrap_err();
        assert!(error.to_string().contains("encoded"), "{error}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
