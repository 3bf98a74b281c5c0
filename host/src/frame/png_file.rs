//! PNG files to images and back: 8-bit colour, 16-bit depth counts, 8-bit labels.
//!
//! A header cannot make more memory reserved than [`MAX_PIXELS`] take, nor more than the file could unpack to.

use std::io::Cursor;
use std::path::Path;

use png::{BitDepth, ColorType, Transformations};

use crate::error::InputError;
use crate::file;
use crate::image::{ColourImage, Image, LabelImage};

/// Most pixels an image may have: 64 million, thirty times a full-HD frame.
pub const MAX_PIXELS: u64 = 64 << 20;

/// Largest file, bytes: what [`MAX_PIXELS`] take uncompressed with four channels, and room for the rest.
const MAX_BYTES: u64 = 5 * MAX_PIXELS;

/// Bytes that one byte of deflate can stand for at most: 258 bytes from two bits.
const MAX_DEFLATE_RATIO: u64 = 1032;

/// An image as stored, before it is known to be of the right kind.
struct Raster {
    width: usize,
    height: usize,
    colour: ColorType,
    depth: BitDepth,
    /// Row after row, each padded to whole bytes; 16-bit samples big endian.
    bytes: Vec<u8>,
}

/// Reads a PNG file with one of the decoders below, which take the path only to name it in errors.
///
/// # Errors
/// When the file cannot be read or is too large, and those of the decoder.
pub fn read<T>(path: &Path, decode: impl Fn(&Path, &[u8]) -> Result<T, InputError>) -> Result<T, InputError> {
    decode(path, &file::read_whole(path, MAX_BYTES)?)
}

/// An 8-bit colour image; grey is spread to three channels, a palette is looked up, alpha is ignored.
///
/// # Errors
/// When the bytes are no whole PNG, announce too many pixels or have another bit depth.
pub fn decode_colour(path: &Path, bytes: &[u8]) -> Result<ColourImage, InputError> {
    let fits = |colour, depth| colour == ColorType::Indexed || depth == BitDepth::Eight;
    let raster = decode(path, bytes, "8-bit RGB, RGBA or greyscale", Transformations::EXPAND, fits)?;
    let channels = raster.colour.samples();
    let colour = |pixel: &[u8]| match *pixel {
        [red, green, blue, ..] => [red, green, blue],
        [grey, ..] => [grey; 3],
        [] => [0; 3],
    };
    let pixels = raster.bytes.chunks_exact(channels).map(colour).collect();
    Ok(Image { width: raster.width, height: raster.height, pixels })
}

/// A 16-bit greyscale image: the counts of a depth camera, 0 = no measurement.
///
/// # Errors
/// When the bytes are no whole PNG, announce too many pixels or are of any other kind: 8 bits cannot hold depth.
pub fn decode_counts(path: &Path, bytes: &[u8]) -> Result<Image<u16>, InputError> {
    let fits = |colour, depth| colour == ColorType::Grayscale && depth == BitDepth::Sixteen;
    let raster = decode(path, bytes, "16-bit greyscale", Transformations::IDENTITY, fits)?;
    let pixels = raster.bytes.as_chunks().0.iter().map(|&pair| u16::from_be_bytes(pair)).collect();
    Ok(Image { width: raster.width, height: raster.height, pixels })
}

/// A mask of up to 8 bits, greyscale or palette: 0 stays 0 (background), every other value becomes 255.
///
/// # Errors
/// When the bytes are no whole PNG, announce too many pixels or are of any other kind.
pub fn decode_mask(path: &Path, bytes: &[u8]) -> Result<LabelImage, InputError> {
    let fits = |colour, depth| {
        matches!(colour, ColorType::Grayscale | ColorType::Indexed) && depth != BitDepth::Sixteen
    };
    let mut mask =
        labels(decode(path, bytes, "greyscale of at most 8 bits", Transformations::IDENTITY, fits)?);
    for pixel in &mut mask.pixels {
        *pixel = if *pixel == 0 { 0 } else { 255 };
    }
    Ok(mask)
}

/// Instance labels, 8-bit greyscale or palette: the value (of a palette: the index) names the instance.
///
/// # Errors
/// When the bytes are no whole PNG, announce too many pixels or are of any other kind.
pub fn decode_instances(path: &Path, bytes: &[u8]) -> Result<LabelImage, InputError> {
    let fits = |colour, depth| match colour {
        ColorType::Grayscale => depth == BitDepth::Eight,
        other => other == ColorType::Indexed,
    };
    Ok(labels(decode(path, bytes, "8-bit greyscale", Transformations::IDENTITY, fits)?))
}

