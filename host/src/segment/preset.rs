//! Colour presets, one for each fruit the command line knows.
//!
//! "paper" is the paper's gate and nothing else; its window and least area are ours, it gives none. The jujube's
//! differs from it by two low floors, without which the noise of grey and black pixels has a hue. The apple's was chosen on
//! orchard frames, where the sky tints the fruit's shaded side to magenta, and holds 61-100 % (median 95 %) of the pixels of
//! a labelled fruit there; the lemon's on a scan. The others are typical hues, not measured, to be adapted with
//! `--hue`. White eggs have no hue: give a mask.

use super::{AreaLimits, ColourGate, HueRange, SegmentOptions};

/// Colour range of a fruit and the smallest region worth a search, pixels of a 1920x1080 image.
struct Preset {
    fruit: &'static str,
    hue: (u16, u16),
    saturation_min_percent: u8,
    value_min: u8,
    area_min_px: u32,
}

const fn of(fruit: &'static str, hue: (u16, u16), saturation: u8, value: u8, area_min_px: u32) -> Preset {
    Preset { fruit, hue, saturation_min_percent: saturation, value_min: value, area_min_px }
}

const PRESETS: [Preset; 9] = [
    of("paper", (252, 36), 0, 0, 100),
    of("jujube", (252, 36), 25, 40, 100),
    of("apple", (295, 25), 30, 50, 250),
    of("tomato", (345, 25), 45, 50, 250),
    of("lemon", (38, 62), 45, 80, 200),
    of("kiwi", (20, 45), 25, 40, 200),
    of("egg", (10, 35), 20, 80, 200),
    of("cherry-tomato", (345, 28), 45, 50, 80),
    // Warm colours: red through yellow.
    of("generic", (290, 70), 25, 25, 100),
];

/// Largest region worth a search, pixels: a fifth of a 1920x1080 image. Anything larger is a background of the
/// fruit's colour.
const AREA_MAX_PX: u32 = 400_000;

/// The options for a fruit by its name on the command line; a name without colours of its own (`none`) gets `generic`.
pub fn preset(fruit: &str) -> SegmentOptions {
    let [.., generic] = &PRESETS;
    let preset = PRESETS.iter().find(|preset| preset.fruit == fruit).unwrap_or(generic);
    let (from_deg, to_deg) = preset.hue;
    SegmentOptions {
        gate: ColourGate {
            hue: HueRange { from_deg, to_deg },
            saturation_min_percent: preset.saturation_min_percent,
            value_min: preset.value_min,
        },
        mean_radius_px: 2,
        area: AreaLimits { min_px: preset.area_min_px, max_px: AREA_MAX_PX },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::segment::hue::Gate;

    #[test]
    fn every_preset_is_a_possible_gate_and_the_jujube_has_the_papers_hue() {
        for one in &PRESETS {
            assert!(Gate::new(&preset(one.fruit).gate).is_ok(), "{}", one.fruit);
        }
        assert_eq!(preset("jujube").gate.hue, HueRange { from_deg: 252, to_deg: 36 });
        assert_eq!(preset("none"), preset("generic"));
    }
}
