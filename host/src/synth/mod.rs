//! Seeded synthetic inputs with known truth.

pub mod onesided;
pub mod patch;
pub mod shapes;
