//! Geometry of the depth and the colour camera of a Kinect v2, from the device's factory parameters.
//!
//! Three coordinates of one depth measurement:
//! * *raw* pixel: where the sensor saw it, lens distortion included;
//! * *ideal* pixel: the same ray on a grid without distortion; raw = D(ideal) is a formula, its inverse an iteration;
//! * point: millimetres, depth camera frame, x right, y down, z forward.
//!
//! The factory model carries half a pixel of inconsistency that must be kept to agree with recorded data: D and the
//! colour polynomials count from the principal point to the pixel's index, (x - cx), the point formula to its far
//! corner, (x + 0.5 - cx). Half a pixel is 0.7 mm at half a metre.

use nalgebra::{Point3, Vector3};

use super::calibration::{ColourParameters, IrParameters};

/// Columns of the depth image.
pub const DEPTH_WIDTH: usize = 512;
/// Rows of the depth image.
pub const DEPTH_HEIGHT: usize = 424;
/// Columns of the colour image.
pub const COLOUR_WIDTH: usize = 1920;
/// Rows of the colour image.
pub const COLOUR_HEIGHT: usize = 1080;

/// Factory constant: depth pixels to the argument of the polynomials.
const DEPTH_PIXEL_SCALE: f64 = 0.01;
/// Factory constant: value of the polynomials to colour pixels.
const COLOUR_PIXEL_SCALE: f64 = 0.002_199;
/// The point formula looks through the far corner of the pixel's index.
const HALF_PIXEL: f64 = 0.5;

/// Steps allowed to invert the distortion. Factory lenses contract the error to a third or better at each step, so
/// 20 steps reach 1e-9 px; a lens that needs more folds the image over and has no inverse there.
const MAX_INVERSION_STEPS: u32 = 40;
/// Accepted error of the inversion, pixels.
const INVERSION_TOLERANCE_PX: f64 = 1e-9;

/// The depth camera: pinhole with radial (k1, k2, k3) and tangential (p1, p2) distortion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthCamera {
    ir: IrParameters,
}

impl DepthCamera {
    /// The camera with these factory parameters.
    pub fn new(ir: IrParameters) -> Self {
        Self { ir }
    }

    /// Focal lengths (x, y), pixels.
    pub fn focal_px(&self) -> (f64, f64) {
        (self.ir.fx, self.ir.fy)
    }

    /// Raw pixel at which the sensor sees the ray of an ideal pixel. Both may lie outside the image.
    pub fn distort(&self, x: f64, y: f64) -> (f64, f64) {
        let IrParameters { fx, fy, cx, cy, k1, k2, k3, p1, p2 } = self.ir;
        let (dx, dy) = ((x - cx) / fx, (y - cy) / fy);
        let (dx2, dy2, dxdy2) = (dx * dx, dy * dy, 2.0 * dx * dy);
        let r2 = dx2 + dy2;
        let radial = 1.0 + ((k3 * r2 + k2) * r2 + k1) * r2;
        let raw_x = fx * (dx * radial + p2 * (r2 + 2.0 * dx2) + p1 * dxdy2) + cx;
        let raw_y = fy * (dy * radial + p1 * (r2 + 2.0 * dy2) + p2 * dxdy2) + cy;
        (raw_x, raw_y)
    }

    /// Ideal pixel whose ray a raw pixel sees: x <- x + (raw - D(x)), within 1e-9 px.
    ///
    /// Nothing where the lens model folds over and the iteration does not settle.
    pub fn undistort(&self, raw_x: f64, raw_y: f64) -> Option<(f64, f64)> {
        let (mut x, mut y) = (raw_x, raw_y);
        for _ in 0..MAX_INVERSION_STEPS {
            let (seen_x, seen_y) = self.distort(x, y);
            let (error_x, error_y) = (raw_x - seen_x, raw_y - seen_y);
            if error_x.abs().max(error_y.abs()) < INVERSION_TOLERANCE_PX {
                return Some((x, y));
            }
            x += error_x;
            y += error_y;
        }
        None
    }

