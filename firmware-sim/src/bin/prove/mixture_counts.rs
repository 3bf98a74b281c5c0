//! Instructions of the search without a size prior: a complete surface of 400 points, a third of them clutter.

use semihosting::{println, process::exit};
use varsac_core::mixture::MixtureConfig;
use varsac_core::{Config, Detector, Point3, Step, Workspace};
use varsac_firmware_sim::body::{BODY_POINTS, one_body};

use crate::counts::{since, ticks};
use crate::hardware::stack_high_water;

/// Prints one `name value` a line. What a start costs is the difference between searches with and without the random ones.
#[inline(never)]
pub(crate) fn print(overhead: u64) {
    let cloud = cortex_m::singleton!(: [Point3; BODY_POINTS] = [Point3::new(0.0, 0.0, 0.0); BODY_POINTS]);
    let workspace = cortex_m::singleton!(: Workspace<BODY_POINTS> = Workspace::new());
    let (Some(cloud), Some(workspace)) = (cloud, workspace) else { exit(2) };
    one_body(cloud);
    let starts = MixtureConfig::SURFACE.starts;
    let all = search(starts, overhead, cloud, workspace);
    let first = search(0, overhead, cloud, workspace);
    println!("mixture.points {BODY_POINTS}");
    println!("mixture.surface {}", all.instructions);
    println!("mixture.surface_steps {}", all.steps);
    println!("mixture.surface_of_one_start {}", first.instructions);
    println!("mixture.start {}", all.instructions.saturating_sub(first.instructions) / u64::from(starts));
    println!("mixture.longest_step {}", all.longest);
    println!("mixture.stack_bytes {}", stack_high_water());
}

#[derive(Default)]
struct Cost {
    instructions: u64,
    steps: u64,
    longest: u64,
}

/// Searches for one body.
#[inline(never)]
fn search(starts: u8, overhead: u64, cloud: &[Point3], workspace: &mut Workspace<BODY_POINTS>) -> Cost {
    let mixture = MixtureConfig { starts, ..MixtureConfig::SURFACE };
    let Ok(detector) = Detector::new(Config { max_targets: 1, mixture, ..Config::surface() }) else {
        exit(2)
    };
    let mut cost = Cost::default();
    let Ok(mut run) = detector.detect(cloud, workspace.scratch(), 1) else { exit(3) };
    loop {
        let start = ticks();
        let finished = matches!(run.step(), Step::Finished(_));
        let instructions = since(start, overhead);
        cost.instructions += instructions;
        cost.steps += 1;
        cost.longest = cost.longest.max(instructions);
        if finished {
            return cost;
        }
    }
}
