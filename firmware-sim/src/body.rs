//! Complete surfaces made from a number, the same on every machine: bodies of any size amid clutter, as a scanner sees them from
//! all around. For proofs of the search without a size prior on boards without a link, as [`crate::scene`].

use varsac_core::mixture::MixtureConfig;
use varsac_core::rng::Stream;
use varsac_core::{Config, Detector, Point3, View, Workspace};

use crate::scene::{Digested, direction, uniform};
use crate::view::{Canvas, VIEW_POINTS};

/// Points of [`one_body`].
pub const BODY_POINTS: usize = 400;
/// Points of a scene; a third of them clutter.
const SCENE_POINTS: usize = 180;
/// Deviation of the points across the surface over the smallest semi-axis.
const NOISE: f32 = 0.02;

/// Fills `cloud` with scene `number`: an ellipsoid, but each fourth time a box. Two thirds of the points lie all over its surface, the others in a
/// cube about it.
pub fn scene(number: u64, cloud: &mut [Point3]) {
    let mut stream = Stream::new(number);
    let semi_axes = [(); 3].map(|()| 10.0 + 20.0 * uniform(&mut stream));
    let centre = [(); 3].map(|()| 400.0 * uniform(&mut stream) - 200.0);
    let box_shaped = number % 4 == 2;
    fill(cloud, centre, semi_axes, box_shaped, &mut stream);
}

/// An ellipsoid with semi-axes of 30, 20 and 15.
pub fn one_body(cloud: &mut [Point3]) {
    fill(cloud, [5.0, -3.0, 40.0], [30.0, 20.0, 15.0], false, &mut Stream::new(7));
}

fn fill(cloud: &mut [Point3], centre: [f32; 3], semi_axes: [f32; 3], box_shaped: bool, stream: &mut Stream) {
    let on_surface = cloud.len() * 2 / 3;
    for (k, slot) in cloud.iter_mut().enumerate() {
        let [x, y, z] = if k >= on_surface {
            [(); 3].map(|()| 100.0 * uniform(stream) - 50.0)
        } else {
            let u = direction(stream);
            let [a, b, c] = u.map(libm::fabsf);
            let radius = if box_shaped { 1.0 / a.max(b).max(c) } else { 1.0 };
            // Sum of four: close to a normal distribution.
            let sum = uniform(stream) + uniform(stream) + uniform(stream) + uniform(stream);
            let scale = radius * (1.0 + 1.73 * NOISE * (sum - 2.0));
            [u[0] * semi_axes[0] * scale, u[1] * semi_axes[1] * scale, u[2] * semi_axes[2] * scale]
        };
        // A turn by an angle of 3:4:5, so that the axes are none of the frame's.
        let [x, y] = [0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y];
        *slot = Point3::new(x + centre[0], y + centre[1], z + centre[2]);
    }
}

/// Searches are digested with few starts on few points: the boards are slow.
const QUICK: MixtureConfig = MixtureConfig { sample: 120, starts: 2, ..MixtureConfig::SURFACE };

/// Makes scene `number`, for odd numbers view `number` of [`crate::view`], searches it to the end without a size prior, and digests all
/// that was found.
pub fn search_digest(number: u64, canvas: &mut Canvas, workspace: &mut Workspace<VIEW_POINTS>) -> Digested {
    if number & 1 == 0 {
        let mut cloud = [Point3::new(0.0, 0.0, 0.0); SCENE_POINTS];
        scene(number, &mut cloud);
        let config = Config { max_targets: 2, mixture: QUICK, ..Config::surface() };
        digest(config, &View::from(&cloud[..]), workspace, number)
    } else {
        let mixture = MixtureConfig { sample: QUICK.sample, starts: QUICK.starts, ..MixtureConfig::VIEW };
        let config = Config { max_targets: 2, mixture, ..Config::unknown() };
        digest(config, &canvas.scene(number), workspace, number)
    }
}

fn digest(config: Config, view: &View<'_>, workspace: &mut Workspace<VIEW_POINTS>, seed: u64) -> Digested {
    let Ok(detector) = Detector::new(config) else { return Digested::default() };
    let Ok(run) = detector.detect_view(view, workspace.scratch(), seed) else { return Digested::default() };
    run.fold(Digested::default(), |before, detection| before.and(&detection))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_are_found_and_most_boxes_refused() {
        let mut canvas = Canvas::new();
        let mut workspace = Workspace::new();
        let mut accepted = |number| search_digest(number, &mut canvas, &mut workspace).accepted;
        for number in [0, 4, 8] {
            assert_eq!(accepted(number), 1, "{number}");
        }
        // 120 noisy points tell little of a shape: one box in three passes for a body here.
        let boxes: u32 = [2, 6, 10].map(&mut accepted).iter().sum();
        assert!(boxes <= 1, "{boxes} of 3 boxes accepted");
    }
}
