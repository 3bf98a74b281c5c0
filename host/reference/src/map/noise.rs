//! The noise that the residuals show: contract, chapter M14.

use super::contact::{Contact, Sight};
use super::evidence::Evidence;
use super::model::{Estimate, Model};
use super::prior::Terms;
use super::view::{Noise, Viewpoint};
use crate::fault::{self, Fault};

/// M14: what the members and the rays of an estimate show.
#[derive(Clone, Copy)]
pub(crate) struct Estimated {
    pub(crate) noise: Noise,
    /// Factor on the deviations of outline rays.
    pub(crate) wider: f32,
}

impl Estimated {
    /// The terms with it.
    pub(crate) fn entered(self, terms: Terms) -> Terms {
        Terms { noise: self.noise, wider: self.wider, ..terms }
    }
}

/// M14: the noise at an estimate, in multiples of the assumed one.
pub(crate) fn estimated(estimate: &Estimate, evidence: Evidence, assumed: &Terms) -> Estimated {
    let model = Model::new(estimate, assumed.noise, assumed.viewpoint);
    let mut axial = Histogram::new();
    let mut lateral = Histogram::new();
    for &member in evidence.members {
        if !evidence.open(member) {
            continue;
        }
        let contact = Contact::new(&model, evidence.point(member));
        if let Sight::Explained(f2) = contact.sight(assumed.window) {
            let share = lateral_share(&model, &contact);
            if share < 0.4 {
                axial.count(f2);
            } else if share > 0.6 {
                lateral.count(f2);
            }
        }
    }
    let mut outline = Histogram::new();
    for touch in evidence.touching(&model, assumed) {
        let f2 = touch.f2(estimate.boxiness);
        if f2 < 6.25 {
            outline.count(f2);
        }
    }
    let noise = Noise {
        axial: assumed.noise.axial * axial.scale(),
        lateral: assumed.noise.lateral * lateral.scale(),
    };
    Estimated { noise, wider: outline.scale() }
}

/// M14: how much of the variance is not along the ray.
fn lateral_share(model: &Model, contact: &Contact) -> f32 {
    if model.viewpoint == Viewpoint::None {
        return 0.0;
    }
    let slope = if contact.miss < 1.0 { contact.value / (contact.gap_mm / model.range) } else { 0.0 };
    1.0 - (model.axial * (slope * slope)) / contact.variance
}

/// 64 bins of `sqrt(f2)` up to 2.5.
struct Histogram([u32; 64]);

impl Histogram {
    fn new() -> Self {
        Self([0; 64])
    }

    fn count(&mut self, f2: f32) {
        let bin = (libm::sqrtf(f2) * 25.6) as usize;
        if bin < 64 {
            self.0[bin] += 1;
        }
    }

    /// M14: from the median, pulled towards 1 and limited.
    fn scale(&self) -> f32 {
        let mut total = 0;
        for count in self.0 {
            total += count;
        }
        let total = total as f32;
        let scale = (total * (self.median(0.5 * total) / 0.664) + 6.0) / (total + 6.0);
        scale.clamp(0.2, 2.0)
    }

    /// M14: where `half` of the counts lie below.
    fn median(&self, half: f32) -> f32 {
        let mut below = 0.0;
        for j in 0..64 {
            let h = self.0[j] as f32;
            let next = below + h;
            if next >= half && h > 0.0 {
                let inside = if fault::is(Fault::Noise) { 0.5 } else { (half - below) / h };
                return (j as f32 + inside) / 25.6;
            }
            below = next;
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_count_the_noise_is_as_assumed() {
        assert_eq!(Histogram::new().scale(), 1.0);
    }

    #[test]
    fn the_median_lies_within_its_bin() {
        let mut histogram = Histogram::new();
        for f2 in [0.0, 0.0, 1.0, 1.0] {
            histogram.count(f2);
        }
        // Half of the counts lie in bin 0.
        assert_eq!(histogram.median(2.0), 1.0 / 25.6);
        assert_eq!(histogram.median(3.0), 25.5 / 25.6);
        histogram.count(6.25);
        assert_eq!(histogram.0.iter().sum::<u32>(), 4, "the product 64 counts in no bin");
    }
}
