//! Charts to SVG and to pixels: one drawing, two back ends of `plotters`.
//!
//! SVG is written by the package itself, its text left to the viewer's fonts. Pixels go through [`OnCanvas`] onto the
//! canvas that draws the pictures of results, with its anti-aliased lines and its built-in font: no font files, no font
//! of the system, the same bytes everywhere. Where a logarithmic axis is asked for, the drawing works in the logarithm,
//! so that both kinds of axis are one to it; ticks are ours, at 1, 2 and 5 times powers of ten.

use std::fmt::Display;

use plotters::{coord::Shift, prelude::*};

use super::{
    figure::{Chart, Mark, PALETTE, Series},
    on_canvas::OnCanvas,
    scale::Scale,
};
use crate::{draw::canvas::Canvas, image::ColourImage};

/// Size of a chart, pixels.
const SIZE: (u32, u32) = (720, 480);
/// Height of the strip for title and label of the y axis, pixels.
const HEAD: i32 = 54;
/// Height of a line of the legend, pixels.
const LEGEND_LINE: i32 = 22;
const FONT: &str = "sans-serif";
const TEXT: f64 = 15.0;
const TITLE: f64 = 17.0;

type Area<DB> = DrawingArea<DB, Shift>;
type Context<'a, DB> = ChartContext<'a, DB, Cartesian2d<Scale, Scale>>;
type Failure<DB> = DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>;

/// Draws charts as SVG.
pub(super) fn svg(charts: &[Chart]) -> Result<String, String> {
    let mut text = String::new();
    let root = SVGBackend::with_string(&mut text, size(charts)).into_drawing_area();
    draw(&root, charts).map_err(|error| in_words(&error))?;
    drop(root);
    Ok(text)
}

/// Draws charts as pixels.
pub(super) fn pixels(charts: &[Chart]) -> Result<ColourImage, String> {
    let (width, height) = size(charts);
    let mut canvas = Canvas::new(ColourImage::filled(width as usize, height as usize, [255; 3]));
    let root = OnCanvas(&mut canvas).into_drawing_area();
    draw(&root, charts).map_err(|error| in_words(&error))?;
    drop(root);
    Ok(canvas.finish())
}

fn in_words(error: &impl Display) -> String {
    error.to_string()
}

fn columns(charts: &[Chart]) -> usize {
    charts.len().min(2)
}

fn size(charts: &[Chart]) -> (u32, u32) {
    let rows = charts.len().div_ceil(2);
    (SIZE.0 * columns(charts) as u32, SIZE.1 * rows as u32)
}

fn draw<DB: DrawingBackend>(root: &Area<DB>, charts: &[Chart]) -> Result<(), Failure<DB>> {
    root.fill(&WHITE)?;
    let areas = root.split_evenly((charts.len().div_ceil(2), columns(charts)));
    for (area, chart) in areas.iter().zip(charts) {
        draw_chart(area, chart)?;
    }
    root.present()
}

fn draw_chart<DB: DrawingBackend>(area: &Area<DB>, chart: &Chart) -> Result<(), Failure<DB>> {
    area.draw(&Text::new(
        chart.title.as_str(),
        (12, 8),
        (FONT, TITLE, FontStyle::Bold).into_text_style(area),
    ))?;
    area.draw(&Text::new(chart.y.label.as_str(), (12, 32), (FONT, TEXT).into_text_style(area)))?;
    let legend_height = draw_legend(area, &chart.series)?;
    let (_, plot) = area.split_vertically(HEAD + legend_height);

    let [x, y] = [Scale::new(&chart.x, chart, 0), Scale::new(&chart.y, chart, 1)];
    let mut context = ChartBuilder::on(&plot)
        .margin(8)
        .margin_right(24)
        .x_label_area_size(52)
        .y_label_area_size(64)
        .build_cartesian_2d(x.clone(), y.clone())?;
    context
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(RGBColor(226, 226, 226))
        .axis_style(RGBColor(90, 90, 90))
        .x_desc(chart.x.label.as_str())
        .axis_desc_style((FONT, TEXT))
        .label_style((FONT, TEXT))
        .draw()?;
    for series in &chart.series {
        draw_series(&mut context, series, &x, &y)?;
    }
    Ok(())
}

