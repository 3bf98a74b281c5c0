//! The normal equations of a step: contract, chapter M9.

use super::algebra::{Lower, Vector, product};
use super::contact::{Contact, Kernel, phi};
use super::evidence::Evidence;
use super::model::{Estimate, Model};
use super::prior::Terms;
use crate::fault::{self, Fault};

/// One residual `F` with the monomials of its `u` and its weight.
pub(crate) struct Residual {
    phi: [f32; 9],
    value: f32,
    weight: f32,
}

impl Residual {
    pub(crate) fn new([x, y, z]: Vector, value: f32, weight: f32) -> Self {
        let phi = [x, y, z, y * z, z * x, x * y, x * x, y * y, z * z];
        Self { phi, value, weight }
    }
}

/// Matrix and gradient, and what the boxiness does when the nine parameters move.
pub(crate) struct Normal {
    pub(crate) matrix: Lower,
    pub(crate) gradient: [f32; 9],
    pub(crate) follower: Follower,
}

/// M9.5: `b, gk, invk`.
#[derive(Default)]
pub(crate) struct Follower {
    pub(crate) b: [f32; 9],
    pub(crate) gradient: f32,
    pub(crate) inverse: f32,
}

/// M9: of an estimate, its evidence and terms, under a kernel.
pub(crate) fn normal_equations(
    estimate: &Estimate,
    evidence: Evidence,
    terms: &Terms,
    kernel: Kernel,
) -> Normal {
    let model = Model::new(estimate, terms.noise, terms.viewpoint);
    let k = estimate.boxiness;
    let mut residuals = Vec::new();
    let mut displacement = Row::new(terms.offset, 0.0);
    let mut boxiness = Row::new(terms.boxiness, k);
    let mut both = 0.0;
    for &member in evidence.members {
        let Some(contact) = counted(&model, evidence, member, terms.window) else { continue };
        let f = phi(contact.u);
        let value = contact.value - k * f;
        if let Some(weight) = kernel.weight((value * value) / contact.variance) {
            let weight = (weight * terms.told) / contact.variance;
            let residual = Residual::new(contact.u, value, weight);
            boxiness.gain(&residual, -f);
            residuals.push(residual);
        }
    }
    for touch in evidence.touching(&model, terms) {
        let f = phi(touch.u);
        let value = touch.on_body(k);
        if let Some(weight) = Kernel::GemanMcClure(9.0).weight(touch.f2(k)) {
            let weight = weight / touch.variance;
            let residual = Residual::new(touch.u, value, weight);
            displacement.gain(&residual, -touch.lever);
            boxiness.gain(&residual, -f);
            residuals.push(residual);
            both += weight * (touch.lever * f);
        }
    }
    let (matrix, gradient) = moments(&residuals, &model.slopes());
    let mut normal = Normal { matrix, gradient, follower: Follower::default() };
    normal.eliminate(&displacement, &boxiness, both, &model.slopes());
    normal.add_prior(estimate, terms);
    normal
}

/// M9.1: the contact of a member, as it is or *beside*, where it counts.
fn counted(model: &Model, evidence: Evidence, member: u16, window: f32) -> Option<Contact> {
    let contact = Contact::new(model, evidence.point(member));
    if contact.gap_mm > window {
        let beside = contact.miss > 0.25 && contact.miss < 1.0 && !fault::is(Fault::Beside);
        beside.then(|| contact.beside(model))
    } else {
        (contact.gap_mm >= -window && evidence.open(member)).then_some(contact)
    }
}

