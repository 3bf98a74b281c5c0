//! The search for one target: contract, chapter 9; Algorithm 1.

use crate::fault::{self, Fault};
use crate::neighbourhood::{live_points, neighbourhood, seed_point};
use crate::{Central, Config, Event, Point, Rejection, Score, Stream};
use crate::{fit_observed, score, size_accepted, trials};

/// How many trials ended in each rejection.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rejections {
    /// [`Rejection::TooFewPoints`].
    pub too_few_points: u32,
    /// [`Rejection::Degenerate`].
    pub degenerate: u32,
    /// [`Rejection::NotEllipsoid`].
    pub not_ellipsoid: u32,
    /// [`Rejection::Size`].
    pub size: u32,
    /// [`Rejection::Support`].
    pub support: u32,
}

impl Rejections {
    pub(crate) fn count(&mut self, rejection: Rejection) {
        match rejection {
            Rejection::TooFewPoints => self.too_few_points += 1,
            Rejection::Degenerate => self.degenerate += 1,
            Rejection::NotEllipsoid => self.not_ellipsoid += 1,
            Rejection::Size => self.size += 1,
            Rejection::Support => self.support += 1,
        }
    }
}

/// What a search did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// Trials made.
    pub trials: u32,
    /// Trials that were rejected, by kind.
    pub rejections: Rejections,
    /// Hypotheses that counted as scored.
    pub scored: u32,
    /// The bound on the trials at the end.
    pub bound: u32,
    /// Score of the best hypothesis within its neighbourhood.
    pub support: Score,
}

/// Chapter 9: the best surface among the live points, if any, and what the search did.
pub fn search_target(
    cloud: &[Point],
    labels: &[u8],
    config: &Config,
    stream: &mut Stream,
    observe: &mut dyn FnMut(Event),
) -> (Option<Central>, Report) {
    let mut report = Report { bound: config.max_trials, ..Report::default() };
    let mut best: Option<Central> = None;
    let mut turn = 0;
    while report.trials < report.bound {
        report.trials += 1;
        let size = config.sizes[turn];
        turn += 1;
        if turn == config.sizes.len() {
            turn = 0;
        }
        match trial(cloud, labels, config, size, stream, observe) {
            Err(rejection) => {
                report.rejections.count(rejection);
                observe(Event::Rejected(rejection));
            }
            Ok((surface, support)) => {
                report.scored += 1;
                observe(Event::Score(support));
                let tie = fault::is(Fault::Best) && support.inliers == report.support.inliers;
                if best.is_none() || support.inliers > report.support.inliers || tie {
                    best = Some(surface);
                    report.support = support;
                    report.bound =
                        trials(config.confidence, &config.sizes, support.ratio(), config.max_trials);
                    observe(Event::Bound(report.bound));
                }
            }
        }
    }
    (best, report)
}

/// Chapter 9, steps 2 to 5: one hypothesis and its support.
fn trial(
    cloud: &[Point],
    labels: &[u8],
    config: &Config,
    size: u8,
    stream: &mut Stream,
    observe: &mut dyn FnMut(Event),
) -> Result<(Central, Score), Rejection> {
    let members = if config.radius == f32::INFINITY {
        live_points(labels)
    } else {
        let seed = seed_point(labels, stream).ok_or(Rejection::TooFewPoints)?;
        observe(Event::SeedPoint(seed));
        let members = neighbourhood(cloud, labels, seed, config.radius);
        observe(Event::Neighbourhood(members.clone()));
        members
    };
    let positions = stream.sample(members.len() as u32, size as u32).ok_or(Rejection::TooFewPoints)?;
    let mut sample = Vec::new();
    for position in positions {
        sample.push(members[position as usize]);
    }
    observe(Event::Sample(sample.clone()));
    let surface = fit_observed(cloud, &sample, config.constraint, observe)?;
    if !size_accepted(&surface.shape, config.semi_axis_min, config.semi_axis_max) {
        return Err(Rejection::Size);
    }
    let support = score(&surface, config.shell, cloud, &members);
    if support.inliers < config.min_inliers || support.ratio() < config.min_ratio {
        return Err(Rejection::Support);
    }
    Ok((surface, support))
}
