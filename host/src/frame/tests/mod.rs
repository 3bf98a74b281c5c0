//! Frames read right and written back, and each bad input refused with its sentence.

mod png;

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use self::png::png_by_hand;
use super::{Frame, Geometry, Intrinsics};
use crate::image::{ColourImage, DepthImage, Image, LabelImage};
use crate::kinect::calibration::{COLOUR_SIZE, DEPTH_SIZE, FactoryCalibration};
use crate::testing::{factory_parameters, mutate, shared_data};

const CAMERA: Intrinsics = Intrinsics { fx: 365.5, fy: 366.25, cx: 2.5, cy: 1.0, width: 5, height: 3 };

fn frame() -> Frame {
    let value = |index: usize| (index * 37 % 256) as u8;
    let colour = (0..15).map(|index| [value(index), value(index + 1), value(index + 2)]).collect();
    Frame {
        name: "view".to_owned(),
        colour: ColourImage { width: 5, height: 3, pixels: colour },
        depth_mm: DepthImage {
            width: 5,
            height: 3,
            pixels: (0..15).map(|index| 4681.0 * index as f32).collect(),
        },
        geometry: Geometry::Registered(CAMERA),
        mask: Some(LabelImage {
            width: 5,
            height: 3,
            pixels: (0..15).map(|index| index % 2 * 255).collect(),
        }),
        instances: Some(LabelImage { width: 5, height: 3, pixels: (0..15).collect() }),
    }
}

fn calibration() -> FactoryCalibration {
    FactoryCalibration::parse("calibration.json", factory_parameters().to_string().as_bytes()).unwrap()
}

/// A folder with a valid frame in it, to be spoilt.
fn folder() -> (TempDir, PathBuf) {
    let parent = tempfile::tempdir().unwrap();
    let folder = parent.path().join("view");
    frame().write(&folder).unwrap();
    (parent, folder)
}

/// Spoils one file of a valid frame and expects the reader's sentence to contain `expected`.
#[track_caller]
fn refused(name: &str, content: Option<&[u8]>, expected: &str) {
    let (_parent, folder) = folder();
    match content {
        Some(bytes) => std::fs::write(folder.join(name), bytes).unwrap(),
        None => std::fs::remove_file(folder.join(name)).unwrap(),
    }
    let message = Frame::read(&folder).unwrap_err().to_string();
    assert!(message.contains(expected), "got: {message}\nexpected: {expected}");
    assert!(message.matches("; ").count() == 1, "no sentence: {message}");
}

#[test]
fn what_is_written_is_read_back() {
    let parent = tempfile::tempdir().unwrap();
    let registered = frame();
    registered.write(&parent.path().join("view")).unwrap();
    assert_eq!(Frame::read(&parent.path().join("view")).unwrap(), registered);
    // Over itself: nothing is in the way.
    registered.write(&parent.path().join("view")).unwrap();

    let pair = Frame {
        name: "pair".to_owned(),
        colour: Image::filled(COLOUR_SIZE.0, COLOUR_SIZE.1, [1, 2, 3]),
        depth_mm: Image::filled(DEPTH_SIZE.0, DEPTH_SIZE.1, 700.0),
        geometry: Geometry::Factory(Box::new(calibration())),
        mask: None,
        instances: None,
    };
    pair.write(&parent.path().join("pair")).unwrap();
    assert_eq!(Frame::read(&parent.path().join("pair")).unwrap(), pair);
    // Depth counts of a tenth of a millimetre.
    let scale = br#"{"fx": 365, "fy": 365, "cx": 256, "cy": 212, "depth_scale_m": 0.0001}"#;
    std::fs::write(parent.path().join("pair/intrinsics.json"), scale).unwrap();
    assert_eq!(Frame::read(&parent.path().join("pair")).unwrap().depth_mm.pixels[0], 70.0);
}

#[test]
fn a_frame_that_contradicts_itself_leaves_no_file() {
    let parent = tempfile::tempdir().unwrap();
    let folder = parent.path().join("view");
    let refused = |frame: &Frame, expected: &str| {
        let message = frame.write(&folder).unwrap_err().to_string();
        assert!(message.contains(expected), "got: {message}\nexpected: {expected}");
        assert!(!folder.exists());
    };
    for (depth_mm, shown) in [(-1.0, "-1"), (65_536.0, "65536"), (f32::NAN, "NaN"), (f32::INFINITY, "inf")] {
        let mut frame = frame();
        frame.depth_mm.set(3, 2, depth_mm);
        refused(&frame, &format!("depth at column 3, row 2 is {shown} mm"));
    }
    let mut wrong = frame();
    wrong.mask = Some(Image::filled(4, 3, 0));
    refused(&wrong, "mask.png: has 4 x 3 pixels where 5 x 3 are due; give a mask");
    let mut wrong = frame();
    wrong.colour.pixels.pop();
    refused(&wrong, "has an image that is empty or has not the pixels of its size");
    let mut wrong = frame();
    wrong.geometry = Geometry::Registered(Intrinsics { fx: f64::NAN, ..CAMERA });
    refused(&wrong, "intrinsics.json: fx is NaN, outside 1e0 to 1e6");
    let mut wrong = frame();
    wrong.geometry = Geometry::Factory(Box::new(calibration()));
    refused(&wrong, "color.png: has 5 x 3 pixels where 1920 x 1080 are due");
}

