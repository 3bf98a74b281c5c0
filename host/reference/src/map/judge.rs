//! A fruit is judged: contract, chapter M18.

use super::accept::{Findings, Refusal, refusal};
use super::algebra::{PI, Vector, cross, dot, minus, unit};
use super::contact::{Contact, Kernel, Sight};
use super::covariance::{covariance, sigma_mm};
use super::evidence::{Evidence, listed};
use super::fruit::{Fruit, Standing};
use super::model::{Estimate, Model, apart2};
use super::neighbours::{Body, contact_function};
use super::normal::normal_equations;
use super::prior::{Prior, Terms};
use super::size_evidence::size_evidence;
use super::step::step;
use super::support::support;
use super::view::{Inflation, MapConfig, View, Viewpoint};
use crate::ellipsoid::{angles, oriented, quaternion};
use crate::fault::{self, Fault};
use crate::jacobi::{ascending, eigen};
use crate::{Ellipsoid, Event, Phase, Report, Score, Symmetric};

/// A fruit as it is reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapDetection {
    /// The label of its points.
    pub target: u8,
    /// The sorted ellipsoid.
    pub ellipsoid: Ellipsoid,
    /// Explained points among all that were live before.
    pub score: Score,
    /// The search that found it.
    pub report: Report,
    /// Why it is refused, if it is.
    pub refusal: Option<Refusal>,
    /// Lower triangle by rows.
    pub covariance: Option<[f32; 45]>,
    /// What the tests looked at.
    pub findings: Findings,
}

/// M18: the detection of one of the fruit.
pub(crate) fn judged(
    view: &View,
    labels: &[u8],
    fruit: &[Fruit],
    index: usize,
    config: &MapConfig,
    observe: &mut dyn FnMut(Event),
) -> MapDetection {
    let this = &fruit[index];
    let (estimate, terms) = (&this.estimate, &this.terms);
    let members = listed(view, estimate.centre, 1.25 * config.long());
    let evidence = Evidence { view, labels, members: &members, label: this.label };
    let loose = Terms { prior: Prior::loose(config), ..*terms };
    let free = free_fit(estimate, evidence, &loose, config, observe);

    let h1 = normal_equations(estimate, evidence, terms, Kernel::Tukey(16.0));
    let h2 = normal_equations(&free, evidence, &loose, Kernel::Tukey(16.0));
    let size = size_evidence((estimate, &h1), (&free, &h2), &terms.prior, &loose.prior);
    let (sorted, order) = sorted(estimate);
    let assumed = Terms { noise: config.noise, wider: 1.0, ..*terms };
    let (explained, through) = match support(estimate, evidence, &assumed, f32::NEG_INFINITY) {
        Some(support) => (support.explained, support.through),
        None => (0, 0),
    };
    let (rays, outline) = outline(estimate, evidence, terms);
    let seen = points(estimate, evidence, &assumed);
    let Inflation { base, per_conflict, per_clutter } = config.inflation;
    let inflation = base + per_conflict * size.conflict + per_clutter * seen.clutter;
    let covariance = covariance(estimate, &h1, inflation, sorted.semi_axes, order);
    let findings = Findings {
        explained,
        through,
        conflict: size.conflict,
        end_on: end_on(&sorted, config.viewpoint),
        size_sigma: size.sigma,
        rival: this.rival,
        rays,
        outline,
        visible: visible(&sorted, seen.explained, view.pitch),
        colour: seen.colour,
        sigma_mm: sigma_mm(covariance.as_ref()),
        flat: seen.flat,
        separation: separation(&sorted, fruit, index),
        clutter: seen.clutter,
    }
    .known();
    MapDetection {
        target: this.label,
        ellipsoid: sorted,
        score: Score { inliers: explained, candidates: this.candidates },
        report: this.report,
        refusal: refusal(&findings, &config.gate, covariance.is_some()),
        covariance,
        findings,
    }
}

/// M18, free fit.
fn free_fit(
    estimate: &Estimate,
    evidence: Evidence,
    loose: &Terms,
    config: &MapConfig,
    observe: &mut dyn FnMut(Event),
) -> Estimate {
    let mut free = *estimate;
    for _ in 0..config.final_steps {
        let before = free;
        let taken = step(&before, &normal_equations(&before, evidence, loose, Kernel::Tukey(16.0)));
        free = taken.unwrap_or(before);
        observe(Event::Estimate(Phase::Free, free));
        if taken.is_none() || apart2(&free, &before) < 0.0004 {
            break;
        }
    }
    free
}

/// M18.3: the ellipsoid with its semi-axes in descending order, and their numbers in the estimate.
pub(crate) fn sorted(estimate: &Estimate) -> (Ellipsoid, [usize; 3]) {
    let sizes = estimate.semi_axes();
    let mut order = [0, 1, 2];
    for (first, second) in [(0, 1), (1, 2), (0, 1)] {
        if sizes[order[second]] > sizes[order[first]] {
            order.swap(first, second);
        }
    }
    let a = unit(estimate.axes[order[0]]);
    let b = estimate.axes[order[1]];
    let t = dot(a, b);
    let b = unit([b[0] - t * a[0], b[1] - t * a[1], b[2] - t * a[2]]);
    let (a, b) = (oriented(a), oriented(b));
    let axes = [a, b, cross(a, b)];
    let ellipsoid = Ellipsoid {
        centre: estimate.centre,
        semi_axes: order.map(|k| sizes[k]),
        axes,
        quaternion: quaternion(&axes),
        angles: angles(&axes),
    };
    (ellipsoid, order)
}

