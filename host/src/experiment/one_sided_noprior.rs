//! One view of fruit of unknown size: all methods side by side, with and without the outline of the depth image.

use varsac_core::{View, mixture::MixtureConfig};

use super::{
    Context, Experiment, Report,
    noprior::{Outcome, Way, columns, summary},
    table::{Column, Table, row},
};
use crate::{
    error::InputError,
    synth::onesided::{
        MaskBias, Scene,
        families::{CLEAN, Family, HARD, OCCLUDED},
    },
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "one-sided-noprior",
    purpose: "Jujubes seen from one side, their size unknown: all methods, with and without outline rays.",
    run,
};

const MIXTURE: Way = Way::Mixture(MixtureConfig::VIEW);
/// Runs of the slow methods are fewer by this factor.
const FEWER: usize = 10;

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(400);
    let few = &seeds[..(seeds.len() / FEWER).max(1)];
    let keys = ["family", "outline", "method"].map(|key| Column::new(key, key, 0));
    let mut table = Table::new("One view, no prior (mm)", keys.into_iter().chain(columns()).collect());
    let mut findings = Vec::new();
    // One fruit a scene: what is to be found has to be defined.
    let single = |family: Family| Family { neighbour: 0.0, ..family };
    for family in [CLEAN, single(OCCLUDED), single(HARD)] {
        let plain =
            [(MIXTURE, &seeds[..]), (Way::Paper, few), (Way::Ransac(1.5), few), (Way::Direct, &seeds)];
        for (with_outline, ways) in [(false, &plain[..]), (true, &plain[..1])] {
            for &(way, seeds) in ways {
                let outcomes = outcomes(context, &family, with_outline, way, seeds);
                let outline = if with_outline { "yes" } else { "no" };
                let failed = outcomes.iter().filter(|outcome| outcome.failed).count();
                findings.push(format!(
                    "{}, outline {outline}, {}: {failed} of {} failed.",
                    family.name,
                    way.name(),
                    outcomes.len()
                ));
                table.push([row![family.name, outline, way.name()], summary(&outcomes)].concat());
            }
        }
    }
    Ok(Report { findings, tables: vec![table], figures: Vec::new() })
}

/// One outcome for each seed.
fn outcomes(context: &Context, family: &Family, with_outline: bool, way: Way, seeds: &[u64]) -> Vec<Outcome> {
    context.each(seeds, |&seed| {
        let scene = Scene::new(family, seed);
        let mut seen = scene.sighting(MaskBias::default());
        if !with_outline {
            seen.outline.clear();
        }
        // The other methods know nothing of surroundings.
        let view = match way {
            Way::Mixture(_) => seen.full(),
            _ => View::from(&seen.cloud[..seen.in_mask]),
        };
        let truth = scene.fruit[0].ellipsoid;
        way.answer(&view, &truth, seed)
    })
}
