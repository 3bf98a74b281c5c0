//! The Kinect v2: colour camera 1920x1080, depth camera 512x424.
pub mod calibration;
