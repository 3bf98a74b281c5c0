//! A run over one cloud: from a checked configuration to located fruit, one bounded step at a time.
//!
//! [`Detector`] holds a checked configuration. [`Detections`] is one run over one cloud: an iterator that yields a
//! fruit per `next()`, or, for a firmware loop that must not be held up, a machine that does one bounded piece of work
//! per [`Detections::step`]. Which search runs is the configuration's choice ([`Method`]). The run ends, whatever the
//! cloud: each target claims at least one point, and targets, failed searches and trials are all bounded by the
//! configuration.

use crate::{
    CloudError, Config, ConfigError, Ellipsoid, MAX_OUTLINE, Method, Observer, Point3, Score, VarsacReport,
    Viewpoint,
    accept::{Findings, Refusal},
    covariance::Covariance,
    field::{Field, View},
    map::MapRun,
    mixture::MixtureRun,
    paper::PaperRun,
    point::check_cloud,
    rng::Stream,
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
    /// Its points among all that were unclaimed before this target: the score that the paper's tables report.
    pub score: Score,
    /// What the search did. Its `support` is the score within the neighbourhood, the `w` of Eq. (17).
    pub report: VarsacReport,
    /// Accepted, or why not. The paper's search accepts all it finds.
    pub status: Status,
    /// How sure; none from the paper's search, nor where the normal equations are singular or their inverse not finite.
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

/// Why a run is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Finish {
    /// Fewer points are left than a sample needs, or (Step 5 of the paper) than the last target had inliers.
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
    /// As [`Self::detect`]; more outline rays than [`MAX_OUTLINE`]. The coordinates of rays are not checked: one that is not
    /// finite fits no model.
    pub fn detect_view<'a>(
        &'a self,
        view: &View<'a>,
        scratch: Scratch<'a>,
        seed: u64,
    ) -> Result<Detections<'a>, CloudError> {
        check_cloud(view.cloud, scratch.capacity())?;
        if view.outline.len() > MAX_OUTLINE {
            return Err(CloudError::TooManyRays { count: view.outline.len() as u32 });
        }
        // Without a viewpoint there are no rays, and no pixels to count.
        let viewpoint = match self.config.method {
            Method::Mixture => self.config.mixture.viewpoint,
            Method::Map | Method::Varsac => self.config.map.viewpoint,
        };
        let view = match viewpoint {
            Viewpoint::Origin => *view,
            Viewpoint::None => View { outline: &[], pitch_rad: 0.0, ..*view },
        };
        let points = view.cloud.len();
        let Scratch { lists, finds } = scratch;
        if let Some(labels) = lists.labels.get_mut(..points) {
            labels.fill(0);
        }
        let in_mask = if view.in_mask < points { view.in_mask } else { points };
        Ok(Detections {
            field: Field {
                config: &self.config,
                view: View { in_mask, ..view },
                scratch: lists,
                stream: Stream::new(seed),
                live: points as u32,
                seeds: in_mask as u32,
                targets: 0,
            },
            run: match self.config.method {
                Method::Varsac => Run::Paper(PaperRun::new(&self.config)),
                Method::Map => Run::Map(MapRun::new(&self.config, finds)),
                Method::Mixture => Run::Mixture(MixtureRun::new()),
            },
        })
    }
}

/// The search that runs.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "no heap to box into; one lives in each run")]
enum Run<'a> {
    Paper(PaperRun),
    Map(MapRun<'a>),
    Mixture(MixtureRun),
}

/// One run over one cloud.
#[derive(Debug)]
pub struct Detections<'a> {
    field: Field<'a>,
    run: Run<'a>,
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
    /// One bounded piece of work, `O(n)` but for the tree that is made before a search, `O(n log n)`.
    pub fn step(&mut self) -> Step {
        self.step_observed(&mut ())
    }

    /// [`Self::step`] under the eyes of an observer.
    pub fn step_observed(&mut self, observer: &mut impl Observer) -> Step {
        match &mut self.run {
            Run::Paper(run) => run.step(&mut self.field, observer),
            Run::Map(run) => run.step(&mut self.field, observer),
            Run::Mixture(run) => run.step(&mut self.field),
        }
    }

    /// For each point of the cloud 0, or the number of the target that claimed it.
    pub fn labels(&self) -> &[u8] {
        self.field.scratch.labels.get(..self.field.view.cloud.len()).unwrap_or(&[])
    }

    /// Points that no target has claimed.
    pub fn live(&self) -> u32 {
        self.labels().iter().map(|&label| u32::from(label == 0)).sum()
    }
}
