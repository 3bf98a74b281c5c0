//! Least squares of the quadric through the 9x9 normal equations, Eq. (3)-(5), and the only place that knows the
//! local frame.
//!
//! The squares of camera coordinates (700 mm) drown a fruit of 20 mm in `f32`, so the sample is first moved to its
//! own mean and scaled by a power of two (exact) until its largest coordinate lies in [1, 2). The normal equations
//! are formed and solved there, improved by one step of residual refinement (minimal samples need it: the normal
//! matrix squares their condition), and the resulting central form is carried back to the cloud's frame.

use crate::{
    CentralQuadric, Observer, Point3, Quadric, Rejection,
    linalg::{N, Symmetric9},
    point::at,
};

/// How the scale of the homogeneous equation is fixed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Constraint {
    /// `a11 = 1`, Eq. (4). Turning the frame changes the answer on one-sided samples.
    #[default]
    A11,
    /// `a11 + a22 + a33 = 3`: the same answer in every frame.
    Trace,
}

/// Points a fit needs at least: as many as unknowns.
pub const MIN_SAMPLE: usize = N;

/// Fits the listed points of `cloud`; `sample` holds indices, in the order in which sums are taken.
/// `O(n)`: about 280 flops a point and 1400 for the two solves.
///
/// ```
/// use varsac_core::{Constraint, Point3, fit};
/// // Fourteen points of the ellipsoid with semi-axes 3, 2, 1 about (10, 0, 700).
/// let mut cloud = Vec::new();
/// for (x, y, z) in [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (0.6, 0.8, 0.0), (0.6, 0.0, 0.8), (0.0, 0.6, 0.8), (0.48, 0.64, 0.6)] {
///     cloud.push(Point3::new(10.0 + 3.0 * x, 2.0 * y, 700.0 + z));
///     cloud.push(Point3::new(10.0 - 3.0 * x, -2.0 * y, 700.0 - z));
/// }
/// let sample: Vec<u16> = (0..14).collect();
/// let ellipsoid = varsac_core::Ellipsoid::from(&fit::fit(&cloud, &sample, Constraint::Trace).unwrap());
/// assert!((ellipsoid.semi_axes[0] - 3.0).abs() < 1e-3);
/// assert!((ellipsoid.centre.z - 700.0).abs() < 1e-3);
/// ```
///
/// # Errors
/// [`Rejection::TooFewPoints`] below nine points, [`Rejection::Degenerate`] when they do not determine a quadric,
/// [`Rejection::NotEllipsoid`] when the quadric is none.
pub fn fit(cloud: &[Point3], sample: &[u16], constraint: Constraint) -> Result<CentralQuadric, Rejection> {
    fit_observed(cloud, sample, constraint, &mut ())
}

/// [`fit`], showing its steps to an observer.
///
/// # Errors
/// As [`fit`].
pub fn fit_observed(
    cloud: &[Point3],
    sample: &[u16],
    constraint: Constraint,
    observer: &mut impl Observer,
) -> Result<CentralQuadric, Rejection> {
    if sample.len() < MIN_SAMPLE {
        return Err(Rejection::TooFewPoints);
    }
    let frame = LocalFrame::around(cloud, sample).ok_or(Rejection::Degenerate)?;
    let mut matrix = Symmetric9::ZERO;
    let mut rhs = [0.0; N];
    for &index in sample {
        let (row, target) = design(frame.to_local(&at(cloud, index)), constraint);
        matrix.add_outer(&row, 1.0);
        add_scaled(&mut rhs, &row, target);
    }
    observer.normal_equations(&matrix, &rhs);
    let factors = matrix.factor().ok_or(Rejection::Degenerate)?;
    let mut x = factors.solve(&rhs);

    // One step of refinement: solve again for the residual, taken from the design rows and not from the normal matrix.
    let mut residual_rhs = [0.0; N];
    for &index in sample {
        let (row, target) = design(frame.to_local(&at(cloud, index)), constraint);
        let mut residual = target;
        for k in 0..N {
            residual -= row[k] * x[k];
        }
        add_scaled(&mut residual_rhs, &row, residual);
    }
    let correction = factors.solve(&residual_rhs);
    for k in 0..N {
        x[k] += correction[k];
    }
    observer.solution(&x);

    let quadric = quadric_from(&x, constraint);
    observer.quadric(&quadric);
    let local = quadric.central().ok_or(Rejection::NotEllipsoid)?;
    let central = frame.to_cloud(&local);
    observer.hypothesis(&central);
    Ok(central)
}

