//! Segmentation of fruit by colour, as the paper does it (III.B.1, Fig. 9): mean filter, hue threshold in HSV,
//! connected regions, small ones removed.
//!
//! [`filter`] and [`hue`] make a mask in one pass, [`regions`] its connected parts. A mask or an instance image that
//! comes with the frame can be used instead of the colour. One 1920x1080 frame takes about 15 ms on a PC, one thread
//! (`cargo run --release -p varsac-host --example segment_speed` prints it).
//!
//! The paper gates the hue alone. Fruit whose hue is not theirs alone (a lemon's is that of dry grass) need floors
//! for saturation and value; the presets say where they depart from the paper.

pub mod filter;
pub mod hue;
pub mod regions;

pub use hue::{ColourGate, HueRange};
pub use regions::{AreaLimits, Region, RegionImage, Regions};

use crate::error::InputError;
use crate::image::ColourImage;

/// How fruit are told from the rest by colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SegmentOptions {
    /// Hue range and floors for saturation and value.
    pub gate: ColourGate,
    /// Radius of the mean filter, pixels of the colour image: 2 means 5x5. 0 filters nothing.
    pub mean_radius_px: usize,
    /// Areas of regions that are kept, pixels of the colour image.
    pub area: AreaLimits,
}

/// A named set of options.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SegmentPreset {
    /// Name of the fruit, as on the command line.
    pub fruit: &'static str,
    /// Its options.
    pub options: SegmentOptions,
}

/// The presets. "paper" is the paper's gate and nothing else; its window and least area are ours, it gives none.
/// The jujube's differs from it by two low floors, without which the noise of grey and black pixels has a hue.
/// The apple's was chosen on orchard frames, where the sky tints the fruit's shaded side to magenta, and holds 61-100 %
/// (median 95 %) of the pixels of the labelled fruit there; the lemon's on a scan. The others are typical hues, not
/// measured. White eggs have no hue: give a mask.
pub const PRESETS: [SegmentPreset; 8] = [
    preset("paper", (252, 36), 0, 0, 100),
    preset("jujube", (252, 36), 25, 40, 100),
    preset("apple", (295, 25), 30, 50, 250),
    preset("tomato", (345, 25), 45, 50, 250),
    preset("lemon", (38, 62), 45, 80, 200),
    preset("kiwi", (20, 45), 25, 40, 200),
    preset("egg", (10, 35), 20, 80, 200),
    preset("cherry-tomato", (345, 28), 45, 50, 80),
];

const fn preset(
    fruit: &'static str,
    (from_deg, to_deg): (u16, u16),
    saturation_min_percent: u8,
    value_min: u8,
    area_min_px: u32,
) -> SegmentPreset {
    let gate = ColourGate { hue: HueRange { from_deg, to_deg }, saturation_min_percent, value_min };
    let area = AreaLimits { min_px: area_min_px, max_px: u32::MAX };
    SegmentPreset { fruit, options: SegmentOptions { gate, mean_radius_px: 2, area } }
}

impl SegmentOptions {
    /// The preset of that name; the names are in [`PRESETS`].
    pub fn preset(fruit: &str) -> Option<Self> {
        PRESETS.iter().find(|preset| preset.fruit == fruit).map(|preset| preset.options)
    }
}

/// Regions of fruit colour.
///
/// # Errors
/// When the gate is impossible ([`hue::Gate::new`]).
pub fn segment(image: &ColourImage, options: &SegmentOptions) -> Result<Regions, InputError> {
    let gate = hue::Gate::new(&options.gate)?;
    let mask = filter::gate_of_mean(image, options.mean_radius_px, &gate);
    Ok(regions::connected_regions(&mask, options.area))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_is_possible_and_has_its_own_name() {
        for (index, preset) in PRESETS.iter().enumerate() {
            assert!(hue::Gate::new(&preset.options.gate).is_ok(), "{}", preset.fruit);
            assert!(PRESETS[..index].iter().all(|other| other.fruit != preset.fruit));
            assert_eq!(SegmentOptions::preset(preset.fruit), Some(preset.options));
        }
        assert_eq!(SegmentOptions::preset("durian"), None);
    }

    #[test]
    fn a_red_blob_among_leaves_is_the_only_region() {
        let mut image = ColourImage::filled(60, 40, [60, 120, 40]);
        for v in 10..25 {
            for u in 20..35 {
                image.set(u, v, [140, 40, 25]);
            }
        }
        // A speck of the fruit's colour: too small once averaged with the leaves around it.
        image.set(50, 30, [140, 40, 25]);
        let options = SegmentOptions::preset("jujube").unwrap();
        let regions = segment(&image, &options).unwrap();
        assert_eq!(regions.list.len(), 1);
        let region = regions.list[0];
        assert!((19..=21).contains(&region.u_min) && (34..=36).contains(&region.u_max), "{region:?}");
        assert!((200..=289).contains(&region.area_px), "{region:?}");
        let impossible = ColourGate { hue: HueRange { from_deg: 7, to_deg: 7 }, ..options.gate };
        assert!(segment(&image, &SegmentOptions { gate: impossible, ..options }).is_err());
    }
}
