//! The bodies a scene is built of, and where a ray meets them: ellipsoid, capsule, leaf.
//!
//! All analytic: each is the root of a quadratic. Rays have directions with z = 1 in the camera's frame, so that the
//! ray parameter is the distance along z from the origin of the ray; nothing depends on the direction's length.

use nalgebra::{Matrix3, Point3, Vector3};

/// A half-line from a camera.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ray {
    pub(super) origin: Point3<f64>,
    pub(super) direction: Vector3<f64>,
}

/// Where a ray enters a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hit {
    /// Ray parameter, > 0.
    pub(super) t: f64,
    /// Unit normal: outward, of a leaf the side of its face.
    pub(super) normal: Vector3<f64>,
    /// Place on the body in its own terms: ellipsoid: point of the unit sphere, rows of the axes;
    /// capsule: (along 0..1, 0, 0); leaf: (along -1..1, across -1..1 of the greatest half-width, 0).
    pub(super) local: Vector3<f64>,
}

/// Nearest ray parameter that counts, so that a surface does not shadow itself.
const NEAREST_T: f64 = 1e-3;

/// A body, its position included.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape {
    Ellipsoid(Ellipsoid),
    Capsule(Capsule),
    Leaf(Leaf),
}

impl Shape {
    pub(super) fn hit(&self, ray: &Ray) -> Option<Hit> {
        match self {
            Self::Ellipsoid(shape) => shape.hit(ray),
            Self::Capsule(shape) => shape.hit(ray),
            Self::Leaf(shape) => shape.hit(ray),
        }
    }

    /// A bent rod that contains the body.
    pub(super) fn rod(&self) -> Rod {
        match self {
            Self::Ellipsoid(shape) => shape.capsule().rod(),
            Self::Capsule(shape) => shape.rod(),
            Self::Leaf(shape) => shape.rod(),
        }
    }
}

/// All points within `radius` of the line through `points`, millimetres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rod {
    pub(super) points: [Point3<f64>; 3],
    pub(super) radius: f64,
}

impl Rod {
    /// No point of it is nearer than this along z.
    pub(super) fn front_mm(&self) -> f64 {
        self.points.iter().map(|point| point.z).fold(f64::INFINITY, f64::min) - self.radius
    }
}

/// Semi-axes along the rows of `axes`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ellipsoid {
    pub(super) centre: Point3<f64>,
    pub(super) semi_axes: Vector3<f64>,
    pub(super) axes: Matrix3<f64>,
}

impl Ellipsoid {
    /// To the frame in which the ellipsoid is the unit sphere.
    fn into_sphere(self, v: Vector3<f64>) -> Vector3<f64> {
        (self.axes * v).component_div(&self.semi_axes)
    }

    /// A capsule around it: the segment between the centres of curvature of a spheroid that is no slimmer.
    /// Needs semi-axes a >= b >= c.
    pub(super) fn capsule(&self) -> Capsule {
        let reach = self.axes.row(0).transpose() * (self.semi_axes[0] - self.semi_axes[1]);
        Capsule { from: self.centre - reach, to: self.centre + reach, radius: self.semi_axes[1] }
    }

    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let origin = self.into_sphere(ray.origin - self.centre);
        let direction = self.into_sphere(ray.direction);
        let (t, _) =
            roots(direction.norm_squared(), 2.0 * origin.dot(&direction), origin.norm_squared() - 1.0)?;
        (t > NEAREST_T).then(|| {
            let local = origin + direction * t;
            let normal = (self.axes.transpose() * local.component_div(&self.semi_axes)).normalize();
            Hit { t, normal, local }
        })
    }
}

/// All points within `radius` of a segment.
#[derive(Debug, Clone, Copy)]
pub(super) struct Capsule {
    pub(super) from: Point3<f64>,
    pub(super) to: Point3<f64>,
    pub(super) radius: f64,
}

