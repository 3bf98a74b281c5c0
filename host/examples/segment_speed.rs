//! Prints how long one Kinect v2 frame takes from raw images to points, stage by stage: median of many runs.
//!
//! `cargo run --release -p varsac-host --example segment_speed`

use std::time::{Duration, Instant};

use varsac_host::backproject::{PointOptions, View};
use varsac_host::error::InputError;
use varsac_host::kinect::Registration;
use varsac_host::segment::filter::gate_of_mean;
use varsac_host::segment::hue::Gate;
use varsac_host::segment::regions::connected_regions;
use varsac_host::segment::{preset, segment};
use varsac_host::synth::{KinectRig, Scene, SceneOptions, render_kinect};

const RUNS: usize = 31;

fn main() -> Result<(), InputError> {
    let frame = render_kinect(&Scene::new(&SceneOptions::default()), &KinectRig::default());
    let registration = Registration::new(&frame.calibration);
    let options = preset("jujube");
    let gate = Gate::new(&options.gate)?;
    let mask = gate_of_mean(&frame.colour, options.mean_radius_px, &gate);
    let regions = connected_regions(&mask, options.area);
    let registered = registration.register(&frame.raw_depth)?;
    let view = View::Kinect { depth: &registered, registration: &registration };
    let points = view.points(&regions, &PointOptions::default())?;
    println!(
        "1920x1080 colour, 512x424 depth, {} regions, {} points; median of {RUNS} runs, one thread",
        regions.list.len(),
        points.iter().map(Vec::len).sum::<usize>()
    );
    report("mean filter and hue gate", || drop(gate_of_mean(&frame.colour, options.mean_radius_px, &gate)));
    report("connected regions", || drop(connected_regions(&mask, options.area)));
    report("depth-to-colour registration", || drop(registration.register(&frame.raw_depth)));
    let memory = std::cell::RefCell::new(registration.register(&frame.raw_depth)?);
    report("registration again", || {
        drop(registration.register_again(&frame.raw_depth, &mut memory.borrow_mut()))
    });
    report("tables of a device", || drop(Registration::new(&frame.calibration)));
    report("back-projection", || drop(view.points(&regions, &PointOptions::default())));
    report("all of it", || {
        let regions = segment(&frame.colour, &options);
        let registered = registration.register(&frame.raw_depth);
        if let (Ok(regions), Ok(registered)) = (regions, registered) {
            let view = View::Kinect { depth: &registered, registration: &registration };
            drop(view.points(&regions, &PointOptions::default()));
        }
    });
    Ok(())
}

fn report(stage: &str, run: impl Fn()) {
    let mut times: Vec<Duration> = (0..RUNS)
        .map(|_| {
            let start = Instant::now();
            run();
            start.elapsed()
        })
        .collect();
    times.sort();
    let milliseconds = |time: Duration| time.as_secs_f64() * 1000.0;
    println!("{stage:30} {:6.2} ms  (fastest {:.2})", milliseconds(times[RUNS / 2]), milliseconds(times[0]));
}
