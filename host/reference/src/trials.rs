//! The bound on the number of trials: contract, chapter 8; Eq. (17).

use crate::fault::{self, Fault};

/// Chapter 8: how many trials give a good sample with probability `p` when a share `ratio` of the points is good
/// and the samples have `sizes` in turn; `max` at most.
pub fn trials(p: f32, sizes: &[u8], ratio: f32, max: u32) -> u32 {
    let w = if ratio > 0.9999 { 0.9999 } else { ratio };
    let mut sum = 0.0_f32;
    for &size in sizes {
        let mut power = 1.0_f32;
        for _ in 0..size {
            power *= w;
        }
        let logarithm = if fault::is(Fault::Bound) { libm::logf(1.0 - power) } else { libm::log1pf(-power) };
        sum += logarithm;
    }
    let k = (sizes.len() as f32 * libm::log1pf(-p)) / sum;
    if k >= 0.0 && k < max as f32 {
        let mut bound = libm::ceilf(k) as u32;
        if bound < 1 {
            bound = 1;
        }
        if bound > max {
            bound = max;
        }
        bound
    } else {
        max
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_worked_example_takes_seven_trials() {
        // ln(1 - 0.98) / ln(1 - (2/3)^2) = -3.912 / -0.588 = 6.66.
        assert_eq!(trials(0.98, &[2], 2.0 / 3.0, 3000), 7);
    }

    #[test]
    fn nothing_good_means_all_trials_and_everything_good_means_one() {
        assert_eq!(trials(0.95, &[9, 10, 11, 12], 0.0, 3000), 3000);
        assert_eq!(trials(0.95, &[9, 10, 11, 12], 1.0, 3000), 1);
    }

    #[test]
    fn equal_sizes_count_like_one() {
        // ln(0.05) / ln(1 - 0.5^3) = -2.996 / -0.1335 = 22.4, with one size or with four of them.
        assert_eq!(trials(0.95, &[3], 0.5, 3000), 23);
        assert_eq!(trials(0.95, &[3, 3, 3, 3], 0.5, 3000), 23);
        assert_eq!(trials(0.95, &[3], 0.5, 20), 20);
    }
}