impl Capsule {
    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let axis = self.to - self.from;
        let length2 = axis.norm_squared();
        // Share of the segment, of the ray's origin and direction: along(t) = start + rate t.
        let offset = ray.origin - self.from;
        let (start, rate) = (offset.dot(&axis) / length2, ray.direction.dot(&axis) / length2);
        let (across, sweep) = (offset - axis * start, ray.direction - axis * rate);
        let body = roots(
            sweep.norm_squared(),
            2.0 * across.dot(&sweep),
            across.norm_squared() - self.radius * self.radius,
        );
        let along_at = |t: f64| start + rate * t;
        let (t, along) = match body {
            Some((t, _)) if (0.0..=1.0).contains(&along_at(t)) => (t, along_at(t)),
            // Off the cylinder the ray can enter only through the cap at that end.
            _ => {
                let entry = body.map_or(start, |(t, _)| along_at(t));
                let cap = if entry < 0.5 { 0.0 } else { 1.0 };
                let offset = offset - axis * cap;
                let direction = ray.direction;
                let constant = offset.norm_squared() - self.radius * self.radius;
                (roots(direction.norm_squared(), 2.0 * offset.dot(&direction), constant)?.0, cap)
            }
        };
        (t > NEAREST_T).then(|| {
            let spine = self.from + axis * along;
            let normal = (ray.origin + ray.direction * t - spine).normalize();
            Hit { t, normal, local: Vector3::new(along, 0.0, 0.0) }
        })
    }

    fn rod(&self) -> Rod {
        Rod { points: [self.from, self.to, self.to], radius: self.radius }
    }

    /// Smallest distance between the surfaces of two capsules, negative when they overlap.
    pub(super) fn gap(&self, other: &Self) -> f64 {
        segment_distance(self.from, self.to, other.from, other.to) - self.radius - other.radius
    }
}

/// Smallest distance of two segments, by alternating projection: the distance is convex in both parameters, and the
/// rounds only have to be good enough to keep bodies apart.
fn segment_distance(a0: Point3<f64>, a1: Point3<f64>, b0: Point3<f64>, b1: Point3<f64>) -> f64 {
    let nearest = |from: Point3<f64>, to: Point3<f64>, point: Point3<f64>| {
        let axis = to - from;
        let length2 = axis.norm_squared();
        let share = if length2 > 0.0 { (point - from).dot(&axis) / length2 } else { 0.0 };
        from + axis * share.clamp(0.0, 1.0)
    };
    let mut on_a = nalgebra::center(&a0, &a1);
    for _ in 0..24 {
        let on_b = nearest(b0, b1, on_a);
        on_a = nearest(a0, a1, on_b);
    }
    nalgebra::distance(&on_a, &nearest(b0, b1, on_a))
}

/// A leaf: a thin sheet with a pointed outline, folded along its middle vein and bent along its length.
///
/// In its own frame (x along, y across, z its face) the sheet is z = bend x^2 + fold |y|, and it ends where
/// |y| = half_width (1 - s^2)(1 - s/3), s = x / half_length. The stalk is at s = -1.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leaf {
    pub(super) centre: Point3<f64>,
    /// Rows: along, across, face.
    pub(super) axes: Matrix3<f64>,
    pub(super) half_length: f64,
    pub(super) half_width: f64,
    /// Curvature along the leaf, 1/mm.
    pub(super) bend: f64,
    /// Slope to either side of the middle vein, not negative.
    pub(super) fold: f64,
}

/// Greatest value of the outline (1 - s^2)(1 - s/3) on -1..1, at s = 1 - sqrt(4/3), rounded up.
const BROADEST: f64 = 1.027;

/// Where along a leaf the rod around it ends.
const ROD_END: f64 = 0.55;

impl Leaf {
    /// Three places of the middle vein, with a radius large enough for the halves of the blade and for both tips.
    fn rod(&self) -> Rod {
        let blade = BROADEST * self.half_width * (1.0 + self.fold * self.fold).sqrt();
        let tip = nalgebra::distance(&self.point(1.0, 0.0), &self.point(ROD_END, 0.0));
        // Between two places the bent vein leaves their chord by bend (length / 2)^2.
        let sag = self.bend.abs() * (ROD_END * self.half_length / 2.0) * (ROD_END * self.half_length / 2.0);
        let radius = blade.max(tip) + sag;
        Rod { points: [-ROD_END, 0.0, ROD_END].map(|along| self.point(along, 0.0)), radius }
    }

    /// Point of the sheet at `along`, `across` in -1..1.
    pub(super) fn point(&self, along: f64, across: f64) -> Point3<f64> {
        let x = along * self.half_length;
        let y = across * self.half_width * outline(along);
        let z = self.bend * x * x + self.fold * y.abs();
        self.centre + self.axes.transpose() * Vector3::new(x, y, z)
    }

