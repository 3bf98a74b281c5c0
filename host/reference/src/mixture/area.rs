//! The surface area of an ellipsoid, after Thomsen: contract, chapter X5.

use crate::fault::{self, Fault};
use crate::map::algebra::Vector;

/// Logarithm of the area, and its slopes along the logarithms of the semi-axes.
pub(crate) struct Area {
    pub(crate) ln: f32,
    pub(crate) slopes: [f32; 3],
}

impl Area {
    /// X5: of the logarithms of the semi-axes.
    pub(crate) fn of([x1, x2, x3]: Vector) -> Self {
        const G: f32 = 1.0 / 1.6075;
        const THIRD: f32 = 1.0 / 3.0;
        let power = |sum: f32| libm::expf(1.6075 * sum);
        let (ab, bc, ca) = (power(x1 + x2), power(x2 + x3), power(x3 + x1));
        let t = (ab + bc) + ca;
        let i = 1.0 / t;
        let mean = if fault::is(Fault::Area) { t / 3.0 } else { t * THIRD };
        Self { ln: 2.531_024_2 + G * libm::logf(mean), slopes: [(ab + ca) * i, (ab + bc) * i, (bc + ca) * i] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_has_four_pi_r_squared() {
        let area = Area::of([libm::logf(3.0); 3]);
        assert!((libm::expf(area.ln) - 4.0 * std::f32::consts::PI * 9.0).abs() < 1e-3);
        assert!(area.slopes.iter().all(|slope| (slope - 2.0 / 3.0).abs() < 1e-6));
    }
}
