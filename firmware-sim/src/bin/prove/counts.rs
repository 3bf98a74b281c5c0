//! Instructions of the paper's search and its parts, by the SysTick timer under a clock that advances 64 ns an instruction. Those
//! of the other searches: [`crate::default_counts`], [`crate::mixture_counts`].
//!
//! The timer counts 24 bits down; its wraps are counted by its interrupt (a dozen instructions each, one in ten
//! million). Reading it costs a few instructions, which are measured first and taken off.

use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::SYST;
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::exception;
use semihosting::{println, process::exit};
use varsac_core::fit::fit;
use varsac_core::tebc::Shell;
use varsac_core::{Config, Detector, Point3, Step, Workspace};
use varsac_firmware_sim::scene::{FRUIT_POINTS, SCENE_POINTS, config, one_fruit, scene};

use crate::hardware::stack_high_water;
use crate::startup::BOARD;

static WRAPS: AtomicU32 = AtomicU32::new(0);
const RELOAD: u32 = 0x00FF_FFFF;

#[exception]
fn SysTick() {
    WRAPS.store(WRAPS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}

pub(crate) fn ticks() -> u64 {
    loop {
        let before = WRAPS.load(Ordering::Relaxed);
        let down = SYST::get_current();
        if before == WRAPS.load(Ordering::Relaxed) {
            return u64::from(before) * (u64::from(RELOAD) + 1) + u64::from(RELOAD - down);
        }
    }
}

/// Instructions of `work`, and its result.
pub(crate) fn counted<T>(overhead: u64, work: impl FnOnce() -> T) -> (u64, T) {
    let start = ticks();
    let result = black_box(work());
    (since(start, overhead), result)
}

/// Instructions since `start`. For results that are too large to be handed through [`counted`].
pub(crate) fn since(start: u64, overhead: u64) -> u64 {
    let nanoseconds = (ticks() - start) * 1_000_000_000 / u64::from(BOARD.clock_hz);
    (nanoseconds / 64).saturating_sub(overhead)
}

/// Starts the timer; what reading it costs.
pub(crate) fn start() -> u64 {
    let Some(mut core) = cortex_m::Peripherals::take() else { exit(2) };
    core.SYST.set_clock_source(SystClkSource::Core);
    core.SYST.set_reload(RELOAD);
    core.SYST.clear_current();
    core.SYST.enable_interrupt();
    core.SYST.enable_counter();
    counted(0, || ()).0
}

/// The paper's search and its parts: prints one `name value` a line.
#[inline(never)]
pub(crate) fn paper(overhead: u64) {
    let cloud = cortex_m::singleton!(: [Point3; SCENE_POINTS] = [Point3::new(0.0, 0.0, 0.0); SCENE_POINTS]);
    let workspace = cortex_m::singleton!(: Workspace<SCENE_POINTS> = Workspace::new());
    let (Some(cloud), Some(workspace)) = (cloud, workspace) else { exit(2) };

    let fruit = cloud.get_mut(..FRUIT_POINTS).unwrap_or_default();
    one_fruit(fruit);
    let fruit = &*fruit;
    let Ok(paper) = Detector::new(Config::table5()) else { exit(2) };

    // Nine points spread over the visible half: every 22nd.
    let sample: [u16; 9] = core::array::from_fn(|k| 22 * k as u16);
    let (nine_points, surface) =
        counted(overhead, || fit(black_box(fruit), black_box(&sample), paper.config().constraint));
    let all: [u16; FRUIT_POINTS] = core::array::from_fn(|k| k as u16);
    let Ok(surface) = fit(fruit, &all, paper.config().constraint).or(surface) else { exit(3) };
    let shell = Shell::new(&surface, paper.config().shell);
    let (tebc, _) = counted(overhead, || shell.score(black_box(fruit), black_box(&all)));

    let one = search(&paper, overhead, fruit, workspace, true);
    scene(0, cloud);
    let Ok(wider) = Detector::new(Config { max_trials: 3000, ..config(0) }) else { exit(2) };
    let whole = search(&wider, overhead, cloud, workspace, false);
    let stack = stack_high_water();

    println!("tebc_point_x100 {}", tebc * 100 / FRUIT_POINTS as u64);
    println!("fit_9_points {nine_points}");
    println!("hypothesis {}", one.trial_instructions / u64::from(one.trials.max(1)));
    println!("fruit_200_points {}", one.instructions);
    println!("fruit_200_points_trials {}", one.trials);
    println!("cloud_300_points {}", whole.instructions);
    println!("cloud_300_points_trials {}", whole.trials);
    println!("longest_step {}", one.longest.max(whole.longest));
    println!("stack_bytes {stack}");
}

#[derive(Default)]
struct Cost {
    instructions: u64,
    trials: u32,
    /// Of the steps between the preparation of the search and the refit.
    trial_instructions: u64,
    longest: u64,
}

/// Searches `cloud`: the first fruit only, or all of it.
fn search(
    detector: &Detector,
    overhead: u64,
    cloud: &[Point3],
    workspace: &mut Workspace<SCENE_POINTS>,
    first: bool,
) -> Cost {
    let mut cost = Cost::default();
    let start = ticks();
    let Ok(mut run) = detector.detect(cloud, workspace.scratch(), 1) else { exit(3) };
    cost.instructions = since(start, overhead);
    loop {
        let start = ticks();
        let (trials, over) = match run.step() {
            Step::Working => (None, false),
            Step::Found(detection) => (Some(detection.report.trials), first),
            Step::Missed(report) => (Some(report.trials), false),
            Step::Finished(_) => (Some(0), true),
        };
        let step = since(start, overhead);
        cost.instructions += step;
        cost.longest = cost.longest.max(step);
        match trials {
            None => cost.trial_instructions += step,
            Some(trials) => cost.trials += trials,
        }
        if over {
            return cost;
        }
    }
}
