//! Synthetic data with known truth: the paper's simulation, and rendered Kinect v2 frames of fruit on a branch.
//!
//! ```text
//! SimulationOptions -> simulation -> points + truth
//! SceneOptions -> scene (fruit, branches, leaves) -> render: the colour camera sees shade's colours,
//!                                                    the depth camera sees sensor's measurements -> frame + truth
//! ```
//!
//! The same seed gives the same bits on every machine. Unit: millimetres; frame: depth camera, x right, y down,
//! z forward.

mod foliage;
pub mod fruit;
mod leaves;
pub mod noise;
pub mod onesided;
pub mod render;
pub mod scene;
mod sensor;
mod shade;
mod shape;
mod sight;
pub mod simulation;
pub mod surface;
mod tiles;

pub use fruit::FruitKind;
pub use render::{KinectFrame, KinectRig, RegisteredFrame, TrueFruit, render_depth_patch, render_kinect};
pub use scene::{Daylight, Scene, SceneOptions};
pub use sensor::SensorOptions;
pub use simulation::{Simulation, SimulationOptions, simulate};
