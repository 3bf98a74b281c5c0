//! Each format read right, each bad input refused with its sentence, and nothing that makes the readers panic.

use std::path::Path;

use varsac_core::Point3;

use super::{Cloud, Format, Unit};
use crate::testing::{mutate, shared_data, without_gigabytes};

fn read(format: Format, bytes: &[u8]) -> Result<Cloud, String> {
    let name = match format {
        Format::Ply => "a.ply",
        Format::Pcd => "a.pcd",
        Format::Text => "a.csv",
    };
    Cloud::parse(name, bytes, Some(format), Some(Unit::Millimetre)).map_err(|error| error.to_string())
}

fn points(cloud: &Cloud) -> Vec<[f32; 3]> {
    cloud.points_mm.iter().map(|point| [point.x, point.y, point.z]).collect()
}

/// The points that every well-formed file of these tests holds.
const POINTS: [[f32; 3]; 3] = [[1.0, -2.5, 700.25], [0.0, 0.1, -3.0], [1e-3, 65_535.0, 3.5e5]];

const PLY_TEXT: &str = "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nobj_info nothing\r\n\
    element patch 2\r\nproperty list uchar int corners\r\nproperty float weight\r\n\
    element vertex 3\r\nproperty uchar red\r\nproperty double z\r\nproperty float x\r\n\
    property list uint8 float32 extra\r\nproperty float y\r\nelement face 1\r\n\
    property list uchar int vertex_indices\r\nend_header\r\n\
    2 7 8 0.5\r\n0 0.5\r\n255 700.25 1 2 9 9 -2.5\r\n\r\n0 -3 0 0 0.1\r\n17 3.5e5 1e-3 1 4 65535\r\n3 0 1 2";

