//! Each bad input refused with its sentence; no header makes the readers reserve much and no bytes make them panic.

use super::super::{Cloud, Format};
use super::{PLY_TEXT, POINTS, pcd, ply_binary, points, read};
use crate::testing::{mutate, without_gigabytes};

#[track_caller]
fn refused(format: Format, bytes: impl AsRef<[u8]>, expected: &str) {
    let message = read(format, bytes.as_ref()).unwrap_err();
    assert!(message.contains(expected), "got: {message}\nexpected: {expected}");
    assert!(message.starts_with("a.") && message.matches("; ").count() == 1, "no sentence: {message}");
}

#[test]
fn coordinates_that_are_not_finite_are_refused_with_index_and_value() {
    refused(Format::Text, "1,2,3\n\n4,NaN,6", "a.csv, line 3: point 1: y is NaN; remove the point");
    refused(Format::Text, "x y z\n1 2 -inf", "a.csv, line 2: point 0: z is -inf; ");
    refused(Format::Ply, PLY_TEXT.replace("0.1\r", "nan\r"), "a.ply, line 21: point 1: y is NaN; ");
    let mut binary = ply_binary(false);
    let value = binary.windows(4).position(|bytes| bytes == 0.1_f32.to_le_bytes()).unwrap();
    binary[value..value + 4].copy_from_slice(&f32::INFINITY.to_le_bytes());
    // z, x and the length of the empty list stand before it, one byte of colour too.
    refused(Format::Ply, &binary, &format!("a.ply, byte {}: point 1: y is inf; ", value - 14));
    // Finite and yet beyond what f32 squares can hold, in any format.
    refused(Format::Text, "1 2 3\n4 5 1e300", "line 2: point 1: z is 1e300, beyond the 1e9 mm");
    refused(Format::Text, "1 2 2e9", "beyond the 1e9 mm that are accepted; check the unit (--unit mm|m)");
    let far = String::from_utf8(pcd("ascii")).unwrap().replace("700.25", "7e30");
    refused(Format::Pcd, far, "a.pcd, line 13: point 1: z is 7e30, beyond");
}

#[test]
fn empty_clouds_are_refused() {
    for nothing in ["", "\n# nothing\n", "x,y,z\n"] {
        refused(Format::Text, nothing, "a.csv: holds no points; give a cloud with points");
    }
    let none = "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
    refused(Format::Ply, none, "a.ply: holds no points; ");
    let holes = "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH 2\nDATA ascii\nnan nan nan\n1 2 inf\n";
    refused(
        Format::Pcd,
        holes.replace("DATA", "POINTS 2\nDATA"),
        "a.pcd: holds 2 points and none of them is a meas",
    );
    refused(Format::Pcd, "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 0\nDATA binary\n", "holds no points");
}

#[test]
fn text_that_is_no_cloud_is_refused_with_its_line() {
    refused(
        Format::Text,
        "1 2 3\n4 5\n",
        "a.csv, line 2: has 2 of 3 values (\"4 5\"); give one point a line",
    );
    refused(
        Format::Text,
        "1 2 3\n4 five 6\n",
        "a.csv, line 2: \"five\" is no number; write numbers with a decimal",
    );
    refused(Format::Text, "1,5;2,5;3,5", "line 1: \"1,5\" is no number");
    refused(Format::Text, "1,5 2,5 3,5", "line 1: \"5 2\" is no number");
    refused(Format::Text, "1,,3", "line 1: \"\" is no number");
    refused(Format::Text, "time,a,b,c\n1,2,3,4", "names columns, but not x, y and z; ");
    refused(Format::Text, "8194\n1 2 3", "line 1: has 1 of 3 values");
    refused(Format::Text, vec![0xff; 3000], "...");
    let error =
        Cloud::parse("a", b"\x89PNG\r\n\x1a\n\0\0\0", Format::of_content(b"\x89PNG\r\n\x1a\n\0\0\0"), None);
    assert!(
        error.unwrap_err().to_string().starts_with("a: is no point cloud in a known format; give a .ply")
    );
}

