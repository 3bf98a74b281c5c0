//! The verdict on each fruit: what its size prior costs, its covariance, what the tests of acceptance look at.

use super::{FINAL_KERNEL, Fruit, REACH, SETTLED_SQUARED, Standing, distance_squared};
use crate::{
    Detection, Ellipsoid, Observer, Point3, Score, Stage, Status,
    accept::{Findings, Refusal, RefusalCode, contact_function},
    covariance::covariance,
    field::Field,
    jacobi::{Symmetric3, eigen},
    point::at,
    prior::SizePrior,
    refine::{Estimate, Evidence, Terms},
    residual::{RayModel, Viewpoint, dot},
    size::size_evidence,
    visibility::{Sight, predicted_pixels, sight},
};

/// What one step came to.
#[allow(clippy::large_enum_variant, reason = "no heap to box into; it lives for the length of one call")]
pub(crate) enum Progress {
    Working,
    Judged(Detection),
    Done,
}

/// Who is judged, and its fit with the size set almost free.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judge {
    turn: u8,
    /// The free fit so far; none before its first step.
    free: Option<Estimate>,
    steps: u8,
    members: usize,
}

impl Judge {
    pub(crate) fn new() -> Self {
        Self { turn: 0, free: None, steps: 0, members: 0 }
    }

    /// One step of the free fit of one fruit; after the last its verdict.
    pub(crate) fn step(
        &mut self,
        field: &mut Field<'_>,
        found: &mut [Fruit],
        observer: &mut impl Observer,
    ) -> Progress {
        let Some(fruit) = found.get(usize::from(self.turn)) else { return Progress::Done };
        if self.free.is_none() {
            let [x, y, z] = fruit.estimate.centre;
            let long = field.config.map.prior.semi_axes_mm[0];
            self.members = field.list_within(&Point3::new(x, y, z), REACH * long);
        }
        let free = self.free.unwrap_or(fruit.estimate);
        let config = &field.config.map;
        let loose = SizePrior {
            spread: [1.0; 3],
            spread_ab: f32::INFINITY,
            spread_bc: f32::INFINITY,
            ..config.prior
        };
        let loose = Terms { prior: loose.term(), ..fruit.terms };
        let evidence = Evidence::of(field, self.members, self.turn + 1);
        if self.steps < config.final_steps {
            let next = free.step(&evidence.normal(&free, &loose, FINAL_KERNEL));
            let moved = next.unwrap_or(free);
            observer.estimate(Stage::Free, &moved);
            let settled = next.is_none() || distance_squared(&moved, &free) < SETTLED_SQUARED;
            self.steps = if settled { config.final_steps } else { self.steps + 1 };
            self.free = Some(moved);
            return Progress::Working;
        }
        let Some(detection) = verdict(field, &evidence, found, self.turn, &free, &loose) else {
            return Progress::Done;
        };
        if detection.status == Status::Accepted
            && let Some(fruit) = found.get_mut(usize::from(self.turn))
        {
            fruit.standing = Standing::Accepted;
        }
        *self = Self { turn: self.turn + 1, ..Self::new() };
        Progress::Judged(detection)
    }
}

