//! How well a hypothesis explains what the camera saw: points on it count for it, points seen through it against it.
//!
//! Each point has the squared residual `f^2 = F^2 / var` at the model's point ([`crate::residual`]):
//! * `f^2 < 6.25` (2.5 standard deviations) and not further from the model's point than `window_mm`: explained, `1 - f^2 / 6.25`;
//! * behind the surface, the ray passing well inside the model: it was seen *through* the model, `-1.5`;
//! * anything else, in front of it (a leaf) or beside it: nothing.

use crate::{Point3, point::at, residual::{Contact, RayModel}};

/// `2.5^2`.
pub const CUT: f32 = 6.25;
/// Price of a point seen through the model.
pub const VIOLATION: f32 = 1.5;

/// What a point says about a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Evidence {
    /// On the surface, with its squared residual.
    Explained(f32),
    /// Seen through it.
    Through,
    /// In front of it or beside it.
    Unrelated,
}

/// Judges one contact.
#[inline(always)]
pub fn judge(contact: &Contact, window: f32) -> Evidence {
    let square = (contact.value * contact.value) / contact.variance;
    if square < CUT && contact.gap < window && contact.gap > -window {
        Evidence::Explained(square)
    } else if contact.gap > 0.0 && square >= CUT && contact.miss_squared < 0.75 {
        Evidence::Through
    } else {
        Evidence::Unrelated
    }
}

/// Support of a model in the listed points.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Support {
    /// Sum of the evidence.
    pub score: f32,
    /// Points explained.
    pub explained: u16,
    /// Points seen through.
    pub through: u16,
}

/// Scores the listed points; gives up (and returns `None`) as soon as `floor` cannot be exceeded any more.
pub fn support(cloud: &[Point3], members: &[u16], model: &RayModel, window: f32, floor: f32) -> Option<Support> {
    let mut support = Support::default();
    let mut left = members.len() as f32;
    for &index in members {
        match judge(&model.contact(&at(cloud, index)), window) {
            Evidence::Explained(square) => {
                support.score += 1.0 - square / CUT;
                support.explained += 1;
            }
            Evidence::Through => {
                support.score -= VIOLATION;
                support.through += 1;
            }
            Evidence::Unrelated => {}
        }
        left -= 1.0;
        if support.score + left <= floor {
            return None;
        }
    }
    Some(support)
}
