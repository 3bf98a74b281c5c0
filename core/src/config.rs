//! What a search may be told, the presets, and the one place where it is checked.

use heapless::Vec;

use crate::{
    Constraint, accept::Gate, map::MapConfig, mixture::MixtureConfig, prior::SizePrior, residual::Viewpoint,
};

/// Largest sample a hypothesis may be made from.
pub const MAX_SAMPLE: usize = 32;
/// Most sample sizes a configuration may list.
pub const MAX_SIZES: usize = 16;
/// Most targets one cloud can yield: labels are bytes and 0 means unclaimed.
pub const MAX_TARGETS: u8 = 255;
/// Largest bound on trials.
pub const MAX_TRIALS: u32 = 1_000_000;
/// Most least-squares refits of a best hypothesis.
pub const MAX_REFITS: u8 = 10;

/// Everything that steers a search. Lengths are in the unit of the cloud (millimetres in the product).
///
/// Start from a preset and change what you need; [`Detector::new`](crate::Detector::new) checks every field once.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Config {
    /// `p`, probability of having drawn a good sample when the search stops. Inside (0, 1).
    pub confidence: f32,
    /// `n_j`, the sample sizes, tried in turn. 1 to 16 entries of 9 to 32.
    pub sample_sizes: Vec<u8, MAX_SIZES>,
    /// `d` of the shell from `1 - d` to `1 + d`. Inside (0, 1).
    pub shell: f32,
    /// `r_s`, sampling radius around the seed point. Positive; infinity means the whole cloud.
    pub radius: f32,
    /// Semi-axes must be longer than this. Positive.
    pub semi_axis_min: f32,
    /// Semi-axes must be shorter than this. Above the minimum, finite.
    pub semi_axis_max: f32,
    /// `k_max`, trials per target at most. 1 to 1 000 000.
    pub max_trials: u32,
    /// Least-squares refits of the best hypothesis on its inliers. The paper does 1; 0 to 10.
    pub refits: u8,
    /// A hypothesis with fewer inliers in its neighbourhood does not count, nor does a target. The paper has no such
    /// limit; without it nine stray points that fit themselves are a perfect score. 1 to 65535.
    pub min_inliers: u16,
    /// A hypothesis that explains less of its neighbourhood than this does not count. The paper has no such limit
    /// (0). Inside [0, 1].
    pub min_ratio: f32,
    /// Targets per cloud at most. 1 to 255; the default search finds at most [`MAX_FRUIT`](crate::MAX_FRUIT).
    pub max_targets: u8,
    /// Searches without a valid hypothesis after which the cloud is given up. 1 to 255.
    pub max_failures: u8,
    /// How the least squares fix the scale of the quadric.
    pub constraint: Constraint,
    /// Which search.
    pub method: Method,
    /// What the default search needs; the fields above other than `max_targets` and `max_failures` steer the paper's.
    pub map: MapConfig,
    /// What the search without a size prior needs, with `max_targets` and `max_failures`.
    pub mixture: MixtureConfig,
}

/// The searches: one loop, one configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Method {
    /// The most probable fruit of known size behind one-sided points.
    Map,
    /// Algorithm 1 of the paper with TEBC.
    #[default]
    Varsac,
    /// The most probable ellipsoid of any size, on complete surfaces or in one view.
    Mixture,
}

/// The field, its value and what is allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConfigError {
    /// Name of the field of [`Config`].
    pub field: &'static str,
    /// Its value (for a list, the first bad entry; for an empty or overlong list, its length).
    pub value: f64,
    /// The allowed range, in words.
    pub allowed: &'static str,
}

impl core::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{} is {}; it must be {}", self.field, self.value, self.allowed)
    }
}

impl core::error::Error for ConfigError {}

impl Config {
    /// Table 2, the paper's simulation: semi-axes 0.5 to 4, `r_s` = 1. With this radius a neighbourhood cannot span the
    /// body and the search often fails, which is the finding; see [`Self::table2_wide`].
    pub fn table2() -> Self {
        Self { radius: 1.0, semi_axis_min: 0.5, semi_axis_max: 4.0, ..Self::table5() }
    }

