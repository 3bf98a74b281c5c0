//! A picture of a cloud that has none: three orthographic views side by side, points coloured by target.
//!
//! Front (along z, as the camera sees it), side (along x) and top (along y), all at the same scale. The views cover
//! nearly all points and all targets; stray points far out are cut off and not allowed to shrink the rest.

use super::canvas::{Canvas, Colour, Frame, Position, Stroke};
use super::label;
use super::outline::{View, Viewpoint, outline};
use super::{DARK, Overlay, Scale, Status, TEXT, colour_of, draw_targets, labels};
use crate::image::ColourImage;

/// Size of the three views together, pixels.
const SIZE: (usize, usize) = (1920, 840);

/// Background of the views.
const BACKGROUND: Colour = [34, 37, 42];

/// Share of the points at either end of each coordinate that may be cut off.
const CUT: f64 = 0.02;

/// One of the three views: which coordinates go right and down, and which way it looks.
struct Projection {
    name: &'static str,
    right: usize,
    down: usize,
    /// Sign of the downward coordinate: far is up in the top view.
    down_sign: f64,
    along: [f64; 3],
}

const PROJECTIONS: [Projection; 3] = [
    Projection { name: "front: x right, y down", right: 0, down: 1, down_sign: 1.0, along: [0.0, 0.0, 1.0] },
    Projection { name: "side: z right, y down", right: 2, down: 1, down_sign: 1.0, along: [-1.0, 0.0, 0.0] },
    Projection { name: "top: x right, z up", right: 0, down: 2, down_sign: -1.0, along: [0.0, 1.0, 0.0] },
];

/// Draws a cloud, millimetres. `targets[k]` is the number of the target that point k belongs to, 0 for none (a missing
/// entry counts as 0). Points that are not finite are left out. `O(n log n)`.
pub fn draw_cloud(
    points: &[[f32; 3]],
    targets: &[u32],
    overlays: &[Overlay],
    captions: &[&str],
) -> ColourImage {
    let mut canvas = Canvas::new(ColourImage::filled(SIZE.0, SIZE.1, BACKGROUND));
    let scale = Scale::of(SIZE.0, SIZE.1, overlays.len());
    let ranges = [0, 1, 2].map(|axis| range(points, overlays, axis));
    let width = SIZE.0 as f64 / 3.0;
    // One scale for all: the largest at which each view fits into its third, margins included.
    let room = (width * 0.86, SIZE.1 as f64 * 0.78);
    let fits = |p: &Projection| (room.0 / extent(ranges[p.right])).min(room.1 / extent(ranges[p.down]));
    let px_per_mm = PROJECTIONS.iter().map(fits).fold(f64::INFINITY, f64::min);
    for (place, projection) in PROJECTIONS.iter().enumerate() {
        let panel = Frame { left: place as f64 * width, top: 0.0, width, height: SIZE.1 as f64 };
        let project = |point: [f64; 3]| {
            let offset = |axis: usize| px_per_mm * (point[axis] - middle(ranges[axis]));
            let x = panel.left + panel.width / 2.0 + offset(projection.right);
            let y = panel.height / 2.0 + projection.down_sign * offset(projection.down);
            // A view ends where the next begins.
            let inside = x >= panel.left && x < panel.left + panel.width;
            inside.then_some((x, y))
        };
        draw_points(&mut canvas, points, targets, overlays, &project, &projection.along);
        let view = View { viewpoint: Viewpoint::Direction(projection.along), project: &project };
        let outlines = draw_targets(&mut canvas, overlays, &view, &scale);
        if place == 0 {
            label::draw_labels(&mut canvas, &labels(overlays, &outlines, &scale), &panel, &scale);
        }
        canvas.fill(&Frame { left: panel.left - 1.0, width: 2.0, ..panel }, 0.0, DARK, 1.0);
        scale.font.draw(&mut canvas, (panel.left + 16.0, 10.0), projection.name, TEXT);
    }
    draw_scale_bar(&mut canvas, px_per_mm, &scale);
    label::with_legend(&canvas.finish(), overlays, captions, &scale)
}

/// Least and greatest value of a coordinate that the views cover.
fn range(points: &[[f32; 3]], overlays: &[Overlay], axis: usize) -> (f64, f64) {
    let mut values: Vec<f64> =
        points.iter().filter(|p| p.iter().all(|v| v.is_finite())).map(|p| f64::from(p[axis])).collect();
    values.sort_by(f64::total_cmp);
    let cut = (values.len() as f64 * CUT) as usize;
    let kept = values.get(cut..values.len() - cut).unwrap_or(&[]);
    let mut ends: Vec<f64> = kept.first().into_iter().chain(kept.last()).copied().collect();
    for overlay in overlays {
        for axis_direction in [Viewpoint::Direction([1.0, 0.0, 0.0]), Viewpoint::Direction([0.0, 1.0, 0.0])] {
            let keep = |p: [f64; 3]| Some((p[axis], 0.0));
            let contour = outline(&overlay.ellipsoid, &View { viewpoint: axis_direction, project: &keep });
            ends.extend(contour.iter().map(|p| p.0).filter(|v| v.is_finite()));
        }
    }
    let least = ends.iter().copied().fold(f64::INFINITY, f64::min);
    let greatest = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if least <= greatest { (least, greatest) } else { (0.0, 0.0) }
}

