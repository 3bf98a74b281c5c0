//! Attitude angles of an ellipsoid, and how far two attitudes of ellipsoids are apart.
//!
//! An attitude is the rotation `R = Rz(theta_z) Ry(theta_y) Rx(theta_x)` (intrinsic Z-Y-X, radians) whose columns are
//! the axes. An ellipsoid does not tell an axis from its opposite: four right-handed sign choices belong to the same
//! body, so an attitude error is the least over those four. Neither does it tell equal semi-axes apart, for which
//! [`axis_error_deg`] allows.

use super::{EllipsoidF64, cross, dot, norm};
use std::f64::consts::{FRAC_PI_2, PI};

/// In which order the semi-axes take the places x, y, z of the rotation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisOrder {
    /// Largest first: the order of every result of this program.
    Descending,
    /// Smallest first: the order of the simulated ellipsoid in the paper's Table 3 (a, b, c = 1, 2, 3). In the other
    /// order that attitude is a gimbal lock and its angles say nothing.
    Ascending,
}

/// Angles about x, y, z in radians of the rotation whose columns are the given unit vectors (passed as rows).
///
/// Ranges: x and z in `[-pi, pi]`, y in `[-pi/2, pi/2]`. In gimbal lock (y = +-pi/2 to within 1e-9) x is 0.
pub fn angles_of_axes(axes: &[[f64; 3]; 3]) -> [f64; 3] {
    let [p, q, r] = axes;
    let cos_y = (q[2] * q[2] + r[2] * r[2]).sqrt();
    if cos_y < 1e-9 {
        return [0.0, if p[2] > 0.0 { -FRAC_PI_2 } else { FRAC_PI_2 }, libm::atan2(-q[0], q[1])];
    }
    [libm::atan2(q[2], r[2]), libm::atan2(-p[2], cos_y), libm::atan2(p[1], p[0])]
}

/// The columns (as rows) of the rotation with the given angles about x, y, z in radians.
pub fn axes_of_angles(angles_rad: [f64; 3]) -> [[f64; 3]; 3] {
    let [(sx, cx), (sy, cy), (sz, cz)] = angles_rad.map(libm::sincos);
    [
        [cz * cy, sz * cy, -sy],
        [cz * sy * sx - sz * cx, sz * sy * sx + cz * cx, cy * sx],
        [cz * sy * cx + sz * sx, sz * sy * cx - cz * sx, cy * cx],
    ]
}

