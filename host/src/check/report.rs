//! What a check found, and how it is said.

use super::cases::Family;
use super::record::{Parting, Record, Stage};
use std::fmt;

/// The outcome of a check. It depends on the options and not on the number of threads.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Cases that were compared.
    pub cases: u64,
    /// Results of the core by stage, in the order of [`Stage::ALL`].
    pub counts: [u64; Stage::COUNT],
    /// One number for all bits of the core's results; the same on every machine.
    pub digest: u64,
    /// Cases in which the two sides differ.
    pub differing: u64,
    /// The first difference of the first such case.
    pub difference: Option<Difference>,
}

impl Outcome {
    /// Fits that both sides made: those that got as far as their normal equations.
    pub fn fits(&self) -> u64 {
        self.counts[Stage::NormalMatrix as usize]
    }

    /// Searches of the paper for one target that both sides made.
    pub fn searches(&self) -> u64 {
        self.counts[Stage::Detection as usize]
    }

    /// Default searches for one target that both sides made.
    pub fn map_searches(&self) -> u64 {
        self.counts[Stage::Verdict as usize]
    }

    /// Searches without a size prior that both sides made.
    pub fn mixture_searches(&self) -> u64 {
        self.counts[Stage::Body as usize]
    }
}

impl fmt::Display for Outcome {
    /// One summary line; before it, the difference if there is one.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(difference) = &self.difference {
            writeln!(f, "{difference}")?;
            write!(f, "check: {} of {} cases differ", self.differing, self.cases)?;
        } else {
            write!(f, "check: {} cases, no bit differs, digest {:016x}", self.cases, self.digest)?;
        }
        for (index, (_, plural)) in Stage::ALL.iter().enumerate() {
            write!(f, "{} {} {plural}", if index == 0 { ';' } else { ',' }, self.counts[index])?;
        }
        Ok(())
    }
}

/// The first difference of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The stage that differs first.
    pub stage: Stage,
    /// Its case.
    pub case: u64,
    /// What kind of input that is.
    pub family: Family,
    /// What the core has, in hex and decimal.
    pub core: String,
    /// What the reference has.
    pub reference: String,
    /// The command that shows this difference again.
    pub replay: String,
}

impl Difference {
    /// Puts the first word that differs, or the presence of a record, into words.
    pub(super) fn new(parting: &Parting, case: u64, family: Family, replay: String) -> Self {
        let [core, reference] = &parting.sides;
        let word = match (core, reference) {
            (Some(a), Some(b)) if a.what == b.what => {
                let same = a.words.iter().zip(&b.words).take_while(|(a, b)| a == b).count();
                Some(same)
            }
            _ => None,
        };
        Self {
            stage: parting.stage,
            case,
            family,
            core: in_words(core.as_ref(), word),
            reference: in_words(reference.as_ref(), word),
            replay,
        }
    }
}

/// A word of a record, or a whole record where the other side has a different one.
fn in_words(record: Option<&Record>, word: Option<usize>) -> String {
    let Some(Record { what, words }) = record else { return "nothing more".to_owned() };
    let value = |index: usize| match words.get(index) {
        None => "missing".to_owned(),
        Some(bits) if what.floats => format!("0x{bits:08x} = {:e}", f32::from_bits(*bits)),
        Some(number) => format!("0x{number:08x} = {number}"),
    };
    match word {
        Some(index) => format!("{}[{index}] {}", what.name, value(index)),
        None if words.is_empty() => what.name.to_owned(),
        None => format!("{}, {} values, the first {}", what.name, words.len(), value(0)),
    }
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "case {} ({:?}): the first difference is in stage {}",
            self.case, self.family, self.stage
        )?;
        writeln!(f, "  core       {}", self.core)?;
        writeln!(f, "  reference  {}", self.reference)?;
        write!(f, "  replay     {}", self.replay)
    }
}

#[cfg(test)]
mod tests {
    use super::super::record::What;
    use super::*;

    #[test]
    fn a_difference_shows_both_values_in_hex_and_decimal() {
        let what = What { stage: Stage::Solution, name: "solution", floats: true };
        let record = |value: f32| Some(Record { what, words: vec![0, value.to_bits()] });
        let parting = Parting { stage: Stage::Solution, sides: [record(1.0), record(-0.5)] };
        let text = Difference::new(&parting, 7, Family::Grid, "again".to_owned()).to_string();
        assert_eq!(
            text,
            "case 7 (Grid): the first difference is in stage Solution\n  \
             core       solution[1] 0x3f800000 = 1e0\n  \
             reference  solution[1] 0xbf000000 = -5e-1\n  \
             replay     again"
        );
    }

    #[test]
    fn a_record_that_one_side_lacks_is_shown_whole() {
        let what = What { stage: Stage::Draws, name: "sample", floats: false };
        assert_eq!(in_words(None, None), "nothing more");
        let record = Record { what, words: vec![12, 3] };
        assert_eq!(in_words(Some(&record), None), "sample, 2 values, the first 0x0000000c = 12");
        let end = Record { what, words: Vec::new() };
        assert_eq!(in_words(Some(&end), None), "sample");
    }
}
