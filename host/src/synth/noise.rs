//! Randomness of the synthetic data: a seeded stream of draws, and noise in space for textures.
//!
//! Everything here is integer arithmetic, the basic operations of `f64`, square roots, and `libm` for the rest, so
//! that a seed gives the same bits on every machine.

use libm::{cos, log, sin};
use nalgebra::{Matrix3, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A stream of random draws. Generator: xoshiro256++ (Blackman and Vigna 2019).
#[derive(Debug, Clone)]
pub struct Noise {
    generator: Xoshiro256PlusPlus,
    /// The polar method makes two normal draws at a time.
    spare_normal: Option<f64>,
}

impl Noise {
    /// The stream that belongs to `seed`; every seed is valid.
    pub fn new(seed: u64) -> Self {
        Self { generator: Xoshiro256PlusPlus::seed_from_u64(seed), spare_normal: None }
    }

    /// Another stream of the same seed, 2^128 draws further on: what it draws changes nothing in this one.
    #[must_use]
    pub fn apart(&self) -> Self {
        let mut generator = self.generator.clone();
        generator.jump();
        Self { generator, spare_normal: None }
    }

    /// 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.generator.next_u64()
    }

    /// Uniform draw from [0, 1), a multiple of 2^-53.
    #[inline]
    pub fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// Uniform draw between two values.
    #[inline]
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Draw from `0..bound`; 0 when there is nothing to draw from. Bounds are small here: of 53 bits the bias is none
    /// that could be seen.
    #[inline]
    pub fn below(&mut self, bound: usize) -> usize {
        (self.uniform() * bound as f64) as usize
    }

    /// Draw from the normal distribution of mean 0 and standard deviation 1 (Marsaglia's polar method, 1964).
    pub fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare_normal.take() {
            return spare;
        }
        loop {
            let (x, y) = (self.between(-1.0, 1.0), self.between(-1.0, 1.0));
            let square = x * x + y * y;
            // Leaves the loop after 1.27 rounds on average.
            if square > 0.0 && square < 1.0 {
                let scale = (-2.0 * log(square) / square).sqrt();
                self.spare_normal = Some(y * scale);
                return x * scale;
            }
        }
    }

    /// Three independent normal draws.
    pub fn normal_vector(&mut self) -> Vector3<f64> {
        let (x, y, z) = (self.normal(), self.normal(), self.normal());
        Vector3::new(x, y, z)
    }

    /// Direction, uniform over the sphere.
    pub fn direction(&mut self) -> Vector3<f64> {
        let z = self.between(-1.0, 1.0);
        let angle = self.between(0.0, std::f64::consts::TAU);
        let radius = (1.0 - z * z).sqrt();
        Vector3::new(radius * cos(angle), radius * sin(angle), z)
    }

    /// Orthonormal right-handed axes as rows; the first is `first` (a unit vector), the turn about it uniform.
    pub fn axes_about(&mut self, first: Vector3<f64>) -> Matrix3<f64> {
        let mut second = first.cross(&self.direction());
        while second.norm_squared() < 1e-3 {
            second = first.cross(&self.direction());
        }
        second.normalize_mut();
        let third = first.cross(&second);
        Matrix3::from_rows(&[first.transpose(), second.transpose(), third.transpose()])
    }
}

/// Smooth noise in space, between 0 and 1, one random value at each integer lattice point (value noise, smoothstep
/// between the lattice points). `field` names one of 2^32 independent fields.
pub fn value_noise(place: Vector3<f32>, field: u32) -> f32 {
    // Floor by saturating casts: far away the field is constant, not undefined.
    let cell = place.map(|x| (x as i32).saturating_sub(i32::from(x < (x as i32) as f32)));
    let offset = place.zip_map(&cell, |x, cell| {
        let t = (x - cell as f32).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    });
    let (x, y, z) = (cell.x, cell.y, cell.z);
    let mut sum = 0.0;
    for corner in 0..8_i32 {
        let (i, j, k) = (corner & 1, (corner >> 1) & 1, corner >> 2);
        let weight = |bit: i32, t: f32| if bit == 1 { t } else { 1.0 - t };
        let lattice = lattice_value(x.wrapping_add(i), y.wrapping_add(j), z.wrapping_add(k), field);
        sum += weight(i, offset.x) * weight(j, offset.y) * weight(k, offset.z) * lattice;
    }
    sum
}

/// Three octaves of [`value_noise`], each twice as fine and half as strong; between 0 and 1.
pub fn cloudy_noise(place: Vector3<f32>, field: u32) -> f32 {
    let coarse = value_noise(place, field);
    let middle = value_noise(place * 2.0, field ^ 0x5851_f42d);
    let fine = value_noise(place * 4.0, field ^ 0x1405_7b7e);
    (4.0 * coarse + 2.0 * middle + fine) / 7.0
}

/// Random value of a lattice point, [0, 1): a multiply-xorshift hash of its coordinates.
fn lattice_value(x: i32, y: i32, z: i32, field: u32) -> f32 {
    let mut hash = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f)
        ^ field.wrapping_mul(0x9e37_79b9);
    hash = (hash ^ (hash >> 15)).wrapping_mul(0x2c1b_3c6d);
    hash = (hash ^ (hash >> 12)).wrapping_mul(0x297a_2d39);
    hash ^= hash >> 15;
    (hash >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_the_draws() {
        let mut noise = Noise::new(3);
        let count = 200_000;
        let normals: Vec<f64> = (0..count).map(|_| noise.normal()).collect();
        let mean = normals.iter().sum::<f64>() / f64::from(count);
        let variance = normals.iter().map(|x| x * x).sum::<f64>() / f64::from(count);
        let beyond = normals.iter().filter(|x| x.abs() > 1.96).count() as f64 / f64::from(count);
        // Four standard errors.
        assert!(mean.abs() < 0.009 && (variance - 1.0).abs() < 0.013, "{mean} {variance}");
        assert!((beyond - 0.05).abs() < 0.002, "{beyond}");
        let direction =
            (0..count).fold(Vector3::zeros(), |sum, _| sum + noise.direction()) / f64::from(count);
        assert!(direction.norm() < 0.006, "{direction}");
    }

    #[test]
    fn a_seed_is_a_stream_and_streams_apart_differ() {
        let (mut first, mut again) = (Noise::new(5), Noise::new(5));
        let mut apart = first.apart();
        let draws: Vec<u64> = (0..50).map(|_| first.bits()).collect();
        assert_eq!(draws, (0..50).map(|_| again.bits()).collect::<Vec<_>>());
        assert!((0..50).all(|k| apart.bits() != draws[k]));
        // Pinned: synthetic scenes must not change silently.
        assert_eq!(Noise::new(0).bits(), 0x5317_5d61_490b_23df);
    }

    #[test]
    fn axes_are_orthonormal_and_right_handed() {
        let mut noise = Noise::new(8);
        for _ in 0..100 {
            let first = noise.direction();
            let axes = noise.axes_about(first);
            assert!((axes * axes.transpose() - Matrix3::identity()).norm() < 1e-12);
            assert!((axes.determinant() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn noise_in_space_is_continuous_and_fills_its_range() {
        let at = |k: i32| Vector3::new(k as f32 * 0.01, 1.3, -k as f32 * 0.02);
        let values: Vec<f32> = (0..5000).map(|k| value_noise(at(k), 9)).collect();
        assert!(values.iter().all(|value| (0.0..=1.0).contains(value)));
        assert!(values.windows(2).all(|pair| (pair[0] - pair[1]).abs() < 0.06));
        assert!(values.iter().any(|&value| value < 0.15) && values.iter().any(|&value| value > 0.85));
    }
}