    /// Direction of the ray of an ideal pixel, scaled to z = 1.
    pub fn ray(&self, x: f64, y: f64) -> Vector3<f64> {
        let IrParameters { fx, fy, cx, cy, .. } = self.ir;
        Vector3::new((x + HALF_PIXEL - cx) / fx, (y + HALF_PIXEL - cy) / fy, 1.0)
    }

    /// Ideal pixel that sees a point; nothing for points that are not in front of the camera.
    pub fn project(&self, point_mm: &Point3<f64>) -> Option<(f64, f64)> {
        let IrParameters { fx, fy, cx, cy, .. } = self.ir;
        let Point3 { coords } = point_mm;
        (coords.z > 0.0)
            .then(|| (coords.x / coords.z * fx + cx - HALF_PIXEL, coords.y / coords.z * fy + cy - HALF_PIXEL))
    }
}

/// Where the colour camera sees an ideal depth pixel: a ray without parallax, and a row that depth does not change.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColourRay {
    /// Tangent of the ray from the colour camera, before parallax.
    pub slope: f64,
    /// Row of the colour image, pixels.
    pub row: f64,
}

/// The colour camera, and the factory's polynomials that lead from the depth grid into it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColourCamera {
    colour: ColourParameters,
    depth_centre: (f64, f64),
}

impl ColourCamera {
    /// The colour camera beside the depth camera `ir`, whose principal point the polynomials count from.
    pub fn new(colour: ColourParameters, ir: &IrParameters) -> Self {
        Self { colour, depth_centre: (ir.cx, ir.cy) }
    }

    /// Colour ray of an ideal depth pixel: two cubic polynomials with ten coefficients each.
    pub fn ray(&self, x: f64, y: f64) -> ColourRay {
        let c = &self.colour;
        let mx = (x - self.depth_centre.0) * DEPTH_PIXEL_SCALE;
        let my = (y - self.depth_centre.1) * DEPTH_PIXEL_SCALE;
        let (mx2, my2, mxmy) = (mx * mx, my * my, mx * my);
        let (mx3, my3, mx2my, mxmy2) = (mx2 * mx, my2 * my, mx2 * my, mx * my2);
        let wx = mx3 * c.mx_x3y0
            + my3 * c.mx_x0y3
            + mx2my * c.mx_x2y1
            + mxmy2 * c.mx_x1y2
            + mx2 * c.mx_x2y0
            + my2 * c.mx_x0y2
            + mxmy * c.mx_x1y1
            + mx * c.mx_x1y0
            + my * c.mx_x0y1
            + c.mx_x0y0;
        let wy = mx3 * c.my_x3y0
            + my3 * c.my_x0y3
            + mx2my * c.my_x2y1
            + mxmy2 * c.my_x1y2
            + mx2 * c.my_x2y0
            + my2 * c.my_x0y2
            + mxmy * c.my_x1y1
            + mx * c.my_x1y0
            + my * c.my_x0y1
            + c.my_x0y0;
        ColourRay {
            slope: wx / (c.fx * COLOUR_PIXEL_SCALE) - c.shift_m / c.shift_d,
            row: wy / COLOUR_PIXEL_SCALE + c.cy,
        }
    }

    /// Where the colour camera stands in the depth camera's frame, millimetres: a baseline to its left (the factory
    /// model has no other offset).
    pub fn centre_mm(&self) -> [f64; 3] {
        [-self.colour.shift_m, 0.0, 0.0]
    }

    /// Column at which a colour ray of this slope sees depth `z_mm`: the parallax of the baseline added.
    #[inline(always)]
    pub fn column(&self, slope: f64, z_mm: f64) -> f64 {
        (slope + self.colour.shift_m / z_mm) * self.colour.fx + self.colour.cx
    }

