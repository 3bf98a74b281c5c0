//! Seeded randomness of the scenes: xoshiro256++, another generator than the core's, and transforms through `libm`.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Random numbers of one test case.
#[derive(Debug, Clone)]
pub struct Dice {
    generator: Xoshiro256PlusPlus,
}

impl Dice {
    /// The numbers of case `case` of the test called `test`. The seed derives from both, so no test depends on
    /// another and a failure is replayed from its name and its case.
    pub fn new(test: &str, case: u64) -> Self {
        // FNV-1a of the name, then the case through the generator's own SplitMix64 seeding.
        let name = test.bytes().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        Self { generator: Xoshiro256PlusPlus::seed_from_u64(name ^ case.wrapping_mul(0x9e37_79b9_7f4a_7c15)) }
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.generator.next_u64()
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform between two numbers.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform integer in `0..bound` (bound far below 2^53).
    pub fn below(&mut self, bound: usize) -> usize {
        (self.unit() * bound as f64) as usize
    }

    /// Standard normal (Box and Muller 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.unit()));
        radius * libm::cos(core::f64::consts::TAU * self.unit())
    }

    /// Three independent standard normals.
    pub fn normal3(&mut self) -> Vector3<f64> {
        Vector3::new(self.normal(), self.normal(), self.normal())
    }

    /// Uniform unit vector.
    pub fn direction(&mut self) -> Vector3<f64> {
        self.normal3().normalize()
    }

    /// Uniform in the cube of the given half side about the origin.
    pub fn in_cube(&mut self, half: f64) -> Vector3<f64> {
        Vector3::new(self.between(-half, half), self.between(-half, half), self.between(-half, half))
    }

    /// Uniform rotation: a normal quaternion, normalised.
    pub fn rotation(&mut self) -> Matrix3<f64> {
        let q = Quaternion::new(self.normal(), self.normal(), self.normal(), self.normal());
        UnitQuaternion::from_quaternion(q).to_rotation_matrix().into_inner()
    }

    /// `size` different members of `0..population`, in random order (a partial Fisher-Yates shuffle).
    ///
    /// # Panics
    /// When the population is smaller than the sample.
    pub fn sample(&mut self, population: usize, size: usize) -> Vec<u16> {
        assert!(size <= population);
        let mut all: Vec<u16> = (0..population as u16).collect();
        for k in 0..size {
            let other = k + self.below(population - k);
            all.swap(k, other);
        }
        all.truncate(size);
        all
    }
}
