//! Fig. 10: the points of the segmented fruit, and what RANSAC and VARSAC+TEBC make of them, one colour a fruit; for a
//! rendered frame and for one that is given with `--frame`.

use nalgebra::Point3;

use super::{
    Context, Experiment, Report,
    figure::Figure,
    frames::{Shown, frames, halved},
    table::{Column, Table, row},
};
use crate::{
    backproject::PointOptions,
    draw::{View, Viewpoint, draw_cloud, draw_overlays},
    error::InputError,
    locate::{Camera, Located, MAX_CAPACITY, Method, Options, REGION_CAPACITY, RegionSource, locate_frame},
    picture::overlays,
    segment::preset,
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "fig10",
    purpose: "The search in stages: points, RANSAC, VARSAC+TEBC, result over the picture; rendered, and of a given frame.",
    run,
};

const METHODS: [(&str, Method, &str); 2] =
    [("b", Method::Ransac, "RANSAC, distance and normal"), ("c", Method::Varsac, "VARSAC+TEBC")];

fn run(context: &Context) -> Result<Report, InputError> {
    let mut table = Table::new(
        "Targets and the points they claim",
        vec![
            Column::new("frame", "frame", 0),
            Column::new("method", "method", 0),
            Column::new("points", "points", 0),
            Column::new("targets", "targets", 0),
            Column::new("claimed", "claimed", 0),
            Column::new("score_percent", "mean score %", 1),
        ],
    );
    let mut figures = Vec::new();
    for Shown { prefix, frame, fruit } in frames(context)? {
        for (letter, method, name) in METHODS {
            let mut config = fruit.config();
            if method == Method::Ransac {
                // The least share of inliers goes with the shell's thickness; few of a noisy fruit's normals agree.
                config.min_ratio = 0.0;
            }
            let options = Options {
                method,
                config,
                regions: RegionSource::Colour(preset(fruit.name())),
                points: PointOptions::default(),
                seed: context.seed,
                region_capacity: REGION_CAPACITY,
                cloud_capacity: MAX_CAPACITY,
            };
            let located = locate_frame(prefix, &frame, &options)?;
            let claimed = located.labels.iter().filter(|&&label| label != 0).count();
            let scores = located.targets.iter().map(|target| f64::from(target.score.ratio()));
            let mean = (!located.targets.is_empty())
                .then(|| 100.0 * scores.sum::<f64>() / located.targets.len() as f64);
            table.push(row![prefix, name, located.points.len(), located.targets.len(), claimed, mean]);
            if figures.len() % 4 == 0 {
                let caption = format!("{prefix}: the points of the regions");
                figures.push(Figure::picture(format!("{prefix}-a"), caption, halved(cloud_alone(&located))));
            }
            let caption = format!("{prefix}: {name}, {} targets, {claimed} points", located.targets.len());
            let picture = draw_cloud(&points(&located), &located.labels, &overlays(&located), &[name]);
            figures.push(Figure::picture(format!("{prefix}-{letter}"), caption, halved(picture)));
            if method == Method::Varsac {
                let camera = Camera::of(&frame)?;
                let pixels = camera.view(&frame);
                let project = |point: [f64; 3]| pixels.project(&Point3::from(point));
                let viewpoint = Viewpoint::Point(camera.colour_centre_mm());
                let view = View { viewpoint, project: &project };
                let picture = draw_overlays(&frame.colour, &overlays(&located), &view, &[name]);
                let caption = format!("{prefix}: the result over the colour image");
                figures.push(Figure::picture(format!("{prefix}-d"), caption, halved(picture)));
            }
        }
    }
    Ok(Report { tables: vec![table], figures, ..Report::default() })
}

fn points(located: &Located) -> Vec<[f32; 3]> {
    located.points.iter().map(|p| [p.x, p.y, p.z]).collect()
}

fn cloud_alone(located: &Located) -> crate::image::ColourImage {
    draw_cloud(&points(located), &vec![0; located.points.len()], &[], &[])
}
