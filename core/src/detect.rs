//! Several targets in one cloud: search, take the points of what was found out, go on. The loop is the paper's (Steps 2
//! to 5); which search runs in it is the configuration's choice ([`Method`]).
//!
//! [`Detector`] holds a checked configuration. [`Detections`] is one run over one cloud: an iterator that yields a
//! fruit per `next()`, or, for a firmware loop that must not be held up, a machine that does one bounded piece of work
//! per [`Detections::step`]. The run ends, whatever the cloud: each target claims at least one point, and targets,
//! failed searches and trials are all bounded by the configuration.

use crate::{
    CentralQuadric, CloudError, Config, ConfigError, Ellipsoid, Method, Observer, Point3, Score,
    VarsacReport,
    accept::{Findings, Refusal, RefusalCode, contact_function},
    covariance::Covariance,
    kdtree,
    map::{MapSearch, Progress, Solution, lies_on},
    outline::OutlineRay,
    point::check_cloud,
    residual::RayModel,
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
    /// Accepted, or why not. The paper's search accepts all it finds.
    pub status: Status,
    /// How sure; none from the paper's search, nor where the normal equations are singular.
    pub covariance: Option<Covariance>,
    /// What the tests of acceptance looked at; none from the paper's search.
    pub findings: Option<Findings>,
}

/// Whether a robot should reach for it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Status {
    /// Yes.
    Accepted,
    /// No, and why.
    Refused(Refusal),
}

/// What a run looks at: points, and what is known of them beyond their coordinates.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Points, mm, camera optical frame.
    pub cloud: &'a [Point3],
    /// Points before this index lie in the mask of fruit-coloured pixels; the others are what is seen around it. They
    /// show where fruit are not. The paper's search makes no difference.
    pub in_mask: usize,
    /// Outline rays found in the depth image; may be empty.
    pub outline: &'a [OutlineRay],
}

impl<'a> From<&'a [Point3]> for View<'a> {
    /// All points in the mask, no outline.
    fn from(cloud: &'a [Point3]) -> Self {
        Self { cloud, in_mask: cloud.len(), outline: &[] }
    }
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
        self.detect_view(&View::from(cloud), scratch, seed)
    }

    /// [`Self::detect`] with all that is known of the view.
    ///
    /// # Errors
    /// As [`Self::detect`]; the coordinates of the outline rays are not checked (a ray that is not finite fits no model).
    pub fn detect_view<'a>(
        &'a self,
        view: &View<'a>,
        scratch: Scratch<'a>,
        seed: u64,
    ) -> Result<Detections<'a>, CloudError> {
        check_cloud(view.cloud, scratch.capacity())?;
        let points = view.cloud.len();
        if let Some(labels) = scratch.labels.get_mut(..points) {
            labels.fill(0);
        }
        let in_mask = if view.in_mask < points { view.in_mask } else { points };
        let seeds = if self.config.method == Method::Map { in_mask } else { points };
        Ok(Detections {
            config: &self.config,
            view: View { in_mask, ..*view },
            scratch,
            stream: Stream::new(seed),
            live: points as u32,
            seeds: seeds as u32,
            targets: 0,
            failures: 0,
            last_inliers: 0,
            phase: Phase::Begin,
            search: Search::None,
            accepted: heapless::Vec::new(),
        })
    }
}

/// The search under way.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "no heap to box into; one lives in each run")]
enum Search {
    None,
    Varsac(Varsac),
    Map(MapSearch),
}

