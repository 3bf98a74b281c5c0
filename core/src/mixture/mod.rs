//! The search without a size prior: the most probable ellipsoid among points of any kind, by expectation-maximisation.
//!
//! Drawing nine points and hoping that all of them lie on the body is the weak way when more than half of the points do not.
//! Here every point counts with its probability to lie on the surface, and the surface moves until it explains
//! most. One bounded piece of work per [`MixtureSearch::step`]:
//!
//! 1. [`frame`]: the search's own frame and unit; a seeded random choice of points, the *sample*.
//! 2. For each start: a Gaussian [`blob`], then the [`shell`] of the same moments, whose noise scale falls from a third of
//!    the body to what the points show, then a few steps with the scale free.
//! 3. The best few by likelihood ([`Shell::gain`]: a large empty shell has a thin density, so no size limits are needed)
//!    are polished with the correction for curvature, `+ 1/2 sum(r) ln A`.
//! 4. The best goes on to all points with orthogonal distances ([`crate::foot`]).
//! 5. Covariance and [`judge`]: an ellipsoid, or a plane, a pipe, a box, half a body, clutter?
//!
//! Bound on the work: `points x steps` with at most [`MAX_START_STEPS`] over the sample for each start,
//! [`KEPT`] x [`POLISH_STEPS`] over the sample, and [`FINAL_STEPS`] + 2 over all points.

mod area;
mod blob;
mod config;
mod frame;
mod judge;
mod shell;

use heapless::Vec;

pub use self::config::{MixtureConfig, MixtureGate};
pub use self::judge::MixtureFindings;
use self::{
    area::ln_area,
    blob::Blob,
    frame::{Frame, shuffle_front},
    judge::findings,
    shell::{Distance, Pass, Shell, smallest},
};
use crate::{
    Ellipsoid, Point3,
    accept::{Refusal, RefusalCode},
    covariance::{Covariance, covariance},
    linalg::N,
    point::at,
    refine::{Estimate, Normal, ROTATION_INFORMATION},
    residual::Viewpoint,
    rng::Stream,
    workspace::Scratch,
};

/// Steps of the blob made from all points, and of the others.
const BLOB_STEPS: (u8, u8) = (20, 3);
/// Deviations of the blobs about random points, local units, in turns: a small one finds a body beside a dense neighbour, a
/// large one a body of which few points are left.
const BLOB_DEVIATIONS: [f32; 2] = [0.2, 0.4];
/// Shares the blobs start with.
const BLOB_SHARE: (f32, f32) = (0.5, 0.8);
/// Steps in which the scale of the noise is made to fall, and free steps after them.
const ANNEALED_STEPS: u8 = 16;
const FREE_STEPS: u8 = 6;
/// Step at which a start that is where another one has been is given up: it would end there too.
const WAYPOINT: u8 = 8;
/// Most starts.
pub const MAX_STARTS: usize = 16;
/// First scale over the geometric mean of (geometric mean, smallest semi-axis).
const FIRST_SCALE: f32 = 0.35;
/// The scale falls at least by this factor a step.
const COOLING: f32 = 0.8;
/// Smallest scale of the starts, and of the final steps; local units.
const SMALLEST_SCALE: (f32, f32) = (0.002, 0.0001);
/// Largest scale over the smallest semi-axis: a shell as thick as its body is a blob.
const THICKEST: f32 = 0.7;
/// Limits of the share of the surface.
const SHARE: (f32, f32) = (0.02, 0.99);
/// Limits of the semi-axes, local units, as logarithms of .01 and 6, and of their ratio, 30.
const LN_AXES: (f32, f32) = (-4.605_170_2, 1.791_759_5);
const LN_ASPECT: f32 = 3.401_197_4;
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
    Frame,
    Blob { start: u8, steps: u8, blob: Blob },
    Shell { start: u8, steps: u8, shell: Shell, ln_area: f32 },
    Polish { candidate: u8, steps: u8 },
    Final { shell: Shell, steps: u8 },
}

