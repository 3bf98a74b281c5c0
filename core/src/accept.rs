//! Accept or refuse: each test has a physical meaning, a value and a limit.
//!
//! A robot reaches for what is accepted. What the picture does not carry is refused with the first test it fails, in
//! the order of [`RefusalCode`].

use crate::{ConfigError, Ellipsoid, config::require, jacobi::Symmetric3};

/// Why a target is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RefusalCode {
    /// Fewer points explained than the limit.
    FewPoints,
    /// The points want another size than the prior allows: a chi-squared of three degrees of freedom.
    SizeConflict,
    /// The view does not tell the size: relative standard deviation of the whole size from the view alone.
    SizeUnknown,
    /// Another fit a little aside explains nearly as much: its share of the score.
    Ambiguous,
    /// The outline does not fit: mean of `min(|f|, 3)` over the outline rays.
    Outline,
    /// Too little of it is seen: explained over predicted pixels.
    Visible,
    /// Too much of it has another colour: share of the explained points outside the mask.
    Colour,
    /// The centre is too uncertain: its largest standard deviation, mm.
    Uncertain,
    /// The points are as well a plane: rms distance from the best plane over that from the model.
    Flat,
    /// Too much is seen through it: points seen through over points explained.
    Through,
    /// It shares volume with a target found before: contact function, 1 = touching.
    SharedVolume,
    /// The normal equations are singular; no value.
    Singular,
    /// The points are as well uniform clutter: gain in log-likelihood for each point.
    Clutter,
    /// Too little of the surface is covered: share of it.
    Coverage,
    /// The body is no ellipsoid: rms of the residuals that depends on where on the surface they are, over the shortest
    /// semi-axis.
    Shape,
    /// The centre is too uncertain: its largest standard deviation over the shortest semi-axis.
    Vague,
}

impl RefusalCode {
    /// Its name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::FewPoints => "few_points",
            Self::SizeConflict => "size_conflict",
            Self::SizeUnknown => "size_unknown",
            Self::Ambiguous => "ambiguous",
            Self::Outline => "outline",
            Self::Visible => "visible",
            Self::Colour => "colour",
            Self::Uncertain => "uncertain",
            Self::Flat => "flat",
            Self::Through => "through",
            Self::SharedVolume => "shared_volume",
            Self::Singular => "singular",
            Self::Clutter => "clutter",
            Self::Coverage => "coverage",
            Self::Shape => "shape",
            Self::Vague => "vague",
        }
    }
}

/// A failed test: for some codes the value is above the limit, for others below.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Refusal {
    /// Which test.
    pub code: RefusalCode,
    /// What was measured.
    pub value: f32,
    /// What is allowed.
    pub limit: f32,
}

/// Limits of the tests; infinity (or zero, for lower limits) switches a test off.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Gate {
    /// Explained points at least.
    pub min_points: u16,
    /// Upper limit of [`RefusalCode::SizeConflict`].
    pub size_conflict: f32,
    /// The same for a fruit seen from its end, which looks like a ball there: see [`Findings::end_on`].
    pub size_conflict_end_on: f32,
    /// Upper limit of [`RefusalCode::SizeUnknown`].
    pub size_unknown: f32,
    /// Upper limit of [`RefusalCode::Ambiguous`].
    pub ambiguous: f32,
    /// Upper limit of [`RefusalCode::Outline`], where there are at least six rays.
    pub outline: f32,
    /// Lower limit of [`RefusalCode::Visible`].
    pub visible: f32,
    /// Upper limit of [`RefusalCode::Colour`].
    pub colour: f32,
    /// Upper limit of [`RefusalCode::Uncertain`], mm.
    pub uncertain_mm: f32,
    /// Lower limit of [`RefusalCode::Flat`].
    pub flat: f32,
    /// Upper limit of [`RefusalCode::Through`].
    pub through: f32,
    /// Lower limit of [`RefusalCode::SharedVolume`].
    pub shared_volume: f32,
}

impl Gate {
    /// The default, for fruit of a jujube's size; see [`Self::scaled`]. On 5000 mixed views (`varsac experiment calibration`: 0.5 to
    /// 1.3 m, to 60 % covered, neighbours, leaves) it accepted 86 % with outline rays, 0.07 % of them wrong by more than 5 mm, and 70 %
    /// without, 0.18 % of them wrong. Of fruit of 0.7 and 1.3 times the size it took 3 and 1.3 % for jujubes, of balls and branches none.
    pub const BALANCED: Self = Self {
        min_points: 20,
        size_conflict: 10.0,
        size_conflict_end_on: 5.0,
        size_unknown: 0.14,
        ambiguous: 0.94,
        outline: 1.2,
        visible: 0.36,
        colour: 0.36,
        uncertain_mm: 1.9,
        flat: 1.3,
        through: 0.15,
        shared_volume: 0.75,
    };

