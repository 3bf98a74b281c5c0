//! PNG files of every kind, whole, cut short, lying and mutated.

use std::path::Path;

use super::super::png_file;
use super::frame;
use crate::error::InputError;
use crate::testing::{mutate, without_gigabytes};

/// The check sum of a PNG chunk.
fn crc(chunk: &[u8]) -> u32 {
    let step = |crc: u32, _| if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
    !chunk.iter().fold(u32::MAX, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), step))
}

/// A PNG file put together by hand, its pixels stored without compression.
pub(super) fn png_by_hand(
    width: u32,
    height: u32,
    depth: u8,
    colour: u8,
    interlace: u8,
    rows: &[u8],
) -> Vec<u8> {
    let adler = rows.iter().fold((1_u32, 0_u32), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65_521;
        (a, (b + a) % 65_521)
    });
    let length = rows.len() as u16;
    let zlib = [
        &[0x78, 1, 1][..],
        &length.to_le_bytes(),
        &(!length).to_le_bytes(),
        rows,
        &(adler.1 << 16 | adler.0).to_be_bytes(),
    ];
    let header =
        [&width.to_be_bytes()[..], &height.to_be_bytes(), &[depth, colour, 0, 0, interlace]].concat();
    let palette = if colour == 3 { &[255, 0, 0, 0, 255, 0, 0, 0, 255][..] } else { &[] };
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    for (kind, content) in
        [(b"IHDR", &header[..]), (b"PLTE", palette), (b"IDAT", &zlib.concat()), (b"IEND", &[])]
    {
        if kind == b"PLTE" && palette.is_empty() {
            continue;
        }
        let chunk = [&kind[..], content].concat();
        file.extend((content.len() as u32).to_be_bytes());
        file.extend(&chunk);
        file.extend(crc(&chunk).to_be_bytes());
    }
    file
}

/// The file with the check sum of every chunk made right again; else nearly every mutation ends at the first of them.
fn with_right_sums(file: &[u8]) -> Vec<u8> {
    let mut file = file.to_vec();
    let mut at = 8;
    while let Some(length) =
        file.get(at..at + 4).map(|bytes| bytes.iter().fold(0, |n, &b| n << 8 | usize::from(b)))
    {
        let end = at + 8 + length;
        let Some(sum) = file.get(at + 4..end).map(crc) else { break };
        let Some(slot) = file.get_mut(end..end + 4) else { break };
        slot.copy_from_slice(&sum.to_be_bytes());
        at = end + 4;
    }
    file
}

/// Decodes bytes that were never in a file.
fn decoded<T>(bytes: &[u8], decode: impl Fn(&Path, &[u8]) -> Result<T, InputError>) -> Result<T, String> {
    decode(Path::new("a.png"), bytes).map_err(|error| error.to_string())
}

#[test]
fn a_png_cut_short_anywhere_is_refused() {
    let files = [
        png_file::encode_colour(&frame().colour).unwrap(),
        png_by_hand(5, 3, 8, 2, 0, &[0; 48]),
        png_by_hand(2, 2, 8, 0, 1, &[0, 10, 0, 20, 0, 30, 40]),
    ];
    for file in files {
        assert!(decoded(&file, png_file::decode_colour).is_ok());
        for length in 0..file.len() {
            assert!(decoded(&file[..length], png_file::decode_colour).is_err(), "{length} of {}", file.len());
        }
    }
    let error = decoded(b"no picture", png_file::decode_colour).unwrap_err();
    assert_eq!(error, "a.png: cannot be decoded (Invalid PNG signature.); save it again as PNG");
}

