//! The search for one fruit: the most probable body of known size behind one-sided points.
//!
//! One bounded piece of work per [`MapSearch::step`]:
//! 1. *Hypotheses*, a fixed number: seed point, neighbourhood, eight points, [`crate::hypothesis`], support
//!    ([`crate::visibility`]); the best few that differ are kept, and a count is given up as soon as it cannot enter.
//! 2. *Refinement* of each of these with Geman-McClure weights ([`crate::refine`]), and its support again.
//! 3. The best is taken; the noise is estimated from its residuals; *final* steps with Tukey's weights.

use heapless::Vec;

use super::{FINAL_KERNEL, Fruit, REACH, SETTLED_SQUARED, Scale, distance_squared, noise::shown_noise};
use crate::{
    Config, Observer, Point3, Rejection, Score, Stage, VarsacReport,
    field::Field,
    hypothesis::{SAMPLE, hypothesis},
    point::at,
    refine::{Estimate, Evidence, Kernel, Terms},
    residual::dot,
    visibility::Support,
};

/// Most hypotheses that may be kept for refinement.
pub(crate) const MAX_KEPT: usize = 8;

/// A kept hypothesis.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    estimate: Estimate,
    support: Support,
}

/// What the search is doing.
#[derive(Debug, Clone, Copy)]
enum Doing {
    Hypotheses,
    Refine { candidate: u8, steps: u8 },
    Final { best: Candidate, terms: Terms, steps: u8 },
}

/// What one step came to.
#[allow(clippy::large_enum_variant, reason = "no heap to box into; it lives for the length of one call")]
pub(crate) enum Progress {
    Working,
    /// Nothing was found.
    Nothing,
    Found(Fruit),
}

/// The state of one search between two steps.
#[derive(Debug, Clone)]
pub(crate) struct MapSearch {
    pub(crate) report: VarsacReport,
    doing: Doing,
    kept: Vec<Candidate, MAX_KEPT>,
    terms: Terms,
    scale: Scale,
    /// Points in `scratch.members`.
    members: usize,
    rival: f32,
}

/// Sampling radius in units of the longest semi-axis.
const SAMPLING: f32 = 0.92;
/// Two hypotheses whose centres are within this part of the shortest semi-axis and whose long axes are within about
/// 20 degrees are one.
const SAME_CENTRE: f32 = 0.28;
const SAME_AXIS: f32 = 0.94;
/// A candidate within this of one already refined (centre in units of the shortest semi-axis, cosine of the long axes)
/// ends there too.
const MERGED_CENTRE: f32 = 0.1;
const MERGED_AXIS: f32 = 0.985;
/// Rivals are further than this from the best (units of the shortest semi-axis) and nearer than that (same).
const RIVAL: (f32, f32) = (0.28, 1.65);
/// `2^2`.
const REFINE_KERNEL: Kernel = Kernel::GemanMcClure(4.0);
/// A step of the centre shorter than this (mm, squared) ends the refinement of a candidate.
const REFINED_SQUARED: f32 = 0.01;

impl MapSearch {
    pub(crate) fn new(config: &Config, terms: &Terms, scale: Scale) -> Self {
        Self {
            report: VarsacReport { bound: u32::from(config.map.hypotheses), ..VarsacReport::default() },
            doing: Doing::Hypotheses,
            kept: Vec::new(),
            terms: *terms,
            scale,
            members: 0,
            rival: 0.0,
        }
    }

    /// One bounded piece of work. `order` of the scratch holds the tree over all points of the cloud.
    pub(crate) fn step(&mut self, field: &mut Field<'_>, observer: &mut impl Observer) -> Progress {
        match self.doing {
            Doing::Hypotheses => {
                self.trial(field, observer);
                if self.report.trials >= self.report.bound {
                    if self.kept.is_empty() {
                        return Progress::Nothing;
                    }
                    self.doing = Doing::Refine { candidate: 0, steps: 0 };
                }
                Progress::Working
            }
            Doing::Refine { candidate, steps } => self.refine(field, candidate, steps, observer),
            Doing::Final { best, terms, steps } => self.finish(field, best, &terms, steps, observer),
        }
    }

    /// One hypothesis.
    fn trial(&mut self, field: &mut Field<'_>, observer: &mut impl Observer) {
        self.report.trials += 1;
        match self.hypothesis(field, observer) {
            Ok(()) => self.report.scored += 1,
            Err(reason) => {
                observer.rejected(reason);
                if let Some(counter) = self.report.rejections.get_mut(reason as usize) {
                    *counter += 1;
                }
            }
        }
    }

