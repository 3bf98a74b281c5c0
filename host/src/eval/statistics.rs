//! Quantiles and root mean squares of errors.
//!
//! Quantiles interpolate linearly between order statistics: of n sorted values `x_0..x_{n-1}` the quantile q is found
//! at position `q (n - 1)` (type 7 of Hyndman and Fan, Sample Quantiles in Statistical Packages, 1996).

/// Root mean square, summed in order; nothing of nothing.
pub fn root_mean_square(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (mut sum, mut count) = (0.0, 0_usize);
    for value in values {
        sum += value * value;
        count += 1;
    }
    (count > 0).then(|| (sum / count as f64).sqrt())
}

/// Quantile `q` (clamped to `[0, 1]`) of ascending values; nothing of nothing.
pub fn quantile(ascending: &[f64], q: f64) -> Option<f64> {
    let position = q.clamp(0.0, 1.0) * ascending.len().checked_sub(1)? as f64;
    let below = position.floor();
    let low = *ascending.get(below as usize)?;
    let high = ascending.get(below as usize + 1).copied().unwrap_or(low);
    let share = position - below;
    // Without the test a neighbour that is infinite would turn the exact position into NaN.
    Some(if share > 0.0 { low + share * (high - low) } else { low })
}

/// Mean and standard deviation (of the population), summed in order; nothing of nothing.
pub fn mean_and_deviation(values: &[f64]) -> Option<(f64, f64)> {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let deviation = root_mean_square(values.iter().map(|value| value - mean))?;
    Some((mean, deviation))
}

/// The quantile of the standard normal distribution, for 0 < p < 1: where the distribution function reaches `p`, by
/// bisection of [-40, 40] down to the last bit.
pub fn normal_quantile(p: f64) -> f64 {
    let (mut low, mut high) = (-40.0, 40.0);
    for _ in 0..64 {
        let middle = f64::midpoint(low, high);
        let reached = libm::erfc(-middle / std::f64::consts::SQRT_2) / 2.0;
        if reached < p { low = middle } else { high = middle }
    }
    f64::midpoint(low, high)
}

/// How a set of errors is distributed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Distribution {
    /// Number of values.
    pub count: usize,
    /// Quantile 0.5.
    pub median: f64,
    /// Quantile 0.9.
    pub p90: f64,
    /// Quantile 0.99.
    pub p99: f64,
    /// Largest value.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
}

impl Distribution {
    /// Of values in any order; nothing of nothing. NaN ranks above infinity, so that it shows and does not hide.
    pub fn of(values: &[f64]) -> Option<Self> {
        let rms = root_mean_square(values.iter().copied())?;
        let mut ascending = values.to_vec();
        ascending.sort_by(f64::total_cmp);
        Some(Self {
            count: ascending.len(),
            median: quantile(&ascending, 0.5)?,
            p90: quantile(&ascending, 0.9)?,
            p99: quantile(&ascending, 0.99)?,
            max: *ascending.last()?,
            rms,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_by_hand() {
        let values = [1.0, 2.0, 4.0, 8.0];
        assert_eq!(quantile(&values, 0.0), Some(1.0));
        assert_eq!(quantile(&values, 0.5), Some(3.0)); // position 1.5
        assert!((quantile(&values, 0.9).unwrap() - 6.8).abs() < 1e-12); // position 2.7
        assert_eq!(quantile(&values, 1.0), Some(8.0));
        assert_eq!(quantile(&values, 7.0), Some(8.0));
        assert_eq!(quantile(&[5.0], 0.9), Some(5.0));
        assert_eq!(quantile(&[], 0.5), None);
        assert_eq!(quantile(&[1.0, f64::INFINITY], 0.0), Some(1.0));
    }

    #[test]
    fn normal_quantiles_are_those_of_the_tables() {
        for (p, expected) in [(0.5, 0.0), (0.975, 1.959_963_984_540_054), (0.001, -3.090_232_306_167_813)] {
            assert!((normal_quantile(p) - expected).abs() < 1e-12, "{p}");
        }
        assert!((normal_quantile(1e-300) + 37.047_1).abs() < 1e-3);
    }

    #[test]
    fn mean_and_deviation_by_hand() {
        assert_eq!(mean_and_deviation(&[1.0, 3.0, 5.0, 7.0]), Some((4.0, 5.0_f64.sqrt())));
        assert_eq!(mean_and_deviation(&[]), None);
    }

    #[test]
    fn a_distribution_by_hand() {
        let d = Distribution::of(&[7.0, 1.0]).unwrap();
        assert_eq!((d.count, d.median, d.max, d.rms), (2, 4.0, 7.0, 5.0));
        assert!((d.p90 - 6.4).abs() < 1e-12 && (d.p99 - 6.94).abs() < 1e-12);
        assert_eq!(Distribution::of(&[]), None);
        assert!(Distribution::of(&[f64::NAN, 1.0]).unwrap().max.is_nan());
    }
}
