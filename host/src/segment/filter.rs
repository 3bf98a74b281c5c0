//! The mean filter (paper III.B.1, Fig. 9b) fused with the colour gate: one pass over the image, integers only.
//!
//! A square window slides over the image. For each column and channel the sum over the window's rows is kept and moved
//! down one row at a time; the sum over the window's columns is taken anew, by adding shifted rows of column sums. A
//! running sum would need fewer additions, but each would wait for the one before; these are done 8 to 32 at a time.
//! The sums go straight into the gate, which needs no division ([`super::hue`]): the result is that of the exact
//! mean, without the rounding of an 8-bit filtered image. At the border the window is what of it lies in the image.
//!
//! Filtering comes before the gate so that pixels of the fruit's border, where single pixels stray, survive.

use super::hue::Gate;
use crate::image::{ColourImage, LabelImage};
use crate::wide;

/// Largest radius of the window: 11x11 pixels. Up to it sums fit `i16` (121 * 255 < 2^15), of which a processor
/// handles eight or more at a time.
pub const MAX_RADIUS_PX: usize = 5;

/// Value of a pixel that passed.
pub const FOREGROUND: u8 = 255;

/// The pixels whose neighbourhood of `(2 radius_px + 1)^2` pixels has a mean colour that passes the gate, as 0 or
/// [`FOREGROUND`]. A radius of 0 filters nothing; one beyond [`MAX_RADIUS_PX`] counts as that. `O(pixels)`.
pub fn gate_of_mean(image: &ColourImage, radius_px: usize, gate: &Gate) -> LabelImage {
    let (width, height) = (image.width, image.height);
    let mut mask = LabelImage::filled(width, height, 0);
    if width > 0 && height > 0 {
        wide::run(
            #[inline(always)]
            || mark(image, radius_px.min(MAX_RADIUS_PX), gate, &mut mask),
        );
    }
    mask
}

#[inline(always)]
fn mark(image: &ColourImage, radius: usize, gate: &Gate, mask: &mut LabelImage) {
    let (width, height) = (image.width, image.height);
    let within = |position: usize, length: usize| {
        ((position + radius).min(length - 1) - position.saturating_sub(radius) + 1) as i16
    };
    let columns_within: Vec<i16> = (0..width).map(|u| within(u, width)).collect();
    let mut columns = ColumnSums::new(width, radius);
    let mut window = [vec![0_i16; width], vec![0_i16; width], vec![0_i16; width]];
    let row = |v: usize| &image.pixels[v * width..(v + 1) * width];
    for v in 0..radius.min(height) {
        columns.enter(row(v));
    }
    for (v, mask_row) in mask.pixels.chunks_exact_mut(width).enumerate() {
        if v > radius {
            columns.leave(row(v - radius - 1));
        }
        if v + radius < height {
            columns.enter(row(v + radius));
        }
        let [r, g, b] = &mut window;
        columns.sum_windows([r, g, b]);
        let rows_within = within(v, height);
        // Without a branch and list by list, so that it is done for many pixels at a time.
        let sums = r.iter().zip(&*g).zip(&*b).zip(&columns_within);
        for (pixel, (((&r, &g), &b), &columns)) in mask_row.iter_mut().zip(sums) {
            *pixel = if gate.passes(r, g, b, columns * rows_within) { FOREGROUND } else { 0 };
        }
    }
}

/// Sums over the window's rows for each column: a list for each channel, with `radius` zeros at either end, which spare
/// the windows at the border their own case.
struct ColumnSums {
    channels: [Vec<i16>; 3],
    radius: usize,
}

impl ColumnSums {
    fn new(width: usize, radius: usize) -> Self {
        let zeros = || vec![0; width + 2 * radius];
        Self { channels: [zeros(), zeros(), zeros()], radius }
    }

    /// A row of the image enters the window at the bottom.
    #[inline(always)]
    fn enter(&mut self, row: &[[u8; 3]]) {
        self.change(row, |sum, value| sum + value);
    }

    /// A row of the image leaves it at the top.
    #[inline(always)]
    fn leave(&mut self, row: &[[u8; 3]]) {
        self.change(row, |sum, value| sum - value);
    }

