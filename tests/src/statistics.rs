//! Figures over many cases, and the lines of the tables that the tests print.

/// Values of one quantity over many cases.
#[derive(Debug, Clone, Default)]
pub struct Sample {
    values: Vec<f64>,
}

impl Sample {
    /// One more case.
    pub fn push(&mut self, value: f64) {
        self.values.push(value);
    }

    /// All cases of another one.
    pub fn extend(&mut self, other: &Self) {
        self.values.extend_from_slice(&other.values);
    }

    /// Number of cases.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// True before the first case.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The smallest value that is not exceeded by `share` of the cases (NaN counts as largest). 0 without cases.
    pub fn quantile(&self, share: f64) -> f64 {
        let mut sorted = self.values.clone();
        sorted.sort_by(f64::total_cmp);
        let rank = libm::ceil(share * sorted.len() as f64) as usize;
        sorted.get(rank.saturating_sub(1)).copied().unwrap_or(0.0)
    }

    /// The largest value.
    pub fn max(&self) -> f64 {
        self.quantile(1.0)
    }

    /// Root mean square. 0 without cases.
    pub fn rms(&self) -> f64 {
        libm::sqrt(self.values.iter().map(|v| v * v).sum::<f64>() / self.len().max(1) as f64)
    }

    /// Share of the cases above a limit.
    pub fn share_above(&self, limit: f64) -> f64 {
        self.values.iter().filter(|v| **v > limit || v.is_nan()).count() as f64 / self.len().max(1) as f64
    }

    /// Median, 99th percentile and maximum in one line.
    pub fn summary(&self) -> String {
        format!(
            "median {:9.2e}  p99 {:9.2e}  max {:9.2e}",
            self.quantile(0.5),
            self.quantile(0.99),
            self.max()
        )
    }
}
