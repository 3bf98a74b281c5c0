//! One trial: seed point, sample, start, steps: contract, chapter M11.

use super::algebra::{E1, E2, SQRT2, adj, cross, det, dot, exponentials, minus, product, solution};
use super::contact::Contact;
use super::model::{Estimate, Model};
use super::normal::{Follower, Normal, Residual, moments};
use super::prior::Terms;
use super::step::step;
use super::view::{MapConfig, View, Viewpoint};
use crate::fault::{self, Fault};
use crate::{Event, Phase, Point, Rejection, Stream, Symmetric, ascending, eigen};

/// M11, up to the support: an estimate from eight points drawn around a seed point.
pub(crate) fn hypothesis(
    view: &View,
    labels: &[u8],
    config: &MapConfig,
    stream: &mut Stream,
    observe: &mut dyn FnMut(Event),
) -> Result<Estimate, Rejection> {
    let terms = Terms::assumed(config);
    let mut seeds = Vec::new();
    for index in 0..view.in_mask {
        if labels[index] == 0 {
            seeds.push(index as u16);
        }
    }
    let seed = seeds[stream.below(seeds.len() as u32) as usize];
    observe(Event::SeedPoint(seed));
    let members = neighbourhood(view, labels, seed, 0.92 * config.long());
    observe(Event::Neighbourhood(members.clone()));
    let positions = stream.sample(members.len() as u32, 8).ok_or(Rejection::TooFewPoints)?;
    let mut sample = Vec::new();
    for position in positions {
        sample.push(members[position as usize]);
    }
    observe(Event::Sample(sample.clone()));
    let mut points = Vec::new();
    for &index in &sample {
        points.push(view.points[index as usize]);
    }
    let mut estimate = start(&points, view.points[seed as usize], &terms)?;
    for _ in 0..config.hypothesis_steps {
        estimate = sample_step(&estimate, &points, &terms).ok_or(Rejection::Degenerate)?;
    }
    observe(Event::Estimate(Phase::Hypothesis, estimate));
    Ok(estimate)
}

/// M11: the live points in the mask around the seed point, ascending.
fn neighbourhood(view: &View, labels: &[u8], seed: u16, radius: f32) -> Vec<u16> {
    let mut members = Vec::new();
    for index in super::evidence::listed(view, view.points[seed as usize], radius) {
        let in_mask = (index as usize) < view.in_mask || fault::is(Fault::Mask);
        if labels[index as usize] == 0 && in_mask {
            members.push(index);
        }
    }
    members
}

/// M11, start: the trace-normalised quadric, pulled towards a sphere.
fn start(points: &[Point], s: Point, terms: &Terms) -> Result<Estimate, Rejection> {
    let [long, _, short] = exponentials(terms.prior.mean);
    let scale = 1.0 / short;
    let mut matrix = [[0.0_f32; 9]; 9];
    let mut rhs = [0.0_f32; 9];
    for &p in points {
        let [x, y, z] = minus(p, s).map(|component| component * scale);
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let deviator = [E1 * (xx - yy), E2 * ((xx + yy) - 2.0 * zz)];
        let mixed = [SQRT2 * (x * y), SQRT2 * (x * z), SQRT2 * (y * z)];
        let row = [deviator[0], deviator[1], mixed[0], mixed[1], mixed[2], x, y, z, 1.0];
        let target = -((xx + yy) + zz);
        for i in 0..9 {
            for j in 0..=i {
                matrix[i][j] += (1.0 * row[i]) * row[j];
            }
            rhs[i] += row[i] * target;
        }
    }
    for i in 0..9 {
        matrix[i][i] += if i < 5 { 0.24 } else { 1e-4 };
    }
    let [e1, e2, e3, e4, e5, b1, b2, b3, _] = solution(&matrix, &rhs)?;
    let shape = Symmetric {
        xx: 1.0 + (E1 * e1 + E2 * e2),
        yy: 1.0 + (E2 * e2 - E1 * e1),
        zz: 1.0 - 2.0 * (E2 * e2),
        xy: E1 * e3,
        xz: E1 * e4,
        yz: E1 * e5,
    };
    let offset = centre_offset(&shape, [b1, b2, b3], s, [long, short], terms.viewpoint);
    let [first, second, third] = ascending(&eigen(&shape)).vectors;
    let third = if fault::is(Fault::Start) { third } else { cross(first, second) };
    Ok(Estimate {
        centre: [s[0] + offset[0], s[1] + offset[1], s[2] + offset[2]],
        axes: [first, second, third],
        x: terms.prior.mean,
        boxiness: 0.0,
    })
}

/// M11: from the seed point to the centre of the quadric, or straight behind it where that is no centre.
fn centre_offset(
    shape: &Symmetric,
    b: [f32; 3],
    s: Point,
    [long, short]: [f32; 2],
    viewpoint: Viewpoint,
) -> Point {
    let range = libm::sqrtf(dot(s, s));
    let v = if range > 0.0 { s.map(|component| component / range) } else { [0.0, 0.0, 1.0] };
    let g = product(&adj(shape), b.map(|component| 0.5 * component));
    let det = det(shape);
    let l = g.map(|component| (-(component / det)) * short);
    let depth = dot(l, v);
    let reach = dot(l, l);
    let behind = viewpoint == Viewpoint::None || (depth > 0.3 * short && depth < 1.2 * long);
    if det > 0.0 && behind && reach < (long * long) * 1.5 { l } else { v.map(|component| component * short) }
}

/// M11, steps: one step on the sample alone.
fn sample_step(estimate: &Estimate, points: &[Point], terms: &Terms) -> Option<Estimate> {
    let model = Model::new(estimate, terms.noise, terms.viewpoint);
    let mut residuals = Vec::new();
    for &p in points {
        let contact = Contact::new(&model, p);
        residuals.push(Residual::new(contact.u, contact.value, terms.told / contact.variance));
    }
    let (matrix, gradient) = moments(&residuals, &model.slopes());
    let mut normal = Normal { matrix, gradient, follower: Follower::default() };
    normal.add_prior(estimate, terms);
    step(estimate, &normal)
}