/// `sum += row * factor`.
#[inline]
fn add_scaled(sum: &mut [f32; N], row: &[f32; N], factor: f32) {
    for k in 0..N {
        sum[k] += row[k] * factor;
    }
}

/// One row of the design matrix and its right-hand side: `row . x = target` for a point on the surface.
///
/// `A11`: unknowns `a22, a33, a14, a24, a34, a44, a12, a13, a23`, the order of the paper; target `-x^2`.
/// `Trace`: the first two unknowns are `a22 - 1` and `a33 - 1`, and `a11 = 1 - (a22 - 1) - (a33 - 1)`;
/// target `-(x^2 + y^2 + z^2)`.
#[inline]
fn design(p: Point3, constraint: Constraint) -> ([f32; N], f32) {
    let (x, y, z) = (p.x, p.y, p.z);
    let (xx, yy, zz) = (x * x, y * y, z * z);
    match constraint {
        Constraint::A11 => ([yy, zz, x, y, z, 1.0, x * y, x * z, y * z], -xx),
        Constraint::Trace => ([yy - xx, zz - xx, x, y, z, 1.0, x * y, x * z, y * z], -(xx + yy + zz)),
    }
}

fn quadric_from(x: &[f32; N], constraint: Constraint) -> Quadric {
    let [u, v, a14, a24, a34, a44, a12, a13, a23] = *x;
    let (a11, a22, a33) = match constraint {
        Constraint::A11 => (1.0, u, v),
        Constraint::Trace => (1.0 - u - v, 1.0 + u, 1.0 + v),
    };
    Quadric { a11, a22, a33, a12, a13, a23, a14, a24, a34, a44 }
}

/// Mean of the sample and a power of two.
pub(crate) struct LocalFrame {
    pub(crate) origin: Point3,
    /// Local units per cloud unit, a power of two.
    pub(crate) scale: f32,
}

impl LocalFrame {
    /// `None` when the points coincide (or nearly: spread below the normal range of `f32`).
    pub(crate) fn around(cloud: &[Point3], sample: &[u16]) -> Option<Self> {
        let (mut x, mut y, mut z) = (0.0_f32, 0.0_f32, 0.0_f32);
        for &index in sample {
            let p = at(cloud, index);
            x += p.x;
            y += p.y;
            z += p.z;
        }
        let n = sample.len() as f32;
        let origin = Point3::new(x / n, y / n, z / n);
        let mut largest = 0.0_f32;
        for &index in sample {
            let p = at(cloud, index);
            for value in [p.x - origin.x, p.y - origin.y, p.z - origin.z] {
                let size = libm::fabsf(value);
                if size > largest {
                    largest = size;
                }
            }
        }
        // largest = 1.f * 2^(e - 127), so 2^(127 - e) brings it into [1, 2).
        let exponent = (largest.to_bits() >> 23) & 0xff;
        if exponent == 0 || exponent >= 254 {
            return None;
        }
        Some(Self { origin, scale: f32::from_bits((254 - exponent) << 23) })
    }

    #[inline]
    pub(crate) fn to_local(&self, p: &Point3) -> Point3 {
        Point3::new(
            (p.x - self.origin.x) * self.scale,
            (p.y - self.origin.y) * self.scale,
            (p.z - self.origin.z) * self.scale,
        )
    }

