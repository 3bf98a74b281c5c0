//! The colour gate (paper III.B.1): is the hue of a pixel within a range of the HSV circle?
//!
//! Exact in integers and without a division. In hue the boundary at h degrees is a plane through the grey axis of the
//! RGB cube: for h in 0..60, where R >= G >= B, the pixel's hue is at least h when 60 (G - B) - h (R - B) >= 0, and so
//! on around the circle. A range is therefore two signs, joined by "and" when it is at most half the circle, by "or"
//! when it is more. Signs do not change when a colour is scaled, so that the gate takes *sums* of colours as well:
//! the mean filter before it needs no division either.
//!
//! A grey pixel (R = G = B) has no hue and never passes.

use crate::error::InputError;

/// Hues from `from_deg` upwards through `to_deg`, both included, whole degrees 0..=360, red 0, green 120, blue 240.
/// With `from_deg > to_deg` the range passes through 360: the paper's "0-36 or 252-360" is 252 to 36.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HueRange {
    /// First hue of the range, degrees.
    pub from_deg: u16,
    /// Last hue of the range, degrees.
    pub to_deg: u16,
}

/// What a pixel's colour must be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ColourGate {
    /// Hues that pass.
    pub hue: HueRange,
    /// Least saturation, (max - min) / max of the three channels, percent. 0 in the paper.
    pub saturation_min_percent: u8,
    /// Least value, the largest of the three channels, 0..=255. 0 in the paper.
    pub value_min: u8,
}

impl HueRange {
    /// Width of the range, degrees.
    fn width_deg(self) -> i32 {
        let width = i32::from(self.to_deg) - i32::from(self.from_deg);
        if width < 0 { width + 360 } else { width }
    }
}

/// A plane through the grey axis: p (R - B) + q (G - B), positive on the side of the larger hues.
#[derive(Debug, Clone, Copy)]
struct Boundary {
    p: i16,
    q: i16,
}

impl Boundary {
    fn at(hue_deg: i16) -> Self {
        let h = hue_deg % 180;
        let (p, q) = match h {
            0..60 => (-h, 60),
            60..120 => (-60, 120 - h),
            _ => (h - 180, 120 - h),
        };
        // The opposite hue lies on the same plane, seen from the other side.
        if (hue_deg / 180) % 2 == 0 { Self { p, q } } else { Self { p: -p, q: -q } }
    }

    /// Its sign tells the side.
    #[inline(always)]
    fn side(self, r_minus_b: i16, g_minus_b: i16) -> i32 {
        i32::from(self.p) * i32::from(r_minus_b) + i32::from(self.q) * i32::from(g_minus_b)
    }
}

/// A [`ColourGate`] made ready for many pixels.
#[derive(Debug, Clone, Copy)]
pub struct Gate {
    from: Boundary,
    to: Boundary,
    /// All bits set: at most half the circle, both signs must agree. No bit set: one suffices.
    both: i32,
    saturation_min_percent: i16,
    value_min: i16,
}

impl Gate {
    /// Prepares a gate.
    ///
    /// # Errors
    /// A hue beyond 360 degrees, an empty range (both ends the same hue), or a saturation beyond 100 %.
    pub fn new(gate: &ColourGate) -> Result<Self, InputError> {
        let HueRange { from_deg, to_deg } = gate.hue;
        let width = gate.hue.width_deg();
        if from_deg > 360 || to_deg > 360 || width == 0 {
            return Err(InputError::at(
                "hue range",
                format!("is {from_deg}..{to_deg} degrees"),
                "give two different hues between 0 and 360; a range may pass through 360, like 252..36",
            ));
        }
        if gate.saturation_min_percent > 100 {
            return Err(InputError::at(
                "least saturation",
                format!("is {} percent", gate.saturation_min_percent),
                "give 0 to 100",
            ));
        }
        Ok(Self {
            from: Boundary::at(from_deg as i16),
            to: Boundary::at(to_deg as i16),
            both: if width <= 180 { -1 } else { 0 },
            saturation_min_percent: i16::from(gate.saturation_min_percent),
            value_min: i16::from(gate.value_min),
        })
    }

