//! The seeded random stream and the two draws made from it.
//!
//! Generator: xoshiro128++ (Blackman and Vigna 2019), its 128 bits of state filled from the `u64` seed by SplitMix64,
//! as `rand_xoshiro` does. 32-bit words suit the device: one draw is a few adds, shifts and xors.
//! Draws are unbiased: multiply-shift with rejection (Lemire 2019), never a remainder of the generator's word.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro128PlusPlus;

/// Redraws allowed per bounded draw. The chance of needing one is below `bound / 2^32 < 2^-16`, so of needing nine
/// in a row below 2^-144: the limit exists to make the loop bounded, not to be reached.
const MAX_REDRAWS: u32 = 8;

/// The random stream of one search.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stream {
    generator: Xoshiro128PlusPlus,
}

impl Stream {
    /// The stream that belongs to `seed`; every seed is valid, 0 and `u64::MAX` too.
    pub fn new(seed: u64) -> Self {
        Self { generator: Xoshiro128PlusPlus::seed_from_u64(seed) }
    }

    /// Uniform draw from `0..bound`. A bound of 0 or 1 yields 0 and takes nothing from the stream.
    #[inline]
    pub fn below(&mut self, bound: u32) -> u32 {
        below(&mut self.generator, bound)
    }

    /// Draws `sample.len()` different members of `0..population` into `sample`, in draw order (Floyd's method:
    /// one draw a member, no shuffle of the population). Every subset is equally likely.
    ///
    /// Returns false, drawing nothing, when the population is too small.
    pub fn sample(&mut self, population: u32, sample: &mut [u16]) -> bool {
        let size = sample.len() as u32;
        if size > population || population > 65_536 {
            return false;
        }
        for k in 0..sample.len() {
            let last = population - size + k as u32;
            let draw = self.below(last + 1) as u16;
            let (earlier, rest) = sample.split_at_mut(k);
            let taken = earlier.contains(&draw);
            if let Some(slot) = rest.first_mut() {
                *slot = if taken { last as u16 } else { draw };
            }
        }
        true
    }
}

/// Uniform draw from `0..bound` from any generator of 32-bit words.
#[inline]
pub fn below(generator: &mut impl Rng, bound: u32) -> u32 {
    if bound <= 1 {
        return 0;
    }
    let mut product = u64::from(generator.next_u32()) * u64::from(bound);
    if (product as u32) < bound {
        // 2^32 mod bound: that many low words are over-represented. `%` cannot divide by zero here.
        let threshold = bound.wrapping_neg().checked_rem(bound).unwrap_or(0);
        let mut redraws = 0;
        while (product as u32) < threshold && redraws < MAX_REDRAWS {
            product = u64::from(generator.next_u32()) * u64::from(bound);
            redraws += 1;
        }
    }
    (product >> 32) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_vector_of_the_generator() {
        // State 1, 2, 3, 4 of the authors' C program.
        let mut generator = Xoshiro128PlusPlus::from_seed([1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, 4, 0, 0, 0]);
        for expected in [641, 1_573_767, 3_222_811_527, 3_517_856_514, 836_907_274, 4_247_214_768] {
            assert_eq!(generator.next_u32(), expected);
        }
    }

    #[test]
    fn samples_are_distinct_in_range_and_uniform() {
        let mut stream = Stream::new(7);
        let mut hits = [0_u32; 12];
        let rounds = 12_000;
        for _ in 0..rounds {
            let mut sample = [0_u16; 5];
            assert!(stream.sample(12, &mut sample));
            for (k, &member) in sample.iter().enumerate() {
                assert!(member < 12);
                assert!(!sample[..k].contains(&member), "{sample:?}");
                hits[usize::from(member)] += 1;
            }
        }
        // Expected 5000 each, standard deviation 54: five of them.
        for (member, &count) in hits.iter().enumerate() {
            assert!((4730..=5270).contains(&count), "member {member}: {count}");
        }
    }

    #[test]
    fn the_edges_of_a_draw() {
        let mut stream = Stream::new(u64::MAX);
        assert_eq!(stream.below(0), 0);
        assert_eq!(stream.below(1), 0);
        let mut nine = [0; 9];
        assert!(!stream.sample(8, &mut nine));
        assert!(stream.sample(9, &mut nine));
        nine.sort_unstable();
        assert_eq!(nine, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
    }
}