/// Writes the names of the series below the head, as many in a line as fit; returns the height of these lines.
fn draw_legend<DB: DrawingBackend>(area: &Area<DB>, all: &[Series]) -> Result<i32, Failure<DB>> {
    const SAMPLE: i32 = 26;
    const GAP: i32 = 18;
    let right = area.dim_in_pixel().0 as i32 - 12;
    let style = (FONT, TEXT).into_text_style(area);
    let (mut left, mut lines) = (12, 0);
    for series in all.iter().filter(|series| !series.name.is_empty()) {
        let width = SAMPLE + 8 + area.estimate_text_size(&series.name, &style)?.0 as i32;
        if lines == 0 || left + width > right {
            (left, lines) = (12, lines + 1);
        }
        let middle = HEAD + LEGEND_LINE * (lines - 1) + LEGEND_LINE / 2;
        let ends = vec![(left, middle), (left + SAMPLE, middle)];
        match series.mark {
            Mark::Line => area.draw(&PathElement::new(ends, stroke(series)))?,
            Mark::Dashed => {
                for start in [left, left + 10, left + 20] {
                    area.draw(&PathElement::new(vec![(start, middle), (start + 6, middle)], stroke(series)))?;
                }
            }
            Mark::Dots => area.draw(&Circle::new((left + SAMPLE / 2, middle), DOT, fill(series)))?,
            Mark::Bars(_) => {
                area.draw(&Rectangle::new([(left + 6, middle - 6), (left + 20, middle + 6)], fill(series)))?;
            }
        }
        area.draw(&Text::new(series.name.as_str(), (left + SAMPLE + 8, middle - 8), style.clone()))?;
        left += width + GAP;
    }
    Ok(lines * LEGEND_LINE)
}

/// Radius of a dot, pixels.
const DOT: i32 = 3;

fn colour(series: &Series) -> RGBColor {
    let [red, green, blue] = PALETTE[series.colour % PALETTE.len()];
    RGBColor(red, green, blue)
}

fn stroke(series: &Series) -> ShapeStyle {
    colour(series).stroke_width(2)
}

fn fill(series: &Series) -> ShapeStyle {
    match series.mark {
        Mark::Bars(_) => colour(series).mix(0.45).filled(),
        _ => colour(series).filled(),
    }
}

fn draw_series<DB: DrawingBackend>(
    context: &mut Context<'_, DB>,
    series: &Series,
    x: &Scale,
    y: &Scale,
) -> Result<(), Failure<DB>> {
    let places: Vec<(f64, f64)> =
        series.points.iter().filter_map(|p| Some((x.place(p[0])?, y.place(p[1])?))).collect();
    match series.mark {
        Mark::Line => context.draw_series(LineSeries::new(places, stroke(series)))?,
        Mark::Dashed => context.draw_series(DashedLineSeries::new(places, 6, 4, stroke(series)))?,
        Mark::Dots => {
            let inside = places.into_iter().filter(|p| x.holds(p.0) && y.holds(p.1));
            context.draw_series(inside.map(|place| Circle::new(place, DOT, fill(series))))?
        }
        Mark::Bars(width) => {
            let bar = |p: &[f64; 2]| {
                let ends = [x.place(p[0] - width / 2.0)?, x.place(p[0] + width / 2.0)?];
                Some(Rectangle::new([(ends[0], y.low.max(0.0)), (ends[1], y.place(p[1])?)], fill(series)))
            };
            context.draw_series(series.points.iter().filter_map(bar))?
        }
    };
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::figure::Axis;

    fn chart(x: Axis, points: Vec<[f64; 2]>) -> Chart {
        let series = vec![Series::new("one", Mark::Line, 0, points)];
        Chart { title: "title".into(), x, y: Axis::linear("up"), series }
    }

    #[test]
    fn both_back_ends_draw_and_draw_the_same_every_time() {
        let line = chart(Axis::linear("right"), vec![[0.0, 0.0], [1.0, 1.0]]);
        let mut bars = line.clone();
        bars.series[0].mark = Mark::Bars(0.5);
        let charts = [line, bars, chart(Axis::linear("nothing"), vec![[f64::NAN, 1.0]])];
        let drawn = svg(&charts).unwrap();
        assert!(
            drawn.starts_with("<svg") && drawn.contains("title") && drawn.contains("<polyline"),
            "{drawn}"
        );
        assert_eq!(drawn, svg(&charts).unwrap());
        let image = pixels(&charts).unwrap();
        assert_eq!((image.width, image.height), (1440, 960));
        let [red, green, blue] = PALETTE[0];
        assert!(image.pixels.iter().filter(|&&p| p == [red, green, blue]).count() > 200);
        assert!(svg(&[]).is_ok() && pixels(&[]).is_ok());
    }
}
