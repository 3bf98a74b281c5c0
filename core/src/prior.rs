//! What is known of the size before looking: a normal distribution of the logarithms of the semi-axes.
//!
//! With `x = (ln a, ln b, ln c)`, `m` the logarithms of the mean semi-axes and standard deviations `s` the cost is
//! `1/2 [ sum_k ((x_k - m_k) / s_k)^2 + ((x_1 - x_2 - m_1 + m_2) / s_ab)^2 + ((x_2 - x_3 - m_2 + m_3) / s_bc)^2 ]`
//! `= 1/2 (x - m)^T P (x - m)`; `P` is the information, a symmetric 3x3 matrix made once. The two terms on ratios say
//! that a fruit larger than the mean is larger in all directions. A one-sided view shows the far half of nothing:
//! this is what holds it.

use crate::jacobi::Symmetric3;

/// Size of a kind of fruit: mean semi-axes in millimetres, longest first, and relative spreads.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SizePrior {
    /// Mean semi-axes `a >= b >= c`, millimetres.
    pub semi_axes_mm: [f32; 3],
    /// Standard deviations of `ln a, ln b, ln c`; 0.05 is 5 %.
    pub spread: [f32; 3],
    /// Standard deviation of `ln (a / b)`; infinity: no such term.
    pub spread_ab: f32,
    /// Standard deviation of `ln (b / c)`; infinity: no such term.
    pub spread_bc: f32,
}

/// The prior in the form the fit uses: mean logarithms and information.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SizeTerm {
    /// `m`.
    pub mean_ln: [f32; 3],
    /// `P`.
    pub information: Symmetric3,
}

impl SizePrior {
    /// Lingwu long jujube, 43.5 x 21.8 x 21.8 mm. Source: the paper (size range of Table 5, roundness of Fig. 3).
    pub const JUJUBE: Self = Self {
        semi_axes_mm: [21.75, 10.9, 10.9],
        spread: [0.035, 0.06, 0.06],
        spread_ab: f32::INFINITY,
        spread_bc: 0.08,
    };

    /// Apple, 72 mm across and 69 mm high with 8 and 12 % deviation, their quotient with 7 %. Source: calipers of 26 Fuji apples,
    /// GRAP-UdL-AT/ak_sw_benchmarker. Mean and spread are a little wider, for what cameras make of it and for other kinds.
    pub const APPLE: Self = Self::of([38.0, 37.0, 34.0], 0.12, 0.07, 0.10);
    /// Tomato, round: 47 to 102 mm across are the size classes of UNECE standard FFV-36; flattened along the core.
    pub const TOMATO: Self = Self::of([35.0, 34.0, 29.0], 0.14, 0.05, 0.10);
    /// Lemon, about 66 x 54 x 53 mm: a scanned one has 65 x 54 x 53 (YCB model set, Calli et al. 2015); 45 mm and more are the size
    /// classes of UNECE standard FFV-14.
    pub const LEMON: Self = Self::of([33.0, 27.0, 26.5], 0.10, 0.10, 0.04);
    /// Kiwi fruit, about 62 x 49 x 45 mm: the mean of small Hayward fruit (72 g) is 59.4 x 46.3 x 42.9 mm (Celik, Ercisli and Turgut
    /// 2007); traded ones are larger.
    pub const KIWI: Self = Self::of([31.0, 24.5, 22.6], 0.08, 0.08, 0.06);
    /// Hen's egg, 57 x 44 mm, with deviations of 3.6 and 2.8 % and of their quotient 3.8 % (250 eggs of ISA Brown hens, Acta
    /// Universitatis Agriculturae et Silviculturae Mendelianae Brunensis 2008); wider here for other breeds.
    pub const EGG: Self = Self::of([28.5, 22.0, 21.9], 0.05, 0.05, 0.02);
    /// Cherry tomato: less than 40 mm across by UNECE standard FFV-36, from round to grape-shaped.
    pub const CHERRY_TOMATO: Self = Self::of([14.5, 13.3, 13.0], 0.15, 0.12, 0.05);

    /// Fruit whose size varies as a whole by `spread` and whose proportions vary by `spread_ab` and `spread_bc`. (Three semi-axes,
    /// each with its own term, tell the common size three times: each deviation is `sqrt 3` times that of the whole.)
    pub const fn of(semi_axes_mm: [f32; 3], spread: f32, spread_ab: f32, spread_bc: f32) -> Self {
        Self { semi_axes_mm, spread: [1.732_050_8 * spread; 3], spread_ab, spread_bc }
    }

    /// The same with another spread of the whole size.
    pub const fn with_spread(self, spread: f32) -> Self {
        Self { spread: [spread; 3], ..self }
    }

    /// Logarithms and information, computed once.
    pub fn term(&self) -> SizeTerm {
        let inverse_square = |s: f32| 1.0 / (s * s);
        let [a, b, c] = self.spread.map(inverse_square);
        let (ab, bc) = (inverse_square(self.spread_ab), inverse_square(self.spread_bc));
        SizeTerm {
            mean_ln: self.semi_axes_mm.map(libm::logf),
            information: Symmetric3 { xx: a + ab, yy: (b + ab) + bc, zz: c + bc, xy: -ab, xz: 0.0, yz: -bc },
        }
    }
}

impl SizeTerm {
    /// `x - m`.
    #[inline]
    pub fn departure(&self, ln_axes: &[f32; 3]) -> [f32; 3] {
        let [a, b, c] = *ln_axes;
        let [ma, mb, mc] = self.mean_ln;
        [a - ma, b - mb, c - mc]
    }

    /// Twice the cost: `(x - m)^T P (x - m)`, summed a, b, c.
    pub fn cost(&self, ln_axes: &[f32; 3]) -> f32 {
        let d = self.departure(ln_axes);
        let [a, b, c] = self.information.times(d);
        d[0] * a + d[1] * b + d[2] * c
    }
}
