//! The command `varsac` as its users meet it: exit codes, sentences, JSON, files.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;
use varsac_host::frame::{Frame, Geometry, Intrinsics, png_file};
use varsac_host::image::{ColourImage, DepthImage, Image};

/// Runs the program in `folder`.
fn varsac(folder: &Path, args: &[&str], stdin: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_varsac"))
        .args(args)
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The program may end before it reads everything.
    let _ = child.stdin.take().unwrap().write_all(stdin.as_bytes());
    child.wait_with_output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A folder of its own.
fn folder() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

/// The whole surface of an ellipsoid 22 x 12 x 11 at (10, -20, 700), as csv.
fn surface_csv(points: u32) -> String {
    let mut csv = String::from("x,y,z\n");
    for k in 0..points {
        let w = 1.0 - 2.0 * (f64::from(k) + 0.5) / f64::from(points);
        let (r, turn) = ((1.0 - w * w).sqrt(), 2.4 * f64::from(k));
        let _ = writeln!(
            csv,
            "{:.4},{:.4},{:.4}",
            10.0 + 22.0 * r * turn.cos(),
            12.0 * r * turn.sin() - 20.0,
            700.0 + 11.0 * w
        );
    }
    csv
}

/// Depth at which the ray (x, y, 1) meets the near side of an ellipsoid 22 x 11 x 11, its long axis along x.
fn near_side([cx, cy, cz]: [f64; 3], (x, y): (f64, f64)) -> Option<f64> {
    let weighed = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] / 484.0 + p[1] * q[1] / 121.0 + p[2] * q[2] / 121.0;
    let (ray, centre) = ([x, y, 1.0], [cx, cy, cz]);
    let (a, b, c) = (weighed(ray, ray), weighed(ray, centre), weighed(centre, centre) - 1.0);
    let discriminant = b * b - a * c;
    (discriminant > 0.0).then(|| (b - discriminant.sqrt()) / a)
}

/// What a camera of this focal length sees of a jujube at (10, -20, 600): its near side, as csv.
fn seen_csv(focal_px: f64) -> String {
    let mut csv = String::from("x,y,z\n");
    let half = (0.06 * focal_px) as i32;
    for v in -half..=half {
        for u in -half..=half {
            let (x, y) = (f64::from(u) / focal_px, f64::from(v) / focal_px);
            if let Some(z) = near_side([10.0, -20.0, 600.0], (x, y)) {
                let _ = writeln!(csv, "{:.4},{:.4},{z:.4}", x * z, y * z);
            }
        }
    }
    csv
}

/// A Kinect v2's depth camera: 282 points of the fruit.
const KINECT_PX: f64 = 365.0;

fn fruit_csv() -> String {
    seen_csv(KINECT_PX)
}

/// A small registered frame: one red ellipsoid before a grey wall.
fn frame() -> Frame {
    let (width, height) = (160, 120);
    let mut colour = ColourImage::filled(width, height, [90, 90, 90]);
    let mut depth_mm = DepthImage::filled(width, height, 900.0);
    for v in 0..height as i64 {
        for u in 0..width as i64 {
            let ray = ((u - 80) as f64 / KINECT_PX, (v - 60) as f64 / KINECT_PX);
            if let Some(z) = near_side([0.0, 0.0, 600.0], ray) {
                colour.set(u, v, [170, 30, 25]);
                depth_mm.set(u, v, z.round() as f32);
            }
        }
    }
    let intrinsics = Intrinsics { fx: KINECT_PX, fy: KINECT_PX, cx: 80.0, cy: 60.0, width, height };
    let geometry = Geometry::Registered(intrinsics);
    Frame { name: "small".to_owned(), colour, depth_mm, geometry, mask: None, instances: None }
}

fn written_frame(folder: &Path) -> PathBuf {
    let path = folder.join("small");
    frame().write(&path).unwrap();
    path
}

