//! How much a fruit looks like an ellipsoid: delta from its front, rho from its bottom. Eq. (1) and (2), Fig. 2.
//!
//! Both start from the minimum-area bounding rectangle of a silhouette: the non-zero pixels of a mask that shows one
//! fruit and nothing else. A pixel is a unit square, so the rectangle encloses its corners and not just its centre.

use crate::image::LabelImage;

/// A rectangle around a silhouette, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectangle {
    /// a_re: the longer side.
    pub length_px: f64,
    /// b_re: the shorter side.
    pub width_px: f64,
}

/// delta of Eq. (1), at most 1: one less the relative difference between the area of the front projection and that of
/// the ellipse inscribed in its bounding rectangle. 1 = as large as that ellipse. Nothing for an empty mask.
///
/// It compares areas, as the paper does: a shape that is full in one corner and hollow in another may reach 1.
/// Below 0 when the projection fills less than half the ellipse.
pub fn front_similarity(front: &LabelImage) -> Option<f64> {
    let rectangle = bounding_rectangle(front)?;
    let projection = front.pixels.iter().filter(|&&label| label != 0).count() as f64;
    let ellipse = std::f64::consts::FRAC_PI_4 * rectangle.length_px * rectangle.width_px;
    Some(1.0 - (projection - ellipse).abs() / projection)
}

/// rho of Eq. (2), in `(0, 1]`: shorter over longer side of the bottom's bounding rectangle. Nothing for an empty mask.
pub fn bottom_similarity(bottom: &LabelImage) -> Option<f64> {
    bounding_rectangle(bottom).map(|rectangle| rectangle.width_px / rectangle.length_px)
}

/// The bounding rectangle of least area, at any angle, by rotating calipers over the convex hull: one of its sides
/// contains an edge of the hull (H. Freeman, R. Shapira, Determining the minimum-area encasing rectangle for an
/// arbitrary closed curve, 1975). `O(pixels)` and `O(h)` for h corners of the hull. Nothing for an empty mask.
pub fn bounding_rectangle(mask: &LabelImage) -> Option<Rectangle> {
    let hull = convex_hull(&outer_corners(mask));
    let count = hull.len();
    if count < 3 {
        return None;
    }
    // Farthest corner forwards, leftwards and backwards along the edge in hand; each only ever moves on.
    let (mut front, mut top, mut back) = (1, 1, 1);
    let mut best: Option<(f64, Rectangle)> = None;
    for from in 0..count {
        let edge = between(hull[from], hull[(from + 1) % count]);
        let advance = |start: usize, gain: &dyn Fn(Corner) -> i64| {
            let mut at = start;
            while gain(between(hull[at % count], hull[(at + 1) % count])) > 0 {
                at += 1;
            }
            at
        };
        front = advance(front.max(from), &|step| dot(edge, step));
        top = advance(top.max(front), &|step| cross(edge, step));
        back = advance(back.max(top), &|step| -dot(edge, step));
        let length = (dot(edge, edge) as f64).sqrt();
        let along = dot(edge, between(hull[back % count], hull[front % count])) as f64 / length;
        let across = cross(edge, between(hull[from], hull[top % count])) as f64 / length;
        if best.is_none_or(|(area, _)| along * across < area) {
            let rectangle = Rectangle { length_px: along.max(across), width_px: along.min(across) };
            best = Some((along * across, rectangle));
        }
    }
    best.map(|(_, rectangle)| rectangle)
}

/// Corner of a pixel, in pixels from the image's top left corner. Integers: hull and calipers are exact.
type Corner = [i64; 2];

fn between(p: Corner, q: Corner) -> Corner {
    [q[0] - p[0], q[1] - p[1]]
}

fn dot(p: Corner, q: Corner) -> i64 {
    p[0] * q[0] + p[1] * q[1]
}

fn cross(p: Corner, q: Corner) -> i64 {
    p[0] * q[1] - p[1] * q[0]
}

/// Corners of the first and last pixel of each row: the hull has no others. Ascending by row, then column.
fn outer_corners(mask: &LabelImage) -> Vec<Corner> {
    let mut corners = Vec::new();
    for v in 0..mask.height {
        let row = &mask.pixels[v * mask.width..(v + 1) * mask.width];
        let (Some(first), Some(last)) = (row.iter().position(|&l| l != 0), row.iter().rposition(|&l| l != 0))
        else {
            continue;
        };
        let (left, right, top) = (first as i64, last as i64 + 1, v as i64);
        corners.extend([[left, top], [right, top], [left, top + 1], [right, top + 1]]);
    }
    corners
}

