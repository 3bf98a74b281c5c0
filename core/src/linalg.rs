//! The 9x9 normal-equation solver: packed symmetric matrix, LDL^T, no pivoting, no square root.
//!
//! A normal matrix is symmetric and positive semi-definite, so LDL^T without pivoting is backward stable on it
//! (Higham, Accuracy and Stability of Numerical Algorithms, section 10.1); the square roots of Cholesky would only
//! add rounding. Storage is the lower triangle by rows: entry (i, j), j <= i, at i (i + 1) / 2 + j, 45 numbers.

/// Unknowns of every fit in this crate.
pub const N: usize = 9;
/// Numbers in the lower triangle of a 9x9 matrix.
pub const PACKED: usize = N * (N + 1) / 2;

/// A pivot must exceed this part of the diagonal entry it came from: below 2^-22 (four roundings of `f32`) nothing but
/// rounding error is left of the column and the system is singular to working precision.
pub const MIN_PIVOT_RATIO: f32 = 1.0 / 4_194_304.0;

/// Symmetric 9x9 matrix, lower triangle by rows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Symmetric9(pub [f32; PACKED]);

/// Index of entry (i, j), j <= i, in the packed triangle.
#[inline]
pub const fn packed(i: usize, j: usize) -> usize {
    i * (i + 1) / 2 + j
}

impl Symmetric9 {
    /// All zeros.
    pub const ZERO: Self = Self([0.0; PACKED]);

    /// Adds `weight * row row^T`: each entry gains `(weight * row[i]) * row[j]`. 90 flops and 9.
    #[inline]
    pub fn add_outer(&mut self, row: &[f32; N], weight: f32) {
        let mut entries = self.0.iter_mut();
        for (i, value) in row.iter().enumerate() {
            let scaled = weight * value;
            for (other, entry) in row.iter().take(i + 1).zip(entries.by_ref()) {
                *entry += scaled * other;
            }
        }
    }

    /// Entry (i, i). Out of range: 0.
    #[inline]
    pub fn diagonal(&self, i: usize) -> f32 {
        self.entry(i, i)
    }

    /// Adds to entry (i, i). Out of range: nothing.
    #[inline]
    pub fn add_diagonal(&mut self, i: usize, value: f32) {
        self.add_entry(i, i, value);
    }

    /// Entry (i, j) of the lower triangle, j <= i. Out of range: 0.
    #[inline]
    pub fn entry(&self, i: usize, j: usize) -> f32 {
        self.0.get(packed(i, j)).copied().unwrap_or(0.0)
    }

    /// Adds to entry (i, j) of the lower triangle, j <= i. Out of range: nothing.
    #[inline]
    pub fn add_entry(&mut self, i: usize, j: usize, value: f32) {
        if let Some(entry) = self.0.get_mut(packed(i, j)) {
            *entry += value;
        }
    }

    /// Factors the matrix, row by row. 285 flops and 36 divisions.
    ///
    /// `None` when a pivot is not above [`MIN_PIVOT_RATIO`] of its diagonal entry (singular to working precision)
    /// or not finite.
    pub fn factor(&self) -> Option<Factors9> {
        let mut l = self.0;
        let mut pivots = [0.0; N];
        for i in 0..N {
            // Slices of rows instead of computed indices: nothing here can be out of range, and the compiler sees it.
            let (above, rest) = l.split_at_mut_checked(packed(i, 0))?;
            let row = rest.get_mut(..=i)?;
            // First L(i, j) d_j for j < i, left to right; then L(i, j) and the pivot.
            for j in 0..i {
                let other = above.get(packed(j, 0)..)?;
                let (done, todo) = row.split_at_mut_checked(j)?;
                let entry = todo.first_mut()?;
                let mut sum = *entry;
                for (scaled, factor) in done.iter().zip(other) {
                    sum -= scaled * factor;
                }
                *entry = sum;
            }
            let (diagonal, entries) = row.split_last_mut()?;
            let mut pivot = *diagonal;
            for (entry, divisor) in entries.iter_mut().zip(&pivots) {
                let scaled = *entry;
                *entry = scaled / divisor;
                pivot -= scaled * *entry;
            }
            // NaN fails both comparisons.
            let usable = pivot > MIN_PIVOT_RATIO * *diagonal && pivot <= f32::MAX;
            if !usable {
                return None;
            }
            *diagonal = pivot;
            *pivots.get_mut(i)? = pivot;
        }
        Some(Factors9 { l, pivots })
    }
}

