//! Several targets in one cloud, Steps 2 to 5 of the paper: search, refit, take the inliers out, go on.
//!
//! [`Detector`] holds a checked configuration. [`Detections`] is one run over one cloud: an iterator that yields a
//! fruit per `next()`, or, for a firmware loop that must not be held up, a machine that does one bounded piece of work
//! per [`Detections::step`]. The run ends, whatever the cloud: each target claims at least one point, and targets,
//! failed searches and trials are all bounded by the configuration.

use crate::{
    CentralQuadric, CloudError, Config, ConfigError, Ellipsoid, Observer, Point3, Score, VarsacReport,
    kdtree,
    point::check_cloud,
    rng::Stream,
    tebc::Shell,
    varsac::{Varsac, valid_fit},
    workspace::Scratch,
};

/// A located fruit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Detection {
    /// 1 for the first target of the cloud, and the label of its points.
    pub target: u8,
    /// Centre, semi-axes, axes.
    pub ellipsoid: Ellipsoid,
    /// Inliers among all points that were live before this target: the score that the paper's tables report.
    pub score: Score,
    /// What the search did. Its `support` is the score within the neighbourhood, the `w` of Eq. (17).
    pub report: VarsacReport,
}

/// Why a run is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Finish {
    /// Fewer points are left than a sample needs, or than the last target had inliers (Step 5).
    FewPoints,
    /// `max_targets` were found.
    Targets,
    /// `max_failures` searches found nothing.
    Failures,
}

/// What one step came to.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "no heap to box into; it lives for the length of one call")]
pub enum Step {
    /// There is more to do.
    Working,
    /// A target was found and its points were claimed; there may be more.
    Found(Detection),
    /// A search ended without a valid hypothesis; its report is handed on so that no trial goes uncounted.
    Missed(VarsacReport),
    /// The run is over; every further step says so again.
    Finished(Finish),
}

/// A checked configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Detector {
    config: Config,
}

impl Detector {
    /// Checks the configuration; from here on it is valid for good.
    ///
    /// # Errors
    /// The first field out of range.
    pub fn new(config: Config) -> Result<Self, ConfigError> {
        config.check()?;
        Ok(Self { config })
    }

    /// The configuration in force.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// Begins a run over `cloud`. The same cloud, configuration and seed give the same bits on every machine.
    ///
    /// ```
    /// use varsac_core::{Config, Detector, Point3, Workspace};
    /// let cloud = [Point3::new(0.0, 0.0, 700.0); 30];
    /// let mut workspace = Workspace::<64>::new();
    /// let detector = Detector::new(Config::jujube()).unwrap();
    /// let found = detector.detect(&cloud, workspace.scratch(), 1).unwrap().count();
    /// assert_eq!(found, 0); // thirty equal points are no fruit
    /// ```
    ///
    /// # Errors
    /// A coordinate that is not finite (with its index), or more points than the workspace holds.
    pub fn detect<'a>(
        &'a self,
        cloud: &'a [Point3],
        scratch: Scratch<'a>,
        seed: u64,
    ) -> Result<Detections<'a>, CloudError> {
        check_cloud(cloud, scratch.capacity())?;
        if let Some(labels) = scratch.labels.get_mut(..cloud.len()) {
            labels.fill(0);
        }
        Ok(Detections {
            config: &self.config,
            cloud,
            scratch,
            stream: Stream::new(seed),
            live: cloud.len() as u32,
            targets: 0,
            failures: 0,
            last_inliers: 0,
            phase: Phase::Begin,
            search: Varsac::new(&self.config),
        })
    }
}

/// Where a run stands between two steps.
#[derive(Debug, Clone, Copy)]
enum Phase {
    /// The next search has to be prepared (or not begun at all).
    Begin,
    /// Trials are under way.
    Search,
    /// The best hypothesis is refitted; this many refits are done.
    Refit { surface: CentralQuadric, done: u8 },
    /// The best hypothesis is final; its points have to be claimed.
    Claim { surface: CentralQuadric },
    /// Over.
    End(Finish),
}

/// One run over one cloud.
#[derive(Debug)]
pub struct Detections<'a> {
    config: &'a Config,
    cloud: &'a [Point3],
    scratch: Scratch<'a>,
    stream: Stream,
    /// Unclaimed points.
    live: u32,
    targets: u8,
    failures: u8,
    last_inliers: u32,
    phase: Phase,
    search: Varsac,
}

impl Iterator for Detections<'_> {
    type Item = Detection;

    /// The next target, or nothing when the run is over.
    fn next(&mut self) -> Option<Detection> {
        loop {
            match self.step() {
                Step::Working | Step::Missed(_) => {}
                Step::Found(detection) => return Some(detection),
                Step::Finished(_) => return None,
            }
        }
    }
}

