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