    /// Tighter limits. On the same views: 62 % accepted with outline rays, 0.03 % of them wrong; 45 and 0.07 % without.
    pub const STRICT: Self = Self {
        size_conflict: 7.0,
        size_conflict_end_on: 3.5,
        size_unknown: 0.10,
        ambiguous: 0.90,
        outline: 1.0,
        visible: 0.50,
        uncertain_mm: 1.3,
        ..Self::BALANCED
    };

    /// Looser limits. On the same views: 94 % accepted with outline rays, 0.44 % of them wrong; 82 and 0.67 % without. Fruit of other
    /// sizes and balls pass by the tenth.
    pub const EAGER: Self = Self {
        size_conflict: 14.0,
        size_conflict_end_on: 14.0,
        size_unknown: 0.15,
        ambiguous: 0.97,
        outline: 1.5,
        visible: 0.25,
        uncertain_mm: 3.0,
        ..Self::BALANCED
    };

    /// The same for fruit with this shortest semi-axis, mm: what is a length is scaled.
    pub const fn scaled(self, short_mm: f32) -> Self {
        Self { uncertain_mm: self.uncertain_mm * (short_mm / Self::SHORT_MM), ..self }
    }

    /// Shortest semi-axis of the fruit for which the constants of this type are given, mm.
    const SHORT_MM: f32 = 10.9;

    pub(crate) fn check(&self) -> Result<(), ConfigError> {
        let limits = [
            ("map.gate.size_conflict", self.size_conflict),
            ("map.gate.size_conflict_end_on", self.size_conflict_end_on),
            ("map.gate.size_unknown", self.size_unknown),
            ("map.gate.ambiguous", self.ambiguous),
            ("map.gate.outline", self.outline),
            ("map.gate.visible", self.visible),
            ("map.gate.colour", self.colour),
            ("map.gate.uncertain_mm", self.uncertain_mm),
            ("map.gate.flat", self.flat),
            ("map.gate.through", self.through),
            ("map.gate.shared_volume", self.shared_volume),
        ];
        for (field, value) in limits {
            require(value >= 0.0, field, value, "0 or more; infinity or 0 switches a test off")?;
        }
        Ok(())
    }
}

/// What the tests look at.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Findings {
    /// Points explained.
    pub explained: u16,
    /// Points seen through.
    pub through: u16,
    /// Conflict of the view with the size prior, chi-squared of three degrees of freedom.
    pub size_conflict: f32,
    /// Cosine between the long axis and the ray of the centre, 0 for a body that is round or has no viewpoint. Above
    /// [`END_ON`] the fruit is seen from its end.
    pub end_on: f32,
    /// Relative standard deviation of the whole size as the view alone tells it.
    pub size_sigma: f32,
    /// Score of the best rival over the score.
    pub rival: f32,
    /// Outline rays that can be the model's.
    pub outline_rays: u16,
    /// Mean of `min(|f|, 3)` over them.
    pub outline: f32,
    /// Points on the surface, in the mask or not, over predicted pixels; infinite where the pitch is not known.
    pub visible: f32,
    /// Share of the explained points outside the mask.
    pub colour: f32,
    /// Largest standard deviation of the centre, mm; infinite when the normal equations are singular.
    pub sigma_mm: f32,
    /// Rms distance from the best plane over that from the model.
    pub flat: f32,
    /// Contact function with the nearest target found before; infinite without one.
    pub separation: f32,
    /// Points near the model that it does not explain, over those it does.
    pub clutter: f32,
}

impl Findings {
    /// The same with what is no number replaced by the worst value: the bits of such a number differ between machines.
    pub(crate) fn known(self) -> Self {
        let high = |value: f32| if value.is_nan() { f32::INFINITY } else { value };
        let low = |value: f32| if value.is_nan() { 0.0 } else { value };
        Self {
            size_conflict: high(self.size_conflict),
            end_on: high(self.end_on),
            size_sigma: high(self.size_sigma),
            rival: high(self.rival),
            outline: high(self.outline),
            visible: low(self.visible),
            colour: high(self.colour),
            sigma_mm: high(self.sigma_mm),
            flat: low(self.flat),
            separation: low(self.separation),
            clutter: high(self.clutter),
            ..self
        }
    }
}