/// M9.3 and 4: matrix and gradient from the sums, each sum a pass of its own over the residuals.
pub(crate) fn moments(residuals: &[Residual], s: &[f32; 9]) -> (Lower, [f32; 9]) {
    // The sum of `w * left * right`, for members `left` and `right` of the monomials.
    const X: usize = 0;
    const Y: usize = 1;
    const Z: usize = 2;
    const YZ: usize = 3;
    const ZX: usize = 4;
    const XY: usize = 5;
    const XX: usize = 6;
    const YY: usize = 7;
    const ZZ: usize = 8;
    let single = |left: usize| {
        let mut sum = 0.0;
        for r in residuals {
            sum += r.weight * r.phi[left];
        }
        sum
    };
    let double = |left: usize, right: usize| {
        let mut sum = 0.0;
        for r in residuals {
            sum += (r.weight * r.phi[left]) * r.phi[right];
        }
        sum
    };
    let (x, y, z) = (single(X), single(Y), single(Z));
    let (xx, yy, zz) = (single(XX), single(YY), single(ZZ));
    let (yz, zx, xy) = (single(YZ), single(ZX), single(XY));
    let (xxy, xxz, yyx) = (double(XX, Y), double(XX, Z), double(YY, X));
    let (yyz, zzx, zzy) = (double(YY, Z), double(ZZ, X), double(ZZ, Y));
    let xyz = double(XY, Z);
    let (xxxy, xxxz, yyyx) = (double(XX, XY), double(XX, ZX), double(YY, XY));
    let (yyyz, zzzx, zzzy) = (double(YY, YZ), double(ZZ, ZX), double(ZZ, YZ));
    let (xxyy, yyzz, zzxx) = (double(XX, YY), double(YY, ZZ), double(ZZ, XX));
    // M9.3: the rest follow from x^2 + y^2 + z^2 = 1.
    let xxx = if fault::is(Fault::Moments) { x - (yyx + zzx) } else { (x - yyx) - zzx };
    let yyy = (y - xxy) - zzy;
    let zzz = (z - xxz) - yyz;
    let xxyz = (yz - yyyz) - zzzy;
    let yyzx = (zx - xxxz) - zzzx;
    let zzxy = (xy - xxxy) - yyyx;
    let xxxx = (xx - xxyy) - zzxx;
    let yyyy = (yy - xxyy) - yyzz;
    let zzzz = (zz - zzxx) - yyzz;
    let table: [&[f32]; 9] = [
        &[xx],
        &[xy, yy],
        &[zx, yz, zz],
        &[xyz, yyz, zzy, yyzz],
        &[xxz, xyz, zzx, zzxy, zzxx],
        &[xxy, yyx, xyz, yyzx, xxyz, xxyy],
        &[xxx, xxy, xxz, xxyz, xxxz, xxxy, xxxx],
        &[yyx, yyy, yyz, yyyz, yyzx, yyyx, xxyy, yyyy],
        &[zzx, zzy, zzz, zzzy, zzzx, zzxy, zzxx, yyzz, zzzz],
    ];
    let mut matrix = [[0.0; 9]; 9];
    let mut gradient = [0.0; 9];
    for i in 0..9 {
        for j in 0..=i {
            matrix[i][j] = (s[i] * s[j]) * table[i][j];
        }
        let mut sum = 0.0;
        for r in residuals {
            sum += (r.weight * r.value) * r.phi[i];
        }
        gradient[i] = s[i] * sum;
    }
    (matrix, gradient)
}

/// M9: a parameter that is to be eliminated.
pub(crate) struct Row {
    information: f32,
    coupling: [f32; 9],
    gradient: f32,
}

impl Row {
    /// With a standard deviation and the present value.
    pub(crate) fn new(deviation: f32, value: f32) -> Self {
        let information = 1.0 / (deviation * deviation);
        let gradient = if deviation > 0.0 { information * value } else { 0.0 };
        Self { information, coupling: [0.0; 9], gradient }
    }

    pub(crate) fn gain(&mut self, residual: &Residual, slope: f32) {
        let h = residual.weight * slope;
        self.information += h * slope;
        for i in 0..9 {
            self.coupling[i] += h * residual.phi[i];
        }
        self.gradient += h * residual.value;
    }
}