/// What one step came to.
#[allow(clippy::large_enum_variant, reason = "no heap to box into; it lives for the length of one call")]
#[derive(Debug, Clone, Copy)]
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
    /// Live points, in `members` of the scratch; the first `sample` of `order` are the sample.
    live: usize,
    sample: usize,
    kept: Vec<Candidate, KEPT>,
    /// Where the starts were at [`WAYPOINT`].
    passed: Vec<Estimate, MAX_STARTS>,
}

impl Default for MixtureSearch {
    fn default() -> Self {
        Self::new()
    }
}

impl MixtureSearch {
    /// At the beginning.
    pub fn new() -> Self {
        Self { stage: Stage::Frame, frame: None, distance: Distance::Radial, live: 0, sample: 0, kept: Vec::new(), passed: Vec::new() }
    }

    /// One bounded piece of work on the live points of the cloud.
    pub fn step(&mut self, config: &MixtureConfig, cloud: &[Point3], scratch: &mut Scratch<'_>, stream: &mut Stream) -> MixtureProgress {
        match (self.stage, self.frame) {
            (Stage::Blob { start, steps, blob }, Some(frame)) => self.blob(config, cloud, scratch, &frame, (start, steps, &blob)),
            (Stage::Shell { start, steps, shell, ln_area }, Some(frame)) => {
                self.shell(config, cloud, scratch, &frame, (start, steps, &shell, ln_area));
                MixtureProgress::Working
            }
            (Stage::Polish { candidate, steps }, Some(frame)) => self.polish(config, cloud, scratch, &frame, candidate, steps),
            (Stage::Final { shell, steps }, Some(frame)) => self.finish(config, cloud, scratch, &frame, &shell, steps),
            _ => self.begin(config, cloud, scratch, stream),
        }
    }

