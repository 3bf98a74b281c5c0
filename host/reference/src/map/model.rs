//! An estimate of a fruit and the model made from it: contract, chapter M4.

use super::algebra::{Vector, dot, exponentials, minus};
use super::view::{Noise, Viewpoint};
use crate::Point;

/// Centre, axes, logarithms of the semi-axes, boxiness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Centre, mm.
    pub centre: Point,
    /// Row `k` is the direction of the k-th semi-axis, in the order of the prior.
    pub axes: [[f32; 3]; 3],
    /// Logarithms of the semi-axes.
    pub x: [f32; 3],
    /// Boxiness `k`.
    pub boxiness: f32,
}

impl Estimate {
    /// M4: `(a, b, c)`.
    pub(crate) fn semi_axes(&self) -> Vector {
        exponentials(self.x)
    }

    /// M4: the longest semi-axis.
    pub(crate) fn longest(&self) -> f32 {
        let [x1, x2, x3] = self.x;
        let t = if x1 > x2 { x1 } else { x2 };
        libm::expf(if t > x3 { t } else { x3 })
    }
}

/// M1: the square of the distance between two centres.
pub(crate) fn apart2(a: &Estimate, b: &Estimate) -> f32 {
    let d = minus(a.centre, b.centre);
    dot(d, d)
}

/// What the points are compared with.
pub(crate) struct Model {
    pub(crate) centre: Point,
    pub(crate) semi_axes: Vector,
    /// Rows of `M`.
    pub(crate) rows: [[f32; 3]; 3],
    /// `1/a, 1/b, 1/c`.
    pub(crate) inverse: Vector,
    /// `t1, t2, t3`.
    pub(crate) turning: Vector,
    pub(crate) range: f32,
    /// `ir2`.
    pub(crate) inverse_range2: f32,
    pub(crate) axial: f32,
    pub(crate) lateral: f32,
    pub(crate) viewpoint: Viewpoint,
}

impl Model {
    /// M4: the model of an estimate under a noise and a viewpoint.
    pub(crate) fn new(estimate: &Estimate, noise: Noise, viewpoint: Viewpoint) -> Self {
        Self::of(estimate.centre, &estimate.axes, estimate.semi_axes(), noise, viewpoint)
    }

    /// M4, from the semi-axes themselves.
    pub(crate) fn of(
        centre: Point,
        axes: &[[f32; 3]; 3],
        [a, b, c]: Vector,
        noise: Noise,
        viewpoint: Viewpoint,
    ) -> Self {
        let inverse = [1.0 / a, 1.0 / b, 1.0 / c];
        let [ia, ib, ic] = inverse;
        let mut rows = *axes;
        for k in 0..3 {
            for i in 0..3 {
                rows[k][i] *= inverse[k];
            }
        }
        let range2 = dot(centre, centre);
        let (axial, lateral) = match viewpoint {
            Viewpoint::Origin => {
                ((noise.axial * noise.axial) / range2, (noise.lateral * noise.lateral) * range2)
            }
            Viewpoint::None => (0.0, noise.axial * noise.axial),
        };
        Self {
            centre,
            semi_axes: [a, b, c],
            rows,
            inverse,
            turning: [b * ic - c * ib, c * ia - a * ic, a * ib - b * ia],
            range: libm::sqrtf(range2),
            inverse_range2: 1.0 / range2,
            axial,
            lateral,
            viewpoint,
        }
    }

    /// `M v`.
    pub(crate) fn times(&self, v: Vector) -> Vector {
        [dot(self.rows[0], v), dot(self.rows[1], v), dot(self.rows[2], v)]
    }

    /// M4: `grad2(u)`.
    pub(crate) fn grad2(&self, u: Vector) -> f32 {
        let [ia, ib, ic] = self.inverse;
        let g = [u[0] * ia, u[1] * ib, u[2] * ic];
        dot(g, g)
    }

    /// M4: the constants `s` of the derivatives.
    pub(crate) fn slopes(&self) -> [f32; 9] {
        let ([ia, ib, ic], [t1, t2, t3]) = (self.inverse, self.turning);
        [-ia, -ib, -ic, t1, t2, t3, -1.0, -1.0, -1.0]
    }
}