/// Length of a range; never zero, so that a cloud without extent can be drawn as the dot it is.
fn extent((least, greatest): (f64, f64)) -> f64 {
    (greatest - least).max(1e-3)
}

fn middle((least, greatest): (f64, f64)) -> f64 {
    f64::midpoint(least, greatest)
}

/// Far points first. Nearer ones are brighter; those of a target have its colour.
fn draw_points(
    canvas: &mut Canvas,
    points: &[[f32; 3]],
    targets: &[u32],
    overlays: &[Overlay],
    project: &dyn Fn([f64; 3]) -> Option<Position>,
    along: &[f64; 3],
) {
    let depth = |p: [f64; 3]| crate::eval::dot(p, *along);
    let mut order: Vec<(f64, usize)> = (points.iter().enumerate())
        .filter(|(_, p)| p.iter().all(|v| v.is_finite()))
        .map(|(index, p)| (depth(p.map(f64::from)), index))
        .collect();
    order.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.cmp(&q.1)));
    let count = order.len();
    // Many points are drawn small, few large.
    let dot_px = (700.0 / (count as f64 + 1.0).sqrt()).clamp(1.6, 5.0);
    for (rank, (_, index)) in order.into_iter().enumerate() {
        let number = targets.get(index).copied().unwrap_or(0);
        let refused = overlays.iter().any(|o| o.number == number && matches!(o.status, Status::Refused(_)));
        let colour = if refused { [176, 128, 112] } else { colour_of(number) };
        // By rank and not by depth: a few far points would make all others equally bright.
        let brightness = 0.55 + 0.45 * rank as f64 / count as f64;
        let colour = colour.map(|channel| (f64::from(channel) * brightness).round() as u8);
        if let Some(position) = project(points[index].map(f64::from)) {
            canvas.dot(position, dot_px, colour);
        }
    }
}

/// A bar of a round length in the lower left corner, about an eighth of a view long.
fn draw_scale_bar(canvas: &mut Canvas, px_per_mm: f64, scale: &Scale) {
    let wished_mm = SIZE.0 as f64 / 24.0 / px_per_mm;
    let power = 10.0_f64.powf(libm::log10(wished_mm).floor());
    let step = [5.0, 2.0, 1.0].into_iter().find(|step| step * power <= wished_mm).unwrap_or(1.0);
    let length_mm = step * power;
    let (x, y) = (20.0, SIZE.1 as f64 - 20.0);
    canvas.stroke(&[(x, y), (x + length_mm * px_per_mm, y)], &Stroke::solid(3.0, TEXT));
    let text = format!("{length_mm} mm");
    scale.font.draw(canvas, (x, y - scale.font.line_height() - 4.0), &text, TEXT);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::EllipsoidF64;
    use crate::eval::attitude::axes_of_angles;

    fn ball() -> (Vec<[f32; 3]>, Overlay) {
        let ellipsoid =
            EllipsoidF64::sorted([5.0, -10.0, 700.0], [20.0, 15.0, 12.0], axes_of_angles([0.5, 0.3, 0.2]));
        let points = (0..1500)
            .map(|k| {
                let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 1500.0;
                let (sin, cos) = libm::sincos(f64::from(k) * 2.4);
                let ring = (1.0 - z * z).sqrt();
                ellipsoid.from_body([20.0 * z, 15.0 * ring * cos, 12.0 * ring * sin]).map(|v| v as f32)
            })
            .collect();
        let overlay = Overlay {
            number: 1,
            ellipsoid,
            status: Status::Found(String::new()),
            centre_covariance_mm2: None,
        };
        (points, overlay)
    }

    #[test]
    fn each_view_shows_the_target() {
        let (points, overlay) = ball();
        let drawn = draw_cloud(&points, &vec![1; points.len()], &[overlay], &["ball"]);
        assert_eq!(drawn.width, SIZE.0);
        for panel in 0..3 {
            let coloured = (0..SIZE.1)
                .flat_map(|v| (panel * 640..(panel + 1) * 640).map(move |u| (u as i64, v as i64)))
                .filter(|&(u, v)| drawn.get(u, v) == Some(colour_of(1)))
                .count();
            assert!(coloured > 300, "view {panel}: {coloured}");
        }
    }

    #[test]
    fn a_stray_point_does_not_shrink_the_rest() {
        let (mut points, _) = ball();
        let before = range(&points, &[], 2);
        points.push([0.0, 0.0, 9e6]);
        points.push([f32::NAN, 0.0, 0.0]);
        let after = range(&points, &[], 2);
        assert!((before.0 - after.0).abs() < 1.0 && (before.1 - after.1).abs() < 1.0, "{before:?} {after:?}");
    }

    #[test]
    fn clouds_without_extent_can_be_drawn() {
        for points in [Vec::new(), vec![[1.0, 2.0, 3.0]], vec![[f32::INFINITY; 3]; 4]] {
            assert!(draw_cloud(&points, &[], &[], &[]).height > SIZE.1);
        }
    }
}
