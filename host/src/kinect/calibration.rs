//! The factory parameters of one Kinect v2, as its driver reports them and `calibration.json` keeps them.
//!
//! The file has one object per camera, `IrCameraParams` (which is also the depth camera) and `ColorCameraParams`, with
//! the names of libfreenect2's structures as keys. Other keys are ignored.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::file;

/// Columns and rows of the colour image that the parameters belong to.
pub const COLOUR_SIZE: (usize, usize) = (1920, 1080);
/// Columns and rows of the depth image that the parameters belong to.
pub const DEPTH_SIZE: (usize, usize) = (512, 424);

const REMEDY: &str =
    "give the factory parameters of the device as IrCameraParams and ColorCameraParams, complete";

/// Everything the factory stored about the two cameras of one device.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct FactoryCalibration {
    /// The infrared camera, which measures depth.
    #[serde(rename = "IrCameraParams")]
    pub ir: IrParameters,
    /// The colour camera and the mapping of depth pixels onto it.
    #[serde(rename = "ColorCameraParams")]
    pub colour: ColourParameters,
}

/// Pinhole model and lens distortion of the infrared camera; pixels of the 512x424 image.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct IrParameters {
    /// Focal length along x, pixels.
    pub fx: f64,
    /// Focal length along y, pixels.
    pub fy: f64,
    /// Column of the principal point, pixels.
    pub cx: f64,
    /// Row of the principal point, pixels.
    pub cy: f64,
    /// Radial distortion, coefficient of r^2.
    pub k1: f64,
    /// Radial distortion, coefficient of r^4.
    pub k2: f64,
    /// Radial distortion, coefficient of r^6.
    pub k3: f64,
    /// First tangential distortion coefficient.
    pub p1: f64,
    /// Second tangential distortion coefficient.
    pub p2: f64,
}

/// Pinhole model of the colour camera (pixels of the 1920x1080 image) and the two cubic polynomials that carry an
/// ideal depth pixel to it: `mx_x2y1` multiplies mx^2 my in the column, `my_x2y1` in the row.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "the names say which monomial each coefficient multiplies")]
pub struct ColourParameters {
    /// Focal length along x, pixels.
    pub fx: f64,
    /// Focal length along y, pixels.
    pub fy: f64,
    /// Column of the principal point, pixels.
    pub cx: f64,
    /// Row of the principal point, pixels.
    pub cy: f64,
    /// Depth at which the parallax between the cameras is zero, millimetres.
    pub shift_d: f64,
    /// Distance between the cameras, millimetres.
    pub shift_m: f64,
    pub mx_x3y0: f64,
    pub mx_x0y3: f64,
    pub mx_x2y1: f64,
    pub mx_x1y2: f64,
    pub mx_x2y0: f64,
    pub mx_x0y2: f64,
    pub mx_x1y1: f64,
    pub mx_x1y0: f64,
    pub mx_x0y1: f64,
    pub mx_x0y0: f64,
    pub my_x3y0: f64,
    pub my_x0y3: f64,
    pub my_x2y1: f64,
    pub my_x1y2: f64,
    pub my_x2y0: f64,
    pub my_x0y2: f64,
    pub my_x1y1: f64,
    pub my_x1y0: f64,
    pub my_x0y1: f64,
    pub my_x0y0: f64,
}

impl FactoryCalibration {
    /// Reads `calibration.json`.
    ///
    /// # Errors
    /// When the file cannot be read, is no JSON, lacks a parameter, or has one that no camera can have.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        Self::parse(&path.display().to_string(), &file::read_whole(path, file::MAX_JSON_BYTES)?)
    }

    /// [`Self::read`] for bytes already in memory; `place` names them in errors.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(place: &str, bytes: &[u8]) -> Result<Self, InputError> {
        file::parse_json::<Self>(place, bytes, REMEDY)?.checked(place)
    }

    /// Refuses the values that the mapping divides by when they are zero or not of a camera. JSON has no NaN.
    fn checked(self, place: &str) -> Result<Self, InputError> {
        let focal_lengths = [
            ("IrCameraParams.fx", self.ir.fx),
            ("IrCameraParams.fy", self.ir.fy),
            ("ColorCameraParams.fx", self.colour.fx),
            ("ColorCameraParams.fy", self.colour.fy),
            ("ColorCameraParams.shift_d", self.colour.shift_d),
        ];
        for (name, value) in focal_lengths {
            if !(1.0..=1.0e6).contains(&value) {
                let what = format!("{name} is {value}, which must lie between 1 and 1e6");
                return Err(InputError::at(place, what, REMEDY));
            }
        }
        Ok(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{factory_parameters, shared_data};

    fn parse(value: &serde_json::Value) -> Result<FactoryCalibration, InputError> {
        FactoryCalibration::parse("calibration.json", value.to_string().as_bytes())
    }

    #[test]
    fn every_key_lands_in_the_field_of_its_name() {
        let calibration = parse(&factory_parameters()).unwrap();
        assert_eq!((calibration.colour.mx_x2y1, calibration.colour.my_x0y3), (21.0, 103.0));
        assert_eq!((calibration.colour.shift_d, calibration.ir.k2), (863.0, -0.272));
        let written = serde_json::to_value(calibration).unwrap();
        for camera in ["IrCameraParams", "ColorCameraParams"] {
            assert_eq!(written[camera], factory_parameters()[camera]);
        }
    }

    #[test]
    fn a_missing_or_impossible_parameter_is_named() {
        let mut incomplete = factory_parameters();
        incomplete["ColorCameraParams"].as_object_mut().unwrap().remove("my_x1y2");
        let message = parse(&incomplete).unwrap_err().to_string();
        assert!(message.contains("missing field `my_x1y2` at line 1"), "{message}");
        for (camera, key, value) in [
            ("IrCameraParams", "fx", 0.0),
            ("ColorCameraParams", "fy", -1.0),
            ("ColorCameraParams", "shift_d", 0.0),
        ] {
            let mut wrong = factory_parameters();
            wrong[camera][key] = value.into();
            let message = parse(&wrong).unwrap_err().to_string();
            assert!(message.contains(&format!("{camera}.{key} is {value},")), "{message}");
        }
        assert!(FactoryCalibration::parse("c.json", b"{\"IrCameraParams\": {\"fx\": 1e999}}").is_err());
    }
    #[test]
    fn the_parameters_of_a_real_device_are_read() {
        let Some(path) = shared_data("calib/kinect2-factory-example.json") else { return };
        let calibration = FactoryCalibration::read(&path).unwrap();
        assert_eq!((calibration.ir.k2, calibration.ir.p2), (-0.272_185_713_052_749_63, 0.0));
        assert_eq!(calibration.colour.mx_x1y0, 0.636_134_624_481_201_2);
        assert_eq!(calibration.colour.my_x0y1, 0.634_756_326_675_415);
        assert_eq!((calibration.colour.shift_d, calibration.colour.shift_m), (863.0, 52.0));
    }
}
