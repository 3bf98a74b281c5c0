//! Algorithm 1 of the paper (Table 1): variable sample consensus for one target, one trial a step.
//!
//! A trial draws a seed point, looks up its neighbourhood (Step 2), draws `n_j` of it, fits (Step 3), verifies with
//! invariants and size, scores by TEBC within the neighbourhood, and on a new best recomputes the bound on the trials,
//! Eq. (17). The sample sizes take turns. Departures from the printed algorithm, each from a reading in
//! `core/docs/paper.md`: the bound is tested at each trial and not once a round; before the first valid hypothesis it
//! is `k_max`; hypotheses compare by the number of their inliers, because the ratios of neighbourhoods of different
//! size do not compare (nine stray points that fit themselves have ratio 1).

use crate::{
    CentralQuadric, Config, Constraint, Observer, Point3, Score,
    fit::fit_observed,
    kdtree,
    point::{at, distance_squared},
    rng::Stream,
    tebc::Shell,
    trials::trials,
    workspace::Lists,
};

/// Why a trial came to nothing. Counted in [`VarsacReport`]; not an error, most trials end so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Rejection {
    /// The neighbourhood (or the list given to a fit) has fewer points than the sample needs.
    TooFewPoints = 0,
    /// The sample does not determine a quadric: equal points, a line, a plane.
    Degenerate = 1,
    /// The quadric is no real ellipsoid, Eq. (6)-(9).
    NotEllipsoid = 2,
    /// A semi-axis is outside the limits.
    Size = 3,
    /// Too few inliers, or too small a part of the neighbourhood.
    Support = 4,
}

impl Rejection {
    /// How many kinds there are.
    pub const COUNT: usize = 5;
}

/// What a search for one target did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VarsacReport {
    /// Trials done.
    pub trials: u32,
    /// Trials that came to nothing, by [`Rejection`].
    pub rejections: [u32; Rejection::COUNT],
    /// Trials that ended in a score.
    pub scored: u32,
    /// The bound that was in force at the end.
    pub bound: u32,
    /// Support of the best hypothesis in the neighbourhood it was drawn from: the `w` of Eq. (17).
    pub support: Score,
}

/// The best hypothesis so far: kept and replaced as one value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Best {
    pub(crate) surface: CentralQuadric,
    pub(crate) support: Score,
}

/// The state of one search between two steps.
#[derive(Debug, Clone)]
pub(crate) struct Varsac {
    pub(crate) report: VarsacReport,
    pub(crate) best: Option<Best>,
    /// Index of the next sample size.
    turn: u8,
    /// A neighbourhood was too large for the tree to pay; the next ones will be too.
    crowded: bool,
}

impl Varsac {
    pub(crate) fn new(config: &Config) -> Self {
        let report = VarsacReport { bound: config.max_trials, ..VarsacReport::default() };
        Self { report, best: None, turn: 0, crowded: false }
    }

    /// True when as many trials as the bound asks for are done.
    pub(crate) fn is_done(&self) -> bool {
        self.report.trials >= self.report.bound
    }

    /// One trial on the `live` points that are still unclaimed. The whole-cloud neighbourhood is expected in
    /// `scratch.members` already when the radius is infinite (see [`crate::detect`]).
    pub(crate) fn trial(
        &mut self,
        config: &Config,
        cloud: &[Point3],
        live: u32,
        scratch: &mut Lists<'_>,
        stream: &mut Stream,
        observer: &mut impl Observer,
    ) {
        self.report.trials += 1;
        let size = config.sample_sizes.get(usize::from(self.turn)).copied().unwrap_or(0);
        self.turn = if usize::from(self.turn) + 1 >= config.sample_sizes.len() { 0 } else { self.turn + 1 };

        let count = self.neighbourhood(config, cloud, live, scratch, stream, observer);
        let members = scratch.members.get(..count).unwrap_or(&[]);
        match hypothesis(config, cloud, members, size, stream, observer) {
            Err(reason) => {
                observer.rejected(reason);
                if let Some(counter) = self.report.rejections.get_mut(reason as usize) {
                    *counter += 1;
                }
            }
            Ok((surface, support)) => {
                self.report.scored += 1;
                observer.score(support);
                if self.best.is_none_or(|best| support.inliers > best.support.inliers) {
                    self.best = Some(Best { surface, support });
                    self.report.support = support;
                    self.report.bound =
                        trials(config.confidence, &config.sample_sizes, support.ratio(), config.max_trials);
                    observer.bound(self.report.bound);
                }
            }
        }
    }

