//! The default search: fruit of known size in a view from one side, as many as there are, each accepted or refused.
//!
//! 1. [`search`]: one fruit after the other is found and its points are claimed, until a search finds nothing.
//! 2. [`joint`]: fruit near each other are refitted together, each point going to the model it lies nearest.
//! 3. [`judge`]: each in turn, in the order found: covariance, findings, acceptance ([`crate::accept`]).
//!
//! So the first fruit is handed out when the last has been found: what a fruit is depends on what lies beside it.

mod config;
mod joint;
mod judge;
mod measures;
mod noise;
pub(crate) mod search;

use heapless::Vec;

pub use self::config::MapConfig;

use self::{
    joint::Joint,
    judge::Judge,
    search::{MapSearch, Progress},
};
use crate::{
    Config, Finish, Observer, Step, VarsacReport,
    field::Field,
    hypothesis::SAMPLE,
    refine::{Estimate, Kernel, Terms},
    residual::{RayModel, dot},
    visibility::CUT,
};

/// Most fruit of one cloud: their state is kept until all are found.
pub const MAX_FRUIT: usize = 32;

/// Reach of the points that bear on a model, from its centre, in units of the longest semi-axis.
pub(crate) const REACH: f32 = 1.25;
/// Window along the ray in units of the shortest semi-axis.
const WINDOW: f32 = 0.55;
/// `4^2`.
pub(crate) const FINAL_KERNEL: Kernel = Kernel::Tukey(16.0);
/// A step of the centre shorter than this (mm, squared) ends the fit.
pub(crate) const SETTLED_SQUARED: f32 = 4e-4;

/// Longest and shortest semi-axis of the prior, mm: the unit of all lengths of the search.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    pub(crate) long: f32,
    pub(crate) short: f32,
}

/// How a fruit stands to the others of its cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Standing {
    /// Nothing near.
    Alone,
    /// Others are near: refitted with them.
    Contested,
    /// It lies in another one that explains more: not refitted, and its points are the other's.
    Ghost,
    /// Judged and accepted.
    Accepted,
}

/// A found fruit, before it is judged. The k-th has the label k + 1.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fruit {
    pub(crate) estimate: Estimate,
    pub(crate) terms: Terms,
    /// Support when it was chosen.
    pub(crate) score: f32,
    /// Score of its best rival over its own.
    pub(crate) rival: f32,
    pub(crate) report: VarsacReport,
    /// Points that were live when it was found.
    pub(crate) candidates: u32,
    pub(crate) standing: Standing,
}

/// Where a run stands between two steps.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "no heap to box into; one lives in each run")]
enum Phase {
    /// The next search has to be prepared (or not begun at all).
    Begin,
    Search(MapSearch),
    Joint(Joint, Finish),
    Judge(Judge, Finish),
    /// Over.
    End(Finish),
}

/// Room for what one run finds, until all of it is judged: up to [`MAX_FRUIT`] fruit.
#[derive(Debug, Clone)]
pub struct Finds(Vec<Fruit, MAX_FRUIT>);

impl Finds {
    /// Nothing yet.
    pub const fn new() -> Self {
        Self(Vec::new())
    }
}

impl Default for Finds {
    fn default() -> Self {
        Self::new()
    }
}

/// The state of a run.
#[derive(Debug)]
pub(crate) struct MapRun<'a> {
    phase: Phase,
    failures: u8,
    terms: Terms,
    scale: Scale,
    found: &'a mut Vec<Fruit, MAX_FRUIT>,
}

impl<'a> MapRun<'a> {
    pub(crate) fn new(config: &Config, Finds(found): &'a mut Finds) -> Self {
        found.clear();
        let map = &config.map;
        let [long, _, short] = map.prior.semi_axes_mm;
        let terms = Terms {
            prior: map.prior.term(),
            noise: map.noise,
            outline: 1.0,
            viewpoint: map.viewpoint,
            window_mm: WINDOW * short,
            offset_rad: map.outline_offset_rad,
            boxiness: 0.0,
            independence: map.independence,
        };
        Self { phase: Phase::Begin, failures: 0, terms, scale: Scale { long, short }, found }
    }

    // A frame of its own: the paper's search must not pay for it on the stack.
    #[inline(never)]
    pub(crate) fn step(&mut self, field: &mut Field<'_>, observer: &mut impl Observer) -> Step {
        match &mut self.phase {
            Phase::Begin => {
                self.begin(field);
                Step::Working
            }
            Phase::Search(search) => match search.step(field, observer) {
                Progress::Working => Step::Working,
                Progress::Nothing => {
                    self.failures += 1;
                    let report = search.report;
                    self.phase = Phase::Begin;
                    Step::Missed(report)
                }
                Progress::Found(fruit) => self.found(field, fruit),
            },
            Phase::Joint(joint, finish) => {
                if !joint.step(field, self.found, observer) {
                    self.phase = Phase::Judge(Judge::new(), *finish);
                }
                Step::Working
            }
            Phase::Judge(judge, finish) => match judge.step(field, self.found, observer) {
                judge::Progress::Working => Step::Working,
                judge::Progress::Judged(detection) => {
                    observer.detection(&detection);
                    Step::Found(detection)
                }
                judge::Progress::Done => {
                    self.phase = Phase::End(*finish);
                    Step::Working
                }
            },
            Phase::End(finish) => Step::Finished(*finish),
        }
    }

    /// The next search, or none: too few points, enough targets, or nothing found lately. The tree is made once, over all
    /// points: a claimed point still shows where other fruit are not.
    fn begin(&mut self, field: &mut Field<'_>) {
        let config = field.config;
        let finish = if field.targets >= config.max_targets || self.found.is_full() {
            Finish::Targets
        } else if self.failures >= config.max_failures {
            Finish::Failures
        } else if field.seeds < SAMPLE as u32 {
            Finish::FewPoints
        } else {
            if self.found.is_empty() && self.failures == 0 {
                field.plant();
            }
            self.phase = Phase::Search(MapSearch::new(config, &self.terms, self.scale));
            return;
        };
        joint::sort_out(field, self.found);
        self.phase = Phase::Joint(Joint::new(), finish);
    }

    /// Claims the points on a fruit, to be judged later: what was found once must not be found again.
    fn found(&mut self, field: &mut Field<'_>, fruit: Fruit) -> Step {
        let model = RayModel::new(&fruit.estimate.ellipsoid(), &self.terms.noise, self.terms.viewpoint);
        let window = self.terms.window_mm;
        let count = field.scratch.list_live(field.view.cloud, |point| {
            let contact = model.contact(point);
            contact.square() < 2.0 * CUT && contact.gap_mm < window && contact.gap_mm > -window
        });
        self.phase = Phase::Begin;
        if count == 0 {
            self.failures += 1;
            return Step::Missed(fruit.report);
        }
        field.claim(count);
        let _ = self.found.push(fruit);
        Step::Working
    }
}

/// Squared distance of two centres.
pub(crate) fn distance_squared(a: &Estimate, b: &Estimate) -> f32 {
    let d = [a.centre[0] - b.centre[0], a.centre[1] - b.centre[1], a.centre[2] - b.centre[2]];
    dot(d, d)
}