    fn hypothesis(&mut self, field: &mut Field<'_>, observer: &mut impl Observer) -> Result<(), Rejection> {
        let (cloud, in_mask) = (field.view.cloud, field.view.in_mask);
        let rank = field.stream.below(field.seeds);
        let labels = field.scratch.labels.get(..in_mask).unwrap_or(&[]);
        let seed = labels.iter().enumerate().filter(|&(_, &label)| label == 0).nth(rank as usize);
        let seed = seed.map_or(0, |(index, _)| index as u16);
        observer.seed_point(seed);
        let seed = at(cloud, seed);
        let count = field.list_within(&seed, SAMPLING * self.scale.long);
        // Only unclaimed points of the mask are sampled: squeeze out the others.
        let mut usable = 0;
        for k in 0..count {
            let index = field.scratch.members.get(k).copied().unwrap_or(0);
            let live =
                field.scratch.labels.get(usize::from(index)) == Some(&0) && usize::from(index) < in_mask;
            if live && let Some(slot) = field.scratch.members.get_mut(usable) {
                *slot = index;
                usable += 1;
            }
        }
        let members = field.scratch.members.get(..usable).unwrap_or(&[]);
        observer.neighbourhood(members);
        let mut sample = [0_u16; SAMPLE];
        if !field.stream.sample(members.len() as u32, &mut sample) {
            return Err(Rejection::TooFewPoints);
        }
        for position in &mut sample {
            *position = members.get(usize::from(*position)).copied().unwrap_or(0);
        }
        observer.sample(&sample);
        let estimate = hypothesis(cloud, &sample, &seed, &self.terms, field.config.map.hypothesis_steps)
            .ok_or(Rejection::Degenerate)?;
        observer.estimate(Stage::Hypothesis, &estimate);
        let limit = usize::from(field.config.map.kept);
        let floor = match self.kept.last() {
            Some(worst) if self.kept.len() >= limit => worst.support.score,
            _ => f32::NEG_INFINITY,
        };
        let evidence = self.gather(field, &estimate);
        let support = evidence.support(&estimate, &self.terms, floor).ok_or(Rejection::Support)?;
        observer.support(&support);
        self.keep(Candidate { estimate, support }, limit);
        Ok(())
    }

    /// Lists the points within reach of the model.
    fn gather<'a>(&mut self, field: &'a mut Field<'_>, estimate: &Estimate) -> Evidence<'a> {
        let [x, y, z] = estimate.centre;
        self.members = field.list_within(&Point3::new(x, y, z), REACH * self.scale.long);
        self.evidence(field)
    }

    /// The points listed before.
    fn evidence<'a>(&self, field: &'a Field<'_>) -> Evidence<'a> {
        Evidence::of(field, self.members, field.targets + 1)
    }

    /// Keeps the best few that differ, best first; of equal scores the earlier one stays ahead.
    fn keep(&mut self, new: Candidate, limit: usize) {
        let near = SAME_CENTRE * self.scale.short;
        let same = |old: &Candidate| {
            distance_squared(&old.estimate, &new.estimate) < near * near
                && libm::fabsf(dot(old.estimate.axes[0], new.estimate.axes[0])) > SAME_AXIS
        };
        let better = |old: &Candidate| !(old.support.score < new.support.score);
        if let Some(position) = self.kept.iter().position(same) {
            if self.kept.get(position).is_some_and(better) {
                return;
            }
            self.drop_kept(position);
        } else if self.kept.len() >= limit || self.kept.is_full() {
            if self.kept.last().is_some_and(better) {
                return;
            }
            self.kept.pop();
        }
        let position = self.kept.iter().position(|old| !better(old));
        let _ = self.kept.insert(position.unwrap_or(self.kept.len()), new);
    }

    /// Takes one out; the others keep their order. (`Vec::remove` would keep a panic.)
    fn drop_kept(&mut self, position: usize) {
        let mut at = 0;
        self.kept.retain(|_| {
            at += 1;
            at != position + 1
        });
    }

