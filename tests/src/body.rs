//! An ellipsoid in 64 bits: the truth of a scene, and the geometry that scores are judged by.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use varsac_core::{CentralQuadric, Ellipsoid, Point3};

use crate::random::Dice;

/// Centre, semi-axes in any order, and the rotation whose columns are their directions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Centre.
    pub centre: Vector3<f64>,
    /// Semi-axes, one per column of `axes`.
    pub semi_axes: Vector3<f64>,
    /// Columns are unit vectors.
    pub axes: Matrix3<f64>,
}

/// `(p - centre)^T shape (p - centre) = 1` in 64 bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Central64 {
    /// Centre.
    pub centre: Vector3<f64>,
    /// Positive definite, eigenvalues `1 / semi-axis^2`.
    pub shape: Matrix3<f64>,
}

/// A point of the cloud in 64 bits, exactly.
pub fn wide(p: &Point3) -> Vector3<f64> {
    Vector3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z))
}

/// A point rounded to the cloud's `f32`.
pub fn narrow(p: &Vector3<f64>) -> Point3 {
    Point3::new(p.x as f32, p.y as f32, p.z as f32)
}

impl Body {
    /// A Lingwu long jujube of random size (semi-axes 20.5-23.5 x 10.5-12 x 10-12 mm) and attitude at `centre`.
    pub fn jujube(dice: &mut Dice, centre: Vector3<f64>) -> Self {
        let b = dice.between(10.5, 12.0);
        let semi_axes = Vector3::new(dice.between(20.5, 23.5), b, dice.between(10.0, b));
        Self { centre, semi_axes, axes: dice.rotation() }
    }

    /// Coordinates in the body's frame, each divided by its semi-axis: the unit sphere is the surface.
    pub fn to_sphere(&self, p: &Vector3<f64>) -> Vector3<f64> {
        (self.axes.transpose() * (p - self.centre)).component_div(&self.semi_axes)
    }

    /// The point that belongs to a point of the unit sphere.
    pub fn from_sphere(&self, s: &Vector3<f64>) -> Vector3<f64> {
        self.centre + self.axes * s.component_mul(&self.semi_axes)
    }

    /// The same body scaled about its centre.
    pub fn scaled(&self, factor: f64) -> Self {
        Self { semi_axes: self.semi_axes * factor, ..*self }
    }

    /// Where the viewing ray `t * direction` from the origin enters the body: the smaller positive `t`.
    pub fn first_hit(&self, direction: &Vector3<f64>) -> Option<f64> {
        let d = (self.axes.transpose() * direction).component_div(&self.semi_axes);
        let o = self.to_sphere(&Vector3::zeros());
        let (a, b, c) = (d.dot(&d), d.dot(&o), o.dot(&o) - 1.0);
        let discriminant = b * b - a * c;
        let t = (-b - libm::sqrt(discriminant)) / a;
        (discriminant >= 0.0 && t > 0.0).then_some(t)
    }

    /// A point of the surface, uniform by area: a uniform direction of the sphere, accepted in proportion to how much
    /// the map to the ellipsoid stretches area there.
    pub fn surface_point(&self, dice: &mut Dice) -> Vector3<f64> {
        loop {
            let s = dice.direction();
            // |D^-1 s| times the smallest semi-axis is at most 1.
            if dice.unit() < s.component_div(&self.semi_axes).norm() * self.semi_axes.min() {
                return self.from_sphere(&s);
            }
        }
    }

    /// Signed orthogonal distance of a point to the surface, negative inside.
    ///
    /// The closest point of the surface is `x_i = a_i^2 q_i / (a_i^2 + t)` with `t` the largest root of the secular
    /// equation `sum (a_i q_i / (a_i^2 + t))^2 = 1`, found by bisection (Eberly, Distance from a Point to an Ellipse,
    /// an Ellipsoid, or a Hyperellipsoid, 2013). For a point of a symmetry plane of the body the root may lie on the
    /// pole `t = -a_i^2`; random points are not there.
    pub fn signed_distance(&self, p: &Vector3<f64>) -> f64 {
        let q = self.axes.transpose() * (p - self.centre);
        let squares = self.semi_axes.component_mul(&self.semi_axes);
        let excess = |t: f64| {
            (0..3).map(|i| self.semi_axes[i] * q[i] / (squares[i] + t)).map(|u| u * u).sum::<f64>() - 1.0
        };
        let mut low = -squares.min();
        // At this t each term is at most (q_i / |q|)^2, so the sum is at most one.
        let mut high = self.semi_axes.max() * q.norm();
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if excess(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let t = 0.5 * (low + high);
        let closest = Vector3::from_fn(|i, _| squares[i] * q[i] / (squares[i] + t));
        let distance = (q - closest).norm();
        if q.component_div(&self.semi_axes).norm_squared() < 1.0 { -distance } else { distance }
    }

    /// The body as a central form.
    pub fn central(&self) -> Central64 {
        let d = Matrix3::from_diagonal(&self.semi_axes.map(|a| 1.0 / (a * a)));
        Central64 { centre: self.centre, shape: self.axes * d * self.axes.transpose() }
    }

    /// Direction of the longest semi-axis.
    pub fn long_axis(&self) -> Vector3<f64> {
        self.axes.column(self.semi_axes.imax()).into_owned()
    }

    /// Semi-axes, longest first.
    pub fn sorted_semi_axes(&self) -> [f64; 3] {
        let mut sorted: [f64; 3] = self.semi_axes.into();
        sorted.sort_by(|x, y| y.total_cmp(x));
        sorted
    }
}

impl From<&CentralQuadric> for Central64 {
    fn from(narrow: &CentralQuadric) -> Self {
        let s = &narrow.shape;
        let shape = Matrix3::new(s.xx, s.xy, s.xz, s.xy, s.yy, s.yz, s.xz, s.yz, s.zz);
        Self { centre: wide(&narrow.centre), shape: shape.map(f64::from) }
    }
}

impl Central64 {
    /// 1 on the surface, `s^2` on the surface scaled by `s`.
    pub fn value(&self, p: &Vector3<f64>) -> f64 {
        let d = p - self.centre;
        d.dot(&(self.shape * d))
    }

    /// The body, longest semi-axis first.
    pub fn body(&self) -> Body {
        let eigen = SymmetricEigen::new(self.shape);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
        let column = |k: usize| eigen.eigenvectors.column(order[k]).into_owned();
        Body {
            centre: self.centre,
            semi_axes: Vector3::from_fn(|k, _| 1.0 / libm::sqrt(eigen.eigenvalues[order[k]])),
            axes: Matrix3::from_columns(&[column(0), column(1), column(2)]),
        }
    }
}

/// Angle between two axes without direction, degrees.
pub fn axis_angle_deg(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    libm::atan2(a.cross(b).norm(), libm::fabs(a.dot(b))).to_degrees()
}

/// The long axis of a result in 64 bits.
pub fn long_axis(e: &Ellipsoid) -> Vector3<f64> {
    Vector3::from(e.long_axis().map(f64::from))
}
