//! The least squares of the paper solved in other ways: in 64 bits by QR of the design matrix, and in `f32` as the core
//! does it but with fewer or more steps of refinement, to measure what its one step buys.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use varsac_core::{
    CentralQuadric, Constraint, Point3, Quadric, Rejection, jacobi::Symmetric3, linalg::Symmetric9,
};

use crate::body::{Central64, wide};

/// Where the equations are formed: `local = (p - origin) * scale`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Origin in the cloud's frame.
    pub origin: Vector3<f64>,
    /// Local units per cloud unit.
    pub scale: f64,
}

impl Frame {
    /// The cloud's own coordinates.
    pub const RAW: Self = Self { origin: Vector3::new(0.0, 0.0, 0.0), scale: 1.0 };

    /// Mean of the points, largest coordinate scaled to 1..2 by a power of two.
    pub fn around(points: &[Vector3<f64>]) -> Self {
        let origin = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let largest = points.iter().map(|p| (p - origin).amax()).fold(0.0, f64::max);
        Self { origin, scale: libm::exp2(-libm::floor(libm::log2(largest))) }
    }

    fn to_local(self, p: &Vector3<f64>) -> Vector3<f64> {
        (p - self.origin) * self.scale
    }
}

/// The listed points in 64 bits.
pub fn listed(cloud: &[Point3], sample: &[u16]) -> Vec<Vector3<f64>> {
    sample.iter().map(|&index| wide(&cloud[usize::from(index)])).collect()
}

/// One row of the design matrix and its target, unknowns as in the core.
pub fn design(p: &Vector3<f64>, constraint: Constraint) -> ([f64; 9], f64) {
    let (x, y, z) = (p.x, p.y, p.z);
    match constraint {
        Constraint::A11 => ([y * y, z * z, x, y, z, 1.0, x * y, x * z, y * z], -x * x),
        Constraint::Trace => {
            ([y * y - x * x, z * z - x * x, x, y, z, 1.0, x * y, x * z, y * z], -(x * x + y * y + z * z))
        }
    }
}

fn design_matrix(
    points: &[Vector3<f64>],
    constraint: Constraint,
    frame: &Frame,
) -> (DMatrix<f64>, DVector<f64>) {
    let rows: Vec<_> = points.iter().map(|p| design(&frame.to_local(p), constraint)).collect();
    let matrix = DMatrix::from_fn(rows.len(), 9, |i, j| rows[i].0[j]);
    (matrix, DVector::from_fn(rows.len(), |i, _| rows[i].1))
}

/// Condition number of the design matrix in its local frame, by its singular values.
pub fn condition(points: &[Vector3<f64>], constraint: Constraint) -> f64 {
    let singular = design_matrix(points, constraint, &Frame::around(points)).0.singular_values();
    singular.max() / singular.min()
}

/// The least squares by Householder QR in 64 bits; `None` when the quadric is no real ellipsoid.
pub fn fit64(points: &[Vector3<f64>], constraint: Constraint, frame: &Frame) -> Option<Central64> {
    let (matrix, target) = design_matrix(points, constraint, frame);
    let qr = matrix.qr();
    let mut turned = target;
    qr.q_tr_mul(&mut turned);
    let x = qr.r().solve_upper_triangular(&turned.rows(0, 9))?;
    let x: [f64; 9] = core::array::from_fn(|k| x[k]);
    central64(&x, constraint, frame)
}

