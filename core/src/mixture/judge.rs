//! Is it an ellipsoid at all? What the points say of a fitted surface, and the tests of acceptance.
//!
//! * *Gain*: how much better the points are explained than as uniform clutter, for each point.
//! * *Coverage*: of points uniform by area, weighed with `1 / |g|`, the unit-sphere coordinates are uniform over the sphere:
//!   mean 0, second moments `I / 3`. Of a cap that covers the part `f` of the sphere the mean has the length `1 - f`; of
//!   a band `|z| < f` about the middle `<z^2> = f^2 / 3`. The smaller `f` is the coverage: half a surface shows at the
//!   first, a pipe without ends at the second.
//! * *Flat*: a plane is explained by a thin ellipsoid, but nearly as well by a plane.
//! * *Misfit*: the residuals of a box or a cylinder depend on where on the surface they are. The sphere is cut into 54
//!   cells, 3x3 on each face of the cube; the rms of the cells' means, less what chance gives them, over the shortest
//!   semi-axis.

use crate::accept::{Refusal, RefusalCode};
use crate::{
    jacobi::{Symmetric3, eigen},
    mixture::{
        MixtureGate,
        shell::{Data, Shell, contact, smallest},
    },
    point::at,
    residual::dot,
};

/// What the tests look at.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MixtureFindings {
    /// Points on the surface (sum of probabilities).
    pub members: f32,
    /// Gain over uniform clutter for each point, natural logarithm.
    pub gain: f32,
    /// Covered part of the surface.
    pub coverage: f32,
    /// Rms distance from the best plane over that from the surface.
    pub flat: f32,
    /// Rms of the residuals that depends on where on the surface they are, over the shortest semi-axis.
    pub misfit: f32,
    /// Largest standard deviation of the centre over the shortest semi-axis.
    pub uncertain: f32,
}

impl MixtureGate {
    /// The first test that fails.
    pub fn refusal(&self, f: &MixtureFindings) -> Option<Refusal> {
        let above =
            |code, value: f32, limit: f32| (!(value <= limit)).then_some(Refusal { code, value, limit });
        let below =
            |code, value: f32, limit: f32| (!(value >= limit)).then_some(Refusal { code, value, limit });
        below(RefusalCode::FewPoints, f.members, self.min_points)
            .or_else(|| below(RefusalCode::Flat, f.flat, self.flat))
            .or_else(|| below(RefusalCode::Clutter, f.gain, self.gain))
            .or_else(|| below(RefusalCode::Coverage, f.coverage, self.coverage))
            .or_else(|| above(RefusalCode::Shape, f.misfit, self.misfit))
            .or_else(|| above(RefusalCode::Vague, f.uncertain, self.uncertain))
    }
}

/// Half of the eleven parameters: each costs half the logarithm of the number of points (Schwarz 1978).
const PRICE: f32 = 5.5;
const CELLS: usize = 54;
/// Parameters of the surface: so many directions of the residuals are fitted away.
const FITTED: f32 = 9.0;
/// `d^2 / sigma^2` up to which a point counts.
const NEAR: f32 = 16.0;

/// Cell of a direction: face of the cube by the largest component, then thirds of the two others.
fn cell(u: [f32; 3]) -> usize {
    let [x, y, z] = u.map(libm::fabsf);
    let (face, main, p, q) = if x >= y && x >= z {
        (0, u[0], u[1], u[2])
    } else if y >= z {
        (1, u[1], u[2], u[0])
    } else {
        (2, u[2], u[0], u[1])
    };
    let third = |v: f32| {
        let size = 3.0 * libm::fabsf(v);
        if size < libm::fabsf(main) {
            1
        } else if v < 0.0 {
            0
        } else {
            2
        }
    };
    ((2 * face + usize::from(main < 0.0)) * 3 + third(p)) * 3 + third(q)
}