#[test]
fn broken_ply_headers_and_rows_are_named() {
    let with = |from: &str, to: &str| PLY_TEXT.replacen(from, to, 1);
    refused(Format::Ply, "plyer\n", "does not begin with the line ply; ");
    refused(
        Format::Ply,
        with("ascii 1.0", "ascii 2.0"),
        "a.ply, line 2: \"format ascii 2.0\" is no valid header",
    );
    refused(Format::Ply, with("format ascii 1.0\r\n", ""), "has no format line");
    refused(Format::Ply, with("end_header", "comment"), "is no valid header line");
    refused(
        Format::Ply,
        &PLY_TEXT[..PLY_TEXT.find("end_header").unwrap()],
        "has no end_header line; copy it again",
    );
    refused(Format::Ply, with("vertex 3", "vertex -3"), "\"element vertex -3\" is no valid header line");
    refused(Format::Ply, with("double z", "quad z"), "\"property quad z\" is no valid");
    refused(Format::Ply, with("list uint8", "list float"), "is no valid header line");
    refused(Format::Ply, with("double z", "double w"), "its vertices do not have exactly one property z");
    refused(Format::Ply, with("uchar red", "float x"), "exactly one property x");
    refused(Format::Ply, with("element patch", "element vertex"), "\"element vertex 3\" is no valid");
    refused(Format::Ply, with("element vertex", "element point"), "has no element vertex");
    refused(Format::Ply, with("4 65535", "4 65535 1"), "line 22: vertex 2: the line has more values than");
    refused(
        Format::Ply,
        with("0 -3 0 0 0.1", "0 -3 0 9 0.1"),
        "line 21: vertex 1: the line has fewer values",
    );
    refused(Format::Ply, with("0 -3 0 0 0.1", "0 -3 0 -1 0.1"), "\"-1\" is no length of list extra");
    refused(Format::Ply, with("3 0 1 2", "3 0 1"), "line 23: face 0: the line has fewer");
    refused(Format::Ply, with("\r\n3 0 1 2", ""), "a.ply");
    refused(Format::Ply, format!("{PLY_TEXT}\n1 2 3\n"), "line 24: comes after everything that the header");
    // A signed list length below zero would walk backwards.
    let signed = ply_binary(false);
    let at = signed.windows(5).position(|bytes| bytes == b"uint8").unwrap();
    let mut signed = [&signed[..at], b"int8", &signed[at + 5..]].concat();
    let at = signed.len() - 13 - 4 - 4 - 1;
    assert_eq!(signed[at], 1);
    signed[at] = 0xff;
    refused(Format::Ply, &signed, "vertex 2: list extra has length -1; save the cloud as PLY again");
}

#[test]
fn broken_pcd_headers_and_rows_are_named() {
    let text = String::from_utf8(pcd("ascii")).unwrap();
    let with = |from: &str, to: &str| text.replacen(from, to, 1);
    refused(
        Format::Pcd,
        with("DATA ascii", "DATA text"),
        "a.pcd, line 11: \"DATA text\" is no valid header line",
    );
    refused(Format::Pcd, &text[..150], "has no DATA line; copy it again");
    refused(
        Format::Pcd,
        with("POINTS 4", "POINTS 5"),
        "WIDTH 2 times HEIGHT 2 is not POINTS, 5; correct the header",
    );
    refused(Format::Pcd, with("WIDTH 2", "WIDTH -2"), "\"WIDTH -2\" is no valid");
    refused(Format::Pcd, with("WIDTH 2", "WIDTH 9999999999999999999"), "is not POINTS, 4");
    refused(
        Format::Pcd,
        with("POINTS 4\n", "").replace("HEIGHT 2", "HEIGHT 18446744073709551615"),
        "a number that fits",
    );
    refused(Format::Pcd, with("WIDTH 2\n", "").replace("POINTS 4\n", ""), "has neither WIDTH nor POINTS");
    refused(
        Format::Pcd,
        with("SIZE 2 8 4", "SIZE 2 3 4"),
        "field \"z\" has TYPE \"F\", SIZE \"3\", COUNT \"1\"; use TYPE",
    );
    refused(
        Format::Pcd,
        with("SIZE 2 8", "SIZE 8"),
        "its FIELDS, SIZE, TYPE and COUNT lines differ in length",
    );
    refused(Format::Pcd, with("label z", "label depth"), "does not have exactly one field z with COUNT 1");
    refused(Format::Pcd, with("COUNT 1 1", "COUNT 1 2"), "exactly one field z");
    refused(Format::Pcd, with("VIEWPOINT 10", "VIEWPOINT nan"), "\"VIEWPOINT nan 20");
    refused(Format::Pcd, with(" -30 1 0 0 0", ""), "\"VIEWPOINT 10 20\" is no valid");
    refused(Format::Pcd, with("7 -3 0", "7 -3"), "line 14: has 6 values where a point has 7");
    refused(Format::Pcd, with("7 -3 0", "7 minus 0"), "line 14: \"minus\" is no number");
    refused(Format::Pcd, format!("{text}7 1 2 0 0 1 3"), "line 16: comes after the 4 points of the header");
    refused(Format::Pcd, &text[..text.len() - 28], "a.pcd");
}

