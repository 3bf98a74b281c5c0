//! Semi-axes, axes and attitude of a surface: contract, chapter 11, steps 3 to 6; Eq. (11) to (13).

use crate::fault::{self, Fault};
use crate::{Central, ascending, eigen};

/// An ellipsoid as it is reported.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Centre, mm.
    pub centre: [f32; 3],
    /// Semi-axes, mm, descending.
    pub semi_axes: [f32; 3],
    /// Unit vectors of the semi-axes, one a row, right-handed.
    pub axes: [[f32; 3]; 3],
    /// The rotation whose columns are the axes, as (x, y, z, w) with `w >= 0`.
    pub quaternion: [f32; 4],
    /// The same rotation as `[theta_x, theta_y, theta_z]`, rad.
    pub angles: [f32; 3],
}

/// Chapter 11.
pub fn ellipsoid_of(surface: &Central) -> Ellipsoid {
    let sorted = ascending(&eigen(&surface.shape));
    let semi_axes = semi_axes(&sorted.values);
    let axes = with_signs(&sorted.vectors);
    Ellipsoid {
        centre: surface.centre,
        semi_axes,
        axes,
        quaternion: quaternion(&axes),
        angles: angles(&axes),
    }
}

/// Chapter 11.3.
fn semi_axes(eigenvalues: &[f32; 3]) -> [f32; 3] {
    let mut semi_axes = [0.0; 3];
    for k in 0..3 {
        semi_axes[k] = if fault::is(Fault::Ellipsoid) {
            libm::sqrtf(1.0 / eigenvalues[k])
        } else {
            1.0 / libm::sqrtf(eigenvalues[k])
        };
    }
    semi_axes
}

/// Chapter 11.4.
pub(crate) fn with_signs(vectors: &[[f32; 3]; 3]) -> [[f32; 3]; 3] {
    let (a, b) = (oriented(vectors[0]), oriented(vectors[1]));
    let mut c = vectors[2];
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    if cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2] < 0.0 {
        c = negated(c);
    }
    [a, b, c]
}

/// Chapter 11.4: the sign of the first and of the second vector.
pub(crate) fn oriented(v: [f32; 3]) -> [f32; 3] {
    if largest_component(v) < 0.0 { negated(v) } else { v }
}

/// Chapter 11.4: the component that is largest by magnitude, the earlier one of two equals.
fn largest_component([x, y, z]: [f32; 3]) -> f32 {
    let (ax, ay, az) = (libm::fabsf(x), libm::fabsf(y), libm::fabsf(z));
    if ax >= ay && ax >= az {
        x
    } else if ay >= az {
        y
    } else {
        z
    }
}

fn negated([x, y, z]: [f32; 3]) -> [f32; 3] {
    [-x, -y, -z]
}

/// Chapter 11.5: (x, y, z, w) of the rotation whose columns are the axes.
pub(crate) fn quaternion(axes: &[[f32; 3]; 3]) -> [f32; 4] {
    let [[m00, m10, m20], [m01, m11, m21], [m02, m12, m22]] = *axes;
    let trace = m00 + m11 + m22;
    let [x, y, z, w] = if trace >= m00 && trace >= m11 && trace >= m22 {
        [m21 - m12, m02 - m20, m10 - m01, 1.0 + trace]
    } else if m00 >= m11 && m00 >= m22 {
        [1.0 + m00 - m11 - m22, m01 + m10, m02 + m20, m21 - m12]
    } else if m11 >= m22 {
        [m01 + m10, 1.0 + m11 - m00 - m22, m12 + m21, m02 - m20]
    } else {
        [m02 + m20, m12 + m21, 1.0 + m22 - m00 - m11, m10 - m01]
    };
    let norm = libm::sqrtf(x * x + y * y + z * z + w * w);
    if fault::is(Fault::Attitude) {
        let signed = if w < 0.0 { -norm } else { norm };
        return [x / signed, y / signed, z / signed, w / signed];
    }
    let factor = if w < 0.0 { -1.0 / norm } else { 1.0 / norm };
    [x * factor, y * factor, z * factor, w * factor]
}

/// Chapter 11.6: `[theta_x, theta_y, theta_z]`.
pub(crate) fn angles(axes: &[[f32; 3]; 3]) -> [f32; 3] {
    let [[m00, m10, m20], [m01, m11, m21], [_, _, m22]] = *axes;
    let cos_y = libm::sqrtf(m00 * m00 + m10 * m10);
    let theta_y = libm::atan2f(-m20, cos_y);
    if cos_y < 1e-6 {
        return [0.0, theta_y, libm::atan2f(-m01, m11)];
    }
    [libm::atan2f(m21, m22), theta_y, libm::atan2f(m10, m00)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Symmetric;
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

    fn near(found: &[f32], expected: &[f32]) -> bool {
        found.iter().zip(expected).all(|(f, e)| (f - e).abs() < 1e-6)
    }

    #[test]
    fn an_axis_aligned_ellipsoid_lies_as_its_axes_say() {
        let shape = Symmetric { xx: 1.0, yy: 0.0625, zz: 0.25, ..Symmetric::default() };
        let found = ellipsoid_of(&Central { centre: [5.0, 6.0, 7.0], shape });
        assert_eq!(found.centre, [5.0, 6.0, 7.0]);
        assert_eq!(found.semi_axes, [4.0, 2.0, 1.0]);
        assert_eq!(found.axes, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
        // x to y to z to x: a third of a turn about (1, 1, 1).
        assert_eq!(found.quaternion, [0.5, 0.5, 0.5, 0.5]);
        assert!(near(&found.angles, &[FRAC_PI_2, 0.0, FRAC_PI_2]));
    }

    #[test]
    fn a_turn_about_z_is_the_angle_theta_z() {
        // Long axis along (1, 1, 0): shape [[a, b], [b, a]] with a + b = 1/16 and a - b = 1/4.
        let shape = Symmetric { xx: 0.156_25, yy: 0.156_25, zz: 1.0, xy: -0.093_75, ..Symmetric::default() };
        let found = ellipsoid_of(&Central { centre: [0.0; 3], shape });
        assert!(near(&found.semi_axes, &[4.0, 2.0, 1.0]));
        let [a, b, c] = found.axes;
        let r = 0.5_f32.sqrt();
        assert!(near(&a, &[r, r, 0.0]));
        // |x| and |y| of the second axis differ by rounding at most, so its sign is either; the third follows it.
        assert!(near(&b, &[r, -r, 0.0]) || near(&b, &[-r, r, 0.0]));
        assert!(near(&c, &[0.0, 0.0, if b[1] > 0.0 { 1.0 } else { -1.0 }]));
        assert!(near(&found.angles[2..], &[FRAC_PI_4]));
    }

    #[test]
    fn every_branch_of_the_quaternion_is_a_half_turn_or_none() {
        let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(quaternion(&identity), [0.0, 0.0, 0.0, 1.0]);
        for k in 0..3 {
            let mut half_turn = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
            half_turn[k][k] = 1.0;
            let mut expected = [0.0; 4];
            expected[k] = 1.0;
            assert_eq!(quaternion(&half_turn), expected);
        }
    }

    #[test]
    fn looking_straight_down_the_twist_is_theta_z() {
        // First axis along -z: m20 = -1, cos_y = 0.
        let found = angles(&[[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]);
        assert_eq!(found, [0.0, FRAC_PI_2, 0.0]);
    }
}
