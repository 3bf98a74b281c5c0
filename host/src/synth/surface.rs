//! Seeded families of whole surfaces: clouds as a scanner or a turned magnetometer makes them, with the truth.
//!
//! Unit: the geometric mean of the semi-axes is [`SIZE`] (ten, of any unit). Noise, clutter and density vary; beside
//! ellipsoids there are the bodies that a search must not take for one.

use nalgebra::{Matrix3, Vector3};
use varsac_core::Point3;

use super::noise::Noise;
use super::simulation::{half_extent, surface_point};
use crate::eval::EllipsoidF64;

/// Geometric mean of the semi-axes.
pub const SIZE: f64 = 10.0;

/// What the points lie on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Body {
    /// An ellipsoid, uniform by area.
    Ellipsoid,
    /// An ellipsoid, uniform by direction from the centre in the space where it is a sphere: dense at the tips.
    EllipsoidByDirection,
    /// A flat rectangle.
    Plane,
    /// A cylinder without ends.
    Pipe,
    /// A cylinder with ends.
    Cylinder,
    /// A box.
    Box,
    /// Nothing: all points are random.
    Clutter,
}

/// A family of clouds: every pair is a range drawn from uniformly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceFamily {
    /// Name in tables.
    pub name: &'static str,
    /// What the points lie on.
    pub body: Body,
    /// Points of a cloud.
    pub point_count: usize,
    /// Standard deviation of the error of each coordinate over [`SIZE`].
    pub noise: (f64, f64),
    /// Share of points that do not lie on the surface.
    pub outliers: (f64, f64),
    /// Longest over shortest semi-axis, uniform in its logarithm; the middle one likewise between them.
    pub aspect: (f64, f64),
    /// Part of the sphere of directions that is covered: a cap about a random direction.
    pub coverage: (f64, f64),
    /// Edge of the box of random points over the edge of the box around the body.
    pub box_scale: (f64, f64),
    /// The box of random points lies off the centre by so many [`SIZE`], in a random direction.
    pub offset: (f64, f64),
    /// Share of the random points that lie on a plane patch instead.
    pub plane: (f64, f64),
}

/// Complete ellipsoids with everything varied.
pub const SURFACE: SurfaceFamily = SurfaceFamily {
    name: "surface",
    body: Body::Ellipsoid,
    point_count: 1500,
    noise: (0.01, 0.1),
    outliers: (0.0, 0.6),
    aspect: (1.0, 10.0),
    coverage: (1.0, 1.0),
    box_scale: (1.2, 2.0),
    offset: (0.0, 0.0),
    plane: (0.0, 0.0),
};

/// Clutter on one side, a dense plane patch in it.
pub const CLUTTERED: SurfaceFamily = SurfaceFamily {
    name: "clutter",
    outliers: (0.3, 0.6),
    noise: (0.01, 0.05),
    aspect: (1.0, 4.0),
    box_scale: (1.5, 2.5),
    offset: (0.5, 2.0),
    plane: (0.3, 0.5),
    ..SURFACE
};

/// A cloud and the truth about it.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceCloud {
    /// Points in random order.
    pub points: Vec<Point3>,
    /// The ellipsoid (the one that surrounds the body where the body is none).
    pub truth: EllipsoidF64,
    /// Standard deviation of the error of each coordinate.
    pub sigma: f64,
    /// Share of points that do not lie on the surface.
    pub outliers: f64,
    /// Covered part of the directions.
    pub coverage: f64,
}

impl SurfaceFamily {
    /// The same with another name, for a change of a field.
    #[must_use]
    pub const fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// The cloud of this family that belongs to `seed`. `O(points)`.
    pub fn cloud(&self, seed: u64) -> SurfaceCloud {
        let mut noise = Noise::new(seed);
        let draw = |noise: &mut Noise, (low, high)| noise.between(low, high);
        let sigma = SIZE * draw(&mut noise, self.noise);
        let outliers = draw(&mut noise, self.outliers);
        let coverage = draw(&mut noise, self.coverage);
        let semi_axes = self.semi_axes(&mut noise);
        let first = noise.direction();
        let rotation = noise.axes_about(first).transpose();
        let centre = noise.normal_vector() * (3.0 * SIZE);
        let extent = half_extent(&rotation, &semi_axes);
        let reach = extent * draw(&mut noise, self.box_scale);
        let middle = noise.direction() * (SIZE * draw(&mut noise, self.offset));
        let patch = Patch::new(&mut noise, middle, &reach);
        let on_patch = draw(&mut noise, self.plane);
        let up = noise.direction();

        let outlier_count = (outliers * self.point_count as f64).round() as usize;
        let mut points: Vec<Point3> = (0..self.point_count)
            .map(|index| {
                let place = if index < outlier_count || self.body == Body::Clutter {
                    if noise.uniform() < on_patch {
                        patch.point(&mut noise)
                    } else {
                        middle + reach.map(|reach| noise.between(-reach, reach))
                    }
                } else {
                    let error = noise.normal_vector() * sigma;
                    rotation * self.body_point(&semi_axes, &up, coverage, &mut noise) + error
                };
                Point3::from((centre + place).map(|x| x as f32))
            })
            .collect();
        for last in (1..points.len()).rev() {
            points.swap(last, noise.below(last + 1));
        }
        let truth = EllipsoidF64::of_matrix(centre, semi_axes.into(), rotation.transpose());
        SurfaceCloud { points, truth, sigma, outliers, coverage }
    }

