//! Number of trials, quaternion and angles against 64 bits.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use varsac_core::{CentralQuadric, Config, Ellipsoid, Point3, jacobi::Symmetric3, trials::trials};
use varsac_tests::{random::Dice, statistics::Sample, tolerance as limit, twin};

#[test]
fn trials_against_64_bits() {
    let (mut off, mut equal) = (Sample::default(), Sample::default());
    for case in 0..50_000 {
        let mut dice = Dice::new("trials", case);
        let mut config = Config { confidence: dice.between(0.01, 0.9999) as f32, ..Config::table5() };
        config.sample_sizes.truncate(1 + dice.below(4));
        let ratio = dice.unit() as f32;
        let ours = trials(config.confidence, &config.sample_sizes, ratio, config.max_trials);
        let judge = twin::trials_needed(&config, f64::from(ratio));
        off.push(f64::from(ours.abs_diff(judge)));
        equal.push(f64::from(u8::from(ours == judge)));
    }
    limit::TRIALS_OFF.check(off.max());
    limit::TRIALS_EQUAL.check(equal.share_above(0.5));
}

/// An ellipsoid of known attitude, through the core's own eigen-decomposition.
fn attitude(rotation: &Matrix3<f64>) -> Ellipsoid {
    let d = Matrix3::from_diagonal(&Vector3::new(1.0 / 9.0, 0.25, 1.0));
    let s = (rotation * d * rotation.transpose()).map(|v| v as f32);
    let shape = Symmetric3 { xx: s.m11, yy: s.m22, zz: s.m33, xy: s.m12, xz: s.m13, yz: s.m23 };
    Ellipsoid::from(&CentralQuadric { centre: Point3::origin(), shape })
}

/// The rotation of the axes as they are, in 64 bits, made orthonormal.
fn judge(e: &Ellipsoid) -> Rotation3<f64> {
    let [a, b, c] = e.axes.map(|axis| Vector3::from(axis.map(f64::from)));
    let a = a.normalize();
    let b = (b - a * a.dot(&b)).normalize();
    assert!(a.cross(&b).dot(&c) > 0.999_999, "right-handed: {e:?}");
    Rotation3::from_matrix_unchecked(Matrix3::from_columns(&[a, b, a.cross(&b)]))
}

#[test]
fn quaternion_and_angles_against_64_bits() {
    let (mut quaternion, mut angles, mut direct) = (Sample::default(), Sample::default(), Sample::default());
    for case in 0..20_000 {
        let mut dice = Dice::new("attitude", case);
        let axis = nalgebra::Unit::new_normalize(dice.normal3());
        let small = libm::pow(10.0, dice.between(-8.0, -1.0));
        let rotation = match case % 4 {
            // Anywhere; close to half a turn, where w vanishes; close to the pole, where the long axis points along z.
            0 => dice.rotation(),
            1 => Rotation3::from_axis_angle(&axis, core::f64::consts::PI - small).into_inner(),
            2 => Rotation3::from_euler_angles(3.0 * dice.unit(), core::f64::consts::FRAC_PI_2 - small, 2.0)
                .into_inner(),
            _ => Rotation3::from_axis_angle(&axis, small).into_inner(),
        };
        let e = attitude(&rotation);
        let truth = judge(&e);

        let [x, y, z, w] = e.quaternion_xyzw().map(f64::from);
        assert!(w >= 0.0);
        assert!((x * x + y * y + z * z + w * w - 1.0).abs() < 1e-6);
        let ours = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        quaternion.push(ours.angle_to(&UnitQuaternion::from_rotation_matrix(&truth)));

        let [x, y, z] = e.attitude_rad().map(f64::from);
        angles.push(Rotation3::from_euler_angles(x, y, z).angle_to(&truth));
        let (roll, pitch, yaw) = truth.euler_angles();
        if pitch.abs() < 1.5 {
            let apart = |a: f64, b: f64| libm::fabs(libm::remainder(a - b, core::f64::consts::TAU));
            direct.push(apart(x, roll).max(apart(y, pitch)).max(apart(z, yaw)) * libm::cos(pitch));
        }
    }
    limit::QUATERNION.check(quaternion.max());
    limit::ANGLES.check(angles.max());
    limit::ANGLES_DIRECT.check(direct.max());
}
