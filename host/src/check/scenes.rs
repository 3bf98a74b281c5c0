//! Synthetic clouds of the check, one function a family. Each one sets the lengths of the configuration to suit its
//! cloud and leaves the rest as it is.

use super::cases::Dice;
use varsac_core::{Config, Point3, Vector3};

/// An ellipsoid to draw points from.
struct Body {
    centre: Point3,
    semi_axes: [f32; 3],
    /// Columns are the axes.
    axes: [Vector3; 3],
}

impl Body {
    fn random(dice: &mut Dice, centre: Point3, semi_axes: [f32; 3]) -> Self {
        let a = direction(dice);
        let other = direction(dice);
        let c = a.cross(&other);
        let length = libm::sqrtf(c.dot(&c));
        // Parallel directions (probability 1e-7 or so) leave the axes of the camera.
        let axes = if length > 1e-3 {
            let c = c / length;
            [a, c.cross(&a), c]
        } else {
            [Vector3::x(), Vector3::y(), Vector3::z()]
        };
        Self { centre, semi_axes, axes }
    }

    /// A point of the surface and the outward normal there (not of unit length).
    fn point(&self, dice: &mut Dice) -> (Point3, Vector3) {
        let u = direction(dice);
        let [a, b, c] = self.semi_axes;
        let at = self.axes[0] * (a * u.x) + self.axes[1] * (b * u.y) + self.axes[2] * (c * u.z);
        let normal = self.axes[0] * (u.x / a) + self.axes[1] * (u.y / b) + self.axes[2] * (u.z / c);
        (self.centre + at, normal)
    }
}

/// A direction, uniform on the sphere.
fn direction(dice: &mut Dice) -> Vector3 {
    loop {
        let v = Vector3::new(dice.between(-1.0, 1.0), dice.between(-1.0, 1.0), dice.between(-1.0, 1.0));
        let square = v.x * v.x + v.y * v.y + v.z * v.z;
        if square > 0.01 && square <= 1.0 {
            return v / libm::sqrtf(square);
        }
    }
}

/// A point in the cube of half-width `reach` around `centre`.
fn in_cube(dice: &mut Dice, centre: &Point3, reach: f32) -> Point3 {
    let mut offset = || dice.between(-reach, reach);
    Point3::new(centre.x + offset(), centre.y + offset(), centre.z + offset())
}

/// Reorders the points, so that inliers are not the first of the cloud.
fn shuffle(dice: &mut Dice, cloud: &mut [Point3]) {
    for k in (1..cloud.len()).rev() {
        cloud.swap(k, dice.below(k as u32 + 1) as usize);
    }
}

/// The paper's simulation: semi-axes about 3, 2, 1, Gaussian error, up to 40 % outliers, some of them left out.
pub(super) fn surface(dice: &mut Dice, config: &mut Config) -> Vec<Point3> {
    (config.semi_axis_min, config.semi_axis_max) = (0.5, 4.0);
    config.radius = dice.pick(&[f32::INFINITY, 6.5, 2.5, 1.0]);
    let semi_axes = [dice.between(2.0, 3.5), dice.between(1.2, 2.2), dice.between(0.8, 1.3)];
    let body = Body::random(dice, Point3::new(1.0, 1.0, 1.0), semi_axes);
    let noise = dice.pick(&[0.0, 0.005, 0.03]);
    let inliers = 40 + dice.below(160);
    let outliers = inliers * dice.below(40) / 60;
    let mut cloud = Vec::new();
    for _ in 0..inliers {
        let (p, _) = body.point(dice);
        cloud.push(p + Vector3::new(dice.normal(), dice.normal(), dice.normal()) * noise);
    }
    for _ in 0..outliers {
        cloud.push(in_cube(dice, &body.centre, 4.0));
    }
    shuffle(dice, &mut cloud);
    cloud
}

