//! What both sides write down, in one shape: a sequence of records, each the bits of one result of one stage.
//!
//! Whole traces are never kept. A record is folded into a running hash, the hash is noted every [`SEGMENT`] records,
//! and the notes are what is compared. Where they differ, the case is run again and the records of the first
//! differing segment are kept. NaN has one bit pattern here: which one an operation makes differs between processors
//! and the contract does not say.

use std::ops::Range;
use varsac_reference::Fnv1a;

/// Records between two notes of the running hash.
const SEGMENT: u64 = 32;

/// A stage of a search, in the order of a trial, after it those of the default search (it shares the draws and the
/// hypothesis) and of the search without a prior; its name is what a difference is reported under.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "the names are those of the chapters of the numeric contract")]
pub enum Stage {
    Cloud,
    Draws,
    Neighbourhood,
    NormalMatrix,
    Solution,
    Quadric,
    Invariants,
    Hypothesis,
    Eigenpairs,
    Ellipsoid,
    Attitude,
    Size,
    Score,
    Bound,
    Refit,
    Detection,
    Support,
    Refined,
    Noise,
    Final,
    Labels,
    Joint,
    Free,
    Findings,
    Covariance,
    Verdict,
    Body,
    Single,
}

impl Stage {
    /// How many there are.
    pub const COUNT: usize = 28;

    /// All stages with the word (in the plural) that counts their results.
    pub const ALL: [(Self, &'static str); Self::COUNT] = [
        (Self::Cloud, "clouds"),
        (Self::Draws, "draws"),
        (Self::Neighbourhood, "neighbourhoods"),
        (Self::NormalMatrix, "normal matrices"),
        (Self::Solution, "solutions"),
        (Self::Quadric, "quadrics"),
        (Self::Invariants, "invariants"),
        (Self::Hypothesis, "hypotheses"),
        (Self::Eigenpairs, "eigenpairs"),
        (Self::Ellipsoid, "ellipsoids"),
        (Self::Attitude, "attitudes"),
        (Self::Size, "size checks"),
        (Self::Score, "scores"),
        (Self::Bound, "bounds"),
        (Self::Refit, "refits"),
        (Self::Detection, "ends of a search"),
        (Self::Support, "supports"),
        (Self::Refined, "refinements"),
        (Self::Noise, "noises"),
        (Self::Final, "final steps"),
        (Self::Labels, "labellings"),
        (Self::Joint, "joint steps"),
        (Self::Free, "free steps"),
        (Self::Findings, "findings"),
        (Self::Covariance, "covariances"),
        (Self::Verdict, "verdicts"),
        (Self::Body, "bodies or none"),
        (Self::Single, "single fits"),
    ];

    /// Of two stages the one that comes first after `last`, in the cycle of trials. When the sides go on
    /// differently, that is the one whose result only one of them has.
    fn first_after(last: Self, a: Self, b: Self) -> Self {
        let distance = |stage: Self| (stage as usize + Self::COUNT - last as usize) % Self::COUNT;
        // At distance 0 the same stage comes again (a refit after a refit), before any other.
        if distance(a) <= distance(b) { a } else { b }
    }
}

impl std::fmt::Display for Stage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self:?}")
    }
}

/// One result, and how to read its words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct What {
    /// The stage it belongs to.
    pub(crate) stage: Stage,
    /// What it is, in words.
    pub(crate) name: &'static str,
    /// The words are bits of `f32`, or else integers.
    pub(crate) floats: bool,
}

/// A record that was kept for a close look.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Record {
    pub(crate) what: What,
    pub(crate) words: Vec<u32>,
}

/// Takes the records of one side of one case.
pub(crate) struct Recorder {
    hash: Fnv1a,
    records: u64,
    notes: Vec<u64>,
    counts: [u64; Stage::COUNT],
    keep: Range<u64>,
    kept: Vec<Record>,
}

impl Recorder {
    /// A recorder that keeps nothing but notes.
    pub(crate) fn new() -> Self {
        Self {
            hash: Fnv1a::new(),
            records: 0,
            notes: Vec::new(),
            counts: [0; Stage::COUNT],
            keep: 0..0,
            kept: Vec::new(),
        }
    }

    /// A recorder that keeps the records of one segment, and the one before them.
    pub(crate) fn keeping(segment: usize) -> Self {
        let start = segment as u64 * SEGMENT;
        Self { keep: start.saturating_sub(1)..start + SEGMENT, ..Self::new() }
    }

    /// A result made of `f32`.
    pub(crate) fn floats(&mut self, stage: Stage, name: &'static str, values: &[&[f32]]) {
        let bits = values.iter().flat_map(|part| part.iter().map(|&value| canonical(value)));
        self.record(What { stage, name, floats: true }, bits);
    }

    /// A result made of integers.
    pub(crate) fn integers(
        &mut self,
        stage: Stage,
        name: &'static str,
        values: impl IntoIterator<Item = u32>,
    ) {
        self.record(What { stage, name, floats: false }, values);
    }

