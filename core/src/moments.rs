//! Normal equations from weighted moments of points on the unit sphere.
//!
//! In the letters of [`crate::residual`] each derivative of `F` is a monomial of `u` times a constant of the model:
//! `J_k = s_k phi_k(u)`, `phi = (x, y, z, yz, zx, xy, xx, yy, zz)` with `u = (x, y, z)`, `s = (-1/a, -1/b, -1/c, t1, t2, t3, -1, -1,
//! -1)`. So `H = sum w J J^T` needs sums of monomials of degree 2 to 4 only, and because `xx + yy + zz = 1` on the sphere 25
//! of them suffice for the 45 entries; the others follow, `xxx = x - xyy - xzz` for instance. A point costs about 75 flops
//! instead of 145, and the sums stay in registers for longer.
//!
//! All sums are plain sums in the order in which points are added.

use crate::linalg::{N, Symmetric9, packed};

/// The sums.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moments {
    /// `w x, w y, w z`.
    first: [f32; 3],
    /// `w xx, w yy, w zz, w yz, w zx, w xy`.
    second: [f32; 6],
    /// `w xxy, w xxz, w yyx, w yyz, w zzx, w zzy, w xyz`.
    third: [f32; 7],
    /// `w xxxy, w xxxz, w yyyx, w yyyz, w zzzx, w zzzy, w xxyy, w yyzz, w zzxx`.
    fourth: [f32; 9],
    /// `w F phi`.
    gradient: [f32; N],
}

impl Moments {
    /// No points.
    pub(crate) const ZERO: Self =
        Self { first: [0.0; 3], second: [0.0; 6], third: [0.0; 7], fourth: [0.0; 9], gradient: [0.0; N] };

    /// Adds the residual `value` at `u` with weight `w` (already divided by the variance).
    #[inline(always)]
    pub(crate) fn add(&mut self, u: [f32; 3], value: f32, w: f32) {
        let [x, y, z] = u;
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let (yz, zx, xy) = (y * z, z * x, x * y);
        let (wxx, wyy, wzz) = (w * xx, w * yy, w * zz);
        let (wyz, wzx, wxy) = (w * yz, w * zx, w * xy);
        let [a, b, c] = &mut self.first;
        *a += w * x;
        *b += w * y;
        *c += w * z;
        let [a, b, c, d, e, f] = &mut self.second;
        *a += wxx;
        *b += wyy;
        *c += wzz;
        *d += wyz;
        *e += wzx;
        *f += wxy;
        let [a, b, c, d, e, f, g] = &mut self.third;
        *a += wxx * y;
        *b += wxx * z;
        *c += wyy * x;
        *d += wyy * z;
        *e += wzz * x;
        *f += wzz * y;
        *g += wxy * z;
        let [a, b, c, d, e, f, g, h, i] = &mut self.fourth;
        *a += wxx * xy;
        *b += wxx * zx;
        *c += wyy * xy;
        *d += wyy * yz;
        *e += wzz * zx;
        *f += wzz * yz;
        *g += wxx * yy;
        *h += wyy * zz;
        *i += wzz * xx;
        let s = w * value;
        for (sum, phi) in self.gradient.iter_mut().zip([x, y, z, yz, zx, xy, xx, yy, zz]) {
            *sum += s * phi;
        }
    }

    /// `H` and `g` with the constants `s` of the model.
    pub(crate) fn normal(&self, s: &[f32; N]) -> (Symmetric9, [f32; N]) {
        let [x, y, z] = self.first;
        let [xx, yy, zz, yz, zx, xy] = self.second;
        let [xxy, xxz, yyx, yyz, zzx, zzy, xyz] = self.third;
        let [xxxy, xxxz, yyyx, yyyz, zzzx, zzzy, xxyy, yyzz, zzxx] = self.fourth;
        // What the sphere gives for nothing.
        let (xxx, yyy, zzz) = ((x - yyx) - zzx, (y - xxy) - zzy, (z - xxz) - yyz);
        let (xxyz, yyzx, zzxy) = ((yz - yyyz) - zzzy, (zx - xxxz) - zzzx, (xy - xxxy) - yyyx);
        let (xxxx, yyyy, zzzz) = ((xx - xxyy) - zzxx, (yy - xxyy) - yyzz, (zz - zzxx) - yyzz);
        #[rustfmt::skip]
        let monomials = [
            xx,
            xy,  yy,
            zx,  yz,  zz,
            xyz, yyz, zzy, yyzz,
            xxz, xyz, zzx, zzxy, zzxx,
            xxy, yyx, xyz, yyzx, xxyz, xxyy,
            xxx, xxy, xxz, xxyz, xxxz, xxxy, xxxx,
            yyx, yyy, yyz, yyyz, yyzx, yyyx, xxyy, yyyy,
            zzx, zzy, zzz, zzzy, zzzx, zzxy, zzxx, yyzz, zzzz,
        ];
        let mut matrix = Symmetric9::ZERO;
        let mut gradient = [0.0; N];
        for i in 0..N {
            for j in 0..=i {
                matrix.0[packed(i, j)] = (s[i] * s[j]) * monomials[packed(i, j)];
            }
            gradient[i] = s[i] * self.gradient[i];
        }
        (matrix, gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::refine::Normal;

    #[test]
    fn moments_give_the_outer_products() {
        let s = [-0.05, -0.09, -0.1, 0.1, -1.6, 1.5, -1.0, -1.0, -1.0];
        let mut moments = Moments::ZERO;
        let mut plain = Normal::ZERO;
        for k in 0..50 {
            let (t, w) = (k as f32, 1.0 + 0.1 * k as f32);
            let (theta, phi) = (0.03 * t, 2.4 * t);
            let u =
                [libm::cosf(theta), libm::sinf(theta) * libm::cosf(phi), libm::sinf(theta) * libm::sinf(phi)];
            let [x, y, z] = u;
            let phi = [x, y, z, y * z, z * x, x * y, x * x, y * y, z * z];
            let row = core::array::from_fn(|i| s[i] * phi[i]);
            moments.add(u, 0.3 - 0.01 * t, w);
            plain.add(&row, 0.3 - 0.01 * t, w);
        }
        let (matrix, gradient) = moments.normal(&s);
        for (i, (value, expected)) in matrix.0.iter().zip(plain.matrix.0).enumerate() {
            assert!(
                (value - expected).abs() < 2e-5 * (1.0 + expected.abs()),
                "entry {i}: {value} {expected}"
            );
        }
        for (value, expected) in gradient.iter().zip(plain.gradient) {
            assert!((value - expected).abs() < 2e-5 * (1.0 + expected.abs()));
        }
    }
}