/// The whole surfaces of one or two bodies of these semi-axes that touch or nearly so, with noise and stray points.
pub(super) fn surfaces(dice: &mut Dice, semi_axes: [f32; 3], mut centre: Point3) -> Vec<Point3> {
    let noise = dice.pick(&[0.0, 0.2, 1.0]);
    let mut cloud = Vec::new();
    for _ in 0..=dice.below(2) {
        let body = Body::random(dice, centre, semi_axes);
        for _ in 0..60 + dice.below(140) {
            let (p, _) = body.point(dice);
            cloud.push(p + Vector3::new(dice.normal(), dice.normal(), dice.normal()) * noise);
        }
        centre += direction(dice) * dice.between(20.0, 40.0);
    }
    for _ in 0..dice.below(60) {
        cloud.push(in_cube(dice, &centre, 40.0));
    }
    shuffle(dice, &mut cloud);
    cloud
}

/// The camera's side of `fruit` jujubes that touch, 500 to 1300 mm away, with noise along the ray, and clutter.
pub(super) fn view(dice: &mut Dice, config: &mut Config, fruit: u32) -> Vec<Point3> {
    (config.semi_axis_min, config.semi_axis_max) = dice.pick(&[(9.5, 24.5), (10.0, 23.0), (5.0, 60.0)]);
    config.radius = dice.pick(&[30.0, 30.0, 20.0, f32::INFINITY]);
    let mut centre =
        Point3::new(dice.between(-200.0, 200.0), dice.between(-150.0, 150.0), dice.between(500.0, 1300.0));
    let noise = dice.pick(&[0.0, 0.2, 1.0]);
    let mut cloud = Vec::new();
    for _ in 0..fruit {
        let semi_axes = [dice.between(20.0, 23.5), dice.between(10.2, 11.8), dice.between(10.2, 11.8)];
        let body = Body::random(dice, centre, semi_axes);
        for _ in 0..60 + dice.below(120) {
            let (p, normal) = body.point(dice);
            if normal.dot(&p.coords) < 0.0 {
                cloud.push(p * (1.0 + noise * dice.normal() / p.z));
            }
        }
        centre += direction(dice) * dice.between(20.0, 26.0);
    }
    let seen = cloud.len() as u32;
    let leaf = direction(dice);
    for k in 0..seen * dice.below(40) / 60 {
        let p = in_cube(dice, &centre, 40.0);
        // Every second one lies on a leaf, a plane through the fruit.
        let off = leaf.dot(&(p - centre));
        cloud.push(if k % 2 == 0 { p } else { p - leaf * off });
    }
    shuffle(dice, &mut cloud);
    cloud
}

/// Grid points on one or two spheres of radius 5 or 3 and some beside them; radii at which distances tie.
pub(super) fn grid(dice: &mut Dice, config: &mut Config) -> Vec<Point3> {
    let unit = dice.pick(&[1.0, 0.5, 4.0, 3.0]);
    (config.semi_axis_min, config.semi_axis_max) = (unit, 8.0 * unit);
    config.radius = unit * dice.pick(&[5.0, 10.0, 3.0, 13.0]);
    let shift = dice.pick(&[0.0, 64.0, 700.0]);
    let stretch = dice.pick(&[1.0, 2.0]);
    let stray = dice.below(30);
    let mut cloud = Vec::new();
    for x in -5..=5_i8 {
        for y in -5..=5_i8 {
            for z in -5..=5_i8 {
                let [x, y, z] = [f32::from(x), f32::from(y), f32::from(z)];
                let square = x * x + y * y + z * z;
                if square == 25.0 || square == 9.0 || dice.below(1331) < stray {
                    cloud.push(Point3::new(x * unit * stretch, y * unit, z * unit + shift));
                }
            }
        }
    }
    if dice.below(2) == 0 {
        shuffle(dice, &mut cloud);
    }
    cloud
}

