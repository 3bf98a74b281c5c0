//! Bodies of the light patch generator and where a viewing ray meets them.
//!
//! Unit: millimetres, `f64`; frame: camera optical frame, rays start at its origin. Roots and powers come from libm,
//! so that a scene is the same on every machine.

pub(super) use crate::eval::{cross, dot, norm, subtract};

/// A point or direction, millimetres.
pub type V3 = [f64; 3];

/// `a + s b`.
#[inline]
pub(super) fn along(a: V3, s: f64, b: V3) -> V3 {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// Unit vector of `a`; `a` must not be zero.
pub(super) fn unit(a: V3) -> V3 {
    let s = 1.0 / norm(a);
    [a[0] * s, a[1] * s, a[2] * s]
}

/// Where a body is and how it is turned: row k of `axes` is its k-th axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Centre.
    pub centre: V3,
    /// Rows are orthogonal unit vectors.
    pub axes: [V3; 3],
}

impl Pose {
    /// Coordinates of a camera-frame direction in the body's frame.
    #[inline]
    fn turned(&self, v: V3) -> V3 {
        [dot(self.axes[0], v), dot(self.axes[1], v), dot(self.axes[2], v)]
    }

    /// The camera-frame point at these coordinates in the body's frame.
    fn point(&self, body: V3) -> V3 {
        (0..3).fold(self.centre, |point, k| along(point, body[k], self.axes[k]))
    }
}

/// Geometry of one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shape {
    /// `|x/a|^p + |y/b|^p + |z/c|^p = 1`; `p = 2` is an ellipsoid, larger is boxier. `p >= 2`.
    Superellipsoid {
        /// `a, b, c`.
        semi_axes: V3,
        /// `p`.
        exponent: f64,
    },
    /// Flat ellipse across the third axis: a leaf, or a picture of a fruit.
    Disc {
        /// Radii along the first two axes.
        radii: [f64; 2],
    },
    /// Open cylinder about the first axis: a branch.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Half of its length.
        half_length: f64,
    },
    /// Endless plane across the third axis.
    Plane,
}

/// Where a ray meets a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// z of the point in millimetres (rays have direction z = 1).
    pub depth: f64,
    /// Cosine of the angle between surface normal and ray, 0..=1.
    pub cosine: f64,
}

/// Newton steps at most on the convex function of a super-ellipsoid; it converges monotonically, most rays need 6.
const NEWTON_STEPS: usize = 40;

impl Shape {
    /// The first point of the ray `t (x, y, 1)`, `t > 0`, on the body.
    pub fn hit(&self, pose: &Pose, ray: V3) -> Option<Hit> {
        let (q, w) = (pose.turned(ray), pose.turned(pose.centre));
        match *self {
            Self::Superellipsoid { semi_axes, exponent } => superellipsoid(semi_axes, exponent, q, w, ray),
            Self::Disc { radii } => {
                let t = w[2] / q[2];
                let (x, y) = ((t * q[0] - w[0]) / radii[0], (t * q[1] - w[1]) / radii[1]);
                (t > 0.0 && x * x + y * y <= 1.0)
                    .then(|| Hit { depth: t, cosine: libm::fabs(q[2]) / norm(ray) })
            }
            Self::Cylinder { radius, half_length } => {
                let a = q[1] * q[1] + q[2] * q[2];
                let b = q[1] * w[1] + q[2] * w[2];
                let c = w[1] * w[1] + w[2] * w[2] - radius * radius;
                let root = b * b - a * c;
                if root <= 0.0 {
                    return None;
                }
                let root = libm::sqrt(root);
                let t = (b - root) / a;
                (t > 0.0 && libm::fabs(t * q[0] - w[0]) <= half_length)
                    .then(|| Hit { depth: t, cosine: root / (radius * norm(ray)) })
            }
            Self::Plane => {
                let t = w[2] / q[2];
                (t > 0.0).then(|| Hit { depth: t, cosine: libm::fabs(q[2]) / norm(ray) })
            }
        }
    }
}

