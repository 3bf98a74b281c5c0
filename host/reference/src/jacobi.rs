//! Eigen-decomposition by cyclic Jacobi rotations: contract, chapter 11, steps 1 and 2; Eq. (11) and (12).

use crate::Symmetric;
use crate::fault::{self, Fault};

/// Three eigenvalues and their unit vectors; row `k` of `vectors` belongs to `values[k]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eigen {
    /// Eigenvalues.
    pub values: [f32; 3],
    /// Eigenvectors, one a row.
    pub vectors: [[f32; 3]; 3],
}

/// Chapter 11.1: at most 8 sweeps over the pairs (0, 1), (0, 2), (1, 2), in the order the diagonal ends up with.
pub fn eigen(shape: &Symmetric) -> Eigen {
    let s = shape;
    let mut m = [[s.xx, s.xy, s.xz], [s.xy, s.yy, s.yz], [s.xz, s.yz, s.zz]];
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut pairs = [(0, 1, 2), (0, 2, 1), (1, 2, 0)];
    if fault::is(Fault::Eigenpairs) {
        pairs.swap(0, 1);
    }
    for _sweep in 0..8 {
        let mut rotated = false;
        for (p, q, r) in pairs {
            let size = libm::fabsf(m[p][q]);
            let app = libm::fabsf(m[p][p]);
            let aqq = libm::fabsf(m[q][q]);
            if app + size == app && aqq + size == aqq {
                m[p][q] = 0.0;
                m[q][p] = 0.0;
            } else {
                rotate(&mut m, &mut v, p, q, r);
                rotated = true;
            }
        }
        if !rotated {
            break;
        }
    }
    Eigen { values: [m[0][0], m[1][1], m[2][2]], vectors: v }
}

/// Chapter 11.1: the rotation that makes `m[p][q]` zero (Rutishauser's form, with `tau = tan(angle / 2)`).
fn rotate(m: &mut [[f32; 3]; 3], v: &mut [[f32; 3]; 3], p: usize, q: usize, r: usize) {
    let app = m[p][p];
    let aqq = m[q][q];
    let apq = m[p][q];
    let theta = (aqq - app) / (2.0 * apq);
    let root = libm::fabsf(theta) + libm::sqrtf(theta * theta + 1.0);
    let t = if theta < 0.0 { -1.0 / root } else { 1.0 / root };
    let cos = 1.0 / libm::sqrtf(t * t + 1.0);
    let sin = t * cos;
    let tau = sin / (1.0 + cos);
    m[p][p] = app - t * apq;
    m[q][q] = aqq + t * apq;
    m[p][q] = 0.0;
    m[q][p] = 0.0;
    let arp = m[r][p];
    let arq = m[r][q];
    m[r][p] = arp - sin * (arq + tau * arp);
    m[p][r] = m[r][p];
    m[r][q] = arq + sin * (arp - tau * arq);
    m[q][r] = m[r][q];
    for k in 0..3 {
        let vp = v[p][k];
        let vq = v[q][k];
        v[p][k] = vp - sin * (vq + tau * vp);
        v[q][k] = vq + sin * (vp - tau * vq);
    }
}

/// Chapter 11.2: ascending eigenvalues, by three compare-and-swaps.
pub fn ascending(eigen: &Eigen) -> Eigen {
    let mut sorted = *eigen;
    for (first, second) in [(0, 1), (1, 2), (0, 1)] {
        if sorted.values[second] < sorted.values[first] {
            sorted.values.swap(first, second);
            sorted.vectors.swap(first, second);
        }
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_diagonal_matrix_is_left_alone_and_then_sorted() {
        let found = eigen(&Symmetric { xx: 3.0, yy: 1.0, zz: 2.0, ..Symmetric::default() });
        assert_eq!(found.values, [3.0, 1.0, 2.0]);
        assert_eq!(found.vectors, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let sorted = ascending(&found);
        assert_eq!(sorted.values, [1.0, 2.0, 3.0]);
        assert_eq!(sorted.vectors, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
    }

    #[test]
    fn one_rotation_by_45_degrees_solves_equal_diagonals() {
        // [[2, 1], [1, 2]] has the eigenvalues 1 and 3: theta = 0, t = 1.
        let found = eigen(&Symmetric { xx: 2.0, yy: 2.0, zz: 5.0, xy: 1.0, ..Symmetric::default() });
        assert_eq!(found.values, [1.0, 3.0, 5.0]);
        for k in 0..2 {
            let [x, y, z] = found.vectors[k];
            assert!((x.abs() - 0.5_f32.sqrt()).abs() < 1e-6 && (y.abs() - 0.5_f32.sqrt()).abs() < 1e-6);
            assert_eq!(z, 0.0);
        }
    }

    #[test]
    fn a_full_matrix_is_diagonalised() {
        let s = Symmetric { xx: 4.0, yy: 3.0, zz: 2.0, xy: 1.0, xz: -0.5, yz: 0.25 };
        let rows = [[s.xx, s.xy, s.xz], [s.xy, s.yy, s.yz], [s.xz, s.yz, s.zz]];
        let found = eigen(&s);
        for k in 0..3 {
            let v = found.vectors[k];
            for i in 0..3 {
                let product = rows[i][0] * v[0] + rows[i][1] * v[1] + rows[i][2] * v[2];
                assert!((product - found.values[k] * v[i]).abs() < 2e-6);
            }
        }
    }
}
