//! The paper's simulation (III.A, Tables 2 and 3): points on an ellipsoid with Gaussian errors, and random points.
//!
//! Unit: none, the paper gives none. Defaults are the paper's: semi-axes 1, 2, 3, centre (1, 1, 1), angles
//! (0, 0, 1.05) rad, about 30 % random points. It leaves open how points are spread over the surface and where the
//! random ones fall; here they are uniform by area, and uniform in the bounding box enlarged by
//! [`SimulationOptions::box_scale`].

use nalgebra::{Matrix3, Vector3};
use varsac_core::Point3;

use super::noise::Noise;
use crate::error::InputError;
use crate::eval::EllipsoidF64;

/// What to simulate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SimulationOptions {
    /// Every seed is valid; the same seed gives the same bits.
    pub seed: u64,
    /// All points, on the surface and random.
    pub point_count: usize,
    /// Share of random points, 0 to 1; rounded to whole points.
    pub outlier_fraction: f64,
    /// Standard deviation of the error of each coordinate of a surface point.
    pub sigma: f64,
    /// Semi-axes along the body's x, y and z.
    pub semi_axes: [f64; 3],
    /// Centre.
    pub centre: [f64; 3],
    /// Rotation of the body about x, y and z, rad, composed as Rz Ry Rx.
    pub attitude_rad: [f64; 3],
    /// Edge of the box of random points relative to the ellipsoid's bounding box, same centre.
    pub box_scale: f64,
}

impl Default for SimulationOptions {
    fn default() -> Self {
        Self {
            seed: 1,
            point_count: 1000,
            outlier_fraction: 0.3,
            sigma: 0.1,
            semi_axes: [1.0, 2.0, 3.0],
            centre: [1.0; 3],
            attitude_rad: [0.0, 0.0, 1.05],
            box_scale: 1.25,
        }
    }
}

/// A simulated cloud and the truth about it.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// Points in random order.
    pub points: Vec<Point3>,
    /// For each point whether it was put on the surface. A random point may lie there by chance.
    pub on_surface: Vec<bool>,
    /// The ellipsoid.
    pub truth: EllipsoidF64,
}

/// Simulates one cloud. `O(points)`.
///
/// # Errors
/// Semi-axes that are not positive, a negative sigma, or any number that is not finite.
pub fn simulate(options: &SimulationOptions) -> Result<Simulation, InputError> {
    check(options)?;
    let mut noise = Noise::new(options.seed);
    let rotation = rotation(options.attitude_rad);
    let centre = Vector3::from(options.centre);
    let semi_axes = Vector3::from(options.semi_axes);
    let outlier_count = (options.outlier_fraction * options.point_count as f64).round() as usize;
    let reach = half_extent(&rotation, &semi_axes) * options.box_scale;

    let mut labelled: Vec<(Point3, bool)> = (0..options.point_count)
        .map(|index| {
            let on_surface = index >= outlier_count;
            let place = if on_surface {
                let error = noise.normal_vector() * options.sigma;
                rotation * surface_point(&semi_axes, &mut noise) + error
            } else {
                reach.map(|reach| noise.between(-reach, reach))
            };
            (Point3::from((centre + place).map(|x| x as f32)), on_surface)
        })
        .collect();
    // Fisher-Yates: neither kind of point may come first.
    for last in (1..labelled.len()).rev() {
        labelled.swap(last, noise.below(last + 1));
    }
    let (points, on_surface) = labelled.into_iter().unzip();
    let truth = EllipsoidF64::of_matrix(centre, options.semi_axes, rotation.transpose());
    Ok(Simulation { points, on_surface, truth })
}

fn check(options: &SimulationOptions) -> Result<(), InputError> {
    let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
    let refuse = |what: String, remedy: &str| Err(InputError::at("simulation", what, remedy));
    if !finite(&options.semi_axes) || options.semi_axes.iter().any(|&length| length <= 0.0) {
        return refuse(format!("semi-axes are {:?}", options.semi_axes), "give three positive lengths");
    }
    if !finite(&options.centre) || !finite(&options.attitude_rad) {
        let (centre, attitude) = (options.centre, options.attitude_rad);
        return refuse(format!("centre is {centre:?}, attitude {attitude:?}"), "give finite numbers");
    }
    let spreads = [options.sigma, options.box_scale, options.outlier_fraction];
    if !finite(&spreads) || spreads.iter().any(|&value| value < 0.0) || options.outlier_fraction > 1.0 {
        let [sigma, box_scale, fraction] = spreads;
        return refuse(
            format!("sigma is {sigma}, box scale {box_scale}, outlier fraction {fraction}"),
            "give finite numbers that are not negative, and a fraction of at most 1",
        );
    }
    Ok(())
}

