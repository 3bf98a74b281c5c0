//! Fig. 7: the simulated cloud, the two auxiliary ellipsoids of TEBC, the inliers, and the final ellipsoid.

use super::{
    Context, Experiment, Report,
    figure::Figure,
    methods::VARSAC,
    simulated::{WHOLE, cloud, search},
    table::{Column, Table, row},
};
use crate::{
    draw::{Overlay, Status, draw_cloud},
    error::InputError,
    eval::EllipsoidF64,
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "fig7",
    purpose: "The simulation in stages: cloud, auxiliary ellipsoids, inliers, result.",
    run,
};

const SIGMA: f64 = 0.1;

fn run(context: &Context) -> Result<Report, InputError> {
    let simulation = cloud(context.seed, SIGMA);
    let config = WHOLE.config();
    let found = search(&VARSAC, &simulation, &config, context.seed).ok_or_else(|| {
        InputError::at(
            "fig7",
            format!("the search of seed {} finds nothing", context.seed),
            "choose another --seed",
        )
    })?;
    let points: Vec<[f32; 3]> = simulation.points.iter().map(|p| [p.x, p.y, p.z]).collect();
    let mut labels = vec![0; points.len()];
    for &index in &found.inliers {
        labels[index as usize] = 1;
    }
    let inliers: Vec<[f32; 3]> = found.inliers.iter().map(|&index| points[index as usize]).collect();
    let d = f64::from(config.shell);
    let [small, large] = [1.0 - d, 1.0 + d].map(|s| EllipsoidF64 {
        semi_axes_mm: found.ellipsoid.semi_axes_mm.map(|length| s * length),
        ..found.ellipsoid
    });
    let overlay = |number, ellipsoid, words: &str| Overlay {
        number,
        ellipsoid,
        status: Status::Found(words.to_owned()),
        centre_covariance_mm2: None,
    };
    let nothing = vec![0; points.len()];
    let pictures = [
        (
            "a",
            "The cloud: 700 points of the ellipsoid with errors, 300 random ones.",
            draw_cloud(&points, &nothing, &[], &[]),
        ),
        (
            "b",
            "The two auxiliary ellipsoids; the points between them are counted.",
            draw_cloud(&points, &labels, &[overlay(1, small, "1 - d"), overlay(2, large, "1 + d")], &[]),
        ),
        ("c", "The inliers of the best model.", draw_cloud(&inliers, &vec![1; inliers.len()], &[], &[])),
        (
            "d",
            "The result among all points.",
            draw_cloud(&points, &labels, &[overlay(1, found.ellipsoid, "result")], &[]),
        ),
    ];
    let figures = pictures
        .into_iter()
        .map(|(name, caption, picture)| Figure::picture(name, caption, picture))
        .collect();

    let mut table = Table::new(
        "Points in each stage",
        vec![
            Column::new("stage", "stage", 0),
            Column::new("surface", "on the surface", 0),
            Column::new("random", "random", 0),
        ],
    );
    let count = |of: &dyn Fn(usize) -> bool| {
        let on = simulation.on_surface.iter().enumerate().filter(|(k, on)| **on && of(*k)).count();
        let all = (0..points.len()).filter(|&k| of(k)).count();
        (on, all - on)
    };
    for (stage, (surface, random)) in [("cloud", count(&|_| true)), ("inliers", count(&|k| labels[k] == 1))] {
        table.push(row![stage, surface, random]);
    }
    Ok(Report { tables: vec![table], figures, ..Report::default() })
}
