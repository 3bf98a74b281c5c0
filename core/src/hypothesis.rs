//! A hypothesis from eight points: a ridge fit for the direction, the prior for the size, a few steps along the rays.
//!
//! The ridge fit is the trace-normalised quadric `|x|^2 + x^T E x + 2 b.x + d = 0` with `E` symmetric and free of
//! trace (five numbers, in a basis that is orthonormal in the Frobenius norm), minimised with `ridge |E|^2` added.
//! It is a sphere pulled into an ellipsoid as far as the points insist, the same in every frame, and needs no more
//! than five points. Only its centre and the order and directions of its axes are used.

use crate::{
    Point3,
    jacobi::{self, Symmetric3},
    linalg::{N, Symmetric9},
    moments::Moments,
    point::at,
    prior::SizeTerm,
    refine::{Estimate, Normal, Terms},
    residual::{RayModel, Viewpoint},
};

/// Points of a hypothesis.
pub(crate) const SAMPLE: usize = 8;
/// Pull of the deviator towards the sphere, per point.
pub(crate) const RIDGE: f32 = 0.03;
/// Makes a hypothesis from sampled points; `seed` is the point the sample was drawn around.
pub(crate) fn hypothesis(
    cloud: &[Point3],
    sample: &[u16; SAMPLE],
    seed: &Point3,
    terms: &Terms,
    steps: u8,
) -> Option<Estimate> {
    let mut estimate = start(cloud, sample, seed, &terms.prior, terms.viewpoint)?;
    for _ in 0..steps {
        let model = RayModel::new(&estimate.ellipsoid(), &terms.noise, terms.viewpoint);
        let mut moments = Moments::ZERO;
        for &index in sample {
            let contact = model.contact(&at(cloud, index));
            moments.add(contact.u, contact.value, terms.independence / contact.variance);
        }
        let mut normal = Normal::new(&moments, &model.constants());
        normal.add_prior(&terms.prior, &estimate.ln_axes);
        estimate = estimate.step(&normal)?;
    }
    Some(estimate)
}

const SQRT_2: f32 = core::f32::consts::SQRT_2;
/// `1 / sqrt 2` and `1 / sqrt 6`.
const E1: f32 = core::f32::consts::FRAC_1_SQRT_2;
const E2: f32 = 0.408_248_3;

/// Ridge fit, centre checked, axes by length, size of the prior.
fn start(
    cloud: &[Point3],
    sample: &[u16; SAMPLE],
    seed: &Point3,
    prior: &SizeTerm,
    viewpoint: Viewpoint,
) -> Option<Estimate> {
    let short = libm::expf(prior.mean_ln[2]);
    let long = libm::expf(prior.mean_ln[0]);
    let scale = 1.0 / short;
    let mut matrix = Symmetric9::ZERO;
    let mut rhs = [0.0; N];
    for &index in sample {
        let p = at(cloud, index);
        let (x, y, z) = ((p.x - seed.x) * scale, (p.y - seed.y) * scale, (p.z - seed.z) * scale);
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let row = [
            E1 * (xx - yy),
            E2 * ((xx + yy) - 2.0 * zz),
            SQRT_2 * (x * y),
            SQRT_2 * (x * z),
            SQRT_2 * (y * z),
            x,
            y,
            z,
            1.0,
        ];
        let target = -((xx + yy) + zz);
        matrix.add_outer(&row, 1.0);
        for k in 0..N {
            rhs[k] += row[k] * target;
        }
    }
    for k in 0..5 {
        matrix.add_diagonal(k, RIDGE * SAMPLE as f32);
    }
    for k in 5..9 {
        matrix.add_diagonal(k, 1e-4);
    }
    let [e1, e2, e3, e4, e5, b1, b2, b3, _] = matrix.factor()?.solve(&rhs);
    let shape = Symmetric3 {
        xx: 1.0 + (E1 * e1 + E2 * e2),
        yy: 1.0 + (E2 * e2 - E1 * e1),
        zz: 1.0 - 2.0 * (E2 * e2),
        xy: E1 * e3,
        xz: E1 * e4,
        yz: E1 * e5,
    };
    let ray = [seed.x, seed.y, seed.z];
    let range = libm::sqrtf(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
    let v = if range > 0.0 { ray.map(|x| x / range) } else { [0.0, 0.0, 1.0] };
    let determinant = shape.determinant();
    let g = shape.adjugate().times([0.5 * b1, 0.5 * b2, 0.5 * b3]);
    let local = g.map(|x| -(x / determinant) * short);
    let depth = local[0] * v[0] + local[1] * v[1] + local[2] * v[2];
    let reach = local[0] * local[0] + local[1] * local[1] + local[2] * local[2];
    let behind = viewpoint == Viewpoint::None || (depth > 0.3 * short && depth < 1.2 * long);
    let offset =
        if determinant > 0.0 && behind && reach < long * long * 1.5 { local } else { v.map(|x| x * short) };
    let eigen = jacobi::eigen(&shape);
    // Right-handed: turn the third axis if need be.
    let [a, b, _] = eigen.vectors;
    let c = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    Some(Estimate {
        centre: [seed.x + offset[0], seed.y + offset[1], seed.z + offset[2]],
        axes: [a, b, c],
        ln_axes: prior.mean_ln,
        boxiness: 0.0,
    })
}
