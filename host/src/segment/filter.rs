//! The mean filter (paper III.B.1, Fig. 9b) fused with the colour gate: one pass over the image, integers only.
//!
//! A square window slides over the image. For each column the sum over the window's rows is kept and moved down one
//! row at a time; a running sum over the window's columns follows. The cost does not depend on the window.
//! The sums go straight into the gate, which needs no division ([`super::hue`]): the result is that of the exact
//! mean, without the rounding of an 8-bit filtered image. At the border the window is what of it lies in the image.
//!
//! Filtering comes before the gate so that pixels of the fruit's border, where single pixels stray, survive.

use super::hue::Gate;
use crate::image::{ColourImage, LabelImage};

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
    if width == 0 || height == 0 {
        return mask;
    }
    let radius = radius_px.min(MAX_RADIUS_PX);
    let within = |position: usize, length: usize| {
        ((position + radius).min(length - 1) - position.saturating_sub(radius) + 1) as i16
    };
    let columns_within: Vec<i16> = (0..width).map(|u| within(u, width)).collect();
    // Sums over the window's rows; a border of zeros on either side spares the loop over columns its ends.
    let mut column_sums = vec![[0_i16; 3]; width + 2 * radius + 1];
    let inner = radius + 1..radius + 1 + width;
    let mut sums =
        WindowSums { r: vec![0; width], g: vec![0; width], b: vec![0; width], count: vec![0; width] };
    let row = |v: usize| &image.pixels[v * width..(v + 1) * width];
    for v in 0..radius.min(height) {
        move_down(&mut column_sums[inner.clone()], None, Some(row(v)));
    }
    for (v, mask_row) in mask.pixels.chunks_exact_mut(width).enumerate() {
        let leaving = (v > radius).then(|| row(v - radius - 1));
        let entering = (v + radius < height).then(|| row(v + radius));
        move_down(&mut column_sums[inner.clone()], leaving, entering);
        sums.slide_along(&column_sums, radius);
        let rows_within = within(v, height);
        for (count, columns) in sums.count.iter_mut().zip(&columns_within) {
            *count = columns * rows_within;
        }
        sums.gate(gate, mask_row);
    }
    mask
}

/// Moves the window's rows one down: the topmost leaves, one at the bottom enters.
fn move_down(column_sums: &mut [[i16; 3]], leaving: Option<&[[u8; 3]]>, entering: Option<&[[u8; 3]]>) {
    let sums = column_sums.as_flattened_mut();
    if let Some(row) = leaving {
        for (sum, &value) in sums.iter_mut().zip(row.as_flattened()) {
            *sum -= i16::from(value);
        }
    }
    if let Some(row) = entering {
        for (sum, &value) in sums.iter_mut().zip(row.as_flattened()) {
            *sum += i16::from(value);
        }
    }
}

/// Sums over the whole window for each pixel of one row, a list for each channel, and the pixels they are of.
struct WindowSums {
    r: Vec<i16>,
    g: Vec<i16>,
    b: Vec<i16>,
    count: Vec<i16>,
}

impl WindowSums {
    /// Slides the window along a row of column sums.
    fn slide_along(&mut self, column_sums: &[[i16; 3]], radius: usize) {
        let [mut r, mut g, mut b] = [0_i16; 3];
        for sum in &column_sums[..=2 * radius] {
            r += sum[0];
            g += sum[1];
            b += sum[2];
        }
        let moves = column_sums.iter().zip(&column_sums[2 * radius + 1..]);
        let places = self.r.iter_mut().zip(&mut self.g).zip(&mut self.b);
        for (((place_r, place_g), place_b), (leaving, entering)) in places.zip(moves) {
            // The difference first: the sum of both windows' pixels might not fit.
            r += entering[0] - leaving[0];
            g += entering[1] - leaving[1];
            b += entering[2] - leaving[2];
            (*place_r, *place_g, *place_b) = (r, g, b);
        }
    }

    /// Writes which of them pass. Without a branch and list by list, so that it is done for many pixels at a time.
    fn gate(&self, gate: &Gate, mask_row: &mut [u8]) {
        let sums = self.r.iter().zip(&self.g).zip(&self.b).zip(&self.count);
        for (pixel, (((&r, &g), &b), &count)) in mask_row.iter_mut().zip(sums) {
            *pixel = if gate.passes(r, g, b, count) { FOREGROUND } else { 0 };
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