    fn hit(&self, ray: &Ray) -> Option<Hit> {
        let offset = ray.origin - self.centre;
        let along = |k: usize, v: &Vector3<f64>| {
            self.axes[(k, 0)] * v.x + self.axes[(k, 1)] * v.y + self.axes[(k, 2)] * v.z
        };
        // Most rays miss, and should find out soon: while one is between the bottom and the top of the box around the
        // leaf, it stays beyond one of the box's sides. Of rays along the leaf's face, with their infinities and NaN,
        // the comparisons decide nothing.
        let (oz, dz) = (along(2, &offset), along(2, &ray.direction));
        let rise = self.bend * self.half_length * self.half_length;
        let breadth = self.half_width * BROADEST;
        let (enter, leave) = ((rise.min(0.0) - oz) / dz, (rise.max(0.0) + self.fold * breadth - oz) / dz);
        let (ox, dx) = (along(0, &offset), along(0, &ray.direction));
        let (x0, x1) = (ox + dx * enter, ox + dx * leave);
        if (x0 > self.half_length && x1 > self.half_length)
            || (x0 < -self.half_length && x1 < -self.half_length)
        {
            return None;
        }
        let (oy, dy) = (along(1, &offset), along(1, &ray.direction));
        let (y0, y1) = (oy + dy * enter, oy + dy * leave);
        // On each side of the middle vein |y| is y or -y, and the sheet a parabolic cylinder.
        let sides: &[f64] = if (y0 > breadth && y1 > breadth) || (y0 < -breadth && y1 < -breadth) {
            &[]
        } else if y0 > 0.0 && y1 > 0.0 {
            &[1.0]
        } else if y0 < 0.0 && y1 < 0.0 {
            &[-1.0]
        } else {
            &[1.0, -1.0]
        };
        let mut nearest: Option<(f64, f64, f64)> = None;
        for &side in sides {
            let fold = self.fold * side;
            let a = -self.bend * dx * dx;
            let b = dz - 2.0 * self.bend * ox * dx - fold * dy;
            let c = oz - self.bend * ox * ox - fold * oy;
            let Some((first, second)) = roots(a, b, c) else { continue };
            for t in [first, second] {
                let (x, y) = (ox + dx * t, oy + dy * t);
                let inside = x.abs() <= self.half_length
                    && y * side >= 0.0
                    && y.abs() <= self.half_width * outline(x / self.half_length);
                if t > NEAREST_T && inside && nearest.is_none_or(|(other, ..)| t < other) {
                    nearest = Some((t, x, y));
                }
            }
        }
        nearest.map(|(t, x, y)| {
            let slope = Vector3::new(-2.0 * self.bend * x, -self.fold * y.signum(), 1.0);
            let local = Vector3::new(x / self.half_length, y / self.half_width, 0.0);
            Hit { t, normal: (self.axes.transpose() * slope).normalize(), local }
        })
    }
}

/// Half-width of a leaf relative to `half_width`.
fn outline(s: f64) -> f64 {
    (1.0 - s * s) * (1.0 - s / 3.0)
}

/// Real roots of a t^2 + b t + c, the smaller first; the same twice when it is linear.
fn roots(a: f64, b: f64, c: f64) -> Option<(f64, f64)> {
    if a.abs() <= 1e-12 * b.abs() {
        return (b != 0.0).then(|| (-c / b, -c / b));
    }
    let discriminant = b * b - 4.0 * a * c;
    if discriminant < 0.0 || a == 0.0 {
        return None;
    }
    // The form that does not subtract nearly equal numbers.
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    let (first, second) = if q == 0.0 { (0.0, 0.0) } else { (q / a, c / q) };
    Some(if first <= second { (first, second) } else { (second, first) })
}

#[cfg(test)]
mod tests {
    use super::super::noise::Noise;
    use super::*;

    /// Rays from the origin of the camera towards a body some 600 mm away.
    fn rays(noise: &mut Noise, target: Point3<f64>, spread: f64) -> Vec<Ray> {
        (0..2000)
            .map(|_| {
                let aim = target.coords + noise.normal_vector() * spread;
                Ray { origin: Point3::origin(), direction: aim / aim.z }
            })
            .collect()
    }