/// Convex hull without corners on its edges, by monotone chains (A. M. Andrew, 1979), turning from x to y.
fn convex_hull(corners: &[Corner]) -> Vec<Corner> {
    let mut sorted = corners.to_vec();
    sorted.sort_unstable();
    sorted.dedup();
    let mut hull: Vec<Corner> = Vec::new();
    let mut chain = |ordered: &mut dyn Iterator<Item = Corner>| {
        let start = hull.len();
        for corner in ordered {
            while hull.len() >= start + 2 {
                let [p, q] = [hull[hull.len() - 2], hull[hull.len() - 1]];
                if cross(between(p, q), between(q, corner)) > 0 {
                    break;
                }
                hull.pop();
            }
            hull.push(corner);
        }
        // The last corner of a chain is the first of the other.
        hull.pop();
    };
    chain(&mut sorted.iter().copied());
    chain(&mut sorted.iter().rev().copied());
    hull
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pixels whose centres `inside` accepts, relative to the image's centre.
    fn drawn(size: usize, inside: impl Fn(f64, f64) -> bool) -> LabelImage {
        let mut mask = LabelImage::filled(size, size, 0);
        let middle = (size as f64 - 1.0) / 2.0;
        for v in 0..size {
            for u in 0..size {
                if inside(u as f64 - middle, v as f64 - middle) {
                    mask.set(u as i64, v as i64, 255);
                }
            }
        }
        mask
    }

    fn turned(x: f64, y: f64, angle_deg: f64) -> (f64, f64) {
        let (sin, cos) = libm::sincos(angle_deg.to_radians());
        (x * cos + y * sin, y * cos - x * sin)
    }

    #[test]
    fn ellipses_at_any_angle_are_similar_and_their_sides_are_their_axes() {
        for angle in [0.0, 10.0, 30.0, 45.0, 77.0, 90.0] {
            let mask = drawn(301, |x, y| {
                let (p, q) = turned(x, y, angle);
                (p / 120.0).powi(2) + (q / 60.0).powi(2) <= 1.0
            });
            let rectangle = bounding_rectangle(&mask).unwrap();
            assert!((rectangle.length_px - 240.0).abs() < 2.5, "{angle}: {rectangle:?}");
            assert!((rectangle.width_px - 120.0).abs() < 2.5, "{angle}: {rectangle:?}");
            assert!(front_similarity(&mask).unwrap() > 0.97, "{angle}");
            assert!((bottom_similarity(&mask).unwrap() - 0.5).abs() < 0.01, "{angle}");
        }
    }

    #[test]
    fn an_upright_rectangle_is_exact() {
        let mask = drawn(100, |x, y| x.abs() < 30.0 && y.abs() < 20.0);
        assert_eq!(bounding_rectangle(&mask), Some(Rectangle { length_px: 60.0, width_px: 40.0 }));
        // 1 - (1 - pi / 4).
        assert!((front_similarity(&mask).unwrap() - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
        assert!((bottom_similarity(&mask).unwrap() - 2.0 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn a_turned_rectangle_keeps_its_sides() {
        let mask = drawn(301, |x, y| {
            let (p, q) = turned(x, y, 33.0);
            p.abs() <= 100.0 && q.abs() <= 40.0
        });
        let rectangle = bounding_rectangle(&mask).unwrap();
        assert!(
            (rectangle.length_px - 200.0).abs() < 2.5 && (rectangle.width_px - 80.0).abs() < 2.5,
            "{rectangle:?}"
        );
    }

    #[test]
    fn a_disc_is_round_and_a_diamond_is_its_own_rectangle() {
        let disc = drawn(201, |x, y| x * x + y * y <= 90.0 * 90.0);
        assert!(bottom_similarity(&disc).unwrap() > 0.99);
        // Stairs along the sides of the diamond: the hull's edges are the diagonals, at 45 degrees.
        let diamond = drawn(201, |x, y| x.abs() + y.abs() <= 80.0);
        let rectangle = bounding_rectangle(&diamond).unwrap();
        assert!((rectangle.length_px - 161.0 / 2.0_f64.sqrt() - 0.71).abs() < 1.0, "{rectangle:?}");
    }

    #[test]
    fn one_pixel_a_line_and_nothing() {
        let one = drawn(9, |x, y| x == 0.0 && y == 0.0);
        assert_eq!(bounding_rectangle(&one), Some(Rectangle { length_px: 1.0, width_px: 1.0 }));
        let line = drawn(9, |x, y| x.abs() <= 3.0 && y == 0.0);
        assert_eq!(bounding_rectangle(&line), Some(Rectangle { length_px: 7.0, width_px: 1.0 }));
        let nothing = LabelImage::filled(9, 9, 0);
        assert_eq!((front_similarity(&nothing), bottom_similarity(&nothing)), (None, None));
    }

    #[test]
    fn the_calipers_agree_with_trying_every_edge() {
        let mask = drawn(121, |x, y| (x * 0.7 + y).abs() < 25.0 && (x - 9.0).abs() < 44.0 && x * y < 600.0);
        let hull = convex_hull(&outer_corners(&mask));
        let area = |edge: Corner| {
            let extent = |measure: &dyn Fn(Corner) -> i64| {
                let values: Vec<i64> = hull.iter().map(|&c| measure(c)).collect();
                (values.iter().max().unwrap() - values.iter().min().unwrap()) as f64
            };
            extent(&|c| dot(edge, c)) * extent(&|c| cross(edge, c)) / dot(edge, edge) as f64
        };
        let least = (0..hull.len())
            .map(|k| area(between(hull[k], hull[(k + 1) % hull.len()])))
            .fold(f64::MAX, f64::min);
        let rectangle = bounding_rectangle(&mask).unwrap();
        assert!((rectangle.length_px * rectangle.width_px - least).abs() < 1e-6);
        assert!(hull.len() > 6, "{hull:?}");
    }
}
