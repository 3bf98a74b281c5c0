//! Back-projection: which points of space lie behind the pixels of each region.
//!
//! One [`View`] unites the two kinds of frame: colour and depth that share a pinhole camera's grid, and the Kinect
//! v2, whose depth grid is mapped into a colour image of another size. Regions always live in the colour image,
//! points always in the depth camera: millimetres, x right, y down, z forward. Coordinates are computed in `f64`
//! and rounded once, to the `f32` of the core.

use nalgebra::{Point3 as Point3f64, Vector3};
use varsac_core::Point3;

use crate::error::InputError;
use crate::image::DepthImage;
use crate::kinect::{COLOUR_HEIGHT, COLOUR_WIDTH, RegisteredDepth, Registration};
use crate::segment::Regions;

/// A camera without distortion. Pixel centres lie at integer coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pinhole {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
}

impl Pinhole {
    /// A camera of focal lengths `fx`, `fy` and principal point (`cx`, `cy`), pixels.
    ///
    /// # Errors
    /// Focal lengths that are not positive, or any number that is not finite.
    pub fn new(fx: f64, fy: f64, cx: f64, cy: f64) -> Result<Self, InputError> {
        let finite = [fx, fy, cx, cy].iter().all(|value| value.is_finite());
        if !finite || fx <= 0.0 || fy <= 0.0 {
            return Err(InputError::at(
                "camera intrinsics",
                format!("fx {fx}, fy {fy}, cx {cx}, cy {cy} describe no camera"),
                "give positive focal lengths and a finite principal point, in pixels",
            ));
        }
        Ok(Self { fx, fy, cx, cy })
    }

    /// Focal lengths (x, y), pixels.
    pub fn focal_px(&self) -> (f64, f64) {
        (self.fx, self.fy)
    }

    /// Direction of the ray of a pixel, scaled to z = 1.
    pub fn ray(&self, u: f64, v: f64) -> Vector3<f64> {
        Vector3::new((u - self.cx) / self.fx, (v - self.cy) / self.fy, 1.0)
    }

    /// Pixel that sees a point; nothing for points that are not in front of the camera.
    pub fn project(&self, point_mm: &Point3f64<f64>) -> Option<(f64, f64)> {
        let Point3f64 { coords } = point_mm;
        (coords.z > 0.0)
            .then(|| (coords.x / coords.z * self.fx + self.cx, coords.y / coords.z * self.fy + self.cy))
    }
}

/// One depth image, and how it relates to space and to the colour image beside it.
#[derive(Debug, Clone, Copy)]
pub enum View<'a> {
    /// Depth and colour share one grid and one camera.
    Registered {
        /// Depth of each pixel.
        depth: &'a DepthImage,
        /// The camera of both.
        camera: Pinhole,
    },
    /// A Kinect v2 pair.
    Kinect {
        /// Depth on the ideal grid, with its place in the colour image.
        depth: &'a RegisteredDepth,
        /// The device.
        registration: &'a Registration,
    },
}

/// Which depth pixels become points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointOptions {
    /// Nearest depth, millimetres.
    pub near_mm: f32,
    /// Farthest depth, millimetres.
    pub far_mm: f32,
    /// A pixel is dropped as flying (mixed between two surfaces) when the measured depths of its 3x3 neighbourhood
    /// span more than this, millimetres. Nothing keeps them all, as the paper does.
    pub flying_span_mm: Option<f32>,
}

impl Default for PointOptions {
    /// 0.3 to 4.5 m, flying pixels kept.
    fn default() -> Self {
        Self { near_mm: 300.0, far_mm: 4500.0, flying_span_mm: None }
    }
}

/// A point of a region with the two pixels it was seen by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewPoint {
    /// Millimetres, depth camera frame.
    pub point_mm: Point3,
    /// Column and row of the depth image (ideal grid).
    pub depth_px: (u32, u32),
    /// Column and row of the colour image.
    pub colour_px: (u32, u32),
}