/// The four attitudes that describe the same ellipsoid, as angles about x, y, z in radians.
pub fn equivalent_attitudes(ellipsoid: &EllipsoidF64, order: AxisOrder) -> [[f64; 3]; 4] {
    let [p, q, r] = match order {
        AxisOrder::Descending => ellipsoid.axes,
        AxisOrder::Ascending => [ellipsoid.axes[2], ellipsoid.axes[1], ellipsoid.axes[0]],
    };
    let hand = if dot(cross(p, q), r) < 0.0 { -1.0 } else { 1.0 };
    [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(|[sign_p, sign_q]| {
        let sign_r: f64 = sign_p * sign_q * hand;
        angles_of_axes(&[p.map(|v| sign_p * v), q.map(|v| sign_q * v), r.map(|v| sign_r * v)])
    })
}

/// Mean absolute difference of the three angles, radians, each taken the short way round, for that of the four
/// equivalent attitudes of `fit` which makes it least: the inner term of RMS-a. The true angles are taken as given.
pub fn attitude_error_rad(truth_rad: [f64; 3], fit: &EllipsoidF64, order: AxisOrder) -> f64 {
    let mean_difference = |angles: [f64; 3]| {
        let sum: f64 = angles.iter().zip(truth_rad).map(|(angle, truth)| short_way(angle - truth)).sum();
        sum / 3.0
    };
    equivalent_attitudes(fit, order).map(mean_difference).into_iter().fold(f64::INFINITY, f64::min)
}

/// Magnitude of an angle after full turns are taken off: `[0, pi]`.
fn short_way(angle_rad: f64) -> f64 {
    let turn = libm::fmod(angle_rad, 2.0 * PI).abs();
    if turn > PI { 2.0 * PI - turn } else { turn }
}

/// Semi-axes whose ratio is below this count as equal in [`axis_error_deg`], by default.
pub const EQUAL_AXES_RATIO: f64 = 1.03;

/// Angle in degrees, `[0, 90]`, between the true axis that can be told and the same one of the fit, whatever its sign.
///
/// That is the long axis; for a body of revolution about its short axis (a / b below `equal_ratio`) the short one.
/// Nothing when neither stands out, as in a sphere.
pub fn axis_error_deg(truth: &EllipsoidF64, fit: &EllipsoidF64, equal_ratio: f64) -> Option<f64> {
    let [a, b, c] = truth.semi_axes_mm;
    let distinct = if a > equal_ratio * b {
        0
    } else if b > equal_ratio * c {
        2
    } else {
        return None;
    };
    Some(angle_between_lines_deg(truth.axes[distinct], fit.axes[distinct]))
}

/// Angle in degrees, `[0, 90]`, between two undirected lines. Exact near 0 and near 90, where an arc cosine is not.
pub fn angle_between_lines_deg(p: [f64; 3], q: [f64; 3]) -> f64 {
    libm::atan2(norm(cross(p, q)), dot(p, q).abs()).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE_3_RAD: [f64; 3] = [0.0, 0.0, 1.05];

    fn table_3() -> EllipsoidF64 {
        EllipsoidF64::sorted([1.0; 3], [1.0, 2.0, 3.0], axes_of_angles(TABLE_3_RAD))
    }

    #[test]
    fn angles_and_axes_are_inverse() {
        for angles in [[0.3, -0.7, 2.9], [-3.0, 1.5, -0.1], [0.0, 0.0, 1.05], [1.0, -1.57, 0.5]] {
            let back = angles_of_axes(&axes_of_angles(angles));
            for k in 0..3 {
                assert!((back[k] - angles[k]).abs() < 1e-9, "{angles:?} {back:?}");
            }
        }
    }

    #[test]
    fn a_quarter_turn_about_one_axis_by_hand() {
        // Rz(90 deg): x goes to y, y to -x.
        let axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(angles_of_axes(&axes), [0.0, 0.0, FRAC_PI_2]);
        // Gimbal lock: the first axis along -z means y = +90 deg.
        let lock = [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        assert_eq!(angles_of_axes(&lock), [0.0, FRAC_PI_2, 0.0]);
    }

    #[test]
    fn the_same_body_has_no_attitude_error_whatever_its_signs() {
        let e = table_3();
        assert!(attitude_error_rad(TABLE_3_RAD, &e, AxisOrder::Ascending) < 1e-12);
        let mut turned = e;
        turned.axes[0] = turned.axes[0].map(|v| -v);
        turned.axes[1] = turned.axes[1].map(|v| -v);
        assert!(attitude_error_rad(TABLE_3_RAD, &turned, AxisOrder::Ascending) < 1e-12);
    }

    #[test]
    fn the_four_attitudes_are_rotations_onto_the_same_lines() {
        let e = EllipsoidF64::sorted([0.0; 3], [3.0, 2.0, 1.0], axes_of_angles([0.4, -0.3, 1.2]));
        for angles in equivalent_attitudes(&e, AxisOrder::Descending) {
            let axes = axes_of_angles(angles);
            assert!((dot(cross(axes[0], axes[1]), axes[2]) - 1.0).abs() < 1e-12);
            for k in 0..3 {
                assert!(angle_between_lines_deg(axes[k], e.axes[k]) < 1e-6);
            }
        }
    }

    #[test]
    fn table_3_has_the_attitude_error_one_computes_by_hand() {
        // Fitted 0.11, -0.10, 1.13 against 0, 0, 1.05: (0.11 + 0.10 + 0.08) / 3.
        let fit =
            EllipsoidF64::sorted([1.0; 3], [1.0098, 2.0354, 3.0462], axes_of_angles([0.11, -0.10, 1.13]));
        assert!((attitude_error_rad(TABLE_3_RAD, &fit, AxisOrder::Ascending) - 0.29 / 3.0).abs() < 1e-12);
    }

    #[test]
    fn angles_are_compared_the_short_way_round() {
        assert!((short_way(3.1 - -3.1) - (2.0 * PI - 6.2)).abs() < 1e-12);
        assert_eq!(short_way(-0.5), 0.5);
    }

    #[test]
    fn only_the_axis_that_can_be_told_counts() {
        let tilted = axes_of_angles([0.2, 0.0, 0.1]);
        let upright = axes_of_angles([0.0; 3]);
        let of = |semi: [f64; 3], axes| EllipsoidF64 { centre_mm: [0.0; 3], semi_axes_mm: semi, axes };
        let prolate = axis_error_deg(
            &of([22.0, 11.0, 11.0], upright),
            &of([22.0, 11.0, 11.0], tilted),
            EQUAL_AXES_RATIO,
        );
        assert!((prolate.unwrap() - 0.1_f64.to_degrees()).abs() < 1e-9);
        let oblate = axis_error_deg(
            &of([40.0, 39.5, 30.0], upright),
            &of([41.0, 39.0, 30.0], tilted),
            EQUAL_AXES_RATIO,
        );
        assert!((oblate.unwrap() - 0.2_f64.to_degrees()).abs() < 1e-9);
        assert_eq!(axis_error_deg(&of([30.0; 3], upright), &of([30.0; 3], tilted), EQUAL_AXES_RATIO), None);
    }
}
