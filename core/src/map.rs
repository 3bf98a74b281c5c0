//! The default search for one target: the most probable fruit of known size behind one-sided points.
//!
//! One bounded piece of work per [`MapSearch::step`]:
//! 1. *Hypotheses*, a fixed number: seed point, neighbourhood, eight points, [`crate::hypothesis`], support
//!    ([`crate::visibility`]); the best few that differ are kept, and a count is given up as soon as it cannot enter.
//! 2. *Refinement* of each of these with Geman-McClure weights ([`crate::refine`]), and its support again.
//! 3. The best is taken; the noise is estimated from its residuals; *final* steps with Tukey's weights.
//! 4. The same with the size set almost free: what the size prior costs ([`crate::accept`]).
//! 5. Covariance, findings.

use heapless::Vec;

use crate::{
    Config, Ellipsoid, Observer, Point3, Rejection, Score, VarsacReport,
    accept::Findings,
    covariance::{Covariance, covariance},
    detect::View,
    hypothesis::{SAMPLE, hypothesis},
    jacobi::{Symmetric3, eigen},
    kdtree,
    point::at,
    prior::{SizePrior, SizeTerm},
    refine::{Estimate, Evidence, Kernel, Terms},
    residual::{Noise, RayModel, dot},
    rng::Stream,
    size::size_evidence,
    visibility::{CUT, Sight, Support, predicted_pixels, sight},
    workspace::Scratch,
};

/// Most hypotheses that may be kept for refinement.
pub const MAX_KEPT: usize = 8;

/// A kept hypothesis.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    estimate: Estimate,
    support: Support,
}

/// What the search is doing.
#[derive(Debug, Clone, Copy)]
enum Stage {
    Hypotheses,
    Refine { candidate: u8, steps: u8 },
    Final { estimate: Estimate, terms: Terms, steps: u8 },
    Loose { best: Estimate, terms: Terms, free: Estimate, steps: u8 },
}

/// What one step came to.
#[allow(clippy::large_enum_variant, reason = "no heap to box into; it lives for the length of one call")]
pub(crate) enum Progress {
    Working,
    /// Nothing was found.
    Nothing,
    Found(Solution),
}

/// The result of a search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Solution {
    pub(crate) ellipsoid: Ellipsoid,
    pub(crate) covariance: Option<Covariance>,
    pub(crate) findings: Findings,
    pub(crate) terms: Terms,
    pub(crate) support: Support,
}

/// The state of one search between two steps.
#[derive(Debug, Clone)]
pub(crate) struct MapSearch {
    pub(crate) report: VarsacReport,
    stage: Stage,
    kept: Vec<Candidate, MAX_KEPT>,
    terms: Terms,
    loose: SizeTerm,
    /// Semi-axes of the prior, longest and shortest, mm.
    long: f32,
    short: f32,
    /// Points in `scratch.members`.
    members: usize,
    rival: f32,
    boxiness: f32,
}

/// Sampling radius in units of the longest semi-axis.
const SAMPLING: f32 = 0.92;
/// Reach of the points that bear on a model, from its centre, in units of the longest semi-axis.
const REACH: f32 = 1.25;
/// Window along the ray in units of the shortest semi-axis.
const WINDOW: f32 = 0.55;
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
/// `2^2` and `4^2`.
const REFINE_KERNEL: Kernel = Kernel::GemanMcClure(4.0);
const FINAL_KERNEL: Kernel = Kernel::Tukey(16.0);

impl MapSearch {
    pub(crate) fn new(config: &Config) -> Self {
        let map = &config.map;
        let report = VarsacReport { bound: u32::from(map.hypotheses), ..VarsacReport::default() };
        let [long, _, short] = map.prior.semi_axes_mm;
        let terms = Terms {
            prior: map.prior.term(),
            noise: map.noise,
            viewpoint: map.viewpoint,
            window_mm: WINDOW * short,
            offset_rad: map.outline_offset_px * map.pixel_rad,
            boxiness: 0.0,
        };
        let loose =
            SizePrior { spread: [1.0; 3], spread_ab: f32::INFINITY, spread_bc: f32::INFINITY, ..map.prior };
        Self {
            report,
            stage: Stage::Hypotheses,
            kept: Vec::new(),
            terms,
            loose: loose.term(),
            long,
            short,
            members: 0,
            rival: 0.0,
            boxiness: map.boxiness,
        }
    }