    /// Lists, frame, sample.
    fn begin(&mut self, config: &MixtureConfig, cloud: &[Point3], scratch: &mut Scratch<'_>, stream: &mut Stream) -> MixtureProgress {
        let few = |count: usize| {
            let (value, limit) = (count as f32, MIN_POINTS as f32);
            MixtureProgress::Nothing(Refusal { code: RefusalCode::FewPoints, value, limit })
        };
        self.live = scratch.list_live(cloud, |_| true);
        if self.live < MIN_POINTS {
            return few(self.live);
        }
        let copy = |scratch: &mut Scratch<'_>| {
            for (slot, &index) in scratch.order.iter_mut().zip(scratch.members.iter()) {
                *slot = index;
            }
        };
        copy(scratch);
        let order = scratch.order.get_mut(..self.live).unwrap_or(&mut []);
        let Some(frame) = Frame::around(cloud, order, config.viewpoint) else { return few(0) };
        // The medians left an order of their own behind: begin again from the ascending list.
        copy(scratch);
        self.sample = if self.live < usize::from(config.sample) { self.live } else { usize::from(config.sample) };
        shuffle_front(scratch.order.get_mut(..self.live).unwrap_or(&mut []), self.sample, stream);
        self.distance = match config.viewpoint {
            Viewpoint::None => Distance::Radial,
            Viewpoint::Origin => {
                Distance::Ray { lateral_rad: (config.noise.lateral_rad / config.noise.axial_mm) * frame.unit }
            }
        };
        self.frame = Some(frame);
        self.start(0, cloud, scratch, &frame);
        MixtureProgress::Working
    }

    /// Puts the first blob of a start on the way: the first from all points, the others from a point of the sample each.
    fn start(&mut self, start: u8, cloud: &[Point3], scratch: &Scratch<'_>, frame: &Frame) {
        let blob = if start == 0 {
            let [x, y, z] = mean(cloud, self.sample_of(scratch), frame);
            Blob::round(&Point3::new(x, y, z), 1.0, BLOB_SHARE.0)
        } else {
            let index = scratch.order.get(usize::from(start) - 1).copied().unwrap_or(0);
            let deviation = BLOB_DEVIATIONS[usize::from(start) % BLOB_DEVIATIONS.len()];
            Blob::round(&frame.local(&at(cloud, index)), deviation, BLOB_SHARE.1)
        };
        self.stage = Stage::Blob { start, steps: 0, blob };
    }

    fn sample_of<'a>(&self, scratch: &'a Scratch<'_>) -> &'a [u16] {
        scratch.order.get(..self.sample).unwrap_or(&[])
    }

    /// The next start, or what comes after the last.
    fn next_start(&mut self, config: &MixtureConfig, start: u8, cloud: &[Point3], scratch: &Scratch<'_>, frame: &Frame) {
        if start < config.starts && usize::from(start) < self.sample {
            self.start(start + 1, cloud, scratch, frame);
        } else {
            self.stage = Stage::Polish { candidate: 0, steps: 0 };
        }
    }

    fn blob(&mut self, config: &MixtureConfig, cloud: &[Point3], scratch: &Scratch<'_>, frame: &Frame, (start, steps, blob): (u8, u8, &Blob)) -> MixtureProgress {
        let limit = if start == 0 { BLOB_STEPS.0 } else { BLOB_STEPS.1 };
        if let Some(blob) = blob.step(cloud, self.sample_of(scratch), frame) {
            self.stage = if steps + 1 < limit {
                Stage::Blob { start, steps: steps + 1, blob }
            } else {
                let (mut estimate, share) = blob.shell();
                if config.viewpoint == Viewpoint::Origin {
                    push_back(&mut estimate);
                }
                hold(&mut estimate);
                let [a, b, c] = estimate.ln_axes;
                let sigma = FIRST_SCALE * libm::expf(0.5 * ((a + b + c) / 3.0 + c));
                Stage::Shell { start, steps: 0, shell: Shell { estimate, sigma, share: within(share, SHARE) }, ln_area: ln_area(&estimate.ln_axes).value }
            };
        } else {
            self.next_start(config, start, cloud, scratch, frame);
        }
        MixtureProgress::Working
    }

    /// One step of a start's shell.
    fn shell(&mut self, config: &MixtureConfig, cloud: &[Point3], scratch: &Scratch<'_>, frame: &Frame, (start, steps, shell, area): (u8, u8, &Shell, f32)) {
        let list = self.sample_of(scratch);
        if steps >= ANNEALED_STEPS + FREE_STEPS {
            let gain = shell.gain(cloud, list, frame, self.distance);
            self.keep(Candidate { shell: *shell, gain });
            self.next_start(config, start, cloud, scratch, frame);
            return;
        }
        if steps == WAYPOINT {
            if self.passed.iter().any(|other| is_same(other, &shell.estimate, 0.25)) {
                self.next_start(config, start, cloud, scratch, frame);
                return;
            }
            // A full list only gives up fewer.
            let _ = self.passed.push(shell.estimate);
        }
        let annealed = steps < ANNEALED_STEPS;
        let area = if annealed { area } else { ln_area(&shell.estimate.ln_axes).value };
        let pass = shell.pass(cloud, list, frame, self.distance, area);
        let limit = if annealed { COOLING * shell.sigma } else { f32::INFINITY };
        let normal = terms(&pass, shell, config, if config.viewpoint == Viewpoint::None { 0.0 } else { config.area_weight });
        match moved(shell, &normal, &pass, list.len(), limit, SMALLEST_SCALE.0) {
            Some((shell, _)) => self.stage = Stage::Shell { start, steps: steps + 1, shell, ln_area: area },
            None => self.next_start(config, start, cloud, scratch, frame),
        }
    }

    /// Keeps the best few, best first; of equal ones the earlier stays ahead.
    fn keep(&mut self, new: Candidate) {
        if !new.gain.is_finite() {
            return;
        }
        let same = |old: &Candidate| is_same(&old.shell.estimate, &new.shell.estimate, 0.1);
        if let Some(position) = self.kept.iter().position(same) {
            if self.kept.get(position).is_none_or(|old| old.gain >= new.gain) {
                return;
            }
            self.kept.remove(position);
        } else if self.kept.is_full() {
            if self.kept.last().is_none_or(|worst| worst.gain >= new.gain) {
                return;
            }
            self.kept.pop();
        }
        let position = self.kept.iter().position(|old| old.gain < new.gain).unwrap_or(self.kept.len());
        // Room was made above.
        let _ = self.kept.insert(position, new);
    }

    /// One step of one candidate; after the last of all the best goes on to all points.
    fn polish(&mut self, config: &MixtureConfig, cloud: &[Point3], scratch: &Scratch<'_>, frame: &Frame, candidate: u8, steps: u8) -> MixtureProgress {
        let list = self.sample_of(scratch);
        let distance = self.distance;
        let Some(slot) = self.kept.get_mut(usize::from(candidate)) else { return self.choose() };
        let area = ln_area(&slot.shell.estimate.ln_axes).value;
        let pass = slot.shell.pass(cloud, list, frame, distance, area);
        let normal = terms(&pass, &slot.shell, config, config.area_weight);
        let next = moved(&slot.shell, &normal, &pass, list.len(), f32::INFINITY, SMALLEST_SCALE.0);
        let settled = next.is_none_or(|(_, promise)| promise < SETTLED);
        if let Some((shell, _)) = next {
            slot.shell = shell;
        }
        self.stage = if settled || steps + 1 >= POLISH_STEPS {
            slot.gain = slot.shell.gain(cloud, list, frame, distance);
            Stage::Polish { candidate: candidate + 1, steps: 0 }
        } else {
            Stage::Polish { candidate, steps: steps + 1 }
        };
        MixtureProgress::Working
    }

    /// The best of the polished candidates.
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

    /// One step of the best over all points; after the last the solution.
    fn finish(&mut self, config: &MixtureConfig, cloud: &[Point3], scratch: &Scratch<'_>, frame: &Frame, shell: &Shell, steps: u8) -> MixtureProgress {
        let list = scratch.members.get(..self.live).unwrap_or(&[]);
        let area = ln_area(&shell.estimate.ln_axes).value;
        let pass = shell.pass(cloud, list, frame, self.distance, area);
        let normal = terms(&pass, shell, config, config.area_weight);
        let next = moved(shell, &normal, &pass, list.len(), f32::INFINITY, SMALLEST_SCALE.1);
        match next {
            Some((shell, promise)) if promise >= SETTLED && steps + 1 < FINAL_STEPS => {
                self.stage = Stage::Final { shell, steps: steps + 1 };
                MixtureProgress::Working
            }
            _ => MixtureProgress::Found(self.solution(config, cloud, list, frame, shell)),
        }
    }

    fn solution(&self, config: &MixtureConfig, cloud: &[Point3], list: &[u16], frame: &Frame, shell: &Shell) -> MixtureSolution {
        let (local, order) = shell.estimate.sorted();
        let area = ln_area(&shell.estimate.ln_axes).value;
        let odds = shell.odds(frame.volume, area);
        let mut findings = findings(shell, cloud, list, frame, self.distance, odds);
        let information = shell.information(cloud, list, frame, self.distance, area);
        let thickness = shell.sigma / local.semi_axes[2];
        let inflation = config.inflation + config.inflation_thin * (thickness * thickness);
        let covariance = covariance(&information, &shell.estimate, &local, order, inflation);
        let sigma = covariance.map_or(f32::INFINITY, |c| c.sigma_centre_max_mm());
        findings.uncertain = sigma / local.semi_axes[2];
        MixtureSolution {
            ellipsoid: Ellipsoid {
                centre: frame.to_cloud(&local.centre),
                semi_axes: local.semi_axes.map(|a| a * frame.unit),
                axes: local.axes,
            },
            covariance: covariance.map(|c| c.scaled(frame.unit)),
            sigma: shell.sigma * frame.unit,
            findings,
            refusal: config.gate.refusal(&findings),
        }
    }
}

