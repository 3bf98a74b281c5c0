//! How many trials a search needs, Eq. (14)-(18).

/// The largest inlier ratio used in the formula: at 1 its logarithm has no value, and a sample can always fail.
pub const MAX_RATIO: f32 = 0.9999;

/// Trials after which a search over the given sample sizes has drawn one good sample with probability `confidence`,
/// Eq. (17): `k = m ln(1 - p) / sum_j ln(1 - w^n_j)`, rounded up, within `1..=max`.
///
/// One inlier ratio `ratio` stands for all sizes (the paper sets `w_j = s_max`). It is clamped to 0..=[`MAX_RATIO`];
/// NaN, zero or an empty list of sizes give `max`. `w^n` is a running product, so the result needs `log1pf` only.
///
/// ```
/// use varsac_core::trials::trials;
/// // The paper's worked example, Fig. 5: three points, a line through two of them or near all three.
/// assert_eq!(trials(0.98, &[2], 2.0 / 3.0, 3000), 7);
/// assert_eq!(trials(0.98, &[3], 1.0, 3000), 1);
/// ```
pub fn trials(confidence: f32, sizes: &[u8], ratio: f32, max: u32) -> u32 {
    let w = if ratio > MAX_RATIO { MAX_RATIO } else { ratio };
    let mut sum = 0.0;
    for &size in sizes {
        let mut power = 1.0;
        for _ in 0..size {
            power *= w;
        }
        sum += libm::log1pf(-power);
    }
    let k = sizes.len() as f32 * libm::log1pf(-confidence) / sum;
    // sum is negative, or zero (k infinite or NaN) when every w^n vanishes.
    if k >= 0.0 && k < max as f32 { (libm::ceilf(k) as u32).clamp(1, max.max(1)) } else { max }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_integers() {
        // ln(0.05) / ln(1 - 0.5^9) = 1532.3; and for 0.8: 20.77.
        assert_eq!(trials(0.95, &[9], 0.5, 3000), 1533);
        assert_eq!(trials(0.95, &[9], 0.8, 3000), 21);
        // Four sizes at 0.774, the score of Table 6: 4 * 2.9957 / (.1047+.0801+.0615+.0473 by logs) = 40.4.
        assert_eq!(trials(0.95, &[9, 10, 11, 12], 0.774, 3000), 41);
        assert_eq!(trials(0.95, &[9, 10, 11, 12], 0.2, 3000), 3000);
    }

    #[test]
    fn one_size_is_plain_ransac_and_more_inliers_never_need_more_trials() {
        let mut last = u32::MAX;
        for percent in 0..=100 {
            let k = trials(0.95, &[9, 10, 11, 12], percent as f32 / 100.0, 100_000);
            assert!(k <= last, "{percent} %");
            last = k;
        }
        assert_eq!(last, 1);
    }

    #[test]
    fn the_edges() {
        assert_eq!(trials(0.95, &[9], 0.0, 3000), 3000);
        assert_eq!(trials(0.95, &[9], f32::NAN, 3000), 3000);
        assert_eq!(trials(0.95, &[9], -1.0, 3000), 3000);
        assert_eq!(trials(0.95, &[], 0.5, 3000), 3000);
        assert_eq!(trials(0.95, &[9], 2.0, 3000), 1);
        assert_eq!(trials(1e-9, &[9], 1.0, 3000), 1);
    }
}