    /// Draws a seed point among the live ones and gathers its neighbourhood into `scratch.members`; returns its size.
    fn neighbourhood(
        &mut self,
        config: &Config,
        cloud: &[Point3],
        live: u32,
        scratch: &mut Lists<'_>,
        stream: &mut Stream,
        observer: &mut impl Observer,
    ) -> usize {
        if config.radius == f32::INFINITY {
            // Every seed point would see the same neighbourhood: none is drawn.
            return live as usize;
        }
        let rank = stream.below(live);
        let seed = live_point_of_rank(scratch.labels, cloud.len(), live, rank);
        observer.seed_point(seed);
        let centre = at(cloud, seed);
        let tree = scratch.order.get(..live as usize).unwrap_or(&[]);
        // Past an eighth of the cloud, sorting what the tree finds costs more than looking at every point in order. Both
        // ways give the same list.
        let few = scratch.members.get_mut(..live as usize / 8).unwrap_or(&mut []);
        let found =
            if self.crowded { None } else { kdtree::within(cloud, tree, &centre, config.radius, few) };
        let count = found.unwrap_or_else(|| {
            self.crowded = true;
            let limit = config.radius * config.radius;
            scratch.list_live(cloud, |point| distance_squared(point, &centre) <= limit)
        });
        observer.neighbourhood(scratch.members.get(..count).unwrap_or(&[]));
        count
    }
}

/// The unclaimed point with `rank` unclaimed points before it.
fn live_point_of_rank(labels: &[u8], points: usize, live: u32, rank: u32) -> u16 {
    if live as usize == points {
        return rank as u16;
    }
    let unclaimed = labels.iter().take(points).enumerate().filter(|&(_, &label)| label == 0);
    unclaimed.map(|(index, _)| index as u16).nth(rank as usize).unwrap_or(0)
}

/// Sample, fit, size check, score.
fn hypothesis(
    config: &Config,
    cloud: &[Point3],
    members: &[u16],
    size: u8,
    stream: &mut Stream,
    observer: &mut impl Observer,
) -> Result<(CentralQuadric, Score), Rejection> {
    let mut buffer = [0_u16; crate::config::MAX_SAMPLE];
    let sample = buffer.get_mut(..usize::from(size)).ok_or(Rejection::TooFewPoints)?;
    if !stream.sample(members.len() as u32, sample) {
        return Err(Rejection::TooFewPoints);
    }
    for position in &mut *sample {
        *position = members.get(usize::from(*position)).copied().unwrap_or(0);
    }
    observer.sample(sample);
    let surface = valid_fit(config, cloud, sample, config.constraint, observer)?;
    let shell = Shell::new(&surface, config.shell);
    // As many different members as points: that is all of them, and no list is needed.
    let score = if members.len() == cloud.len() {
        Score { inliers: shell.count(cloud), candidates: cloud.len() as u32 }
    } else {
        shell.score(cloud, members)
    };
    if score.inliers < u32::from(config.min_inliers) || score.ratio() < config.min_ratio {
        return Err(Rejection::Support);
    }
    Ok((surface, score))
}

/// Least squares on the listed points, and the size check of Step 3.
pub(crate) fn valid_fit(
    config: &Config,
    cloud: &[Point3],
    sample: &[u16],
    constraint: Constraint,
    observer: &mut impl Observer,
) -> Result<CentralQuadric, Rejection> {
    let surface = fit_observed(cloud, sample, constraint, observer)?;
    if surface.semi_axes_within(config.semi_axis_min, config.semi_axis_max) {
        Ok(surface)
    } else {
        Err(Rejection::Size)
    }
}