#[test]
fn every_kind_of_png_that_is_accepted_is_read_right() {
    // Adam7 on 2 x 2: the first pass has the pixel at the top left, the sixth the one beside it, the last the row below.
    let interlaced =
        decoded(&png_by_hand(2, 2, 8, 0, 1, &[0, 10, 0, 20, 0, 30, 40]), png_file::decode_colour);
    assert_eq!(interlaced.unwrap().pixels, [[10; 3], [20; 3], [30; 3], [40; 3]]);
    let rgba =
        decoded(&png_by_hand(1, 2, 8, 6, 0, &[0, 1, 2, 3, 0, 0, 4, 5, 6, 255]), png_file::decode_colour);
    assert_eq!(rgba.unwrap().pixels, [[1, 2, 3], [4, 5, 6]]);
    let grey_alpha = decoded(&png_by_hand(2, 1, 8, 4, 0, &[0, 9, 255, 8, 0]), png_file::decode_colour);
    assert_eq!(grey_alpha.unwrap().pixels, [[9; 3], [8; 3]]);
    // 2-bit palette: indices 2, 0, 1, 1, 2.
    let palette = png_by_hand(5, 1, 2, 3, 0, &[0, 0b1000_0101, 0b1000_0000]);
    let (red, green, blue) = ([255, 0, 0], [0, 255, 0], [0, 0, 255]);
    assert_eq!(decoded(&palette, png_file::decode_colour).unwrap().pixels, [blue, red, green, green, blue]);
    assert_eq!(decoded(&palette, png_file::decode_instances).unwrap().pixels, [2, 0, 1, 1, 2]);
    assert_eq!(decoded(&palette, png_file::decode_mask).unwrap().pixels, [255, 0, 255, 255, 255]);
    let bits = png_by_hand(9, 2, 1, 0, 0, &[0, 0b1010_0001, 0b1000_0000, 0, 0b0111_1110, 0]);
    let mask: Vec<u8> = b"101000011011111100".iter().map(|bit| (bit - b'0') * 255).collect();
    assert_eq!(decoded(&bits, png_file::decode_mask).unwrap().pixels, mask);
    let counts = decoded(&png_by_hand(2, 1, 16, 0, 0, &[0, 1, 2, 255, 254]), png_file::decode_counts);
    assert_eq!(counts.unwrap().pixels, [258, 65_534]);
}

#[test]
fn png_headers_that_promise_too_much_reserve_nothing() {
    without_gigabytes(|| {
        for (width, height) in [(40_000, 40_000), (0x7fff_ffff, 0x7fff_ffff), (8000, 8000), (1, 0x7fff_ffff)]
        {
            let file = png_by_hand(width, height, 8, 6, 0, &[0; 100]);
            let message = decoded(&file, png_file::decode_colour).unwrap_err();
            assert!(
                message.contains(&format!("announces {width} x {height} pixels, more than its ")),
                "{message}"
            );
        }
        let file = png_by_hand(0, 5, 8, 6, 0, &[0; 100]);
        assert!(decoded(&file, png_file::decode_colour).is_err());
    });
}

#[test]
fn mutated_pngs_never_panic() {
    for (name, valid) in [
        ("compressed RGB", png_file::encode_colour(&frame().colour).unwrap()),
        ("stored RGBA", png_by_hand(5, 3, 8, 6, 0, &[0; 63])),
        ("interlaced grey", png_by_hand(2, 2, 8, 0, 1, &[0, 10, 0, 20, 0, 30, 40])),
        ("16-bit grey", png_by_hand(5, 3, 16, 0, 0, &[0; 33])),
        ("palette", png_by_hand(5, 1, 2, 3, 0, &[0, 0b1000_0101, 0b1000_0000])),
    ] {
        mutate(name, &valid, 4000, |bytes| {
            let bytes = with_right_sums(bytes);
            let whole = |size: Option<(usize, usize, usize)>| {
                assert!(size.is_none_or(|(width, height, pixels)| width * height == pixels && pixels > 0));
            };
            whole(decoded(&bytes, png_file::decode_mask).ok().map(|i| (i.width, i.height, i.pixels.len())));
            whole(
                decoded(&bytes, png_file::decode_instances).ok().map(|i| (i.width, i.height, i.pixels.len())),
            );
            whole(decoded(&bytes, png_file::decode_colour).ok().map(|i| (i.width, i.height, i.pixels.len())));
            whole(decoded(&bytes, png_file::decode_counts).ok().map(|i| (i.width, i.height, i.pixels.len())));
        });
    }
}
