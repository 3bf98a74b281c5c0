//! Several bodies in one cloud: search, judge, take the points out, go on.
//!
//! Every body found is handed out, refused ones with their reason: what lies on a plane is not looked for again. A body that
//! explains too little ([`RefusalCode::FewPoints`], [`RefusalCode::Clutter`]) tells that nothing is left; it is handed out only
//! if it is the first, so that a cloud without any body is answered with the reason.

use crate::{
    Config, Detection, Finish, Point3, Score, Status, Step, VarsacReport,
    accept::RefusalCode,
    field::Field,
    mixture::{MIN_POINTS, MixtureConfig, MixtureProgress, MixtureSearch, MixtureSolution},
    residual::{Noise, RayModel, Viewpoint},
};

/// Where a run stands between two steps.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "no heap to box into; one lives in each run")]
enum Phase {
    Begin,
    Search(MixtureSearch),
    Claim(MixtureSolution),
    End(Finish),
}

/// The state of a run.
#[derive(Debug, Clone)]
pub(crate) struct MixtureRun {
    phase: Phase,
    failures: u8,
}

/// A point within three standard deviations (squared) is the body's.
const CLAIM: f32 = 9.0;
/// Window along the ray over the shortest semi-axis.
const WINDOW: f32 = 0.55;

impl MixtureRun {
    pub(crate) fn new() -> Self {
        Self { phase: Phase::Begin, failures: 0 }
    }

    // A frame of its own: the other searches must not pay for it on the stack.
    #[inline(never)]
    pub(crate) fn step(&mut self, field: &mut Field<'_>) -> Step {
        let config = field.config;
        match &mut self.phase {
            Phase::Begin => {
                self.phase = self.begin(config, field);
                Step::Working
            }
            Phase::Search(search) => {
                match search.work(&config.mixture, &field.view, &mut field.scratch, &mut field.stream) {
                    MixtureProgress::Working => Step::Working,
                    MixtureProgress::Nothing(_) => self.missed(report(config, None, field.live)),
                    MixtureProgress::Found(solution) => {
                        self.phase = Phase::Claim(solution);
                        Step::Working
                    }
                }
            }
            Phase::Claim(solution) => {
                let solution = *solution;
                self.found(field, &solution)
            }
            Phase::End(finish) => Step::Finished(*finish),
        }
    }

    fn begin(&self, config: &Config, field: &Field<'_>) -> Phase {
        if field.targets >= config.max_targets {
            Phase::End(Finish::Targets)
        } else if self.failures >= config.max_failures {
            Phase::End(Finish::Failures)
        } else if (field.live as usize) < MIN_POINTS {
            Phase::End(Finish::FewPoints)
        } else {
            Phase::Search(MixtureSearch::new())
        }
    }

    fn missed(&mut self, report: VarsacReport) -> Step {
        self.failures += 1;
        self.phase = Phase::Begin;
        Step::Missed(report)
    }

    fn found(&mut self, field: &mut Field<'_>, solution: &MixtureSolution) -> Step {
        let report = report(field.config, Some(solution), field.live);
        let code = solution.refusal.map(|refusal| refusal.code);
        let exhausted = matches!(code, Some(RefusalCode::FewPoints | RefusalCode::Clutter));
        if exhausted && field.targets > 0 {
            return self.missed(report);
        }
        let claim = Claim::new(solution, &field.config.mixture);
        let count = field.scratch.list_live(field.view.cloud, |point| claim.holds(point));
        if count == 0 {
            return self.missed(report);
        }
        self.failures += u8::from(exhausted);
        self.phase = Phase::Begin;
        let score = Score { inliers: count as u32, candidates: field.live };
        Step::Found(Detection {
            target: field.claim(count),
            ellipsoid: solution.ellipsoid,
            score,
            report,
            status: solution.refusal.map_or(Status::Accepted, Status::Refused),
            covariance: solution.covariance,
            findings: None,
        })
    }
}

/// Starts, and the members of what was found.
fn report(config: &Config, solution: Option<&MixtureSolution>, live: u32) -> VarsacReport {
    let starts = 1 + u32::from(config.mixture.starts);
    let members = solution.map_or(0, |solution| solution.findings.members as u32);
    let support = Score { inliers: members, candidates: live };
    VarsacReport { trials: starts, bound: starts, support, ..VarsacReport::default() }
}

/// Which points are a body's.
struct Claim {
    model: RayModel,
    viewpoint: Viewpoint,
    window: f32,
}

impl Claim {
    fn new(solution: &MixtureSolution, config: &MixtureConfig) -> Self {
        let ratio = config.noise.lateral_rad / config.noise.axial_mm;
        let noise = Noise { axial_mm: solution.sigma, lateral_rad: solution.sigma * ratio };
        let model = RayModel::new(&solution.ellipsoid, &noise, config.viewpoint);
        let window = WINDOW * solution.ellipsoid.semi_axes[2];
        Self { model, viewpoint: config.viewpoint, window }
    }

    fn holds(&self, point: &Point3) -> bool {
        let contact = match self.viewpoint {
            Viewpoint::None => self.model.perpendicular(point),
            Viewpoint::Origin => self.model.contact(point),
        };
        contact.square() < CLAIM && contact.gap_mm < self.window && contact.gap_mm > -self.window
    }
}
