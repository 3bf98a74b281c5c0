//! Reads and writes frame folders: one view of a depth camera.
//!
//! | file | content |
//! |---|---|
//! | `color.png` | 8-bit colour image |
//! | `depth.png` | 16-bit counts, 0 = no measurement |
//! | `intrinsics.json` | `fx fy cx cy`, `depth_scale_m` (default 0.001), optional `width height registered_to` |
//! | `calibration.json` | optional: factory parameters of a Kinect v2, for a pair that is not registered |
//! | `mask.png` | optional, of the colour image's size: 0 = background |
//! | `instances.png` | optional, of the colour image's size: the value names the fruit |
//!
//! Colour and depth of one size are taken as registered, pixel on pixel, and need `intrinsics.json` (which may deny it
//! with `"registered_to": "none"`). Otherwise they must be the 1920x1080 and 512x424 images of a Kinect v2 and need
//! `calibration.json`; of `intrinsics.json`, should there be one, only `depth_scale_m` is then used.

mod intrinsics;
pub mod png_file;

use std::path::Path;

pub use self::intrinsics::Intrinsics;
use self::intrinsics::{DEFAULT_DEPTH_SCALE_M, IntrinsicsFile};
use self::png_file::{decode_colour, decode_counts, decode_instances, decode_mask};
use crate::error::{InputError, write_whole};
use crate::image::{ColourImage, DepthImage, Image, LabelImage};
use crate::kinect::calibration::{COLOUR_SIZE, DEPTH_SIZE, FactoryCalibration};

/// One view: a colour image, a depth image and how they belong together.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Name of the folder.
    pub name: String,
    /// The colour image.
    pub colour: ColourImage,
    /// Depth along z in millimetres, 0 = no measurement.
    pub depth_mm: DepthImage,
    /// What maps pixels to space.
    pub geometry: Geometry,
    /// Where fruit is, in the colour image: 0 or 255.
    pub mask: Option<LabelImage>,
    /// Which fruit is where, in the colour image: 0 = none.
    pub instances: Option<LabelImage>,
}

/// How colour and depth belong together.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// Pixel on pixel, seen by one pinhole camera.
    Registered(Intrinsics),
    /// Two cameras of a Kinect v2, tied by its factory parameters.
    Factory(Box<FactoryCalibration>),
}

impl Frame {
    /// Reads a frame folder.
    ///
    /// # Errors
    /// One sentence with file, value and remedy: a file is missing, unreadable, cut short or of the wrong bit depth;
    /// colour and depth differ in size and nothing registers them; intrinsics are missing, impossible or for another
    /// size; a mask is not of the colour image's size.
    pub fn read(folder: &Path) -> Result<Self, InputError> {
        if !folder.is_dir() {
            let remedy = "give a folder with color.png, depth.png and intrinsics.json";
            return Err(InputError::in_file(folder, "is no frame folder", remedy));
        }
        let colour = png_file::read(&required(folder, "color.png")?, decode_colour)?;
        let counts = png_file::read(&required(folder, "depth.png")?, decode_counts)?;
        let intrinsics_path = folder.join("intrinsics.json");
        let intrinsics = optional(folder, "intrinsics.json", IntrinsicsFile::read)?;
        let calibration = optional(folder, "calibration.json", FactoryCalibration::read)?;
        let one_size = size(&colour) == size(&counts);
        let registered = one_size && intrinsics.as_ref().is_none_or(IntrinsicsFile::is_registered);
        let geometry = match (&intrinsics, calibration) {
            (Some(file), _) if registered => {
                Geometry::Registered(file.camera(&intrinsics_path, colour.width, colour.height)?)
            }
            (_, Some(calibration)) => Geometry::Factory(Box::new(calibration)),
            (None, None) if registered => {
                let remedy = "add it with fx, fy, cx and cy of the images, in pixels";
                return Err(InputError::in_file(folder, "has no intrinsics.json", remedy));
            }
            _ => {
                let what = format!(
                    "color.png has {} and depth.png {} pixels, and neither is registered to the other",
                    shown(size(&colour)),
                    shown(size(&counts))
                );
                let remedy = "register them, or add the camera's factory parameters as calibration.json";
                return Err(InputError::in_file(folder, what, remedy));
            }
        };
        let scale_mm = 1000.0 * intrinsics.map_or(DEFAULT_DEPTH_SCALE_M, |file| file.depth_scale_m());
        let depth = counts.pixels.iter().map(|&count| (f64::from(count) * scale_mm) as f32).collect();
        let frame = Self {
            name: folder_name(folder),
            colour,
            depth_mm: Image { width: counts.width, height: counts.height, pixels: depth },
            geometry,
            mask: optional(folder, "mask.png", |path| png_file::read(path, decode_mask))?,
            instances: optional(folder, "instances.png", |path| png_file::read(path, decode_instances))?,
        };
        frame.check_sizes(folder)?;
        Ok(frame)
    }

