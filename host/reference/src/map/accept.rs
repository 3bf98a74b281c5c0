//! What the tests of acceptance look at, and the tests: contract, chapter M21.

use super::view::Gate;
use crate::fault::{self, Fault};

/// The findings of M18.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the names are those of M18")]
pub struct Findings {
    pub explained: u32,
    pub through: u32,
    pub conflict: f32,
    pub end_on: f32,
    pub size_sigma: f32,
    pub rival: f32,
    pub rays: u32,
    pub outline: f32,
    pub visible: f32,
    pub colour: f32,
    pub sigma_mm: f32,
    pub flat: f32,
    pub separation: f32,
    pub clutter: f32,
}

impl Findings {
    /// M18.13: no finding is NaN.
    pub(crate) fn known(self) -> Self {
        let or = |value: f32, other: f32| if value.is_nan() { other } else { value };
        Self {
            conflict: or(self.conflict, f32::INFINITY),
            end_on: or(self.end_on, f32::INFINITY),
            size_sigma: or(self.size_sigma, f32::INFINITY),
            rival: or(self.rival, f32::INFINITY),
            outline: or(self.outline, f32::INFINITY),
            visible: or(self.visible, 0.0),
            colour: or(self.colour, f32::INFINITY),
            sigma_mm: or(self.sigma_mm, f32::INFINITY),
            flat: or(self.flat, 0.0),
            separation: or(self.separation, 0.0),
            clutter: or(self.clutter, f32::INFINITY),
            ..self
        }
    }
}

/// M21: which test a fruit failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names are those of the table of M21 and of X10")]
pub enum RefusalCode {
    FewPoints,
    SizeConflict,
    SizeUnknown,
    Ambiguous,
    Outline,
    Visible,
    Colour,
    Uncertain,
    Flat,
    Through,
    SharedVolume,
    Singular,
    Clutter,
    Coverage,
    Shape,
    Vague,
}

/// M21: the test that a fruit failed, its value and limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refusal {
    /// Which test.
    pub code: RefusalCode,
    /// What was found.
    pub value: f32,
    /// What is allowed.
    pub limit: f32,
}

/// Which side of its limit a value must not be on.
enum Fails {
    Above,
    Below,
}

/// M21: the first test that fails.
pub(crate) fn refusal(f: &Findings, gate: &Gate, has_covariance: bool) -> Option<Refusal> {
    use RefusalCode as Code;
    if !has_covariance {
        return Some(Refusal { code: Code::Singular, value: 0.0, limit: 0.0 });
    }
    let explained = if f.explained == 0 { 1.0 } else { f.explained as f32 };
    let size_conflict = if f.end_on > 0.85 { gate.size_conflict_end_on } else { gate.size_conflict };
    let mut tests = vec![
        (Code::FewPoints, f.explained as f32, Fails::Below, f32::from(gate.min_points)),
        (Code::SizeConflict, f.conflict, Fails::Above, size_conflict),
        (Code::SizeUnknown, f.size_sigma, Fails::Above, gate.size_unknown),
        (Code::Ambiguous, f.rival, Fails::Above, gate.ambiguous),
    ];
    if f.rays >= 6 {
        tests.push((Code::Outline, f.outline, Fails::Above, gate.outline));
    }
    tests.extend([
        (Code::Visible, f.visible, Fails::Below, gate.visible),
        (Code::Colour, f.colour, Fails::Above, gate.colour),
        (Code::Uncertain, f.sigma_mm, Fails::Above, gate.uncertain),
        (Code::Flat, f.flat, Fails::Below, gate.flat),
        (Code::Through, f.through as f32 / explained, Fails::Above, gate.through),
        (Code::SharedVolume, f.separation, Fails::Below, gate.shared_volume),
    ]);
    if fault::is(Fault::Acceptance) {
        tests.reverse();
    }
    for (code, value, fails, limit) in tests {
        let passed = match fails {
            Fails::Above => value <= limit,
            Fails::Below => value >= limit,
        };
        if !passed {
            return Some(Refusal { code, value, limit });
        }
    }
    None
}