/// [`PLY_TEXT`] as binary, in the byte order of `swap`.
fn ply_binary(big_endian: bool) -> Vec<u8> {
    let header = PLY_TEXT[..PLY_TEXT.find("end_header\r\n").unwrap() + 12].replace("\r\n", "\n");
    let order = if big_endian { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = header.replace("ascii", order).into_bytes();
    let mut put = |number: &[u8]| {
        // `number` is little endian.
        if big_endian { bytes.extend(number.iter().rev()) } else { bytes.extend(number) }
    };
    put(&[2]);
    put(&7_i32.to_le_bytes());
    put(&8_i32.to_le_bytes());
    put(&0.5_f32.to_le_bytes());
    put(&[0]);
    put(&0.5_f32.to_le_bytes());
    for (extras, [x, y, z]) in [2_u8, 0, 1].into_iter().zip(POINTS) {
        put(&[255]);
        put(&f64::from(z).to_le_bytes());
        put(&x.to_le_bytes());
        put(&[extras]);
        (0..extras).for_each(|_| put(&9.0_f32.to_le_bytes()));
        put(&y.to_le_bytes());
    }
    put(&[3]);
    (0..3_i32).for_each(|corner| put(&corner.to_le_bytes()));
    bytes
}

/// A PCD file of [`POINTS`] behind one point without measurement, two columns and two rows.
fn pcd(data: &str) -> Vec<u8> {
    let header = format!(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS label z x normal y\nSIZE 2 8 4 4 4\nTYPE U F F F F\nCOUNT 1 1 1 3 1\n\
         WIDTH 2\nHEIGHT 2\nVIEWPOINT 10 20 -30 1 0 0 0\nPOINTS 4\nDATA {data}\n"
    );
    let all = [[f32::NAN, f32::NAN, f32::NAN]].into_iter().chain(POINTS);
    let fields = |[x, y, z]: [f32; 3]| {
        let normal = [[1_u8; 4]; 3].concat();
        [
            vec![7, 0],
            f64::from(z).to_le_bytes().to_vec(),
            x.to_le_bytes().to_vec(),
            normal,
            y.to_le_bytes().to_vec(),
        ]
    };
    let mut bytes = header.into_bytes();
    match data {
        "ascii" => {
            for [x, y, z] in all {
                bytes.extend(format!("7 {z} {x} 0 0 1 {y}\n").into_bytes());
            }
        }
        "binary" => all.for_each(|point| bytes.extend(fields(point).concat())),
        _ => {
            let records: Vec<_> = all.map(fields).collect();
            let columns: Vec<u8> = (0..5)
                .flat_map(|field| records.iter().flat_map(move |record| record[field].clone()))
                .collect();
            // Literal runs only; the real files bring repeats.
            let packed: Vec<u8> =
                columns.chunks(32).flat_map(|run| [&[run.len() as u8 - 1][..], run].concat()).collect();
            bytes.extend((packed.len() as u32).to_le_bytes());
            bytes.extend((columns.len() as u32).to_le_bytes());
            bytes.extend(packed);
        }
    }
    bytes
}

#[test]
fn ply_in_all_encodings_with_all_that_is_to_be_skipped() {
    for bytes in [PLY_TEXT.as_bytes().to_vec(), ply_binary(false), ply_binary(true)] {
        let cloud = read(Format::Ply, &bytes).unwrap();
        assert_eq!(points(&cloud), POINTS);
        assert_eq!((cloud.dropped, &cloud.grid, cloud.viewpoint_mm), (0, &None, None));
    }
}

#[test]
fn pcd_in_all_encodings_with_grid_viewpoint_and_a_hole() {
    for data in ["ascii", "binary", "binary_compressed"] {
        let cloud = read(Format::Pcd, &pcd(data)).unwrap();
        assert_eq!(points(&cloud), POINTS, "{data}");
        assert_eq!((cloud.dropped, cloud.viewpoint_mm), (1, Some(Point3::new(10.0, 20.0, -30.0))));
        let grid = cloud.grid.unwrap();
        assert_eq!((grid.width, grid.height, grid.cells.as_slice()), (2, 2, &[1, 2, 3][..]));
    }
}

#[test]
fn text_with_any_separator_header_and_comment() {
    let expected = [[1.0, 2.0, 3.0], [-4.0, 0.5, 6000.0]];
    for text in [
        "1,2,3\n-4,.5,6e3\n",
        "x,y,z\r\n1,2,3\r\n-4,0.5,6000",
        "\u{feff}# by hand\nx;y;z;t\n1;2;3;9\n\n-4;0.5;6000;9 # last\n",
        "1\t2\t3\tabc\n-4\t0.5\t6000\tdef\n",
        "  1   2 3 255 0 0\n -4 +0.5 6000.0 0 0 0",
        "time, Z, \"Y\", X\n0.1, 3, 2, 1\n0.2, 6000, .5, -4",
        "//X Y Z R G B\n1 2 3 0 0 0\n-4 0.5 6000 0 0 0\n",
        "mag_1,mag_2,mag_3\n1,2,3\n-4,0.5,6000\n",
    ] {
        assert_eq!(points(&read(Format::Text, text.as_bytes()).unwrap()), expected, "{text:?}");
    }
}

#[test]
fn units_and_formats_follow_their_rules() {
    let folder = tempfile::tempdir().unwrap();
    let first = |name: &str, bytes: &[u8], unit| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let cloud = Cloud::read(&path, unit).unwrap();
        (cloud.name.clone(), points(&cloud)[0])
    };
    let metres = [1000.0, -2500.0, 700_250.0];
    assert_eq!(first("scan 1.PLY", PLY_TEXT.as_bytes(), None), ("scan 1".to_owned(), POINTS[0]));
    assert_eq!(first("a.ply", PLY_TEXT.as_bytes(), Some(Unit::Metre)).1, metres);
    assert_eq!(first("a.pcd", &pcd("binary"), None).1, metres);
    assert_eq!(first("a.pcd", &pcd("binary"), Some(Unit::Millimetre)).1, POINTS[0]);
    assert_eq!(first("a.xyz", b"0.7 0 0", Some(Unit::Metre)).1, [700.0, 0.0, 0.0]);
    // No extension that means anything: the content decides, and with it the unit.
    assert_eq!(first("ply.dat", PLY_TEXT.as_bytes(), None).1, POINTS[0]);
    assert_eq!(first("pcd", &pcd("ascii"), None).1, metres);
    assert_eq!(first("points.txt", b"1 2 3\n", None).1, [1.0, 2.0, 3.0]);
    let viewpoint = Cloud::parse("a", &pcd("ascii"), Some(Format::Pcd), None).unwrap().viewpoint_mm;
    assert_eq!(viewpoint, Some(Point3::new(10_000.0, 20_000.0, -30_000.0)));
}

