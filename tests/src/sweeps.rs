//! Chapter 11.1 of the numeric contract with a count: how many sweeps of Jacobi's rotations a matrix needs when nobody
//! stops them.

use varsac_core::jacobi::Symmetric3;

/// Far beyond what quadratic convergence can need: reaching it would mean that the iteration does not end.
pub const LIMIT: u32 = 100;

/// Sweeps until one rotates nothing, that one included, and the diagonal then.
pub fn needed(a: &Symmetric3) -> (u32, [f32; 3]) {
    let mut m = [[a.xx, a.xy, a.xz], [a.xy, a.yy, a.yz], [a.xz, a.yz, a.zz]];
    let mut sweeps = 0;
    let mut rotated = true;
    while rotated && sweeps < LIMIT {
        sweeps += 1;
        rotated = false;
        for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            rotated |= rotate(&mut m, p, q, r);
        }
    }
    (sweeps, [m[0][0], m[1][1], m[2][2]])
}

fn rotate(m: &mut [[f32; 3]; 3], p: usize, q: usize, r: usize) -> bool {
    let (app, aqq, apq) = (m[p][p], m[q][q], m[p][q]);
    m[p][q] = 0.0;
    m[q][p] = 0.0;
    let vanishes = |d: f32| d.abs() + apq.abs() == d.abs();
    if vanishes(app) && vanishes(aqq) {
        return false;
    }
    let theta = (aqq - app) / (2.0 * apq);
    let root = theta.abs() + libm::sqrtf(theta * theta + 1.0);
    let t = if theta < 0.0 { -1.0 / root } else { 1.0 / root };
    let cos = 1.0 / libm::sqrtf(t * t + 1.0);
    let sin = t * cos;
    let tau = sin / (1.0 + cos);
    m[p][p] = app - t * apq;
    m[q][q] = aqq + t * apq;
    let (arp, arq) = (m[r][p], m[r][q]);
    m[r][p] = arp - sin * (arq + tau * arp);
    m[p][r] = m[r][p];
    m[r][q] = arq + sin * (arp - tau * arq);
    m[q][r] = m[r][q];
    true
}
