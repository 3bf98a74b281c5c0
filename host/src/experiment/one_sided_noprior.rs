//! One view of fruit of unknown size: all methods side by side, with and without the outline of the depth image.

use varsac_core::{Point3, View, mixture::MixtureConfig};

use super::{
    Context, Experiment, Report,
    noprior::{Outcome, Way, columns, summary},
    table::{Column, Table, row},
};
use crate::{
    error::InputError,
    eval::EllipsoidF64,
    outline::outline_rays,
    synth::onesided::{CLEAN, Family, HARD, OCCLUDED, Scene},
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
/// What separates two surfaces in depth, mm.
const STEP_MM: f32 = 10.0;

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
        let (points, in_mask) = scene.cloud(&scene.mask);
        let cloud: Vec<Point3> = points.iter().map(|&p| Point3::from(p)).collect();
        let (window, focal_px) = (scene.patch.window, scene.sensor.focal_px);
        let outline = if with_outline {
            let (columns, rows) = (scene.mask.width as i64, scene.mask.height as i64);
            outline_rays(
                &scene.patch.depth,
                (0..=columns - 1, 0..=rows - 1),
                |u, v| scene.mask.get(u, v).is_some_and(|label| label > 0),
                focal_px,
                |u, v| [(window.left as f64 + u) / focal_px, (window.top as f64 + v) / focal_px],
                STEP_MM,
            )
        } else {
            Vec::new()
        };
        // The other methods know nothing of surroundings.
        let seen = match way {
            Way::Mixture(_) => View { cloud: &cloud, in_mask, outline: &outline, pitch_rad: 0.0 },
            _ => View::from(&cloud[..in_mask]),
        };
        let fruit = scene.fruit[0];
        let truth = EllipsoidF64::sorted(fruit.pose.centre, fruit.semi_axes_mm, fruit.pose.axes);
        way.answer(&seen, &truth, seed)
    })
}