impl View<'_> {
    /// The depth image, millimetres, 0 = no measurement; on the ideal grid for a Kinect.
    pub fn depth(&self) -> &DepthImage {
        match self {
            Self::Registered { depth, .. } => depth,
            Self::Kinect { depth, .. } => &depth.depth,
        }
    }

    /// Width and height of the colour image, pixels.
    pub fn colour_size(&self) -> (usize, usize) {
        match self {
            Self::Registered { depth, .. } => (depth.width, depth.height),
            Self::Kinect { .. } => (COLOUR_WIDTH, COLOUR_HEIGHT),
        }
    }

    /// Direction of the ray of a depth pixel, scaled to z = 1.
    pub fn ray(&self, u: f64, v: f64) -> Vector3<f64> {
        match self {
            Self::Registered { camera, .. } => camera.ray(u, v),
            Self::Kinect { registration, .. } => registration.ray(u, v),
        }
    }

    /// Focal lengths (x, y) of the depth image, pixels.
    pub fn focal_px(&self) -> (f64, f64) {
        match self {
            Self::Registered { camera, .. } => camera.focal_px(),
            Self::Kinect { registration, .. } => registration.depth_camera().focal_px(),
        }
    }

    /// Width and height of what one depth pixel covers of a frontal surface at `z_mm`, millimetres.
    pub fn footprint_mm(&self, z_mm: f64) -> (f64, f64) {
        let (fx, fy) = self.focal_px();
        (z_mm / fx, z_mm / fy)
    }

    /// Colour pixel (column, row, fractional) that sees a point of the depth camera frame. It may lie outside the
    /// image; nothing for points that are not in front of the camera.
    pub fn project(&self, point_mm: &Point3f64<f64>) -> Option<(f64, f64)> {
        match self {
            Self::Registered { camera, .. } => camera.project(point_mm),
            Self::Kinect { registration, .. } => registration.project_to_colour(point_mm),
        }
    }

    /// Colour pixel (column, row) of a depth pixel; nothing outside the image, and for a Kinect nothing without
    /// depth or where the colour camera does not see the surface.
    pub fn colour_px(&self, u: usize, v: usize) -> Option<(u32, u32)> {
        match self {
            Self::Registered { depth, .. } => {
                (u < depth.width && v < depth.height).then_some((u as u32, v as u32))
            }
            Self::Kinect { depth, .. } => {
                let (column, row) = depth.colour.get(u as i64, v as i64).flatten()?;
                // Positions round to pixels inside the image (`RegisteredDepth::colour`); -0.5 casts to 0.
                Some(((column + 0.5) as u32, (row + 0.5) as u32))
            }
        }
    }

    /// The points of each region: entry `k` belongs to `regions.list[k]`, in raster order of the depth image.
    /// `O(depth pixels)`.
    ///
    /// # Errors
    /// When the regions are not of the size of the colour image.
    pub fn points(
        &self,
        regions: &Regions,
        options: &PointOptions,
    ) -> Result<Vec<Vec<ViewPoint>>, InputError> {
        let (width, height) = self.colour_size();
        if (regions.image.width, regions.image.height) != (width, height) {
            return Err(InputError::at(
                "mask",
                format!("is {}x{} pixels", regions.image.width, regions.image.height),
                format!("give one of the size of the colour image, {width}x{height}"),
            ));
        }
        let depth = self.depth();
        let mut points: Vec<Vec<ViewPoint>> = vec![Vec::new(); regions.list.len()];
        for (v, row) in depth.pixels.chunks_exact(depth.width.max(1)).enumerate() {
            for (u, &z_mm) in row.iter().enumerate() {
                // Written so that NaN fails it too.
                if !(z_mm > 0.0 && (options.near_mm..=options.far_mm).contains(&z_mm)) {
                    continue;
                }
                let Some(colour_px) = self.colour_px(u, v) else { continue };
                let label = regions.image.pixels[colour_px.1 as usize * width + colour_px.0 as usize];
                let Some(place) = label.checked_sub(1).and_then(|place| points.get_mut(place as usize))
                else {
                    continue;
                };
                if options.flying_span_mm.is_some_and(|limit_mm| depth_span_mm(depth, u, v) > limit_mm) {
                    continue;
                }
                let point = self.ray(u as f64, v as f64) * f64::from(z_mm);
                let point_mm = Point3::new(point.x as f32, point.y as f32, point.z as f32);
                place.push(ViewPoint { point_mm, depth_px: (u as u32, v as u32), colour_px });
            }
        }
        Ok(points)
    }
}