    /// The label of every point.
    pub(crate) fn labels(&mut self, labels: &[u8]) {
        self.integers(Stage::Labels, "labels", labels.iter().map(|&label| u32::from(label)));
    }

    fn record(&mut self, what: What, words: impl IntoIterator<Item = u32>) {
        let keep = self.keep.contains(&self.records);
        let mut kept = Vec::new();
        let mut count = 0_u32;
        self.hash.write(&[what.stage as u8]);
        self.hash.write(what.name.as_bytes());
        for word in words {
            self.hash.write(&word.to_le_bytes());
            count += 1;
            if keep {
                kept.push(word);
            }
        }
        self.hash.write(&count.to_le_bytes());
        if keep {
            self.kept.push(Record { what, words: kept });
        }
        // A record without words only says how a trial ended.
        self.counts[what.stage as usize] += u64::from(count > 0);
        self.records += 1;
        if self.records.is_multiple_of(SEGMENT) {
            self.notes.push(self.hash.finish());
        }
    }

    /// The hash of everything recorded.
    pub(crate) fn digest(&self) -> u64 {
        self.hash.finish()
    }

    /// Results by stage.
    pub(crate) fn counts(&self) -> [u64; Stage::COUNT] {
        self.counts
    }

    /// The first segment in which two recordings differ.
    pub(crate) fn first_difference(&self, other: &Self) -> Option<usize> {
        if self.records == other.records && self.digest() == other.digest() {
            return None;
        }
        let same = self.notes.iter().zip(&other.notes).take_while(|(a, b)| a == b).count();
        Some(same)
    }
}

/// The bits of a number, with one pattern for NaN.
fn canonical(value: f32) -> u32 {
    if value.is_nan() { f32::NAN.to_bits() } else { value.to_bits() }
}

/// Where two recordings of the same segment part: the records of both sides and the stage to name.
pub(crate) struct Parting {
    pub(crate) stage: Stage,
    pub(crate) sides: [Option<Record>; 2],
}

impl Parting {
    /// The first record that differs, if one does.
    pub(crate) fn between(first: Recorder, second: Recorder) -> Option<Self> {
        let mut last = Stage::Cloud;
        let (mut first, mut second) = (first.kept.into_iter(), second.kept.into_iter());
        loop {
            let sides = [first.next(), second.next()];
            let stage = match &sides {
                [None, None] => return None,
                [Some(one), None] | [None, Some(one)] => one.what.stage,
                [Some(a), Some(b)] if a == b => {
                    last = a.what.stage;
                    continue;
                }
                [Some(a), Some(b)] => Stage::first_after(last, a.what.stage, b.what.stage),
            };
            return Some(Self { stage, sides });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn recording(values: &[u32], mut recorder: Recorder) -> Recorder {
        for &value in values {
            recorder.integers(Stage::Score, "score", [value]);
        }
        recorder
    }

    #[test]
    fn equal_recordings_do_not_differ_and_one_word_does() {
        let mut values: Vec<u32> = (0..100).collect();
        let first = recording(&values, Recorder::new());
        assert_eq!(first.first_difference(&recording(&values, Recorder::new())), None);
        values[70] += 1;
        assert_eq!(first.first_difference(&recording(&values, Recorder::new())), Some(2));
        let kept = |values: &[u32]| recording(values, Recorder::keeping(2));
        let parting =
            Parting::between(kept(&(0..100).collect::<Vec<_>>()), kept(&values)).expect("a difference");
        let words = parting.sides.map(|side| side.expect("both sides have it").words);
        assert_eq!(words, [vec![70], vec![71]]);
    }

    #[test]
    fn a_missing_record_is_a_difference() {
        let long = recording(&[1, 2, 3], Recorder::new());
        assert_eq!(long.first_difference(&recording(&[1, 2], Recorder::new())), Some(0));
        let kept = |values: &[u32]| recording(values, Recorder::keeping(0));
        let parting = Parting::between(kept(&[1, 2, 3]), kept(&[1, 2])).expect("a difference");
        assert!(parting.sides[0].is_some() && parting.sides[1].is_none());
    }

    #[test]
    fn zero_and_minus_zero_differ_and_all_nan_are_one() {
        let one = |value: f32| {
            let mut recorder = Recorder::new();
            recorder.floats(Stage::Solution, "solution", &[&[value]]);
            recorder.digest()
        };
        assert_ne!(one(0.0), one(-0.0));
        assert_eq!(one(f32::NAN), one(-f32::NAN));
    }

    #[test]
    fn the_stage_that_only_one_side_has_is_named() {
        // After a score, one side reports a new bound and the other begins the next trial.
        assert_eq!(Stage::first_after(Stage::Score, Stage::Draws, Stage::Bound), Stage::Bound);
        // After the last refit, one side takes it once more and the other reports the target.
        assert_eq!(Stage::first_after(Stage::Attitude, Stage::Refit, Stage::Detection), Stage::Refit);
    }
}
