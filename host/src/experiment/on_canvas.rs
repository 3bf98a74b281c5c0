//! A back end of `plotters` that draws on the canvas of [`crate::draw`].

use std::convert::Infallible;

use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind, FontStyle,
    text_anchor::{HPos, VPos},
};

use crate::draw::{
    canvas::{Canvas, Colour, Frame, Position, Stroke},
    text::Font,
};

/// Draws on a borrowed canvas. Nothing can go wrong.
pub(super) struct OnCanvas<'a>(pub(super) &'a mut Canvas);

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

fn position((x, y): BackendCoord) -> Position {
    (f64::from(x), f64::from(y))
}

fn colour(colour: BackendColor) -> Colour {
    let (red, green, blue) = colour.rgb;
    [red, green, blue]
}

fn stroke_of(style: &impl BackendStyle) -> Stroke {
    let width_px = f64::from(style.stroke_width()).max(1.0);
    Stroke { opacity: style.color().alpha, ..Stroke::solid(width_px, colour(style.color())) }
}

fn font_of(style: &impl BackendTextStyle) -> Font {
    Font::of_height(style.size(), matches!(style.style(), FontStyle::Bold))
}

impl DrawingBackend for OnCanvas<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        let (width, height) = self.0.size();
        (width as u32, height as u32)
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, point: BackendCoord, pixel: BackendColor) -> Drawn {
        self.0.blend(point.0.into(), point.1.into(), colour(pixel), pixel.alpha);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(&mut self, from: BackendCoord, to: BackendCoord, style: &S) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        let line: Vec<Position> = path.into_iter().map(position).collect();
        self.0.stroke(&line, &stroke_of(style));
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        bottom_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let corners = [position(upper_left), position(bottom_right)];
        if fill {
            if let Some(frame) = Frame::around(&corners) {
                self.0.fill(&frame, 0.0, colour(style.color()), style.color().alpha);
            }
            return Ok(());
        }
        let [(left, top), (right, bottom)] = corners;
        let outline = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)];
        self.0.stroke(&outline, &stroke_of(style));
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        centre: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Drawn {
        let (x, y) = position(centre);
        let radius = f64::from(radius);
        if fill {
            self.0.stroke(&[(x, y)], &Stroke { width_px: 2.0 * radius, ..stroke_of(style) });
            return Ok(());
        }
        let turn = |k: i32| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(k) / 48.0);
            (x + radius * cos, y + radius * sin)
        };
        self.0.stroke(&(0..=48).map(turn).collect::<Vec<_>>(), &stroke_of(style));
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(&mut self, text: &str, style: &S, at: BackendCoord) -> Drawn {
        let font = font_of(style);
        let (x, y) = position(at);
        let anchor = style.anchor();
        let left = match anchor.h_pos {
            HPos::Left => x,
            HPos::Center => x - font.width_of(text) / 2.0,
            HPos::Right => x - font.width_of(text),
        };
        let top = match anchor.v_pos {
            VPos::Top => y,
            VPos::Center => y - font.line_height() / 2.0,
            VPos::Bottom => y - font.line_height(),
        };
        font.draw(self.0, (left, top), text, colour(style.color()));
        Ok(())
    }

    fn estimate_text_size<S: BackendTextStyle>(
        &self,
        text: &str,
        style: &S,
    ) -> Result<(u32, u32), DrawingErrorKind<Infallible>> {
        let font = font_of(style);
        Ok((font.width_of(text) as u32, font.line_height() as u32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::ColourImage;
    use plotters::style::{Color, RGBColor};

    const RED: RGBColor = RGBColor(255, 0, 0);

    fn drawn(draw: impl Fn(&mut OnCanvas<'_>) -> Drawn) -> ColourImage {
        let mut canvas = Canvas::new(ColourImage::filled(60, 40, [0; 3]));
        draw(&mut OnCanvas(&mut canvas)).unwrap();
        canvas.finish()
    }

    fn light(image: &ColourImage) -> f64 {
        image.pixels.iter().map(|p| f64::from(p[0]) / 255.0).sum()
    }

    #[test]
    fn shapes_have_their_areas() {
        let disc = drawn(|b| b.draw_circle((30, 20), 10, &RED.filled(), true));
        assert!((light(&disc) / (std::f64::consts::PI * 100.0) - 1.0).abs() < 0.03, "{}", light(&disc));
        let ring = drawn(|b| b.draw_circle((30, 20), 10, &Color::stroke_width(&RED, 2), false));
        assert!((light(&ring) / (std::f64::consts::TAU * 20.0) - 1.0).abs() < 0.05, "{}", light(&ring));
        let block = drawn(|b| b.draw_rect((10, 10), (30, 20), &RED.filled(), true));
        assert!((light(&block) - 200.0).abs() < 35.0, "{}", light(&block));
        let pale = drawn(|b| b.draw_rect((10, 10), (30, 20), &RED.mix(0.5).filled(), true));
        assert_eq!(pale.get(20, 15), Some([128, 0, 0]));
        let outline = drawn(|b| b.draw_rect((10, 10), (30, 20), &Color::stroke_width(&RED, 1), false));
        assert_eq!((outline.get(20, 15), outline.get(10, 15)), (Some([0; 3]), Some([255, 0, 0])));
    }
}