/// Rz Ry Rx, with `libm`'s sines and cosines.
fn rotation([x, y, z]: [f64; 3]) -> Matrix3<f64> {
    let about = |axis: Vector3<f64>, angle: f64| {
        let (s, c) = libm::sincos(angle);
        let k = axis.cross_matrix();
        Matrix3::identity() + k * s + k * k * (1.0 - c)
    };
    about(Vector3::z(), z) * about(Vector3::y(), y) * about(Vector3::x(), x)
}

/// Half the edges of the bounding box of a centred ellipsoid: along x the largest x is |(R D)^T e_x|.
pub(super) fn half_extent(rotation: &Matrix3<f64>, semi_axes: &Vector3<f64>) -> Vector3<f64> {
    let stretched = rotation * Matrix3::from_diagonal(semi_axes);
    Vector3::new(stretched.row(0).norm(), stretched.row(1).norm(), stretched.row(2).norm())
}

/// A point of a centred, unrotated ellipsoid, uniform by area.
///
/// Stretching the unit sphere by D stretches the area at u in proportion to |D^-1 u|, at most 1 / smallest semi-axis:
/// a direction is accepted with its share of that.
pub(super) fn surface_point(semi_axes: &Vector3<f64>, noise: &mut Noise) -> Vector3<f64> {
    loop {
        let u = noise.direction();
        if noise.uniform() <= u.component_div(semi_axes).norm() * semi_axes.min() {
            return u.component_mul(semi_axes);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_ellipsoid_stands_as_described() {
        let simulation = simulate(&SimulationOptions { sigma: 0.0, ..SimulationOptions::default() }).unwrap();
        let truth = &simulation.truth;
        assert_eq!(truth.semi_axes_mm, [3.0, 2.0, 1.0]);
        // The semi-axis 1 is the body's x, turned by 1.05 rad about z.
        let shortest = Vector3::from(truth.axes[2]);
        assert!((shortest.dot(&Vector3::new(1.05_f64.cos(), 1.05_f64.sin(), 0.0))).abs() > 1.0 - 1e-12);
        for (point, _) in simulation.points.iter().zip(&simulation.on_surface).filter(|(_, on)| **on) {
            assert!((truth.level(&point.cast()) - 1.0).abs() < 1e-5);
        }
    }

    #[test]
    fn shares_are_exact_and_order_says_nothing() {
        let simulation = simulate(&SimulationOptions::default()).unwrap();
        assert_eq!(simulation.points.len(), 1000);
        assert_eq!(simulation.on_surface.iter().filter(|on| !**on).count(), 300);
        let early = simulation.on_surface[..500].iter().filter(|on| !**on).count();
        assert!((110..190).contains(&early), "{early}");
    }

    #[test]
    fn random_points_fill_the_enlarged_box_and_not_more() {
        let options =
            SimulationOptions { outlier_fraction: 1.0, point_count: 5000, ..SimulationOptions::default() };
        let simulation = simulate(&options).unwrap();
        // z is a semi-axis of its own: 1 -+ 3 * 1.25.
        let lowest = simulation.points.iter().map(|p| p.z).fold(f32::INFINITY, f32::min);
        let highest = simulation.points.iter().map(|p| p.z).fold(f32::NEG_INFINITY, f32::max);
        assert!((-2.75..-2.7).contains(&lowest) && (4.7..=4.75).contains(&highest), "{lowest} {highest}");
    }

    #[test]
    fn points_are_uniform_by_area() {
        // A flat spheroid (semi-axes 2, 2, 0.2) is nearly two discs: a quarter of them lies within half the radius.
        let mut noise = Noise::new(4);
        let semi_axes = Vector3::new(2.0, 2.0, 0.2);
        let count = 20_000;
        let inner = (0..count).filter(|_| surface_point(&semi_axes, &mut noise).xy().norm() < 1.0).count();
        let share = inner as f64 / f64::from(count);
        // Area within half the radius over the whole, by the formula of the spheroid: 0.2429.
        assert!((share - 0.2429).abs() < 0.012, "{share}");
    }

    #[test]
    fn a_seed_gives_the_same_bits() {
        let options = SimulationOptions { seed: u64::MAX, ..SimulationOptions::default() };
        let simulation = simulate(&options).unwrap();
        assert_eq!(simulate(&options).unwrap(), simulation);
        assert_ne!(simulate(&SimulationOptions { seed: 0, ..options }).unwrap().points, simulation.points);
    }

    #[test]
    fn impossible_options_are_refused() {
        let good = SimulationOptions::default();
        for bad in [
            SimulationOptions { semi_axes: [1.0, 0.0, 3.0], ..good },
            SimulationOptions { semi_axes: [1.0, f64::NAN, 3.0], ..good },
            SimulationOptions { centre: [0.0, f64::INFINITY, 0.0], ..good },
            SimulationOptions { sigma: -0.1, ..good },
            SimulationOptions { outlier_fraction: 1.1, ..good },
        ] {
            assert!(simulate(&bad).is_err(), "{bad:?}");
        }
    }
}
