//! The verdict on each fruit: what its size prior costs, its covariance, what the tests of acceptance look at.

use super::{
    FINAL_KERNEL, Fruit, REACH, SETTLED_SQUARED, Standing, distance_squared,
    measures::{end_on, outline_fit, separation, shape_of_points, visible},
};
use crate::{
    Detection, Observer, Point3, Score, Stage, Status,
    accept::{Findings, Refusal, RefusalCode},
    covariance::covariance,
    field::Field,
    prior::SizePrior,
    refine::{Estimate, Evidence, Normal, Terms},
    size::{SizeEvidence, size_evidence},
};

/// What one step came to.
#[allow(clippy::large_enum_variant, reason = "no heap to box into; it lives for the length of one call")]
pub(crate) enum Progress {
    Working,
    Judged(Detection),
    Done,
}

/// What the next step does for the fruit whose turn it is. Each looks at all of its points once or, the last, twice
/// without derivatives.
#[derive(Debug, Clone, Copy)]
#[allow(clippy::large_enum_variant, reason = "no heap to box into; a run has room for larger states")]
enum Task {
    /// A step of the fit with the size set almost free, from the free fit so far; the first one lists the members too.
    Free { free: Option<Estimate>, steps: u8 },
    /// The normal equations at its estimate.
    Normal { free: Estimate },
    /// Those at the free fit, and what both say about the size.
    Size { free: Estimate, normal: Normal },
    /// All the rest, and the answer.
    Verdict { normal: Normal, size: SizeEvidence },
}

/// Who is judged, and how far that is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judge {
    turn: u8,
    task: Task,
    members: usize,
}

impl Judge {
    pub(crate) fn new() -> Self {
        Self { turn: 0, task: Task::Free { free: None, steps: 0 }, members: 0 }
    }

    /// One step for one fruit; the last of its steps gives the verdict.
    pub(crate) fn step(
        &mut self,
        field: &mut Field<'_>,
        found: &mut [Fruit],
        observer: &mut impl Observer,
    ) -> Progress {
        let Some(fruit) = found.get(usize::from(self.turn)) else { return Progress::Done };
        let best = &fruit.estimate;
        if matches!(self.task, Task::Free { free: None, .. }) {
            let [x, y, z] = best.centre;
            let long = field.config.map.prior.semi_axes_mm[0];
            self.members = field.list_within(&Point3::new(x, y, z), REACH * long);
        }
        let evidence = Evidence::of(field, self.members, self.turn + 1);
        self.task = match &self.task {
            Task::Free { free, steps } => {
                let free = free.unwrap_or(*best);
                let next = free.step(&evidence.normal(&free, &loose(field, fruit), FINAL_KERNEL));
                let moved = next.unwrap_or(free);
                observer.estimate(Stage::Free, &moved);
                let settled = next.is_none() || distance_squared(&moved, &free) < SETTLED_SQUARED;
                if settled || steps + 1 >= field.config.map.final_steps {
                    Task::Normal { free: moved }
                } else {
                    Task::Free { free: Some(moved), steps: steps + 1 }
                }
            }
            Task::Normal { free } => {
                Task::Size { free: *free, normal: evidence.normal(best, &fruit.terms, FINAL_KERNEL) }
            }
            Task::Size { free, normal } => {
                let (tight, loose) = (&fruit.terms.prior, &loose(field, fruit));
                let without = evidence.normal(free, loose, FINAL_KERNEL);
                let size = size_evidence(normal, &best.ln_axes, &without, &free.ln_axes, tight, &loose.prior);
                Task::Verdict { normal: *normal, size }
            }
            Task::Verdict { normal, size } => {
                let Some(detection) = verdict(field, &evidence, found, self.turn, normal, *size) else {
                    return Progress::Done;
                };
                if detection.status == Status::Accepted
                    && let Some(fruit) = found.get_mut(usize::from(self.turn))
                {
                    fruit.standing = Standing::Accepted;
                }
                *self = Self { turn: self.turn + 1, ..Self::new() };
                return Progress::Judged(detection);
            }
        };
        Progress::Working
    }
}

/// The terms of a fruit's fit with the size set almost free.
fn loose(field: &Field<'_>, fruit: &Fruit) -> Terms {
    let prior = SizePrior {
        spread: [1.0; 3],
        spread_ab: f32::INFINITY,
        spread_bc: f32::INFINITY,
        ..field.config.map.prior
    };
    Terms { prior: prior.term(), ..fruit.terms }
}

/// Everything that is asked of a fruit, and the answer.
fn verdict(
    field: &Field<'_>,
    evidence: &Evidence<'_>,
    found: &[Fruit],
    turn: u8,
    normal: &Normal,
    size: SizeEvidence,
) -> Option<Detection> {
    let fruit = found.get(usize::from(turn))?;
    let (config, terms, best) = (&field.config.map, &fruit.terms, &fruit.estimate);
    let assumed = Terms { noise: config.noise, outline: 1.0, ..*terms };
    let (ellipsoid, order) = best.sorted();
    let support = evidence.support(best, &assumed, f32::NEG_INFINITY).unwrap_or_default();
    let (outline_rays, outline) = outline_fit(evidence, best, terms);
    let points = shape_of_points(evidence, best, &assumed, field.view.in_mask);
    let by = &config.inflation;
    let inflation = by.base + by.per_conflict * size.conflict + by.per_clutter * points.clutter;
    let covariance = covariance(normal, best, &ellipsoid, order, inflation);
    let findings = Findings {
        explained: support.explained,
        through: support.through,
        size_conflict: size.conflict,
        end_on: end_on(&ellipsoid, terms.viewpoint),
        size_sigma: size.sigma,
        rival: fruit.rival,
        outline_rays,
        outline,
        visible: visible(points.count, &ellipsoid, field.view.pitch_rad),
        colour: points.outside,
        sigma_mm: covariance.map_or(f32::INFINITY, |c| c.sigma_centre_max_mm()),
        flat: points.flat,
        separation: separation(found, turn, &ellipsoid),
        clutter: points.clutter,
    };
    let findings = findings.known();
    let refusal = match covariance {
        Some(_) => config.gate.refusal(&findings),
        None => Some(Refusal { code: RefusalCode::Singular, value: 0.0, limit: 0.0 }),
    };
    Some(Detection {
        target: turn + 1,
        ellipsoid,
        score: Score { inliers: u32::from(support.explained), candidates: fruit.candidates },
        report: fruit.report,
        status: refusal.map_or(Status::Accepted, Status::Refused),
        covariance,
        findings: Some(findings),
    })
}
