//! The search without a size prior: the most probable ellipsoid among points of any kind, by expectation-maximisation.
//!
//! Drawing nine points and hoping that all of them lie on the body is the weak way when more than half of the points do not.
//! Here every point counts with its probability to lie on the surface, and the surface moves until it explains
//! most. One bounded piece of work per [`MixtureSearch::step`]:
//!
//! 1. `frame`: the search's own frame and unit; a seeded random choice of points, the *sample*.
//! 2. For each start: a Gaussian `blob`, then the `shell` of the same moments, whose noise scale falls from a third of
//!    the body to what the points show, then a few steps with the scale free.
//! 3. The best few by likelihood (a large empty shell has a thin density, so no size limits are needed)
//!    are polished with the correction for curvature, `+ 1/2 sum(r) ln A`.
//! 4. The best goes on to all points with orthogonal distances (`foot`).
//! 5. Covariance and verdict (`judge`): an ellipsoid, or a plane, a pipe, a box, half a body, clutter?
//!
//! Bound on the work, in points looked at: [`MAX_START_STEPS`] times the sample for each start, [`KEPT`] times
//! [`POLISH_STEPS`] + 1 times the sample, and [`FINAL_STEPS`] + 2 times all points. A step looks at no more than that many points
//! once (the first one sorts them, `O(n log n)`).
//!
//! With a viewpoint the same search takes distances along the viewing rays ([`crate::residual`]), begins with the blobs pushed
//! back behind the surface that was seen, prefers round bodies by a little, and hears the points seen past the body and the
//! outline rays.

mod area;
mod blob;
mod climb;
mod config;
mod frame;
mod judge;
mod run;
mod shell;

use heapless::Vec;

pub use self::config::{MixtureConfig, MixtureGate};
pub use self::judge::MixtureFindings;
pub(crate) use self::run::MixtureRun;
use self::{
    area::ln_area,
    blob::{Blob, push_back},
    climb::{Place, SHARE, Scale, climb, hold, is_same, terms, within},
    frame::{Frame, shuffle_front},
    judge::findings,
    shell::{Data, Distance, Shell, smallest},
};
use crate::{
    Ellipsoid, View,
    accept::{Refusal, RefusalCode},
    covariance::{Covariance, covariance},
    point::at,
    refine::Estimate,
    residual::Viewpoint,
    rng::Stream,
    workspace::{Lists, Scratch},
};

/// Steps of the blob made from all points, and of the others.
const BLOB_STEPS: (u8, u8) = (20, 3);
/// Steps in which the scale of the noise is made to fall, and free steps after them.
const ANNEALED_STEPS: u8 = 16;
const FREE_STEPS: u8 = 6;
/// Step at which a start that is where another one has been is given up: it would end there too.
const WAYPOINT: u8 = 8;
/// Two estimates are one body, at the waypoint and at the end, see [`is_same`].
const SAME: (f32, f32) = (0.25, 0.1);
/// First scale over the geometric mean of (geometric mean, smallest semi-axis).
const FIRST_SCALE: f32 = 0.35;
/// The scale falls at least by this factor a step.
const COOLING: f32 = 0.8;
/// Smallest scale of the starts, and of the final steps; local units.
const LEAST_SCALE: (f32, f32) = (0.002, 0.0001);
/// Most starts.
pub const MAX_STARTS: usize = 16;
/// Candidates kept.
pub const KEPT: usize = 3;
/// Steps of each of them, and of the best over all points.
pub const POLISH_STEPS: u8 = 12;
/// See [`POLISH_STEPS`].
pub const FINAL_STEPS: u8 = 25;
/// Steps of one start at most.
pub const MAX_START_STEPS: u8 = BLOB_STEPS.0 + ANNEALED_STEPS + FREE_STEPS + 1;
/// A step that promises less than this gain (natural logarithm) is the last.
const SETTLED: f32 = 1e-3;
/// Fewer live points than this are not searched.
pub const MIN_POINTS: usize = 12;

/// What the search is doing.
#[derive(Debug, Clone, Copy)]
enum Stage {
    Begin,
    Blob { start: u8, steps: u8, blob: Blob },
    Shell { start: u8, steps: u8, shell: Shell, ln_area: f32 },
    Polish { candidate: u8, steps: u8 },
    Final { shell: Shell, steps: u8 },
    Measure { shell: Shell },
    Judge { shell: Shell, covariance: Option<Covariance> },
}

/// What one step came to.
#[allow(clippy::large_enum_variant, reason = "no heap to box into; it lives for the length of one call")]
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MixtureProgress {
    /// There is more to do.
    Working,
    /// Nothing was found, and why.
    Nothing(Refusal),
    /// The most probable ellipsoid.
    Found(MixtureSolution),
}

