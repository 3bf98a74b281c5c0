//! How well a model explains what the camera saw: points on it count for it, points seen through it against it.
//!
//! Each point has the squared residual `f^2 = F^2 / variance` at the model's point ([`crate::residual`]):
//! * `f^2 < 6.25` (2.5 standard deviations) and within the window of the model's point along the ray: explained,
//!   `1 - f^2 / 6.25`. Only the near side of the model is ever met, so the check for facing the camera is built in;
//! * behind the surface, the ray passing well inside the model: seen *through* it, `-1.5`;
//! * anything else is in front of it (a leaf) or beside it: nothing.
//!
//! An outline ray that fits adds half of `1 - f^2 / 6.25`.

use crate::{
    Ellipsoid,
    point::at,
    refine::{Estimate, Evidence, Terms},
    residual::{Contact, RayModel, dot},
};

/// `2.5^2`.
pub const CUT: f32 = 6.25;
/// Price of a point seen through the model.
pub const VIOLATION: f32 = 1.5;
/// A ray passes well inside the model below this `e.e`: nearer to the centre than 0.87 of the way to the rim.
const WELL_INSIDE: f32 = 0.75;
/// Worth of an outline ray beside a point.
const OUTLINE_WORTH: f32 = 0.5;

/// What a point says about a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sight {
    /// On the surface, with `f^2`.
    Explained(f32),
    /// Seen through the model.
    Through,
    /// In front of it or beside it.
    Unrelated,
}

/// Judges one contact.
#[inline(always)]
pub fn sight(contact: &Contact, window_mm: f32) -> Sight {
    let square = contact.square();
    if square < CUT && contact.gap_mm < window_mm && contact.gap_mm > -window_mm {
        Sight::Explained(square)
    } else if contact.gap_mm > 0.0 && square >= CUT && contact.miss_squared < WELL_INSIDE {
        Sight::Through
    } else {
        Sight::Unrelated
    }
}

/// Support of a model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Support {
    /// Sum of the evidence, less the prior's price.
    pub score: f32,
    /// Points explained.
    pub explained: u16,
    /// Points seen through.
    pub through: u16,
}

impl Evidence<'_> {
    /// Scores a model; gives up with `None` as soon as `floor` cannot be exceeded any more, which changes no result.
    pub(crate) fn support(&self, estimate: &Estimate, terms: &Terms, floor: f32) -> Option<Support> {
        let ellipsoid = estimate.ellipsoid();
        let model = RayModel::new(&ellipsoid, &terms.noise, terms.viewpoint);
        // A residual at the cut costs 6.25 in twice the negative logarithm of the likelihood; so does the prior.
        let mut support =
            Support { score: -(terms.prior.cost(&estimate.ln_axes) / CUT), explained: 0, through: 0 };
        for touch in self.touches(&model, &ellipsoid, terms) {
            if touch.square(estimate.boxiness) < CUT {
                support.score += OUTLINE_WORTH * (1.0 - touch.square(estimate.boxiness) / CUT);
            }
        }
        let mut left = self.members.len() as f32;
        for &index in self.members {
            left -= 1.0;
            match sight(&model.contact(&at(self.cloud, index)), terms.window_mm) {
                Sight::Explained(square) => {
                    if self.is_open(index) {
                        support.score += terms.independence * (1.0 - square / CUT);
                        support.explained += 1;
                    }
                }
                Sight::Through => {
                    support.score -= terms.independence * VIOLATION;
                    support.through += 1;
                }
                Sight::Unrelated => {}
            }
            // Written so that a score that is no number has no support.
            if !(support.score + terms.independence * left > floor) {
                return None;
            }
        }
        Some(support)
    }
}

/// Pixels the whole near side of an ellipsoid covers in a camera with square pixels of `pitch_rad`, rad at the image
/// centre: the area of its shadow along the ray of its centre, `pi sqrt((bc v1)^2 + (ca v2)^2 + (ab v3)^2)` with `v` the
/// direction in the body's frame, over a pixel's footprint there.
pub fn predicted_pixels(ellipsoid: &Ellipsoid, pitch_rad: f32) -> f32 {
    let centre = [ellipsoid.centre.x, ellipsoid.centre.y, ellipsoid.centre.z];
    let [a, b, c] = ellipsoid.semi_axes;
    let [ra, rb, rc] = ellipsoid.axes;
    let shadow = [(b * c) * dot(ra, centre), (c * a) * dot(rb, centre), (a * b) * dot(rc, centre)];
    // Area of the shadow times the range; the range and the cosine of the footprint leave z |c| / |c| = z.
    let area = core::f32::consts::PI * libm::sqrtf(dot(shadow, shadow));
    let footprint = pitch_rad * centre[2];
    area / ((footprint * footprint) * centre[2])
}
