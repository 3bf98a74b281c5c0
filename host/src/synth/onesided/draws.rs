//! Random numbers of the light generator, all from one seed.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::shapes::V3;

/// Seeded draws of the generator.
#[derive(Debug, Clone)]
pub(super) struct Draws(Xoshiro256PlusPlus);

impl Draws {
    /// The draws that belong to a seed.
    pub(super) fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    /// Uniform in `low..high`; 53 random bits.
    pub(super) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.0.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0))
    }

    /// Standard normal (Box and Muller 1958, one of the pair).
    pub(super) fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(1.0 - self.uniform(0.0, 1.0)));
        radius * libm::cos(core::f64::consts::TAU * self.uniform(0.0, 1.0))
    }

    /// True with this probability.
    pub(super) fn chance(&mut self, probability: f64) -> bool {
        self.uniform(0.0, 1.0) < probability
    }

    /// Rows of a rotation drawn uniformly (a random unit quaternion).
    pub(super) fn rotation(&mut self) -> [V3; 3] {
        let mut q = [0.0; 4];
        for part in &mut q {
            *part = self.normal();
        }
        let s = 1.0 / libm::sqrt(q.iter().map(|part| part * part).sum());
        let [w, x, y, z] = q.map(|part| part * s);
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }
}
