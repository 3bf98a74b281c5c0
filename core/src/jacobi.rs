//! Cyclic Jacobi eigen-decomposition of a symmetric 3x3 matrix.
//!
//! Chosen over the closed form (cubic and arc cosine) because its error is relative to each eigenvalue of a positive
//! definite matrix (Demmel and Veselic 1992), which matters when one semi-axis is ten times another, and because it
//! needs one square root a rotation and nothing else.

/// Symmetric 3x3 matrix as the six numbers it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Symmetric3 {
    /// Entry (1, 1).
    pub xx: f32,
    /// Entry (2, 2).
    pub yy: f32,
    /// Entry (3, 3).
    pub zz: f32,
    /// Entries (1, 2) and (2, 1).
    pub xy: f32,
    /// Entries (1, 3) and (3, 1).
    pub xz: f32,
    /// Entries (2, 3) and (3, 2).
    pub yz: f32,
}

impl Symmetric3 {
    /// Determinant, expanded along the first row.
    #[inline]
    pub fn determinant(&self) -> f32 {
        self.xx * (self.yy * self.zz - self.yz * self.yz) - self.xy * (self.xy * self.zz - self.yz * self.xz)
            + self.xz * (self.xy * self.yz - self.yy * self.xz)
    }

    /// Matrix of cofactors (the adjugate: it is symmetric). `A adj(A) = det(A) I`.
    #[inline]
    pub fn adjugate(&self) -> Self {
        Self {
            xx: self.yy * self.zz - self.yz * self.yz,
            yy: self.xx * self.zz - self.xz * self.xz,
            zz: self.xx * self.yy - self.xy * self.xy,
            xy: self.xz * self.yz - self.xy * self.zz,
            xz: self.xy * self.yz - self.xz * self.yy,
            yz: self.xy * self.xz - self.xx * self.yz,
        }
    }

    /// Product with a vector, each component summed x, y, z.
    #[inline]
    pub fn times(&self, v: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = v;
        [
            self.xx * x + self.xy * y + self.xz * z,
            self.xy * x + self.yy * y + self.yz * z,
            self.xz * x + self.yz * y + self.zz * z,
        ]
    }

    /// Positive definite by Sylvester's criterion: the three leading minors are positive. 14 flops.
    #[inline]
    pub fn is_positive_definite(&self) -> bool {
        self.xx > 0.0 && self.xx * self.yy - self.xy * self.xy > 0.0 && self.determinant() > 0.0
    }
}

/// Eigenvalues and unit eigenvectors: `vectors[k]` belongs to `values[k]`, ascending.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Eigen3 {
    /// Ascending.
    pub values: [f32; 3],
    /// Rows are the eigenvectors, in the order of `values`; signs as the rotations left them.
    pub vectors: [[f32; 3]; 3],
}

/// Sweeps at most. Convergence is quadratic; `tests/accuracy.rs` measures how many are needed.
pub const MAX_SWEEPS: u32 = 8;

/// Decomposes `a`. At most [`MAX_SWEEPS`] sweeps of the rotations (1,2), (1,3), (2,3), each of them skipped (and its
/// entry set to zero) when the entry vanishes beside both of its diagonal entries; a sweep that only skips is the last.
///
/// Cost: about 45 flops, two square roots and three divisions a rotation. The result of a non-finite matrix has no
/// meaning, but it is returned all the same.
pub fn eigen(a: &Symmetric3) -> Eigen3 {
    let mut m = *a;
    // Rows are the vectors, so that a rotation touches two whole rows.
    let [mut u, mut v, mut w] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..MAX_SWEEPS {
        let first = rotate(&mut m.xx, &mut m.yy, &mut m.xy, [&mut m.xz, &mut m.yz], [&mut u, &mut v]);
        let second = rotate(&mut m.xx, &mut m.zz, &mut m.xz, [&mut m.xy, &mut m.yz], [&mut u, &mut w]);
        let third = rotate(&mut m.yy, &mut m.zz, &mut m.yz, [&mut m.xy, &mut m.xz], [&mut v, &mut w]);
        if !(first || second || third) {
            break;
        }
    }
    sorted((m.xx, u), (m.yy, v), (m.zz, w))
}

