//! Multi-precision judges: 320-bit binary floats, 96 decimal digits, so that what they say is the truth for any matrix
//! an `f32` program can hold.

use dashu_float::{FBig, ops::SquareRoot, round::mode::HalfEven};
use varsac_core::{
    jacobi::Symmetric3,
    linalg::{N, Symmetric9, packed},
};

/// A 320-bit float.
pub type Big = FBig<HalfEven, 2>;

const BITS: usize = 320;

/// An `f64` as a multi-precision number, exactly.
///
/// # Panics
/// When the value is not finite: the judges are not asked about such.
pub fn big(value: f64) -> Big {
    Big::try_from(value).expect("a finite number").with_precision(BITS).value()
}

/// The nearest `f64`.
pub fn to_f64(value: &Big) -> f64 {
    value.to_f64().value()
}

fn magnitude(value: &Big) -> Big {
    if *value < Big::ZERO { -value.clone() } else { value.clone() }
}

/// What multi-precision says about one 9x9 system and an `f32` answer to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SolveReport {
    /// `|b - A x|_inf / (|A|_inf |x|_inf + |b|_inf)` in units of 2^-24: how far away the system lies that the answer
    /// solves exactly.
    pub backward_ulps: f64,
    /// `|x - x*|_inf / |x*|_inf`.
    pub forward: f64,
    /// Condition number `|A|_inf |A^-1|_inf`.
    pub condition: f64,
}

/// Judges `x` as a solution of `a x = b`. `None` when the matrix is not positive definite.
pub fn judge_solution(a: &Symmetric9, b: &[f32; N], x: &[f32; N]) -> Option<SolveReport> {
    let entry = |i: usize, j: usize| big(f64::from(a.0[packed(i.max(j), i.min(j))]));
    let matrix: Vec<Vec<Big>> = (0..N).map(|i| (0..N).map(|j| entry(i, j)).collect()).collect();
    let rhs: Vec<Big> = b.iter().map(|&v| big(f64::from(v))).collect();
    let answer: Vec<Big> = x.iter().map(|&v| big(f64::from(v))).collect();

    // One elimination for the right-hand side and for the nine unit vectors of the inverse.
    let mut columns = vec![rhs.clone()];
    columns.extend((0..N).map(|j| (0..N).map(|i| big(f64::from(u8::from(i == j)))).collect()));
    let solved = eliminate(matrix.clone(), columns)?;
    let truth = &solved[0];

    let largest = |v: &[Big]| v.iter().map(|e| to_f64(&magnitude(e))).fold(0.0, f64::max);
    let row_sum = |row: &dyn Fn(usize, usize) -> f64| {
        (0..N).map(|i| (0..N).map(|j| row(i, j)).sum::<f64>()).fold(0.0, f64::max)
    };
    let norm = row_sum(&|i, j| to_f64(&magnitude(&matrix[i][j])));
    let inverse_norm = row_sum(&|i, j| to_f64(&magnitude(&solved[1 + j][i])));
    let residual: Vec<Big> = (0..N)
        .map(|i| matrix[i].iter().zip(&answer).fold(rhs[i].clone(), |sum, (entry, x)| sum - entry * x))
        .collect();
    let error: Vec<Big> = answer.iter().zip(truth).map(|(x, t)| x - t).collect();
    let backward = largest(&residual) / (norm * largest(&answer) + largest(&rhs));
    Some(SolveReport {
        backward_ulps: backward * f64::from(1_u32 << 24),
        forward: largest(&error) / largest(truth),
        condition: norm * inverse_norm,
    })
}

/// Gauss's elimination without pivoting, which a positive definite matrix does not need; `None` on a pivot that is
/// not positive.
fn eliminate(mut a: Vec<Vec<Big>>, mut columns: Vec<Vec<Big>>) -> Option<Vec<Vec<Big>>> {
    let n = a.len();
    for k in 0..n {
        if a[k][k] <= Big::ZERO {
            return None;
        }
        for i in k + 1..n {
            let factor = &a[i][k] / &a[k][k];
            for j in k..n {
                let change = &factor * &a[k][j];
                a[i][j] -= change;
            }
            for column in &mut columns {
                let change = &factor * &column[k];
                column[i] -= change;
            }
        }
    }
    for column in &mut columns {
        for i in (0..n).rev() {
            let known = (i + 1..n).fold(column[i].clone(), |sum, j| sum - &a[i][j] * &column[j]);
            column[i] = known / &a[i][i];
        }
    }
    Some(columns)
}