/// Steps round and along a body in [`Shape::surface`].
const SURFACE_STEPS: u32 = 24;

impl Shape {
    /// Points all over the body, none for a plane.
    pub(super) fn surface(&self, pose: &Pose) -> Vec<V3> {
        let lattice = (0..SURFACE_STEPS * SURFACE_STEPS).map(|k| {
            let (i, j) = (k % SURFACE_STEPS, k / SURFACE_STEPS);
            let share = (f64::from(i) + 0.5) / f64::from(SURFACE_STEPS);
            (share, core::f64::consts::TAU * f64::from(j) / f64::from(SURFACE_STEPS))
        });
        match *self {
            Self::Superellipsoid { semi_axes, exponent } => lattice
                .map(|(share, around)| {
                    let polar = core::f64::consts::PI * share;
                    let (sin, cos) = (libm::sin(polar), libm::cos(polar));
                    let direction = [cos, sin * libm::cos(around), sin * libm::sin(around)];
                    let sum: f64 = direction.iter().map(|d| libm::pow(libm::fabs(*d), exponent)).sum();
                    let reach = libm::pow(sum, -1.0 / exponent);
                    pose.point(core::array::from_fn(|k| reach * direction[k] * semi_axes[k]))
                })
                .collect(),
            Self::Disc { radii } => lattice
                .map(|(share, around)| {
                    let [p, q] = radii.map(|radius| libm::sqrt(share) * radius);
                    pose.point([p * libm::cos(around), q * libm::sin(around), 0.0])
                })
                .collect(),
            Self::Cylinder { radius, half_length } => lattice
                .map(|(share, around)| {
                    let (y, z) = (radius * libm::cos(around), radius * libm::sin(around));
                    pose.point([(2.0 * share - 1.0) * half_length, y, z])
                })
                .collect(),
            Self::Plane => Vec::new(),
        }
    }

    /// Whether a point lies inside a super-ellipsoid or a cylinder; the others have no inside.
    pub(super) fn holds(&self, pose: &Pose, point: V3) -> bool {
        let [x, y, z] = pose.turned(subtract(point, pose.centre));
        match *self {
            Self::Superellipsoid { semi_axes: [a, b, c], exponent } => {
                let term = |u: f64| libm::pow(libm::fabs(u), exponent);
                term(x / a) + term(y / b) + term(z / c) < 1.0
            }
            Self::Cylinder { radius, half_length } => {
                libm::fabs(x) < half_length && y * y + z * z < radius * radius
            }
            Self::Disc { .. } | Self::Plane => false,
        }
    }
}

/// Entry into the bounding ellipsoid by the quadratic formula, then Newton on `G(t) = sum |u_k|^p - 1`, which is
/// convex along a line: from outside the steps never overshoot.
fn superellipsoid(semi_axes: V3, p: f64, q: V3, w: V3, ray: V3) -> Option<Hit> {
    // The body lies within the ellipsoid enlarged by 3^(1/2 - 1/p), which touches its corners.
    let grown = libm::pow(3.0, 0.5 - 1.0 / p);
    let q: V3 = core::array::from_fn(|k| q[k] / semi_axes[k]);
    let w: V3 = core::array::from_fn(|k| w[k] / semi_axes[k]);
    let (a, b, c) = (dot(q, q), dot(q, w), dot(w, w) - grown * grown);
    let root = b * b - a * c;
    if root <= 0.0 {
        return None;
    }
    let mut t = (b - libm::sqrt(root)) / a;
    if t <= 0.0 {
        return None;
    }
    let mut u: V3 = core::array::from_fn(|k| t * q[k] - w[k]);
    if p > 2.0 {
        for _ in 0..NEWTON_STEPS {
            let mut value = -1.0;
            let mut slope = 0.0;
            for k in 0..3 {
                let power = libm::pow(libm::fabs(u[k]), p - 1.0);
                value += power * libm::fabs(u[k]);
                slope += p * power * libm::copysign(q[k], u[k] * q[k]);
            }
            if value < 1e-12 {
                break;
            }
            if slope >= 0.0 {
                return None;
            }
            t -= value / slope;
            u = core::array::from_fn(|k| t * q[k] - w[k]);
        }
    }
    // Gradient in the body's frame: sign(u) |u|^(p-1) / semi-axis.
    let gradient: V3 =
        core::array::from_fn(|k| libm::copysign(libm::pow(libm::fabs(u[k]), p - 1.0), u[k]) / semi_axes[k]);
    let ray_body: V3 = core::array::from_fn(|k| q[k] * semi_axes[k]);
    let cosine = libm::fabs(dot(gradient, ray_body)) / (norm(gradient) * norm(ray));
    Some(Hit { depth: t, cosine })
}

