//! The data that is raced on. Everything comes from a seed; millimetres, depth camera frame.

use varsac_core::{Config, Ellipsoid, Method, Point3};

use crate::{
    eval::EllipsoidF64,
    frame::{Frame, Geometry},
    synth::{KinectRig, Scene, SceneOptions, noise::Noise, onesided, render_kinect},
};

/// The configuration of the paper's search for jujubes.
pub fn paper() -> Config {
    Config { method: Method::Varsac, ..Config::jujube() }
}

/// The configuration of the default search for jujubes.
pub fn default_search() -> Config {
    Config::jujube()
}

/// The jujube that the points of [`points`] are around.
pub fn jujube() -> Ellipsoid {
    let (sin, cos) = (0.6, 0.8);
    Ellipsoid {
        centre: Point3::new(3.0, -5.0, 702.0),
        semi_axes: [22.0, 11.5, 10.6],
        axes: [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]],
    }
}

/// Points around [`jujube`]: half on the side that faces the camera, with 1 mm of noise, half anywhere in a box about it.
pub fn points(count: usize, seed: u64) -> Vec<Point3> {
    around(&jujube(), count, &mut Noise::new(seed))
}

fn around(fruit: &Ellipsoid, count: usize, noise: &mut Noise) -> Vec<Point3> {
    let body = EllipsoidF64::from(fruit);
    let centre = body.centre_mm;
    (0..count)
        .map(|k| {
            let place = if k % 2 == 0 {
                let to = noise.direction();
                let on = body.from_body(std::array::from_fn(|i| body.semi_axes_mm[i] * to[i]));
                // Through the centre to the near side, where it came out on the far one.
                let near = on[2] <= centre[2];
                std::array::from_fn(|i| if near { on[i] } else { 2.0 * centre[i] - on[i] } + noise.normal())
            } else {
                centre.map(|c| c + noise.between(-30.0, 30.0))
            };
            Point3::new(place[0] as f32, place[1] as f32, place[2] as f32)
        })
        .collect()
}

/// A wall of fruit before the camera, 60 mm from one to the next, with so many points around each.
pub fn wall(fruit: usize, points_each: usize, seed: u64) -> Vec<Point3> {
    let mut noise = Noise::new(seed);
    let columns = (fruit as f64).sqrt().ceil().max(1.0) as usize;
    (0..fruit)
        .flat_map(|k| {
            let (column, row) = ((k % columns) as f32, (k / columns) as f32);
            let middle = 30.0 * (columns - 1) as f32;
            let centre = Point3::new(60.0 * column - middle, 60.0 * row - middle, 700.0);
            around(&Ellipsoid { centre, ..jujube() }, points_each, &mut noise)
        })
        .collect()
}

/// One-sided views of one jujube each, some with a neighbour, leaves and background: what a region of a frame is.
pub fn views(count: u64, seed: u64) -> Vec<Vec<Point3>> {
    let view = |k| {
        let scene = onesided::Scene::new(&onesided::families::HARD, seed.wrapping_add(k));
        let mut seen = scene.sighting(onesided::MaskBias::default());
        seen.cloud.truncate(seen.in_mask);
        seen.cloud
    };
    (0..count).map(view).collect()
}

/// A rendered Kinect v2 pair, 1920x1080 and 512x424, of so many jujubes in a tree.
pub fn frame(fruit_count: usize, seed: u64) -> Frame {
    let rendered = render_kinect(
        &Scene::new(&SceneOptions { seed, fruit_count, ..SceneOptions::default() }),
        &KinectRig::default(),
    );
    Frame {
        name: format!("tree-{seed}"),
        colour: rendered.colour,
        depth_mm: rendered.raw_depth,
        geometry: Geometry::Factory(Box::new(rendered.calibration)),
        mask: None,
        instances: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use varsac_core::{CentralQuadric, tebc::Shell};

    #[test]
    fn half_of_the_points_are_the_fruits_and_the_same_seed_gives_the_same() {
        let cloud = points(2000, 4);
        let surface = CentralQuadric::from(&EllipsoidF64::from(&jujube()));
        let inliers = Shell::new(&surface, 0.2).count(&cloud);
        assert!((800..1200).contains(&inliers), "{inliers}");
        assert_eq!(cloud, points(2000, 4));
        assert_ne!(cloud, points(2000, 5));
    }

    #[test]
    fn a_wall_has_a_fruit_at_each_place() {
        let cloud = wall(5, 100, 1);
        assert_eq!(cloud.len(), 500);
        let middle = |k: usize| cloud[100 * k..100 * (k + 1)].iter().map(|p| p.x).sum::<f32>() / 100.0;
        assert!((middle(1) - middle(0) - 60.0).abs() < 12.0 && (middle(3) - middle(0)).abs() < 12.0);
        assert!(views(2, 1).iter().all(|view| view.len() > 50));
    }
}