/// Looks at all listed points; `uncertain` is left for the covariance to say.
pub(crate) fn findings(shell: &Shell, data: &Data<'_>, ln_area: f32) -> MixtureFindings {
    let model = shell.model(data.distance);
    let odds = shell.odds(data.frame.volume, ln_area);
    let window = shell.window(data.distance);
    let centre = shell.estimate.centre;
    let short = smallest(&shell.estimate.ln_axes);
    let (mut members, mut gain, mut model_sum) = (0.0_f32, 0.0_f32, 0.0_f32);
    let (mut area, mut first, mut second) = (0.0_f32, [0.0_f32; 3], Symmetric3::default());
    let (mut sum, mut square) = ([0.0_f32; 3], Symmetric3::default());
    let (mut counts, mut means) = ([0.0_f32; CELLS], [0.0_f32; CELLS]);
    for &index in data.list {
        let p = data.frame.local(&at(data.cloud, index));
        let contact = contact(&model, &p, data.distance);
        let f2 = contact.square();
        if !(f2 < NEAR && contact.gap_mm < window && contact.gap_mm >= -window) {
            continue;
        }
        let k = odds * libm::expf(-0.5 * f2);
        let r = k / (1.0 + k);
        gain += libm::log1pf(k);
        members += r;
        model_sum += r * ((contact.value * contact.value) / model.gradient_squared(contact.u));
        let u = contact.u;
        let share = r / libm::sqrtf(model.gradient_squared(u));
        area += share;
        add_moments(&mut first, &mut second, u, share);
        add_moments(&mut sum, &mut square, [p.x - centre[0], p.y - centre[1], p.z - centre[2]], r);
        let slot = cell(u);
        if let (Some(count), Some(mean)) = (counts.get_mut(slot), means.get_mut(slot)) {
            *count += r;
            let f = libm::sqrtf(f2);
            *mean += r * if contact.value < 0.0 { -f } else { f };
        }
    }
    let count = data.list.len() as f32;
    let gain = (gain - PRICE * libm::logf(count)) / count + libm::log1pf(-shell.share);
    let plane = scatter(members, sum, &square);
    let ratio = eigen(&plane).values[0] / (model_sum / members);
    MixtureFindings {
        members,
        gain,
        coverage: coverage(members, area, first, &second),
        flat: if ratio > 0.0 { libm::sqrtf(ratio) } else { 0.0 },
        misfit: misfit(&counts, &means, members, model_sum / (shell.sigma * shell.sigma))
            * (shell.sigma / short),
        uncertain: 0.0,
    }
}

#[inline(always)]
fn add_moments(first: &mut [f32; 3], second: &mut Symmetric3, v: [f32; 3], weight: f32) {
    let [x, y, z] = v;
    let (wx, wy, wz) = (weight * x, weight * y, weight * z);
    first[0] += wx;
    first[1] += wy;
    first[2] += wz;
    second.xx += wx * x;
    second.yy += wy * y;
    second.zz += wz * z;
    second.xy += wx * y;
    second.xz += wx * z;
    second.yz += wy * z;
}

/// Covariance from sums.
fn scatter(n: f32, sum: [f32; 3], square: &Symmetric3) -> Symmetric3 {
    let [x, y, z] = sum.map(|s| s / n);
    Symmetric3 {
        xx: square.xx / n - x * x,
        yy: square.yy / n - y * y,
        zz: square.zz / n - z * z,
        xy: square.xy / n - x * y,
        xz: square.xz / n - x * z,
        yz: square.yz / n - y * z,
    }
}

/// `members` points scattered over the whole sphere have a mean of their own, of square `1 / members` on average, and
/// their smallest second moment falls short by about `1 / 3 sqrt(members)`.
fn coverage(members: f32, area: f32, first: [f32; 3], second: &Symmetric3) -> f32 {
    let mean = first.map(|s| s / area);
    let square = dot(mean, mean) - 1.0 / members;
    let cap = 1.0 - if square > 0.0 { libm::sqrtf(square) } else { 0.0 };
    let smallest = 3.0 * (eigen(second).values[0] / area) + 1.0 / libm::sqrtf(members);
    let band = if smallest > 0.0 { libm::sqrtf(smallest) } else { 0.0 };
    if cap < band { cap } else { band }
}

/// Root of the variance of the cells' means beyond what chance gives them, in units of sigma; `squares` is the sum of `r f^2`.
fn misfit(counts: &[f32; CELLS], means: &[f32; CELLS], members: f32, squares: f32) -> f32 {
    let (mut between, mut occupied) = (0.0_f32, 0.0_f32);
    for (&count, &mean) in counts.iter().zip(means) {
        if count > 1.0 {
            between += (mean * mean) / count;
            occupied += 1.0;
        }
    }
    // Chi-squared: mean and three standard deviations.
    let freedom = if occupied > FITTED { occupied - FITTED } else { 0.0 };
    let chance = (freedom + 3.0 * libm::sqrtf(2.0 * freedom)) * (squares / members);
    let square = (between - chance) / members;
    if square > 0.0 { libm::sqrtf(square) } else { 0.0 }
}