    /// One step of one candidate; after the last of all the best goes on.
    fn refine(
        &mut self,
        field: &mut Field<'_>,
        candidate: u8,
        steps: u8,
        observer: &mut impl Observer,
    ) -> Progress {
        let Some(&Candidate { estimate, support }) = self.kept.get(usize::from(candidate)) else {
            return self.choose(field, observer);
        };
        let most = field.config.map.refine_steps;
        let evidence = if steps == 0 { self.gather(field, &estimate) } else { self.evidence(field) };
        let next = estimate.step(&evidence.normal(&estimate, &self.terms, REFINE_KERNEL));
        let moved = next.unwrap_or(estimate);
        observer.estimate(Stage::Refined, &moved);
        // On its way to where another one has already been: no need to go there twice.
        let near = MERGED_CENTRE * self.scale.short;
        let merged = self.kept.iter().take(usize::from(candidate)).any(|other| {
            distance_squared(&other.estimate, &moved) < near * near
                && libm::fabsf(dot(other.estimate.axes[0], moved.axes[0])) > MERGED_AXIS
        });
        if merged {
            self.drop_kept(usize::from(candidate));
            self.doing = Doing::Refine { candidate, steps: 0 };
            return Progress::Working;
        }
        let settled = next.is_none() || distance_squared(&moved, &estimate) < REFINED_SQUARED;
        let last = settled || steps + 1 >= most;
        let support = if last {
            evidence.support(&moved, &self.terms, f32::NEG_INFINITY).unwrap_or(support)
        } else {
            support
        };
        if last {
            observer.support(&support);
        }
        if let Some(slot) = self.kept.get_mut(usize::from(candidate)) {
            *slot = Candidate { estimate: moved, support };
        }
        self.doing = if last {
            Doing::Refine { candidate: candidate + 1, steps: 0 }
        } else {
            Doing::Refine { candidate, steps: steps + 1 }
        };
        Progress::Working
    }

    /// The best of the refined candidates (the first of equals), its rival, and the noise of its residuals.
    fn choose(&mut self, field: &mut Field<'_>, observer: &mut impl Observer) -> Progress {
        let mut best: Option<Candidate> = None;
        for &candidate in &self.kept {
            if best.is_none_or(|best| candidate.support.score > best.support.score) {
                best = Some(candidate);
            }
        }
        let Some(best) = best else { return Progress::Nothing };
        if best.support.explained < field.config.map.gate.min_points {
            return Progress::Nothing;
        }
        let (near, far) = (RIVAL.0 * self.scale.short, RIVAL.1 * self.scale.short);
        let mut rival = 0.0;
        for other in &self.kept {
            let apart = distance_squared(&other.estimate, &best.estimate);
            if apart > near * near && apart < far * far && other.support.score > rival {
                rival = other.support.score;
            }
        }
        self.rival = if best.support.score > 0.0 { rival / best.support.score } else { 1.0 };
        let Support { explained, through, .. } = best.support;
        self.report.support =
            Score { inliers: u32::from(explained), candidates: u32::from(explained) + u32::from(through) };
        let evidence = self.gather(field, &best.estimate);
        let shown = shown_noise(&evidence, &best.estimate, &self.terms);
        observer.noise(&shown.noise);
        let terms = Terms { boxiness: field.config.map.boxiness, ..shown };
        self.doing = Doing::Final { best, terms, steps: 0 };
        Progress::Working
    }

    /// One step of the best; the noise is looked at once more after the second.
    fn finish(
        &mut self,
        field: &mut Field<'_>,
        best: Candidate,
        terms: &Terms,
        steps: u8,
        observer: &mut impl Observer,
    ) -> Progress {
        let evidence = self.evidence(field);
        let next = best.estimate.step(&evidence.normal(&best.estimate, terms, FINAL_KERNEL));
        let moved = next.unwrap_or(best.estimate);
        observer.estimate(Stage::Final, &moved);
        let settled = next.is_none() || distance_squared(&moved, &best.estimate) < SETTLED_SQUARED;
        if (settled && steps > 2) || steps + 1 >= field.config.map.final_steps {
            return Progress::Found(Fruit {
                estimate: moved,
                terms: *terms,
                score: best.support.score,
                rival: self.rival,
                report: self.report,
                candidates: field.live,
                standing: super::Standing::Alone,
            });
        }
        let mut terms = *terms;
        if steps == 1 {
            let shown = shown_noise(&evidence, &moved, &self.terms);
            observer.noise(&shown.noise);
            terms = Terms { boxiness: terms.boxiness, ..shown };
        }
        let best = Candidate { estimate: moved, ..best };
        self.doing = Doing::Final { best, terms, steps: steps + 1 };
        Progress::Working
    }
}
