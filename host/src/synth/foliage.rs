//! The far background: trees 2 to 3 m away, out of focus, with sky between them.
//!
//! A wall whose look is noise in space: blobs of foliage, denser below, the sky above and in gaps. The depth camera
//! measures the foliage, slightly rough, and nothing where the sky shines through; the colour camera sees it blurred.
//! Blurred as it is, the wall is painted once, coarsely, and interpolated for both.

use nalgebra::Vector3;

use super::noise::{Noise, cloudy_noise, value_noise};
use super::sensor::Echo;
use super::shade::{Light, linear, smoothstep};
use super::shape::Ray;

/// Depth of the wall, millimetres.
const WALL_MM: f32 = 2500.0;
/// Depth of its relief, millimetres.
const RELIEF_MM: f32 = 600.0;
/// Distance of painted places: six pixels of the colour camera, millimetres.
const STEP_MM: f32 = 15.0;
/// Painted places; the wall fills the view of both cameras.
const COLUMNS: usize = 320;
const ROWS: usize = 210;
/// Discs of light that the lens makes of bright spots.
const GLINTS: usize = 120;
/// Number of this surface.
pub(super) const SURFACE: u16 = u16::MAX;

/// One place of the wall.
#[derive(Debug, Clone, Copy)]
struct Patch {
    /// Share of foliage, 0 sky to 1.
    share: f32,
    z_mm: f32,
    light: Light,
}

/// The painted wall.
pub(super) struct Backdrop {
    patches: Vec<Patch>,
}

impl Backdrop {
    /// Paints the wall that belongs to `field`. `O(1)`: 67 000 places.
    pub(super) fn paint(field: u32) -> Self {
        let place = |index: usize, count: usize| (index as f32 - count as f32 / 2.0) * STEP_MM / 1000.0;
        let patches = (0..ROWS).flat_map(|row| {
            (0..COLUMNS).map(move |column| patch(place(column, COLUMNS), place(row, ROWS), field))
        });
        let mut backdrop = Self { patches: patches.collect() };
        let mut noise = Noise::new(u64::from(field));
        for _ in 0..GLINTS {
            backdrop.add_glint(&mut noise);
        }
        backdrop
    }

    /// A soft disc, brighter at its rim, where a gap lets the sky through or a leaf mirrors it.
    fn add_glint(&mut self, noise: &mut Noise) {
        let (x, y) = (noise.between(0.0, COLUMNS as f64) as f32, noise.between(0.0, ROWS as f64) as f32);
        let radius = noise.between(2.6, 5.8) as f32;
        let strength = noise.between(0.03, 0.20) as f32;
        let tint = linear([0.80, 0.90, 0.52]).lerp(&linear([0.86, 0.93, 0.95]), noise.uniform() as f32);
        // Casts saturate at the wall's upper and left end.
        let reach = |centre: f32, count: usize| {
            (centre - 1.3 * radius) as usize..((centre + 1.3 * radius) as usize + 1).min(count)
        };
        for row in reach(y, ROWS) {
            for column in reach(x, COLUMNS) {
                let (dx, dy) = (column as f32 - x, row as f32 - y);
                let square = (dx * dx + dy * dy) / (radius * radius);
                let disc = (1.0 - smoothstep(0.8, 1.15, square.sqrt())) * (0.7 + 0.3 * square);
                let light = &mut self.patches[row * COLUMNS + column].light;
                *light = light.lerp(&tint, strength * disc);
            }
        }
    }

    /// Light that comes along a ray when nothing nearer is in its way.
    pub(super) fn light(&self, ray: &Ray) -> Light {
        let ([a, b, c, d], s, t) = self.around(ray);
        a.light.lerp(&b.light, s).lerp(&c.light.lerp(&d.light, s), t)
    }

    /// What a ray of the depth camera meets when nothing nearer is in its way.
    pub(super) fn echo(&self, ray: &Ray) -> Option<Echo> {
        let ([a, b, c, d], s, t) = self.around(ray);
        let mix = |value: fn(&Patch) -> f32| {
            let (above, below) = (value(a) + (value(b) - value(a)) * s, value(c) + (value(d) - value(c)) * s);
            above + (below - above) * t
        };
        let z_mm = f64::from(mix(|patch| patch.z_mm));
        (mix(|patch| patch.share) > 0.5).then_some(Echo { z_mm, cosine: 0.9, surface: SURFACE })
    }

    /// The four patches around where a ray meets the wall, and where between them. At the wall's end the last repeat.
    fn around(&self, ray: &Ray) -> ([&Patch; 4], f32, f32) {
        let meets = ray.origin + ray.direction * f64::from(WALL_MM);
        let place = |meets: f64, count: usize| {
            let place = (meets as f32 / STEP_MM + count as f32 / 2.0).clamp(0.0, count as f32 - 1.001);
            (place as usize, place - (place as usize) as f32)
        };
        let ((column, s), (row, t)) = (place(meets.x, COLUMNS), place(meets.y, ROWS));
        let patch = |i: usize, j: usize| &self.patches[(row + j) * COLUMNS + column + i];
        ([patch(0, 0), patch(1, 0), patch(0, 1), patch(1, 1)], s, t)
    }
}

/// The wall at `x`, `y`, metres.
fn patch(x: f32, y: f32, field: u32) -> Patch {
    let clumps = cloudy_noise(Vector3::new(x * 1.7, y * 1.7, 0.5), field);
    let relief = cloudy_noise(Vector3::new(x * 5.0, y * 5.0, 3.5), field);
    let hue = value_noise(Vector3::new(x * 2.3, y * 2.3, 7.5), field);
    // y grows downwards: the sky opens above.
    let share = smoothstep(0.30, 0.44, clumps + 0.16 + 0.30 * y + 0.25 * (relief - 0.5));
    let green = linear([0.15, 0.26, 0.11]).lerp(&linear([0.40, 0.50, 0.20]), smoothstep(0.35, 0.8, relief));
    let green = green.lerp(&linear([0.44, 0.49, 0.22]), 0.35 * hue);
    let shade = 1.0 - 0.35 * smoothstep(-0.2, 1.2, y);
    let sky = linear([0.66, 0.81, 0.96]).lerp(&linear([0.84, 0.92, 0.98]), smoothstep(-1.2, 0.2, y));
    Patch { share, z_mm: WALL_MM + RELIEF_MM * (relief - 0.5), light: sky.lerp(&(green * shade), share) }
}
