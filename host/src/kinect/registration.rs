//! Depth-to-colour registration of a Kinect v2: which depth and which colour pixel belong to each ideal depth pixel.
//!
//! From a raw depth image (512x424, millimetres) and the factory parameters. Undistortion is a lookup of the nearest
//! raw pixel, without interpolation, so that no depth is invented between two surfaces. The two cameras look from
//! different places: a strip beside each near object is seen by the depth camera only. The occlusion filter finds it
//! by letting each depth pixel claim a patch of the colour image for its depth; a pixel that lies clearly behind the
//! nearest claim has no colour, and must not take the near object's.
//!
//! The patches overlap, and the nearest claim on a colour pixel is a minimum, which can be taken along the columns and
//! then along the rows: each depth pixel writes its claim into its own row only, and the question "who is nearest here"
//! looks at the row above and the row below as well. That is a third of the writing, with the same answer.

use nalgebra::{Point3, Vector3};

use super::calibration::FactoryCalibration;
use super::camera::{COLOUR_HEIGHT, COLOUR_WIDTH, ColourCamera, DEPTH_HEIGHT, DEPTH_WIDTH, DepthCamera};
use crate::error::InputError;
use crate::image::{DepthImage, Image};
use crate::wide;

/// Columns to either side that a depth pixel claims in the colour image. A depth pixel covers three colour pixels.
const CLAIM_COLUMNS: usize = 2;
/// Rows above and below that a depth pixel claims.
const CLAIM_ROWS: usize = 1;
/// Colour pixels in a row of the claims: with margins, so that a patch at the border needs no case of its own.
const CLAIM_STRIDE: usize = COLOUR_WIDTH + 2 * CLAIM_COLUMNS;
/// A depth pixel more than this fraction of its depth behind the nearest claim is hidden from the colour camera.
const HIDDEN_FRACTION: f32 = 0.01;

/// Marks an ideal pixel that no raw pixel sees, and one whose row lies outside the colour image.
const UNSEEN: u32 = u32::MAX;

/// A depth image on the ideal grid together with its place in the colour image.
#[derive(Debug, Clone, PartialEq)]
pub struct RegisteredDepth {
    /// Depth of each ideal pixel, 512x424, millimetres, 0 = no measurement.
    pub depth: DepthImage,
    /// Colour position (column, row) of each ideal pixel, pixels with centres at integers and so that rounding yields
    /// a pixel inside the image; nothing without depth, outside the colour image, or hidden from the colour camera.
    pub colour: Image<Option<(f32, f32)>>,
    /// Columns of all ideal pixels, and the nearest depth that a row of each colour pixel was claimed for: kept so that
    /// the next frame does not have to ask for ten megabytes again.
    columns: Vec<f32>,
    claims: Vec<f32>,
}

impl RegisteredDepth {
    /// Room for a frame.
    fn empty() -> Self {
        Self {
            depth: Image::filled(DEPTH_WIDTH, DEPTH_HEIGHT, 0.0),
            colour: Image::filled(DEPTH_WIDTH, DEPTH_HEIGHT, None),
            columns: vec![0.0; DEPTH_WIDTH * DEPTH_HEIGHT],
            claims: vec![f32::INFINITY; CLAIM_STRIDE * (COLOUR_HEIGHT + 2 * CLAIM_ROWS)],
        }
    }
}

/// The mapping of one device, with its per-pixel tables: 20 bytes for each of the 217 088 depth pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Registration {
    depth_camera: DepthCamera,
    colour_camera: ColourCamera,
    /// Index of the raw pixel of each ideal pixel, or [`UNSEEN`].
    raw_index: Vec<u32>,
    /// Where that raw pixel looks, pixels right of and below the ideal one: up to half a pixel, two thirds of a millimetre at
    /// half a metre, and alike for the whole of a fruit.
    look: Vec<[f32; 2]>,
    /// Slope of its ray in the colour camera, before parallax.
    slope: Vec<f64>,
    /// Its row in the colour image, which depth does not change, and the nearest row of pixels or [`UNSEEN`].
    row: Vec<(f32, u32)>,
}

