//! Depth-to-colour registration of a Kinect v2: which depth and which colour pixel belong to each ideal depth pixel.
//!
//! From a raw depth image (512x424, millimetres) and the factory parameters. Undistortion is a lookup of the nearest
//! raw pixel, without interpolation, so that no depth is invented between two surfaces. The two cameras look from
//! different places: a strip beside each near object is seen by the depth camera only. The occlusion filter finds it
//! by letting each depth pixel claim a patch of the colour image for its depth; a pixel that lies clearly behind the
//! nearest claim has no colour, and must not take the near object's.

use nalgebra::Point3;

use super::calibration::FactoryCalibration;
use super::camera::{
    COLOUR_HEIGHT, COLOUR_WIDTH, ColourCamera, ColourRay, DEPTH_HEIGHT, DEPTH_WIDTH, DepthCamera,
};
use crate::error::InputError;
use crate::image::{DepthImage, Image};

/// Columns to either side that a depth pixel claims in the colour image. A depth pixel covers three colour pixels.
const CLAIM_COLUMNS: usize = 2;
/// Rows above and below that a depth pixel claims; also the margin of [`RegisteredDepth::colour_depth`].
const CLAIM_ROWS: usize = 1;
/// A depth pixel more than this fraction of its depth behind the nearest claim is hidden from the colour camera.
const HIDDEN_FRACTION: f32 = 0.01;

/// Marks an ideal pixel that no raw pixel sees.
const UNSEEN: u32 = u32::MAX;

/// A depth image on the ideal grid together with its place in the colour image.
#[derive(Debug, Clone, PartialEq)]
pub struct RegisteredDepth {
    /// Depth of each ideal pixel, 512x424, millimetres, 0 = no measurement.
    pub depth: DepthImage,
    /// Colour position (column, row) of each ideal pixel, pixels with centres at integers and so that rounding yields
    /// a pixel inside the image; nothing without depth, outside the colour image, or hidden from the colour camera.
    pub colour: Image<Option<(f32, f32)>>,
    /// Nearest depth of each colour pixel, 1920x1082: one extra row above and below the colour image, millimetres,
    /// infinity = none.
    pub colour_depth: DepthImage,
}

/// The mapping of one device, with its per-pixel tables: 20 bytes for each of the 217 088 depth pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Registration {
    depth_camera: DepthCamera,
    colour_camera: ColourCamera,
    /// Index of the raw pixel of each ideal pixel, or [`UNSEEN`].
    raw_index: Vec<u32>,
    colour_rays: Vec<ColourRay>,
}

impl Registration {
    /// Computes the tables. `O(512 * 424)`, a few milliseconds.
    pub fn new(calibration: &FactoryCalibration) -> Self {
        let depth_camera = DepthCamera::new(calibration.ir);
        let colour_camera = ColourCamera::new(calibration.colour, &calibration.ir);
        let mut raw_index = Vec::with_capacity(DEPTH_WIDTH * DEPTH_HEIGHT);
        let mut colour_rays = Vec::with_capacity(DEPTH_WIDTH * DEPTH_HEIGHT);
        for y in 0..DEPTH_HEIGHT {
            for x in 0..DEPTH_WIDTH {
                let (x, y) = (x as f64, y as f64);
                let (raw_x, raw_y) = depth_camera.distort(x, y);
                let nearest = index_of_nearest(raw_x, raw_y, DEPTH_WIDTH, DEPTH_HEIGHT);
                raw_index.push(nearest.map_or(UNSEEN, |index| index as u32));
                colour_rays.push(colour_camera.ray(x, y));
            }
        }
        Self { depth_camera, colour_camera, raw_index, colour_rays }
    }

    /// The depth camera.
    pub fn depth_camera(&self) -> &DepthCamera {
        &self.depth_camera
    }

    /// The colour camera.
    pub fn colour_camera(&self) -> &ColourCamera {
        &self.colour_camera
    }

