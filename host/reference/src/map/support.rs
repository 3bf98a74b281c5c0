//! What speaks for an estimate: contract, chapter M8.

use super::contact::{Contact, Sight};
use super::evidence::Evidence;
use super::model::{Estimate, Model};
use super::prior::Terms;
use crate::fault::{self, Fault};

/// Score and counts of an estimate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// The evidence, less the price of the size.
    pub score: f32,
    /// Points explained.
    pub explained: u32,
    /// Points seen through.
    pub through: u32,
}

/// M8: the support of an estimate, if it exceeds the floor.
pub(crate) fn support(estimate: &Estimate, evidence: Evidence, terms: &Terms, floor: f32) -> Option<Support> {
    let model = Model::new(estimate, terms.noise, terms.viewpoint);
    let mut found = Support { score: -(terms.prior.cost(estimate.x) / 6.25), explained: 0, through: 0 };
    for touch in evidence.touching(&model, terms) {
        let f2 = touch.f2(estimate.boxiness);
        if f2 < 6.25 {
            found.score += 0.5 * (1.0 - f2 / 6.25);
        }
    }
    let mut left = evidence.members.len() as f32;
    for &member in evidence.members {
        left -= 1.0;
        match Contact::new(&model, evidence.point(member)).sight(terms.window) {
            Sight::Explained(f2) if evidence.open(member) => {
                let worth = if fault::is(Fault::Support) { (6.25 - f2) / 6.25 } else { 1.0 - f2 / 6.25 };
                found.score += terms.told * worth;
                found.explained += 1;
            }
            Sight::Through => {
                found.score -= terms.told * 1.5;
                found.through += 1;
            }
            Sight::Explained(_) | Sight::Unrelated => {}
        }
        let hope = found.score + terms.told * left;
        let enough = hope > floor;
        if !enough {
            return None;
        }
    }
    Some(found)
}