/// The result of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MixtureSolution {
    /// Frame and unit of the cloud.
    pub ellipsoid: Ellipsoid,
    /// None where the normal equations are singular.
    pub covariance: Option<Covariance>,
    /// Standard deviation of the points across the surface (along the ray with a viewpoint), unit of the cloud.
    pub sigma: f32,
    /// What the tests looked at.
    pub findings: MixtureFindings,
    /// The first test that failed.
    pub refusal: Option<Refusal>,
}

/// A kept candidate.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    shell: Shell,
    gain: f32,
}

/// The state of one search between two steps.
#[derive(Debug, Clone)]
pub struct MixtureSearch {
    stage: Stage,
    frame: Option<Frame>,
    distance: Distance,
    /// Live points: `members` of the scratch, ascending.
    live: usize,
    /// Points of the sample: the first of `order` of the scratch.
    sample: usize,
    kept: Vec<Candidate, KEPT>,
    /// Where the starts were at [`WAYPOINT`].
    passed: Vec<Place, MAX_STARTS>,
}

impl Default for MixtureSearch {
    fn default() -> Self {
        Self::new()
    }
}

impl MixtureSearch {
    /// At the beginning.
    pub fn new() -> Self {
        Self {
            stage: Stage::Begin,
            frame: None,
            distance: Distance::Radial,
            live: 0,
            sample: 0,
            kept: Vec::new(),
            passed: Vec::new(),
        }
    }

    /// One bounded piece of work on the live points of the view. The scratch is the search's own until it is over.
    pub fn step(
        &mut self,
        config: &MixtureConfig,
        view: &View<'_>,
        scratch: &mut Scratch<'_>,
        stream: &mut Stream,
    ) -> MixtureProgress {
        self.work(config, view, &mut scratch.lists, stream)
    }

    pub(crate) fn work(
        &mut self,
        config: &MixtureConfig,
        view: &View<'_>,
        scratch: &mut Lists<'_>,
        stream: &mut Stream,
    ) -> MixtureProgress {
        let Some(frame) = self.frame else { return self.begin(config, view, scratch, stream) };
        let list = match self.stage {
            Stage::Final { .. } | Stage::Measure { .. } | Stage::Judge { .. } => {
                scratch.members.get(..self.live)
            }
            _ => scratch.order.get(..self.sample),
        };
        let data = Data {
            cloud: view.cloud,
            list: list.unwrap_or(&[]),
            outline: view.outline,
            offset_rad: config.outline_offset_rad,
            frame: &frame,
            distance: self.distance,
        };
        match self.stage {
            Stage::Begin => {}
            Stage::Blob { start, steps, blob } => self.blob(config, view, &data, start, steps, &blob),
            Stage::Shell { start, steps, shell, ln_area } => {
                match Self::shell(config, &data, steps, &shell, ln_area) {
                    Some(_) if steps == WAYPOINT && self.is_known(&shell.estimate) => {
                        self.next_start(config, view, &data, start);
                    }
                    Some((shell, ln_area)) if steps + 1 < ANNEALED_STEPS + FREE_STEPS => {
                        self.stage = Stage::Shell { start, steps: steps + 1, shell, ln_area };
                    }
                    Some((shell, _)) => {
                        self.keep(Candidate { shell, gain: shell.gain(&data) });
                        self.next_start(config, view, &data, start);
                    }
                    None => self.next_start(config, view, &data, start),
                }
            }
            Stage::Polish { candidate, steps } => return self.polish(config, &data, candidate, steps),
            Stage::Final { shell, steps } => self.finish(config, &data, &shell, steps),
            Stage::Measure { shell } => {
                self.stage = Stage::Judge { shell, covariance: certainty(config, &data, &shell) };
            }
            Stage::Judge { shell, covariance } => {
                return MixtureProgress::Found(solution(config, &data, &shell, covariance.as_ref()));
            }
        }
        MixtureProgress::Working
    }