impl Normal {
    /// M9.5: adds a row `r` with a value and a weight.
    fn add(&mut self, r: &[f32; 9], value: f32, weight: f32) {
        let t = weight * value;
        for i in 0..9 {
            for j in 0..=i {
                self.matrix[i][j] += (weight * r[i]) * r[j];
            }
            self.gradient[i] += t * r[i];
        }
    }

    /// M9.5.
    pub(crate) fn eliminate(&mut self, displacement: &Row, boxiness: &Row, both: f32, s: &[f32; 9]) {
        let mut d = [0.0; 9];
        let mut b = [0.0; 9];
        for i in 0..9 {
            d[i] = displacement.coupling[i] * s[i];
            b[i] = boxiness.coupling[i] * s[i];
        }
        let inv = 1.0 / displacement.information;
        if !fault::is(Fault::Displacement) {
            self.add(&d, displacement.gradient, -inv);
        }
        let share = both * inv;
        for i in 0..9 {
            b[i] -= share * d[i];
        }
        let gk = boxiness.gradient - share * displacement.gradient;
        let reduced = boxiness.information - share * both;
        let invk = 1.0 / if fault::is(Fault::Boxiness) { boxiness.information } else { reduced };
        self.add(&b, gk, -invk);
        self.follower = Follower { b, gradient: gk, inverse: invk };
    }

    /// M9.6.
    pub(crate) fn add_prior(&mut self, estimate: &Estimate, terms: &Terms) {
        let p = &terms.prior.information;
        let pull = product(p, terms.prior.departure(estimate.x));
        for (i, j, value) in
            [(6, 6, p.xx), (7, 7, p.yy), (8, 8, p.zz), (7, 6, p.xy), (8, 6, p.xz), (8, 7, p.yz)]
        {
            self.matrix[i][j] += value;
        }
        for k in 0..3 {
            self.gradient[6 + k] += pull[k];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Matrix and gradient must be those of the rows `s_i * phi_i`.
    #[test]
    fn the_moments_are_the_normal_equations_of_the_rows() {
        let mut residuals = Vec::new();
        for k in 0..40 {
            let (t, z) = (0.7 * k as f32, k as f32 / 20.0 - 0.975);
            let r = (1.0 - z * z).sqrt();
            let (u, weight) = ([r * t.cos(), r * t.sin(), z], 1.0 + 0.1 * k as f32);
            residuals.push(Residual::new(u, 0.01 * t.sin(), weight));
        }
        let s = [-0.05, -0.1, -0.1, 0.02, 1.5, -1.5, -1.0, -1.0, -1.0];
        let (matrix, gradient) = moments(&residuals, &s);
        for i in 0..9 {
            let row = |r: &Residual, i: usize| f64::from(s[i]) * f64::from(r.phi[i]);
            for j in 0..=i {
                let exact: f64 = residuals.iter().map(|r| f64::from(r.weight) * row(r, i) * row(r, j)).sum();
                assert!((f64::from(matrix[i][j]) - exact).abs() < 1e-4, "{i} {j}");
            }
            let exact: f64 = residuals.iter().map(|r| f64::from(r.weight * r.value) * row(r, i)).sum();
            assert!((f64::from(gradient[i]) - exact).abs() < 1e-4, "{i}");
        }
    }

    #[test]
    fn an_eliminated_row_is_the_schur_complement() {
        let mut normal = Normal { matrix: [[0.0; 9]; 9], gradient: [0.0; 9], follower: Follower::default() };
        normal.matrix[0][0] = 5.0;
        let mut displacement = Row::new(0.5, 0.0);
        displacement.coupling[0] = 2.0;
        displacement.gradient = 3.0;
        let boxiness = Row::new(0.0, 0.0);
        normal.eliminate(&displacement, &boxiness, 0.0, &[1.0; 9]);
        assert_eq!(normal.matrix[0][0], 5.0 - 2.0 * 2.0 / 4.0);
        assert_eq!(normal.gradient[0], -(2.0 * 3.0) / 4.0);
        assert_eq!(normal.follower.inverse, 0.0);
    }
}
