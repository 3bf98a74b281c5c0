//! The trials of a search, the candidates that are kept, and their refinement: contract, chapter M12.

use super::algebra::dot;
use super::contact::Kernel;
use super::evidence::{Evidence, listed};
use super::hypothesis::hypothesis;
use super::model::{Estimate, apart2};
use super::normal::normal_equations;
use super::prior::Terms;
use super::step::step;
use super::support::{Support, support};
use super::view::{MapConfig, View};
use crate::fault::{self, Fault};
use crate::{Event, Phase, Rejection, Report, Stream};

/// An estimate with what speaks for it.
#[derive(Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) estimate: Estimate,
    pub(crate) support: Support,
}

/// M11 and M12, keeping: all trials of a search; the label is one that no point has.
pub(crate) fn candidates(
    view: &View,
    labels: &[u8],
    label: u8,
    config: &MapConfig,
    stream: &mut Stream,
    report: &mut Report,
    observe: &mut dyn FnMut(Event),
) -> Vec<Candidate> {
    let mut kept = Vec::new();
    for _ in 0..config.hypotheses {
        report.trials += 1;
        match trial(view, labels, label, config, &kept, stream, observe) {
            Ok(candidate) => {
                report.scored += 1;
                observe(Event::Support(candidate.support));
                keep(&mut kept, candidate, config);
            }
            Err(rejection) => {
                report.rejections.count(rejection);
                observe(Event::Rejected(rejection));
            }
        }
    }
    kept
}

/// M11: a hypothesis and its support, which must exceed that of the last candidate kept.
fn trial(
    view: &View,
    labels: &[u8],
    label: u8,
    config: &MapConfig,
    kept: &[Candidate],
    stream: &mut Stream,
    observe: &mut dyn FnMut(Event),
) -> Result<Candidate, Rejection> {
    let estimate = hypothesis(view, labels, config, stream, observe)?;
    let members = listed(view, estimate.centre, 1.25 * config.long());
    let floor =
        if kept.len() >= config.kept { kept[kept.len() - 1].support.score } else { f32::NEG_INFINITY };
    let evidence = Evidence { view, labels, members: &members, label };
    let support = support(&estimate, evidence, &Terms::assumed(config), floor).ok_or(Rejection::Support)?;
    Ok(Candidate { estimate, support })
}

/// M12: whether two estimates are the same fruit, for a distance and the cosine of an angle.
fn same(a: &Estimate, b: &Estimate, n: f32, cosine: f32) -> bool {
    apart2(a, b) < n * n && libm::fabsf(dot(a.axes[0], b.axes[0])) > cosine
}

/// M12, keeping.
fn keep(kept: &mut Vec<Candidate>, new: Candidate, config: &MapConfig) {
    let worse = |old: &Candidate| old.support.score < new.support.score;
    let first_same =
        kept.iter().position(|old| same(&old.estimate, &new.estimate, 0.28 * config.short(), 0.94));
    if let Some(position) = first_same {
        if !worse(&kept[position]) {
            return;
        }
        kept.remove(position);
    } else if kept.len() >= config.kept {
        if !worse(&kept[kept.len() - 1]) {
            return;
        }
        kept.pop();
    }
    let place = kept.iter().position(worse).unwrap_or(kept.len());
    kept.insert(place, new);
}

/// M12, refinement: what is left of the candidates, refined.
pub(crate) fn refined(
    mut list: Vec<Candidate>,
    view: &View,
    labels: &[u8],
    label: u8,
    config: &MapConfig,
    observe: &mut dyn FnMut(Event),
) -> Vec<Candidate> {
    if fault::is(Fault::Keeping) && list.len() > 1 {
        list.swap(0, 1);
    }
    let mut done: Vec<Candidate> = Vec::new();
    for candidate in list {
        done.extend(refine(candidate, &done, view, labels, label, config, observe));
    }
    done
}

/// M12: a candidate after its steps; none where it becomes one of those that are done.
fn refine(
    mut candidate: Candidate,
    done: &[Candidate],
    view: &View,
    labels: &[u8],
    label: u8,
    config: &MapConfig,
    observe: &mut dyn FnMut(Event),
) -> Option<Candidate> {
    let terms = Terms::assumed(config);
    let members = listed(view, candidate.estimate.centre, 1.25 * config.long());
    let evidence = Evidence { view, labels, members: &members, label };
    let mut number = 0;
    loop {
        number += 1;
        let before = candidate.estimate;
        let taken = step(&before, &normal_equations(&before, evidence, &terms, Kernel::GemanMcClure(4.0)));
        let moved = taken.unwrap_or(before);
        observe(Event::Estimate(Phase::Refined, moved));
        if done.iter().any(|other| same(&other.estimate, &moved, 0.1 * config.short(), 0.985)) {
            return None;
        }
        candidate.estimate = moved;
        let limit = if fault::is(Fault::Refinement) { 0.04 } else { 0.01 };
        if taken.is_none() || apart2(&moved, &before) < limit || number == config.refine_steps {
            if let Some(new) = support(&moved, evidence, &terms, f32::NEG_INFINITY) {
                candidate.support = new;
            }
            observe(Event::Support(candidate.support));
            return Some(candidate);
        }
    }
}
