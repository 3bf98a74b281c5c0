//! A picture of every result: outlines, axes, sizes and status of the ellipsoids over the camera's colour image.
//!
//! [`draw_overlays`] is for frames and [`draw_cloud`] for clouds without a picture. Both leave the
//! picture itself as it is: small ones are enlarged by a whole number, so that lines and text stay legible, and the
//! legend is a strip below. One colour a fruit, from a palette that colour-blind people can tell apart, over the refused
//! ones: these are thin, grey and dashed outlines that say why.

pub mod canvas;
pub mod cloud;
pub mod label;
pub mod outline;
pub mod text;

pub use canvas::write_png;
pub use cloud::draw_cloud;
pub use outline::{View, Viewpoint};

use nalgebra::Matrix3;

use crate::eval::EllipsoidF64;
use crate::image::ColourImage;
use canvas::{Canvas, Colour, Frame, Position, Stroke};
use label::Label;
use text::Font;

/// What became of a target.
#[derive(Debug, Clone, PartialEq)]
pub enum Status {
    /// Found or accepted; the words are shown behind its size (a score, say), and may be empty.
    Found(String),
    /// Refused; the words say why.
    Refused(String),
}

/// One target to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct Overlay {
    /// Number in the list of results, from 1; chooses the colour.
    pub number: u32,
    /// The ellipsoid, in the frame that the view projects from.
    pub ellipsoid: EllipsoidF64,
    /// Found or refused.
    pub status: Status,
    /// Covariance of the centre, square millimetres, where there is one: drawn as the ellipse that holds the centre with
    /// 95 % probability.
    pub centre_covariance_mm2: Option<[[f64; 3]; 3]>,
}

/// After Okabe and Ito (Color universal design, 2008): those of their colours that are bright enough for a dark rim,
/// purple and green a little lighter than theirs.
const PALETTE: [Colour; 5] = [[86, 180, 233], [240, 228, 66], [230, 159, 0], [224, 145, 192], [0, 190, 140]];

/// Colour of refused targets.
const REFUSED: Colour = [205, 205, 205];
/// Colour of the ellipse that holds the centre.
const UNCERTAINTY: Colour = [255; 3];
/// Colour of the reason.
const REASON: Colour = [255, 150, 100];
/// Colour of plain text.
const TEXT: Colour = [235, 235, 235];
/// Colour behind text.
const DARK: Colour = [18, 20, 24];

/// The colour of a target by its number, from 1; number 0, no target, is grey.
pub fn colour_of(number: u32) -> Colour {
    match number.checked_sub(1) {
        Some(place) => PALETTE[place as usize % PALETTE.len()],
        None => [120, 120, 120],
    }
}

impl Overlay {
    /// The colour of its lines.
    pub fn colour(&self) -> Colour {
        match self.status {
            Status::Found(_) => colour_of(self.number),
            Status::Refused(_) => REFUSED,
        }
    }

    pub(crate) fn is_refused(&self) -> bool {
        matches!(self.status, Status::Refused(_))
    }

    /// Standard deviation of the centre in the direction in which it is largest, mm.
    fn sigma_mm(&self) -> Option<f64> {
        let rows = self.centre_covariance_mm2?;
        Some(Matrix3::from(rows).symmetric_eigenvalues().max().sqrt())
    }
}

/// Line widths and text size for a picture: they grow with it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scale {
    /// Width of an outline, pixels; everything else is a multiple of it.
    line_px: f64,
    font: Font,
    bold: Font,
    is_crowded: bool,
}

impl Scale {
    pub(crate) fn of(width: usize, height: usize, targets: usize) -> Self {
        let relative = width.max(height) as f64 / 1920.0;
        let is_crowded = targets > CROWD;
        let text_px = (if is_crowded { 18.0 } else { 22.0 } * relative).max(16.0);
        let (font, bold) = (Font::of_height(text_px, false), Font::of_height(text_px, true));
        Self { line_px: (2.5 * relative).max(1.8), font, bold, is_crowded }
    }
}

/// With more targets than this, labels are smaller and have one line: the size, or why refused.
const CROWD: usize = 12;

/// Pictures narrower than this are enlarged.
const LEGIBLE_WIDTH: usize = 1200;

