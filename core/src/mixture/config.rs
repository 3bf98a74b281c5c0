//! What the search without a size prior may be told.

use crate::{
    config::{ConfigError, require},
    mixture::MAX_STARTS,
    residual::{Noise, Viewpoint},
};

/// Configuration of [`super::MixtureSearch`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MixtureConfig {
    /// From where the points were seen.
    pub viewpoint: Viewpoint,
    /// Noise of the camera, of which only the ratio counts (the size is estimated); of no concern without a viewpoint.
    pub noise: Noise,
    /// Points the starts are tried on. 50 to 2000.
    pub sample: u16,
    /// Starts from a random point, beside the one from all points. 0 to [`MAX_STARTS`] - 1.
    pub starts: u8,
    /// Weight of the logarithm of the surface area for each point. 1/2 cancels the bias of noise across a curved surface.
    pub area_weight: f32,
    /// Standard deviation of the logarithms of the semi-axes about their mean; infinity: any shape is as good.
    pub shape_spread: f32,
    /// Standard deviation of the displacement common to all outline rays, rad.
    pub outline_offset_rad: f32,
    /// Factor on the covariance of the normal equations.
    pub inflation: f32,
    /// Added to it, times the square of the noise over the shortest semi-axis.
    pub inflation_thin: f32,
    /// Added to it for as many points off the surface as on it: some of their neighbours fit by chance.
    pub inflation_outliers: f32,
    /// Limits of acceptance.
    pub gate: MixtureGate,
}

/// Limits of the tests; infinity (or zero, for lower limits) switches a test off.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MixtureGate {
    /// Points on the surface at least.
    pub min_points: f32,
    /// Gain over uniform clutter for each point at least, natural logarithm.
    pub gain: f32,
    /// Covered part of the surface at least.
    pub coverage: f32,
    /// Rms distance from the best plane over that from the surface at least.
    pub flat: f32,
    /// Rms of the residuals that depends on where on the surface they are, over the shortest semi-axis, at most.
    pub misfit: f32,
    /// Largest standard deviation of the centre over the shortest semi-axis, at most.
    pub uncertain: f32,
}

impl MixtureConfig {
    /// Complete surfaces: scanner clouds, measured from all around.
    pub const SURFACE: Self = Self {
        viewpoint: Viewpoint::None,
        noise: Noise { axial_mm: 1.0, lateral_rad: 0.001 },
        sample: 400,
        starts: 10,
        area_weight: 0.5,
        shape_spread: f32::INFINITY,
        outline_offset_rad: 0.15 / 365.456,
        inflation: 1.1,
        inflation_thin: 2.0,
        inflation_outliers: 0.0,
        gate: MixtureGate {
            min_points: 20.0,
            gain: 0.1,
            coverage: 0.7,
            flat: 1.75,
            misfit: 0.025,
            uncertain: 0.3,
        },
    };

    /// One view from the origin, unknown fruit.
    pub const VIEW: Self = Self {
        viewpoint: Viewpoint::Origin,
        // The half that is seen does not curve the other way: what the correction would do to the sizes it does to the centre.
        area_weight: 0.0,
        shape_spread: 1.0,
        inflation: 1.0,
        inflation_outliers: 4.0,
        gate: MixtureGate { coverage: 0.0, uncertain: 0.4, ..Self::SURFACE.gate },
        ..Self::SURFACE
    };
}

impl MixtureConfig {
    /// Checks every field.
    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let positive = |value: f32| value > 0.0 && value < f32::INFINITY;
        for (field, value) in [
            ("mixture.noise.axial_mm", self.noise.axial_mm),
            ("mixture.noise.lateral_rad", self.noise.lateral_rad),
            ("mixture.inflation", self.inflation),
        ] {
            require(positive(value), field, value, "a finite number above 0")?;
        }
        let sample = f32::from(self.sample);
        require((50..=2000).contains(&self.sample), "mixture.sample", sample, "50 to 2000")?;
        let starts = f32::from(self.starts);
        require(usize::from(self.starts) < MAX_STARTS, "mixture.starts", starts, "0 to 15")?;
        require((0.0..=1.0).contains(&self.area_weight), "mixture.area_weight", self.area_weight, "0 to 1")?;
        let spread = self.shape_spread;
        require(spread >= 0.01, "mixture.shape_spread", spread, "0.01 or more; infinity for no such term")?;
        let offset = self.outline_offset_rad;
        require((1e-9..=1.0).contains(&offset), "mixture.outline_offset_rad", offset, "1e-9 to 1")?;
        for (field, value) in [
            ("mixture.inflation_thin", self.inflation_thin),
            ("mixture.inflation_outliers", self.inflation_outliers),
        ] {
            require((0.0..f32::INFINITY).contains(&value), field, value, "0 or more")?;
        }
        let gate = &self.gate;
        for (field, value) in [
            ("mixture.gate.min_points", gate.min_points),
            ("mixture.gate.gain", gate.gain),
            ("mixture.gate.coverage", gate.coverage),
            ("mixture.gate.flat", gate.flat),
            ("mixture.gate.misfit", gate.misfit),
            ("mixture.gate.uncertain", gate.uncertain),
        ] {
            require(!value.is_nan(), field, value, "a number; infinity switches an upper limit off")?;
        }
        Ok(())
    }
}
