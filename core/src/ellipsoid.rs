//! The ellipsoid as people and robots use it: centre, semi-axes, axes, attitude.
//!
//! Conventions: semi-axes `a >= b >= c`; `axes[k]` is the unit vector of the k-th semi-axis; the three are
//! right-handed; each of the first two has its largest component positive (the lowest index where components are
//! equally large), and the third follows from the right hand. The attitude is the rotation whose columns are the
//! axes: it turns the body frame (long axis along x) into the cloud's frame.
//!
//! Where two semi-axes are equal, the directions within their plane have no meaning (a spheroid's twist), and the
//! angles derived from them neither: look at the long axis, or at the covariance.

use crate::{CentralQuadric, Point3, jacobi};
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion};

/// Centre, sorted semi-axes and right-handed axes. Unit and frame of the cloud (millimetres, camera).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Ellipsoid {
    /// Centre.
    #[cfg_attr(feature = "defmt", defmt(Debug2Format))]
    pub centre: Point3,
    /// `a >= b >= c`, Eq. (13).
    pub semi_axes: [f32; 3],
    /// Row k is the unit vector of the k-th semi-axis.
    pub axes: [[f32; 3]; 3],
}

impl From<&CentralQuadric> for Ellipsoid {
    /// Eq. (11)-(13): eigenvectors of the shape matrix are the axes, `1 / sqrt(eigenvalue)` the semi-axes.
    fn from(central: &CentralQuadric) -> Self {
        let eigen = jacobi::eigen(&central.shape);
        let semi_axes = eigen.values.map(|value| 1.0 / libm::sqrtf(value));
        Self { centre: central.centre, semi_axes, axes: right_handed(eigen.vectors) }
    }
}

/// Applies the sign rule of this module to three orthogonal unit vectors.
pub(crate) fn right_handed(axes: [[f32; 3]; 3]) -> [[f32; 3]; 3] {
    let [a, b, c] = axes;
    let a = with_positive_largest(a);
    let b = with_positive_largest(b);
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let along = cross[0] * c[0] + cross[1] * c[1] + cross[2] * c[2];
    let c = if along < 0.0 { c.map(|v| -v) } else { c };
    [a, b, c]
}

fn with_positive_largest(v: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = v.map(libm::fabsf);
    let largest = if x >= y && x >= z {
        v[0]
    } else if y >= z {
        v[1]
    } else {
        v[2]
    };
    if largest < 0.0 { v.map(|value| -value) } else { v }
}

impl Ellipsoid {
    /// Unit vector of the long axis; its sign follows the module's rule and has no physical meaning.
    pub fn long_axis(&self) -> [f32; 3] {
        self.axes[0]
    }

    /// Rotation whose columns are the axes, body frame to cloud frame.
    pub fn rotation(&self) -> Rotation3<f32> {
        let [a, b, c] = self.axes;
        Rotation3::from_matrix_unchecked(Matrix3::new(a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2]))
    }

    /// The attitude as a unit quaternion with `w >= 0`, from our own [`Self::quaternion_xyzw`].
    pub fn quaternion(&self) -> UnitQuaternion<f32> {
        let [x, y, z, w] = self.quaternion_xyzw();
        UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
    }

    /// The attitude as `x, y, z, w` with `w >= 0` (Shepperd 1978: divide by the largest of the four, so never by a
    /// small number). Ties go to w, then x, then y.
    pub fn quaternion_xyzw(&self) -> [f32; 4] {
        // m[i][j]: row i, column j of the rotation.
        let [a, b, c] = self.axes;
        let (m00, m11, m22) = (a[0], b[1], c[2]);
        let (m10, m20, m01, m21, m02, m12) = (a[1], a[2], b[0], b[2], c[0], c[1]);
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
        let scale = if w < 0.0 { -1.0 / norm } else { 1.0 / norm };
        [x * scale, y * scale, z * scale, w * scale]
    }

    /// Attitude angles `theta_x, theta_y, theta_z` in radians, the intrinsic Z-Y-X sequence:
    /// `R = Rz(theta_z) Ry(theta_y) Rx(theta_x)`, `theta_y` in [-pi/2, pi/2], the others in (-pi, pi].
    ///
    /// The paper fixes no convention; this is ours. Where the long axis is along z of the cloud
    /// (`cos theta_y < 1e-6`) only a combination of the other two is defined: `theta_x = 0` there.
    pub fn attitude_rad(&self) -> [f32; 3] {
        let [a, b, c] = self.axes;
        let (m00, m10, m20) = (a[0], a[1], a[2]);
        let cos_y = libm::sqrtf(m00 * m00 + m10 * m10);
        let theta_y = libm::atan2f(-m20, cos_y);
        if cos_y < 1e-6 {
            return [0.0, theta_y, libm::atan2f(-b[0], b[1])];
        }
        [libm::atan2f(b[2], c[2]), theta_y, libm::atan2f(m10, m00)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jacobi::Symmetric3;

    /// Spheroid-free test body: rotation by known angles of diag(1/9, 1/4, 1).
    fn body(theta_x: f32, theta_y: f32, theta_z: f32) -> CentralQuadric {
        let r = Rotation3::from_euler_angles(theta_x, theta_y, theta_z);
        let d = Matrix3::from_diagonal(&nalgebra::Vector3::new(1.0 / 9.0, 0.25, 1.0));
        let s = r.matrix() * d * r.matrix().transpose();
        CentralQuadric {
            centre: Point3::new(1.0, 2.0, 3.0),
            shape: Symmetric3 { xx: s.m11, yy: s.m22, zz: s.m33, xy: s.m12, xz: s.m13, yz: s.m23 },
        }
    }

    #[test]
    fn semi_axes_and_angles_come_back() {
        let e = Ellipsoid::from(&body(0.3, -0.4, 0.5));
        for (value, expected) in e.semi_axes.iter().zip([3.0, 2.0, 1.0]) {
            assert!((value - expected).abs() < 1e-5, "{e:?}");
        }
        for (value, expected) in e.attitude_rad().iter().zip([0.3, -0.4, 0.5]) {
            assert!((value - expected).abs() < 1e-5, "{:?}", e.attitude_rad());
        }
    }

    #[test]
    fn axes_are_right_handed_and_the_quaternion_is_the_rotation() {
        for k in 0..200 {
            let t = k as f32;
            let e = Ellipsoid::from(&body(0.7 * t, 0.31 * t, 1.3 * t));
            assert!((e.rotation().matrix().determinant() - 1.0).abs() < 1e-5);
            let q = e.quaternion().to_rotation_matrix();
            assert!((q.matrix() - e.rotation().matrix()).abs().max() < 2e-6, "case {k}");
            let [x, y, z] = e.attitude_rad();
            let again = Rotation3::from_euler_angles(x, y, z);
            assert!((again.matrix() - e.rotation().matrix()).abs().max() < 1e-5, "case {k}");
        }
    }

    #[test]
    fn a_long_axis_along_z_is_no_special_case_for_the_reader() {
        let s = Symmetric3 { xx: 1.0, yy: 0.25, zz: 1.0 / 9.0, ..Default::default() };
        let e = Ellipsoid::from(&CentralQuadric { centre: Point3::origin(), shape: s });
        assert_eq!(e.long_axis(), [0.0, 0.0, 1.0]);
        let [x, y, z] = e.attitude_rad();
        let again = Rotation3::from_euler_angles(x, y, z);
        assert!((again.matrix() - e.rotation().matrix()).abs().max() < 1e-6);
    }
}