#[cfg(test)]
mod tests {
    use super::*;

    const UPRIGHT: [V3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    #[test]
    fn bodies_are_met_where_geometry_says() {
        let pose = Pose { centre: [0.0, 0.0, 100.0], axes: UPRIGHT };
        let depth = |shape: Shape, ray| shape.hit(&pose, ray).map(|hit| hit.depth);
        for exponent in [2.0, 2.5, 3.0] {
            let body = Shape::Superellipsoid { semi_axes: [20.0, 10.0, 5.0], exponent };
            assert!((depth(body, [0.0, 0.0, 1.0]).unwrap() - 95.0).abs() < 1e-9);
            assert_eq!(depth(body, [0.3, 0.0, 1.0]), None);
        }
        assert!(
            (depth(Shape::Cylinder { radius: 7.0, half_length: 30.0 }, [0.1, 0.0, 1.0]).unwrap() - 93.0)
                .abs()
                < 1e-9
        );
        assert_eq!(depth(Shape::Cylinder { radius: 7.0, half_length: 9.0 }, [0.1, 0.0, 1.0]), None);
        assert!((depth(Shape::Plane, [0.4, -0.2, 1.0]).unwrap() - 100.0).abs() < 1e-9);
        assert_eq!(depth(Shape::Disc { radii: [5.0, 3.0] }, [0.0, 0.04, 1.0]), None);
    }

    #[test]
    fn a_super_ellipsoid_point_satisfies_its_equation() {
        let body = Shape::Superellipsoid { semi_axes: [20.0, 10.0, 5.0], exponent: 2.5 };
        let pose = Pose { centre: [1.0, 2.0, 300.0], axes: UPRIGHT };
        let ray = [0.03, 0.02, 1.0];
        let hit = body.hit(&pose, ray).unwrap();
        let p = along([0.0; 3], hit.depth, ray);
        let sum: f64 =
            (0..3).map(|k| libm::pow(libm::fabs(p[k] - pose.centre[k]) / [20.0, 10.0, 5.0][k], 2.5)).sum();
        assert!((sum - 1.0).abs() < 1e-9);
        assert!(hit.cosine > 0.0 && hit.cosine < 1.0);
    }

    #[test]
    fn surface_points_lie_between_inside_and_outside() {
        let pose = Pose { centre: [1.0, 2.0, 300.0], axes: UPRIGHT };
        for shape in [
            Shape::Superellipsoid { semi_axes: [20.0, 10.0, 5.0], exponent: 2.0 },
            Shape::Superellipsoid { semi_axes: [20.0, 10.0, 5.0], exponent: 3.0 },
            Shape::Cylinder { radius: 4.0, half_length: 30.0 },
        ] {
            let points = shape.surface(&pose);
            assert_eq!(points.len(), 576);
            for point in points {
                let outward = subtract(point, pose.centre);
                assert!(shape.holds(&pose, along(point, -1e-6, outward)), "{shape:?} {point:?}");
                assert!(!shape.holds(&pose, along(point, 1e-6, outward)), "{shape:?} {point:?}");
            }
        }
    }
}
