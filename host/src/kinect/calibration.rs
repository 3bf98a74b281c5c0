//! Factory parameters of one Kinect v2, as the device stores them and as `calibration.json` carries them.

use serde::{Deserialize, Serialize};

/// Depth (infrared) camera: pinhole with radial and tangential distortion. Lengths in pixels of the 512x424 image.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct IrParameters {
    pub fx: f64,
    pub fy: f64,
    pub cx: f64,
    pub cy: f64,
    pub k1: f64,
    pub k2: f64,
    pub k3: f64,
    pub p1: f64,
    pub p2: f64,
}

/// Colour camera: pinhole, the parallax pair, and two cubic polynomials whose coefficients are named by powers
/// (`mx_x2y1` multiplies mx^2 my). Lengths in pixels of the 1920x1080 image; shifts in millimetres.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[allow(missing_docs)]
pub struct ColourParameters {
    pub fx: f64,
    pub fy: f64,
    pub cx: f64,
    pub cy: f64,
    pub shift_d: f64,
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

/// Everything the device stores about its two cameras.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FactoryCalibration {
    /// Depth camera.
    #[serde(rename = "IrCameraParams")]
    pub ir: IrParameters,
    /// Colour camera and the mapping into it.
    #[serde(rename = "ColorCameraParams")]
    pub colour: ColourParameters,
}