    /// Every hit is on the surface, within the rod, and has a unit normal; some rays hit and some miss.
    fn check(shape: &Shape, noise: &mut Noise, error_mm: impl Fn(Point3<f64>) -> f64) {
        let Rod { points: [a, b, c], radius } = shape.rod();
        let mut hits = 0;
        for ray in rays(noise, nalgebra::center(&a, &c), radius) {
            let Some(hit) = shape.hit(&ray) else { continue };
            hits += 1;
            let point = ray.origin + ray.direction * hit.t;
            assert!((point.z - hit.t).abs() < 1e-9);
            assert!(error_mm(point).abs() < 1e-6, "{shape:?} {point}");
            let beside = segment_distance(point, point, a, b).min(segment_distance(point, point, b, c));
            assert!(beside <= radius + 1e-9 && point.z >= shape.rod().front_mm(), "{shape:?} {point}");
            assert!((hit.normal.norm() - 1.0).abs() < 1e-12);
            if !matches!(shape, Shape::Leaf(_)) {
                assert!(hit.normal.dot(&ray.direction) <= 1e-9, "the far side was hit first");
            }
        }
        assert!((100..1900).contains(&hits), "{hits}");
    }

    #[test]
    fn rays_meet_surfaces() {
        let mut noise = Noise::new(2);
        for _ in 0..20 {
            let centre = Point3::new(noise.between(-90.0, 90.0), 20.0, 600.0);
            let first = noise.direction();
            let axes = noise.axes_about(first);
            let ellipsoid = Ellipsoid { centre, semi_axes: Vector3::new(22.0, 12.0, 9.0), axes };
            check(&Shape::Ellipsoid(ellipsoid), &mut noise, |p| {
                (ellipsoid.into_sphere(p - centre).norm() - 1.0) * 9.0
            });
            let capsule = Capsule { from: centre, to: centre + first * 60.0, radius: 7.0 };
            check(&Shape::Capsule(capsule), &mut noise, |p| {
                segment_distance(p, p, capsule.from, capsule.to) - 7.0
            });
            let leaf = Leaf { centre, axes, half_length: 30.0, half_width: 16.0, bend: -0.008, fold: 0.35 };
            check(&Shape::Leaf(leaf), &mut noise, |p| {
                let q = axes * (p - centre);
                assert!(q.x.abs() <= 30.0 && q.y.abs() <= 16.0 * BROADEST);
                q.z + 0.008 * q.x * q.x - 0.35 * q.y.abs()
            });
        }
    }

    #[test]
    fn a_ray_along_a_capsules_axis_meets_its_cap() {
        let from = Point3::new(0.0, 0.0, 500.0);
        for (from, to) in [(from, from + Vector3::z() * 40.0), (from + Vector3::z() * 40.0, from)] {
            let ray = Ray { origin: Point3::origin(), direction: Vector3::z() };
            let hit = Capsule { from, to, radius: 5.0 }.hit(&ray).unwrap();
            assert!((hit.t - 495.0).abs() < 1e-9);
        }
    }

    #[test]
    fn gaps_of_capsules() {
        let capsule =
            |from: [f64; 3], to: [f64; 3]| Capsule { from: from.into(), to: to.into(), radius: 1.0 };
        let flat = capsule([0.0, 0.0, 0.0], [10.0, 0.0, 0.0]);
        assert!((flat.gap(&capsule([5.0, -5.0, 4.0], [5.0, 5.0, 4.0])) - 2.0).abs() < 1e-9);
        assert!((flat.gap(&capsule([13.0, 4.0, 0.0], [20.0, 4.0, 0.0])) - 3.0).abs() < 1e-9);
        assert!((flat.gap(&capsule([2.0, 5.0, 0.0], [8.0, 5.0, 0.0])) - 3.0).abs() < 1e-9);
    }

    #[test]
    fn nothing_behind_the_eye_is_hit() {
        let ray = Ray { origin: Point3::origin(), direction: Vector3::z() };
        let centre = Point3::new(0.0, 0.0, -50.0);
        let ball = Ellipsoid { centre, semi_axes: Vector3::repeat(10.0), axes: Matrix3::identity() };
        assert!(ball.hit(&ray).is_none());
    }
}
