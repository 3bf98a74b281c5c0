//! What speaks for a shell, and whether it is enough: contract, chapter X10.

use super::cells::{Cell, Cells, cell, variance_between};
use super::config::{MixtureConfig, MixtureGate};
use super::look::{Look, Scene, contact};
use super::moments::{Moments, smallest_eigenvalue};
use super::numbers::smallest;
use super::shell::Shell;
use crate::fault::{self, Fault};
use crate::jacobi::{ascending, eigen};
use crate::map::accept::{Refusal, RefusalCode};
use crate::map::algebra::{Vector, dot, minus};
use crate::map::covariance::covariance;
use crate::map::judge::sorted;
use crate::{Ellipsoid, Symmetric};

/// A shell that was judged, still local.
#[derive(Clone, Copy)]
pub(crate) struct Body {
    pub(crate) ellipsoid: Ellipsoid,
    pub(crate) sigma: f32,
    pub(crate) members: f32,
    pub(crate) covariance: Option<[f32; 45]>,
    pub(crate) refusal: Option<Refusal>,
}

/// X10: the sums over the points.
struct Sums {
    gain: f32,
    members: f32,
    q: f32,
    area: f32,
    sphere: Moments,
    plane: Moments,
    cells: Cells,
}

/// X10: the final shell, over all live points.
pub(crate) fn judged(shell: &Shell, scene: &Scene, points: &[Vector], config: &MixtureConfig) -> Body {
    let look = Look::new(scene, shell, shell.ln_area(), points);
    let sums = sums(&look, shell, scene, points);
    let (ellipsoid, order) = sorted(&shell.estimate);
    let shortest = ellipsoid.semi_axes[2];
    let thick = shell.sigma / shortest;
    let w = shell.share;
    let factor = (config.inflation + config.inflation_thin * (thick * thick))
        + config.inflation_outliers * ((1.0 - w) / w);
    let covariance = covariance(&shell.estimate, &look.information(), factor, ellipsoid.semi_axes, order);
    let c = points.len() as f32;
    let found = Found {
        members: sums.members,
        gain: (sums.gain - 5.5 * libm::logf(c)) / c + libm::log1pf(-w),
        flat: root(smallest_eigenvalue(&sums.plane.scatter(sums.members)) / (sums.q / sums.members)),
        coverage: coverage(&sums),
        misfit: root(variance_between(&sums.cells, sums.q, shell.sigma, sums.members))
            * (shell.sigma / smallest(shell.estimate.x)),
        uncertain: deviation(covariance.as_ref()) / shortest,
    };
    Body {
        ellipsoid,
        sigma: shell.sigma,
        members: sums.members,
        covariance,
        refusal: refusal(&found, &config.gate),
    }
}

/// The square root of what is positive, else 0.
fn root(z: f32) -> f32 {
    if z > 0.0 { libm::sqrtf(z) } else { 0.0 }
}

/// X10, first paragraph.
fn sums(look: &Look, shell: &Shell, scene: &Scene, points: &[Vector]) -> Sums {
    let mut sums = Sums {
        gain: 0.0,
        members: 0.0,
        q: 0.0,
        area: 0.0,
        sphere: Moments::default(),
        plane: Moments::default(),
        cells: [Cell::default(); 54],
    };
    for &p in points {
        let contact = contact(&look.model, scene.distance, p);
        let f2 = contact.f2();
        let counts = f2 < 16.0 && contact.gap_mm < look.window && contact.gap_mm >= -look.window;
        if !counts {
            continue;
        }
        let k = look.odds * libm::expf(-0.5 * f2);
        let r = k / (1.0 + k);
        sums.gain += libm::log1pf(k);
        sums.members += r;
        let g = look.model.grad2(contact.u);
        sums.q += r * ((contact.value * contact.value) / g);
        let h = r / libm::sqrtf(g);
        sums.area += h;
        sums.sphere.gain(contact.u, h);
        sums.plane.gain(minus(p, shell.estimate.centre), r);
        let f = libm::sqrtf(f2);
        let cell = &mut sums.cells[cell(contact.u)];
        cell.count += if fault::is(Fault::Cells) { r * f2 } else { r };
        cell.mean += r * if contact.value < 0.0 { -f } else { f };
    }
    sums
}

/// X10, coverage.
fn coverage(sums: &Sums) -> f32 {
    let m = sums.sphere.mean(sums.area);
    let cap = 1.0 - root(dot(m, m) - 1.0 / sums.members);
    let e = smallest_eigenvalue(&sums.sphere.q);
    let band = root(3.0 * (e / sums.area) + 1.0 / libm::sqrtf(sums.members));
    if fault::is(Fault::Coverage) {
        return if cap < band { band } else { cap };
    }
    if cap < band { cap } else { band }
}

/// M18.9 of a local covariance.
fn deviation(covariance: Option<&[f32; 45]>) -> f32 {
    let Some(&[xx, xy, yy, xz, yz, zz, ..]) = covariance else { return f32::INFINITY };
    let largest = ascending(&eigen(&Symmetric { xx, yy, zz, xy, xz, yz })).values[2];
    if largest > 0.0 { libm::sqrtf(largest) } else { f32::INFINITY }
}

/// What the tests look at.
struct Found {
    members: f32,
    gain: f32,
    flat: f32,
    coverage: f32,
    misfit: f32,
    uncertain: f32,
}

/// X10, refusal: the first test that fails.
fn refusal(found: &Found, gate: &MixtureGate) -> Option<Refusal> {
    use RefusalCode::{Clutter, Coverage, FewPoints, Flat, Shape, Vague};
    for (code, value, limit, passed) in [
        (FewPoints, found.members, gate.min_points, found.members >= gate.min_points),
        (Flat, found.flat, gate.flat, found.flat >= gate.flat),
        (Clutter, found.gain, gate.gain, found.gain >= gate.gain),
        (Coverage, found.coverage, gate.coverage, found.coverage >= gate.coverage),
        (Shape, found.misfit, gate.misfit, found.misfit <= gate.misfit),
        (Vague, found.uncertain, gate.uncertain, found.uncertain <= gate.uncertain),
    ] {
        if !passed {
            return Some(Refusal { code, value, limit });
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_test_that_fails_is_named_and_nan_fails() {
        let gate = MixtureGate {
            min_points: 20.0,
            gain: 0.1,
            flat: 1.5,
            coverage: 0.5,
            misfit: 0.02,
            uncertain: 0.3,
        };
        let good =
            || Found { members: 20.0, gain: 0.1, flat: 1.5, coverage: 0.5, misfit: 0.02, uncertain: 0.3 };
        assert_eq!(refusal(&good(), &gate), None);
        let bad = Found { gain: 0.0, flat: 1.0, ..good() };
        assert_eq!(refusal(&bad, &gate), Some(Refusal { code: RefusalCode::Flat, value: 1.0, limit: 1.5 }));
        let nan = refusal(&Found { uncertain: f32::NAN, ..good() }, &gate);
        assert!(nan.is_some_and(|refusal| refusal.code == RefusalCode::Vague));
    }
}
