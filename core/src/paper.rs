//! Several targets with the paper's search, Steps 2 to 5: search, refit, take the inliers out, go on.

use crate::{
    CentralQuadric, Config, Detection, Ellipsoid, Finish, Observer, Score, Status, Step, VarsacReport,
    field::Field,
    tebc::Shell,
    varsac::{Varsac, valid_fit},
};

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

/// The state of a run of the paper's search.
#[derive(Debug, Clone)]
pub(crate) struct PaperRun {
    phase: Phase,
    search: Varsac,
    failures: u8,
    last_inliers: u32,
}

impl PaperRun {
    pub(crate) fn new(config: &Config) -> Self {
        Self { phase: Phase::Begin, search: Varsac::new(config), failures: 0, last_inliers: 0 }
    }

    pub(crate) fn step(&mut self, field: &mut Field<'_>, observer: &mut impl Observer) -> Step {
        match self.phase {
            Phase::Begin => self.begin(field),
            Phase::Search => self.trial(field, observer),
            Phase::Refit { surface, done } => self.refit(field, surface, done, observer),
            Phase::Claim { surface } => self.claim(field, &surface, observer),
            Phase::End(finish) => Step::Finished(finish),
        }
    }

    /// Step 5's rule, then the tree over what is left.
    fn begin(&mut self, field: &mut Field<'_>) -> Step {
        let config = field.config;
        let smallest = config.sample_sizes.iter().copied().min().unwrap_or(0);
        self.phase = if field.targets >= config.max_targets {
            Phase::End(Finish::Targets)
        } else if self.failures >= config.max_failures {
            Phase::End(Finish::Failures)
        } else if field.live < u32::from(smallest) || field.live < self.last_inliers {
            Phase::End(Finish::FewPoints)
        } else {
            self.search = Varsac::new(config);
            if config.radius == f32::INFINITY {
                field.scratch.list_live(field.view.cloud, |_| true);
            } else {
                field.plant();
            }
            Phase::Search
        };
        Step::Working
    }

    fn trial(&mut self, field: &mut Field<'_>, observer: &mut impl Observer) -> Step {
        let Field { config, view, live, scratch, stream, .. } = field;
        self.search.trial(config, view.cloud, *live, scratch, stream, observer);
        if !self.search.is_done() {
            return Step::Working;
        }
        let Some(best) = self.search.best else { return self.missed() };
        self.phase = Phase::Refit { surface: best.surface, done: 0 };
        Step::Working
    }

    /// "Optimization with the inner point": least squares on the inliers among all live points. A refit that is no
    /// valid ellipsoid is dropped and ends the refits, and so does one that changes no bit.
    fn refit(
        &mut self,
        field: &mut Field<'_>,
        surface: CentralQuadric,
        done: u8,
        observer: &mut impl Observer,
    ) -> Step {
        let Field { config, view, scratch, .. } = field;
        if done >= config.refits {
            self.phase = Phase::Claim { surface };
            return Step::Working;
        }
        let shell = Shell::new(&surface, config.shell);
        let count = scratch.list_live(view.cloud, |point| shell.contains(point));
        let inliers = scratch.members.get(..count).unwrap_or(&[]);
        self.phase = match valid_fit(config, view.cloud, inliers, config.constraint, observer) {
            Ok(better) if better != surface => {
                observer.refit(&better);
                Phase::Refit { surface: better, done: done + 1 }
            }
            _ => Phase::Claim { surface },
        };
        Step::Working
    }

    fn claim(
        &mut self,
        field: &mut Field<'_>,
        surface: &CentralQuadric,
        observer: &mut impl Observer,
    ) -> Step {
        let shell = Shell::new(surface, field.config.shell);
        let count = field.scratch.list_live(field.view.cloud, |point| shell.contains(point));
        if count < usize::from(field.config.min_inliers) {
            // The refit moved the surface off its points.
            return self.missed();
        }
        let score = Score { inliers: count as u32, candidates: field.live };
        self.last_inliers = score.inliers;
        self.phase = Phase::Begin;
        let detection = Detection {
            target: field.claim(count),
            ellipsoid: Ellipsoid::from(surface),
            score,
            report: self.search.report,
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

    fn report(&self) -> VarsacReport {
        self.search.report
    }
}
