//! Seeded families of one-sided views: one fruit (and perhaps others) as a depth camera sees it, with the truth.
//!
//! This is the light generator for tens of thousands of scenes: it renders only the pixels around the fruit, by
//! analytic rays. Everything is drawn from one seed; unit millimetres, camera optical frame.
//!
//! ```text
//! Family (families) -> Subject (subject) -> bodies, none through another (placement, shapes)
//!                   -> record: depth with noise, mixed pixels, holes (patch) -> colour mask with errors (mask)
//!                   -> Scene, Truth, Sighting: what a search is given (scene)
//! ```

mod draws;
pub mod families;
mod mask;
pub mod patch;
mod placement;
mod scene;
pub mod shapes;
mod subject;

pub use families::Family;
pub use mask::MaskBias;
pub use scene::{Scene, Sighting, Truth};
pub use subject::{JUJUBE, Subject, VARIED_JUJUBE, boxy_jujube, scaled_jujube};
