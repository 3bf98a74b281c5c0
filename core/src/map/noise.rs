//! The noise that the residuals of a fit show, along the rays, across them and at the outline.

use crate::{
    point::at,
    refine::{Estimate, Evidence, Terms},
    residual::{Noise, RayModel},
    visibility::{CUT, Sight, sight},
};

const BINS: usize = 64;
/// Bins per standard deviation: 64 over 2.5.
const BINS_PER_SIGMA: f32 = 25.6;
/// Median of |f| of a standard normal variable cut at 2.5.
const MEDIAN_SIGMA: f32 = 0.664;
/// Range of the scale: no camera is five times better than it says, and at twice the noise of the presets little shape is left.
const SCALE: (f32, f32) = (0.2, 2.0);
/// Weight of the assumption, in points.
const ASSUMED: f32 = 6.0;

/// |f| of explained points, counted in bins.
struct Scatter {
    bins: [u16; BINS],
    count: u16,
}

impl Scatter {
    const EMPTY: Self = Self { bins: [0; BINS], count: 0 };

    fn add(&mut self, square: f32) {
        if let Some(bin) = self.bins.get_mut((libm::sqrtf(square) * BINS_PER_SIGMA) as usize) {
            *bin += 1;
            self.count += 1;
        }
    }

    /// Ratio to the assumed noise: the median, linear within its bin, drawn towards 1 as if [`ASSUMED`] points had said so.
    fn scale(&self) -> f32 {
        let count = f32::from(self.count);
        let half = 0.5 * count;
        let mut below = 0.0;
        let mut median = 0.0;
        for (k, &bin) in self.bins.iter().enumerate() {
            let next = below + f32::from(bin);
            if next >= half && bin > 0 {
                median = (k as f32 + (half - below) / f32::from(bin)) / BINS_PER_SIGMA;
                break;
            }
            below = next;
        }
        let scale = (count * (median / MEDIAN_SIGMA) + ASSUMED) / (count + ASSUMED);
        if scale < SCALE.0 {
            SCALE.0
        } else if scale > SCALE.1 {
            SCALE.1
        } else {
            scale
        }
    }
}

/// The assumed terms with the noise that the residuals of a fit show: along the rays from points seen frontally, across
/// them from those near the rim, and of outline rays.
pub(crate) fn shown_noise(evidence: &Evidence<'_>, estimate: &Estimate, terms: &Terms) -> Terms {
    let ellipsoid = estimate.ellipsoid();
    let model = RayModel::new(&ellipsoid, &terms.noise, terms.viewpoint);
    let (mut axial, mut lateral) = (Scatter::EMPTY, Scatter::EMPTY);
    for &index in evidence.members {
        if !evidence.is_open(index) {
            continue;
        }
        let contact = model.contact(&at(evidence.cloud, index));
        if let Sight::Explained(square) = sight(&contact, terms.window_mm) {
            let share = model.lateral_share(&contact);
            if share < 0.4 {
                axial.add(square);
            } else if share > 0.6 {
                lateral.add(square);
            }
        }
    }
    let mut outline = Scatter::EMPTY;
    for touch in evidence.touches(&model, &ellipsoid, terms) {
        let square = touch.square(estimate.boxiness);
        if square < CUT {
            outline.add(square);
        }
    }
    let Noise { axial_mm, lateral_rad } = terms.noise;
    let noise = Noise { axial_mm: axial_mm * axial.scale(), lateral_rad: lateral_rad * lateral.scale() };
    Terms { noise, outline: outline.scale(), ..*terms }
}
