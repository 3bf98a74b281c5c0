//! The mask of fruit-coloured pixels, as a colour threshold would give it, and what can go wrong with it.

use super::{
    draws::Draws,
    patch::{Body, Patch},
};
use crate::image::{Image, LabelImage};

/// Chance that a colour threshold is wrong at a pixel of the mask's border.
const BORDER_ERROR: f64 = 0.2;
/// The same inside it. Far from fruit a threshold makes no blobs that region growing would keep.
const COLOUR_ERROR: f64 = 0.01;
/// The four neighbours of a pixel.
const NEIGHBOURS: [(i64, i64); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];

/// An error of the whole mask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MaskBias {
    /// Pixels by which the mask is too large (negative: too small), city-block distance.
    pub grow_px: i64,
    /// Pixels by which it is displaced, right and down.
    pub shift_px: [i64; 2],
}

impl MaskBias {
    /// The mask with this error.
    pub fn applied(&self, mask: &LabelImage) -> LabelImage {
        let mut biased = Image::filled(mask.width, mask.height, 0_u8);
        for v in 0..mask.height as i64 {
            for u in 0..mask.width as i64 {
                biased.set(u, v, mask.get(u - self.shift_px[0], v - self.shift_px[1]).unwrap_or(0));
            }
        }
        for _ in 0..self.grow_px.abs() {
            biased = grown(&biased, self.grow_px > 0);
        }
        biased
    }
}

/// Pixels whose centre shows a fruit-coloured body, 255, with errors at the border and a few inside.
pub(super) fn colour_mask(patch: &Patch, bodies: &[Body], draws: &mut Draws) -> LabelImage {
    let coloured = |u: i64, v: i64| match patch.owner.get(u, v) {
        Some(owner @ 1..) => bodies[usize::from(owner) - 1].fruit_coloured,
        _ => false,
    };
    let mut mask = Image::filled(patch.owner.width, patch.owner.height, 0_u8);
    for v in 0..mask.height as i64 {
        for u in 0..mask.width as i64 {
            let here = coloured(u, v);
            let border = NEIGHBOURS.iter().any(|&(du, dv)| coloured(u + du, v + dv) != here);
            let wrong = draws.chance(if border { BORDER_ERROR } else { COLOUR_ERROR }) && (border || here);
            mask.set(u, v, if here == wrong { 0 } else { 255 });
        }
    }
    mask
}

/// One step of dilation (or of erosion) with the four neighbours.
pub(super) fn grown(mask: &LabelImage, grow: bool) -> LabelImage {
    let mut result = mask.clone();
    let joins = if grow { 255 } else { 0 };
    for v in 0..mask.height as i64 {
        for u in 0..mask.width as i64 {
            if NEIGHBOURS.iter().any(|&(du, dv)| mask.get(u + du, v + dv) == Some(joins)) {
                result.set(u, v, joins);
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mask_is_displaced_grown_and_shrunk() {
        let mut mask = Image::filled(9, 9, 0_u8);
        for (u, v) in [(4, 4), (3, 4), (5, 4), (4, 3), (4, 5)] {
            mask.set(u, v, 255);
        }
        let count = |mask: &LabelImage| mask.pixels.iter().map(|&pixel| u32::from(pixel == 255)).sum::<u32>();
        let biased = |grow_px, shift_px| MaskBias { grow_px, shift_px }.applied(&mask);
        assert_eq!(MaskBias::default().applied(&mask), mask);
        // City-block discs of radius 0, 1, 2: 1, 5 and 13 pixels.
        assert_eq!((count(&biased(-1, [0, 0])), count(&biased(1, [0, 0]))), (1, 13));
        let shifted = biased(-1, [2, -1]);
        assert_eq!((count(&shifted), shifted.get(6, 3)), (1, Some(255)));
    }
}
