//! Bodies of the light patch generator and where a viewing ray meets them.
//!
//! Unit: millimetres, `f64`; frame: camera optical frame, rays start at its origin. Roots and powers come from libm,
//! so that a scene is the same on every machine.

/// A point or direction, millimetres.
pub type V3 = [f64; 3];

/// Inner product.
#[inline]
pub fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// `a + s b`.
#[inline]
pub fn along(a: V3, s: f64, b: V3) -> V3 {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// Difference `a - b`.
#[inline]
pub fn minus(a: V3, b: V3) -> V3 {
    along(a, -1.0, b)
}

/// Vector product.
pub fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Length.
pub fn length(a: V3) -> f64 {
    libm::sqrt(dot(a, a))
}

/// Unit vector of `a`; `a` must not be zero.
pub fn unit(a: V3) -> V3 {
    let s = 1.0 / length(a);
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
                    .then(|| Hit { depth: t, cosine: libm::fabs(q[2]) / length(ray) })
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
                    .then(|| Hit { depth: t, cosine: root / (radius * length(ray)) })
            }
            Self::Plane => {
                let t = w[2] / q[2];
                (t > 0.0).then(|| Hit { depth: t, cosine: libm::fabs(q[2]) / length(ray) })
            }
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
    let cosine = libm::fabs(dot(gradient, ray_body)) / (length(gradient) * length(ray));
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
}