/// The ellipsoid of a solution, by inverting the quadratic part; `None` when it is none.
pub fn central64(x: &[f64; 9], constraint: Constraint, frame: &Frame) -> Option<Central64> {
    let [u, v, a14, a24, a34, a44, a12, a13, a23] = *x;
    let (a11, a22, a33) = match constraint {
        Constraint::A11 => (1.0, u, v),
        Constraint::Trace => (1.0 - u - v, 1.0 + u, 1.0 + v),
    };
    let a = Matrix3::new(a11, a12 / 2.0, a13 / 2.0, a12 / 2.0, a22, a23 / 2.0, a13 / 2.0, a23 / 2.0, a33);
    let b = Vector3::new(a14, a24, a34) / 2.0;
    let minors = [a11, a11 * a22 - a12 * a12 / 4.0, a.determinant()];
    if !minors.iter().all(|&minor| minor > 0.0) {
        return None;
    }
    let centre = -(a.try_inverse()? * b);
    // Constant term in the frame of the centre: I4 / I3.
    let constant = a44 + b.dot(&centre);
    (constant < 0.0).then(|| Central64 {
        centre: frame.origin + centre / frame.scale,
        shape: a * (-frame.scale * frame.scale / constant),
    })
}

/// The fit of the core (chapter 5 of the numeric contract) with any number of refinement steps; the core does one.
///
/// # Errors
/// As the core's fit.
pub fn fit_refined(
    cloud: &[Point3],
    sample: &[u16],
    constraint: Constraint,
    steps: u32,
) -> Result<CentralQuadric, Rejection> {
    let (origin, scale) = frame32(cloud, sample).ok_or(Rejection::Degenerate)?;
    let local = |index: &u16| (cloud[usize::from(*index)] - origin) * scale;
    let rows: Vec<_> = sample.iter().map(local).map(|p| design32([p.x, p.y, p.z], constraint)).collect();
    let mut matrix = Symmetric9::ZERO;
    for (row, _) in &rows {
        matrix.add_outer(row, 1.0);
    }
    let factors = matrix.factor().ok_or(Rejection::Degenerate)?;
    let mut x = [0.0; 9];
    for _ in 0..=steps {
        let mut rhs = [0.0; 9];
        for (row, target) in &rows {
            let residual = row.iter().zip(&x).fold(*target, |rest, (entry, x)| rest - entry * x);
            for k in 0..9 {
                rhs[k] += row[k] * residual;
            }
        }
        let correction = factors.solve(&rhs);
        for k in 0..9 {
            x[k] += correction[k];
        }
    }
    let [u, v, a14, a24, a34, a44, a12, a13, a23] = x;
    let (a11, a22, a33) = match constraint {
        Constraint::A11 => (1.0, u, v),
        Constraint::Trace => (1.0 - u - v, 1.0 + u, 1.0 + v),
    };
    let quadric = Quadric { a11, a22, a33, a12, a13, a23, a14, a24, a34, a44 };
    let CentralQuadric { centre, shape } = quadric.central().ok_or(Rejection::NotEllipsoid)?;
    let (back, square) = (1.0 / scale, scale * scale);
    Ok(CentralQuadric {
        centre: origin + centre.coords * back,
        shape: Symmetric3 {
            xx: shape.xx * square,
            yy: shape.yy * square,
            zz: shape.zz * square,
            xy: shape.xy * square,
            xz: shape.xz * square,
            yz: shape.yz * square,
        },
    })
}

fn design32([x, y, z]: [f32; 3], constraint: Constraint) -> ([f32; 9], f32) {
    let (xx, yy, zz) = (x * x, y * y, z * z);
    match constraint {
        Constraint::A11 => ([yy, zz, x, y, z, 1.0, x * y, x * z, y * z], -xx),
        Constraint::Trace => ([yy - xx, zz - xx, x, y, z, 1.0, x * y, x * z, y * z], -(xx + yy + zz)),
    }
}

/// Origin and scale of the local frame.
fn frame32(cloud: &[Point3], sample: &[u16]) -> Option<(Point3, f32)> {
    let points = || sample.iter().map(|&index| &cloud[usize::from(index)]);
    let mean = |k: usize| points().fold(0.0, |sum, p| sum + p[k]) / sample.len() as f32;
    let origin = Point3::new(mean(0), mean(1), mean(2));
    let largest = points().flat_map(|p| (0..3).map(move |k| (p[k] - origin[k]).abs())).fold(0.0, f32::max);
    let exponent = largest.to_bits() >> 23;
    (1..254).contains(&exponent).then(|| (origin, f32::from_bits((254 - exponent) << 23)))
}