    /// One bounded piece of work. `order` of the scratch holds the tree over all points of the cloud.
    pub(crate) fn step(
        &mut self,
        config: &Config,
        view: &View<'_>,
        live: u32,
        scratch: &mut Scratch<'_>,
        stream: &mut Stream,
        observer: &mut impl Observer,
    ) -> Progress {
        match self.stage {
            Stage::Hypotheses => {
                self.trial(config, view, live, scratch, stream, observer);
                if self.report.trials >= self.report.bound {
                    if self.kept.is_empty() {
                        return Progress::Nothing;
                    }
                    self.stage = Stage::Refine { candidate: 0, steps: 0 };
                }
                Progress::Working
            }
            Stage::Refine { candidate, steps } => self.refine(config, view, scratch, candidate, steps),
            Stage::Final { estimate, terms, steps } => {
                self.finish(config, view, scratch, &estimate, &terms, steps);
                Progress::Working
            }
            Stage::Loose { best, terms, free, steps } => {
                self.set_free(config, view, scratch, &best, &terms, &free, steps)
            }
        }
    }

    /// One hypothesis.
    fn trial(
        &mut self,
        config: &Config,
        view: &View<'_>,
        live: u32,
        scratch: &mut Scratch<'_>,
        stream: &mut Stream,
        observer: &mut impl Observer,
    ) {
        self.report.trials += 1;
        match self.hypothesis(config, view, live, scratch, stream, observer) {
            Ok(()) => self.report.scored += 1,
            Err(reason) => {
                observer.rejected(reason);
                if let Some(counter) = self.report.rejections.get_mut(reason as usize) {
                    *counter += 1;
                }
            }
        }
    }

    fn hypothesis(
        &mut self,
        config: &Config,
        view: &View<'_>,
        live: u32,
        scratch: &mut Scratch<'_>,
        stream: &mut Stream,
        observer: &mut impl Observer,
    ) -> Result<(), Rejection> {
        let rank = stream.below(live);
        let labels = scratch.labels.get(..view.in_mask).unwrap_or(&[]);
        let seed = labels.iter().enumerate().filter(|&(_, &label)| label == 0).nth(rank as usize);
        let seed = seed.map_or(0, |(index, _)| index as u16);
        observer.seed_point(seed);
        let seed = at(view.cloud, seed);
        let count = list_within(view.cloud, scratch, &seed, SAMPLING * self.long);
        // Live points of the mask come first in the order of sampling: squeeze out the others.
        let mut usable = 0;
        for k in 0..count {
            let index = scratch.members.get(k).copied().unwrap_or(0);
            let live =
                scratch.labels.get(usize::from(index)) == Some(&0) && usize::from(index) < view.in_mask;
            if live && let Some(slot) = scratch.members.get_mut(usable) {
                *slot = index;
                usable += 1;
            }
        }
        let members = scratch.members.get(..usable).unwrap_or(&[]);
        observer.neighbourhood(members);
        let mut sample = [0_u16; SAMPLE];
        if !stream.sample(members.len() as u32, &mut sample) {
            return Err(Rejection::TooFewPoints);
        }
        for position in &mut sample {
            *position = members.get(usize::from(*position)).copied().unwrap_or(0);
        }
        observer.sample(&sample);
        let estimate = hypothesis(view.cloud, &sample, &seed, &self.terms, config.map.hypothesis_steps)
            .ok_or(Rejection::Degenerate)?;
        let floor = if self.kept.len() < usize::from(config.map.kept) {
            f32::NEG_INFINITY
        } else {
            self.kept.last().map_or(f32::NEG_INFINITY, |worst| worst.support.score)
        };
        let evidence = self.gather(view, scratch, &estimate);
        let support = evidence.support(&estimate, &self.terms, floor).ok_or(Rejection::Support)?;
        self.keep(Candidate { estimate, support }, usize::from(config.map.kept));
        Ok(())
    }

