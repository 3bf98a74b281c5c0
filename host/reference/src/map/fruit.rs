//! A search from its candidates to a fruit, and the claim of its points: contract, chapters M13 and M15.

use super::candidates::{Candidate, candidates, refined};
use super::contact::{Contact, Kernel};
use super::evidence::{Evidence, listed};
use super::model::{Estimate, Model, apart2};
use super::noise::estimated;
use super::normal::normal_equations;
use super::prior::Terms;
use super::step::step;
use super::view::{MapConfig, View};
use crate::fault::{self, Fault};
use crate::{Event, Phase, Report, Score, Stream, live_points};

/// M16: how a fruit stands among the others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Standing {
    Alone,
    Contested,
    Ghost,
    Accepted,
}

/// A fruit that was found, before it is judged.
pub(crate) struct Fruit {
    pub(crate) label: u8,
    pub(crate) estimate: Estimate,
    pub(crate) terms: Terms,
    pub(crate) score: f32,
    pub(crate) rival: f32,
    pub(crate) report: Report,
    /// Live points before it was found.
    pub(crate) candidates: u32,
    pub(crate) standing: Standing,
}

/// M11 to M14: one search. Its report tells what it did when it ends with nothing.
pub(crate) fn search(
    view: &View,
    labels: &[u8],
    label: u8,
    config: &MapConfig,
    stream: &mut Stream,
    observe: &mut dyn FnMut(Event),
) -> Result<Fruit, Report> {
    let mut report = Report { bound: config.hypotheses, ..Report::default() };
    let list = candidates(view, labels, label, config, stream, &mut report, observe);
    let list = refined(list, view, labels, label, config, observe);
    let Some((best, rival)) = choice(&list, config) else { return Err(report) };
    let Candidate { estimate, support } = best;
    report.support = Score { inliers: support.explained, candidates: support.explained + support.through };
    let assumed = Terms::assumed(config);
    let members = listed(view, estimate.centre, 1.25 * config.long());
    let evidence = Evidence { view, labels, members: &members, label };
    let shown = estimated(&estimate, evidence, &assumed);
    observe(Event::Noise(shown.noise));
    let terms = shown.entered(Terms { boxiness: config.boxiness, ..assumed });
    let (estimate, terms) = final_fit(estimate, evidence, terms, config, observe);
    Ok(Fruit {
        label,
        estimate,
        terms,
        score: support.score,
        rival,
        report,
        candidates: live_points(labels).len() as u32,
        standing: Standing::Alone,
    })
}

/// M13: the best of the refined candidates and the rival share; nothing if it explains too little.
fn choice(list: &[Candidate], config: &MapConfig) -> Option<(Candidate, f32)> {
    let mut best = *list.first()?;
    for candidate in list {
        if candidate.support.score > best.support.score && !fault::is(Fault::Choice) {
            best = *candidate;
        }
    }
    if best.support.explained < u32::from(config.gate.min_points) {
        return None;
    }
    let (n, f) = (0.28 * config.short(), 1.65 * config.short());
    let mut rival = 0.0;
    for candidate in list {
        let d2 = apart2(&candidate.estimate, &best.estimate);
        let aside = d2 > n * n && d2 < f * f || fault::is(Fault::Rival);
        if aside && candidate.support.score > rival {
            rival = candidate.support.score;
        }
    }
    let share = if best.support.score > 0.0 { rival / best.support.score } else { 1.0 };
    Some((best, share))
}

/// M13, final fit.
fn final_fit(
    mut estimate: Estimate,
    evidence: Evidence,
    mut terms: Terms,
    config: &MapConfig,
    observe: &mut dyn FnMut(Event),
) -> (Estimate, Terms) {
    let mut i = 0;
    loop {
        let before = estimate;
        let taken = step(&before, &normal_equations(&before, evidence, &terms, Kernel::Tukey(16.0)));
        estimate = taken.unwrap_or(before);
        observe(Event::Estimate(Phase::Final, estimate));
        let settled = taken.is_none() || apart2(&estimate, &before) < 0.0004;
        if (settled && i > 2) || i + 1 >= config.final_steps {
            return (estimate, terms);
        }
        if i == 1 {
            terms = estimated(&estimate, evidence, &Terms::assumed(config)).entered(terms);
            observe(Event::Noise(terms.noise));
        }
        i += 1;
    }
}

/// M15: the points that a fruit claims, ascending.
pub(crate) fn claimed(view: &View, labels: &[u8], fruit: &Fruit, config: &MapConfig) -> Vec<u16> {
    let assumed = Terms::assumed(config);
    let model = Model::new(&fruit.estimate, assumed.noise, assumed.viewpoint);
    let limit = if fault::is(Fault::Claim) { 6.25 } else { 12.5 };
    let mut claimed = Vec::new();
    for (index, &p) in view.points.iter().enumerate() {
        let contact = Contact::new(&model, p);
        if labels[index] == 0 && contact.f2() < limit && contact.within(assumed.window) {
            claimed.push(index as u16);
        }
    }
    claimed
}