/// The normal equations with area and shape terms.
fn terms(pass: &Pass, shell: &Shell, config: &MixtureConfig, area_weight: f32) -> Normal {
    let mut normal = pass.normal(&shell.estimate, area_weight);
    let precision = 1.0 / (config.shape_spread * config.shape_spread);
    if precision > 0.0 {
        add_shape(&mut normal, &shell.estimate.ln_axes, precision);
    }
    normal
}

/// `1/2 precision sum_k (x_k - mean x)^2`, `x` the logarithms of the semi-axes.
fn add_shape(normal: &mut Normal, x: &[f32; 3], precision: f32) {
    let mean = (x[0] + x[1] + x[2]) / 3.0;
    for k in 0..3 {
        normal.gradient[6 + k] += precision * (x[k] - mean);
        normal.matrix.add_diagonal(6 + k, precision * (2.0 / 3.0));
    }
    for (i, j) in [(7, 6), (8, 6), (8, 7)] {
        normal.matrix.0[crate::linalg::packed(i, j)] -= precision / 3.0;
    }
}

/// The shell after a step, and the gain the step promises; `None` where the equations are singular.
fn moved(shell: &Shell, normal: &Normal, pass: &Pass, count: usize, scale_limit: f32, floor: f32) -> Option<(Shell, f32)> {
    let mut matrix = normal.matrix;
    for k in 3..6 {
        matrix.add_diagonal(k, ROTATION_INFORMATION);
    }
    for k in 0..N {
        let d = matrix.diagonal(k);
        matrix.add_diagonal(k, 1e-4 * d);
    }
    let step = matrix.factor()?.solve(&normal.gradient).map(|x| -x);
    let mut promise = 0.0;
    for k in 0..N {
        promise -= step[k] * normal.gradient[k];
    }
    let longest = libm::expf(largest(&shell.estimate.ln_axes));
    let mut estimate = shell.estimate.moved_by(&step, 0.5 * longest)?;
    hold(&mut estimate);
    let estimated = shell.sigma * libm::sqrtf(pass.squares / pass.members);
    let thickest = THICKEST * smallest(&estimate.ln_axes);
    let scale_limit = if thickest < scale_limit { thickest } else { scale_limit };
    let sigma = if estimated < scale_limit { estimated } else { scale_limit };
    let sigma = if sigma > floor { sigma } else { floor };
    let share = within(pass.members / count as f32, SHARE);
    Some((Shell { estimate, sigma, share }, promise))
}

