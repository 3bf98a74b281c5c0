//! What a run is asked to do, under the names of the contract. The reference takes any values; it is the core that
//! refuses nonsense.

/// The scale of the quadric that least squares holds fixed (contract, 5.2).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constraint {
    /// `a11 = 1`, as in the paper.
    A11,
    /// `a11 + a22 + a33 = 3`, which no rotation changes.
    Trace,
}

/// The parameters of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// `p` of Eq. (17): the probability to have drawn one good sample (chapter 8).
    pub confidence: f32,
    /// Sample sizes, taken in turn (chapter 9).
    pub sizes: Vec<u8>,
    /// `d`: the shell lies between the surface scaled by `1 - d` and by `1 + d` (chapter 7).
    pub shell: f32,
    /// Radius of a neighbourhood, mm; infinite for the whole cloud (chapter 4).
    pub radius: f32,
    /// Shortest semi-axis that is accepted, mm (chapter 6).
    pub semi_axis_min: f32,
    /// Longest semi-axis that is accepted, mm (chapter 6).
    pub semi_axis_max: f32,
    /// Trials at most, for one target (chapter 9).
    pub max_trials: u32,
    /// Refits at most, for one target (chapter 10).
    pub refits: u32,
    /// Inliers that a hypothesis and a target need (chapters 9 and 10).
    pub min_inliers: u32,
    /// Share of the neighbourhood that must be inliers (chapter 9).
    pub min_ratio: f32,
    /// Targets at most (chapter 10).
    pub max_targets: u8,
    /// Failed searches after which a run ends (chapter 10).
    pub max_failures: u32,
    /// The constraint of every fit (chapter 5).
    pub constraint: Constraint,
}