    /// Lists the points within reach of the model.
    fn gather<'a>(
        &mut self,
        view: &View<'a>,
        scratch: &'a mut Scratch<'_>,
        estimate: &Estimate,
    ) -> Evidence<'a> {
        let [x, y, z] = estimate.centre;
        self.members = list_within(view.cloud, scratch, &Point3::new(x, y, z), REACH * self.long);
        self.evidence(view, scratch)
    }

    /// The points listed before.
    fn evidence<'a>(&self, view: &View<'a>, scratch: &'a Scratch<'_>) -> Evidence<'a> {
        Evidence {
            cloud: view.cloud,
            members: scratch.members.get(..self.members).unwrap_or(&[]),
            labels: scratch.labels,
            outline: view.outline,
        }
    }

    /// Keeps the best few that differ, best first; of equal scores the earlier one stays ahead.
    fn keep(&mut self, new: Candidate, limit: usize) {
        let limit = if limit < MAX_KEPT { limit } else { MAX_KEPT };
        let near = SAME_CENTRE * self.short;
        let same = |old: &Candidate| {
            distance_squared(&old.estimate, &new.estimate) < near * near
                && libm::fabsf(dot(old.estimate.axes[0], new.estimate.axes[0])) > SAME_AXIS
        };
        if let Some(position) = self.kept.iter().position(same) {
            if self.kept[position].support.score >= new.support.score {
                return;
            }
            self.kept.remove(position);
        } else if self.kept.len() >= limit {
            if self.kept.last().is_some_and(|worst| worst.support.score >= new.support.score) {
                return;
            }
            self.kept.pop();
        }
        let position = self.kept.iter().position(|old| old.support.score < new.support.score);
        let _ = self.kept.insert(position.unwrap_or(self.kept.len()), new);
    }

    /// One step of one candidate; after the last of all the best goes on.
    fn refine(
        &mut self,
        config: &Config,
        view: &View<'_>,
        scratch: &mut Scratch<'_>,
        candidate: u8,
        steps: u8,
    ) -> Progress {
        let Some(&Candidate { estimate, support }) = self.kept.get(usize::from(candidate)) else {
            return self.choose(view, scratch);
        };
        let evidence =
            if steps == 0 { self.gather(view, scratch, &estimate) } else { self.evidence(view, scratch) };
        let normal = evidence.normal(&estimate, &self.terms, REFINE_KERNEL);
        let next = estimate.step(&normal);
        let moved = next.unwrap_or(estimate);
        // On its way to where another one has already been: no need to go there twice.
        let near = MERGED_CENTRE * self.short;
        let merged = self.kept.iter().take(usize::from(candidate)).any(|other| {
            distance_squared(&other.estimate, &moved) < near * near
                && libm::fabsf(dot(other.estimate.axes[0], moved.axes[0])) > MERGED_AXIS
        });
        if merged {
            self.kept.remove(usize::from(candidate));
            self.stage = Stage::Refine { candidate, steps: 0 };
            return Progress::Working;
        }
        let settled = next.is_none() || distance_squared(&moved, &estimate) < REFINED_SQUARED;
        let last = settled || steps + 1 >= config.map.refine_steps;
        let support = if last {
            evidence.support(&moved, &self.terms, f32::NEG_INFINITY).unwrap_or(support)
        } else {
            support
        };
        if let Some(slot) = self.kept.get_mut(usize::from(candidate)) {
            *slot = Candidate { estimate: moved, support };
        }
        self.stage = if last {
            Stage::Refine { candidate: candidate + 1, steps: 0 }
        } else {
            Stage::Refine { candidate, steps: steps + 1 }
        };
        Progress::Working
    }

    /// The best of the refined candidates, its rival, and the noise of its residuals.
    fn choose(&mut self, view: &View<'_>, scratch: &mut Scratch<'_>) -> Progress {
        let mut best: Option<Candidate> = None;
        for &candidate in &self.kept {
            if best.is_none_or(|best| candidate.support.score > best.support.score) {
                best = Some(candidate);
            }
        }
        let Some(best) = best else { return Progress::Nothing };
        let (near, far) = (RIVAL.0 * self.short, RIVAL.1 * self.short);
        let mut rival = 0.0;
        for other in &self.kept {
            let apart = distance_squared(&other.estimate, &best.estimate);
            if apart > near * near && apart < far * far && other.support.score > rival {
                rival = other.support.score;
            }
        }
        self.rival = if best.support.score > 0.0 { rival / best.support.score } else { 1.0 };
        self.report.support = Score {
            inliers: u32::from(best.support.explained),
            candidates: u32::from(best.support.explained) + u32::from(best.support.through),
        };
        let evidence = self.gather(view, scratch, &best.estimate);
        let terms = Terms {
            noise: shown_noise(&evidence, &best.estimate, &self.terms),
            boxiness: self.boxiness,
            ..self.terms
        };
        self.stage = Stage::Final { estimate: best.estimate, terms, steps: 0 };
        Progress::Working
    }

    fn finish(
        &mut self,
        config: &Config,
        view: &View<'_>,
        scratch: &mut Scratch<'_>,
        estimate: &Estimate,
        terms: &Terms,
        steps: u8,
    ) {
        let evidence = self.evidence(view, scratch);
        let normal = evidence.normal(estimate, terms, FINAL_KERNEL);
        let next = estimate.step(&normal);
        let moved = next.unwrap_or(*estimate);
        let settled = next.is_none() || distance_squared(&moved, estimate) < SETTLED_SQUARED;
        self.stage = if settled && steps > 2 || steps + 1 >= config.map.final_steps {
            Stage::Loose { best: moved, terms: *terms, free: moved, steps: 0 }
        } else {
            let terms = if steps == 1 {
                Terms { noise: shown_noise(&evidence, &moved, &self.terms), ..*terms }
            } else {
                *terms
            };
            Stage::Final { estimate: moved, terms, steps: steps + 1 }
        };
    }

    /// One step with the size set free; after the last, the findings.
    #[allow(clippy::too_many_arguments, reason = "the state of one stage")]
    fn set_free(
        &mut self,
        config: &Config,
        view: &View<'_>,
        scratch: &mut Scratch<'_>,
        best: &Estimate,
        terms: &Terms,
        free: &Estimate,
        steps: u8,
    ) -> Progress {
        let evidence = self.evidence(view, scratch);
        let loose = Terms { prior: self.loose, ..*terms };
        if steps < config.map.final_steps {
            let normal = evidence.normal(free, &loose, FINAL_KERNEL);
            let next = free.step(&normal);
            let moved = next.unwrap_or(*free);
            let settled = next.is_none() || distance_squared(&moved, free) < SETTLED_SQUARED;
            let steps = if settled { config.map.final_steps } else { steps + 1 };
            self.stage = Stage::Loose { best: *best, terms: *terms, free: moved, steps };
            return Progress::Working;
        }
        let normal = evidence.normal(best, terms, FINAL_KERNEL);
        let without = evidence.normal(free, &loose, FINAL_KERNEL);
        let size = size_evidence(&normal, &best.ln_axes, &without, &free.ln_axes, &terms.prior, &self.loose);
        let (ellipsoid, order) = best.sorted();
        let Some(support) = evidence.support(best, &self.terms, f32::NEG_INFINITY) else {
            return Progress::Nothing;
        };
        let (outline_rays, outline) = outline_fit(&evidence, &ellipsoid, best.boxiness, terms);
        let points = shape_of_points(&evidence, &ellipsoid, &self.terms, view.in_mask);
        let by = &config.map.inflation;
        let inflation = by.base + by.per_conflict * size.conflict + by.per_clutter * points.clutter;
        let covariance = covariance(&normal, best, &ellipsoid, order, inflation);
        let explained = f32::from(support.explained);
        let findings = Findings {
            explained: support.explained,
            through: support.through,
            size_conflict: size.conflict,
            size_sigma: size.sigma,
            rival: self.rival,
            outline_rays,
            outline,
            visible: explained / predicted_pixels(&ellipsoid, config.map.pixel_rad),
            colour: points.outside,
            sigma_mm: covariance.map_or(f32::INFINITY, |c| c.sigma_centre_max_mm()),
            flat: points.flat,
            separation: f32::INFINITY,
            clutter: points.clutter,
        };
        Progress::Found(Solution { ellipsoid, covariance, findings, terms: self.terms, support })
    }
}