/// Keeps the semi-axes within their limits.
fn hold(estimate: &mut Estimate) {
    let bound = largest(&estimate.ln_axes) - LN_ASPECT;
    let low = if bound > LN_AXES.0 { bound } else { LN_AXES.0 };
    estimate.ln_axes = estimate.ln_axes.map(|x| within(x, (low, LN_AXES.1)));
}

fn largest(x: &[f32; 3]) -> f32 {
    let first = if x[0] > x[1] { x[0] } else { x[1] };
    if first > x[2] { first } else { x[2] }
}

fn within(x: f32, (low, high): (f32, f32)) -> f32 {
    if x < low {
        low
    } else if x > high {
        high
    } else {
        x
    }
}

/// From one side the blob's centre lies on the surface: two thirds of its depth back along the ray.
fn push_back(estimate: &mut Estimate) {
    let c = estimate.centre;
    let range = libm::sqrtf(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    let mut square = 0.0;
    for k in 0..3 {
        let r = estimate.axes[k];
        let along = libm::expf(estimate.ln_axes[k]) * ((r[0] * c[0] + r[1] * c[1] + r[2] * c[2]) / range);
        square += along * along;
    }
    let factor = 1.0 + (2.0 / 3.0) * (libm::sqrtf(square) / range);
    estimate.centre = c.map(|x| x * factor);
}

/// Two estimates of one body: centres within this part of the smallest semi-axis, and the product of the semi-axes.
fn is_same(a: &Estimate, b: &Estimate, part: f32) -> bool {
    let d = [a.centre[0] - b.centre[0], a.centre[1] - b.centre[1], a.centre[2] - b.centre[2]];
    let apart = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    let near = part * smallest(&a.ln_axes);
    let size = |e: &Estimate| e.ln_axes[0] + e.ln_axes[1] + e.ln_axes[2];
    apart < near * near && libm::fabsf(size(a) - size(b)) < part
}

fn mean(cloud: &[Point3], list: &[u16], frame: &Frame) -> [f32; 3] {
    let mut sum = [0.0_f32; 3];
    for &index in list {
        let p = frame.local(&at(cloud, index));
        sum[0] += p.x;
        sum[1] += p.y;
        sum[2] += p.z;
    }
    sum.map(|s| s / list.len() as f32)
}