    /// The factory parameters under which [`ColourCamera::ray`] and [`ColourCamera::column`] are exactly a pinhole of
    /// focal length `focal_px` and centre `(cx, cy)` that stands `baseline_mm` to the left of the depth camera
    /// `ir`, its axes parallel: column = f (X + b) / Z + cx, row = f Y / Z + cy for a point of the depth camera.
    ///
    /// Both are linear in the depth pixel, so that the quadratic and cubic coefficients vanish.
    pub fn parallel_pinhole(
        focal_px: f64,
        (cx, cy): (f64, f64),
        baseline_mm: f64,
        ir: &IrParameters,
    ) -> ColourParameters {
        // The distance of zero shift only splits the constant term in two; this is every device's value.
        let shift_d = 863.0;
        let scale = focal_px * COLOUR_PIXEL_SCALE;
        ColourParameters {
            fx: focal_px,
            fy: focal_px,
            cx,
            cy,
            shift_d,
            shift_m: baseline_mm,
            mx_x1y0: scale / (DEPTH_PIXEL_SCALE * ir.fx),
            mx_x0y0: scale * (HALF_PIXEL / ir.fx + baseline_mm / shift_d),
            my_x0y1: scale / (DEPTH_PIXEL_SCALE * ir.fy),
            my_x0y0: scale * HALF_PIXEL / ir.fy,
            ..ColourParameters::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::FactoryCalibration;
    use super::*;

    /// An invented device in which every coefficient matters.
    fn invented() -> FactoryCalibration {
        let ir = IrParameters {
            fx: 366.1,
            fy: 366.7,
            cx: 257.3,
            cy: 207.9,
            k1: 0.0915,
            k2: -0.2702,
            k3: 0.0968,
            p1: 0.0004,
            p2: -0.0007,
        };
        let colour = ColourParameters {
            fx: 1080.5,
            fy: 1080.5,
            cx: 958.75,
            cy: 540.25,
            shift_d: 860.0,
            shift_m: 51.5,
            mx_x3y0: 0.00061,
            mx_x0y3: 0.00007,
            mx_x2y1: -0.00003,
            mx_x1y2: 0.00042,
            mx_x2y0: 0.00019,
            mx_x0y2: 0.00012,
            mx_x1y1: -0.0009,
            mx_x1y0: 0.637,
            mx_x0y1: -0.0021,
            mx_x0y0: 0.151,
            my_x3y0: 0.00002,
            my_x0y3: 0.00095,
            my_x2y1: 0.00055,
            my_x1y2: -0.00004,
            my_x2y0: -0.00008,
            my_x0y2: -0.00085,
            my_x1y1: 0.00013,
            my_x1y0: 0.0019,
            my_x0y1: 0.6355,
            my_x0y0: -0.0381,
        };
        FactoryCalibration { ir, colour }
    }

    /// Ideal pixel, depth, raw pixel, colour pixel and point (x, y); computed apart from this program, in double
    /// precision, from the formulas with every power written out.
    struct Vector {
        ideal: (f64, f64),
        z_mm: f64,
        raw: (f64, f64),
        colour: (f64, f64),
        point_mm: (f64, f64),
    }

    const VECTORS: [Vector; 3] = [
        Vector {
            ideal: (12.0, 33.0),
            z_mm: 640.0,
            raw: (19.4856, 38.5601),
            colour: (334.1285, 9.2632),
            point_mm: (-427.9486, -304.3796),
        },
        Vector {
            ideal: (301.0, 118.0),
            z_mm: 875.0,
            raw: (301.1988, 117.5627),
            colour: (1154.0470, 262.7900),
            point_mm: (105.6405, -213.3215),
        },
        Vector {
            ideal: (470.0, 402.0),
            z_mm: 1410.0,
            raw: (464.7040, 397.4022),
            colour: (1619.6876, 1089.6215),
            point_mm: (821.1199, 748.2574),
        },
    ];

    fn assert_near((ax, ay): (f64, f64), (bx, by): (f64, f64), tolerance: f64) {
        assert!(
            (ax - bx).abs() <= tolerance && (ay - by).abs() <= tolerance,
            "({ax}, {ay}) is not ({bx}, {by})"
        );
    }

    fn check(calibration: &FactoryCalibration, vector: &Vector, tolerance_px: f64) {
        let depth = DepthCamera::new(calibration.ir);
        let colour = ColourCamera::new(calibration.colour, &calibration.ir);
        let (x, y) = vector.ideal;
        assert_near(depth.distort(x, y), vector.raw, tolerance_px);
        let ray = colour.ray(x, y);
        assert_near((colour.column(ray.slope, vector.z_mm), ray.row), vector.colour, tolerance_px);
        let point = depth.ray(x, y) * vector.z_mm;
        assert_near((point.x, point.y), vector.point_mm, 1e-3);
        let (seen_x, seen_y) = depth.project(&Point3::from(point)).unwrap();
        assert_near((seen_x, seen_y), vector.ideal, 1e-9);
    }

    #[test]
    fn the_projects_own_vectors() {
        for vector in &VECTORS {
            check(&invented(), vector, 1e-4);
        }
    }

    #[test]
    fn the_factory_example_to_a_hundredth_of_a_pixel() {
        let shared = std::env::var_os("VARSAC_SHARED").map_or_else(
            || concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared").into(),
            std::path::PathBuf::from,
        );
        let path = shared.join("data/calib/kinect2-factory-example.json");
        let Ok(text) = std::fs::read_to_string(&path) else {
            println!("ABSENT: {} is not there; the 20 factory vectors were NOT checked", path.display());
            return;
        };
        let calibration: FactoryCalibration = serde_json::from_str(&text).unwrap();
        let example: serde_json::Value = serde_json::from_str(&text).unwrap();
        let vectors = example["test_vectors"].as_array().unwrap();
        assert_eq!(vectors.len(), 20);
        for vector in vectors {
            let number = |key: &str, index: usize| vector[key][index].as_f64().unwrap();
            let pair = |key: &str| (number(key, 0), number(key, 1));
            let (x_m, y_m) = pair("point_m");
            let vector = Vector {
                ideal: pair("undistorted_depth_pixel"),
                z_mm: vector["depth_mm"].as_f64().unwrap(),
                raw: pair("raw_depth_pixel"),
                colour: pair("color_pixel"),
                point_mm: (x_m * 1000.0, y_m * 1000.0),
            };
            check(&calibration, &vector, 0.01);
        }
    }

    #[test]
    fn undistortion_inverts_distortion_over_the_whole_image() {
        let camera = DepthCamera::new(invented().ir);
        for v in (0..DEPTH_HEIGHT).step_by(7) {
            for u in (0..DEPTH_WIDTH).step_by(5) {
                let raw = (u as f64, v as f64);
                let (x, y) = camera.undistort(raw.0, raw.1).unwrap();
                assert_near(camera.distort(x, y), raw, 1e-8);
            }
        }
    }

    #[test]
    fn a_lens_that_folds_over_has_no_inverse() {
        let camera = DepthCamera::new(IrParameters { k1: -8.0, ..invented().ir });
        assert_eq!(camera.undistort(0.0, 0.0), None);
        assert!(camera.undistort(257.0, 208.0).is_some());
    }

    #[test]
    fn a_parallel_pinhole_is_represented_exactly() {
        let ir = invented().ir;
        let (focal, centre, baseline) = (1080.0, (959.5, 539.5), 52.0);
        let depth = DepthCamera::new(ir);
        let colour = ColourCamera::new(ColourCamera::parallel_pinhole(focal, centre, baseline, &ir), &ir);
        for z_mm in [500.0, 700.0, 1000.0, 1500.0] {
            for (x, y) in [(0.0, 0.0), (200.0, 300.0), (511.0, 423.0)] {
                let point = depth.ray(x, y) * z_mm;
                let expected =
                    (focal * (point.x + baseline) / z_mm + centre.0, focal * point.y / z_mm + centre.1);
                let ray = colour.ray(x, y);
                assert_near((colour.column(ray.slope, z_mm), ray.row), expected, 1e-9);
            }
        }
    }

    #[test]
    fn nothing_behind_the_camera_is_seen() {
        let camera = DepthCamera::new(invented().ir);
        assert_eq!(camera.project(&Point3::new(0.0, 0.0, 0.0)), None);
        assert_eq!(camera.project(&Point3::new(0.0, 0.0, -5.0)), None);
        assert_eq!(camera.project(&Point3::new(0.0, 0.0, f64::NAN)), None);
    }
}