/// The program refuses: exit code 2, one sentence with all of `words`, nothing on standard output, no panic.
fn refuses(folder: &Path, args: &[&str], stdin: &str, words: &[&str]) {
    let before = listing(folder);
    let output = varsac(folder, args, stdin);
    let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(2), "{args:?}: {stdout}{stderr}");
    assert_eq!(stdout, "", "{args:?}");
    assert!(!stderr.contains("panicked"), "{args:?}: {stderr}");
    for word in words {
        assert!(stderr.contains(word), "{args:?}: no {word:?} in {stderr}");
    }
    assert_eq!(listing(folder), before, "{args:?} left a file behind");
}

fn listing(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// The program runs and accepts nothing: exit code 1.
fn accepts_nothing(folder: &Path, args: &[&str], stdin: &str) {
    let output = varsac(folder, args, stdin);
    let stdout = text(&output.stdout);
    assert_eq!(output.status.code(), Some(1), "{args:?}: {stdout}{}", text(&output.stderr));
    assert!(stdout.contains("nothing found") || stdout.contains("nothing accepted, "), "{args:?}: {stdout}");
    assert!(!stdout.contains("  accepted"), "{args:?}: {stdout}");
}

/// The report of one input, and the exit code.
fn report(folder: &Path, args: &[&str], stdin: &str) -> (Value, Option<i32>) {
    let output = varsac(folder, args, stdin);
    let report = serde_json::from_str(&text(&output.stdout));
    (report.unwrap_or_else(|_| panic!("{args:?}: {}", text(&output.stderr))), output.status.code())
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn assert_near(values: &Value, expected: &[f64], tolerance: f64) {
    let values = numbers(values);
    assert_eq!(values.len(), expected.len());
    for (value, expected) in values.iter().zip(expected) {
        assert!((value - expected).abs() < tolerance, "{values:?}, not {expected:?}");
    }
}

#[test]
fn a_cloud_on_standard_input_becomes_json() {
    let folder = folder();
    let args = ["locate", "-", "--json", "--seed", "7"];
    let (found, code) = report(folder.path(), &args, &fruit_csv());
    assert_eq!(code, Some(0));
    assert_eq!((found["input"].as_str(), found["points"].as_u64()), (Some("-"), Some(282)));
    assert_eq!((found["method"].as_str(), found["seed"].as_u64()), (Some("map"), Some(7)));
    assert_eq!(found.get("learnt_size"), None);
    let fruit = &found["detections"][0];
    assert_eq!(fruit["status"], "accepted");
    assert_eq!(fruit["refusal"], Value::Null);
    assert_near(&fruit["centre_mm"], &[10.0, -20.0, 600.0], 0.1);
    assert_near(&fruit["semi_axes_mm"], &[22.0, 11.0, 11.0], 0.1);
    let bits = fruit["bits"].as_str().unwrap();
    assert_eq!(bits.len(), 16);
    let (again, _) = report(folder.path(), &args, &fruit_csv());
    assert_eq!(again["detections"][0]["bits"], bits, "the same seed gives the same bits");
}

#[test]
fn attitude_and_uncertainty_agree_with_themselves() {
    let folder = folder();
    let (found, _) = report(folder.path(), &["locate", "-", "--json"], &fruit_csv());
    let fruit = &found["detections"][0];
    // The first axis is the image of x under the rotation of the quaternion.
    let [x, y, z, w] = numbers(&fruit["quaternion_xyzw"])[..] else { panic!("{fruit}") };
    assert!((x * x + y * y + z * z + w * w - 1.0).abs() < 1e-6);
    let turned_x = [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + z * w), 2.0 * (x * z - y * w)];
    assert_near(&fruit["axes"][0], &turned_x, 1e-6);
    assert!(turned_x[0].abs() > 0.999, "the fruit lies along x");
    let [_, ry, rz] = numbers(&fruit["attitude_rad"])[..] else { panic!("{fruit}") };
    assert!((ry.sin() + turned_x[2]).abs() < 1e-5 && (rz.tan() - turned_x[1] / turned_x[0]).abs() < 1e-5);

    let covariance: Vec<Vec<f64>> = fruit["covariance"].as_array().unwrap().iter().map(numbers).collect();
    assert_eq!((covariance.len(), covariance[0].len()), (9, 9));
    for (i, row) in covariance.iter().enumerate() {
        assert!(row[i] > 0.0 && row.iter().zip(&covariance).all(|(value, other)| *value == other[i]));
    }
    let sigma: Vec<f64> = (0..3).map(|k| covariance[k][k].sqrt()).collect();
    assert_near(&fruit["sigma_centre_mm"], &sigma, 1e-6);
    assert!(sigma.iter().all(|sigma| (0.01..1.8).contains(sigma)), "{sigma:?}");
}

#[test]
fn a_refused_target_is_listed_with_its_reason_and_is_not_found() {
    let folder = folder();
    // A camera sees no complete surface: what is expected of one is mostly missing in it.
    let (found, code) = report(folder.path(), &["locate", "-", "--json"], &surface_csv(400));
    assert_eq!(code, Some(1));
    let targets = found["detections"].as_array().unwrap();
    assert!(!targets.is_empty());
    for target in targets {
        assert_eq!(target["status"], "refused");
        let refusal = target["refusal"].as_object().unwrap();
        assert!(refusal["code"].as_str().is_some_and(|code| !code.is_empty()), "{target}");
        assert_ne!(refusal["value"].as_f64().unwrap(), refusal["limit"].as_f64().unwrap(), "{target}");
    }
    let table = text(&varsac(folder.path(), &["locate", "-"], &surface_csv(400)).stdout);
    assert!(table.contains("nothing accepted, ") && table.contains("  refused: "), "{table}");
}

#[test]
fn a_complete_surface_has_no_viewpoint() {
    let folder = folder();
    let cases: [&[&str]; 6] = [
        &["--viewpoint", "none"],
        &["--viewpoint", "none", "--fruit", "none"],
        &["--method", "varsac"],
        &["--method", "direct"],
        &["--method", "algebraic", "--fruit", "none"],
        &["--method", "geometric", "--fruit", "none"],
    ];
    for options in cases {
        let mut args = vec!["locate", "-", "--json"];
        args.extend(options);
        let (found, code) = report(folder.path(), &args, &surface_csv(400));
        assert_eq!(code, Some(0), "{options:?}");
        let target = &found["detections"][0];
        assert_near(&target["centre_mm"], &[10.0, -20.0, 700.0], 0.05);
        assert_near(&target["semi_axes_mm"], &[22.0, 12.0, 11.0], 0.05);
        let has_covariance = !options.contains(&"varsac") && !options.contains(&"direct");
        assert_eq!(target["covariance"].is_array(), has_covariance, "{options:?}");
    }
}

#[test]
fn lengths_have_the_digits_they_need_at_any_scale() {
    let folder = folder();
    let surface = surface_csv(400);
    for (factor, sizes) in [(1e-3, ["0.02200", "0.01200", "0.01100"]), (0.1, ["2.200", "1.200", "1.100"])] {
        let mut csv = String::new();
        for line in surface.lines().skip(1) {
            let point: Vec<f64> =
                line.split(',').map(|number| factor * number.parse::<f64>().unwrap()).collect();
            let _ = writeln!(csv, "{},{},{}", point[0], point[1], point[2]);
        }
        let args = ["locate", "-", "--fruit", "none", "--method", "geometric"];
        let table = text(&varsac(folder.path(), &args, &csv).stdout);
        let words: Vec<&str> = table.split_whitespace().collect();
        assert!(words.windows(3).any(|three| three == sizes), "{table}");
    }
}

#[test]
fn the_co_processor_searches_as_this_machine_does() {
    let folder = folder();
    std::fs::write(folder.path().join("fruit.csv"), fruit_csv()).unwrap();
    let (here, _) = report(folder.path(), &["locate", "fruit.csv", "--json"], "");
    let (there, code) = report(folder.path(), &["simulate", "fruit.csv", "--json", "--check"], "");
    assert_eq!((code, &there["method"]), (Some(0), &Value::from("map")));
    assert_eq!(there["detections"], here["detections"]);
    refuses(folder.path(), &["simulate", "fruit.csv", "--method", "direct"], "", &["--method"]);
}

#[test]
fn the_size_is_learnt_from_many_and_kept_with_few() {
    let folder = folder();
    let at = folder.path();
    let names: Vec<String> = (0..12).map(|k| format!("{k}.csv")).collect();
    for (k, name) in names.iter().enumerate() {
        std::fs::write(at.join(name), seen_csv(KINECT_PX + 3.0 * k as f64)).unwrap();
    }
    let few = varsac(at, &["locate", "0.csv", "--learn-size"], "");
    assert_eq!(few.status.code(), Some(0));
    assert!(text(&few.stdout).contains("size not learnt: 1 accepted"), "{}", text(&few.stdout));

    let mut args = vec!["locate", "--learn-size", "--json"];
    args.extend(names.iter().map(String::as_str));
    let output = varsac(at, &args, "");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let lines = text(&output.stdout);
    assert_eq!(lines.lines().count(), names.len());
    for line in lines.lines() {
        let learnt = &serde_json::from_str::<Value>(line).unwrap()["learnt_size"];
        assert_eq!((&learnt["from"], &learnt["bounded"]), (&Value::from(12), &Value::from(false)));
        assert_eq!(learnt["too_few"], false);
        // The fruit is 22 x 11 x 11, the preset 21.75 x 10.9 x 10.9.
        assert_near(&learnt["semi_axes_mm"], &[22.0, 11.0, 11.0], 0.1);
    }
    refuses(at, &["locate", "-", "--learn-size"], &fruit_csv(), &["--learn-size", "twice"]);
    let unsized_ = ["locate", "0.csv", "--learn-size", "--fruit", "none"];
    refuses(at, &unsized_, "", &["--learn-size", "mixture"]);
}

#[test]
fn options_without_a_say_are_named() {
    let folder = folder();
    let output = varsac(folder.path(), &["locate", "-", "--radius", "30", "--sizes", "9,12"], &fruit_csv());
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stderr).contains("--radius, --sizes"), "{}", text(&output.stderr));
    let used = varsac(folder.path(), &["locate", "-", "--radius", "30", "--method", "varsac"], &fruit_csv());
    assert_eq!(text(&used.stderr), "");
}

