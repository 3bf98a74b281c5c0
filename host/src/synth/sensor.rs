//! What the depth sensor makes of the scene: noise, mixed pixels, holes, whole millimetres.
//!
//! Axial noise after Fankhauser et al., "Kinect v2 for mobile robot navigation: evaluation and modeling", ICAR 2015:
//! sigma_z = 1.5 - 0.5 z + 0.3 z^2 + 0.1 z^1.5 theta^2 / (pi/2 - theta)^2, z in metres, result in millimetres, theta
//! the angle between the surface normal and the ray. Lateral noise from the same work: 1.6 mm, the wandering of an
//! edge; what it does to depth on a slanted surface is part of the axial term already, so that here it decides which
//! surface a pixel sees and not where on it.
//!
//! A time-of-flight pixel integrates the light of its whole area. Across an edge it reports a depth between the two
//! surfaces, drawn here as the mean weighted by returned light (~ 1/z^2): a flying pixel.

use super::noise::Noise;
use crate::image::Image;

/// Standard deviation of lateral noise, millimetres.
const LATERAL_SIGMA_MM: f64 = 1.6;
/// Beyond this angle the axial formula is used at this angle: it diverges at 90 degrees.
const STEEPEST_RAD: f64 = 1.40;
/// Cosine of the angle at which pixels begin to be lost, and at which none is left: 72 and 85 degrees.
const GRAZING_COSINES: (f64, f64) = (0.309, 0.087);
/// Share of pixels lost for no visible reason.
const RANDOM_LOSS: f64 = 0.004;
/// Share of mixed pixels that the driver's edge filter removes.
const MIXED_LOSS: f64 = 0.4;
/// Depths further apart than this within a pixel are two surfaces, millimetres.
const MIXED_STEP_MM: f64 = 15.0;
/// Samples along each side of a pixel.
const SAMPLES: usize = 3;

/// The properties of the simulated sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorOptions {
    /// Factor on axial and lateral noise: 1 as measured, 0 none.
    pub noise_scale: f64,
    /// Depth is rounded to multiples of this, millimetres; 0 = not at all.
    pub quantum_mm: f64,
    /// Pixels on depth edges report a depth in between; otherwise that of the surface that fills most of the pixel.
    pub flying_pixels: bool,
    /// Pixels are lost at grazing angles, on edges, and at random.
    pub holes: bool,
}

impl Default for SensorOptions {
    /// A Kinect v2.
    fn default() -> Self {
        Self { noise_scale: 1.0, quantum_mm: 1.0, flying_pixels: true, holes: true }
    }
}

impl SensorOptions {
    /// A sensor without any fault.
    pub const PERFECT: Self = Self { noise_scale: 0.0, quantum_mm: 0.0, flying_pixels: false, holes: false };
}

/// What a ray of the depth camera meets.
#[derive(Debug, Clone, Copy)]
pub(super) struct Echo {
    /// Depth along z, millimetres.
    pub(super) z_mm: f64,
    /// Cosine of the angle between ray and surface normal, 0..1.
    pub(super) cosine: f64,
    /// Number of the surface.
    pub(super) surface: u16,
}

/// Standard deviation of axial noise, millimetres.
fn axial_sigma_mm(z_mm: f64, cosine: f64) -> f64 {
    let z = z_mm / 1000.0;
    let theta = libm::acos(cosine.clamp(0.0, 1.0)).min(STEEPEST_RAD);
    let steepness = theta / (std::f64::consts::FRAC_PI_2 - theta);
    1.5 - 0.5 * z + 0.3 * z * z + 0.1 * z * z.sqrt() * steepness * steepness
}

