//! Colour presets, one for each fruit the command line knows.
//!
//! The jujube's hue range is the paper's. The paper has no floors for saturation and value; we add low ones, because a
//! pixel that is nearly grey or nearly black has a hue of pure noise. Figures for apples were read off two orchard
//! frames (Azure Kinect, 28 labelled fruit each): the gate keeps 86 and 88 % of the labelled pixels and passes 8 and 7 % of
//! the rest. The other ranges are typical colours of ripe fruit in daylight, to be adapted with `--hue`.

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

const PRESETS: [Preset; 8] = [
    of("jujube", (252, 36), 20, 25, 200),
    of("apple", (290, 10), 25, 80, 400),
    of("tomato", (340, 30), 45, 50, 400),
    of("lemon", (40, 68), 45, 70, 400),
    of("kiwi", (20, 60), 20, 30, 400),
    of("egg", (5, 45), 10, 90, 400),
    of("cherry-tomato", (340, 35), 45, 50, 150),
    // Warm colours: red through yellow.
    of("generic", (290, 70), 25, 25, 150),
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
