//! Rendered Kinect v2 frames of jujubes in a tree, with truth: the scenes of section III.B.
//!
//! A seed stands for a scene and for its conditions: distance, light and leaves before the fruit take turns, so that
//! eighteen seeds in a row hold each combination once.

use crate::{
    frame::{Frame, Geometry},
    synth::{Daylight, KinectRig, Scene, SceneOptions, TrueFruit, render_kinect},
};

/// Nearest and farthest fruit of a scene, millimetres.
pub(super) const DISTANCES_MM: [(f64, f64); 3] = [(500.0, 750.0), (750.0, 1000.0), (1000.0, 1500.0)];
/// Light, with its name in tables.
pub(super) const LIGHTS: [(&str, Daylight); 3] =
    [("sun", Daylight::Sun), ("overcast", Daylight::Overcast), ("evening", Daylight::Evening)];
/// Leaves hung before fruit.
pub(super) const LEAVES: [usize; 2] = [2, 10];
/// Fruit of a scene.
const FRUIT: usize = 12;

/// A rendered frame.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    /// Index in [`DISTANCES_MM`].
    pub(super) distance: usize,
    /// Index in [`LIGHTS`].
    pub(super) light: usize,
    /// Index in [`LEAVES`].
    pub(super) leaves: usize,
    /// Colour and raw depth.
    pub(super) frame: Frame,
    /// Every fruit, hidden ones too.
    pub(super) fruit: Vec<TrueFruit>,
}

/// Renders the scene of a seed. A second or so.
pub(super) fn tree(seed: u64) -> Tree {
    let turn = (seed % 18) as usize;
    let (distance, light, leaves) = (turn % 3, turn / 3 % 3, turn / 9);
    let scene = Scene::new(&SceneOptions {
        seed,
        fruit_count: FRUIT,
        distance_mm: DISTANCES_MM[distance],
        occluding_leaf_count: LEAVES[leaves],
        daylight: LIGHTS[light].1,
        ..SceneOptions::default()
    });
    let rendered = render_kinect(&scene, &KinectRig::default());
    let frame = Frame {
        name: format!("tree-{seed}"),
        colour: rendered.colour,
        depth_mm: rendered.raw_depth,
        geometry: Geometry::Factory(Box::new(rendered.calibration)),
        mask: None,
        instances: Some(rendered.instances),
    };
    Tree { distance, light, leaves, frame, fruit: rendered.fruits }
}

#[cfg(test)]
mod tests {
    #[test]
    fn eighteen_seeds_are_all_conditions() {
        let mut seen: Vec<[u64; 3]> = (0..18_u64).map(|turn| [turn % 3, turn / 3 % 3, turn / 9]).collect();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), 18);
    }
}