    /// Table 2 with `r_s` = 6.5, which spans the simulated body from any of its points, and five refits: the table
    /// names no number, and on whole surfaces one refit stops well short of where five settle.
    pub fn table2_wide() -> Self {
        Self { radius: 6.5, refits: 5, ..Self::table2() }
    }

    /// Table 5, jujubes in millimetres as printed: semi-axes 10 to 23, `r_s` = 30.
    pub fn table5() -> Self {
        let mut sample_sizes = Vec::new();
        for size in 9..=12 {
            // Four of sixteen.
            let _ = sample_sizes.push(size);
        }
        Self {
            confidence: 0.95,
            sample_sizes,
            shell: 0.1,
            radius: 30.0,
            semi_axis_min: 10.0,
            semi_axis_max: 23.0,
            max_trials: 3000,
            refits: 1,
            min_inliers: 20,
            min_ratio: 0.0,
            max_targets: 16,
            max_failures: 1,
            constraint: Constraint::A11,
            method: Method::Varsac,
            map: MapConfig::of(SizePrior::JUJUBE),
            mixture: MixtureConfig::VIEW,
        }
    }

    /// Jujubes: the default search with the size of Lingwu long jujubes.
    ///
    /// For the paper's search ([`Self::paper`]) it is Table 5 for real jujubes before a real camera. Limits of 9.5 to
    /// 24.5 mm: the printed 10 mm refuses fruit whose shorter minor semi-axis is 9.6 mm, as rho = 0.937 of Fig. 3 implies.
    /// A shell of 0.16 instead of 0.1: at the axial noise of a Kinect v2 (1.3 mm) the printed one, 1.1 mm either side of
    /// the short semi-axes, loses half of the fruit's own points. With the wider shell a hypothesis must explain 80 % of
    /// its neighbourhood.
    pub fn jujube() -> Self {
        Self {
            semi_axis_min: 9.5,
            semi_axis_max: 24.5,
            shell: 0.16,
            min_ratio: 0.8,
            method: Method::Map,
            ..Self::table5()
        }
    }

    /// Apples. For the paper's search of 54 to 100 mm: semi-axes 27 to 50 mm, neighbourhoods of 60 mm, and the printed
    /// shell, which is wide enough at this size.
    pub fn apple() -> Self {
        Self {
            semi_axis_min: 27.0,
            semi_axis_max: 50.0,
            radius: 60.0,
            shell: 0.1,
            min_ratio: 0.6,
            map: MapConfig {
                // A gripper for apples forgives a centimetre; leaves cover two thirds of many.
                gate: Gate {
                    size_conflict: 12.0,
                    uncertain_mm: 12.0,
                    visible: 0.3,
                    through: 0.25,
                    ..MapConfig::of(SizePrior::APPLE).gate
                },
                ..MapConfig::of(SizePrior::APPLE)
            },
            ..Self::jujube()
        }
    }

    /// Any fruit of 10 to 120 mm, for the paper's search; the default search needs to know the size better.
    pub fn generic() -> Self {
        Self { semi_axis_min: 5.0, semi_axis_max: 60.0, ..Self::apple().paper() }
    }

    /// The same with the paper's search.
    pub fn paper(self) -> Self {
        Self { method: Method::Varsac, ..self }
    }

    /// Complete surfaces of any size, measured from all around.
    pub fn surface() -> Self {
        let map = MapConfig { viewpoint: Viewpoint::None, ..MapConfig::of(SizePrior::JUJUBE) };
        Self { method: Method::Mixture, mixture: MixtureConfig::SURFACE, map, ..Self::table5() }
    }

    /// One view of fruit of unknown size before a Kinect v2.
    pub fn unknown() -> Self {
        Self { method: Method::Mixture, mixture: MixtureConfig::VIEW, ..Self::table5() }
    }

