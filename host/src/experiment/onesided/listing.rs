//! Accepted detections that should not have been, one by one: seed, body, findings. Where to look when a gate is changed.

use super::{Case, Method, Outcome, measure::Judged};
use crate::{
    experiment::table::{Cell, Column, Table, row},
    synth::onesided::{Scene, patch::Body, shapes::Shape},
};

/// Rows of one case and method at most.
const ROWS: usize = 12;

/// An empty list.
pub(super) fn table(title: &str) -> Table {
    let columns = vec![
        Column::new("case", "scenes", 0),
        Column::new("method", "method", 0),
        Column::new("seed", "seed", 0),
        Column::new("distance_mm", "distance mm", 0),
        Column::new("size_mm", "longest semi-axis or radius mm", 1),
        Column::new("visible_percent", "visible %", 0),
        Column::new("error_mm", "error mm", 1),
        Column::new("explained", "explained points", 0),
        Column::new("size_conflict", "size conflict", 1),
        Column::new("size_sigma", "size sigma", 3),
        Column::new("rival", "rival", 2),
        Column::new("outline_rays", "rays", 0),
        Column::new("outline", "outline", 2),
        Column::new("predicted_share", "explained / predicted", 2),
        Column::new("sigma_mm", "sigma mm", 2),
        Column::new("flat", "flat", 2),
        Column::new("clutter", "clutter", 2),
    ];
    Table::new(title, columns)
}

/// Adds the detections of these outcomes that are accepted and wrong, the first [`ROWS`] of them.
pub(super) fn list(table: &mut Table, case: &Case, method: Method, outcomes: &[Outcome]) {
    let all =
        outcomes.iter().flat_map(|outcome| outcome.detections.iter().map(move |judged| (outcome, judged)));
    for (outcome, judged) in all.filter(|(_, judged)| judged.is_wrong()).take(ROWS) {
        if let Some(cells) = cells(case, method, outcome, judged) {
            table.push(cells);
        }
    }
}

fn cells(case: &Case, method: Method, outcome: &Outcome, judged: &Judged) -> Option<Vec<Cell>> {
    let findings = judged.findings?;
    // Bodies are not kept; the seed is the scene.
    let subject = *Scene::new(&case.family, outcome.seed).bodies.first()?;
    let wide = |value: f32| f64::from(value);
    let visible = (outcome.distance_mm > 0.0).then_some(100.0 * outcome.visible);
    Some(row![
        case.name,
        method.name(),
        outcome.seed,
        subject.pose.centre.iter().map(|x| x * x).sum::<f64>().sqrt(),
        size_mm(&subject),
        visible,
        judged.error_mm,
        u64::from(findings.explained),
        wide(findings.size_conflict),
        wide(findings.size_sigma),
        wide(findings.rival),
        u64::from(findings.outline_rays),
        wide(findings.outline),
        wide(findings.visible),
        wide(findings.sigma_mm),
        wide(findings.flat),
        wide(findings.clutter),
    ])
}

fn size_mm(body: &Body) -> f64 {
    match body.shape {
        Shape::Superellipsoid { semi_axes, .. } => semi_axes.into_iter().fold(0.0, f64::max),
        Shape::Disc { radii: [long, _] } => long,
        Shape::Cylinder { radius, .. } => radius,
        Shape::Plane => f64::INFINITY,
    }
}
