//! Text, in an anti-aliased bitmap font that comes with the program: no fonts of the system are asked for.
//!
//! The glyphs (Noto Sans Mono, printable ASCII and Latin-1) exist in four heights; greater ones are enlarged from the
//! greatest. A character without a glyph is shown as `?`.

use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

use super::canvas::{Canvas, Colour, Position};

/// A size and weight of the font.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Font {
    raster: RasterHeight,
    weight: FontWeight,
    /// Enlargement of the raster.
    factor: usize,
}

impl Font {
    /// The font whose line height is nearest to the one wished for: 16, 20, 24, or a multiple of 32 pixels.
    pub fn of_height(height_px: f64, bold: bool) -> Self {
        let weight = if bold { FontWeight::Bold } else { FontWeight::Regular };
        let (raster, factor) = match height_px {
            h if h < 18.0 => (RasterHeight::Size16, 1),
            h if h < 22.0 => (RasterHeight::Size20, 1),
            h if h < 28.0 => (RasterHeight::Size24, 1),
            // The cast saturates; eight times 32 is more than any picture needs.
            h => (RasterHeight::Size32, ((h / 32.0).round() as usize).clamp(1, 8)),
        };
        Self { raster, weight, factor }
    }

    /// Height of a line, pixels.
    pub fn line_height(&self) -> f64 {
        (self.raster.val() * self.factor) as f64
    }

    /// Width of a line of text, pixels: every character is equally wide.
    pub fn width_of(&self, text: &str) -> f64 {
        (text.chars().count() * self.advance()) as f64
    }

    fn advance(&self) -> usize {
        get_raster_width(self.weight, self.raster) * self.factor
    }

    /// Draws a line of text with its upper left corner at `corner`, rounded to whole pixels.
    pub fn draw(&self, canvas: &mut Canvas, corner: Position, text: &str, colour: Colour) {
        let (left, top) = (corner.0.round() as i64, corner.1.round() as i64);
        for (place, character) in text.chars().enumerate() {
            self.draw_glyph(
                canvas,
                left.saturating_add((place * self.advance()) as i64),
                top,
                character,
                colour,
            );
        }
    }

    fn draw_glyph(&self, canvas: &mut Canvas, left: i64, top: i64, character: char, colour: Colour) {
        let glyph = |c| get_raster(c, self.weight, self.raster);
        let Some(glyph) = glyph(character).or_else(|| glyph('?')) else { return };
        let factor = self.factor as f64;
        // Intensity between raster pixels, linear; with factor 1 it is read at them.
        let intensity = |u: usize, v: usize| {
            let (x, y) = ((u as f64 + 0.5) / factor - 0.5, (v as f64 + 0.5) / factor - 0.5);
            let (x0, y0) = (x.floor(), y.floor());
            let at = |x: f64, y: f64| {
                let inside = x >= 0.0 && y >= 0.0;
                f64::from(if inside { glyph.pixel(x as usize, y as usize).unwrap_or(0) } else { 0 })
            };
            let between = |y: f64| at(x0, y) + (x - x0) * (at(x0 + 1.0, y) - at(x0, y));
            (between(y0) + (y - y0) * (between(y0 + 1.0) - between(y0))) / 255.0
        };
        for v in 0..glyph.height() * self.factor {
            for u in 0..glyph.width() * self.factor {
                let opacity = intensity(u, v);
                if opacity > 0.0 {
                    canvas.blend(
                        left.saturating_add(u as i64),
                        top.saturating_add(v as i64),
                        colour,
                        opacity,
                    );
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ColourImage;

    fn written(font: Font, corner: Position, text: &str) -> ColourImage {
        let mut canvas = Canvas::new(ColourImage::filled(400, 80, [0; 3]));
        font.draw(&mut canvas, corner, text, [255; 3]);
        canvas.finish()
    }

    fn light(image: &ColourImage) -> f64 {
        image.pixels.iter().map(|pixel| f64::from(pixel[0]) / 255.0).sum()
    }

    #[test]
    fn heights_are_the_nearest_that_exist() {
        for (wished, got) in
            [(3.0, 16.0), (19.0, 20.0), (25.0, 24.0), (40.0, 32.0), (60.0, 64.0), (1e9, 256.0)]
        {
            assert_eq!(Font::of_height(wished, false).line_height(), got);
        }
    }

    #[test]
    fn text_stays_within_the_width_it_states() {
        for height in [16.0, 24.0, 64.0] {
            let font = Font::of_height(height, true);
            let image = written(font, (10.0, 4.0), "21.8 × 10.9");
            let right = 10.0 + font.width_of("21.8 × 10.9");
            let lit = |u: usize| (0..80).any(|v| image.get(u as i64, v) != Some([0; 3]));
            assert!((10..30).any(lit));
            assert!((0..9).chain(right as usize + 1..400).all(|u| !lit(u)), "height {height}");
        }
    }

    #[test]
    fn an_enlarged_glyph_has_the_area_of_its_raster() {
        let small = light(&written(Font::of_height(32.0, false), (4.0, 4.0), "W8"));
        let large = light(&written(Font::of_height(64.0, false), (4.0, 4.0), "W8"));
        assert!((large / small - 4.0).abs() < 0.02, "{small} {large}");
    }

    #[test]
    fn unknown_characters_and_corners_outside_are_harmless() {
        let font = Font::of_height(16.0, false);
        assert_eq!(written(font, (4.0, 4.0), "\u{4e2d}"), written(font, (4.0, 4.0), "?"));
        assert_eq!(light(&written(font, (f64::NEG_INFINITY, 1e300), "abc")), 0.0);
        assert_eq!(light(&written(font, (4.0, 4.0), " ")), 0.0);
    }
}