/// Draws the targets over a picture; `view` maps space to the pixels of that picture. The captions (frame, method, ...)
/// go into the legend below, after the counts, and wrap like words.
///
/// The result is at least about 1200 pixels wide (at most four times the original) and higher by the legend.
pub fn draw_overlays(
    picture: &ColourImage,
    overlays: &[Overlay],
    view: &View,
    captions: &[&str],
) -> ColourImage {
    if picture.pixels.is_empty() {
        return picture.clone();
    }
    let factor = LEGIBLE_WIDTH.div_ceil(picture.width).min(4);
    let mut canvas = Canvas::new(enlarged(picture, factor));
    let scale = Scale::of(picture.width * factor, picture.height * factor, overlays.len());
    let project = |point| {
        let (u, v) = (view.project)(point)?;
        let place = |pixel: f64| (pixel + 0.5) * factor as f64 - 0.5;
        Some((place(u), place(v)))
    };
    let view = View { viewpoint: view.viewpoint, project: &project };
    let outlines = draw_targets(&mut canvas, overlays, &view, &scale);
    let whole = Frame { left: 0.0, top: 0.0, width: canvas.size().0 as f64, height: canvas.size().1 as f64 };
    label::draw_labels(&mut canvas, &labels(overlays, &outlines, &scale), &whole, &scale);
    label::with_legend(&canvas.finish(), overlays, captions, &scale)
}

/// Each pixel becomes a square of `factor` by `factor`.
fn enlarged(picture: &ColourImage, factor: usize) -> ColourImage {
    let (width, height) = (picture.width * factor, picture.height * factor);
    let mut pixels = Vec::with_capacity(width * height);
    for row in picture.pixels.chunks_exact(picture.width) {
        let start = pixels.len();
        pixels.extend(row.iter().flat_map(|&pixel| std::iter::repeat_n(pixel, factor)));
        for _ in 1..factor {
            pixels.extend_from_within(start..start + width);
        }
    }
    ColourImage { width, height, pixels }
}

/// Draws the lines of all targets, the refused below the others, and returns their outlines in the order of the targets.
pub(crate) fn draw_targets(
    canvas: &mut Canvas,
    overlays: &[Overlay],
    view: &View,
    scale: &Scale,
) -> Vec<Vec<Position>> {
    let mut outlines = vec![Vec::new(); overlays.len()];
    for layer in [true, false] {
        for (overlay, line) in overlays.iter().zip(&mut outlines) {
            if overlay.is_refused() == layer {
                *line = draw_target(canvas, overlay, view, scale);
            }
        }
    }
    outlines
}

/// Draws the lines of one target and returns its outline (empty when it is out of sight).
fn draw_target(canvas: &mut Canvas, overlay: &Overlay, view: &View, scale: &Scale) -> Vec<Position> {
    let line_px = scale.line_px;
    let line = outline::outline(&overlay.ellipsoid, view);
    if overlay.is_refused() {
        canvas.stroke_with_halo(&line, &refused_stroke(scale));
        return line;
    }
    let solid = |width_px| Stroke::solid(width_px, overlay.colour());
    let axes = outline::semi_axes(&overlay.ellipsoid, view);
    for (axis, width) in axes.iter().zip([0.9, 0.6, 0.6]).rev() {
        canvas.stroke_with_halo(axis, &Stroke { opacity: 0.9, ..solid(width * line_px) });
    }
    canvas.stroke_with_halo(&line, &solid(line_px));
    if let Some(centre) = (view.project)(overlay.ellipsoid.centre_mm) {
        canvas.stroke_with_halo(&[centre], &solid(1.6 * line_px));
    }
    // Above the dot, so that it shows where it is smaller too.
    if let Some(covariance) = &overlay.centre_covariance_mm2 {
        let ellipse = outline::centre_uncertainty(overlay.ellipsoid.centre_mm, covariance, view);
        canvas.stroke_with_halo(&ellipse, &Stroke::solid(0.6 * line_px, UNCERTAINTY));
    }
    line
}

/// How a refused target is outlined.
fn refused_stroke(scale: &Scale) -> Stroke {
    let line_px = scale.line_px;
    Stroke { dash_px: Some((4.0 * line_px, 3.0 * line_px)), ..Stroke::solid(0.6 * line_px, REFUSED) }
}