/// Eigenvalues, ascending, and unit eigenvectors of a symmetric matrix given in `f32`, right to `f64`: Jacobi's
/// rotations in 320 bits until nothing is left beside the diagonal.
pub fn eigen(a: &Symmetric3) -> ([f64; 3], [[f64; 3]; 3]) {
    let lift = |v: f32| big(f64::from(v));
    let mut m = [
        [lift(a.xx), lift(a.xy), lift(a.xz)],
        [lift(a.xy), lift(a.yy), lift(a.yz)],
        [lift(a.xz), lift(a.yz), lift(a.zz)],
    ];
    let mut v = core::array::from_fn(|i| core::array::from_fn(|j| big(f64::from(u8::from(i == j)))));
    for _ in 0..40 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut m, &mut v, p, q);
        }
    }
    let mut pairs: Vec<(Big, [f64; 3])> =
        (0..3).map(|k| (m[k][k].clone(), core::array::from_fn(|i| to_f64(&v[i][k])))).collect();
    pairs.sort_by(|x, y| x.0.cmp(&y.0));
    (core::array::from_fn(|k| to_f64(&pairs[k].0)), core::array::from_fn(|k| pairs[k].1))
}

/// One rotation as two full products of matrices: slow, plain, and in nothing like the code it judges.
fn rotate(m: &mut [[Big; 3]; 3], v: &mut [[Big; 3]; 3], p: usize, q: usize) {
    if m[p][q] == Big::ZERO || to_f64(&magnitude(&m[p][q])) < 1e-80 * to_f64(&magnitude(&m[p][p])) {
        return;
    }
    // The angle with tan(2 phi) = 2 m_pq / (m_qq - m_pp), by half-angle formulas.
    let difference = &m[q][q] - &m[p][p];
    let twice = &m[p][q] + &m[p][q];
    let length = (&difference * &difference + &twice * &twice).sqrt();
    let tan =
        if difference >= Big::ZERO { &twice / (difference + length) } else { &twice / (difference - length) };
    let one = big(1.0);
    let cos = &one / (&one + &tan * &tan).sqrt();
    let sin = &tan * &cos;
    let turn = |i: usize, j: usize| match (i, j) {
        _ if i == j && (i == p || i == q) => cos.clone(),
        _ if (i, j) == (p, q) => sin.clone(),
        _ if (i, j) == (q, p) => -sin.clone(),
        _ => big(f64::from(u8::from(i == j))),
    };
    let r = core::array::from_fn(|i| core::array::from_fn(|j| turn(i, j)));
    let transposed = core::array::from_fn(|i| core::array::from_fn(|j| turn(j, i)));
    *m = product(&product(&transposed, m), &r);
    *v = product(v, &r);
}

fn product(a: &[[Big; 3]; 3], b: &[[Big; 3]; 3]) -> [[Big; 3]; 3] {
    core::array::from_fn(|i| {
        core::array::from_fn(|j| &a[i][0] * &b[0][j] + &a[i][1] * &b[1][j] + &a[i][2] * &b[2][j])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_solution_is_seen() {
        let mut a = Symmetric9::ZERO;
        for i in 0..N {
            a.add_diagonal(i, (i + 1) as f32);
        }
        let b: [f32; N] = core::array::from_fn(|i| (i + 1) as f32);
        let right = judge_solution(&a, &b, &[1.0; N]).unwrap();
        assert_eq!((right.backward_ulps, right.forward, right.condition), (0.0, 0.0, 9.0));
        let mut x = [1.0; N];
        x[8] = 1.0 + f32::EPSILON;
        let wrong = judge_solution(&a, &b, &x).unwrap();
        assert_eq!(wrong.forward, f64::from(f32::EPSILON));
        assert!((wrong.backward_ulps - 1.0).abs() < 1e-6, "{wrong:?}");
    }

    #[test]
    fn eigenvalues_of_a_known_matrix() {
        // Characteristic polynomial (2 - x)(x^2 - 5 x + 4).
        let a = Symmetric3 { xx: 2.5, yy: 2.5, zz: 2.0, xy: -1.5, xz: 0.0, yz: 0.0 };
        let (values, vectors) = eigen(&a);
        assert_eq!(values, [1.0, 2.0, 4.0]);
        assert!((vectors[0][0] - core::f64::consts::FRAC_1_SQRT_2).abs() < 1e-15);
    }
}