/// A fruit whose long axis is within about 32 degrees of the ray is seen from its end.
pub const END_ON: f32 = 0.85;

/// Outline rays needed for the outline test.
pub const MIN_OUTLINE: u16 = 6;

impl Gate {
    /// The first test that fails, in the order of [`RefusalCode`].
    pub fn refusal(&self, f: &Findings) -> Option<Refusal> {
        let above =
            |code, value: f32, limit: f32| (!(value <= limit)).then_some(Refusal { code, value, limit });
        let below =
            |code, value: f32, limit: f32| (!(value >= limit)).then_some(Refusal { code, value, limit });
        let through = f32::from(f.through) / if f.explained > 0 { f32::from(f.explained) } else { 1.0 };
        let conflict_limit = if f.end_on > END_ON { self.size_conflict_end_on } else { self.size_conflict };
        below(RefusalCode::FewPoints, f32::from(f.explained), f32::from(self.min_points))
            .or_else(|| above(RefusalCode::SizeConflict, f.size_conflict, conflict_limit))
            .or_else(|| above(RefusalCode::SizeUnknown, f.size_sigma, self.size_unknown))
            .or_else(|| above(RefusalCode::Ambiguous, f.rival, self.ambiguous))
            .or_else(|| {
                if f.outline_rays < MIN_OUTLINE {
                    None
                } else {
                    above(RefusalCode::Outline, f.outline, self.outline)
                }
            })
            .or_else(|| below(RefusalCode::Visible, f.visible, self.visible))
            .or_else(|| above(RefusalCode::Colour, f.colour, self.colour))
            .or_else(|| above(RefusalCode::Uncertain, f.sigma_mm, self.uncertain_mm))
            .or_else(|| below(RefusalCode::Flat, f.flat, self.flat))
            .or_else(|| above(RefusalCode::Through, through, self.through))
            .or_else(|| below(RefusalCode::SharedVolume, f.separation, self.shared_volume))
    }
}

/// Points of the search for the maximum in [`contact_function`].
const LAMBDAS: u32 = 15;

/// How far two ellipsoids are apart: `sqrt(max over l in (0, 1) of l (1 - l) d^T [(1 - l) A + l B]^-1 d)` with `d` from
/// centre to centre and `A = R_a^T diag(a^2, b^2, c^2) R_a`; 1 where they touch, smaller where they share volume (Perram
/// and Wertheim 1985). The maximum is taken over `l = 1/16 .. 15/16`: a slightly smaller value, to the careful side.
pub fn contact_function(first: &Ellipsoid, second: &Ellipsoid) -> f32 {
    let d = [
        second.centre.x - first.centre.x,
        second.centre.y - first.centre.y,
        second.centre.z - first.centre.z,
    ];
    let (a, b) = (extent(first), extent(second));
    let mut largest = 0.0;
    for k in 1..=LAMBDAS {
        let l = k as f32 / (LAMBDAS + 1) as f32;
        let m = 1.0 - l;
        let mix = Symmetric3 {
            xx: m * a.xx + l * b.xx,
            yy: m * a.yy + l * b.yy,
            zz: m * a.zz + l * b.zz,
            xy: m * a.xy + l * b.xy,
            xz: m * a.xz + l * b.xz,
            yz: m * a.yz + l * b.yz,
        };
        let g = mix.adjugate().times(d);
        let value = (l * m) * ((d[0] * g[0] + d[1] * g[1] + d[2] * g[2]) / mix.determinant());
        if value > largest {
            largest = value;
        }
    }
    libm::sqrtf(largest)
}

/// `R^T diag(a^2, b^2, c^2) R`.
fn extent(ellipsoid: &Ellipsoid) -> Symmetric3 {
    let mut sum = Symmetric3::default();
    for (semi_axis, r) in ellipsoid.semi_axes.iter().zip(ellipsoid.axes) {
        let s = semi_axis * semi_axis;
        sum.xx += s * (r[0] * r[0]);
        sum.yy += s * (r[1] * r[1]);
        sum.zz += s * (r[2] * r[2]);
        sum.xy += s * (r[0] * r[1]);
        sum.xz += s * (r[0] * r[2]);
        sum.yz += s * (r[1] * r[2]);
    }
    sum
}