#[test]
fn files_of_another_frame_are_not_mixed_in() {
    let (_parent, folder) = folder();
    let error = Frame { mask: None, ..frame() }.write(&folder).unwrap_err().to_string();
    assert!(error.contains("mask.png: is there already and is no part of the frame"), "{error}");
}

#[test]
fn missing_files_are_named() {
    refused(
        "color.png",
        None,
        "view: has no color.png; give a folder with color.png, depth.png and intrinsics.json",
    );
    refused("depth.png", None, "view: has no depth.png; ");
    refused("intrinsics.json", None, "view: has no intrinsics.json; add it with fx, fy, cx and cy");
    let message = Frame::read(Path::new("nowhere/at-all")).unwrap_err().to_string();
    assert_eq!(
        message,
        "nowhere/at-all: is no frame folder; give a folder with color.png, depth.png and intrinsics.json"
    );
}

#[test]
fn wrong_bit_depths_are_refused() {
    let grey8 = png_by_hand(5, 3, 8, 0, 0, &[0; 18]);
    let grey16 = png_by_hand(5, 3, 16, 0, 0, &[0; 33]);
    let rgb8 = png_by_hand(5, 3, 8, 2, 0, &[0; 48]);
    refused("depth.png", Some(&grey8), "depth.png: is 8-bit greyscale; save it as 16-bit greyscale PNG");
    refused("depth.png", Some(&rgb8), "depth.png: is 8-bit RGB; ");
    refused("color.png", Some(&grey16), "color.png: is 16-bit greyscale; save it as 8-bit RGB, RGBA or grey");
    refused("color.png", Some(&png_by_hand(5, 3, 16, 6, 0, &[0; 123])), "color.png: is 16-bit RGBA; ");
    refused(
        "mask.png",
        Some(&grey16),
        "mask.png: is 16-bit greyscale; save it as greyscale of at most 8 bits",
    );
    refused("mask.png", Some(&rgb8), "mask.png: is 8-bit RGB; ");
    refused("instances.png", Some(&grey16), "instances.png: is 16-bit greyscale; save it as 8-bit");
    refused(
        "instances.png",
        Some(&png_by_hand(5, 3, 1, 0, 0, &[0; 6])),
        "instances.png: is 1-bit greyscale; ",
    );
}