/// Everything that is asked of a fruit, and the answer.
fn verdict(
    field: &Field<'_>,
    evidence: &Evidence<'_>,
    found: &[Fruit],
    turn: u8,
    free: &Estimate,
    loose: &Terms,
) -> Option<Detection> {
    let fruit = found.get(usize::from(turn))?;
    let (config, terms, best) = (&field.config.map, &fruit.terms, &fruit.estimate);
    let assumed = Terms { noise: config.noise, outline: 1.0, ..*terms };
    let normal = evidence.normal(best, terms, FINAL_KERNEL);
    let without = evidence.normal(free, loose, FINAL_KERNEL);
    let size = size_evidence(&normal, &best.ln_axes, &without, &free.ln_axes, &terms.prior, &loose.prior);
    let (ellipsoid, order) = best.sorted();
    let support = evidence.support(best, &assumed, f32::NEG_INFINITY).unwrap_or_default();
    let (outline_rays, outline) = outline_fit(evidence, best, terms);
    let points = shape_of_points(evidence, best, &assumed, field.view.in_mask);
    let by = &config.inflation;
    let inflation = by.base + by.per_conflict * size.conflict + by.per_clutter * points.clutter;
    let covariance = covariance(&normal, best, &ellipsoid, order, inflation);
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

/// A body counts as elongated when its long semi-axis is this many times the middle one.
const ELONGATED: f32 = 1.3;

/// See [`Findings::end_on`].
fn end_on(ellipsoid: &Ellipsoid, viewpoint: Viewpoint) -> f32 {
    let [a, b, _] = ellipsoid.semi_axes;
    if viewpoint == Viewpoint::None || a < ELONGATED * b {
        return 0.0;
    }
    let centre = [ellipsoid.centre.x, ellipsoid.centre.y, ellipsoid.centre.z];
    libm::fabsf(dot(ellipsoid.axes[0], centre)) / libm::sqrtf(dot(centre, centre))
}

/// Seen on the surface, in the mask or not, over predicted pixels; infinite where the pitch is not known.
fn visible(seen: f32, ellipsoid: &Ellipsoid, pitch_rad: f32) -> f32 {
    if pitch_rad > 0.0 && ellipsoid.centre.z > 0.0 {
        seen / predicted_pixels(ellipsoid, pitch_rad)
    } else {
        f32::INFINITY
    }
}

/// The contact function with the nearest fruit that was accepted before; for a ghost, with any that is none.
fn separation(found: &[Fruit], turn: u8, ellipsoid: &Ellipsoid) -> f32 {
    let ghost = found.get(usize::from(turn)).is_some_and(|fruit| fruit.standing == Standing::Ghost);
    let mut least = f32::INFINITY;
    for (j, other) in found.iter().enumerate() {
        let counts = other.standing == Standing::Accepted || (ghost && other.standing != Standing::Ghost);
        if counts && j != usize::from(turn) {
            let separation = contact_function(ellipsoid, &other.estimate.ellipsoid());
            if separation < least {
                least = separation;
            }
        }
    }
    least
}

/// Outline rays that can be the model's, and the mean of `min(|f|, 3)` over them.
#[inline(never)]
fn outline_fit(evidence: &Evidence<'_>, best: &Estimate, terms: &Terms) -> (u16, f32) {
    let ellipsoid = best.ellipsoid();
    let model = RayModel::new(&ellipsoid, &terms.noise, terms.viewpoint);
    let mut count = 0_u16;
    let mut sum = 0.0;
    for touch in evidence.touches(&model, &ellipsoid, terms) {
        let size = libm::sqrtf(touch.square(best.boxiness));
        sum += if size < 3.0 { size } else { 3.0 };
        count += 1;
    }
    (count, if count == 0 { 0.0 } else { sum / f32::from(count) })
}

/// What the points near a model look like.
struct PointShape {
    /// Points on its surface, in the mask or not.
    count: f32,
    /// Rms distance of the explained points from their best plane over their rms distance from the model.
    flat: f32,
    /// Share of the explained points outside the mask.
    outside: f32,
    /// Points near the model that it does not explain, over those it does.
    clutter: f32,
}

/// Unexplained points count as near within twice the window and `f^2 < 100`.
const CLUTTER_CUT: f32 = 100.0;

#[inline(never)]
fn shape_of_points(evidence: &Evidence<'_>, best: &Estimate, terms: &Terms, in_mask: usize) -> PointShape {
    let ellipsoid = best.ellipsoid();
    let model = RayModel::new(&ellipsoid, &terms.noise, terms.viewpoint);
    let c = ellipsoid.centre;
    let near_mm = 2.0 * terms.window_mm;
    let (mut n, mut outside, mut near, mut model_sum) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    let mut sum = [0.0_f32; 3];
    let mut square = Symmetric3::default();
    for &index in evidence.members {
        if !evidence.is_unclaimed(index) {
            continue;
        }
        let p = at(evidence.cloud, index);
        let contact = model.contact(&p);
        let Sight::Explained(_) = sight(&contact, terms.window_mm) else {
            let close = contact.gap_mm < near_mm && contact.gap_mm > -near_mm;
            near += if close && contact.square() < CLUTTER_CUT { 1.0 } else { 0.0 };
            continue;
        };
        n += 1.0;
        outside += if usize::from(index) >= in_mask { 1.0 } else { 0.0 };
        model_sum += (contact.value * contact.value) / model.gradient_squared(contact.u);
        let (x, y, z) = (p.x - c.x, p.y - c.y, p.z - c.z);
        sum[0] += x;
        sum[1] += y;
        sum[2] += z;
        square.xx += x * x;
        square.yy += y * y;
        square.zz += z * z;
        square.xy += x * y;
        square.xz += x * z;
        square.yz += y * z;
    }
    if n < 1.0 {
        return PointShape { count: 0.0, flat: 0.0, outside: 0.0, clutter: 0.0 };
    }
    let [x, y, z] = sum.map(|s| s / n);
    let scatter = Symmetric3 {
        xx: square.xx / n - x * x,
        yy: square.yy / n - y * y,
        zz: square.zz / n - z * z,
        xy: square.xy / n - x * y,
        xz: square.xz / n - x * z,
        yz: square.yz / n - y * z,
    };
    let ratio = eigen(&scatter).values[0] / (model_sum / n);
    let flat = if ratio > 0.0 { libm::sqrtf(ratio) } else { 0.0 };
    PointShape { count: n, flat, outside: outside / n, clutter: near / n }
}
