//! A window into every stage, for the bit-for-bit check, for pictures and for debugging.
//!
//! Each method is called once where its stage happens and does nothing by default; the search with `()` as observer
//! compiles to the search alone.

use crate::{
    CentralQuadric, Detection, Noise, Quadric, Rejection, Score, linalg::Symmetric9, refine::Estimate,
    visibility::Support,
};

/// Where in the default search an estimate stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Made from a sample.
    Hypothesis,
    /// After a step of refinement.
    Refined,
    /// After a step of the final fit.
    Final,
    /// After a step of the fit beside its neighbours.
    Joint,
    /// After a step with its size set almost free.
    Free,
}

/// Sees what the search does, in order. Index lists are in ascending order where not stated otherwise.
#[allow(unused_variables, reason = "the defaults ignore what they are shown")]
pub trait Observer {
    /// A trial begins at this point of the cloud.
    fn seed_point(&mut self, index: u16) {}
    /// Live points within the sampling radius of the seed point.
    fn neighbourhood(&mut self, members: &[u16]) {}
    /// The points drawn, as indices of the cloud, in draw order.
    fn sample(&mut self, members: &[u16]) {}
    /// Normal matrix and right-hand side of a fit, in its local frame.
    fn normal_equations(&mut self, matrix: &Symmetric9, rhs: &[f32; 9]) {}
    /// Its refined solution.
    fn solution(&mut self, x: &[f32; 9]) {}
    /// The quadric in the local frame; its invariants follow from it.
    fn quadric(&mut self, quadric: &Quadric) {}
    /// The ellipsoid it is, in the frame of the cloud.
    fn hypothesis(&mut self, surface: &CentralQuadric) {}
    /// Why a trial came to nothing.
    fn rejected(&mut self, reason: Rejection) {}
    /// Support of a valid hypothesis in its neighbourhood.
    fn score(&mut self, score: Score) {}
    /// The hypothesis is the best so far, and this many trials are now enough.
    fn bound(&mut self, trials: u32) {}
    /// The best hypothesis after a least-squares refit on its inliers.
    fn refit(&mut self, surface: &CentralQuadric) {}
    /// A model of the default search.
    fn estimate(&mut self, stage: Stage, estimate: &Estimate) {}
    /// What speaks for it.
    fn support(&mut self, support: &Support) {}
    /// The noise that its residuals show.
    fn noise(&mut self, noise: &Noise) {}
    /// A target is handed out.
    fn detection(&mut self, detection: &Detection) {}
}

impl Observer for () {}