    /// Checks every field.
    ///
    /// # Errors
    /// The first field out of range, its value and the range.
    pub fn check(&self) -> Result<(), ConfigError> {
        const OPEN_UNIT: &str = "above 0 and below 1";
        let inside = |value: f32| value > 0.0 && value < 1.0;
        // Squares and their reciprocals must stay in the normal range of f32.
        let length = |value: f32| (1e-9..=1e9).contains(&value);
        require(inside(self.confidence), "confidence", self.confidence, OPEN_UNIT)?;
        require(
            !self.sample_sizes.is_empty(),
            "sample_sizes",
            self.sample_sizes.len() as f32,
            "a list of 1 to 16 sample sizes",
        )?;
        for &size in &self.sample_sizes {
            require(
                (crate::fit::MIN_SAMPLE..=MAX_SAMPLE).contains(&usize::from(size)),
                "sample_sizes",
                f32::from(size),
                "9 to 32: nine unknowns need nine points",
            )?;
        }
        require(inside(self.shell), "shell", self.shell, OPEN_UNIT)?;
        require(
            length(self.radius) || self.radius == f32::INFINITY,
            "radius",
            self.radius,
            "1e-9 to 1e9, or infinity for the whole cloud",
        )?;
        require(length(self.semi_axis_min), "semi_axis_min", self.semi_axis_min, POSITIVE)?;
        require(length(self.semi_axis_max), "semi_axis_max", self.semi_axis_max, POSITIVE)?;
        require(
            self.semi_axis_max > self.semi_axis_min,
            "semi_axis_max",
            self.semi_axis_max,
            "larger than semi_axis_min",
        )?;
        require(
            (1..=MAX_TRIALS).contains(&self.max_trials),
            "max_trials",
            self.max_trials as f32,
            "1 to 1000000",
        )?;
        require(self.refits <= MAX_REFITS, "refits", f32::from(self.refits), "0 to 10")?;
        require(self.min_inliers >= 1, "min_inliers", f32::from(self.min_inliers), "1 to 65535")?;
        require((0.0..=1.0).contains(&self.min_ratio), "min_ratio", self.min_ratio, "0 to 1")?;
        require(self.max_targets >= 1, "max_targets", f32::from(self.max_targets), "1 to 255")?;
        require(self.max_failures >= 1, "max_failures", f32::from(self.max_failures), "1 to 255")?;
        self.map.check()?;
        self.mixture.check()
    }
}

pub(crate) const POSITIVE: &str = "a finite number above 0";

pub(crate) fn require(
    holds: bool,
    field: &'static str,
    value: f32,
    allowed: &'static str,
) -> Result<(), ConfigError> {
    if holds { Ok(()) } else { Err(ConfigError { field, value: f64::from(value), allowed }) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn presets_are_valid() {
        for preset in [
            Config::table2(),
            Config::table2_wide(),
            Config::table5(),
            Config::jujube(),
            Config::apple(),
            Config::surface(),
            Config::unknown(),
            Config::generic(),
        ] {
            assert_eq!(preset.check(), Ok(()));
        }
    }

    #[test]
    fn each_bad_field_is_named() {
        type Spoil = fn(&mut Config);
        let cases: [(&str, Spoil); 18] = [
            ("confidence", |c| c.confidence = 0.0),
            ("confidence", |c| c.confidence = 1.0),
            ("confidence", |c| c.confidence = f32::NAN),
            ("sample_sizes", |c| c.sample_sizes.clear()),
            ("sample_sizes", |c| c.sample_sizes[0] = 8),
            ("sample_sizes", |c| c.sample_sizes[3] = 33),
            ("shell", |c| c.shell = 1.0),
            ("radius", |c| c.radius = -1.0),
            ("radius", |c| c.radius = f32::NAN),
            ("semi_axis_min", |c| c.semi_axis_min = 0.0),
            ("semi_axis_max", |c| c.semi_axis_max = f32::INFINITY),
            ("semi_axis_max", |c| c.semi_axis_max = 5.0),
            ("max_trials", |c| c.max_trials = 0),
            ("refits", |c| c.refits = 11),
            ("min_inliers", |c| c.min_inliers = 0),
            ("min_ratio", |c| c.min_ratio = 1.5),
            ("max_targets", |c| c.max_targets = 0),
            ("max_failures", |c| c.max_failures = 0),
        ];
        for (field, spoil) in cases {
            let mut config = Config::jujube();
            spoil(&mut config);
            assert_eq!(config.check().map_err(|error| error.field), Err(field));
        }
    }
}