    /// Registers one raw depth image (millimetres; zero, negative, NaN and infinite mean no measurement).
    ///
    /// # Errors
    /// When the image is not 512x424.
    pub fn register(&self, raw_depth: &DepthImage) -> Result<RegisteredDepth, InputError> {
        if (raw_depth.width, raw_depth.height) != (DEPTH_WIDTH, DEPTH_HEIGHT) {
            return Err(InputError::at(
                "raw depth image",
                format!("is {}x{} pixels", raw_depth.width, raw_depth.height),
                format!("registration needs the sensor's {DEPTH_WIDTH}x{DEPTH_HEIGHT} pixels"),
            ));
        }
        let depth = self.undistorted(raw_depth);
        let mut colour = Image::filled(DEPTH_WIDTH, DEPTH_HEIGHT, None);
        let mut colour_depth = Image::filled(COLOUR_WIDTH, COLOUR_HEIGHT + 2 * CLAIM_ROWS, f32::INFINITY);
        for ((&z_mm, &ray), place) in depth.pixels.iter().zip(&self.colour_rays).zip(&mut colour.pixels) {
            if z_mm > 0.0 {
                let column = self.colour_camera.column(ray, f64::from(z_mm)) as f32;
                let row = ray.row as f32;
                if let Some(index) = colour_index(column, row) {
                    *place = Some((column, row));
                    claim(&mut colour_depth, index, z_mm);
                }
            }
        }
        for (place, &z_mm) in colour.pixels.iter_mut().zip(&depth.pixels) {
            if let Some(index) = place.and_then(|(column, row)| colour_index(column, row)) {
                let nearest_mm = colour_depth.pixels[index + CLAIM_ROWS * COLOUR_WIDTH];
                if z_mm - nearest_mm > HIDDEN_FRACTION * z_mm {
                    *place = None;
                }
            }
        }
        Ok(RegisteredDepth { depth, colour, colour_depth })
    }

    /// Colour position (column, row) of a point of the depth camera frame, so that it can be drawn on the colour
    /// image. It may lie outside the image; nothing for points that are not in front of the camera.
    pub fn project_to_colour(&self, point_mm: &Point3<f64>) -> Option<(f64, f64)> {
        let (x, y) = self.depth_camera.project(point_mm)?;
        let ray = self.colour_camera.ray(x, y);
        Some((self.colour_camera.column(ray, point_mm.z), ray.row))
    }

    /// The raw image looked up on the ideal grid, invalid depths as 0.
    fn undistorted(&self, raw_depth: &DepthImage) -> DepthImage {
        let pixels = self
            .raw_index
            .iter()
            .map(|&index| match raw_depth.pixels.get(index as usize) {
                Some(&z_mm) if z_mm > 0.0 && z_mm.is_finite() => z_mm,
                _ => 0.0,
            })
            .collect();
        DepthImage { width: DEPTH_WIDTH, height: DEPTH_HEIGHT, pixels }
    }
}

/// Lowers the colour pixels around `index` (of the image without margin) to `z_mm`.
#[inline]
fn claim(colour_depth: &mut DepthImage, index: usize, z_mm: f32) {
    let (column, top) = (index % COLOUR_WIDTH, index / COLOUR_WIDTH);
    let first = column.saturating_sub(CLAIM_COLUMNS);
    let last = (column + CLAIM_COLUMNS).min(COLOUR_WIDTH - 1);
    // With the margin above the image, row `v` of the image is row `v + CLAIM_ROWS`, so the claim starts at `v`.
    for row in top..=top + 2 * CLAIM_ROWS {
        let claimed = &mut colour_depth.pixels[row * COLOUR_WIDTH + first..=row * COLOUR_WIDTH + last];
        // Nearly all claims are of full width; of known length they take a few instructions.
        match <&mut [f32; 2 * CLAIM_COLUMNS + 1]>::try_from(&mut *claimed) {
            Ok(claimed) => lower(claimed, z_mm),
            Err(_) => lower(claimed, z_mm),
        }
    }
}

#[inline(always)]
fn lower(depths_mm: &mut [f32], z_mm: f32) {
    for nearest_mm in depths_mm {
        *nearest_mm = if z_mm < *nearest_mm { z_mm } else { *nearest_mm };
    }
}

/// Index of the colour pixel nearest to a position.
#[inline]
fn colour_index(column: f32, row: f32) -> Option<usize> {
    index_of_nearest(f64::from(column), f64::from(row), COLOUR_WIDTH, COLOUR_HEIGHT)
}

/// Row-major index of the pixel whose centre is nearest; nothing outside the image or for NaN.
#[inline]
fn index_of_nearest(x: f64, y: f64, width: usize, height: usize) -> Option<usize> {
    let (x, y) = (x + 0.5, y + 0.5);
    // Not negative inside, so that truncation is floor.
    (x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64).then(|| y as usize * width + x as usize)
}

