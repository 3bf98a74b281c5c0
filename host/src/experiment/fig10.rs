//! Fig. 10: the points of the segmented fruit, and what RANSAC, VARSAC+TEBC and the default search make of them, one colour
//! a fruit; for a rendered frame and for one that is given with `--frame`.

use nalgebra::Point3;

use super::{
    Context, Experiment, Report,
    figure::Figure,
    frames::{Shown, frames, halved},
    table::{Column, Table, row},
};
use crate::{
    draw::{Overlay, View, Viewpoint, draw_cloud, draw_overlays},
    error::InputError,
    eval::{EllipsoidF64, norm, statistics::mean_and_deviation, subtract},
    frame::Frame,
    fruit::Fruit,
    image::ColourImage,
    locate::{Camera, Located, Method, Options, RegionSource, locate_frame},
    picture::overlays,
    segment::preset,
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "fig10",
    purpose: "The search in stages: points, RANSAC, VARSAC+TEBC, default, results over the picture; rendered, and of a given frame.",
    run,
};

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
        let ransac = located(prefix, &frame, fruit, Method::Ransac, context.seed)?;
        let varsac = located(prefix, &frame, fruit, Method::Varsac, context.seed)?;
        let default = located(prefix, &frame, fruit, Method::Map, context.seed)?;
        let all = [
            ("b", "RANSAC, distance and normal", &ransac),
            ("c", "VARSAC+TEBC", &varsac),
            ("d", "default search", &default),
        ];
        let focus = Focus::on(&varsac, f64::from(fruit.config().semi_axis_max));
        let alone = draw_cloud(&focus.points(&varsac).0, &[], &[], &[]);
        figures.push(Figure::picture(
            format!("{prefix}-a"),
            format!("{prefix}: points around a fruit"),
            halved(alone),
        ));
        for (letter, name, located) in all {
            let claimed = located.labels.iter().filter(|&&label| label != 0).count();
            let scores: Vec<f64> =
                located.targets.iter().map(|t| 100.0 * f64::from(t.score.ratio())).collect();
            let mean = mean_and_deviation(&scores).map(|(mean, _)| mean);
            table.push(row![prefix, name, located.points.len(), located.targets.len(), claimed, mean]);
            let (points, labels) = focus.points(located);
            let picture = draw_cloud(&points, &labels, &focus.overlays(located), &[name]);
            figures.push(Figure::picture(
                format!("{prefix}-{letter}"),
                format!("{prefix}: {name}"),
                halved(picture),
            ));
        }
        for (letter, name, located) in [("e", "VARSAC+TEBC", &varsac), ("f", "default search", &default)] {
            let refused = located.targets.iter().filter(|target| target.refusal.is_some()).count();
            let accepted = located.targets.len() - refused;
            let caption = format!("{prefix}: {name}, {accepted} targets accepted, {refused} refused");
            let picture = halved(over_picture(&frame, located)?);
            figures.push(Figure::picture(format!("{prefix}-{letter}"), caption, picture));
        }
    }
    Ok(Report { tables: vec![table], figures, ..Report::default() })
}

fn located(
    name: &str,
    frame: &Frame,
    fruit: Fruit,
    method: Method,
    seed: u64,
) -> Result<Located, InputError> {
    let mut config = fruit.config();
    if method != Method::Map {
        config = config.paper();
    }
    if method == Method::Ransac {
        // The least share of inliers goes with the shell's thickness; few of a noisy fruit's normals agree.
        config.min_ratio = 0.0;
    }
    let colour = RegionSource::Colour(preset(fruit.name()));
    let options = Options { method, ..Options::new(config, colour, seed) };
    locate_frame(name, frame, &options)
}

/// The part of the space that is shown of a cloud: a whole frame is mostly empty.
struct Focus {
    centre: [f64; 3],
    reach_mm: f64,
}

impl Focus {
    /// Around the target with the most points, three times as far as a fruit may reach; everything where there is none.
    fn on(located: &Located, semi_axis_max_mm: f64) -> Self {
        let best = located.targets.iter().max_by_key(|target| target.score.inliers);
        match best.map(|target| EllipsoidF64::from(&target.ellipsoid).centre_mm) {
            Some(centre) => Self { centre, reach_mm: 3.0 * semi_axis_max_mm },
            None => Self { centre: [0.0; 3], reach_mm: f64::INFINITY },
        }
    }

    fn holds(&self, point: [f64; 3]) -> bool {
        norm(subtract(point, self.centre)) <= self.reach_mm
    }

    /// The points that are shown, and their labels.
    fn points(&self, located: &Located) -> (Vec<[f32; 3]>, Vec<u32>) {
        let all = located.points.iter().map(|p| [p.x, p.y, p.z]).zip(located.labels.iter().copied());
        all.filter(|(point, _)| self.holds(point.map(f64::from))).unzip()
    }

    fn overlays(&self, located: &Located) -> Vec<Overlay> {
        let all = overlays(located).into_iter();
        all.filter(|overlay| self.holds(overlay.ellipsoid.centre_mm)).collect()
    }
}

fn over_picture(frame: &Frame, located: &Located) -> Result<ColourImage, InputError> {
    let camera = Camera::of(frame)?;
    let pixels = camera.view(frame);
    let project = |point: [f64; 3]| pixels.project(&Point3::from(point));
    let view = View { viewpoint: Viewpoint::Point(camera.colour_centre_mm()), project: &project };
    Ok(draw_overlays(&frame.colour, &overlays(located), &view, &[located.method.name()]))
}