/// Below this many points a look at each of them is the quicker way.
const SMALL_CLOUD: usize = 600;

/// Lists all points within `radius` of `centre` in `scratch.members`, ascending; returns how many. By the tree where
/// they are few, by looking at every point where sorting them would cost more: the list is the same.
fn list_within(cloud: &[Point3], scratch: &mut Scratch<'_>, centre: &Point3, radius: f32) -> usize {
    let tree = scratch.order.get(..cloud.len()).unwrap_or(&[]);
    let room = if cloud.len() < SMALL_CLOUD { 0 } else { cloud.len() / 8 };
    let few = scratch.members.get_mut(..room).unwrap_or(&mut []);
    kdtree::within(cloud, tree, centre, radius, few).unwrap_or_else(|| {
        let limit = radius * radius;
        let mut count = 0;
        for (index, point) in cloud.iter().enumerate() {
            if let Some(slot) = scratch.members.get_mut(count) {
                *slot = index as u16;
                count += usize::from(crate::point::distance_squared(point, centre) <= limit);
            }
        }
        count
    })
}

/// A step of the centre shorter than this (mm, squared) ends the refinement of a candidate, and of the best.
const REFINED_SQUARED: f32 = 0.01;
const SETTLED_SQUARED: f32 = 4e-4;

fn distance_squared(a: &Estimate, b: &Estimate) -> f32 {
    let d = [a.centre[0] - b.centre[0], a.centre[1] - b.centre[1], a.centre[2] - b.centre[2]];
    dot(d, d)
}

