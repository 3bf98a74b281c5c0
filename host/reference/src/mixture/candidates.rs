//! The choice among the shells kept, and the final fit: contract, chapter X9.

use super::climb::{Climb, climb};
use super::config::MixtureConfig;
use super::look::{Look, Scene};
use super::shell::Shell;
use super::starts::Kept;
use crate::fault::{self, Fault};
use crate::map::algebra::Vector;

/// X9: the first of the polished shells with the largest gain over the sample.
pub(crate) fn best(kept: &[Kept], scene: &Scene, sample: &[Vector], config: &MixtureConfig) -> Option<Shell> {
    let mut best: Option<Kept> = None;
    for candidate in kept {
        let shell = polished(candidate.shell, scene, sample, config);
        let gain = Look::new(scene, &shell, shell.ln_area(), sample).gain();
        if best.is_none_or(|best| gain > best.gain) {
            best = Some(Kept { shell, gain });
        }
    }
    best.map(|best| best.shell)
}

/// X9: a climb with the area as it is and no upper limit of the scale.
fn climbed(
    shell: &Shell,
    scene: &Scene,
    points: &[Vector],
    config: &MixtureConfig,
    least: f32,
) -> Option<Climb> {
    let look = Look::new(scene, shell, shell.ln_area(), points);
    climb(shell, &look.pass(config.area_weight, config.shape_spread), least, f32::INFINITY)
}

/// X9, polish.
fn polished(mut shell: Shell, scene: &Scene, sample: &[Vector], config: &MixtureConfig) -> Shell {
    for _ in 0..12 {
        let Some(climb) = climbed(&shell, scene, sample, config, 0.002) else { break };
        shell = climb.shell;
        let goes_on = climb.promise >= 0.001;
        if !goes_on {
            break;
        }
    }
    shell
}

/// X9, final fit.
pub(crate) fn final_fit(mut shell: Shell, scene: &Scene, points: &[Vector], config: &MixtureConfig) -> Shell {
    let mut i = 0;
    loop {
        match climbed(&shell, scene, points, config, 0.0001) {
            Some(climb) if climb.promise >= 0.001 && i + 1 < 25 => shell = climb.shell,
            Some(climb) if fault::is(Fault::FinalFit) => return climb.shell,
            _ => return shell,
        }
        i += 1;
    }
}
