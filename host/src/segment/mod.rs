//! Segmentation of fruit by colour, as the paper does it (III.B.1, Fig. 9): mean filter, hue threshold in HSV,
//! connected regions, small ones removed.
//!
//! [`filter`] and [`hue`] make a mask in one pass, [`regions`] its connected parts. A mask or an instance image that
//! comes with the frame can be used instead of the colour. `varsac experiment speed` prints what each step of a
//! 1920x1080 frame takes: 2.5 ms for these two on a PC, one thread.
//!
//! The paper gates the hue alone. Fruit whose hue is not theirs alone (a lemon's is that of dry grass) need floors
//! for saturation and value; the presets say where they depart from the paper.

pub mod filter;
pub mod hue;
pub mod preset;
pub mod regions;

pub use hue::{ColourGate, HueRange};
pub use preset::preset;
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
    fn a_red_blob_among_leaves_is_the_only_region() {
        let mut image = ColourImage::filled(60, 40, [60, 120, 40]);
        for v in 10..25 {
            for u in 20..35 {
                image.set(u, v, [140, 40, 25]);
            }
        }
        // A speck of the fruit's colour: too small once averaged with the leaves around it.
        image.set(50, 30, [140, 40, 25]);
        let options = preset("jujube");
        let regions = segment(&image, &options).unwrap();
        assert_eq!(regions.list.len(), 1);
        let region = regions.list[0];
        assert!((19..=21).contains(&region.u_min) && (34..=36).contains(&region.u_max), "{region:?}");
        assert!((200..=289).contains(&region.area_px), "{region:?}");
        let impossible = ColourGate { hue: HueRange { from_deg: 7, to_deg: 7 }, ..options.gate };
        assert!(segment(&image, &SegmentOptions { gate: impossible, ..options }).is_err());
    }
}