#[test]
fn every_seed_is_valid() {
    let folder = folder();
    for seed in ["0", "18446744073709551615"] {
        let output = varsac(folder.path(), &["locate", "-", "--seed", seed], &fruit_csv());
        assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    }
}

#[test]
fn a_frame_becomes_a_table_a_picture_and_a_coloured_cloud() {
    let folder = folder();
    written_frame(folder.path());
    let args = ["locate", "small", "--draw", "found.png", "--cloud-out", "found.ply"];
    let output = varsac(folder.path(), &args, "");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("1 target accepted"), "{}", text(&output.stdout));
    let picture = png_file::read(&folder.path().join("found.png"), png_file::decode_colour).unwrap();
    assert!(picture.width >= 160 && picture.height >= 120);
    let cloud = varsac(folder.path(), &["locate", "found.ply"], "");
    assert_eq!(cloud.status.code(), Some(0), "the coloured cloud is a cloud: {}", text(&cloud.stderr));
}

#[test]
fn several_inputs_keep_their_order_and_get_files_of_their_own() {
    let folder = folder();
    for name in ["one", "two", "three"] {
        std::fs::write(folder.path().join(format!("{name}.csv")), fruit_csv()).unwrap();
    }
    let args = ["locate", "two.csv", "one.csv", "three.csv", "--json", "--draw", "p.png"];
    let output = varsac(folder.path(), &args, "");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let inputs: Vec<String> = text(&output.stdout)
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap()["input"].as_str().unwrap().to_owned())
        .collect();
    assert_eq!(inputs, ["two.csv", "one.csv", "three.csv"]);
    for name in ["p-one.png", "p-two.png", "p-three.png"] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
    // One unreadable input does not keep the others from being worked on.
    let output = varsac(folder.path(), &["locate", "two.csv", "gone.csv", "one.csv", "--json"], "");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(text(&output.stdout).lines().count(), 2);
}

