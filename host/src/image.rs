//! Images as the pipeline sees them: row-major, origin at the top left, pixel centres at integer coordinates.

/// A rectangle of values, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Image<T> {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// `width * height` values, row by row.
    pub pixels: Vec<T>,
}

/// 8-bit red, green, blue.
pub type ColourImage = Image<[u8; 3]>;
/// Depth along z in millimetres; 0 = no measurement.
pub type DepthImage = Image<f32>;
/// One byte a pixel: 0 = background; in an instance image the value names the instance.
pub type LabelImage = Image<u8>;

impl<T: Copy> Image<T> {
    /// An image filled with one value.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self { width, height, pixels: vec![value; width * height] }
    }

    /// The pixel in column `u` and row `v`, or nothing outside the image.
    #[inline]
    pub fn get(&self, u: i64, v: i64) -> Option<T> {
        if u < 0 || v < 0 || u >= self.width as i64 || v >= self.height as i64 {
            return None;
        }
        self.pixels.get(v as usize * self.width + u as usize).copied()
    }

    /// Sets a pixel; outside the image nothing happens.
    #[inline]
    pub fn set(&mut self, u: i64, v: i64, value: T) {
        if u >= 0 && v >= 0 && u < self.width as i64 && v < self.height as i64 {
            self.pixels[v as usize * self.width + u as usize] = value;
        }
    }
}