const BINS: usize = 64;
/// Bins per standard deviation: 64 over 2.5.
const BINS_PER_SIGMA: f32 = 25.6;
/// Median of |f| of a standard normal variable cut at 2.5.
const MEDIAN_SIGMA: f32 = 0.664;
/// Range of the scale: the camera is not ten times better than it says, and at three times worse there is no shape.
const SCALE: (f32, f32) = (0.2, 2.0);
/// Weight of the assumption, in points.
const ASSUMED: f32 = 6.0;

/// |f| of explained points, counted in bins.
struct Scatter {
    bins: [u16; BINS],
    count: u16,
}

impl Scatter {
    const EMPTY: Self = Self { bins: [0; BINS], count: 0 };

    fn add(&mut self, square: f32) {
        if let Some(bin) = self.bins.get_mut((libm::sqrtf(square) * BINS_PER_SIGMA) as usize) {
            *bin += 1;
            self.count += 1;
        }
    }

    /// Ratio to the assumed noise: the median, linear within its bin, drawn towards 1 as if ten points had said so.
    fn scale(&self) -> f32 {
        let count = f32::from(self.count);
        let half = 0.5 * count;
        let mut below = 0.0;
        let mut median = 0.0;
        for (k, &bin) in self.bins.iter().enumerate() {
            let next = below + f32::from(bin);
            if next >= half && bin > 0 {
                median = (k as f32 + (half - below) / f32::from(bin)) / BINS_PER_SIGMA;
                break;
            }
            below = next;
        }
        let scale = (count * (median / MEDIAN_SIGMA) + ASSUMED) / (count + ASSUMED);
        if scale < SCALE.0 {
            SCALE.0
        } else if scale > SCALE.1 {
            SCALE.1
        } else {
            scale
        }
    }
}

/// The noise that the residuals of a fit show: along the rays from points seen frontally, across them from those near the rim.
fn shown_noise(evidence: &Evidence<'_>, estimate: &Estimate, terms: &Terms) -> Noise {
    let model = RayModel::new(&estimate.ellipsoid(), &terms.noise, terms.viewpoint);
    let (mut axial, mut lateral) = (Scatter::EMPTY, Scatter::EMPTY);
    for &index in evidence.members {
        if !evidence.is_live(index) {
            continue;
        }
        let contact = model.contact(&at(evidence.cloud, index));
        if let Sight::Explained(square) = sight(&contact, terms.window_mm) {
            let share = model.lateral_share(&contact);
            if share < 0.4 {
                axial.add(square);
            } else if share > 0.6 {
                lateral.add(square);
            }
        }
    }
    let (axial, lateral) = (axial.scale(), lateral.scale());
    Noise { axial_mm: terms.noise.axial_mm * axial, lateral_rad: terms.noise.lateral_rad * lateral }
}