/// Clouds that determine no ellipsoid, the perfect sphere, and clouds that must be refused.
pub(super) fn degenerate(dice: &mut Dice, config: &mut Config) -> Vec<Point3> {
    config.radius = dice.pick(&[30.0, f32::INFINITY, 1e-9, 1e9]);
    config.semi_axis_min = dice.pick(&[9.5, 1e-9, 1.0]);
    config.semi_axis_max = dice.pick(&[24.5, 1e9, 1000.0]);
    let count = dice.pick(&[0, 1, 5, 8, 9, 12, 40, 100]);
    let kind = dice.below(8);
    let (along, across) = (direction(dice), direction(dice));
    let mut cloud = Vec::new();
    for k in 0..count {
        let (s, t) = (dice.between(-30.0, 30.0), dice.between(-30.0, 30.0));
        let p = Point3::new(0.0, 0.0, 700.0);
        cloud.push(match kind {
            // A plane, a line, one point, a few points again and again.
            0 => p + along * s + across * t,
            1 => p + along * s,
            2 => p,
            3 => p + along * (k % 7) as f32 + across * (k % 3) as f32,
            // A sphere, a cylinder, two parallel planes.
            4 => p + direction(dice) * 12.0,
            5 => p + along * s + along.cross(&direction(dice)) * 10.0,
            6 => Point3::new(s, t, if k % 2 == 0 { 690.0 } else { 710.0 }),
            // A cloud to be refused, unless the coordinate is the largest that is allowed.
            _ => {
                let bad = dice.pick(&[f32::NAN, f32::INFINITY, 1.1e9, -1e9]);
                if k == count / 2 { Point3::new(s, bad, t) } else { p + along * s }
            }
        });
    }
    cloud
}

/// A surface, a view or a grid, multiplied by a power of two and a little more, down to subnormal spreads.
pub(super) fn scaled(dice: &mut Dice, config: &mut Config) -> Vec<Point3> {
    let mut cloud = match dice.below(3) {
        0 => surface(dice, config),
        1 => view(dice, config, 1),
        _ => grid(dice, config),
    };
    let exponent = dice.pick(&[-145, -138, -128, -126, -100, -64, -33, -20, 10, 19]);
    let factor = dice.between(1.0, 1.9) * libm::ldexpf(1.0, exponent);
    let shift = dice.pick(&[0.0, 0.0, 1.0e-4, 100.0]);
    for p in &mut cloud {
        *p = Point3::new(p.x * factor, p.y * factor, p.z * factor + shift);
    }
    // Lengths of a configuration end at 1e-9 and 1e9: below that, no hypothesis has the right size, but it is fitted.
    config.radius = if config.radius == f32::INFINITY {
        f32::INFINITY
    } else {
        within(config.radius * factor, 1e-9, 1e9)
    };
    config.semi_axis_min = within(config.semi_axis_min * factor, 1e-9, 1e8);
    config.semi_axis_max = within(config.semi_axis_max * factor, 2e-9, 1e9);
    cloud
}

fn within(value: f32, low: f32, high: f32) -> f32 {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

/// A surface without noise and with no other point, or nearly none; a target needs all of its points.
pub(super) fn exact(dice: &mut Dice, config: &mut Config) -> Vec<Point3> {
    (config.semi_axis_min, config.semi_axis_max) = (5.0, 40.0);
    config.radius = f32::INFINITY;
    let count = 20 + dice.below(40);
    let semi_axes = [dice.between(20.0, 30.0), dice.between(12.0, 20.0), dice.between(8.0, 12.0)];
    let body = Body::random(dice, Point3::new(0.0, 0.0, 700.0), semi_axes);
    let mut cloud: Vec<Point3> = (0..count).map(|_| body.point(dice).0).collect();
    for _ in 0..dice.below(4) {
        cloud.push(in_cube(dice, &Point3::new(0.0, 0.0, 850.0), 20.0));
    }
    config.min_inliers = count as u16;
    config.min_ratio = 0.0;
    cloud
}