#[cfg(test)]
mod tests {
    use super::super::calibration::IrParameters;
    use super::*;

    /// A device without distortion whose colour camera is a pinhole 52 mm to the left.
    fn plain() -> Registration {
        let ir = IrParameters {
            fx: 366.0,
            fy: 366.0,
            cx: 256.0,
            cy: 206.0,
            k1: 0.0,
            k2: 0.0,
            k3: 0.0,
            p1: 0.0,
            p2: 0.0,
        };
        let colour = ColourCamera::parallel_pinhole(1080.0, (959.5, 539.5), 52.0, &ir);
        Registration::new(&FactoryCalibration { ir, colour })
    }

    #[test]
    fn colour_position_is_that_of_the_projected_point() {
        let registration = plain();
        let registered = registration.register(&Image::filled(DEPTH_WIDTH, DEPTH_HEIGHT, 800.0)).unwrap();
        let point = Point3::from(registration.depth_camera().ray(300.0, 100.0) * 800.0);
        let (column, row) = registration.project_to_colour(&point).unwrap();
        let place = registered.colour.get(300, 100).flatten().unwrap();
        assert!((f64::from(place.0) - column).abs() < 1e-3 && (f64::from(place.1) - row).abs() < 1e-3);
        assert!((column - (1080.0 * (point.x + 52.0) / 800.0 + 959.5)).abs() < 1e-9);
    }

    #[test]
    fn a_near_object_hides_a_strip_of_the_background_from_the_colour_camera_only() {
        let registration = plain();
        let mut raw = Image::filled(DEPTH_WIDTH, DEPTH_HEIGHT, 1000.0);
        for v in 150..250 {
            for u in 240..280 {
                raw.set(u, v, 600.0);
            }
        }
        let registered = registration.register(&raw).unwrap();
        assert_eq!(registered.depth, raw);
        // Parallax 52 (1/600 - 1/1000) * 1080 = 37.4 colour pixels = 12.7 depth pixels, seen right of the object
        // by the depth camera, which is the right one of the two.
        let hidden = (0..DEPTH_WIDTH as i64).filter(|&u| registered.colour.get(u, 200).flatten().is_none());
        let hidden: Vec<i64> = hidden.collect();
        assert!(hidden.iter().all(|u| (280..294).contains(u)), "{hidden:?}");
        assert!((11..=14).contains(&hidden.len()), "{hidden:?}");
    }

    #[test]
    fn nearest_depth_covers_two_columns_and_one_row_around() {
        let registration = plain();
        let mut raw = Image::filled(DEPTH_WIDTH, DEPTH_HEIGHT, 0.0);
        raw.set(256, 206, 863.0);
        raw.set(10, 10, f32::NAN);
        raw.set(11, 10, -4.0);
        let registered = registration.register(&raw).unwrap();
        let place = registered.colour.get(256, 206).flatten().unwrap();
        let (column, row) = (place.0.round() as i64, place.1.round() as i64);
        let claimed = registered.colour_depth.pixels.iter().filter(|z| z.is_finite()).count();
        assert_eq!(claimed, 15);
        for dv in -1..=1 {
            for du in -2..=2 {
                assert_eq!(registered.colour_depth.get(column + du, row + 1 + dv), Some(863.0));
            }
        }
    }

    #[test]
    fn a_claim_does_not_wrap_around_the_image_border() {
        let mut colour_depth = Image::filled(COLOUR_WIDTH, COLOUR_HEIGHT + 2, f32::INFINITY);
        claim(&mut colour_depth, 5 * COLOUR_WIDTH, 700.0);
        claim(&mut colour_depth, COLOUR_WIDTH * COLOUR_HEIGHT - 1, 800.0);
        assert_eq!(colour_depth.pixels.iter().filter(|z| z.is_finite()).count(), 9 + 9);
        assert_eq!(colour_depth.get(COLOUR_WIDTH as i64 - 1, 4), Some(f32::INFINITY));
    }

    #[test]
    fn an_image_of_another_size_is_refused() {
        let error = plain().register(&Image::filled(640, 480, 700.0)).unwrap_err();
        assert!(error.to_string().contains("640x480"), "{error}");
    }
}
