//! What the scenes of a family are like: points, outliers, cover, outline rays. Without this a figure says little.

use nalgebra::Point3;

use super::Case;
use crate::{
    eval::statistics::quantile,
    experiment::{
        Context,
        table::{Column, Table, row},
    },
    synth::onesided::Scene,
};

/// One scene in numbers.
struct Likeness {
    points: f64,
    /// Share of the points that are further from the subject's surface than a quarter of its size.
    outliers: f64,
    covered: f64,
    rays: f64,
}

impl Likeness {
    fn of(case: &Case, seed: u64) -> Option<Self> {
        let scene = Scene::new(&case.family, seed);
        let sighting = scene.sighting(case.bias);
        let subject = scene.fruit.first()?;
        let level =
            |p: &varsac_core::Point3| subject.ellipsoid.level(&Point3::from([p.x, p.y, p.z].map(f64::from)));
        let own = sighting.cloud.iter().filter(|point| (level(point) - 1.0).abs() < 0.25).count();
        Some(Self {
            points: sighting.cloud.len() as f64,
            outliers: 1.0 - own as f64 / sighting.cloud.len().max(1) as f64,
            covered: 1.0 - subject.visible,
            rays: sighting.outline.len() as f64,
        })
    }
}

/// Medians and means over the scenes of each case.
pub(super) fn table(context: &Context, cases: &[Case], seeds: &[u64]) -> Table {
    let columns = vec![
        Column::new("case", "scenes", 0),
        Column::new("points", "points, median", 0),
        Column::new("outlier_percent", "outliers %, mean", 0),
        Column::new("covered_percent", "covered %, mean", 0),
        Column::new("rays", "outline rays, median", 0),
    ];
    let mut table = Table::new("What the scenes are like", columns);
    for case in cases {
        let all: Vec<Likeness> =
            context.each(seeds, |&seed| Likeness::of(case, seed)).into_iter().flatten().collect();
        let median = |of: fn(&Likeness) -> f64| {
            let mut ascending: Vec<f64> = all.iter().map(of).collect();
            ascending.sort_by(f64::total_cmp);
            quantile(&ascending, 0.5)
        };
        let percent = |of: fn(&Likeness) -> f64| 100.0 * all.iter().map(of).sum::<f64>() / all.len() as f64;
        table.push(row![
            case.name,
            median(|l| l.points),
            percent(|l| l.outliers),
            percent(|l| l.covered),
            median(|l| l.rays)
        ]);
    }
    table
}