#[test]
fn unreadable_files_are_named() {
    let folder = folder();
    let at = folder.path();
    refuses(at, &["locate", "gone.ply"], "", &["gone.ply"]);
    refuses(at, &["locate", "-"], "1,2,3\n4,nan,6\n7,8,9\n", &["NaN"]);
    refuses(at, &["locate", "-"], "1,2,3\n4,5,inf\n", &["inf"]);
    refuses(at, &["locate", "-"], "", &["standard input"]);
    refuses(at, &["locate", "-"], "x,y,z\n", &["standard input"]);
    std::fs::write(
        at.join("huge.ply"),
        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\nproperty float z\nend_header\nabc",
    )
    .unwrap();
    refuses(at, &["locate", "huge.ply"], "", &["huge.ply", "4000000000"]);
    std::fs::write(
        at.join("a.pcd"),
        "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 9\n",
    )
    .unwrap();
    refuses(at, &["locate", "a.pcd"], "", &["a.pcd"]);
}

#[test]
fn unusable_frames_are_named() {
    let folder = folder();
    let small = written_frame(folder.path());
    let at = folder.path();
    refuses(at, &["locate", "small", "--regions", "mask"], "", &["mask.png"]);
    refuses(at, &["locate", "small", "--draw", "no/such/folder/p.png"], "", &["p.png"]);

    let depth = small.join("depth.png");
    let good = std::fs::read(&depth).unwrap();
    std::fs::write(&depth, &good[..good.len() / 2]).unwrap();
    refuses(at, &["locate", "small"], "", &["depth.png"]);
    std::fs::write(&depth, png_file::encode_labels(&Image::filled(160, 120, 7_u8)).unwrap()).unwrap();
    refuses(at, &["locate", "small"], "", &["depth.png", "16"]);
    std::fs::write(&depth, png_file::encode_counts(&Image::filled(80, 60, 700_u16)).unwrap()).unwrap();
    refuses(at, &["locate", "small"], "", &["160 x 120", "80 x 60", "calibration.json"]);
    std::fs::write(&depth, &good).unwrap();
    std::fs::remove_file(small.join("intrinsics.json")).unwrap();
    refuses(at, &["locate", "small"], "", &["intrinsics.json"]);
}

