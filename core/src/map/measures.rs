//! What the tests of acceptance look at: one fruit measured against its points, its outline and the others.

use super::{Fruit, Standing};
use crate::{
    Ellipsoid,
    accept::contact_function,
    jacobi::{Symmetric3, eigen},
    point::at,
    refine::{Estimate, Evidence, Terms},
    residual::{RayModel, Viewpoint, dot},
    visibility::{Sight, predicted_pixels, sight},
};

/// A body counts as elongated when its long semi-axis is this many times the middle one.
const ELONGATED: f32 = 1.3;

/// See [`Findings::end_on`].
pub(super) fn end_on(ellipsoid: &Ellipsoid, viewpoint: Viewpoint) -> f32 {
    let [a, b, _] = ellipsoid.semi_axes;
    if viewpoint == Viewpoint::None || a < ELONGATED * b {
        return 0.0;
    }
    let centre = [ellipsoid.centre.x, ellipsoid.centre.y, ellipsoid.centre.z];
    libm::fabsf(dot(ellipsoid.axes[0], centre)) / libm::sqrtf(dot(centre, centre))
}

/// Seen on the surface, in the mask or not, over predicted pixels; infinite where the pitch is not known.
pub(super) fn visible(seen: f32, ellipsoid: &Ellipsoid, pitch_rad: f32) -> f32 {
    if pitch_rad > 0.0 && ellipsoid.centre.z > 0.0 {
        seen / predicted_pixels(ellipsoid, pitch_rad)
    } else {
        f32::INFINITY
    }
}

/// The contact function with the nearest fruit that was accepted before; for a ghost, with any that is none.
pub(super) fn separation(found: &[Fruit], turn: u8, ellipsoid: &Ellipsoid) -> f32 {
    let ghost = found.get(usize::from(turn)).is_some_and(|fruit| fruit.standing == Standing::Ghost);
    let mut least = f32::INFINITY;
    for (j, other) in found.iter().enumerate() {
        let counts = other.standing == Standing::Accepted || (ghost && other.standing != Standing::Ghost);
        if counts && j != usize::from(turn) {
            let separation = contact_function(ellipsoid, &other.estimate.ellipsoid());
            if separation < least {
                least = separation;
            }
        }
    }
    least
}

/// Outline rays that can be the model's, and the mean of `min(|f|, 3)` over them.
#[inline(never)]
pub(super) fn outline_fit(evidence: &Evidence<'_>, best: &Estimate, terms: &Terms) -> (u16, f32) {
    let ellipsoid = best.ellipsoid();
    let model = RayModel::new(&ellipsoid, &terms.noise, terms.viewpoint);
    let mut count = 0_u16;
    let mut sum = 0.0;
    for touch in evidence.touches(&model, &ellipsoid, terms) {
        let size = libm::sqrtf(touch.square(best.boxiness));
        sum += if size < 3.0 { size } else { 3.0 };
        count += 1;
    }
    (count, if count == 0 { 0.0 } else { sum / f32::from(count) })
}

/// What the points near a model look like.
pub(super) struct PointShape {
    /// Points on its surface, in the mask or not.
    pub(super) count: f32,
    /// Rms distance of the explained points from their best plane over their rms distance from the model.
    pub(super) flat: f32,
    /// Share of the explained points outside the mask.
    pub(super) outside: f32,
    /// Points near the model that it does not explain, over those it does.
    pub(super) clutter: f32,
}

/// Unexplained points count as near within twice the window and `f^2 < 100`.
const CLUTTER_CUT: f32 = 100.0;

#[inline(never)]
pub(super) fn shape_of_points(
    evidence: &Evidence<'_>,
    best: &Estimate,
    terms: &Terms,
    in_mask: usize,
) -> PointShape {
    let ellipsoid = best.ellipsoid();
    let model = RayModel::new(&ellipsoid, &terms.noise, terms.viewpoint);
    let c = ellipsoid.centre;
    let near_mm = 2.0 * terms.window_mm;
    let (mut n, mut outside, mut near, mut model_sum) = (0.0_f32, 0.0_f32, 0.0_f32, 0.0_f32);
    let mut sum = [0.0_f32; 3];
    let mut square = Symmetric3::default();
    for &index in evidence.members {
        if !evidence.is_unclaimed(index) {
            continue;
        }
        let p = at(evidence.cloud, index);
        let contact = model.contact(&p);
        let Sight::Explained(_) = sight(&contact, terms.window_mm) else {
            let close = contact.gap_mm < near_mm && contact.gap_mm > -near_mm;
            near += if close && contact.square() < CLUTTER_CUT { 1.0 } else { 0.0 };
            continue;
        };
        n += 1.0;
        outside += if usize::from(index) >= in_mask { 1.0 } else { 0.0 };
        model_sum += (contact.value * contact.value) / model.gradient_squared(contact.u);
        let (x, y, z) = (p.x - c.x, p.y - c.y, p.z - c.z);
        sum[0] += x;
        sum[1] += y;
        sum[2] += z;
        square.xx += x * x;
        square.yy += y * y;
        square.zz += z * z;
        square.xy += x * y;
        square.xz += x * z;
        square.yz += y * z;
    }
    if n < 1.0 {
        return PointShape { count: 0.0, flat: 0.0, outside: 0.0, clutter: 0.0 };
    }
    let [x, y, z] = sum.map(|s| s / n);
    let scatter = Symmetric3 {
        xx: square.xx / n - x * x,
        yy: square.yy / n - y * y,
        zz: square.zz / n - z * z,
        xy: square.xy / n - x * y,
        xz: square.xz / n - x * z,
        yz: square.yz / n - y * z,
    };
    let ratio = eigen(&scatter).values[0] / (model_sum / n);
    let flat = if ratio > 0.0 { libm::sqrtf(ratio) } else { 0.0 };
    PointShape { count: n, flat, outside: outside / n, clutter: near / n }
}