    /// Lists, frame, sample.
    fn begin(
        &mut self,
        config: &MixtureConfig,
        view: &View<'_>,
        scratch: &mut Lists<'_>,
        stream: &mut Stream,
    ) -> MixtureProgress {
        let few = |count: usize| {
            let (value, limit) = (count as f32, MIN_POINTS as f32);
            MixtureProgress::Nothing(Refusal { code: RefusalCode::FewPoints, value, limit })
        };
        self.live = scratch.list_live(view.cloud, |_| true);
        if self.live < MIN_POINTS {
            return few(self.live);
        }
        let Some(frame) = Frame::around(view.cloud, scratch.copy_members(self.live), config.viewpoint) else {
            return few(0);
        };
        // The medians left an order of their own behind: begin again from the ascending list.
        let list = scratch.copy_members(self.live);
        let wanted = usize::from(config.sample);
        self.sample = if self.live < wanted { self.live } else { wanted };
        shuffle_front(list, self.sample, stream);
        self.distance = match config.viewpoint {
            Viewpoint::None => Distance::Radial,
            Viewpoint::Origin => {
                Distance::Ray { lateral_rad: (config.noise.lateral_rad / config.noise.axial_mm) * frame.unit }
            }
        };
        self.frame = Some(frame);
        let sample = list.get(..self.sample).unwrap_or(&[]);
        self.stage = Stage::Blob { start: 0, steps: 0, blob: Blob::around(view.cloud, sample, &frame) };
        MixtureProgress::Working
    }

    /// The next start, from the next point of the sample that lies in the mask, or what comes after the last.
    fn next_start(&mut self, config: &MixtureConfig, view: &View<'_>, data: &Data<'_>, start: u8) {
        let mut seeds = data.list.iter().filter(|&&index| usize::from(index) < view.in_mask);
        let seed = if start < config.starts { seeds.nth(usize::from(start)) } else { None };
        self.stage = match seed {
            Some(&seed) => {
                let start = start + 1;
                let blob = Blob::at(&data.frame.local(&at(view.cloud, seed)), start);
                Stage::Blob { start, steps: 0, blob }
            }
            None => Stage::Polish { candidate: 0, steps: 0 },
        };
    }

    /// One step of a start's blob; after the last it becomes a shell.
    fn blob(
        &mut self,
        config: &MixtureConfig,
        view: &View<'_>,
        data: &Data<'_>,
        start: u8,
        steps: u8,
        blob: &Blob,
    ) {
        let Some(blob) = blob.step(data.cloud, data.list, data.frame) else {
            self.next_start(config, view, data, start);
            return;
        };
        let limit = if start == 0 { BLOB_STEPS.0 } else { BLOB_STEPS.1 };
        if steps + 1 < limit {
            self.stage = Stage::Blob { start, steps: steps + 1, blob };
            return;
        }
        let (mut estimate, share) = blob.shell();
        if config.viewpoint == Viewpoint::Origin {
            push_back(&mut estimate);
        }
        hold(&mut estimate);
        let [a, b, c] = estimate.ln_axes;
        let mean = libm::expf((a + b + c) / 3.0);
        let sigma = FIRST_SCALE * libm::sqrtf(mean * smallest(&estimate.ln_axes));
        let shell = Shell { estimate, sigma, share: within(share, SHARE) };
        let ln_area = ln_area(&estimate.ln_axes).value;
        self.stage = Stage::Shell { start, steps: 0, shell, ln_area };
    }

    /// One step of a start's shell, and the logarithm of the area to go on with: while the scale is made to fall that of the
    /// start, so that a shell that is still too thick does not shrink for the sake of its density.
    fn shell(
        config: &MixtureConfig,
        data: &Data<'_>,
        steps: u8,
        shell: &Shell,
        ln_first: f32,
    ) -> Option<(Shell, f32)> {
        let annealed = steps < ANNEALED_STEPS;
        let area = if annealed { ln_first } else { ln_area(&shell.estimate.ln_axes).value };
        let most = if annealed { COOLING * shell.sigma } else { f32::INFINITY };
        let pass = shell.pass(data, area);
        let normal = terms(&pass, &shell.estimate, config, 0.0);
        let scale = Scale { least: LEAST_SCALE.0, most };
        climb(shell, &normal, &pass, data.list.len(), scale).map(|(shell, _)| (shell, area))
    }

    /// True when another start came by here; otherwise this one is remembered.
    fn is_known(&mut self, estimate: &Estimate) -> bool {
        let place = Place::of(estimate);
        let known = self.passed.iter().any(|other| is_same(other, &place, SAME.0));
        if !known {
            // There is room for every start.
            let _ = self.passed.push(place);
        }
        known
    }

    /// Keeps the best few, best first; of equal ones the earlier stays ahead.
    fn keep(&mut self, new: Candidate) {
        let place = Place::of(&new.shell.estimate);
        let same = |old: &Candidate| is_same(&Place::of(&old.shell.estimate), &place, SAME.1);
        let worse = |old: Option<&Candidate>| old.is_some_and(|old| new.gain > old.gain);
        if let Some(position) = self.kept.iter().position(same) {
            if !worse(self.kept.get(position)) {
                return;
            }
            self.kept.remove(position);
        } else if self.kept.is_full() {
            if !worse(self.kept.last()) {
                return;
            }
            self.kept.pop();
        }
        let position = self.kept.iter().position(|old| worse(Some(old))).unwrap_or(self.kept.len());
        // Room was made above.
        let _ = self.kept.insert(position, new);
    }