/// One rotation in the plane (p, q): its three entries, the two entries that couple p and q to the third index, and
/// the two vectors. Rutishauser's formulas (Golub and Van Loan, section 8.5).
#[inline]
fn rotate(
    app: &mut f32,
    aqq: &mut f32,
    apq: &mut f32,
    [arp, arq]: [&mut f32; 2],
    [vp, vq]: [&mut [f32; 3]; 2],
) -> bool {
    let size = libm::fabsf(*apq);
    let (dp, dq) = (libm::fabsf(*app), libm::fabsf(*aqq));
    if dp + size == dp && dq + size == dq {
        *apq = 0.0;
        return false;
    }
    // tan of the rotation: the smaller root of t^2 + 2 theta t - 1 = 0. An infinite theta gives t = 0.
    let theta = (*aqq - *app) / (2.0 * *apq);
    let root = libm::fabsf(theta) + libm::sqrtf(theta * theta + 1.0);
    let t = if theta < 0.0 { -1.0 / root } else { 1.0 / root };
    let cos = 1.0 / libm::sqrtf(t * t + 1.0);
    let sin = t * cos;
    let tau = sin / (1.0 + cos);
    let shift = t * *apq;
    *app -= shift;
    *aqq += shift;
    *apq = 0.0;
    let turn = |p: &mut f32, q: &mut f32| {
        let (old_p, old_q) = (*p, *q);
        *p = old_p - sin * (old_q + tau * old_p);
        *q = old_q + sin * (old_p - tau * old_q);
    };
    turn(arp, arq);
    for (p, q) in vp.iter_mut().zip(vq) {
        turn(p, q);
    }
    true
}

/// An eigenvalue and its vector.
type Pair = (f32, [f32; 3]);

/// Ascending by value; equal values keep their order (three compare-and-swaps: 01, 12, 01).
fn sorted(mut first: Pair, mut second: Pair, mut third: Pair) -> Eigen3 {
    let in_order = |low: &mut Pair, high: &mut Pair| {
        if high.0 < low.0 {
            core::mem::swap(low, high);
        }
    };
    in_order(&mut first, &mut second);
    in_order(&mut second, &mut third);
    in_order(&mut first, &mut second);
    Eigen3 { values: [first.0, second.0, third.0], vectors: [first.1, second.1, third.1] }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rebuilt(e: &Eigen3, i: usize, j: usize) -> f32 {
        (0..3).map(|k| e.values[k] * e.vectors[k][i] * e.vectors[k][j]).sum()
    }

    #[test]
    fn known_values_and_axes() {
        // Eigenvalues 1, 2, 4 with axes (1,1,0)/sqrt2, (0,0,1), (1,-1,0)/sqrt2.
        let a = Symmetric3 { xx: 2.5, yy: 2.5, zz: 2.0, xy: -1.5, xz: 0.0, yz: 0.0 };
        let e = eigen(&a);
        for (value, expected) in e.values.iter().zip([1.0, 2.0, 4.0]) {
            assert!((value - expected).abs() < 1e-6, "{e:?}");
        }
        assert!((libm::fabsf(e.vectors[1][2]) - 1.0).abs() < 1e-6);
        assert!((e.vectors[0][0] - e.vectors[0][1]).abs() < 1e-6);
    }

    #[test]
    fn a_full_matrix_is_rebuilt() {
        let a = Symmetric3 { xx: 3.0, yy: 1.0, zz: 2.0, xy: 0.7, xz: -0.4, yz: 0.9 };
        let e = eigen(&a);
        let full = [[a.xx, a.xy, a.xz], [a.xy, a.yy, a.yz], [a.xz, a.yz, a.zz]];
        for i in 0..3 {
            for j in 0..3 {
                assert!((rebuilt(&e, i, j) - full[i][j]).abs() < 2e-6);
            }
        }
    }

    #[test]
    fn multiples_of_the_identity_and_zero_need_no_rotation() {
        for d in [0.0, 1.0, 1e-30] {
            let e = eigen(&Symmetric3 { xx: d, yy: d, zz: d, ..Default::default() });
            assert_eq!(e.values, [d; 3]);
            assert_eq!(e.vectors, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        }
    }

    #[test]
    fn small_eigenvalues_keep_their_digits() {
        // diag(1e-6, 1, 1e3) scaled into a dense matrix by the graded congruence D B D.
        let d = [1e-3_f32, 1.0, 30.0];
        let b = [[1.0, 0.3, -0.2], [0.3, 1.0, 0.4], [-0.2, 0.4, 1.0_f32]];
        let m = |i: usize, j: usize| d[i] * b[i][j] * d[j];
        let a = Symmetric3 { xx: m(0, 0), yy: m(1, 1), zz: m(2, 2), xy: m(0, 1), xz: m(0, 2), yz: m(1, 2) };
        let e = eigen(&a);
        let product = f64::from(e.values[0]) * f64::from(e.values[1]) * f64::from(e.values[2]);
        // det = d1^2 d2^2 d3^2 det(B), det(B) = 1 + 2(.3*-.2*.4) - .09 - .04 - .16 = 0.662.
        let expected = 1e-6 * 900.0 * 0.662;
        assert!((product / expected - 1.0).abs() < 2e-6, "{e:?}");
    }
}