#[test]
fn different_sizes_are_refused() {
    let depth = png_by_hand(4, 3, 16, 0, 0, &[0; 27]);
    let grey = png_by_hand(4, 3, 8, 0, 0, &[0; 15]);
    let what = "color.png has 5 x 3 and depth.png 4 x 3 pixels, and neither is registered to the other; register them";
    refused("depth.png", Some(&depth), what);
    refused("mask.png", Some(&grey), "mask.png: has 4 x 3 pixels where 5 x 3 are due; ");
    refused("instances.png", Some(&grey), "instances.png: has 4 x 3 pixels where 5 x 3 are due; ");
    let json = |more: &str| format!(r#"{{"fx": 365, "fy": 365, "cx": 2, "cy": 1{more}}}"#).into_bytes();
    let what = "intrinsics.json: is for 640 x 480 pixels, and the images have 5 x 3; give";
    refused("intrinsics.json", Some(&json(r#", "width": 640, "height": 480"#)), what);
    refused(
        "intrinsics.json",
        Some(&json(r#", "registered_to": "none""#)),
        "neither is registered to the other",
    );

    // A calibration is for the two images of a Kinect v2 and no others.
    let (_parent, folder) = folder();
    std::fs::write(folder.join("depth.png"), depth).unwrap();
    std::fs::write(folder.join("calibration.json"), serde_json::to_vec(&calibration()).unwrap()).unwrap();
    let message = Frame::read(&folder).unwrap_err().to_string();
    assert!(
        message.contains("color.png: has 5 x 3 pixels where 1920 x 1080 are due; give the images as"),
        "{message}"
    );
}

#[test]
fn impossible_intrinsics_are_refused() {
    let with =
        |fx: &str, more: &str| format!(r#"{{"fx": {fx}, "fy": 365, "cx": 2, "cy": 1{more}}}"#).into_bytes();
    for (fx, more, expected) in [
        ("0", "", "intrinsics.json: fx is 0, outside 1e0 to 1e6; give fx, fy, cx and cy in pixels"),
        ("-365", "", "fx is -365, outside"),
        ("\"365\"", "", "cannot be understood (invalid type: string \"365\", expected f64 at line 1 column"),
        ("NaN", "", "cannot be understood (expected value at line 1 column"),
        ("1e999", "", "cannot be understood (number out of range at line 1"),
        ("365", ", \"depth_scale_m\": 1000", "depth_scale_m is 1000, outside 1e-7 to 1e-1; "),
        ("365", ", \"depth_scale_m\": 0", "depth_scale_m is 0, outside"),
        ("365", ", \"width\": -5", "cannot be understood (invalid value: integer `-5`"),
        (
            "365",
            ", \"distortion\": [0.1, 0, 0]",
            "states a lens distortion, which is not applied here; undistort",
        ),
    ] {
        refused("intrinsics.json", Some(&with(fx, more)), expected);
    }
    refused("intrinsics.json", Some(b"{\"fx\": 365}"), "cannot be understood (missing field `fy` at line 1");
    refused("intrinsics.json", Some(b""), "cannot be understood (EOF while parsing");
    refused(
        "calibration.json",
        Some(b"{\"IrCameraParams\": {}}"),
        "calibration.json: cannot be understood (missing",
    );
    let (_parent, folder) = folder();
    std::fs::write(
        folder.join("intrinsics.json"),
        with("365", ", \"distortion\": {\"k1\": 0, \"p\": [0, 0.0]}, \"a\": 1"),
    )
    .unwrap();
    assert!(Frame::read(&folder).is_ok());
}

#[test]
fn mutated_json_never_panics() {
    let path = Path::new("intrinsics.json");
    let valid = serde_json::to_vec_pretty(&super::IntrinsicsFile::of(&CAMERA)).unwrap();
    mutate("intrinsics", &valid, 4000, |bytes| {
        if let Ok(file) = super::IntrinsicsFile::parse(path, bytes) {
            assert!(file.depth_scale_m() > 0.0);
            assert!(file.camera(path, 5, 3).ok().is_none_or(|camera| camera.fx >= 1.0 && camera.width == 5));
        }
    });
    let valid = serde_json::to_vec_pretty(&calibration()).unwrap();
    mutate("calibration", &valid, 4000, |bytes| {
        if let Ok(calibration) = FactoryCalibration::parse("calibration.json", bytes) {
            assert!(calibration.colour.shift_d >= 1.0 && calibration.ir.fx >= 1.0);
        }
    });
}

/// Counts and sums found with an independent program, from the bytes of the files.
#[test]
fn real_frames_are_read_as_an_independent_program_reads_them() {
    for (name, size, measured, sum_mm, nearest_mm) in [
        ("neg-redbin-full", (640, 480), 233_596, 150_281_505.8, 126.1),
        ("neg-table-1", (640, 480), 281_413, 326_466_670.0, 595.0),
        ("scan-a", (512, 424), 211_775, 262_922_894.0, 508.0),
    ] {
        let Some(path) = shared_data(&format!("frames/{name}")) else { return };
        let frame = Frame::read(&path).unwrap();
        assert_eq!(frame.name, name);
        let Geometry::Registered(camera) = frame.geometry else { panic!("{name} is registered") };
        assert_eq!((camera.width, camera.height), size);
        let depths: Vec<f32> = frame.depth_mm.pixels.into_iter().filter(|&depth| depth > 0.0).collect();
        let sum: f64 = depths.iter().copied().map(f64::from).sum();
        assert_eq!(depths.len(), measured, "{name}");
        // Tenths of a millimetre are no f32: half a unit in the last place of 867 mm, for each pixel, at most.
        assert!((sum - sum_mm).abs() <= 3.1e-5 * measured as f64, "{name}: {sum}");
        assert_eq!(depths.iter().copied().fold(f32::INFINITY, f32::min), nearest_mm, "{name}");
        if name == "scan-a" {
            let channel =
                |channel: usize| frame.colour.pixels.iter().map(|rgb| u32::from(rgb[channel])).sum::<u32>();
            assert_eq!([0, 1, 2].map(channel), [13_125_812, 18_291_172, 8_521_101]);
            let labels = frame.instances.unwrap().pixels;
            let count = |wanted: u8| labels.iter().map(|&label| usize::from(label == wanted)).sum::<usize>();
            assert_eq!([0, 1, 2, 3, 4, 5, 6].map(count), [213_239, 833, 658, 796, 382, 802, 378]);
        }
    }
}

#[test]
fn real_orchard_and_laboratory_frames_are_read() {
    for (name, labelled) in [("fuji-121804", true), ("fuji-125309", true), ("lab-balls-0", false)] {
        let Some(path) = shared_data(&format!("frames/{name}")) else { return };
        let frame = Frame::read(&path).unwrap();
        assert_eq!((frame.colour.width, frame.colour.height), COLOUR_SIZE);
        assert_eq!((frame.mask.is_some(), frame.instances.is_some()), (labelled, labelled));
        let (Some(mask), Some(labels)) = (frame.mask, frame.instances) else { continue };
        assert!(mask.pixels.iter().all(|&value| value == 0 || value == 255));
        // The labels were made from the mask.
        assert!(labels.pixels.iter().zip(&mask.pixels).all(|(&label, &mask)| label == 0 || mask == 255));
    }
}
