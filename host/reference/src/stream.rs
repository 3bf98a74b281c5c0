//! The random stream: contract, chapter 3. xoshiro128++ (Blackman and Vigna, Scrambled linear pseudorandom number
//! generators, 2021), seeded with SplitMix64, and Floyd's draw of distinct members.

use crate::fault::{self, Fault};

/// The one stream of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Stream {
    state: [u32; 4],
}

impl Stream {
    /// The generator in a given state `[s0, s1, s2, s3]`.
    pub fn from_state(state: [u32; 4]) -> Self {
        Self { state }
    }

    /// Chapter 3, seeding.
    pub fn seeded(seed: u64) -> Self {
        let mut x = seed;
        let mut bytes = Vec::new();
        for _ in 0..2 {
            bytes.extend_from_slice(&split_mix_64(&mut x).to_le_bytes());
        }
        let mut state = [0; 4];
        for k in 0..4 {
            state[k] =
                u32::from_le_bytes([bytes[4 * k], bytes[4 * k + 1], bytes[4 * k + 2], bytes[4 * k + 3]]);
        }
        if state == [0; 4] {
            return Self::seeded(0);
        }
        Self { state }
    }

    /// Chapter 3, one draw of the generator.
    pub fn draw(&mut self) -> u32 {
        let [mut s0, mut s1, mut s2, mut s3] = self.state;
        let result = s0.wrapping_add(s3).rotate_left(7).wrapping_add(s0);
        let t = s1 << 9;
        s2 ^= s0;
        s3 ^= s1;
        s1 ^= s2;
        s0 ^= s3;
        s2 ^= t;
        s3 = s3.rotate_left(11);
        self.state = [s0, s1, s2, s3];
        result
    }

    /// Chapter 3, `below(m)`: uniform in `0..m`.
    pub fn below(&mut self, m: u32) -> u32 {
        if m <= 1 {
            return 0;
        }
        let u = self.draw();
        if fault::is(Fault::Draws) {
            return u % m;
        }
        let mut p = u64::from(u) * u64::from(m);
        if (p % (1 << 32)) < u64::from(m) {
            let t = ((1 << 32) - u64::from(m)) % u64::from(m);
            let mut redraws = 0;
            while (p % (1 << 32)) < t && redraws < 8 {
                p = u64::from(self.draw()) * u64::from(m);
                redraws += 1;
            }
        }
        (p >> 32) as u32
    }

    /// Chapter 3, `sample(m, k)`: `k` distinct members of `0..m` in the order drawn, or none if `k > m`.
    pub fn sample(&mut self, m: u32, k: u32) -> Option<Vec<u32>> {
        if k > m {
            return None;
        }
        let mut members = Vec::new();
        for i in 0..k {
            let last = m - k + i;
            let d = self.below(last + 1);
            if members.contains(&d) {
                members.push(last);
            } else {
                members.push(d);
            }
        }
        Some(members)
    }
}

/// One 64-bit output of SplitMix64 (Steele, Lea and Flood, Fast splittable pseudorandom number generators, 2014).
fn split_mix_64(x: &mut u64) -> u64 {
    *x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *x;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_words_come_out() {
        let mut stream = Stream::from_state([1, 2, 3, 4]);
        for expected in [641, 1_573_767, 3_222_811_527, 3_517_856_514, 836_907_274, 4_247_214_768] {
            assert_eq!(stream.draw(), expected);
        }
    }

    #[test]
    fn the_published_first_output_of_split_mix_64_fills_the_state() {
        // Outputs for the seed 1234567: 6457827717110365317, 3203168211198807973.
        let mut x = 1_234_567;
        assert_eq!(split_mix_64(&mut x), 6_457_827_717_110_365_317);
        assert_eq!(split_mix_64(&mut x), 3_203_168_211_198_807_973);
        let first: u64 = 6_457_827_717_110_365_317;
        let second: u64 = 3_203_168_211_198_807_973;
        let words = [first as u32, (first >> 32) as u32, second as u32, (second >> 32) as u32];
        assert_eq!(Stream::seeded(1_234_567), Stream::from_state(words));
    }

    #[test]
    fn below_draws_nothing_when_there_is_no_choice() {
        let mut stream = Stream::seeded(7);
        let before = stream.clone();
        assert_eq!(stream.below(0), 0);
        assert_eq!(stream.below(1), 0);
        assert_eq!(stream.sample(3, 4), None);
        assert_eq!(stream, before);
    }

    #[test]
    fn below_takes_the_high_word_of_the_product() {
        // The first word of this state is 641, and 641 * 2^31 has the high word 320.
        assert_eq!(Stream::from_state([1, 2, 3, 4]).below(1 << 31), 320);
    }

    #[test]
    fn below_redraws_where_the_low_word_is_not_fair() {
        // m = 3 * 2^30: p = 641 m has the low word 2^30, which is below m and not below t = (2^32 - m) mod m = 2^30,
        // so 641 stands; a state whose first word is 4 makes p = 4 m with the low word 0, below t: it is redrawn.
        let m = 3 << 30;
        assert_eq!(Stream::from_state([1, 2, 3, 4]).below(m), 480);
        let mut fair = Stream::from_state([0, 9, 9, 0x0800_0000]);
        assert_eq!(fair.clone().draw(), 4);
        let mut second = fair.clone();
        second.draw();
        let word = u64::from(second.draw());
        assert!((word * u64::from(m)) as u32 >= 1 << 30, "the second word stands");
        assert_eq!(fair.below(m), ((word * u64::from(m)) >> 32) as u32);
        assert_eq!(fair, second);
    }

    #[test]
    fn a_sample_of_everything_is_everything() {
        let mut members = Stream::seeded(5).sample(12, 12).expect("12 of 12");
        members.sort_unstable();
        assert_eq!(members, (0..12).collect::<Vec<_>>());
    }
}