    /// Writes the frame as a folder that [`Self::read`] reads back; each file whole or not at all, and none if the
    /// frame contradicts itself. Depth is rounded to millimetres.
    ///
    /// # Errors
    /// When the folder cannot be written or holds a file of another frame that would be read with this one; when
    /// sizes contradict each other or a depth is not within 0 to 65535 mm.
    pub fn write(&self, folder: &Path) -> Result<(), InputError> {
        self.check_sizes(folder)?;
        let png = |name: &str, encoded: Result<Vec<u8>, String>| {
            encoded.map_err(|what| InputError::in_file(&folder.join(name), what, "give images with pixels"))
        };
        let (intrinsics, calibration) = match &self.geometry {
            Geometry::Registered(camera) => {
                let path = folder.join("intrinsics.json");
                (Some(json(&path, &IntrinsicsFile::of(camera).checked(&path)?)?), None)
            }
            Geometry::Factory(calibration) => {
                (None, Some(json(&folder.join("calibration.json"), calibration)?))
            }
        };
        let labels = |name, image: &Option<LabelImage>| {
            image.as_ref().map(|image| png(name, png_file::encode_labels(image))).transpose()
        };
        let files = [
            ("color.png", Some(png("color.png", png_file::encode_colour(&self.colour))?)),
            ("depth.png", Some(png("depth.png", png_file::encode_counts(&self.counts(folder)?))?)),
            ("intrinsics.json", intrinsics),
            ("calibration.json", calibration),
            ("mask.png", labels("mask.png", &self.mask)?),
            ("instances.png", labels("instances.png", &self.instances)?),
        ];
        std::fs::create_dir_all(folder).map_err(|error| {
            InputError::in_file(
                folder,
                format!("cannot be created ({error})"),
                "give a folder that can be written",
            )
        })?;
        for (name, content) in &files {
            if content.is_none() && folder.join(name).exists() {
                let what = "is there already and is no part of the frame to be written";
                return Err(InputError::in_file(&folder.join(name), what, "give an empty folder"));
            }
        }
        for (name, content) in files {
            if let Some(bytes) = content {
                write_whole(&folder.join(name), &bytes)?;
            }
        }
        Ok(())
    }

    /// Depth in whole millimetres.
    fn counts(&self, folder: &Path) -> Result<Image<u16>, InputError> {
        let DepthImage { width, height, ref pixels } = self.depth_mm;
        let count = |(index, &depth_mm): (usize, &f32)| {
            let rounded = depth_mm.round();
            if (0.0..=f32::from(u16::MAX)).contains(&rounded) {
                return Ok(rounded as u16);
            }
            let what = format!("depth at column {}, row {} is {depth_mm} mm", index % width, index / width);
            Err(InputError::in_file(folder, what, "keep depth within 0 (none) to 65535 mm"))
        };
        let pixels = pixels.iter().enumerate().map(count).collect::<Result<_, _>>()?;
        Ok(Image { width, height, pixels })
    }

    fn check_sizes(&self, folder: &Path) -> Result<(), InputError> {
        let (colour, depth) = (size(&self.colour), size(&self.depth_mm));
        let (colour_due, depth_due, remedy) = match &self.geometry {
            Geometry::Registered(camera) => {
                let due = (camera.width, camera.height);
                (due, due, "give images of the size that the intrinsics are for")
            }
            Geometry::Factory(_) => {
                (COLOUR_SIZE, DEPTH_SIZE, "give the images as the Kinect v2 delivers them")
            }
        };
        if !is_whole(&self.colour) || !is_whole(&self.depth_mm) {
            let what = "has an image that is empty or has not the pixels of its size";
            return Err(InputError::in_file(folder, what, "give whole images"));
        }
        let labels = |image: &Option<LabelImage>| image.as_ref().map_or(colour, size);
        for (name, found, due, remedy) in [
            ("color.png", colour, colour_due, remedy),
            ("depth.png", depth, depth_due, remedy),
            ("mask.png", labels(&self.mask), colour, "give a mask of the colour image's size"),
            ("instances.png", labels(&self.instances), colour, "give labels of the colour image's size"),
        ] {
            if found != due {
                let what = format!("has {} pixels where {} are due", shown(found), shown(due));
                return Err(InputError::in_file(&folder.join(name), what, remedy));
            }
        }
        Ok(())
    }
}

/// Whether an image has pixels, and as many as its size says.
fn is_whole<T>(image: &Image<T>) -> bool {
    !image.pixels.is_empty() && image.width.checked_mul(image.height) == Some(image.pixels.len())
}

fn size<T>(image: &Image<T>) -> (usize, usize) {
    (image.width, image.height)
}

fn shown((width, height): (usize, usize)) -> String {
    format!("{width} x {height}")
}

/// The path of a file that a frame cannot do without.
fn required(folder: &Path, name: &str) -> Result<std::path::PathBuf, InputError> {
    let path = folder.join(name);
    if path.exists() {
        return Ok(path);
    }
    let remedy = "give a folder with color.png, depth.png and intrinsics.json";
    Err(InputError::in_file(folder, format!("has no {name}"), remedy))
}

/// The bytes of a JSON file.
fn json(path: &Path, value: &impl serde::Serialize) -> Result<Vec<u8>, InputError> {
    let text = serde_json::to_string_pretty(value).map_err(|error| {
        InputError::in_file(path, format!("cannot be written ({error})"), "give finite parameters")
    })?;
    Ok((text + "\n").into_bytes())
}

/// Reads a file if it is there.
fn optional<T>(
    folder: &Path,
    name: &str,
    read: impl Fn(&Path) -> Result<T, InputError>,
) -> Result<Option<T>, InputError> {
    let path = folder.join(name);
    if path.exists() { read(&path).map(Some) } else { Ok(None) }
}

/// The last part of the path; of "." and "..", that of the folder they stand for.
fn folder_name(folder: &Path) -> String {
    let name = |path: &Path| Some(path.file_name()?.to_string_lossy().into_owned());
    name(folder)
        .or_else(|| name(&folder.canonicalize().ok()?))
        .unwrap_or_else(|| folder.display().to_string())
}

#[cfg(test)]
mod tests;
