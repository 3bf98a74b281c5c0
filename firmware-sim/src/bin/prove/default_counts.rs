//! Instructions of the default search, step by step, by what the step was for.

use semihosting::{println, process::exit};
use varsac_core::{Config, Detector, Estimate, Observer, Rejection, Stage, Step, View, Workspace};
use varsac_firmware_sim::view::{Canvas, VIEW_POINTS};

use crate::counts::{since, ticks};
use crate::hardware::stack_high_water;

/// What steps are for, in the order of the lines that are printed.
const PARTS: [&str; 6] = ["other", "hypotheses", "refinement", "final", "judging", "verdict"];
const VERDICT: usize = 5;

/// Steps and instructions of one part.
#[derive(Debug, Clone, Copy, Default)]
struct Part {
    steps: u64,
    instructions: u64,
}

/// Sees what a step is for.
#[derive(Default)]
struct Purpose(usize);

impl Observer for Purpose {
    fn estimate(&mut self, stage: Stage, _estimate: &Estimate) {
        self.0 = match stage {
            Stage::Hypothesis => 1,
            Stage::Refined => 2,
            Stage::Final | Stage::Joint => 3,
            Stage::Free => 4,
        };
    }

    /// A hypothesis may die before it is one.
    fn rejected(&mut self, _reason: Rejection) {
        self.0 = 1;
    }
}

/// Prints one `name value` a line: a view of one whole fruit, about 250 points and its outline. What it costs to
/// find and judge it; no other is asked for.
#[inline(never)]
pub(crate) fn print(overhead: u64, canvas: &mut Canvas) {
    let workspace = cortex_m::singleton!(: Workspace<VIEW_POINTS> = Workspace::new());
    let Some(workspace) = workspace else { exit(2) };
    let view = canvas.one_fruit();
    println!("map.points {}", view.cloud.len());
    println!("map.outline_rays {}", view.outline.len());
    let Ok(first_only) = Detector::new(Config { max_targets: 1, ..Config::jujube() }) else { exit(2) };
    let one = search(&first_only, overhead, &view, workspace);
    println!("map.fruit {}", one.total());
    for (name, part) in PARTS.iter().zip(one.parts) {
        println!("map.fruit_{name} {}", part.instructions);
        println!("map.fruit_{name}_steps {}", part.steps);
    }
    let bare = View { outline: &[], ..view };
    let without = search(&first_only, overhead, &bare, workspace);
    println!("map.fruit_without_outline {}", without.total());
    println!("map.longest_step {}", one.longest.max(without.longest));
    println!("map.stack_bytes {}", stack_high_water());
}

#[derive(Default)]
struct Cost {
    parts: [Part; PARTS.len()],
    longest: u64,
}

impl Cost {
    fn total(&self) -> u64 {
        self.parts.iter().map(|part| part.instructions).sum()
    }

    fn add(&mut self, purpose: usize, instructions: u64) {
        if let Some(part) = self.parts.get_mut(purpose) {
            part.steps += 1;
            part.instructions += instructions;
        }
        self.longest = self.longest.max(instructions);
    }
}

/// Searches to the end.
#[inline(never)]
fn search(
    detector: &Detector,
    overhead: u64,
    view: &View<'_>,
    workspace: &mut Workspace<VIEW_POINTS>,
) -> Cost {
    let mut cost = Cost::default();
    let start = ticks();
    let Ok(mut run) = detector.detect_view(view, workspace.scratch(), 1) else { exit(3) };
    cost.add(0, since(start, overhead));
    loop {
        let mut purpose = Purpose::default();
        let start = ticks();
        match run.step_observed(&mut purpose) {
            Step::Finished(_) => return cost,
            Step::Found(_) => purpose.0 = VERDICT,
            Step::Working | Step::Missed(_) => {}
        }
        cost.add(purpose.0, since(start, overhead));
    }
}
