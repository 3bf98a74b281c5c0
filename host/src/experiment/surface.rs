//! Whole surfaces without a size prior: all methods side by side, and the search of this project by slices.

use varsac_core::{View, mixture::MixtureConfig};

use super::{
    Context, Experiment, Report,
    noprior::{Outcome, Way, columns, summary},
    table::{Column, Table, row},
};
use crate::{
    error::InputError,
    synth::{
        SimulationOptions, simulate,
        surface::{Body, CLUTTERED, SIZE, SURFACE, SurfaceFamily},
    },
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "surface",
    purpose: "Whole ellipsoids of unknown size among outliers: all methods, by noise, outliers, aspect and coverage.",
    run,
};

const MIXTURE: Way = Way::Mixture(MixtureConfig::SURFACE);
/// Runs of the slow methods are fewer by this factor.
const FEWER: usize = 10;

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(400);
    let few = &seeds[..(seeds.len() / FEWER).max(1)];
    let ways =
        [(MIXTURE, &seeds[..]), (Way::Paper, few), (Way::Ransac(0.1 * SIZE), few), (Way::Direct, &seeds)];
    let mut table =
        Table::new("Methods side by side, geometric-mean semi-axis 10", titled(&["family", "method"]));
    let mut findings = Vec::new();
    for family in [SURFACE, CLUTTERED] {
        for (way, seeds) in ways {
            let outcomes = outcomes(context, &family, way, seeds);
            let failed = outcomes.iter().filter(|outcome| outcome.failed).count();
            findings.push(format!("{}, {}: {failed} of {} failed.", family.name, way.name(), outcomes.len()));
            table.push([row![family.name, way.name()], summary(&outcomes)].concat());
        }
    }
    let mut simulation =
        Table::new("The paper's simulation, 2000 points, 30 % outliers", titled(&["sigma", "method"]));
    for sigma in [0.02, 0.05, 0.1] {
        for (way, seeds) in [(MIXTURE, &seeds[..]), (Way::Paper, few), (Way::Direct, &seeds)] {
            let outcomes = simulated(context, sigma, way, seeds)?;
            simulation.push([row![sigma, way.name()], summary(&outcomes)].concat());
        }
    }
    let mut slices = Table::new("The search without a size prior, by slices", titled(&["slice"]));
    for (name, family) in slices_of(&SURFACE) {
        slices.push([row![name], summary(&outcomes(context, &family, MIXTURE, &seeds))].concat());
    }
    let mut bodies = Table::new("Bodies that are none: what is accepted", titled(&["body"]));
    for (name, family) in others() {
        bodies.push([row![name], summary(&outcomes(context, &family, MIXTURE, &seeds))].concat());
    }
    Ok(Report { findings, tables: vec![table, simulation, slices, bodies], figures: Vec::new() })
}

fn titled(keys: &[&'static str]) -> Vec<Column> {
    keys.iter().map(|&key| Column::new(key, key, 2)).chain(columns()).collect()
}

/// One outcome for each seed.
fn outcomes(context: &Context, family: &SurfaceFamily, way: Way, seeds: &[u64]) -> Vec<Outcome> {
    context.each(seeds, |&seed| {
        let cloud = family.cloud(seed);
        way.answer(&View::from(cloud.points.as_slice()), &cloud.truth, seed)
    })
}

fn simulated(context: &Context, sigma: f64, way: Way, seeds: &[u64]) -> Result<Vec<Outcome>, InputError> {
    let outcomes = context.each(seeds, |&seed| {
        let options = SimulationOptions { seed, point_count: 2000, sigma, ..SimulationOptions::default() };
        let cloud = simulate(&options)?;
        Ok(way.answer(&View::from(cloud.points.as_slice()), &cloud.truth, seed))
    });
    outcomes.into_iter().collect()
}

/// One thing fixed, the rest varied.
fn slices_of(family: &SurfaceFamily) -> Vec<(String, SurfaceFamily)> {
    let mut slices = Vec::new();
    for share in [0.0, 0.2, 0.4, 0.6, 0.7] {
        slices.push((format!("outliers {share}"), SurfaceFamily { outliers: (share, share), ..*family }));
    }
    for noise in [0.0, 0.01, 0.05, 0.1] {
        slices.push((format!("noise {noise}"), SurfaceFamily { noise: (noise, noise), ..*family }));
    }
    for aspect in [1.0, 2.0, 5.0, 10.0] {
        slices.push((format!("aspect {aspect}"), SurfaceFamily { aspect: (aspect, aspect), ..*family }));
    }
    for part in [0.9, 0.8, 0.7, 0.6, 0.5] {
        slices.push((format!("coverage {part}"), SurfaceFamily { coverage: (part, part), ..*family }));
    }
    for point_count in [100, 300, 6000] {
        slices.push((format!("{point_count} points"), SurfaceFamily { point_count, ..*family }));
    }
    slices.push(("dense at the tips".into(), SurfaceFamily { body: Body::EllipsoidByDirection, ..*family }));
    slices
}

fn others() -> Vec<(&'static str, SurfaceFamily)> {
    let base = SurfaceFamily { outliers: (0.0, 0.3), aspect: (1.0, 4.0), ..SURFACE };
    let half = SurfaceFamily { coverage: (0.5, 0.5), ..base };
    let body = |body| SurfaceFamily { body, ..base };
    vec![
        ("half an ellipsoid", half),
        ("plane", body(Body::Plane)),
        ("pipe", body(Body::Pipe)),
        ("cylinder", body(Body::Cylinder)),
        ("box", body(Body::Box)),
        ("clutter", body(Body::Clutter)),
    ]
}
