//! The results of every stage in the order in which a run makes them.
//!
//! Within a trial: `SeedPoint` and `Neighbourhood` (finite radius only), `Sample` (if one was drawn), `Normal`,
//! `Solution`, `Quadric`, `Invariants`, `Hypothesis` as far as the fit gets, then `Rejected` or `Score`, then
//! `Bound` if the hypothesis is the best so far. Within a refit: `Normal` to `Hypothesis` as far as the fit gets,
//! then `Refit` if the new surface replaces the old one. A search ends in a `Detection` or is `Missed`.
//!
//! The default search has the same draws, and otherwise the events of its chapter M22.

use crate::{Central, Detection, Estimate, MapDetection, MixtureDetection, Noise, Report, Score, Support};

/// Why a hypothesis died.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// Fewer points than a sample or a fit needs.
    TooFewPoints,
    /// The points do not determine a quadric.
    Degenerate,
    /// The quadric is not a real ellipsoid.
    NotEllipsoid,
    /// A semi-axis outside its limits.
    Size,
    /// Too few inliers, by count or by ratio.
    Support,
}

/// Where in the default search an estimate stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Made from a sample, after its steps (M11).
    Hypothesis,
    /// After a step of a candidate (M12).
    Refined,
    /// After a step of the final fit (M13).
    Final,
    /// After a step beside its neighbours (M17).
    Joint,
    /// After a step with the loose prior (M18).
    Free,
}

/// One result of one stage.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// Index of the seed point (chapter 4).
    SeedPoint(u16),
    /// Indices of the neighbourhood, ascending (chapter 4).
    Neighbourhood(Vec<u16>),
    /// Indices of the sample in the order drawn (chapter 9.3).
    Sample(Vec<u16>),
    /// The normal equations before they are factored (chapter 5.3).
    Normal {
        /// Lower triangle by rows.
        matrix: [f32; 45],
        /// Right-hand side.
        rhs: [f32; 9],
    },
    /// The refined solution `[u, v, a14, a24, a34, a44, a12, a13, a23]` (chapter 5.6).
    Solution([f32; 9]),
    /// `[a11, a22, a33, a12, a13, a23, a14, a24, a34, a44]` in the local frame (chapter 5.7).
    Quadric([f32; 10]),
    /// `[I1, I2, I3, I4]` in the local frame (chapter 5.8).
    Invariants([f32; 4]),
    /// A real ellipsoid in the frame of the cloud, its size not yet checked (chapter 5.10).
    Hypothesis(Central),
    /// The end of a trial that failed.
    Rejected(Rejection),
    /// The support of a hypothesis within its neighbourhood (chapter 9.5).
    Score(Score),
    /// The bound on the trials after a new best hypothesis (chapter 8).
    Bound(u32),
    /// The surface that a refit has put in place of the previous one (chapter 10.3).
    Refit(Central),
    /// A target as it is reported (chapter 10.4).
    Detection(Detection),
    /// What a search did that came to nothing (chapter 10.2 or 10.4; M13 or M15).
    Missed(Report),
    /// A model of the default search after one of its steps.
    Estimate(Phase, Estimate),
    /// What speaks for an estimate (M8).
    Support(Support),
    /// The noise that the points of an estimate show (M14).
    Noise(Noise),
    /// The labels of all points after a claim (M15), the standings (M16) or a challenge (M17.2), changed or not. The core
    /// has no such event: its labels are seen between two steps.
    Labels(Vec<u8>),
    /// A fruit as it is reported (M21).
    MapDetection(Box<MapDetection>),
    /// A body of the search without a size prior as it is reported (X12).
    MixtureDetection(Box<MixtureDetection>),
}