/// M18.5: how many rays fit, and the mean of their residuals.
fn outline(estimate: &Estimate, evidence: Evidence, terms: &Terms) -> (u32, f32) {
    let model = Model::new(estimate, terms.noise, terms.viewpoint);
    let touching = evidence.touching(&model, terms);
    let mut sum = 0.0;
    for touch in &touching {
        let r = libm::sqrtf(touch.f2(estimate.boxiness));
        sum += if r < 3.0 { r } else { 3.0 };
    }
    let rays = touching.len() as u32;
    (rays, if rays == 0 { 0.0 } else { sum / rays as f32 })
}

/// M18.6: what the points say, one by one.
struct Seen {
    explained: f32,
    flat: f32,
    colour: f32,
    clutter: f32,
}

/// M18.6.
fn points(estimate: &Estimate, evidence: Evidence, terms: &Terms) -> Seen {
    let model = Model::new(estimate, terms.noise, terms.viewpoint);
    let (mut near, mut n, mut outside, mut q) = (0.0, 0.0, 0.0, 0.0);
    let mut sum = [0.0; 3];
    let mut squares = Symmetric::default();
    for &member in evidence.members {
        if !evidence.unclaimed(member) {
            continue;
        }
        let p = evidence.point(member);
        let contact = Contact::new(&model, p);
        if let Sight::Explained(_) = contact.sight(terms.window) {
            n += 1.0;
            outside += if evidence.in_mask(member) { 0.0 } else { 1.0 };
            q += (contact.value * contact.value) / model.grad2(contact.u);
            let [x, y, z] = minus(p, estimate.centre);
            sum = [sum[0] + x, sum[1] + y, sum[2] + z];
            squares.xx += x * x;
            squares.yy += y * y;
            squares.zz += z * z;
            squares.xy += x * y;
            squares.xz += x * z;
            squares.yz += y * z;
        } else if contact.within(2.0 * terms.window) && contact.f2() < 100.0 {
            near += 1.0;
        }
    }
    if n < 1.0 {
        return Seen { explained: n, flat: 0.0, colour: 0.0, clutter: 0.0 };
    }
    let ratio = smallest_scatter(sum, squares, n) / (q / n);
    Seen {
        explained: n,
        flat: if ratio > 0.0 { libm::sqrtf(ratio) } else { 0.0 },
        colour: outside / n,
        clutter: near / n,
    }
}

/// M18.6: the variance of the points across their best plane.
fn smallest_scatter(sum: Vector, squares: Symmetric, n: f32) -> f32 {
    let [mx, my, mz] = if fault::is(Fault::Flat) {
        sum.map(|component| component * (1.0 / n))
    } else {
        sum.map(|component| component / n)
    };
    let scatter = Symmetric {
        xx: squares.xx / n - mx * mx,
        yy: squares.yy / n - my * my,
        zz: squares.zz / n - mz * mz,
        xy: squares.xy / n - mx * my,
        xz: squares.xz / n - mx * mz,
        yz: squares.yz / n - my * mz,
    };
    ascending(&eigen(&scatter)).values[0]
}

/// M18.8: points explained over those that a view of the whole fruit would have.
fn visible(e: &Ellipsoid, explained: f32, pitch: f32) -> f32 {
    let m = e.centre;
    let known = pitch > 0.0 && m[2] > 0.0;
    if !known {
        return f32::INFINITY;
    }
    let [a, b, c] = e.semi_axes;
    let [ra, rb, rc] = e.axes;
    let h = [(b * c) * dot(ra, m), (c * a) * dot(rb, m), (a * b) * dot(rc, m)];
    let area = PI * libm::sqrtf(dot(h, h));
    let f = pitch * m[2];
    let pixels = area / ((f * f) * m[2]);
    explained / pixels
}

/// M18.12: how nearly the long axis points at the camera.
fn end_on(e: &Ellipsoid, viewpoint: Viewpoint) -> f32 {
    let [a, b, _] = e.semi_axes;
    if viewpoint == Viewpoint::None || a < 1.3 * b {
        return 0.0;
    }
    libm::fabsf(dot(e.axes[0], e.centre)) / libm::sqrtf(dot(e.centre, e.centre))
}

/// M18.10: the contact function with the nearest of the fruit that count.
fn separation(sorted: &Ellipsoid, fruit: &[Fruit], index: usize) -> f32 {
    let this = Body { centre: sorted.centre, semi_axes: sorted.semi_axes, axes: sorted.axes };
    let mut least = f32::INFINITY;
    for (number, other) in fruit.iter().enumerate() {
        let counts = if fruit[index].standing == Standing::Ghost {
            other.standing != Standing::Ghost
        } else {
            other.standing == Standing::Accepted
        };
        if number != index && counts {
            let value = contact_function(&this, &Body::of(&other.estimate));
            if value < least {
                least = value;
            }
        }
    }
    least
}
