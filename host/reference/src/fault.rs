//! Deliberate mistakes, one per stage, each a single rounding or a single tie. They prove that the comparison of
//! core and reference can fail and that it names the right stage.
//!
//! Only the feature `faults`, which only tests switch on, can inject one. Without it [`is`] is the constant
//! `false` and nothing of a mistake is compiled.

/// The stage that goes wrong, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(not(feature = "faults"), expect(unreachable_pub, reason = "exported with the feature only"))]
pub enum Fault {
    /// A draw is reduced by modulo instead of by multiplication.
    Draws,
    /// A point at exactly the radius is left out.
    Neighbourhood,
    /// The points enter the normal equations in reverse order.
    NormalMatrix,
    /// The solution is not refined.
    Solution,
    /// `a11` under the trace constraint is `1 - (u + v)` instead of `(1 - u) - v`.
    Quadric,
    /// `I2` adds its three terms in reverse order.
    Invariants,
    /// The centre multiplies by a reciprocal instead of dividing.
    Hypothesis,
    /// A semi-axis exactly at its limit is accepted.
    Size,
    /// A point exactly on the outer surface of the shell is left out.
    Score,
    /// The bound takes the logarithm of `1 - x` instead of `log1p(-x)`.
    Bound,
    /// Of two equally good hypotheses the later one is kept.
    Best,
    /// A refit that changes nothing is taken for a new surface.
    Refit,
    /// The sweep takes the pair (0, 2) before the pair (0, 1).
    Eigenpairs,
    /// A semi-axis is the root of the reciprocal instead of the reciprocal of the root.
    Ellipsoid,
    /// The quaternion is divided by its norm instead of multiplied by the reciprocal.
    Attitude,
    /// A target with exactly as many points as it needs is dropped.
    Detection,
    /// A point in the shells of two targets goes to the later one.
    Labels,
    /// The information of the third semi-axis lacks the ratio of the short ones (M2).
    Prior,
    /// The residual multiplies out the gap (M5).
    Contact,
    /// The lever of an outline ray multiplies from the right (M7).
    Ray,
    /// The worth of a point is `(6.25 - f2) / 6.25` (M8).
    Support,
    /// Points behind the window count for nothing (M9.1).
    Beside,
    /// A derived sum subtracts the sum of two (M9.3).
    Moments,
    /// The displacement of the rays is not eliminated (M9.5).
    Displacement,
    /// The information of the boxiness keeps what the displacement takes of it (M9.5).
    Boxiness,
    /// The reciprocal is squared instead of the denominator (M6).
    GemanMcClure,
    /// The weight of Tukey is not squared (M6).
    Tukey,
    /// The centre gains the three terms of its step one by one (M10).
    Step,
    /// Points outside the mask are drawn, too (M11).
    Mask,
    /// The third axis of a start is the third eigenvector (M11).
    Start,
    /// The second-best candidate is refined first (M12).
    Keeping,
    /// A candidate is done when it moves by less than twice the limit (M12).
    Refinement,
    /// The first candidate is taken for the best (M13).
    Choice,
    /// A rival may stand anywhere (M13).
    Rival,
    /// The median is the middle of its bin (M14).
    Noise,
    /// A claim ends where a sight does (M15).
    Claim,
    /// The stronger of two fruit is the ghost (M16).
    Standings,
    /// The contact function multiplies from the right (M16).
    ContactFunction,
    /// A challenged point does not ask who is nearer (M17.2).
    Challenge,
    /// A turn has four steps (M17.3).
    Joint,
    /// The loose prior is half as loose (M2).
    Loose,
    /// A reciprocal is multiplied with instead of divided by (M19).
    SizeEvidence,
    /// The means of the points multiply by a reciprocal (M18.6).
    Flat,
    /// The covariance is inflated last (M20).
    Covariance,
    /// The last failing test is reported (M21).
    Acceptance,
    /// The volume multiplies from the right (X3).
    Volume,
    /// An element changes places with any other (X3).
    Shuffle,
    /// The covariance of a blob is not widened (X4).
    Blob,
    /// The logarithm of the area divides by three (X5).
    Area,
    /// The odds divide by the scale last (X5).
    Odds,
    /// The foot is given one step less (X5.1).
    Foot,
    /// The curvature has no limit (X6).
    Bend,
    /// Points behind the window count for nothing (X6).
    Past,
    /// Outline rays count for nothing (X6).
    Rays,
    /// The diagonal is not enlarged (X7).
    Climb,
    /// A start is not told from an earlier one (X8.3).
    Remembered,
    /// Of two shells that are the same the earlier one stays (X8.4).
    Kept,
    /// The last climb of the final fit is taken (X9).
    FinalFit,
    /// An expected square is added up where a responsibility is asked for (X10).
    Cells,
    /// The larger of cap and band counts (X10).
    Coverage,
    /// All of the responsibility counts as information (X6).
    Information,
    /// A body claims no point off its surface by more than two and a half deviations (X12).
    Claimed,
    /// The damping falls to a half (G1).
    Damping,
    /// The covariance of the algebraic fit takes the first matrix for the second (G1).
    Spread,
}

#[cfg(feature = "faults")]
thread_local! {
    static INJECTED: std::cell::Cell<Option<Fault>> = const { std::cell::Cell::new(None) };
}

/// From here on, this thread makes the mistake `fault`, or none.
#[cfg(feature = "faults")]
pub fn inject(fault: Option<Fault>) {
    INJECTED.set(fault);
}

/// Whether this thread is to make the mistake `fault`.
#[cfg(feature = "faults")]
pub(crate) fn is(fault: Fault) -> bool {
    INJECTED.get() == Some(fault)
}

/// Without the feature there are no mistakes.
#[cfg(not(feature = "faults"))]
pub(crate) const fn is(_: Fault) -> bool {
    false
}