impl Registration {
    /// Computes the tables. `O(512 * 424)`, a few milliseconds.
    pub fn new(calibration: &FactoryCalibration) -> Self {
        let depth_camera = DepthCamera::new(calibration.ir);
        let colour_camera = ColourCamera::new(calibration.colour, &calibration.ir);
        let mut raw_index = Vec::with_capacity(DEPTH_WIDTH * DEPTH_HEIGHT);
        let mut look = Vec::with_capacity(DEPTH_WIDTH * DEPTH_HEIGHT);
        let mut slope = Vec::with_capacity(DEPTH_WIDTH * DEPTH_HEIGHT);
        let mut row = Vec::with_capacity(DEPTH_WIDTH * DEPTH_HEIGHT);
        for y in 0..DEPTH_HEIGHT {
            for x in 0..DEPTH_WIDTH {
                let (x, y) = (x as f64, y as f64);
                let (raw_x, raw_y) = depth_camera.distort(x, y);
                let nearest = nearest_pixel(raw_x, DEPTH_WIDTH).zip(nearest_pixel(raw_y, DEPTH_HEIGHT));
                raw_index.push(nearest.map_or(UNSEEN, |(x, y)| (y * DEPTH_WIDTH + x) as u32));
                // Over half a pixel the distortion is a translation.
                let beside = |raw: f64| (libm::rint(raw) - raw) as f32;
                look.push(nearest.map_or([0.0; 2], |_| [beside(raw_x), beside(raw_y)]));
                let ray = colour_camera.ray(x, y);
                slope.push(ray.slope);
                let nearest = nearest_pixel(ray.row as f32, COLOUR_HEIGHT);
                row.push((ray.row as f32, nearest.map_or(UNSEEN, |row| row as u32)));
            }
        }
        Self { depth_camera, colour_camera, raw_index, look, slope, row }
    }

    /// Whether these are the tables of that device.
    pub fn is_of(&self, calibration: &FactoryCalibration) -> bool {
        self.depth_camera == DepthCamera::new(calibration.ir)
            && self.colour_camera == ColourCamera::new(calibration.colour, &calibration.ir)
    }

    /// Direction, scaled to z = 1, in which the raw pixel behind an ideal pixel looks; between pixels the mean of those around.
    pub fn ray(&self, x: f64, y: f64) -> Vector3<f64> {
        let (columns, rows) = ([x.floor(), x.ceil()], [y.floor(), y.ceil()]);
        let (mut right, mut below) = (0.0, 0.0);
        for (column, row) in [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(i, j)| (columns[i], rows[j])) {
            let inside =
                (0.0..DEPTH_WIDTH as f64).contains(&column) && (0.0..DEPTH_HEIGHT as f64).contains(&row);
            let index = if inside { row as usize * DEPTH_WIDTH + column as usize } else { usize::MAX };
            let [u, v] = self.look.get(index).copied().unwrap_or([0.0; 2]);
            right += 0.25 * f64::from(u);
            below += 0.25 * f64::from(v);
        }
        self.depth_camera.ray(x + right, y + below)
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
        let mut registered = RegisteredDepth::empty();
        self.register_again(raw_depth, &mut registered)?;
        Ok(registered)
    }

    /// [`Self::register`] into the memory of an earlier frame, which saves a third of the time. On an error the earlier
    /// frame is left as it was.
    ///
    /// # Errors
    /// When the image is not 512x424.
    pub fn register_again(
        &self,
        raw_depth: &DepthImage,
        registered: &mut RegisteredDepth,
    ) -> Result<(), InputError> {
        if (raw_depth.width, raw_depth.height) != (DEPTH_WIDTH, DEPTH_HEIGHT) {
            return Err(InputError::at(
                "raw depth image",
                format!("is {}x{} pixels", raw_depth.width, raw_depth.height),
                format!("registration needs the sensor's {DEPTH_WIDTH}x{DEPTH_HEIGHT} pixels"),
            ));
        }
        let RegisteredDepth { depth, colour, columns, claims } = registered;
        self.undistort(raw_depth, depth);
        wide::run(
            #[inline(always)]
            || {
                for ((column, &z_mm), &slope) in columns.iter_mut().zip(&depth.pixels).zip(&self.slope) {
                    *column = self.colour_camera.column(slope, f64::from(z_mm)) as f32;
                }
            },
        );
        claims.fill(f32::INFINITY);
        let places = columns.iter().zip(&self.row).zip(&depth.pixels).zip(&mut colour.pixels);
        for (((&column, &(row, row_px)), &z_mm), place) in places {
            // Without depth the column is infinite, which is no pixel.
            *place = match nearest_pixel(column, COLOUR_WIDTH) {
                Some(column_px) if row_px != UNSEEN => {
                    claim(claims, column_px, row_px as usize, z_mm);
                    Some((column, row))
                }
                _ => None,
            };
        }
        for ((place, &(_, row_px)), &z_mm) in colour.pixels.iter_mut().zip(&self.row).zip(&depth.pixels) {
            if let Some(column_px) = place.and_then(|(column, _)| nearest_pixel(column, COLOUR_WIDTH)) {
                let nearest_mm = nearest_claim(claims, column_px, row_px as usize);
                if z_mm - nearest_mm > HIDDEN_FRACTION * z_mm {
                    *place = None;
                }
            }
        }
        Ok(())
    }

