//! The Kinect v2: two cameras about 52 mm apart whose images do not share a grid.
//!
//! ```text
//! raw depth 512x424 --undistort by lookup--> ideal depth grid --polynomials + parallax--> colour pixel 1920x1080
//! ```
//!
//! [`calibration`] holds the factory parameters, [`camera`] the geometry of each camera, [`registration`] the
//! precomputed mapping with its occlusion filter. Unit: millimetres; frame: depth camera, x right, y down, z forward.

pub mod calibration;
pub mod camera;
pub mod registration;

pub use calibration::FactoryCalibration;
pub use camera::{COLOUR_HEIGHT, COLOUR_WIDTH, ColourCamera, DEPTH_HEIGHT, DEPTH_WIDTH, DepthCamera};
pub use registration::{RegisteredDepth, Registration};