/// Depth that the sensor reports for pixel (u, v), millimetres, 0 = none.
///
/// `straight` holds what the ray through each pixel's centre meets, `cast(dx, dy)` is what a ray meets that passes
/// `dx`, `dy` pixels beside this one's; `focal_px` turns lateral noise into pixels.
pub(super) fn measure(
    straight: &Image<Option<Echo>>,
    (u, v): (i64, i64),
    cast: impl Fn(f64, f64) -> Option<Echo>,
    focal_px: f64,
    options: &SensorOptions,
    noise: &mut Noise,
) -> f32 {
    let own = straight.get(u, v).flatten();
    // Where the ray itself meets nothing, a surface at 1 m stands for what its neighbours may see.
    let lateral_px = options.noise_scale * LATERAL_SIGMA_MM * focal_px / own.map_or(1000.0, |echo| echo.z_mm);
    let (shift_x, shift_y) = (noise.normal() * lateral_px, noise.normal() * lateral_px);
    let axial = noise.normal() * options.noise_scale;
    let (luck, mixed_luck) = (noise.uniform(), noise.uniform());
    let seen = if is_even(straight, u + shift_x.round() as i64, v + shift_y.round() as i64, own) {
        own.map(|echo| (echo, false))
    } else {
        integrate(own, |dx, dy| cast(shift_x + dx, shift_y + dy), options.flying_pixels)
    };
    let Some((echo, mixed)) = seen else { return 0.0 };
    let (from, to) = GRAZING_COSINES;
    let grazing_loss = ((from - echo.cosine) / (from - to)).clamp(0.0, 1.0);
    if options.holes && (luck < RANDOM_LOSS.max(grazing_loss) || (mixed && mixed_luck < MIXED_LOSS)) {
        return 0.0;
    }
    let z_mm = echo.z_mm + axial * axial_sigma_mm(echo.z_mm, echo.cosine);
    let quantum_mm = options.quantum_mm;
    (if quantum_mm > 0.0 { (z_mm / quantum_mm).round() * quantum_mm } else { z_mm }).max(0.0) as f32
}

/// Whether a pixel and its eight neighbours all see the same surface as `own`.
fn is_even(straight: &Image<Option<Echo>>, u: i64, v: i64, own: Option<Echo>) -> bool {
    let surface = |echo: Option<Echo>| echo.map(|echo| echo.surface);
    (-1..=1).all(|dv| {
        (-1..=1).all(|du| straight.get(u + du, v + dv).is_some_and(|echo| surface(echo) == surface(own)))
    })
}

/// What a pixel sees within its area, and whether that is a mixture of two surfaces. `own` is what its centre sees
/// without lateral noise, `cast` includes it.
fn integrate(
    own: Option<Echo>,
    cast: impl Fn(f64, f64) -> Option<Echo>,
    flying_pixels: bool,
) -> Option<(Echo, bool)> {
    let offset = |k: usize| (k as f64 + 0.5) / SAMPLES as f64 - 0.5;
    let samples: [Option<Echo>; SAMPLES * SAMPLES] =
        std::array::from_fn(|k| cast(offset(k % SAMPLES), offset(k / SAMPLES)));
    let echoes = || samples.iter().flatten();
    // Light that never returns only weakens the pixel; more than half of it missing, the pixel is lost.
    let count = echoes().count();
    if 2 * count < samples.len() {
        return None;
    }
    let nearest = echoes().reduce(|a, b| if b.z_mm < a.z_mm { b } else { a })?;
    let is_front = |echo: &Echo| echo.z_mm < nearest.z_mm + MIXED_STEP_MM;
    let front = echoes().filter(|echo| is_front(echo)).count();
    if flying_pixels && front < count {
        return Some((Echo { z_mm: mean_by_light(echoes()), ..*nearest }, true));
    }
    // Of two surfaces the larger; lateral noise does not move the measurement on the one that the ray itself meets.
    let larger = 2 * front >= count;
    let seen = || echoes().filter(|echo| is_front(echo) == larger);
    let own = own.filter(|own| seen().any(|echo| echo.surface == own.surface));
    own.or_else(|| seen().next().copied()).map(|echo| (echo, false))
}