/// Largest minus smallest measured depth of the 3x3 neighbourhood of a pixel, millimetres.
pub(crate) fn depth_span_mm(depth: &DepthImage, u: usize, v: usize) -> f32 {
    let (mut nearest, mut farthest) = (f32::INFINITY, 0.0_f32);
    for dv in -1..=1 {
        for du in -1..=1 {
            if let Some(z_mm) = depth.get(u as i64 + du, v as i64 + dv).filter(|&z_mm| z_mm > 0.0) {
                nearest = nearest.min(z_mm);
                farthest = farthest.max(z_mm);
            }
        }
    }
    (farthest - nearest).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{Image, LabelImage};
    use crate::segment::AreaLimits;
    use crate::segment::regions::{connected_regions, instance_regions};

    fn camera() -> Pinhole {
        Pinhole::new(400.0, 500.0, 3.5, 2.0).unwrap()
    }

    #[test]
    fn points_are_those_of_the_pinhole_and_carry_their_pixel() {
        let mut depth = Image::filled(8, 6, 700.0);
        depth.set(5, 1, 0.0);
        depth.set(6, 1, f32::NAN);
        depth.set(7, 1, 299.9);
        depth.set(4, 1, 4500.0);
        let view = View::Registered { depth: &depth, camera: camera() };
        let mut mask = LabelImage::filled(8, 6, 0);
        for u in 2..8 {
            mask.set(u, 1, 1);
        }
        mask.set(0, 5, 2);
        let points =
            view.points(&instance_regions(&mask, AreaLimits::ALL), &PointOptions::default()).unwrap();
        assert_eq!(points.iter().map(Vec::len).collect::<Vec<_>>(), [3, 1]);
        assert_eq!(points[0][2].point_mm, Point3::new(5.625, -9.0, 4500.0));
        assert_eq!(points[0][2].colour_px, (4, 1));
        assert_eq!(points[1][0].depth_px, (0, 5));
        let (u, v) = view.project(&points[1][0].point_mm.cast()).unwrap();
        assert!(u.abs() < 1e-5 && (v - 5.0).abs() < 1e-5, "({u}, {v})");
        assert_eq!(view.footprint_mm(800.0), (2.0, 1.6));
    }

    #[test]
    fn the_flying_pixel_between_two_surfaces_goes() {
        let mut depth = Image::filled(9, 3, 700.0);
        for v in 0..3 {
            depth.set(4, v, 760.0);
            for u in 5..9 {
                depth.set(u, v, 900.0);
            }
        }
        let view = View::Registered { depth: &depth, camera: camera() };
        let regions = connected_regions(&LabelImage::filled(9, 3, 1), AreaLimits::ALL);
        let options = PointOptions { flying_span_mm: Some(30.0), ..PointOptions::default() };
        let points = view.points(&regions, &options).unwrap();
        let columns: Vec<u32> =
            points[0].iter().filter(|p| p.depth_px.1 == 1).map(|p| p.depth_px.0).collect();
        assert_eq!(columns, [0, 1, 2, 6, 7, 8]);
        assert_eq!(view.points(&regions, &PointOptions::default()).unwrap()[0].len(), 27);
    }

    #[test]
    fn a_mask_of_another_size_is_refused() {
        let depth = Image::filled(8, 6, 700.0);
        let view = View::Registered { depth: &depth, camera: camera() };
        let regions = connected_regions(&LabelImage::filled(6, 8, 1), AreaLimits::ALL);
        let error = view.points(&regions, &PointOptions::default()).unwrap_err();
        assert!(error.to_string().contains("6x8") && error.to_string().contains("8x6"), "{error}");
    }

    #[test]
    fn a_camera_that_is_none_is_refused() {
        for (fx, cx) in [(0.0, 1.0), (-3.0, 1.0), (f64::NAN, 1.0), (f64::INFINITY, 1.0), (400.0, f64::NAN)] {
            assert!(Pinhole::new(fx, 400.0, cx, 1.0).is_err());
        }
    }
}
