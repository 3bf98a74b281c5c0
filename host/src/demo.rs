//! The demonstration: a rendered Kinect v2 pair goes the whole way, and what is found is held against the truth.
//!
//! Colour (1920x1080) and raw depth (512x424) are rendered unregistered, with noise, holes and flying pixels; the
//! mapping between the two cameras is on the main path, as with a real device.

use std::fmt::Write as _;
use std::time::Duration;

use crate::{
    error::InputError,
    eval::{
        EllipsoidF64,
        attitude::{EQUAL_AXES_RATIO, axis_error_deg},
        matching::match_centres,
    },
    frame::{Frame, Geometry},
    fruit::Fruit,
    locate::{Camera, Located, Options, RegionSource, locate_frame},
    segment,
    synth::{KinectRig, Scene, SceneOptions, TrueFruit, render_kinect},
};

/// Scene and search of the plain command.
pub const SEED: u64 = 22;
/// Where the picture goes.
pub const PICTURE: &str = "varsac-demo.png";

/// A centre farther than this from every true one is a false target, millimetres: the short semi-axis of a jujube.
const GATE_MM: f64 = 11.0;

/// The rendered frame, what was found in it, and the truth.
#[derive(Debug)]
pub struct Demo {
    /// The frame.
    pub frame: Frame,
    /// Its cameras.
    pub camera: Camera,
    /// What was found.
    pub located: Located,
    /// Every fruit of the scene.
    pub truth: Vec<TrueFruit>,
}

/// Renders the scene of `seed` and locates its fruit.
///
/// # Errors
/// None that a valid seed can cause; those of the stages are handed on.
pub fn run(seed: u64) -> Result<Demo, InputError> {
    let scene = Scene::new(&SceneOptions { seed, ..SceneOptions::default() });
    let rendered = render_kinect(&scene, &KinectRig::default());
    let frame = Frame {
        name: format!("demo-{seed}"),
        colour: rendered.colour,
        depth_mm: rendered.raw_depth,
        geometry: Geometry::Factory(Box::new(rendered.calibration)),
        mask: None,
        instances: Some(rendered.instances),
    };
    let colour = RegionSource::Colour(segment::preset(Fruit::Jujube.name()));
    let options = Options::new(Fruit::Jujube.config(), colour, seed);
    let located = locate_frame("demo", &frame, &options)?;
    let camera = Camera::of(&frame)?;
    Ok(Demo { frame, camera, located, truth: rendered.fruits })
}

impl Demo {
    /// One line a fruit of the scene: where it is, where it was found, how far off, how long it took in all.
    pub fn table(&self) -> String {
        let truths: Vec<EllipsoidF64> = self.truth.iter().map(|fruit| fruit.ellipsoid).collect();
        let found: Vec<EllipsoidF64> =
            self.located.accepted().map(|target| EllipsoidF64::from(&target.ellipsoid)).collect();
        let centres = |list: &[EllipsoidF64]| list.iter().map(|e| e.centre_mm).collect::<Vec<_>>();
        let matching = match_centres(&centres(&truths), &centres(&found), GATE_MM);

        let mut text = format!(
            "A rendered Kinect v2 view (mean of 16 exposures): {} jujubes; {} targets accepted, {} false; {} refused.\n\n",
            truths.len(),
            found.len(),
            matching.false_detections.len(),
            self.located.targets.len() - found.len()
        );
        let _ = writeln!(
            text,
            "  {:>2}  {:>24}  {:>7}  {:>24}  {:>9}  {:>8}  {:>8}",
            "#", "true centre mm", "visible", "found centre mm", "centre mm", "size mm", "axis deg"
        );
        for (k, (truth, fruit)) in truths.iter().zip(&self.truth).enumerate() {
            let place = |c: [f64; 3]| format!("{:>7.1} {:>7.1} {:>8.1}", c[0], c[1], c[2]);
            let _ = write!(
                text,
                "  {:>2}  {:>24}  {:>5.0} %",
                k + 1,
                place(truth.centre_mm),
                100.0 * fruit.visible_fraction
            );
            match matching.matches.iter().find(|pair| pair.truth == k) {
                None => text.push_str("  not accepted\n"),
                Some(pair) => {
                    let fit = &found[pair.detection];
                    let size: f64 = (0..3).map(|i| (truth.semi_axes_mm[i] - fit.semi_axes_mm[i]).abs()).sum();
                    let axis = axis_error_deg(truth, fit, EQUAL_AXES_RATIO);
                    let _ = writeln!(
                        text,
                        "  {:>24}  {:>9.2}  {:>8.2}  {:>8}",
                        place(fit.centre_mm),
                        pair.distance_mm,
                        size / 3.0,
                        axis.map_or_else(|| "-".to_owned(), |deg| format!("{deg:.1}"))
                    );
                }
            }
        }
        let _ = writeln!(
            text,
            "\nSegmentation, registration and search: {}.",
            milliseconds(self.located.elapsed)
        );
        text
    }
}

fn milliseconds(elapsed: Duration) -> String {
    format!("{:.1} ms", elapsed.as_secs_f64() * 1e3)
}