impl Detections<'_> {
    /// One bounded piece of work: preparing a search (`O(n log n)`), one trial (`O(n)`), one refit (`O(n)`), or
    /// claiming the points of a target (`O(n)`).
    pub fn step(&mut self) -> Step {
        self.step_observed(&mut ())
    }

    /// [`Self::step`] under the eyes of an observer.
    pub fn step_observed(&mut self, observer: &mut impl Observer) -> Step {
        match self.phase {
            Phase::Begin => self.begin(),
            Phase::Search => self.trial(observer),
            Phase::Refit { surface, done } => self.refit(surface, done, observer),
            Phase::Claim { surface } => self.claim(&surface, observer),
            Phase::End(finish) => Step::Finished(finish),
        }
    }

    /// For each point of the cloud 0, or the number of the target that claimed it.
    pub fn labels(&self) -> &[u8] {
        self.scratch.labels.get(..self.cloud.len()).unwrap_or(&[])
    }

    /// Unclaimed points.
    pub fn live(&self) -> u32 {
        self.live
    }

    /// Step 5's rule, then the tree over what is left.
    fn begin(&mut self) -> Step {
        let smallest = self.config.sample_sizes.iter().copied().min().unwrap_or(0);
        self.phase = if self.targets >= self.config.max_targets {
            Phase::End(Finish::Targets)
        } else if self.failures >= self.config.max_failures {
            Phase::End(Finish::Failures)
        } else if self.live < u32::from(smallest) || self.live < self.last_inliers {
            Phase::End(Finish::FewPoints)
        } else {
            self.search = Varsac::new(self.config);
            let live = self.scratch.list_live(self.cloud, |_| true);
            if self.config.radius != f32::INFINITY {
                let (order, members) = (&mut *self.scratch.order, &*self.scratch.members);
                if let (Some(order), Some(members)) = (order.get_mut(..live), members.get(..live)) {
                    order.copy_from_slice(members);
                    kdtree::build(self.cloud, order);
                }
            }
            Phase::Search
        };
        Step::Working
    }

    fn trial(&mut self, observer: &mut impl Observer) -> Step {
        let Self { config, cloud, live, scratch, stream, search, .. } = self;
        search.trial(config, cloud, *live, scratch, stream, observer);
        if !search.is_done() {
            return Step::Working;
        }
        let Some(best) = search.best else { return self.missed() };
        self.phase = Phase::Refit { surface: best.surface, done: 0 };
        Step::Working
    }

    /// "Optimization with the inner point": least squares on the inliers among all live points. A refit that is no
    /// valid ellipsoid is dropped and ends the refits, and so does one that changes no bit.
    fn refit(&mut self, surface: CentralQuadric, done: u8, observer: &mut impl Observer) -> Step {
        if done >= self.config.refits {
            self.phase = Phase::Claim { surface };
            return Step::Working;
        }
        let shell = Shell::new(&surface, self.config.shell);
        let count = self.scratch.list_live(self.cloud, |point| shell.contains(point));
        let inliers = self.scratch.members.get(..count).unwrap_or(&[]);
        self.phase = match valid_fit(self.config, self.cloud, inliers, self.config.constraint, observer) {
            Ok(better) if better != surface => {
                observer.refit(&better);
                Phase::Refit { surface: better, done: done + 1 }
            }
            _ => Phase::Claim { surface },
        };
        Step::Working
    }

    fn claim(&mut self, surface: &CentralQuadric, observer: &mut impl Observer) -> Step {
        let shell = Shell::new(surface, self.config.shell);
        let count = self.scratch.list_live(self.cloud, |point| shell.contains(point));
        if count < usize::from(self.config.min_inliers) {
            // The refit moved the surface off its points.
            return self.missed();
        }
        self.targets += 1;
        for &index in self.scratch.members.get(..count).unwrap_or(&[]) {
            if let Some(label) = self.scratch.labels.get_mut(usize::from(index)) {
                *label = self.targets;
            }
        }
        let score = Score { inliers: count as u32, candidates: self.live };
        self.live -= score.inliers;
        self.last_inliers = score.inliers;
        self.phase = Phase::Begin;
        let detection = Detection {
            target: self.targets,
            ellipsoid: Ellipsoid::from(surface),
            score,
            report: self.search.report,
        };
        observer.detection(&detection);
        Step::Found(detection)
    }

    /// A search found nothing: the next one begins, if the configuration allows another.
    fn missed(&mut self) -> Step {
        self.failures += 1;
        self.phase = Phase::Begin;
        Step::Missed(self.search.report)
    }
}