    /// Colour position (column, row) of a point of the depth camera frame, so that it can be drawn on the colour
    /// image. It may lie outside the image; nothing for points that are not in front of the camera.
    pub fn project_to_colour(&self, point_mm: &Point3<f64>) -> Option<(f64, f64)> {
        let (x, y) = self.depth_camera.project(point_mm)?;
        let ray = self.colour_camera.ray(x, y);
        Some((self.colour_camera.column(ray.slope, point_mm.z), ray.row))
    }

    /// Looks the raw image up on the ideal grid, invalid depths as 0.
    fn undistort(&self, raw_depth: &DepthImage, depth: &mut DepthImage) {
        for (place, &index) in depth.pixels.iter_mut().zip(&self.raw_index) {
            *place = match raw_depth.pixels.get(index as usize) {
                Some(&z_mm) if z_mm > 0.0 && z_mm.is_finite() => z_mm,
                _ => 0.0,
            };
        }
    }
}

/// Lowers the claims of one row of the patch around a colour pixel to `z_mm`.
#[inline]
fn claim(claims: &mut [f32], column: usize, row: usize, z_mm: f32) {
    // With the margin to the left, the patch begins at the pixel's own column.
    let first = (row + CLAIM_ROWS) * CLAIM_STRIDE + column;
    for nearest_mm in &mut claims[first..=first + 2 * CLAIM_COLUMNS] {
        *nearest_mm = if z_mm < *nearest_mm { z_mm } else { *nearest_mm };
    }
}

/// Depth of the nearest claim on a colour pixel, millimetres, infinity = none.
#[inline]
fn nearest_claim(claims: &[f32], column: usize, row: usize) -> f32 {
    // With the margin above the image, the first row that reaches the pixel has the pixel's own number.
    let rows = row..=row + 2 * CLAIM_ROWS;
    rows.map(|row| claims[row * CLAIM_STRIDE + column + CLAIM_COLUMNS]).fold(f32::INFINITY, f32::min)
}

/// The pixel whose centre is nearest to a position along an axis of `length` pixels; nothing outside the image or for
/// NaN.
#[inline]
fn nearest_pixel(position: impl Into<f64>, length: usize) -> Option<usize> {
    let position = position.into() + 0.5;
    // Not negative inside, so that truncation is floor.
    (position >= 0.0 && position < length as f64).then_some(position as usize)
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
        let mut claimed = Vec::new();
        for v in 0..COLOUR_HEIGHT {
            for u in 0..COLOUR_WIDTH {
                let nearest_mm = nearest_claim(&registered.claims, u, v);
                assert!(nearest_mm == 863.0 || nearest_mm == f32::INFINITY);
                if nearest_mm.is_finite() {
                    claimed.push((u as i64 - column, v as i64 - row));
                }
            }
        }
        let patch: Vec<_> = (-1..=1).flat_map(|dv| (-2..=2).map(move |du| (du, dv))).collect();
        assert_eq!(claimed, patch);
    }

    #[test]
    fn a_claim_does_not_wrap_around_the_image_border() {
        let mut claims = RegisteredDepth::empty().claims;
        claim(&mut claims, 0, 5, 700.0);
        claim(&mut claims, COLOUR_WIDTH - 1, COLOUR_HEIGHT - 1, 800.0);
        let pixels = (0..COLOUR_HEIGHT).flat_map(|v| (0..COLOUR_WIDTH).map(move |u| (u, v)));
        let claimed: Vec<_> = pixels.filter(|&(u, v)| nearest_claim(&claims, u, v).is_finite()).collect();
        assert_eq!(claimed.len(), 3 * 3 + 3 * 2);
        assert!(
            claimed.iter().all(|&(u, v)| u < 3 && v < 7 || u >= COLOUR_WIDTH - 3 && v >= COLOUR_HEIGHT - 2)
        );
    }

    #[test]
    fn the_memory_of_an_earlier_frame_leaves_no_trace() {
        let registration = plain();
        let (mut near, mut far) = (
            Image::filled(DEPTH_WIDTH, DEPTH_HEIGHT, 1000.0),
            Image::filled(DEPTH_WIDTH, DEPTH_HEIGHT, 1500.0),
        );
        for v in 100..200 {
            for u in 100..200 {
                near.set(u, v, 500.0);
                far.set(u, v + 60, 0.0);
            }
        }
        let mut registered = registration.register(&near).unwrap();
        registration.register_again(&far, &mut registered).unwrap();
        assert_eq!(registered, registration.register(&far).unwrap());
        assert!(registration.register_again(&Image::filled(3, 3, 1.0), &mut registered).is_err());
        assert_eq!(registered.depth, far);
    }

    #[test]
    fn an_image_of_another_size_is_refused() {
        let error = plain().register(&Image::filled(640, 480, 700.0)).unwrap_err();
        assert!(error.to_string().contains("640x480"), "{error}");
    }
}