#[test]
fn impossible_options_name_field_value_and_range() {
    let folder = folder();
    let at = folder.path();
    let cases: [(&[&str], &[&str]); 12] = [
        (&["--semi-axes", "24..9"], &["semi-axes", "larger than"]),
        (&["--semi-axes", "9..inf"], &["semi-axes", "inf"]),
        (&["--semi-axes", "nan..9"], &["semi-axes", "NaN"]),
        (&["--semi-axes", "nine"], &["MIN..MAX"]),
        (&["--sizes", "8"], &["sizes", "8", "9 to 32"]),
        (&["--confidence", "0"], &["confidence", "above 0 and below 1"]),
        (&["--confidence", "1"], &["confidence", "above 0 and below 1"]),
        (&["--shell", "1.5"], &["shell", "1.5"]),
        (&["--radius", "0"], &["radius", "0"]),
        (&["--max-trials", "0"], &["max-trials", "1 to 1000000"]),
        (&["--capacity", "70000"], &["capacity", "65535"]),
        (&["--hue", "10..400"], &["400", "360"]),
    ];
    for (options, words) in cases {
        let mut args = vec!["locate", "-"];
        args.extend(options);
        refuses(at, &args, &fruit_csv(), words);
    }
}

#[test]
fn degenerate_clouds_are_not_accepted() {
    let folder = folder();
    let at = folder.path();
    let lines = |point: &dyn Fn(u32) -> String| (0..100).map(point).collect::<Vec<_>>().join("\n");
    accepts_nothing(at, &["locate", "-"], &lines(&|_| "1,2,700".to_owned()));
    accepts_nothing(at, &["locate", "-"], &lines(&|k| format!("{k},{k},{}", 700 + k)));
    accepts_nothing(at, &["locate", "-"], &lines(&|k| format!("{},{},700", k % 10, k / 10)));
    accepts_nothing(at, &["locate", "-"], "1,2,3\n4,5,6\n7,8,10\n");
    for method in ["direct", "ransac"] {
        accepts_nothing(
            at,
            &["locate", "-", "--method", method],
            &lines(&|k| format!("{},{},700", k % 10, k / 10)),
        );
    }
}