/// One value a pixel from samples of 1, 2, 4 or 8 bits; the leftmost pixel is in the highest bits of its byte.
fn labels(raster: Raster) -> LabelImage {
    let Raster { width, height, bytes, .. } = raster;
    let bits = raster.depth as usize;
    if bits == 8 {
        return Image { width, height, pixels: bytes };
    }
    let mask = u8::MAX >> (8 - bits);
    let value = |row: &[u8], u: usize| (row[u * bits / 8] >> (8 - bits - u * bits % 8)) & mask;
    let rows = bytes.chunks_exact((width * bits).div_ceil(8));
    let pixels = rows.flat_map(|row| (0..width).map(move |u| value(row, u))).collect();
    Image { width, height, pixels }
}

fn decode(
    path: &Path,
    bytes: &[u8],
    wanted: &str,
    transformations: Transformations,
    fits: impl Fn(ColorType, BitDepth) -> bool,
) -> Result<Raster, InputError> {
    let broken = |error: png::DecodingError| {
        InputError::in_file(path, format!("cannot be decoded ({error})"), "save it again as PNG")
    };
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_transformations(transformations);
    let info = decoder.read_header_info().map_err(broken)?;
    let (width, height) = (info.width, info.height);
    if !fits(info.color_type, info.bit_depth) {
        let what = format!("is {}-bit {}", info.bit_depth as u8, name_of(info.color_type));
        return Err(InputError::in_file(path, what, format!("save it as {wanted} PNG")));
    }
    let pixels = u64::from(width) * u64::from(height);
    let possible = (bytes.len() as u64).saturating_mul(MAX_DEFLATE_RATIO);
    if pixels > MAX_PIXELS || pixels * info.bits_per_pixel() as u64 / 8 > possible {
        let what = format!(
            "announces {width} x {height} pixels, more than its {} bytes or the limit of {MAX_PIXELS} allow",
            bytes.len()
        );
        return Err(InputError::in_file(path, what, "copy it again, or scale it down"));
    }
    let mut reader = decoder.read_info().map_err(broken)?;
    let mut pixels = vec![0; reader.output_buffer_size().unwrap_or(0)];
    let frame = reader.next_frame(&mut pixels).map_err(broken)?;
    // Reads on to the end mark, so that a file cut short is noticed wherever it ends.
    reader.finish().map_err(broken)?;
    if (frame.width, frame.height) != (width, height) {
        return Err(InputError::in_file(path, "is an animation of smaller parts", "save it as a still PNG"));
    }
    Ok(Raster {
        width: width as usize,
        height: height as usize,
        colour: frame.color_type,
        depth: frame.bit_depth,
        bytes: pixels,
    })
}

fn name_of(colour: ColorType) -> &'static str {
    match colour {
        ColorType::Grayscale => "greyscale",
        ColorType::GrayscaleAlpha => "greyscale with alpha",
        ColorType::Rgb => "RGB",
        ColorType::Rgba => "RGBA",
        ColorType::Indexed => "palette",
    }
}

/// The bytes of an 8-bit RGB PNG.
///
/// # Errors
/// One clause of a sentence, when the image is empty or its size contradicts its pixels.
pub fn encode_colour(image: &ColourImage) -> Result<Vec<u8>, String> {
    encode(image, ColorType::Rgb, BitDepth::Eight, image.pixels.as_flattened())
}

/// The bytes of a 16-bit greyscale PNG.
///
/// # Errors
/// As [`encode_colour`].
pub fn encode_counts(image: &Image<u16>) -> Result<Vec<u8>, String> {
    let bytes: Vec<u8> = image.pixels.iter().flat_map(|count| count.to_be_bytes()).collect();
    encode(image, ColorType::Grayscale, BitDepth::Sixteen, &bytes)
}

/// The bytes of an 8-bit greyscale PNG.
///
/// # Errors
/// As [`encode_colour`].
pub fn encode_labels(image: &LabelImage) -> Result<Vec<u8>, String> {
    encode(image, ColorType::Grayscale, BitDepth::Eight, &image.pixels)
}

fn encode<T>(image: &Image<T>, colour: ColorType, depth: BitDepth, bytes: &[u8]) -> Result<Vec<u8>, String> {
    let sizes = (u32::try_from(image.width), u32::try_from(image.height));
    let (Ok(width), Ok(height)) = sizes else {
        return Err(format!("{} x {} pixels are more than PNG can hold", image.width, image.height));
    };
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    encoder.set_compression(png::Compression::Fast);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(bytes)?;
        writer.finish()
    });
    written.map(|()| file).map_err(|error| format!("cannot be encoded as PNG ({error})"))
}