/// Outline rays that can be the model's, and the mean of `min(|f|, 3)` over them.
fn outline_fit(evidence: &Evidence<'_>, ellipsoid: &Ellipsoid, boxiness: f32, terms: &Terms) -> (u16, f32) {
    let model = RayModel::new(ellipsoid, &terms.noise, terms.viewpoint);
    let [long, _, short] = ellipsoid.semi_axes;
    let mut count = 0_u16;
    let mut sum = 0.0;
    for ray in evidence.outline {
        if let Some(touch) = ray.touch(&model, short, long, terms.noise.axial_mm) {
            let size = libm::sqrtf(touch.square(boxiness));
            sum += if size < 3.0 { size } else { 3.0 };
            count += 1;
        }
    }
    (count, if count == 0 { 0.0 } else { sum / f32::from(count) })
}

/// What the points near a model look like.
struct PointShape {
    /// Rms distance of the explained points from their best plane over their rms distance from the model.
    flat: f32,
    /// Share of the explained points outside the mask.
    outside: f32,
    /// Points near the model that it does not explain, over those it does.
    clutter: f32,
}

/// Unexplained points count as near within twice the window and `f^2 < 100`.
const CLUTTER_CUT: f32 = 100.0;

fn shape_of_points(
    evidence: &Evidence<'_>,
    ellipsoid: &Ellipsoid,
    terms: &Terms,
    in_mask: usize,
) -> PointShape {
    let model = RayModel::new(ellipsoid, &terms.noise, terms.viewpoint);
    let c = ellipsoid.centre;
    let near_mm = 2.0 * terms.window_mm;
    let (mut n, mut outside, mut near, mut model_sum) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    let mut sum = [0.0_f32; 3];
    let mut square = Symmetric3::default();
    for &index in evidence.members {
        if !evidence.is_live(index) {
            continue;
        }
        let p = at(evidence.cloud, index);
        let contact = model.contact(&p);
        let Sight::Explained(_) = sight(&contact, terms.window_mm) else {
            let close = contact.gap_mm < near_mm && contact.gap_mm > -near_mm;
            near += if close && contact.square() < CLUTTER_CUT { 1.0 } else { 0.0 };
            continue;
        };
        n += 1.0;
        outside += if usize::from(index) >= in_mask { 1.0 } else { 0.0 };
        model_sum += (contact.value * contact.value) / model.gradient_squared(contact.u);
        let (x, y, z) = (p.x - c.x, p.y - c.y, p.z - c.z);
        sum[0] += x;
        sum[1] += y;
        sum[2] += z;
        square.xx += x * x;
        square.yy += y * y;
        square.zz += z * z;
        square.xy += x * y;
        square.xz += x * z;
        square.yz += y * z;
    }
    if n < 1.0 {
        return PointShape { flat: 0.0, outside: 0.0, clutter: 0.0 };
    }
    let [x, y, z] = sum.map(|s| s / n);
    let scatter = Symmetric3 {
        xx: square.xx / n - x * x,
        yy: square.yy / n - y * y,
        zz: square.zz / n - z * z,
        xy: square.xy / n - x * y,
        xz: square.xz / n - x * z,
        yz: square.yz / n - y * z,
    };
    let ratio = eigen(&scatter).values[0] / (model_sum / n);
    let flat = if ratio > 0.0 { libm::sqrtf(ratio) } else { 0.0 };
    PointShape { flat, outside: outside / n, clutter: near / n }
}

/// True when the point lies on the model: explained under the assumed noise.
pub(crate) fn lies_on(model: &RayModel, point: &Point3, window_mm: f32) -> bool {
    let contact = model.contact(point);
    contact.square() < 2.0 * CUT && contact.gap_mm < window_mm && contact.gap_mm > -window_mm
}