/// `L D L^T` of a [`Symmetric9`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factors9 {
    /// Unit lower triangle, packed by rows (the ones on its diagonal are not there: the pivots are).
    l: [f32; PACKED],
    /// `D`, all positive.
    pivots: [f32; N],
}

impl Factors9 {
    /// Row `i` of L left of the diagonal.
    #[inline(always)]
    fn row(&self, i: usize) -> &[f32] {
        self.l.get(packed(i, 0)..packed(i, i)).unwrap_or(&[])
    }

    /// Solves for one right-hand side: forward and back by rows of L, scaling between. 153 flops and 9 divisions.
    pub fn solve(&self, rhs: &[f32; N]) -> [f32; N] {
        let mut x = *rhs;
        for i in 0..N {
            let mut sum = x[i];
            for (factor, value) in self.row(i).iter().zip(&x) {
                sum -= factor * value;
            }
            x[i] = sum;
        }
        for (value, pivot) in x.iter_mut().zip(&self.pivots) {
            *value /= pivot;
        }
        // Once x_i is known it leaves all equations above: by rows, so that L is read as it lies in memory.
        for i in (0..N).rev() {
            let known = x[i];
            for (factor, value) in self.row(i).iter().zip(&mut x) {
                *value -= factor * known;
            }
        }
        x
    }

    /// The pivots `D` (shape 9, all positive).
    pub fn pivots(&self) -> &[f32; N] {
        &self.pivots
    }

    /// Inverse of the factored matrix, column by column. 9 solves.
    pub fn inverse(&self) -> Symmetric9 {
        let mut inverse = Symmetric9::ZERO;
        for j in 0..N {
            let mut unit = [0.0; N];
            unit[j] = 1.0;
            let column = self.solve(&unit);
            for (i, value) in column.iter().enumerate().skip(j) {
                if let Some(entry) = inverse.0.get_mut(packed(i, j)) {
                    *entry = *value;
                }
            }
        }
        inverse
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hilbert_like() -> Symmetric9 {
        let mut a = Symmetric9::ZERO;
        for i in 0..N {
            for j in 0..=i {
                a.0[packed(i, j)] = 1.0 / (1.0 + (i as f32 - j as f32).abs());
            }
        }
        a
    }

    #[test]
    fn solves_a_known_system() {
        let a = hilbert_like();
        let x = [1.0, -2.0, 3.0, -4.0, 5.0, -6.0, 7.0, -8.0, 9.0];
        let mut b = [0.0; N];
        for i in 0..N {
            for j in 0..N {
                b[i] += a.0[packed(i.max(j), i.min(j))] * x[j];
            }
        }
        let solved = a.factor().unwrap().solve(&b);
        for i in 0..N {
            assert!((solved[i] - x[i]).abs() < 2e-5, "{solved:?}");
        }
    }

    #[test]
    fn the_inverse_times_the_matrix_is_one() {
        let a = hilbert_like();
        let inverse = a.factor().unwrap().inverse();
        for i in 0..N {
            for j in 0..N {
                let mut sum = 0.0;
                for k in 0..N {
                    sum += a.0[packed(i.max(k), i.min(k))] * inverse.0[packed(k.max(j), k.min(j))];
                }
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((sum - expected).abs() < 1e-5);
            }
        }
    }

    #[test]
    fn a_rank_deficient_matrix_has_no_factors() {
        let mut a = Symmetric9::ZERO;
        for k in 0..8 {
            let mut row = [1.0; N];
            row[k] = 2.0;
            a.add_outer(&row, 1.0);
        }
        assert!(a.factor().is_none());
        assert!(Symmetric9::ZERO.factor().is_none());
        assert!(Symmetric9([f32::NAN; PACKED]).factor().is_none());
    }
}
