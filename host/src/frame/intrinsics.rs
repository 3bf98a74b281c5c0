//! `intrinsics.json`: the pinhole camera that colour and depth of a registered frame share, and the depth unit.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::InputError;
use crate::file;

const REMEDY: &str = "give fx, fy, cx and cy in pixels and depth_scale_m in metres per count";

/// The depth unit when the file states none: one count is a millimetre.
pub(super) const DEFAULT_DEPTH_SCALE_M: f64 = 0.001;

/// Focal lengths that a camera can have, pixels.
const FOCAL_LENGTHS_PX: std::ops::RangeInclusive<f64> = 1.0..=1.0e6;
/// Principal points that a (cropped) camera image can have, pixels.
const CENTRES_PX: std::ops::RangeInclusive<f64> = -1.0e6..=1.0e6;
/// Depth units that make sense, metres: a tenth of a micrometre to ten centimetres. A user who states counts per
/// metre (1000, 5000) instead of metres per count is told.
const DEPTH_SCALES_M: std::ops::RangeInclusive<f64> = 1.0e-7..=0.1;

/// A pinhole camera without distortion; pixel centres at integer coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics {
    /// Focal length along x, pixels.
    pub fx: f64,
    /// Focal length along y, pixels.
    pub fy: f64,
    /// Column of the principal point, pixels.
    pub cx: f64,
    /// Row of the principal point, pixels.
    pub cy: f64,
    /// Columns of the image.
    pub width: usize,
    /// Rows of the image.
    pub height: usize,
}

/// The file as it stands on disk; keys that are not listed are ignored.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct IntrinsicsFile {
    width: Option<usize>,
    height: Option<usize>,
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
    depth_scale_m: Option<f64>,
    registered_to: Option<String>,
    #[serde(default, skip_serializing)]
    distortion: serde_json::Value,
}

impl IntrinsicsFile {
    pub(super) fn read(path: &Path) -> Result<Self, InputError> {
        Self::parse(path, &file::read_whole(path, file::MAX_JSON_BYTES)?)
    }

    /// [`Self::read`] for bytes already in memory; `path` names them in errors.
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Self, InputError> {
        file::parse_json::<Self>(&path.display().to_string(), bytes, REMEDY)?.checked(path)
    }

    /// Refuses what no camera can have.
    pub(super) fn checked(self, path: &Path) -> Result<Self, InputError> {
        for (name, value, range) in [
            ("fx", self.fx, &FOCAL_LENGTHS_PX),
            ("fy", self.fy, &FOCAL_LENGTHS_PX),
            ("cx", self.cx, &CENTRES_PX),
            ("cy", self.cy, &CENTRES_PX),
            ("depth_scale_m", self.depth_scale_m(), &DEPTH_SCALES_M),
        ] {
            if !range.contains(&value) {
                let what = format!("{name} is {value}, outside {:e} to {:e}", range.start(), range.end());
                return Err(InputError::in_file(path, what, REMEDY));
            }
        }
        if !is_zero(&self.distortion) {
            let remedy = "undistort the images, then state distortion null";
            return Err(InputError::in_file(
                path,
                "states a lens distortion, which is not applied here",
                remedy,
            ));
        }
        Ok(self)
    }

    /// The file that [`Self::read`] turns into `camera` and [`DEFAULT_DEPTH_SCALE_M`].
    pub(super) fn of(camera: &Intrinsics) -> Self {
        let Intrinsics { fx, fy, cx, cy, width, height } = *camera;
        Self {
            width: Some(width),
            height: Some(height),
            fx,
            fy,
            cx,
            cy,
            depth_scale_m: Some(DEFAULT_DEPTH_SCALE_M),
            registered_to: Some("color".to_owned()),
            distortion: serde_json::Value::Null,
        }
    }

    /// Metres per count of the depth image.
    pub(super) fn depth_scale_m(&self) -> f64 {
        self.depth_scale_m.unwrap_or(DEFAULT_DEPTH_SCALE_M)
    }

    /// Whether depth and colour show the same pixels: always, unless the file says `"registered_to": "none"`.
    pub(super) fn is_registered(&self) -> bool {
        self.registered_to.as_deref() != Some("none")
    }

    /// The camera of images of this size, which must be the size stated, if one is.
    pub(super) fn camera(&self, path: &Path, width: usize, height: usize) -> Result<Intrinsics, InputError> {
        let stated = (self.width.unwrap_or(width), self.height.unwrap_or(height));
        if stated != (width, height) {
            let what =
                format!("is for {} x {} pixels, and the images have {width} x {height}", stated.0, stated.1);
            return Err(InputError::in_file(path, what, "give the intrinsics of these images"));
        }
        let Self { fx, fy, cx, cy, .. } = *self;
        Ok(Intrinsics { fx, fy, cx, cy, width, height })
    }
}

/// Whether a distortion is absent: null, zero, or nothing but zeros.
fn is_zero(distortion: &serde_json::Value) -> bool {
    match distortion {
        serde_json::Value::Null => true,
        serde_json::Value::Number(number) => number.as_f64() == Some(0.0),
        serde_json::Value::Array(values) => values.iter().all(is_zero),
        serde_json::Value::Object(values) => values.values().all(is_zero),
        _ => false,
    }
}
