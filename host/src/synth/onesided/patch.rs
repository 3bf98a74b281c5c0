//! A depth patch as a time-of-flight camera would record it: pinhole rays, mixed pixels, noise, holes, counts.
//!
//! In: bodies in the camera frame (mm), a sensor, a window of pixels. Out: depth in mm, the body each pixel shows.
//! A pixel looks along its centre or averages the rays over its area. Where these see two surfaces the pixel is mixed: it reports something in
//! between (a flying pixel), the nearer of the two clusters, or nothing.

use super::{
    draws::Draws,
    shapes::{Pose, Shape, V3},
};
use crate::image::{DepthImage, Image, LabelImage};

/// Focal length of an ideal Kinect v2 depth camera, pixels.
pub const FOCAL_PX: f64 = 365.456;

/// One body of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Centre and axes.
    pub pose: Pose,
    /// Geometry.
    pub shape: Shape,
    /// True where a colour threshold would take it for fruit.
    pub fruit_coloured: bool,
}

/// What the camera does to a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Focal length in pixels; principal point at (0, 0) of the pixel coordinates.
    pub focal_px: f64,
    /// Standard deviation along z of a frontal surface, mm.
    pub axial_mm: f64,
    /// Factor on the growth of that deviation with the angle of incidence (1 = Fankhauser et al. 2015, Kinect v2).
    pub slant: f64,
    /// Standard deviation of where a pixel looks, pixels.
    pub lateral_px: f64,
    /// Step of the depth counts, mm.
    pub quantum_mm: f64,
    /// Chance that a mixed pixel reports something between its surfaces.
    pub flying: f64,
    /// Chance that a mixed pixel reports nothing.
    pub edge_hole: f64,
    /// Chance that any pixel reports nothing.
    pub hole: f64,
    /// Rays across one pixel, each way: 1 = an ideal pixel looks along its centre, 3 = it averages what it covers.
    pub rays: u32,
}

/// A window of pixels: column `u` of the patch is pixel `left + u` from the principal point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    /// First column, pixels from the principal point.
    pub left: i64,
    /// First row.
    pub top: i64,
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// A rendered patch.
#[derive(Debug, Clone, PartialEq)]
pub struct Patch {
    /// Where it sits.
    pub window: Window,
    /// Depth along z in mm, 0 = none.
    pub depth: DepthImage,
    /// Index of the body at the centre of each pixel plus one; 0 where there is none.
    pub owner: LabelImage,
}

/// Depths of one pixel's rays further apart than this make it a mixed pixel, mm.
const MIXED_MM: f64 = 12.0;
/// Most rays across one pixel, each way.
const MAX_RAYS: u32 = 5;
/// Cap of the slant term's deviation, mm.
const SLANT_CAP_MM: f64 = 8.0;

/// The nearest body along a ray and its depth and cosine.
pub(super) fn first_hit(bodies: &[Body], ray: V3) -> Option<(usize, f64, f64)> {
    let mut best: Option<(usize, f64, f64)> = None;
    for (index, body) in bodies.iter().enumerate() {
        if let Some(hit) = body.shape.hit(&body.pose, ray)
            && best.is_none_or(|(_, depth, _)| hit.depth < depth)
        {
            best = Some((index, hit.depth, hit.cosine));
        }
    }
    best
}

/// Records the window.
pub(super) fn record(bodies: &[Body], sensor: &Sensor, window: Window, draws: &mut Draws) -> Patch {
    let mut depth = Image::filled(window.width, window.height, 0.0_f32);
    let mut owner = Image::filled(window.width, window.height, 0_u8);
    for v in 0..window.height as i64 {
        for u in 0..window.width as i64 {
            let (x, y) = ((window.left + u) as f64, (window.top + v) as f64);
            let centre = [x / sensor.focal_px, y / sensor.focal_px, 1.0];
            if let Some((index, _, _)) = first_hit(bodies, centre) {
                owner.set(u, v, index as u8 + 1);
            }
            depth.set(u, v, pixel(bodies, sensor, (x, y), draws) as f32);
        }
    }
    Patch { window, depth, owner }
}

/// One pixel's reading, 0 = none.
fn pixel(bodies: &[Body], sensor: &Sensor, (x, y): (f64, f64), draws: &mut Draws) -> f64 {
    let (du, dv) = (sensor.lateral_px * draws.normal(), sensor.lateral_px * draws.normal());
    let (flight, hole, axial) = (draws.uniform(0.0, 1.0), draws.uniform(0.0, 1.0), draws.normal());
    let rays = sensor.rays.clamp(1, MAX_RAYS);
    let middle_ray = 0.5 * f64::from(rays - 1);
    let mut depths = [0.0; (MAX_RAYS * MAX_RAYS) as usize];
    let mut count = 0;
    let mut cosines = 0.0;
    for j in 0..rays {
        for i in 0..rays {
            let offset = |k: u32| (f64::from(k) - middle_ray) / f64::from(rays);
            let (su, sv) = (offset(i), offset(j));
            let ray = [(x + du + su) / sensor.focal_px, (y + dv + sv) / sensor.focal_px, 1.0];
            if let Some((_, depth, cosine)) = first_hit(bodies, ray) {
                depths[count] = depth;
                cosines += cosine;
                count += 1;
            }
        }
    }
    if count == 0 || hole < sensor.hole {
        return 0.0;
    }
    let seen = &mut depths[..count];
    seen.sort_by(f64::total_cmp);
    let (nearest, furthest) = (seen[0], seen[count - 1]);
    let middle = seen.iter().sum::<f64>() / count as f64;
    let is_mixed = furthest - nearest >= MIXED_MM;
    let value = if !is_mixed || flight < sensor.flying {
        middle
    } else if flight < sensor.flying + sensor.edge_hole {
        return 0.0;
    } else {
        // The larger cluster: split where the gap is widest.
        let split = (1..count)
            .max_by(|&i, &j| (seen[i] - seen[i - 1]).total_cmp(&(seen[j] - seen[j - 1])))
            .unwrap_or(0);
        let part = if 2 * split >= count { &seen[..split] } else { &seen[split..] };
        part.iter().sum::<f64>() / part.len() as f64
    };
    let theta = libm::acos((cosines / count as f64).clamp(0.0, 1.0));
    let left = core::f64::consts::FRAC_PI_2 - theta;
    let metres = 0.001 * value;
    let slant = 0.1 * metres * libm::sqrt(metres) * theta * theta / (left * left).max(1e-6);
    let deviation = sensor.axial_mm + sensor.slant * slant.min(SLANT_CAP_MM);
    let value = value + deviation * axial;
    if sensor.quantum_mm > 0.0 { libm::rint(value / sensor.quantum_mm) * sensor.quantum_mm } else { value }
}
