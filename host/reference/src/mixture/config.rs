//! What the search is told: contract, chapter X2, under the names of the contract.

use crate::map::view::{Noise, Viewpoint};

/// The parameters of the search without a size prior.
#[derive(Clone, Debug, PartialEq)]
pub struct MixtureConfig {
    /// Targets at most (X12).
    pub max_targets: u8,
    /// Failed searches after which a run ends (X12).
    pub max_failures: u32,
    /// From where the points were seen.
    pub viewpoint: Viewpoint,
    /// Of which only the ratio counts.
    pub noise: Noise,
    /// Points of the sample at most (X3).
    pub sample: u16,
    /// Starts beside start 0 (X8).
    pub starts: u8,
    /// Weight of the logarithm of the area (X6).
    pub area_weight: f32,
    /// Deviation of the logarithms of the semi-axes about their mean, or infinity.
    pub shape_spread: f32,
    /// Deviation of the displacement common to all outline rays, rad.
    pub outline_offset: f32,
    /// Factor on the covariance (X10).
    pub inflation: f32,
    /// Added to it for a thin body (X10).
    pub inflation_thin: f32,
    /// Added to it for outliers (X10).
    pub inflation_outliers: f32,
    /// Limits of acceptance (X10).
    pub gate: MixtureGate,
}

/// The limits of X10.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the names are those of X10")]
pub struct MixtureGate {
    pub min_points: f32,
    pub gain: f32,
    pub flat: f32,
    pub coverage: f32,
    pub misfit: f32,
    pub uncertain: f32,
}
