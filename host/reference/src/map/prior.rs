//! What is known of the size, and the terms of a fit: contract, chapter M2.

use super::algebra::{Vector, dot, product};
use super::view::{MapConfig, Noise, Viewpoint};
use crate::Symmetric;
use crate::fault::{self, Fault};

/// A prior of the logarithms of the semi-axes: mean `m` and information `P`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Prior {
    pub(crate) mean: Vector,
    pub(crate) information: Symmetric,
}

impl Prior {
    /// M2: the prior term of spreads.
    fn of(semi_axes: Vector, spread: Vector, spread_ab: f32, spread_bc: f32) -> Self {
        let information = |s: f32| 1.0 / (s * s);
        let [a, b, c] = spread.map(information);
        let (ab, bc) = (information(spread_ab), information(spread_bc));
        let zz = if fault::is(Fault::Prior) { c } else { c + bc };
        Self {
            mean: semi_axes.map(libm::logf),
            information: Symmetric { xx: a + ab, yy: (b + ab) + bc, zz, xy: -ab, xz: 0.0, yz: -bc },
        }
    }

    /// M2: the spreads of the configuration.
    pub(crate) fn tight(config: &MapConfig) -> Self {
        Self::of(config.semi_axes, config.spread, config.spread_ab, config.spread_bc)
    }

    /// M2: the same mean, and hardly any knowledge.
    pub(crate) fn loose(config: &MapConfig) -> Self {
        let spread = if fault::is(Fault::Loose) { 0.5 } else { 1.0 };
        Self::of(config.semi_axes, [spread; 3], f32::INFINITY, f32::INFINITY)
    }

    /// `x - m`.
    pub(crate) fn departure(&self, x: Vector) -> Vector {
        [x[0] - self.mean[0], x[1] - self.mean[1], x[2] - self.mean[2]]
    }

    /// `d P d`.
    pub(crate) fn cost(&self, x: Vector) -> f32 {
        let d = self.departure(x);
        dot(d, product(&self.information, d))
    }
}

/// What a fit assumes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Terms {
    pub(crate) prior: Prior,
    pub(crate) noise: Noise,
    /// Factor on the deviations of outline rays.
    pub(crate) wider: f32,
    /// Half-width in depth of what belongs to a surface, mm.
    pub(crate) window: f32,
    /// Deviation of the displacement common to all rays, rad.
    pub(crate) offset: f32,
    /// Deviation of the boxiness.
    pub(crate) boxiness: f32,
    /// How much a point tells.
    pub(crate) told: f32,
    pub(crate) viewpoint: Viewpoint,
}

impl Terms {
    /// M2: the assumed terms.
    pub(crate) fn assumed(config: &MapConfig) -> Self {
        Self {
            prior: Prior::tight(config),
            noise: config.noise,
            wider: 1.0,
            window: 0.55 * config.short(),
            offset: config.outline_offset,
            boxiness: 0.0,
            told: config.independence,
            viewpoint: config.viewpoint,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_infinite_spread_is_no_term() {
        let prior = Prior::of([2.0, 1.0, 1.0], [0.5, 0.5, 0.5], f32::INFINITY, 0.25);
        let expected = Symmetric { xx: 4.0, yy: 20.0, zz: 20.0, xy: -0.0, xz: 0.0, yz: -16.0 };
        assert_eq!(prior.information, expected);
        assert!(prior.information.xy.is_sign_negative());
        assert_eq!(prior.cost(prior.mean), 0.0);
        let [a, b, c] = prior.mean;
        // One deviation of a alone costs one; b and c together leave their ratio as it is.
        assert_eq!(prior.cost([a + 0.5, b, c]), 1.0);
        assert_eq!(prior.cost([a, b + 0.5, c + 0.5]), 2.0);
    }
}