    /// A local point in the cloud's frame and unit.
    pub(crate) fn point_to_cloud(&self, local: &Point3) -> Point3 {
        let back = 1.0 / self.scale;
        Point3::new(
            self.origin.x + local.x * back,
            self.origin.y + local.y * back,
            self.origin.z + local.z * back,
        )
    }

    fn to_cloud(&self, local: &CentralQuadric) -> CentralQuadric {
        let (c, s) = (&local.centre, &local.shape);
        let square = self.scale * self.scale;
        CentralQuadric {
            centre: self.point_to_cloud(c),
            shape: crate::jacobi::Symmetric3 {
                xx: s.xx * square,
                yy: s.yy * square,
                zz: s.zz * square,
                xy: s.xy * square,
                xz: s.xz * square,
                yz: s.yz * square,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Ellipsoid;

    /// Points of an ellipsoid 22 x 12 x 10 at 700 mm, on a spiral over its front (`share` of it).
    fn fruit<const K: usize>(share: f32) -> [Point3; K] {
        let mut cloud = [Point3::origin(); K];
        for (k, p) in cloud.iter_mut().enumerate() {
            let w = 1.0 - 2.0 * share * (k as f32 + 0.5) / K as f32;
            let r = libm::sqrtf(1.0 - w * w);
            let turn = 2.4 * k as f32;
            *p = Point3::new(
                30.0 + 22.0 * r * libm::cosf(turn),
                -50.0 + 12.0 * r * libm::sinf(turn),
                700.0 - 10.0 * w,
            );
        }
        cloud
    }

    fn indices<const K: usize>() -> [u16; K] {
        core::array::from_fn(|k| k as u16)
    }

    #[test]
    fn both_constraints_find_the_fruit() {
        let cloud = fruit::<60>(0.6);
        for constraint in [Constraint::A11, Constraint::Trace] {
            let e = Ellipsoid::from(&fit(&cloud, &indices::<60>(), constraint).unwrap());
            for (value, expected) in e.semi_axes.iter().zip([22.0, 12.0, 10.0]) {
                assert!((value - expected).abs() < 0.02, "{constraint:?} {e:?}");
            }
            assert!((e.centre - Point3::new(30.0, -50.0, 700.0)).norm() < 0.02, "{e:?}");
        }
    }

    #[test]
    fn degenerate_samples_are_rejected() {
        let same = [Point3::new(1.0, 2.0, 3.0); 9];
        assert_eq!(fit(&same, &indices::<9>(), Constraint::A11), Err(Rejection::Degenerate));
        let line: [Point3; 12] = core::array::from_fn(|k| Point3::new(k as f32, 2.0 * k as f32, 700.0));
        assert_eq!(fit(&line, &indices::<12>(), Constraint::Trace), Err(Rejection::Degenerate));
        let plane: [Point3; 16] =
            core::array::from_fn(|k| Point3::new((k % 4) as f32, (k / 4) as f32, 700.0));
        assert_eq!(fit(&plane, &indices::<16>(), Constraint::A11), Err(Rejection::Degenerate));
        assert_eq!(fit(&plane, &indices::<8>(), Constraint::A11), Err(Rejection::TooFewPoints));
    }

    #[test]
    fn a_sphere_is_an_ellipsoid_too() {
        let cloud: [Point3; 40] = core::array::from_fn(|k| {
            let w = 1.0 - 2.0 * (k as f32 + 0.5) / 40.0;
            let r = libm::sqrtf(1.0 - w * w);
            Point3::new(
                5.0 * r * libm::cosf(2.4 * k as f32),
                5.0 * r * libm::sinf(2.4 * k as f32),
                900.0 + 5.0 * w,
            )
        });
        let e = Ellipsoid::from(&fit(&cloud, &indices::<40>(), Constraint::A11).unwrap());
        assert!(e.semi_axes.iter().all(|a| (a - 5.0).abs() < 1e-3), "{e:?}");
    }
}
