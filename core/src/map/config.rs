//! What the default search may be told.

use crate::{
    accept::Gate,
    config::{ConfigError, POSITIVE, require},
    covariance::Inflation,
    prior::SizePrior,
    residual::{Noise, Viewpoint},
};

/// What the default search may be told. Start from [`MapConfig::of`] a kind of fruit.
///
/// All lengths inside the search are in units of the prior's semi-axes, so one set of numbers serves cherries and melons.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MapConfig {
    /// Size of the fruit and its spread.
    pub prior: SizePrior,
    /// Standard deviation of the boxiness `k`: a body fuller between its axes than an ellipsoid has its surface at
    /// `1 + k phi` (`phi` up to 2/3). 0: exact ellipsoids; a super-ellipsoid of exponent 2.5 has `k` = 0.15. 0 to 1.
    pub boxiness: f32,
    /// Noise of the camera.
    pub noise: Noise,
    /// How much a point tells beside one with noise of its own, above 0 to 1. Depth that was filtered or enlarged repeats itself
    /// from point to point, and errors that neighbours share do not average out.
    pub independence: f32,
    /// From where the points were seen.
    pub viewpoint: Viewpoint,
    /// Standard deviation of the displacement common to all outline rays, rad.
    pub outline_offset_rad: f32,
    /// Hypotheses per target. 1 to 1000.
    pub hypotheses: u16,
    /// Gauss-Newton steps of a hypothesis. 0 to 50.
    pub hypothesis_steps: u8,
    /// Hypotheses kept for refinement. 1 to 8.
    pub kept: u8,
    /// Gauss-Newton steps of each of them. 1 to 50.
    pub refine_steps: u8,
    /// Gauss-Newton steps of the best. 1 to 50.
    pub final_steps: u8,
    /// Inflation of the covariance.
    pub inflation: Inflation,
    /// Limits of acceptance.
    pub gate: Gate,
}

/// Focal length of a Kinect v2's depth camera, pixels: the camera of the presets.
const KINECT_V2_PX: f32 = 365.456;
/// Deviation of where a depth pixel looks, pixels.
const LATERAL_PX: f32 = 0.365;
/// Deviation of the displacement common to all outline rays, pixels.
const OFFSET_PX: f32 = 0.3;

impl MapConfig {
    /// Fruit of this size before a Kinect v2, accepted with care.
    pub const fn of(prior: SizePrior) -> Self {
        Self {
            prior,
            boxiness: 0.08,
            noise: Noise { axial_mm: 1.0, lateral_rad: LATERAL_PX / KINECT_V2_PX },
            independence: 1.0,
            viewpoint: Viewpoint::Origin,
            outline_offset_rad: OFFSET_PX / KINECT_V2_PX,
            hypotheses: 24,
            hypothesis_steps: 3,
            kept: 4,
            refine_steps: 8,
            final_steps: 5,
            inflation: Inflation { base: 0.65, per_conflict: 0.33, per_clutter: 5.0 },
            gate: Gate::BALANCED.scaled(prior.semi_axes_mm[2]),
        }
    }

    /// The same for a camera whose depth pixels are `pitch_rad` apart: what is a fraction of a pixel is scaled.
    pub fn with_pitch(self, pitch_rad: f32) -> Self {
        Self {
            noise: Noise { lateral_rad: LATERAL_PX * pitch_rad, ..self.noise },
            outline_offset_rad: OFFSET_PX * pitch_rad,
            ..self
        }
    }

    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        const STEPS: &str = "1 to 50";
        let length = |value: f32| (1e-6..=1e6).contains(&value);
        let positive = |value: f32| value > 0.0 && value < f32::INFINITY;
        let [a, b, c] = self.prior.semi_axes_mm;
        for value in [a, b, c] {
            require(length(value), "map.prior.semi_axes_mm", value, "1e-6 to 1e6")?;
        }
        require(a >= b && b >= c, "map.prior.semi_axes_mm", b, "longest first")?;
        for value in self.prior.spread {
            require((0.001..=10.0).contains(&value), "map.prior.spread", value, "0.001 to 10")?;
        }
        for (field, value) in
            [("map.prior.spread_ab", self.prior.spread_ab), ("map.prior.spread_bc", self.prior.spread_bc)]
        {
            require(value >= 0.001, field, value, "0.001 or more; infinity for no such term")?;
        }
        let boxiness = self.boxiness;
        let known = boxiness == 0.0 || (1e-6..=1.0).contains(&boxiness);
        require(known, "map.boxiness", boxiness, "0, or 1e-6 to 1")?;
        require(positive(self.noise.axial_mm), "map.noise.axial_mm", self.noise.axial_mm, POSITIVE)?;
        require(positive(self.noise.lateral_rad), "map.noise.lateral_rad", self.noise.lateral_rad, POSITIVE)?;
        let told = self.independence;
        require(told > 0.0 && told <= 1.0, "map.independence", told, "above 0 to 1")?;
        let offset = self.outline_offset_rad;
        require((1e-9..=1.0).contains(&offset), "map.outline_offset_rad", offset, "1e-9 to 1")?;
        let hypotheses = f32::from(self.hypotheses);
        require((1..=1000).contains(&self.hypotheses), "map.hypotheses", hypotheses, "1 to 1000")?;
        let steps = f32::from(self.hypothesis_steps);
        require(self.hypothesis_steps <= 50, "map.hypothesis_steps", steps, "0 to 50")?;
        require((1..=8).contains(&self.kept), "map.kept", f32::from(self.kept), "1 to 8")?;
        for (field, steps) in [("map.refine_steps", self.refine_steps), ("map.final_steps", self.final_steps)]
        {
            require((1..=50).contains(&steps), field, f32::from(steps), STEPS)?;
        }
        let by = &self.inflation;
        require(positive(by.base), "map.inflation.base", by.base, POSITIVE)?;
        for (field, value) in
            [("map.inflation.per_conflict", by.per_conflict), ("map.inflation.per_clutter", by.per_clutter)]
        {
            require((0.0..f32::INFINITY).contains(&value), field, value, "0 or more")?;
        }
        self.gate.check()
    }
}