#[test]
fn a_binary_file_cut_short_anywhere_is_refused() {
    for (format, bytes) in [
        (Format::Ply, ply_binary(false)),
        (Format::Ply, ply_binary(true)),
        (Format::Pcd, pcd("binary")),
        (Format::Pcd, pcd("binary_compressed")),
    ] {
        for length in 0..bytes.len() {
            assert!(read(format, &bytes[..length]).is_err(), "{format:?} cut to {length} of {}", bytes.len());
        }
    }
}

#[test]
fn headers_that_promise_too_much_reserve_nothing() {
    let ply = |encoding: &str, count: &str| {
        format!(
            "ply\nformat {encoding} 1.0\nelement vertex {count}\nproperty float x\nproperty float y\n\
                 property float z\nend_header\n1 2 3\n4 5 6\n"
        )
    };
    let pcd = |data: &str, width: &str, height: &str| {
        format!(
            "FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nWIDTH {width}\nHEIGHT {height}\nDATA {data}\n1 2 3\n4 5 6\n"
        )
    };
    without_gigabytes(|| {
        for encoding in ["ascii", "binary_little_endian"] {
            for count in ["1000000000", "18446744073709551615"] {
                refused(Format::Ply, ply(encoding, count), &format!("announces {count} times vertex, "));
            }
        }
        for data in ["ascii", "binary"] {
            refused(Format::Pcd, pcd(data, "1000000000", "1"), "announces 1000000000 points, ");
            refused(
                Format::Pcd,
                pcd(data, "4294967295", "4294967295"),
                "announces 18446744065119617025 points, ",
            );
        }
        // 4 GiB announced for 100 bytes, consistently.
        let mut packed = pcd("binary_compressed", "357913941", "1").into_bytes();
        packed.truncate(packed.len() - 12);
        packed.extend([100_u32.to_le_bytes(), (357_913_941 * 12_u32).to_le_bytes()].concat());
        packed.extend([0; 100]);
        refused(Format::Pcd, &packed, "unpacks to 4294967292 bytes where");
        // A list that claims 4 billion entries.
        let mut list = ply_binary(false);
        let at = list.windows(9).position(|bytes| bytes == b"list ucha").unwrap() + 5;
        list.splice(at..at + 5, *b"uint");
        refused(Format::Ply, &list, "the file ends before it is complete");
        // An element without properties takes no bytes, however many there are.
        let many = PLY_TEXT.replace("element patch", "element nothing 99999999999999\r\nelement patch");
        assert_eq!(points(&read(Format::Ply, many.as_bytes()).unwrap()), POINTS);
        // A header of one endless line.
        refused(Format::Pcd, "FIELDS".to_owned() + &" x".repeat(20 << 20), "has no DATA line");
        refused(Format::Ply, "ply\ncomment".to_owned() + &" x".repeat(20 << 20), "has no end_header line");
    });
}

#[test]
fn mutated_files_never_panic() {
    let text = "# by hand\nx;y;z\n1;2;3\n-4;0.5;6000\n1;5e3;-.5\n".as_bytes().to_vec();
    for (format, name, bytes) in [
        (Format::Ply, "ascii PLY", PLY_TEXT.as_bytes().to_vec()),
        (Format::Ply, "little-endian PLY", ply_binary(false)),
        (Format::Ply, "big-endian PLY", ply_binary(true)),
        (Format::Pcd, "ascii PCD", pcd("ascii")),
        (Format::Pcd, "binary PCD", pcd("binary")),
        (Format::Pcd, "compressed PCD", pcd("binary_compressed")),
        (Format::Text, "text", text),
    ] {
        assert!(read(format, &bytes).is_ok(), "{name}");
        mutate(name, &bytes, 4000, |bytes| {
            if let Ok(cloud) = read(format, bytes) {
                assert!(cloud.points_mm.iter().flat_map(|point| point.iter()).all(|value| value.is_finite()));
                assert!(cloud.grid.is_none_or(|grid| grid.cells.len() == cloud.points_mm.len()));
            }
        });
    }
}