/// The labels of those targets that are in sight.
fn labels(overlays: &[Overlay], outlines: &[Vec<Position>], scale: &Scale) -> Vec<Label> {
    let label = |(overlay, line): (&Overlay, &Vec<Position>)| {
        let outline: Vec<Position> =
            line.iter().copied().filter(|p| p.0.is_finite() && p.1.is_finite()).collect();
        let [a, b, c] = overlay.ellipsoid.semi_axes_mm;
        let number = overlay.number;
        let sigma = overlay.sigma_mm().map_or_else(String::new, |sigma| format!("  ± {sigma:.1}"));
        let (title, words, words_colour) = match &overlay.status {
            Status::Found(_) if scale.is_crowded => {
                (format!("{number}  {a:.1} × {b:.1} × {c:.1}{sigma}"), String::new(), TEXT)
            }
            Status::Found(note) => {
                (format!("{number}  {a:.1} × {b:.1} × {c:.1} mm{sigma}"), note.clone(), TEXT)
            }
            Status::Refused(reason) if scale.is_crowded => {
                (format!("{number}  {reason}"), String::new(), REASON)
            }
            Status::Refused(reason) => {
                (format!("{number}  {a:.1} × {b:.1} × {c:.1} mm"), format!("refused: {reason}"), REASON)
            }
        };
        Some(Label {
            around: Frame::around(&outline)?,
            outline,
            colour: overlay.colour(),
            is_quiet: overlay.is_refused(),
            title,
            words,
            words_colour,
        })
    };
    overlays.iter().zip(outlines).filter_map(label).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::attitude::axes_of_angles;

    fn pinhole(p: [f64; 3]) -> Option<Position> {
        (p[2] > 0.0).then(|| (300.0 * p[0] / p[2] + 160.0, 300.0 * p[1] / p[2] + 120.0))
    }

    const CAMERA: View<'_> = View { viewpoint: Viewpoint::Point([0.0; 3]), project: &pinhole };

    fn overlay(number: u32, x: f64, status: Status) -> Overlay {
        Overlay {
            number,
            ellipsoid: EllipsoidF64::sorted(
                [x, 0.0, 600.0],
                [40.0, 25.0, 20.0],
                axes_of_angles([0.3, 0.2, 0.9]),
            ),
            status,
            centre_covariance_mm2: Some([[9.0, 0.0, 0.0], [0.0, 9.0, 0.0], [0.0, 0.0, 25.0]]),
        }
    }

    fn differences(p: &ColourImage, q: &ColourImage, columns: std::ops::Range<usize>) -> usize {
        let rows = 0..p.height.min(q.height);
        let differs = |u: usize, v: usize| p.get(u as i64, v as i64) != q.get(u as i64, v as i64);
        rows.map(|v| columns.clone().filter(|&u| differs(u, v)).count()).sum()
    }

    #[test]
    fn a_small_picture_is_enlarged_by_a_whole_number_and_gets_a_legend() {
        let picture = ColourImage::filled(320, 240, [90, 120, 60]);
        let drawn = draw_overlays(&picture, &[], &CAMERA, &["frame 7"]);
        assert_eq!(drawn.width, 1280);
        assert!(drawn.height > 960 && drawn.height < 1060);
        assert_eq!(differences(&drawn, &enlarged(&picture, 4), 0..1280), 0);
    }

    #[test]
    fn targets_are_drawn_where_they_are_and_only_there() {
        let picture = ColourImage::filled(320, 240, [90, 120, 60]);
        let nothing = draw_overlays(&picture, &[], &CAMERA, &[]);
        let one = draw_overlays(&picture, &[overlay(1, -200.0, Status::Found("91 %".into()))], &CAMERA, &[]);
        assert!(differences(&one, &nothing, 0..900) > 1000);
        assert_eq!(differences(&one, &nothing, 900..1280), 0);
        // The centre lies at 160 - 100 = 60, 120, and is dotted in the colour of number 1.
        assert_eq!(one.get(60 * 4 + 2, 120 * 4 + 2), Some(PALETTE[0]));
    }

    #[test]
    fn refused_targets_look_different() {
        let picture = ColourImage::filled(320, 240, [90, 120, 60]);
        let found = draw_overlays(&picture, &[overlay(2, 0.0, Status::Found(String::new()))], &CAMERA, &[]);
        let refused =
            draw_overlays(&picture, &[overlay(2, 0.0, Status::Refused("size".into()))], &CAMERA, &[]);
        let count =
            |image: &ColourImage, colour| image.pixels.iter().filter(|&&pixel| pixel == colour).count();
        assert!(count(&found, PALETTE[1]) > 200 && count(&refused, PALETTE[1]) == 0);
        // Its lines are thinner than two pixels and softened at their edges: few have the very colour.
        assert!(count(&refused, REFUSED) > 0 && count(&found, REFUSED) < 20);
        let nothing = draw_overlays(&picture, &[], &CAMERA, &[]);
        let drawn = |image: &ColourImage| differences(image, &nothing, 0..1280);
        assert!(drawn(&refused) > 500 && drawn(&refused) < drawn(&found), "refused targets stand back");
    }

    #[test]
    fn out_of_sight_and_no_picture_are_harmless() {
        let mut behind = overlay(1, 0.0, Status::Found(String::new()));
        behind.ellipsoid.centre_mm[2] = -600.0;
        let mut nonsense = overlay(2, f64::NAN, Status::Refused(String::new()));
        nonsense.ellipsoid.semi_axes_mm = [0.0; 3];
        let picture = ColourImage::filled(320, 240, [90, 120, 60]);
        let drawn = draw_overlays(&picture, &[behind.clone(), nonsense], &CAMERA, &[]);
        assert_eq!(differences(&drawn, &enlarged(&picture, 4), 0..1280), 0);
        let empty = ColourImage::filled(0, 0, [0; 3]);
        assert_eq!(draw_overlays(&empty, &[behind], &CAMERA, &[]), empty);
    }

    #[test]
    fn number_0_is_no_target() {
        assert!(!PALETTE.contains(&colour_of(0)));
        assert_eq!(colour_of(1), colour_of(1 + PALETTE.len() as u32));
    }
}