    /// Whether the mean of `count` pixels passes whose channels add up to `r`, `g`, `b`: at most 128 pixels, so that no
    /// sum and no product leaves its type. A single pixel is its own sum, with a count of 1.
    #[inline(always)]
    pub fn passes(&self, r: i16, g: i16, b: i16, count: i16) -> bool {
        let max = r.max(g).max(b);
        let chroma = max - r.min(g).min(b);
        let above = self.from.side(r - b, g - b);
        let below = -self.to.side(r - b, g - b);
        // Each condition holds when its number is not negative: signs are joined, not truths, so that the compiler
        // can take many pixels at a time.
        let hue = (above & below) | ((above | below) & self.both);
        let saturation = 100 * i32::from(chroma) - i32::from(self.saturation_min_percent) * i32::from(max);
        let rest = (chroma - 1) | (max - self.value_min * count);
        (hue | saturation | i32::from(rest)) >= 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gate(from_deg: u16, to_deg: u16) -> ColourGate {
        ColourGate { hue: HueRange { from_deg, to_deg }, saturation_min_percent: 0, value_min: 0 }
    }

    /// Hue as the textbook has it, as a fraction of degrees: (numerator, denominator > 0); nothing for grey.
    fn textbook_hue(r: i32, g: i32, b: i32) -> Option<(i32, i32)> {
        let max = r.max(g).max(b);
        let chroma = max - r.min(g).min(b);
        if chroma == 0 {
            return None;
        }
        let numerator = if max == r {
            60 * (g - b)
        } else if max == g {
            120 * chroma + 60 * (b - r)
        } else {
            240 * chroma + 60 * (r - g)
        };
        Some((if numerator < 0 { numerator + 360 * chroma } else { numerator }, chroma))
    }

    #[test]
    fn agrees_with_the_textbook_over_the_whole_cube() {
        for (from, to) in
            [(252, 36), (0, 36), (252, 360), (40, 70), (60, 240), (100, 99), (350, 20), (200, 100)]
        {
            let prepared = Gate::new(&gate(from, to)).unwrap();
            let (from, to) = (i32::from(from), i32::from(to));
            let mut passed = 0;
            for r in (0..=255).step_by(5) {
                for g in (0..=255).step_by(3) {
                    for b in (0..=255).step_by(5) {
                        let expected = textbook_hue(r, g, b).is_some_and(|(h, chroma)| {
                            let (above, below) = (h >= from * chroma, h <= to * chroma);
                            // Hue 0 is hue 360.
                            let full_turn = h == 0 && (from <= 360 && to == 360);
                            if from <= to { (above && below) || full_turn } else { above || below }
                        });
                        assert_eq!(
                            prepared.passes(r as i16, g as i16, b as i16, 1),
                            expected,
                            "{r} {g} {b} in {from}..{to}"
                        );
                        passed += i32::from(expected);
                    }
                }
            }
            assert!(passed > 1000);
        }
    }

    #[test]
    fn grey_has_no_hue() {
        let prepared = Gate::new(&gate(0, 360 - 1)).unwrap();
        for level in 0..=255 {
            assert!(!prepared.passes(level, level, level, 1));
        }
    }

    #[test]
    fn floors_are_inclusive_and_the_value_floor_is_of_the_mean() {
        let colour_gate = ColourGate { saturation_min_percent: 50, value_min: 100, ..gate(252, 36) };
        let prepared = Gate::new(&colour_gate).unwrap();
        assert!(prepared.passes(100, 50, 50, 1));
        assert!(!prepared.passes(99, 49, 49, 1));
        assert!(!prepared.passes(100, 51, 51, 1));
        assert!(prepared.passes(900, 450, 450, 9));
        assert!(!prepared.passes(899, 449, 449, 9));
    }

    #[test]
    fn nonsense_is_refused_in_one_sentence() {
        for (from, to) in [(0, 361), (400, 20), (36, 36)] {
            let error = Gate::new(&gate(from, to)).unwrap_err().to_string();
            assert!(error.contains(&format!("{from}..{to}")), "{error}");
        }
        let error = Gate::new(&ColourGate { saturation_min_percent: 101, ..gate(0, 30) }).unwrap_err();
        assert!(error.to_string().contains("101"), "{error}");
    }
}