/// Targets that a new one is compared with: the latest so many. Those of one cluster follow each other.
const COMPARED: usize = 16;

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
    view: View<'a>,
    scratch: Scratch<'a>,
    stream: Stream,
    /// Unclaimed points.
    live: u32,
    /// Unclaimed points that a search may begin from.
    seeds: u32,
    targets: u8,
    failures: u8,
    last_inliers: u32,
    phase: Phase,
    search: Search,
    accepted: heapless::Vec<Ellipsoid, COMPARED>,
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
        self.scratch.labels.get(..self.view.cloud.len()).unwrap_or(&[])
    }

    /// Unclaimed points.
    pub fn live(&self) -> u32 {
        self.live
    }

    /// Step 5's rule, then the tree: over what is left, or, for the default search, over all points (a claimed point
    /// still shows where other fruit are not), once.
    fn begin(&mut self) -> Step {
        let fresh = matches!(self.search, Search::None);
        let smallest = match self.config.method {
            Method::Varsac => self.config.sample_sizes.iter().copied().min().unwrap_or(0),
            Method::Map => crate::hypothesis::SAMPLE as u8,
        };
        let paper = self.config.method == Method::Varsac;
        self.phase = if self.targets >= self.config.max_targets {
            Phase::End(Finish::Targets)
        } else if self.failures >= self.config.max_failures {
            Phase::End(Finish::Failures)
        } else if self.seeds < u32::from(smallest) || (paper && self.live < self.last_inliers) {
            Phase::End(Finish::FewPoints)
        } else {
            if paper {
                self.search = Search::Varsac(Varsac::new(self.config));
            } else {
                self.search = Search::Map(MapSearch::new(self.config));
            }
            if (paper && self.config.radius != f32::INFINITY) || (!paper && fresh) {
                self.plant();
            } else if paper {
                self.scratch.list_live(self.view.cloud, |_| true);
            }
            Phase::Search
        };
        Step::Working
    }

    /// The tree over the live points.
    fn plant(&mut self) {
        let live = self.scratch.list_live(self.view.cloud, |_| true);
        let (order, members) = (&mut *self.scratch.order, &*self.scratch.members);
        if let (Some(order), Some(members)) = (order.get_mut(..live), members.get(..live)) {
            order.copy_from_slice(members);
            kdtree::build(self.view.cloud, order);
        }
    }

    fn trial(&mut self, observer: &mut impl Observer) -> Step {
        let Self { config, view, live, seeds, scratch, stream, search, .. } = self;
        match search {
            Search::None => self.missed(),
            Search::Varsac(varsac) => {
                varsac.trial(config, view.cloud, *live, scratch, stream, observer);
                if varsac.is_done() {
                    let Some(best) = varsac.best else { return self.missed() };
                    self.phase = Phase::Refit { surface: best.surface, done: 0 };
                }
                Step::Working
            }
            Search::Map(map) => match map.step(config, view, *seeds, scratch, stream, observer) {
                Progress::Working => Step::Working,
                Progress::Nothing => self.missed(),
                Progress::Found(solution) => self.judge(&solution, observer),
            },
        }
    }

    /// Claims the points of a solution of the default search, accepted or not: what was refused once must not be found
    /// again.
    fn judge(&mut self, solution: &Solution, observer: &mut impl Observer) -> Step {
        let Solution { ellipsoid, terms, .. } = solution;
        let model = RayModel::new(ellipsoid, &terms.noise, terms.viewpoint);
        let count = self.scratch.list_live(self.view.cloud, |point| lies_on(&model, point, terms.window_mm));
        if count == 0 {
            return self.missed();
        }
        let mut findings = solution.findings;
        for other in &self.accepted {
            let separation = contact_function(ellipsoid, other);
            if separation < findings.separation {
                findings.separation = separation;
            }
        }
        let refusal = match solution.covariance {
            Some(_) => self.config.map.gate.refusal(&findings),
            None => Some(Refusal { code: RefusalCode::Singular, value: 0.0, limit: 0.0 }),
        };
        if refusal.is_none() {
            if self.accepted.is_full() {
                self.accepted.remove(0);
            }
            let _ = self.accepted.push(*ellipsoid);
        }
        let score = Score { inliers: u32::from(findings.explained), candidates: self.live };
        let detection = Detection {
            target: self.take(count),
            ellipsoid: *ellipsoid,
            score,
            report: self.report(),
            status: refusal.map_or(Status::Accepted, Status::Refused),
            covariance: solution.covariance,
            findings: Some(findings),
        };
        observer.detection(&detection);
        Step::Found(detection)
    }

    /// Gives the listed points to the next target; returns its number.
    fn take(&mut self, count: usize) -> u8 {
        self.targets += 1;
        for &index in self.scratch.members.get(..count).unwrap_or(&[]) {
            if let Some(label) = self.scratch.labels.get_mut(usize::from(index)) {
                *label = self.targets;
            }
            let seeds = if self.config.method == Method::Map { self.view.in_mask } else { usize::MAX };
            self.seeds -= u32::from(usize::from(index) < seeds);
        }
        self.live -= count as u32;
        self.last_inliers = count as u32;
        self.phase = Phase::Begin;
        self.targets
    }

    fn report(&self) -> VarsacReport {
        match &self.search {
            Search::None => VarsacReport::default(),
            Search::Varsac(varsac) => varsac.report,
            Search::Map(map) => map.report,
        }
    }

    /// "Optimization with the inner point": least squares on the inliers among all live points. A refit that is no
    /// valid ellipsoid is dropped and ends the refits, and so does one that changes no bit.
    fn refit(&mut self, surface: CentralQuadric, done: u8, observer: &mut impl Observer) -> Step {
        if done >= self.config.refits {
            self.phase = Phase::Claim { surface };
            return Step::Working;
        }
        let shell = Shell::new(&surface, self.config.shell);
        let count = self.scratch.list_live(self.view.cloud, |point| shell.contains(point));
        let inliers = self.scratch.members.get(..count).unwrap_or(&[]);
        self.phase = match valid_fit(self.config, self.view.cloud, inliers, self.config.constraint, observer)
        {
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
        let count = self.scratch.list_live(self.view.cloud, |point| shell.contains(point));
        if count < usize::from(self.config.min_inliers) {
            // The refit moved the surface off its points.
            return self.missed();
        }
        let score = Score { inliers: count as u32, candidates: self.live };
        let detection = Detection {
            target: self.take(count),
            ellipsoid: Ellipsoid::from(surface),
            score,
            report: self.report(),
            status: Status::Accepted,
            covariance: None,
            findings: None,
        };
        observer.detection(&detection);
        Step::Found(detection)
    }

    /// A search found nothing: the next one begins, if the configuration allows another.
    fn missed(&mut self) -> Step {
        self.failures += 1;
        self.phase = Phase::Begin;
        Step::Missed(self.report())
    }
}
