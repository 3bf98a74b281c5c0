//! What stands in the middle of a scene: a fruit of a drawn size, or something that is none.

use super::{
    draws::Draws,
    patch::Body,
    shapes::{Pose, Shape, V3},
};

/// A kind of body, from which a seed draws one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Subject {
    /// A fruit: semi-axes drawn around these means with these standard deviations of the logarithms.
    Fruit {
        /// Mean semi-axes, mm.
        mean_mm: V3,
        /// Standard deviation of `ln a`.
        sd_long: f64,
        /// Standard deviation of `(ln b + ln c) / 2`.
        sd_short: f64,
        /// Standard deviation of `ln b - ln c`.
        sd_ratio: f64,
        /// Exponent of the super-ellipsoid, 2 = ellipsoid.
        exponent: f64,
    },
    /// A ball of this radius range, mm.
    Ball(f64, f64),
    /// A flat ellipse in the fruit's colour with the fruit's outline.
    Disc,
    /// A branch in the fruit's colour, radius range in mm.
    Branch(f64, f64),
}

/// Semi-axes of a Lingwu long jujube, mm.
const JUJUBE_MM: V3 = [21.75, 10.9, 10.9];

/// The jujube of the paper: 22 x 11 x 11 mm, spread as in the size prior.
pub const JUJUBE: Subject = scaled_jujube(1.0);

/// Jujubes whose size varies by 15 % (standard deviation) as a whole and by 6 % in shape.
pub const VARIED_JUJUBE: Subject =
    Subject::Fruit { mean_mm: JUJUBE_MM, sd_long: 0.15, sd_short: 0.15, sd_ratio: 0.058, exponent: 2.0 };

/// A jujube scaled by a factor.
pub const fn scaled_jujube(factor: f64) -> Subject {
    let [a, b, c] = JUJUBE_MM;
    Subject::Fruit {
        mean_mm: [a * factor, b * factor, c * factor],
        sd_long: 0.035,
        sd_short: 0.042,
        sd_ratio: 0.058,
        exponent: 2.0,
    }
}

/// A jujube with the shape of a super-ellipsoid.
pub const fn boxy_jujube(exponent: f64) -> Subject {
    Subject::Fruit { mean_mm: JUJUBE_MM, sd_long: 0.035, sd_short: 0.042, sd_ratio: 0.058, exponent }
}

/// Sizes are cut off at this many standard deviations, so that every fruit is within the prior.
const TRUNCATION: f64 = 3.0;
/// Above this deviation of `ln a` the size varies as a whole: length and thickness together.
const WHOLE_SIZE: f64 = 0.1;

impl Subject {
    /// One of the kind at `centre`, turned at random.
    pub(super) fn body(&self, centre: V3, draws: &mut Draws) -> Body {
        let axes = draws.rotation();
        let shape = match *self {
            Self::Fruit { mean_mm, sd_long, sd_short, sd_ratio, exponent } => {
                let mut bounded = |sd: f64| sd * draws.normal().clamp(-TRUNCATION, TRUNCATION);
                let (long, short, ratio) = (bounded(sd_long), bounded(sd_short), bounded(sd_ratio));
                let short = if sd_long > WHOLE_SIZE { long + 0.3 * short } else { short };
                let half = 0.5 * libm::fabs(ratio);
                let logarithms = [long, short + half, short - half];
                let semi_axes = core::array::from_fn(|k| mean_mm[k] * libm::exp(logarithms[k]));
                Shape::Superellipsoid { semi_axes, exponent }
            }
            Self::Ball(low, high) => {
                Shape::Superellipsoid { semi_axes: [draws.uniform(low, high); 3], exponent: 2.0 }
            }
            Self::Disc => Shape::Disc { radii: [JUJUBE_MM[0], JUJUBE_MM[1]] },
            Self::Branch(low, high) => {
                Shape::Cylinder { radius: draws.uniform(low, high), half_length: draws.uniform(60.0, 200.0) }
            }
        };
        Body { pose: Pose { centre, axes }, shape, fruit_coloured: true }
    }
}
