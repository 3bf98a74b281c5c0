//! Each format read right, down to the real files.

mod refused;

use std::path::Path;

use varsac_core::Point3;

use super::{Cloud, Format, Unit};
use crate::testing::shared_data;

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
