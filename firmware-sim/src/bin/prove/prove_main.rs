//! Arguments in, lines out.

use cortex_m_rt::entry;
// The core's log formats want a logger to link against; nothing is logged here.
use defmt_semihosting as _;
use semihosting::experimental::env::args;
use semihosting::{println, process::exit};
use varsac_core::{Point3, Workspace};
use varsac_firmware_sim::body;
use varsac_firmware_sim::scene::{self, SCENE_POINTS};
use varsac_firmware_sim::view::{self, Canvas, VIEW_POINTS};

use crate::{counts, default_counts, hardware, mixture_counts, startup};

#[entry]
fn main() -> ! {
    // Made at compile time: too large to pass over the stack on its way to where it stays.
    static mut CANVAS: Canvas = Canvas::new();
    startup::check_arithmetic();
    let Ok(arguments) = args::<128>() else { exit(2) };
    // The emulator hands on the first argument too; a program of this name has none.
    let mut words = arguments.filter_map(Result::ok).skip_while(|word| *word == "prove");
    match words.next() {
        Some("digests") => digests(count(words.next())),
        Some("views") => views(count(words.next()), CANVAS),
        Some("bodies") => bodies(count(words.next()), CANVAS),
        Some("counts") => counts(words.next(), CANVAS),
        Some("flush-to-zero") => {
            hardware::set_flush_to_zero();
            startup::check_arithmetic();
        }
        _ => exit(2),
    }
    exit(0)
}

fn count(word: Option<&str>) -> u64 {
    word.and_then(|count| count.parse().ok()).unwrap_or(0)
}

// Each in a frame of its own: the stack that is measured is not to be that of the others.
#[inline(never)]
fn digests(count: u64) {
    let cloud = cortex_m::singleton!(: [Point3; SCENE_POINTS] = [Point3::new(0.0, 0.0, 0.0); SCENE_POINTS]);
    let workspace = cortex_m::singleton!(: Workspace<SCENE_POINTS> = Workspace::new());
    let (Some(cloud), Some(workspace)) = (cloud, workspace) else { exit(2) };
    for number in 0..count {
        println!("{number} {}", scene::search_digest(number, cloud, workspace));
    }
}

#[inline(never)]
fn views(count: u64, canvas: &mut Canvas) {
    let workspace = cortex_m::singleton!(: Workspace<VIEW_POINTS> = Workspace::new());
    let Some(workspace) = workspace else { exit(2) };
    for number in 0..count {
        println!("{number} {}", view::search_digest(number, canvas, workspace));
    }
}

#[inline(never)]
fn bodies(count: u64, canvas: &mut Canvas) {
    let workspace = cortex_m::singleton!(: Workspace<VIEW_POINTS> = Workspace::new());
    let Some(workspace) = workspace else { exit(2) };
    for number in 0..count {
        println!("{number} {}", body::search_digest(number, canvas, workspace));
    }
}

fn counts(search: Option<&str>, canvas: &mut Canvas) {
    let overhead = counts::start();
    match search {
        Some("paper") => counts::paper(overhead),
        Some("map") => default_counts::print(overhead, canvas),
        Some("mixture") => mixture_counts::print(overhead),
        _ => exit(2),
    }
}
