//! Real recordings: magnetometer logs, scanned fruit, camera frames. They are not part of the project; where they are absent
//! the tests say so and pass. `VARSAC_SHARED` names the folder that holds `data/`, else it is `../shared` of the repository.

use std::path::{Path, PathBuf};

use serde_json::Value;
use varsac_core::{Viewpoint, mixture::MixtureConfig};
use varsac_host::cloud::Cloud;
use varsac_host::frame::Frame;
use varsac_host::fruit::Fruit;
use varsac_host::locate::{Camera, Located, Method, Options, RegionSource, locate_cloud, locate_frame};
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

/// The semi-axes of a reference fit by this criterion.
fn reference_semi_axes(cloud: &Path, criterion: Method) -> [f64; 3] {
    let text = std::fs::read_to_string(cloud.with_extension("truth.json")).unwrap();
    let truth: Value = serde_json::from_str(&text).unwrap();
    let axes = &truth["reference_fits"][criterion.name()]["semiaxes"];
    [0, 1, 2].map(|k| axes[k].as_f64().unwrap())
}

/// All points, by this method; with the uncertainty of the semi-axes.
fn semi_axes(cloud: &Path, method: Method) -> ([f64; 3], [f64; 3]) {
    let options = Options { method, ..Options::new(Fruit::None.config(), RegionSource::Mask, 1) };
    let located = locate_cloud("cloud", &Cloud::read(cloud, None).unwrap(), &options).unwrap();
    let [target] = &located.targets[..] else { panic!("{}: {:?}", cloud.display(), located.targets) };
    let covariance = target.covariance.expect("more than nine points");
    let sigma = [3, 4, 5].map(|k| f64::from(covariance.entry(k, k)).sqrt());
    (target.ellipsoid.semi_axes.map(f64::from), sigma)
}

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|own| own == extension));
    paths.sort();
    paths
}

#[test]
fn magnetometer_logs_give_the_semi_axes_of_both_reference_fits() {
    let Some(folder) = recordings("mag") else { return };
    let logs = files(&folder, "csv");
    assert_eq!(logs.len(), 8);
    for log in logs {
        for method in [Method::Algebraic, Method::Geometric] {
            let (values, sigma) = semi_axes(&log, method);
            for ((value, expected), sigma) in
                values.into_iter().zip(reference_semi_axes(&log, method)).zip(sigma)
            {
                let off = (value / expected - 1.0).abs();
                println!(
                    "{}: {value:.4} +- {sigma:.4}, {} {expected:.4}, off by {:.4} %",
                    log.display(),
                    method.name(),
                    100.0 * off
                );
                assert!(off < 1e-3);
                assert!(sigma > 0.0 && sigma < 0.02 * value);
            }
        }
    }
}

#[test]
fn scanned_fruit_give_the_semi_axes_of_both_reference_fits() {
    let Some(folder) = recordings("clouds") else { return };
    for name in ["ycb-014_lemon.ply", "ycb-056_tennis_ball.ply"] {
        let scan = folder.join(name);
        for method in [Method::Algebraic, Method::Geometric] {
            let (values, sigma) = semi_axes(&scan, method);
            for ((value, expected), sigma) in
                values.into_iter().zip(reference_semi_axes(&scan, method)).zip(sigma)
            {
                println!("{name}: {value:.4} +- {sigma:.4} mm, {} {expected:.4} mm", method.name());
                assert!((value - expected).abs() < 0.2);
            }
        }
    }
}

#[test]
fn scans_without_fruit_have_no_accepted_target_of_any_size() {
    let Some(folder) = recordings("clouds") else { return };
    let mut config = Fruit::None.config();
    config.method = varsac_core::Method::Mixture;
    config.mixture = MixtureConfig::SURFACE;
    config.map.viewpoint = Viewpoint::None;
    let clouds = files(&folder, "pcd");
    assert_eq!(clouds.len(), 2);
    for cloud in clouds {
        let options = Options::new(config.clone(), RegionSource::Mask, 1);
        let located = locate_cloud("cloud", &Cloud::read(&cloud, None).unwrap(), &options).unwrap();
        let codes: Vec<String> =
            located.targets.iter().filter_map(|t| t.refusal.map(|r| r.brief())).collect();
        println!("{}: {}", cloud.display(), codes.join(", "));
        assert_eq!(located.accepted().count(), 0);
    }
}

fn located(folder: &Path, name: &str, fruit: Fruit, regions: RegionSource) -> Located {
    let options = Options::new(fruit.config(), regions, 1);
    locate_frame(name, &Frame::read(&folder.join(name)).unwrap(), &options).unwrap()
}

#[test]
fn no_target_is_accepted_where_there_is_no_fruit() {
    let Some(folder) = recordings("frames") else { return };
    for name in ["neg-redbin-full", "neg-redlids-5", "neg-table-1"] {
        for fruit in [Fruit::Jujube, Fruit::Apple] {
            let colour = RegionSource::Colour(preset(fruit.name()));
            let located = located(&folder, name, fruit, colour);
            let false_targets = located.accepted().count();
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
        targets += located.accepted().count();
        let frame = Frame::read(&folder.join(name)).unwrap();
        let camera = Camera::of(&frame).unwrap();
        let view = camera.view(&frame);
        let instances = frame.instances.as_ref().unwrap();
        for (instance, caliper_mm) in open_apples(&folder, name) {
            let diameter = located.accepted().find_map(|target| {
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