    /// One step of one candidate; after the last of all the best goes on to all points.
    fn polish(
        &mut self,
        config: &MixtureConfig,
        data: &Data<'_>,
        candidate: u8,
        steps: u8,
    ) -> MixtureProgress {
        let Some(slot) = self.kept.get_mut(usize::from(candidate)) else { return self.choose() };
        let shell = &mut slot.shell;
        let pass = shell.pass(data, ln_area(&shell.estimate.ln_axes).value);
        let normal = terms(&pass, &shell.estimate, config, config.area_weight);
        let scale = Scale { least: LEAST_SCALE.0, most: f32::INFINITY };
        let next = climb(shell, &normal, &pass, data.list.len(), scale);
        let settled = next.is_none_or(|(_, promise)| !(promise >= SETTLED));
        if let Some((next, _)) = next {
            *shell = next;
        }
        self.stage = if settled || steps + 1 >= POLISH_STEPS {
            slot.gain = slot.shell.gain(data);
            Stage::Polish { candidate: candidate + 1, steps: 0 }
        } else {
            Stage::Polish { candidate, steps: steps + 1 }
        };
        MixtureProgress::Working
    }

    /// The best of the polished candidates; of equal ones the first.
    fn choose(&mut self) -> MixtureProgress {
        let mut best: Option<Candidate> = None;
        for &candidate in &self.kept {
            if best.is_none_or(|best| candidate.gain > best.gain) {
                best = Some(candidate);
            }
        }
        let Some(Candidate { shell, .. }) = best else {
            return MixtureProgress::Nothing(Refusal { code: RefusalCode::Singular, value: 0.0, limit: 0.0 });
        };
        if self.distance == Distance::Radial {
            self.distance = Distance::Orthogonal;
        }
        self.stage = Stage::Final { shell, steps: 0 };
        MixtureProgress::Working
    }

    /// One step of the best over all points.
    fn finish(&mut self, config: &MixtureConfig, data: &Data<'_>, shell: &Shell, steps: u8) {
        let pass = shell.pass(data, ln_area(&shell.estimate.ln_axes).value);
        let normal = terms(&pass, &shell.estimate, config, config.area_weight);
        let scale = Scale { least: LEAST_SCALE.1, most: f32::INFINITY };
        self.stage = match climb(shell, &normal, &pass, data.list.len(), scale) {
            Some((shell, promise)) if promise >= SETTLED && steps + 1 < FINAL_STEPS => {
                Stage::Final { shell, steps: steps + 1 }
            }
            _ => Stage::Measure { shell: *shell },
        };
    }
}

/// How sure, in local units; `None` where the normal equations are singular.
fn certainty(config: &MixtureConfig, data: &Data<'_>, shell: &Shell) -> Option<Covariance> {
    let (local, order) = shell.estimate.sorted();
    let information = shell.information(data, ln_area(&shell.estimate.ln_axes).value);
    let thickness = shell.sigma / local.semi_axes[2];
    let outliers = (1.0 - shell.share) / shell.share;
    let inflation = config.inflation
        + config.inflation_thin * (thickness * thickness)
        + config.inflation_outliers * outliers;
    covariance(&information, &shell.estimate, &local, order, inflation)
}

/// What the shell is in the frame and unit of the cloud, and whether to believe it.
fn solution(
    config: &MixtureConfig,
    data: &Data<'_>,
    shell: &Shell,
    covariance: Option<&Covariance>,
) -> MixtureSolution {
    let (local, _) = shell.estimate.sorted();
    let unit = data.frame.unit;
    let sigma = covariance.map_or(f32::INFINITY, Covariance::sigma_centre_max_mm);
    let area = ln_area(&shell.estimate.ln_axes).value;
    let findings = MixtureFindings { uncertain: sigma / local.semi_axes[2], ..findings(shell, data, area) };
    MixtureSolution {
        ellipsoid: Ellipsoid {
            centre: data.frame.cloud(&local.centre),
            semi_axes: local.semi_axes.map(|a| a * unit),
            axes: local.axes,
        },
        covariance: covariance.map(|c| c.scaled(unit)),
        sigma: shell.sigma * unit,
        findings,
        refusal: config.gate.refusal(&findings),
    }
}

#[cfg(test)]
mod tests;
