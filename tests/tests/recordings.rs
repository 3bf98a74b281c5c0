//! Real recordings: magnetometer logs, scanned fruit, camera frames. They are not part of the project; where they are absent
//! the tests say so and pass. `VARSAC_SHARED` names the folder that holds `data/`, else it is `../shared` of the repository.

use std::path::{Path, PathBuf};

use serde_json::Value;
use varsac_core::{Constraint, Ellipsoid};
use varsac_host::cloud::Cloud;
use varsac_host::frame::Frame;
use varsac_host::fruit::Fruit;
use varsac_host::locate::{Camera, Located, Options, RegionSource, Target, fit_all, locate_frame};
use varsac_host::segment::preset;

/// A folder of the recordings.
fn recordings(folder: &str) -> Option<PathBuf> {
    let shared = std::env::var_os("VARSAC_SHARED")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"), PathBuf::from);
    let path = shared.join("data").join(folder);
    if !path.is_dir() {
        eprintln!("NOT TESTED: the recordings in {} are absent", path.display());
        return None;
    }
    Some(path)
}

fn reference_semi_axes(cloud: &Path) -> [f64; 3] {
    let text = std::fs::read_to_string(cloud.with_extension("truth.json")).unwrap();
    let truth: Value = serde_json::from_str(&text).unwrap();
    let axes = &truth["reference_fits"]["algebraic"]["semiaxes"];
    [0, 1, 2].map(|k| axes[k].as_f64().unwrap())
}

fn direct(cloud: &Path) -> [f64; 3] {
    let points = Cloud::read(cloud, None).unwrap().points_mm;
    let surface = fit_all(&points, Constraint::Trace).unwrap();
    Ellipsoid::from(&surface).semi_axes.map(f64::from)
}

#[test]
fn magnetometer_logs_give_the_algebraic_semi_axes() {
    let Some(folder) = recordings("mag") else { return };
    let mut logs: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    logs.retain(|path| path.extension().is_some_and(|extension| extension == "csv"));
    logs.sort();
    assert_eq!(logs.len(), 8);
    for log in logs {
        for (value, expected) in direct(&log).into_iter().zip(reference_semi_axes(&log)) {
            let off = (value / expected - 1.0).abs();
            println!("{}: {value:.4}, algebraic {expected:.4}, off by {:.4} %", log.display(), 100.0 * off);
            assert!(off < 1e-3);
        }
    }
}

#[test]
fn scanned_fruit_give_the_algebraic_semi_axes() {
    let Some(folder) = recordings("clouds") else { return };
    for name in ["ycb-014_lemon.ply", "ycb-056_tennis_ball.ply"] {
        let scan = folder.join(name);
        for (value, expected) in direct(&scan).into_iter().zip(reference_semi_axes(&scan)) {
            println!("{name}: {value:.4} mm, algebraic {expected:.4} mm");
            assert!((value - expected).abs() < 0.2);
        }
    }
}

fn located(folder: &Path, name: &str, fruit: Fruit, regions: RegionSource) -> Located {
    let options = Options::new(fruit.config(), regions, 1);
    locate_frame(name, &Frame::read(&folder.join(name)).unwrap(), &options).unwrap()
}

fn accepted(located: &Located) -> impl Iterator<Item = &Target> {
    located.targets.iter().filter(|target| target.refusal.is_none())
}

#[test]
fn no_target_is_accepted_where_there_is_no_fruit() {
    let Some(folder) = recordings("frames") else { return };
    for name in ["neg-redbin-full", "neg-redlids-5", "neg-table-1"] {
        for fruit in [Fruit::Jujube, Fruit::Apple] {
            let colour = RegionSource::Colour(preset(fruit.name()));
            let located = located(&folder, name, fruit, colour);
            let false_targets = accepted(&located).count();
            println!(
                "{name} as {}: {} of {} targets accepted",
                fruit.name(),
                false_targets,
                located.targets.len()
            );
            assert_eq!(false_targets, 0, "{name} as {}", fruit.name());
        }
    }
}

/// A labelled apple that no leaf covers: its instance and its caliper diameter, mm.
fn open_apples(folder: &Path, name: &str) -> Vec<(u8, f64)> {
    let text = std::fs::read_to_string(folder.join(name).join("truth.json")).unwrap();
    let truth: Value = serde_json::from_str(&text).unwrap();
    let objects = truth["objects"].as_array().unwrap();
    let open = objects.iter().filter(|object| object["occluded"] == false && object["kind"] == "apple");
    open.map(|apple| (apple["instance"].as_u64().unwrap() as u8, apple["caliper_mm"].as_f64().unwrap()))
        .collect()
}

/// An apple's caliper diameter and, where a target with its centre in the apple's instance was accepted, the mean of the
/// target's diameters, mm.
type Apple = (f64, Option<f64>);

/// The unoccluded apples of both orchard frames, and the number of all accepted targets.
fn measured(regions: impl Fn() -> RegionSource) -> Option<(Vec<Apple>, usize)> {
    let folder = recordings("frames")?;
    let (mut apples, mut targets) = (Vec::new(), 0);
    for name in ["fuji-121804", "fuji-125309"] {
        let located = located(&folder, name, Fruit::Apple, regions());
        targets += accepted(&located).count();
        let frame = Frame::read(&folder.join(name)).unwrap();
        let camera = Camera::of(&frame).unwrap();
        let view = camera.view(&frame);
        let instances = frame.instances.as_ref().unwrap();
        for (instance, caliper_mm) in open_apples(&folder, name) {
            let diameter = accepted(&located).find_map(|target| {
                let (u, v) = view.project(&target.ellipsoid.centre.cast())?;
                let own = instances.get(u.round() as i64, v.round() as i64) == Some(instance);
                own.then(|| target.ellipsoid.semi_axes.iter().map(|&a| f64::from(a)).sum::<f64>() / 1.5)
            });
            apples.push((caliper_mm, diameter));
        }
    }
    Some((apples, targets))
}

/// Mean absolute error after one scale factor common to all, mm, and the factor: the smallest over 0.8 to 1.2.
fn error_after_scale(pairs: &[(f64, f64)]) -> (f64, f64) {
    let error = |k: f64| {
        pairs.iter().map(|(truth, value)| (k * value - truth).abs()).sum::<f64>() / pairs.len() as f64
    };
    let factors = (0..=400).map(|step| 0.8 + 0.001 * f64::from(step));
    factors.map(|k| (error(k), k)).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
}

#[test]
fn apples_of_given_masks_are_accepted_and_measured() {
    let Some((apples, targets)) = measured(|| RegionSource::Instances) else { return };
    let pairs: Vec<(f64, f64)> = apples.iter().filter_map(|&(truth, value)| Some((truth, value?))).collect();
    let (error_mm, factor) = error_after_scale(&pairs);
    println!(
        "{} of {} unoccluded apples accepted ({targets} targets in all), diameter off by {error_mm:.2} mm (mean, after a factor {factor:.3})",
        pairs.len(),
        apples.len()
    );
    assert!(pairs.len() as f64 >= 0.85 * apples.len() as f64);
    assert!(error_mm <= 4.0);
}

#[test]
fn apples_are_found_by_their_colour() {
    let Some((apples, targets)) = measured(|| RegionSource::Colour(preset(Fruit::Apple.name()))) else {
        return;
    };
    let found = apples.iter().filter(|(_, value)| value.is_some()).count();
    println!(
        "{found} of {} unoccluded apples accepted by colour alone, {targets} targets in all",
        apples.len()
    );
    // A share of a quarter is where something is broken.
    assert!(4 * found >= apples.len());
}