/// Mean depth, each sample weighted by the light that returns from it.
fn mean_by_light<'a>(echoes: impl Iterator<Item = &'a Echo>) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    for echo in echoes {
        let weight = 1.0 / (echo.z_mm * echo.z_mm);
        sum += weight * echo.z_mm;
        weights += weight;
    }
    sum / weights
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(z_mm: f64, cosine: f64, surface: u16) -> Echo {
        Echo { z_mm, cosine, surface }
    }

    /// The middle pixel of a 5x5 sensor before a scene given as what each place sees, in pixels from the middle.
    fn measured(scene: impl Fn(f64, f64) -> Option<Echo>, options: &SensorOptions, noise: &mut Noise) -> f32 {
        let pixels = (0..25).map(|k| scene(f64::from(k % 5 - 2), f64::from(k / 5 - 2))).collect();
        let straight = Image { width: 5, height: 5, pixels };
        measure(&straight, (2, 2), scene, 366.0, options, noise)
    }

    #[test]
    fn axial_noise_has_the_published_size() {
        assert!((axial_sigma_mm(700.0, 1.0) - 1.297).abs() < 1e-9);
        assert!((axial_sigma_mm(700.0, 45_f64.to_radians().cos()) - 1.3556).abs() < 1e-3);
        assert!((axial_sigma_mm(700.0, 75_f64.to_radians().cos()) - 2.761).abs() < 1e-2);
        let mut noise = Noise::new(6);
        let options = SensorOptions { quantum_mm: 0.0, ..SensorOptions::default() };
        let draws: Vec<f64> = (0..20_000)
            .map(|_| f64::from(measured(|_, _| Some(wall(700.0, 1.0, 1)), &options, &mut noise)))
            .filter(|&z_mm| z_mm > 0.0)
            .collect();
        assert!((19_850..20_000).contains(&draws.len()), "{} of 20000 kept", draws.len());
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        let variance = draws.iter().map(|z| (z - mean) * (z - mean)).sum::<f64>() / draws.len() as f64;
        assert!((mean - 700.0).abs() < 0.04 && (variance.sqrt() - 1.297).abs() < 0.03, "{mean} {variance}");
    }

    #[test]
    fn an_edge_reports_something_in_between_only_when_flying() {
        let edge = |dx: f64, _: f64| Some(if dx < 0.1 { wall(700.0, 1.0, 1) } else { wall(900.0, 1.0, 2) });
        let flying = SensorOptions { flying_pixels: true, ..SensorOptions::PERFECT };
        let mut noise = Noise::new(1);
        let mixed = measured(edge, &flying, &mut noise);
        assert!((730.0..800.0).contains(&mixed), "{mixed}");
        assert_eq!(measured(edge, &SensorOptions::PERFECT, &mut noise), 700.0);
    }

    #[test]
    fn lateral_noise_moves_edges_and_not_slopes() {
        let options = SensorOptions { noise_scale: 1.0, ..SensorOptions::PERFECT };
        let mut noise = Noise::new(1);
        // An edge two pixels away reaches the pixel when lateral noise (0.84 px) exceeds about 2.4 sigma.
        let edge = |dx: f64, _: f64| Some(if dx < 2.0 { wall(700.0, 1.0, 1) } else { wall(900.0, 1.0, 2) });
        let moved = (0..4000).filter(|_| measured(edge, &options, &mut noise) > 800.0).count();
        assert!((10..80).contains(&moved), "{moved}");
        // A slope of 45 degrees: 1.9 mm a pixel. Noise stays the axial 1.36 mm.
        let slope = |dx: f64, _: f64| Some(wall(700.0 + 1.9 * dx, 45_f64.to_radians().cos(), 1));
        let square = |_| {
            let error = f64::from(measured(slope, &options, &mut noise)) - 700.0;
            error * error
        };
        let sigma = ((0..4000).map(square).sum::<f64>() / 4000.0).sqrt();
        assert!((sigma - 1.356).abs() < 0.07, "{sigma}");
    }

    #[test]
    fn grazing_surfaces_and_sky_return_nothing() {
        let holes = SensorOptions { holes: true, ..SensorOptions::PERFECT };
        let mut noise = Noise::new(1);
        for _ in 0..100 {
            assert_eq!(measured(|_, _| Some(wall(700.0, 0.05, 1)), &holes, &mut noise), 0.0);
            assert_eq!(measured(|_, _| None, &SensorOptions::default(), &mut noise), 0.0);
        }
    }

    #[test]
    fn depth_comes_in_whole_quanta() {
        let options = SensorOptions { quantum_mm: 0.5, ..SensorOptions::default() };
        let mut noise = Noise::new(1);
        for _ in 0..100 {
            let z_mm = measured(|_, _| Some(wall(700.3, 0.9, 1)), &options, &mut noise);
            assert_eq!(z_mm * 2.0, (z_mm * 2.0).round());
        }
    }
}
