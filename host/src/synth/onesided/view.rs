//! What the core gets to see of a scene: the points of a mask and around it, outline rays, the angle between pixels.

use super::{Scene, patch::Window};
use crate::{image::LabelImage, outline::outline_rays, region_view::RegionView};

/// Depth that separates two surfaces at an outline, mm: about the shortest semi-axis of a jujube.
const OUTLINE_STEP_MM: f32 = 10.0;

impl Scene {
    /// The view of the region `mask` grown by the margin of the scene.
    pub fn view(&self, mask: &LabelImage) -> RegionView {
        let (points, in_mask) = self.cloud(mask);
        let Window { left, top, .. } = self.patch.window;
        let focal_px = self.sensor.focal_px;
        let outline = outline_rays(
            &self.patch.depth,
            (0..=mask.width as i64, 0..=mask.height as i64),
            |u, v| mask.get(u, v).is_some_and(|label| label > 0),
            focal_px,
            |u, v| [(left as f64 + u) / focal_px, (top as f64 + v) / focal_px],
            OUTLINE_STEP_MM,
        );
        RegionView {
            points: points.into_iter().map(Into::into).collect(),
            in_mask,
            outline,
            pitch_rad: (1.0 / focal_px) as f32,
        }
    }
}