    #[inline(always)]
    fn change(&mut self, row: &[[u8; 3]], by: impl Fn(i16, i16) -> i16) {
        let [r, g, b] = self.channels.each_mut().map(|sums| &mut sums[self.radius..]);
        // A channel at a time and not as arrays of three, or the compiler takes the pixels one by one.
        for (((r, g), b), pixel) in r.iter_mut().zip(g).zip(b).zip(row) {
            *r = by(*r, i16::from(pixel[0]));
            *g = by(*g, i16::from(pixel[1]));
            *b = by(*b, i16::from(pixel[2]));
        }
    }

    /// The sums over the window's columns, for each position of the window.
    #[inline(always)]
    fn sum_windows(&self, window: [&mut Vec<i16>; 3]) {
        for (sums, columns) in window.into_iter().zip(&self.channels) {
            let width = sums.len();
            sums.copy_from_slice(&columns[..width]);
            for shift in 1..=2 * self.radius {
                for (sum, column) in sums.iter_mut().zip(&columns[shift..]) {
                    *sum += column;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::hue::{ColourGate, HueRange};
    use super::*;

    const PAPER: ColourGate =
        ColourGate { hue: HueRange { from_deg: 252, to_deg: 36 }, saturation_min_percent: 0, value_min: 0 };

    /// A picture without any structure the filter could lean on.
    fn speckle(width: usize, height: usize) -> ColourImage {
        let mut state = 1_u32;
        let mut image = ColourImage::filled(width, height, [0; 3]);
        for pixel in &mut image.pixels {
            *pixel = [0; 3].map(|_: u8| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 24) as u8
            });
        }
        image
    }

    fn naive(image: &ColourImage, radius: i64, gate: &Gate) -> LabelImage {
        let mut mask = LabelImage::filled(image.width, image.height, 0);
        for v in 0..image.height as i64 {
            for u in 0..image.width as i64 {
                let (mut sums, mut count) = ([0_i16; 3], 0);
                for dv in -radius..=radius {
                    for du in -radius..=radius {
                        if let Some(pixel) = image.get(u + du, v + dv) {
                            count += 1;
                            for (sum, value) in sums.iter_mut().zip(pixel) {
                                *sum += i16::from(value);
                            }
                        }
                    }
                }
                if gate.passes(sums[0], sums[1], sums[2], count) {
                    mask.set(u, v, FOREGROUND);
                }
            }
        }
        mask
    }

    #[test]
    fn running_sums_equal_the_definition_bit_for_bit() {
        let gate = Gate::new(&ColourGate { saturation_min_percent: 8, value_min: 120, ..PAPER }).unwrap();
        for (width, height) in [(37, 23), (1, 9), (9, 1), (1, 1), (4, 4)] {
            let image = speckle(width, height);
            for radius in [0, 1, 2, 5] {
                assert_eq!(
                    gate_of_mean(&image, radius, &gate),
                    naive(&image, radius as i64, &gate),
                    "{width}x{height}, radius {radius}"
                );
            }
        }
    }

    #[test]
    fn a_stray_pixel_on_the_fruit_survives() {
        let gate = Gate::new(&PAPER).unwrap();
        let mut image = ColourImage::filled(9, 9, [150, 30, 20]);
        image.set(4, 4, [90, 100, 80]);
        assert_eq!(gate_of_mean(&image, 0, &gate).get(4, 4), Some(0));
        assert_eq!(gate_of_mean(&image, 1, &gate).get(4, 4), Some(FOREGROUND));
    }

    #[test]
    fn brightest_picture_and_largest_window_stay_in_range() {
        let gate = Gate::new(&PAPER).unwrap();
        let image = ColourImage::filled(200, 200, [255, 0, 0]);
        assert!(gate_of_mean(&image, usize::MAX, &gate).pixels.iter().all(|&pixel| pixel == FOREGROUND));
    }

    #[test]
    fn an_empty_picture_has_an_empty_mask() {
        let gate = Gate::new(&PAPER).unwrap();
        assert!(gate_of_mean(&ColourImage::filled(0, 5, [0; 3]), 2, &gate).pixels.is_empty());
    }
}