#[test]
fn the_origin_is_dropped_where_it_means_nothing_was_measured() {
    let mut bytes = pcd("ascii");
    let at = bytes.len() - "7 350000 0.001 0 0 1 65535\n".len();
    bytes.splice(at.., *b"7 0 -0 0 0 1 0\n");
    let mut cloud = read(Format::Pcd, &bytes).unwrap();
    assert_eq!(cloud.points_mm.len(), 3);
    cloud.drop_origin();
    assert_eq!(points(&cloud), POINTS[..2]);
    assert_eq!((cloud.dropped, cloud.grid.unwrap().cells), (2, vec![1, 2]));
}

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
    refused(Format::Text, "1 2 3\n4 5 1e300", "line 2: point 1: z is 1");
    refused(Format::Text, "1 2 2e9", "beyond the 1e9 mm that are accepted; check the unit (--unit mm|m)");
    let far = String::from_utf8(pcd("ascii")).unwrap().replace("700.25", "7e30");
    refused(Format::Pcd, far, "a.pcd, line 13: point 1: z is 7");
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
    refused(Format::Ply, &PLY_TEXT[..200], "has no end_header line; copy it again");
    refused(Format::Ply, with("vertex 3", "vertex -3"), "\"element vertex -3\" is no valid header line");
    refused(Format::Ply, with("double z", "quad z"), "\"property quad z\" is no valid");
    refused(Format::Ply, with("list uint8", "list float"), "is no valid header line");
    refused(Format::Ply, with("double z", "double w"), "its vertices do not have exactly one property z");
    refused(Format::Ply, with("uchar red", "float x"), "exactly one property x");
    refused(Format::Ply, with("element patch", "element vertex"), "\"element vertex 3\" is no valid");
    refused(Format::Ply, with("element vertex", "element point"), "has no element vertex");
    refused(Format::Ply, with("17 3.5e5", "17 3.5e5 1"), "line 22: vertex 2: the line has more values than");
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

/// Counts and coordinates found with an independent program, from the bytes of the files.
#[test]
fn real_clouds_are_read_as_an_independent_program_reads_them() {
    for (name, measured, first, first_cell) in [
        ("neg-osd-learn1.pcd", 181_408, [-0.638_020_1_f32, -0.225_991_4, 1.311], 95_424),
        ("neg-osd-test33.pcd", 172_802, [-0.563_801, -0.403_612_4, 1.649], 71_180),
    ] {
        let Some(path) = shared_data(&format!("clouds/{name}")) else { return };
        let cloud = Cloud::read(&path, None).unwrap();
        assert_eq!((cloud.points_mm.len(), cloud.dropped), (measured, 640 * 480 - measured));
        assert_eq!(points(&cloud)[0], first.map(|metres| (f64::from(metres) * 1000.0) as f32));
        let grid = cloud.grid.unwrap();
        assert_eq!(
            (grid.width, grid.height, grid.cells[0], grid.cells[measured - 1]),
            (640, 480, first_cell, 306_586)
        );
    }
    for name in ["012_strawberry", "013_apple", "014_lemon", "018_plum", "056_tennis_ball"] {
        let Some(path) = shared_data(&format!("clouds/ycb-{name}.ply")) else { return };
        let cloud = Cloud::read(&path, None).unwrap();
        assert_eq!((cloud.points_mm.len(), cloud.dropped), (8194, 0), "{name}");
        if name == "014_lemon" {
            let mean = |axis: usize| cloud.points_mm.iter().map(|p| f64::from(p[axis])).sum::<f64>() / 8194.0;
            let expected = [-10.259_430_065_966_232, 21.499_151_316_280_21, 27.379_122_529_468_006];
            assert_eq!([mean(0), mean(1), mean(2)], expected);
        }
    }
}

#[test]
fn real_texts_are_read_whole() {
    for (name, count, first) in [
        ("drone-347", 347, [-163.0, 64.0, 1.0]),
        ("sap6-BB", 24, [-17.25, -2.05, 47.025]),
        ("disto-ab", 24, [6.656_601_4, -72.828_73, -94.408_516]),
    ] {
        let Some(path) = shared_data(&format!("mag/{name}.csv")) else { return };
        let cloud = Cloud::read(Path::new(&path), None).unwrap();
        assert_eq!((cloud.points_mm.len(), points(&cloud)[0]), (count, first), "{name}");
    }
    let Some(path) = shared_data("frames/lab-balls-0/cloud_depth_camera.xyz") else { return };
    let mut cloud = Cloud::read(&path, None).unwrap();
    assert_eq!(cloud.points_mm.len(), 320 * 288);
    cloud.drop_origin();
    assert_eq!(
        (points(&cloud)[0], cloud.dropped),
        ([-678.0, -1290.0, 1466.0], 320 * 288 - cloud.points_mm.len())
    );
}
