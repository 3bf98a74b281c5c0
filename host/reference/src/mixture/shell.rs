//! A surface with a noise and a share of the points: contract, chapter X5.

use super::area::Area;
use super::look::Distance;
use super::numbers::{longest_ln, within};
use crate::fault::{self, Fault};
use crate::map::model::{Estimate, Model};
use crate::map::view::{Noise, Viewpoint};

/// Estimate, noise and share, all in local units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shell {
    pub(crate) estimate: Estimate,
    pub(crate) sigma: f32,
    /// `w`.
    pub(crate) share: f32,
}

impl Shell {
    /// X5: the model, as the distance wants it.
    pub(crate) fn model(&self, distance: Distance) -> Model {
        let axial = self.sigma;
        let (lateral, viewpoint) = match distance {
            Distance::Ray { ratio } => (ratio * self.sigma, Viewpoint::Origin),
            Distance::Radial | Distance::Orthogonal => (0.0, Viewpoint::None),
        };
        Model::new(&self.estimate, Noise { axial, lateral }, viewpoint)
    }

    /// `lnA` at the estimate.
    pub(crate) fn ln_area(&self) -> f32 {
        Area::of(self.estimate.x).ln
    }

    /// X5: the odds `K` for a given `lnA`, in a clutter of this volume.
    pub(crate) fn odds(&self, ln_area: f32, volume: f32) -> f32 {
        let density = libm::expf(-(ln_area + 0.918_938_5));
        if fault::is(Fault::Odds) {
            return ((self.share * volume) / (1.0 - self.share)) * density / self.sigma;
        }
        let f = density / self.sigma;
        ((self.share * volume) / (1.0 - self.share)) * f
    }
}

/// X7: the estimate with its semi-axes held within limits.
pub(crate) fn held(estimate: &Estimate) -> Estimate {
    const MOST: f32 = 1.791_759_5;
    let l = longest_ln(estimate.x);
    let l = if l < MOST { l } else { MOST };
    let b = l - 3.401_197_4;
    let b = if b > -4.605_170_2 { b } else { -4.605_170_2 };
    Estimate { x: estimate.x.map(|x| within(x, b, MOST)), ..*estimate }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_semi_axis_is_longer_than_six_or_shorter_than_a_thirtieth_of_the_longest() {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let of = |x| held(&Estimate { centre: [0.0; 3], axes, x, boxiness: 0.0 }).x.map(libm::expf);
        let near = |found: [f32; 3], expected: [f32; 3]| {
            assert!(found.iter().zip(expected).all(|(f, e)| (f / e - 1.0).abs() < 1e-5), "{found:?}");
        };
        near(of([3.0, -9.0, 0.0]), [6.0, 0.2, 1.0]);
        near(of([-9.0, -2.0, -2.0]), [0.01, libm::expf(-2.0), libm::expf(-2.0)]);
    }
}
