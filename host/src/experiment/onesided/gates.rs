//! Gates other than the one in force, applied to detections that are there already.
//!
//! A gate's tests are functions of the findings that each detection carries ([`Gate::refusal`]), so that one search tells what
//! every gate would have made of it. (But for the test for shared volume, which looks at what was accepted before.)

use varsac_core::Gate;

use super::{Outcome, WRONG_MM, measure::Judged};

/// The default.
const BALANCED: Gate = Gate::BALANCED;

/// The presets by their names.
pub(super) const PRESETS: [(&str, Gate); 3] =
    [("strict", Gate::STRICT), ("balanced", BALANCED), ("eager", Gate::EAGER)];

/// Strictness: limits are multiplied by it; 1 is the default gate.
pub(super) const SCALES: [f64; 9] = [0.4, 0.5, 0.65, 0.8, 1.0, 1.25, 1.6, 2.0, 3.0];

/// Whether a gate accepts a detection.
pub(super) fn passes(gate: &Gate, judged: &Judged) -> bool {
    judged.findings.is_some_and(|findings| gate.refusal(&findings).is_none())
}

/// What a gate lets through.
pub(super) struct Passed {
    pub(super) subjects: usize,
    pub(super) accepted: usize,
    pub(super) wrong: usize,
    pub(super) far: usize,
}

impl Passed {
    pub(super) fn of(outcomes: &[Outcome], gate: &Gate) -> Self {
        let passes = |judged: &Judged| passes(gate, judged);
        let subjects =
            outcomes.iter().filter(|o| o.fit.is_some_and(|fit| passes(&o.detections[fit.detection])));
        let accepted = || outcomes.iter().flat_map(|o| &o.detections).filter(|judged| passes(judged));
        Self {
            subjects: subjects.count(),
            accepted: accepted().count(),
            wrong: accepted().filter(|judged| judged.error_mm > WRONG_MM).count(),
            far: accepted().filter(|judged| judged.is_far).count(),
        }
    }
}

/// The default gate with upper limits times `scale` and lower limits divided by it; where the natural bound of a
/// quantity is 1, the distance from 1 is scaled. The number of points stays.
pub(super) fn scaled(scale: f64) -> Gate {
    let (gate, scale) = (BALANCED, scale as f32);
    Gate {
        size_conflict: gate.size_conflict * scale,
        size_unknown: gate.size_unknown * scale,
        ambiguous: 1.0 - (1.0 - gate.ambiguous) / scale,
        outline: gate.outline * scale,
        visible: gate.visible / scale,
        colour: gate.colour * scale,
        uncertain_mm: gate.uncertain_mm * scale,
        flat: 1.0 + (gate.flat - 1.0) / scale,
        through: gate.through * scale,
        shared_volume: gate.shared_volume / scale,
        ..gate
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Case, Method, measure};
    use super::*;
    use crate::{experiment::Context, synth::onesided::families::ORCHARD};

    #[test]
    fn a_looser_gate_accepts_whatever_a_stricter_one_does() {
        let outcomes =
            measure(&Context::default(), &[Case::of(ORCHARD)], &[Method::Outline], &[1, 2, 3, 4, 5, 6]);
        let counts = SCALES.map(|scale| Passed::of(&outcomes[0][0], &scaled(scale)).accepted);
        assert!(counts.is_sorted() && counts[SCALES.len() - 1] > 0, "{counts:?}");
        // At 1 the findings give the verdicts that the search gave.
        let accepted = outcomes[0][0].iter().flat_map(|o| &o.detections).filter(|j| j.is_accepted()).count();
        assert_eq!(Passed::of(&outcomes[0][0], &scaled(1.0)).accepted, accepted);
    }
}