#[test]
fn too_many_points_are_thinned_and_that_is_said() {
    let folder = folder();
    let output = varsac(folder.path(), &["locate", "-", "--capacity", "500"], &seen_csv(1200.0));
    assert_eq!(output.status.code(), Some(0));
    assert!(text(&output.stdout).contains("kept 500 of 3040 points"), "{}", text(&output.stdout));
}

#[test]
fn help_and_completions_are_there() {
    let folder = folder();
    let help = varsac(folder.path(), &["locate", "--help"], "");
    assert_eq!(help.status.code(), Some(0));
    assert!(text(&help.stdout).contains("--cloud-out"));
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let output = varsac(folder.path(), &["completions", shell], "");
        assert_eq!(output.status.code(), Some(0));
        assert!(text(&output.stdout).contains("locate"), "{shell}");
    }
}

#[test]
fn the_demonstration_finds_fruit_and_draws_it() {
    let folder = folder();
    let output = varsac(folder.path(), &[], "");
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let stdout = text(&output.stdout);
    assert!(stdout.contains("varsac-demo.png") && stdout.contains(" 0 of them false"), "{stdout}");
    let picture = png_file::read(&folder.path().join("varsac-demo.png"), png_file::decode_colour).unwrap();
    assert_eq!(picture.width, 1920);
    let saved = varsac(folder.path(), &["demo", "--save-frame", "frame"], "");
    assert_eq!(saved.status.code(), Some(0), "{}", text(&saved.stderr));
    let located = varsac(folder.path(), &["locate", "frame"], "");
    assert_eq!(located.status.code(), Some(0), "{}", text(&located.stderr));
}

#[test]
fn an_experiment_prints_its_table_and_writes_its_files() {
    let folder = folder();
    let plain = varsac(folder.path(), &["experiment", "fig5", "--seeds", "2", "--out", "new"], "");
    assert_eq!(plain.status.code(), Some(0), "{}", text(&plain.stderr));
    assert!(
        text(&plain.stdout).contains("k, Eq. (15)") && text(&plain.stdout).contains("Report: new/fig5.html")
    );
    for file in ["fig5.md", "fig5.json", "fig5.html"] {
        assert!(folder.path().join("new").join(file).is_file(), "{file}");
    }
    let json = varsac(folder.path(), &["experiment", "fig5", "--seeds", "2", "--json"], "");
    let parsed: Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(parsed[0]["tables"][0]["rows"][0]["trials"], 7);

    let list = text(&varsac(folder.path(), &["experiment", "list"], "").stdout);
    assert!(list.lines().any(|line| line.starts_with("fig5 ")), "{list}");
    let unknown = varsac(folder.path(), &["experiment", "fig99"], "");
    assert_eq!(unknown.status.code(), Some(2));
    assert!(text(&unknown.stderr).contains("fig5"), "{}", text(&unknown.stderr));
}

#[test]
fn an_experiment_shows_a_given_frame_as_the_fruit_that_is_named() {
    let folder = folder();
    Frame::write(&frame(), &folder.path().join("frame")).unwrap();
    let regions = |fruit: &str| {
        let args = ["experiment", "fig9", "--json", "--frame", "frame", "--fruit", fruit];
        let output = varsac(folder.path(), &args, "");
        let parsed: Value = serde_json::from_slice(&output.stdout).unwrap();
        let rows = parsed[0]["tables"][0]["rows"].as_array().unwrap().clone();
        let given: Vec<Value> = rows.into_iter().filter(|row| row["frame"] == "given").collect();
        given.last().unwrap()["regions"].as_u64().unwrap()
    };
    // A red fruit has the hue of a jujube and not that of a lemon.
    assert_eq!((regions("jujube"), regions("lemon")), (1, 0));
    assert!(folder.path().join("varsac-experiments/fig9-given-d.png").is_file());
    let missing = varsac(folder.path(), &["experiment", "fig9", "--frame", "nowhere"], "");
    assert_eq!(missing.status.code(), Some(2));
}