    /// Semi-axes of the geometric mean [`SIZE`].
    fn semi_axes(&self, noise: &mut Noise) -> Vector3<f64> {
        let aspect = noise.between(libm::log(self.aspect.0), libm::log(self.aspect.1));
        let middle = aspect * noise.uniform();
        let mean = (aspect + middle) / 3.0;
        Vector3::new(aspect - mean, middle - mean, -mean).map(|x| SIZE * libm::exp(x))
    }

    /// A point of the body within the covered directions.
    fn body_point(
        &self,
        semi_axes: &Vector3<f64>,
        up: &Vector3<f64>,
        coverage: f64,
        noise: &mut Noise,
    ) -> Vector3<f64> {
        loop {
            let point = self.any_point(semi_axes, noise);
            // A cap of height h covers the part h / 2 of the sphere.
            if point.component_div(semi_axes).normalize().dot(up) >= 1.0 - 2.0 * coverage {
                return point;
            }
        }
    }

    fn any_point(&self, semi_axes: &Vector3<f64>, noise: &mut Noise) -> Vector3<f64> {
        let [a, b, c] = (*semi_axes).into();
        match self.body {
            Body::Ellipsoid | Body::Clutter => surface_point(semi_axes, noise),
            Body::EllipsoidByDirection => noise.direction().component_mul(semi_axes),
            Body::Plane => Vector3::new(noise.between(-a, a), noise.between(-b, b), 0.0),
            Body::Pipe => {
                let angle = noise.between(0.0, std::f64::consts::TAU);
                Vector3::new(noise.between(-a, a), c * libm::cos(angle), c * libm::sin(angle))
            }
            Body::Cylinder => {
                // Side 2 pi c 2a, ends 2 pi c^2.
                let angle = noise.between(0.0, std::f64::consts::TAU);
                let end = noise.uniform() < c / (c + 2.0 * a);
                let (x, r) = if end {
                    (a.copysign(noise.between(-1.0, 1.0)), c * noise.uniform().sqrt())
                } else {
                    (noise.between(-a, a), c)
                };
                Vector3::new(x, r * libm::cos(angle), r * libm::sin(angle))
            }
            Body::Box => {
                let areas = [b * c, c * a, a * b];
                let mut pick = noise.uniform() * (areas[0] + areas[1] + areas[2]);
                let face = areas.iter().position(|area| {
                    pick -= area;
                    pick < 0.0
                });
                let mut point = semi_axes.map(|half| noise.between(-half, half));
                let face = face.unwrap_or(2);
                point[face] = semi_axes[face].copysign(point[face]);
                point
            }
        }
    }
}

/// A flat square among the clutter.
struct Patch {
    middle: Vector3<f64>,
    sides: [Vector3<f64>; 2],
}

impl Patch {
    /// A patch half as wide as the box of random points, somewhere in it.
    fn new(noise: &mut Noise, middle: Vector3<f64>, reach: &Vector3<f64>) -> Self {
        let first = noise.direction();
        let axes: Matrix3<f64> = noise.axes_about(first);
        let side = 0.25 * reach.sum();
        let middle = middle + reach.map(|reach| noise.between(-reach, reach) * 0.8);
        Self { middle, sides: [axes.row(0).transpose() * side, axes.row(1).transpose() * side] }
    }

    fn point(&self, noise: &mut Noise) -> Vector3<f64> {
        let [u, v] = self.sides;
        self.middle
            + u * noise.between(-1.0, 1.0)
            + v * noise.between(-1.0, 1.0)
            + noise.normal_vector() * (0.01 * SIZE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_sizes_are_as_ordered() {
        let family = SurfaceFamily { noise: (0.0, 0.0), outliers: (0.4, 0.4), ..SURFACE };
        for seed in 0..20 {
            let cloud = family.cloud(seed);
            let [a, b, c] = cloud.truth.semi_axes_mm;
            assert!((a * b * c / SIZE.powi(3) - 1.0).abs() < 1e-9 && a / c <= 10.0);
            let on =
                cloud.points.iter().filter(|p| (cloud.truth.level(&p.cast()) - 1.0).abs() < 1e-5).count();
            assert!((900..905).contains(&on), "{on}");
        }
    }

    #[test]
    fn half_a_body_is_half_a_body() {
        let family = SurfaceFamily {
            noise: (0.0, 0.0),
            outliers: (0.0, 0.0),
            coverage: (0.5, 0.5),
            aspect: (1.0, 1.0),
            ..SURFACE
        };
        let cloud = family.cloud(3);
        let mean = cloud.points.iter().fold(Vector3::zeros(), |sum, p| sum + p.coords.cast::<f64>())
            / cloud.points.len() as f64;
        // The mean of half a sphere is half a radius from its centre.
        assert!(((mean - Vector3::from(cloud.truth.centre_mm)).norm() / SIZE - 0.5).abs() < 0.03);
    }

    #[test]
    fn a_seed_gives_the_same_bits() {
        assert_eq!(CLUTTERED.cloud(7), CLUTTERED.cloud(7));
        assert_ne!(CLUTTERED.cloud(7).points, CLUTTERED.cloud(8).points);
    }
}
