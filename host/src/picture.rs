//! From what was located to the picture of it: which ellipsoid is drawn how, seen by which camera.

use std::path::Path;

use nalgebra::Point3;

use crate::{
    draw::{Overlay, Status, View, Viewpoint, draw_cloud, draw_overlays, write_png},
    error::InputError,
    eval::EllipsoidF64,
    frame::Frame,
    locate::{Camera, Located},
};

/// Draws the targets of a frame over its colour image and writes the picture, whole or not at all.
///
/// # Errors
/// When the file cannot be written.
pub fn of_frame(frame: &Frame, camera: &Camera, located: &Located, path: &Path) -> Result<(), InputError> {
    let pixels = camera.view(frame);
    let project = |point: [f64; 3]| pixels.project(&Point3::from(point));
    // Points are in the depth camera's frame; the colour camera of a Kinect pair sees them from 52 mm beside it.
    let viewpoint = Viewpoint::Point(camera.colour_centre_mm());
    let view = View { viewpoint, project: &project };
    let captions = captions(located);
    let captions: Vec<&str> = captions.iter().map(String::as_str).collect();
    write_png(path, &draw_overlays(&frame.colour, &overlays(located), &view, &captions))
}

/// Draws a cloud from three sides, its points coloured by target, and writes the picture, whole or not at all.
///
/// # Errors
/// When the file cannot be written.
pub fn of_cloud(located: &Located, path: &Path) -> Result<(), InputError> {
    let points: Vec<[f32; 3]> = located.points.iter().map(|p| [p.x, p.y, p.z]).collect();
    let captions = captions(located);
    let captions: Vec<&str> = captions.iter().map(String::as_str).collect();
    write_png(path, &draw_cloud(&points, &located.labels, &overlays(located), &captions))
}

/// How each target is drawn.
pub(crate) fn overlays(located: &Located) -> Vec<Overlay> {
    let overlay = |(k, target): (usize, &crate::locate::Target)| Overlay {
        number: k as u32 + 1,
        ellipsoid: EllipsoidF64::from(&target.ellipsoid),
        status: match &target.refusal {
            None => {
                Status::Found(format!("{:.0} % of {}", 100.0 * target.score.ratio(), target.score.candidates))
            }
            Some(refusal) => Status::Refused(refusal.brief()),
        },
        centre_covariance_mm2: target.covariance.map(|c| {
            let rows = c.rows();
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| f64::from(rows[i][j])))
        }),
    };
    located.targets.iter().enumerate().map(overlay).collect()
}

fn captions(located: &Located) -> Vec<String> {
    vec![
        located.name.clone(),
        format!("method {}", located.method.name()),
        format!("seed {}", located.seed),
        format!("{} points", located.points.len()),
        format!("{:.0} ms", located.elapsed.as_secs_f64() * 1e3),
    ]
}
