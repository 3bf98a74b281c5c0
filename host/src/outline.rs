//! Outline rays from a depth image: where fruit end and something further away begins.
//!
//! In: depth in mm along z, the mask of fruit-coloured pixels, the camera. Out: rays for
//! [`OutlineRay`]. The mask only says where to look, with a tolerance of a pixel; what makes a pair is depth.
//! From each valid pixel on or beside the mask one walks outward in the four directions of the grid:
//! * the pixel on the other side must be of the same surface (within `step_mm`), else the start is a mixed pixel;
//! * the first valid pixel on the way decides: nearer, or of the same surface: no pair (something covers the fruit, or
//!   the fruit goes on); further by `step_mm` or more: a pair, unless the one after it is further by as much again: then
//!   it is a mixed pixel itself and the next one takes its place;
//! * the surface goes on within two pixels behind the far one: no pair, the far one was an error;
//! * three pixels without depth: a weak pair, for a surface too steep or a background too far to be measured.
//!
//! The ray runs through the middle of the pair. Its deviation grows with the steps between the two: half a pixel's
//! uniform error is 0.29 px.

use varsac_core::{OutlineRay, Point3};

use std::ops::RangeInclusive;

use crate::image::DepthImage;

/// Pixels walked at most.
const REACH: i64 = 4;
/// Pixels beyond the far one that must not show the same surface again: near a rim single pixels are far off, and an
/// outline does not run around each of them.
const BEYOND: i64 = 2;
/// Pixels without depth that make a weak pair.
const GAP: i64 = 3;
/// Deviation of a weak pair, pixels.
const WEAK_PX: f64 = 1.2;
/// Deviation of where the pixels beside an edge look, and of where along a steep rim the last valid one lies, pixels.
const EDGE_PX: f64 = 0.35;
/// A weak pair's ray is this far outside the last pixel on the fruit: the rim lies within the first missing pixels.
const WEAK_OFFSET_PX: f64 = 0.75;

/// Finds the outline rays of all fruit of a mask, row by row within `columns` and `rows`. `ray` gives the direction (x, y, 1) of a pixel, `focal_px` the
/// focal length (for the deviation), `step_mm` what separates two surfaces: about the shortest semi-axis of the fruit.
pub fn outline_rays(
    depth: &DepthImage,
    (columns, rows): (RangeInclusive<i64>, RangeInclusive<i64>),
    in_mask: impl Fn(i64, i64) -> bool,
    focal_px: f64,
    ray: impl Fn(f64, f64) -> [f64; 2],
    step_mm: f32,
) -> Vec<OutlineRay> {
    let mut rays = Vec::new();
    let at = |u: i64, v: i64| depth.get(u, v).filter(|&z| z > 0.0);
    for v in rows {
        for u in columns.clone() {
            let Some(inner) = at(u, v) else { continue };
            let near_mask = (-1..=1).any(|dv| (-1..=1).any(|du| in_mask(u + du, v + dv)));
            if !near_mask {
                continue;
            }
            for (du, dv) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let inside = at(u - du, v - dv);
                if !inside.is_some_and(|z| (z - inner).abs() < step_mm) {
                    continue;
                }
                // What the border of the image cuts has no outline there.
                let end = (u + GAP * du, v + GAP * dv);
                if depth.get(end.0, end.1).is_none() {
                    continue;
                }
                let Some((offset_px, sigma_px, outer_mm)) = walk(&at, (u, v), (du, dv), inner, step_mm)
                else {
                    continue;
                };
                let [x, y] = ray(u as f64 + offset_px * du as f64, v as f64 + offset_px * dv as f64);
                let z = f64::from(inner);
                rays.push(OutlineRay {
                    inner: Point3::new((x * z) as f32, (y * z) as f32, inner),
                    outer_mm,
                    sigma_rad: (sigma_px / focal_px) as f32,
                });
            }
        }
    }
    rays
}

/// Offset of the ray from the start and its deviation, pixels, and the depth behind, mm.
fn walk(
    at: &impl Fn(i64, i64) -> Option<f32>,
    (u, v): (i64, i64),
    (du, dv): (i64, i64),
    inner: f32,
    step_mm: f32,
) -> Option<(f64, f64, f32)> {
    for step in 1..=REACH {
        let Some(outer) = at(u + step * du, v + step * dv) else {
            if step == GAP {
                return Some((WEAK_OFFSET_PX, WEAK_PX, f32::INFINITY));
            }
            continue;
        };
        let same = |z: f32| (z - inner).abs() < step_mm;
        let goes_on = (1..=BEYOND).any(|k| at(u + (step + k) * du, v + (step + k) * dv).is_some_and(same));
        if outer < inner + step_mm || goes_on {
            return None;
        }
        let next = at(u + (step + 1) * du, v + (step + 1) * dv).filter(|&z| z >= outer + step_mm);
        let (steps, outer) = next.map_or((step, outer), |z| (step + 1, z));
        let width = (0.29 * steps as f64).max(0.3);
        let sigma = libm::sqrt(width * width + EDGE_PX * EDGE_PX);
        return Some((0.5 * steps as f64, sigma, outer));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;

    /// A row of depths, the fruit's mask over the first four.
    fn rays_of(row: [f32; 9]) -> Vec<OutlineRay> {
        let mut depth = Image::filled(9, 1, 0.0);
        depth.pixels.copy_from_slice(&row);
        outline_rays(&depth, (0..=8, 0..=0), |u, _| u < 4, 365.0, |u, v| [u / 365.0, v / 365.0], 10.0)
    }

    #[test]
    fn a_step_back_is_an_outline_and_a_step_forward_is_not() {
        let found = rays_of([700.0, 700.0, 701.0, 703.0, 800.0, 800.0, 800.0, 800.0, 800.0]);
        assert_eq!(found.len(), 1);
        assert!((found[0].inner.x - 3.5 / 365.0 * 703.0).abs() < 1e-3);
        assert_eq!(found[0].outer_mm, 800.0);
        // The leaf in front has an outline of its own; the fruit has none there.
        let leaf = rays_of([700.0, 700.0, 701.0, 703.0, 600.0, 600.0, 600.0, 600.0, 600.0]);
        assert!(leaf.iter().all(|ray| ray.inner.z == 600.0));
        assert!(rays_of([700.0, 700.0, 701.0, 703.0, 705.0, 706.0, 707.0, 708.0, 709.0]).is_empty());
    }

    #[test]
    fn a_mixed_pixel_is_stepped_over() {
        let found = rays_of([700.0, 700.0, 701.0, 703.0, 740.0, 800.0, 800.0, 800.0, 800.0]);
        // From pixel 3 over the mixed pixel 4 to pixel 5: the middle is pixel 4.
        assert_eq!(found.len(), 1);
        assert!((found[0].inner.x - 4.0 / 365.0 * 703.0).abs() < 1e-3);
    }

    #[test]
    fn missing_pixels_make_a_weak_pair_only_after_three() {
        let found = rays_of([700.0, 700.0, 701.0, 703.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].outer_mm, f32::INFINITY);
        let found = rays_of([700.0, 700.0, 701.0, 703.0, 0.0, 0.0, 800.0, 800.0, 800.0]);
        assert!((found[0].inner.x - 4.5 / 365.0 * 703.0).abs() < 1e-3);
    }
}
