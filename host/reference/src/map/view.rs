//! What a run looks at and what it is told: contract, chapter M2, under the names of the contract.

use crate::Point;

/// Points and what is known of them beyond their coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct View {
    /// The cloud, mm.
    pub points: Vec<Point>,
    /// Points with an index below it lie in the mask.
    pub in_mask: usize,
    /// Outline rays in order.
    pub outline: Vec<OutlineRay>,
    /// Angle between neighbouring points, rad; 0 where it is not known.
    pub pitch: f32,
}

/// A ray that touches the outline of a fruit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlineRay {
    /// Point of the ray at the depth of the fruit, mm.
    pub inner: Point,
    /// Depth of what is behind, mm; infinite where nothing was seen.
    pub outer: f32,
    /// Standard deviation of the ray's direction, rad.
    pub sigma: f32,
}

/// Deviations of the camera's measurements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Along the ray, mm.
    pub axial: f32,
    /// Across it, rad.
    pub lateral: f32,
}

/// From where the points were seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Viewpoint {
    /// From the origin.
    Origin,
    /// From all around.
    None,
}

/// The inflation of the covariance (M18.7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inflation {
    /// Where nothing is wrong.
    pub base: f32,
    /// Added for each unit of conflict.
    pub per_conflict: f32,
    /// Added for each unit of clutter.
    pub per_clutter: f32,
}

/// The limits of M21.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the names are those of the table of M21")]
pub struct Gate {
    pub min_points: u16,
    pub size_conflict: f32,
    pub size_conflict_end_on: f32,
    pub size_unknown: f32,
    pub ambiguous: f32,
    pub outline: f32,
    pub visible: f32,
    pub colour: f32,
    pub uncertain: f32,
    pub flat: f32,
    pub through: f32,
    pub shared_volume: f32,
}

/// The parameters of the default search.
#[derive(Clone, Debug, PartialEq)]
pub struct MapConfig {
    /// Targets at most (M3.1).
    pub max_targets: u8,
    /// Failed searches after which a run ends (M3.1).
    pub max_failures: u32,
    /// Mean semi-axes `(a, b, c)`, mm.
    pub semi_axes: [f32; 3],
    /// Deviations of their logarithms.
    pub spread: [f32; 3],
    /// Deviation of `ln(a / b)`, or infinity.
    pub spread_ab: f32,
    /// Deviation of `ln(b / c)`, or infinity.
    pub spread_bc: f32,
    /// Deviation of the boxiness.
    pub boxiness: f32,
    /// Assumed noise.
    pub noise: Noise,
    /// How much a point tells beside one whose noise is its own.
    pub independence: f32,
    /// From where the points were seen.
    pub viewpoint: Viewpoint,
    /// Deviation of the displacement common to all outline rays, rad.
    pub outline_offset: f32,
    /// Trials of a search (M12).
    pub hypotheses: u32,
    /// Steps of a hypothesis (M11).
    pub hypothesis_steps: u32,
    /// Candidates kept (M12).
    pub kept: usize,
    /// Steps of a candidate at most (M12).
    pub refine_steps: u32,
    /// Steps of the final and of the free fit at most (M13, M18).
    pub final_steps: u32,
    /// Inflation of the covariance (M18.7).
    pub inflation: Inflation,
    /// Limits of acceptance (M21).
    pub gate: Gate,
}

impl MapConfig {
    /// M2: the semi-axis `a`, as it is.
    pub(crate) fn long(&self) -> f32 {
        self.semi_axes[0]
    }

    /// M2: the semi-axis `c`, as it is.
    pub(crate) fn short(&self) -> f32 {
        self.semi_axes[2]
    }
}
