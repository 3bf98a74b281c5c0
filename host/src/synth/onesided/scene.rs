//! One scene: bodies, the recorded patch, the mask, the truth; and what a search is given of it.

use varsac_core::{OutlineRay, Point3, SizePrior, View};

use super::{
    draws::Draws,
    families::Family,
    mask::{MaskBias, colour_mask, grown},
    patch::{Body, FOCAL_PX, Patch, Sensor, Window, record},
    placement,
    shapes::{Pose, Shape, along, unit},
    subject::Subject,
};
use crate::{eval::EllipsoidF64, image::LabelImage, outline::outline_rays};

/// A true fruit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Truth {
    /// Centre, semi-axes and axes (of a super-ellipsoid: those of its equation).
    pub ellipsoid: EllipsoidF64,
    /// Visible share of the pixels it would show alone.
    pub visible: f64,
}

/// One scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// What the camera recorded.
    pub patch: Patch,
    /// The camera.
    pub sensor: Sensor,
    /// The bodies; `patch.owner` counts them from one.
    pub bodies: Vec<Body>,
    /// The fruit of the scene, the subject first; empty where the subject is a decoy.
    pub fruit: Vec<Truth>,
    /// Where a colour threshold would say fruit: 255, else 0.
    pub mask: LabelImage,
    /// The region grows the mask by so many pixels.
    pub margin_px: i64,
}

/// What a search is given of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// Points of the region: those in the mask or beside it first, then the rest of its margin; each row by row.
    pub cloud: Vec<Point3>,
    /// Number of the former.
    pub in_mask: usize,
    /// Outline rays.
    pub outline: Vec<OutlineRay>,
    /// Angle between neighbouring pixels, rad.
    pub pitch_rad: f32,
}

impl Sighting {
    /// The points alone, as a cloud that comes without an image; but from which camera is known.
    pub fn points_only(&self) -> View<'_> {
        View { pitch_rad: self.pitch_rad, ..View::from(self.cloud.as_slice()) }
    }

    /// All that the depth image and the mask tell.
    pub fn full(&self) -> View<'_> {
        View { cloud: &self.cloud, in_mask: self.in_mask, outline: &self.outline, pitch_rad: self.pitch_rad }
    }
}

/// A colour threshold is not trusted to so many pixels: what is that near the mask counts as in it, as in the pipeline.
const DOUBTFUL_PX: i64 = 1;
/// Pixels rendered around the fruit beyond their own extent.
const BORDER_PX: i64 = 14;
/// A depth step that separates two surfaces, mm: as in the pipeline, nine tenths of the short semi-axis of a jujube.
const OUTLINE_STEP_MM: f32 = 0.9 * SizePrior::JUJUBE.semi_axes_mm[2];

impl Scene {
    /// The scene of `family` that belongs to `seed`.
    pub fn new(family: &Family, seed: u64) -> Self {
        let mut draws = Draws::new(seed);
        let range = |draws: &mut Draws, (low, high)| draws.uniform(low, high);
        let distance = range(&mut draws, family.distance_mm);
        let (x, y) = (draws.uniform(-0.4, 0.4), draws.uniform(-0.35, 0.35));
        let centre = along([0.0; 3], distance, unit([x, y, 1.0]));
        let subject = family.subject.body(centre, &mut draws);
        let extent = placement::extent(&subject);
        let sensor = Sensor {
            focal_px: FOCAL_PX,
            axial_mm: range(&mut draws, family.axial_mm),
            slant: family.slant,
            lateral_px: range(&mut draws, family.lateral_px),
            quantum_mm: family.quantum_mm,
            flying: family.defects[0],
            edge_hole: family.defects[1],
            hole: family.defects[2],
            rays: family.rays,
        };
        let mut bodies = vec![subject];
        if draws.chance(family.neighbour) {
            placement::neighbour(&mut bodies, &family.subject, &mut draws);
        }
        let others = range(&mut draws, family.touching) as usize;
        placement::touching(&mut bodies, others, &family.subject, &mut draws);
        let behind = range(&mut draws, family.background_mm);
        placement::clutter(&mut bodies, range(&mut draws, family.clutter) as usize, &mut draws);
        placement::background(&mut bodies, extent + behind, &mut draws);
        let wanted = range(&mut draws, family.occlusion);
        placement::leaves(&mut bodies, wanted, &mut draws);

        let window = window(&bodies, extent);
        let patch = record(&bodies, &sensor, window, &mut draws);
        let mask = colour_mask(&patch, &bodies, &mut draws);
        let is_fruit = !family.decoy && matches!(family.subject, Subject::Fruit { .. });
        let fruit = (0..bodies.len()).filter_map(|k| truth(&bodies, k)).filter(|_| is_fruit).collect();
        let margin_px = libm::rint(range(&mut draws, family.margin_px)) as i64;
        Self { patch, sensor, bodies, fruit, mask, margin_px }
    }

    /// What a search is given when the mask has this error.
    pub fn sighting(&self, bias: MaskBias) -> Sighting {
        let mask = bias.applied(&self.mask);
        let near_mask = |u: i64, v: i64| {
            let reach = -DOUBTFUL_PX..=DOUBTFUL_PX;
            reach.clone().any(|dv| reach.clone().any(|du| mask.get(u + du, v + dv) == Some(255)))
        };
        let mut region = mask.clone();
        for _ in 0..self.margin_px {
            region = grown(&region, true);
        }
        let (mut cloud, mut margin) = (Vec::new(), Vec::new());
        for v in 0..mask.height as i64 {
            for u in 0..mask.width as i64 {
                let depth = self.patch.depth.get(u, v).unwrap_or(0.0);
                if depth > 0.0 && region.get(u, v) == Some(255) {
                    let list = if near_mask(u, v) { &mut cloud } else { &mut margin };
                    list.push(self.point(u, v, depth));
                }
            }
        }
        let inside = cloud.len();
        cloud.append(&mut margin);
        let (window, focal) = (self.patch.window, self.sensor.focal_px);
        let ray = |u: f64, v: f64| [(window.left as f64 + u) / focal, (window.top as f64 + v) / focal];
        let all = (0..=mask.width as i64 - 1, 0..=mask.height as i64 - 1);
        let in_mask = |u: i64, v: i64| mask.get(u, v) == Some(255);
        let outline = outline_rays(&self.patch.depth, all, in_mask, focal, ray, OUTLINE_STEP_MM);
        Sighting { cloud, in_mask: inside, outline, pitch_rad: (1.0 / focal) as f32 }
    }

    /// The point that a pixel of the patch shows.
    fn point(&self, u: i64, v: i64, depth_mm: f32) -> Point3 {
        let window = &self.patch.window;
        let (x, y) = ((window.left + u) as f32, (window.top + v) as f32);
        let focal = self.sensor.focal_px as f32;
        Point3::new(x * depth_mm / focal, y * depth_mm / focal, depth_mm)
    }
}

/// Pixels that show all fruit of a scene and some of what is around them.
fn window(bodies: &[Body], extent: f64) -> Window {
    let (mut low, mut high) = ([i64::MAX; 2], [i64::MIN; 2]);
    for body in bodies.iter().filter(|body| body.fruit_coloured) {
        let [x, y, z] = body.pose.centre;
        let half = (1.3 * extent / z * FOCAL_PX) as i64 + BORDER_PX;
        for (k, across) in [x, y].into_iter().enumerate() {
            let middle = (across / z * FOCAL_PX) as i64;
            (low[k], high[k]) = (low[k].min(middle - half), high[k].max(middle + half));
        }
    }
    let [width, height] = [0, 1].map(|k| (high[k] - low[k] + 1) as usize);
    Window { left: low[0], top: low[1], width, height }
}

fn truth(bodies: &[Body], index: usize) -> Option<Truth> {
    let Body {
        pose: Pose { centre, axes },
        shape: Shape::Superellipsoid { semi_axes, .. },
        fruit_coloured: true,
    } = bodies[index]
    else {
        return None;
    };
    let visible = 1.0 - placement::occlusion(bodies, index);
    Some(Truth { ellipsoid: EllipsoidF64::sorted(centre, semi_axes, axes), visible })
}

#[cfg(test)]
mod tests {
    use super::super::{
        families::{CLEAN, HARD, ORCHARD},
        subject::{Subject, scaled_jujube},
    };
    use super::*;
    use nalgebra::Point3 as Wide;

    fn level(truth: &Truth, point: &Point3) -> f64 {
        truth.ellipsoid.level(&Wide::from([point.x, point.y, point.z].map(f64::from)))
    }

    #[test]
    fn a_seed_is_a_scene() {
        assert_eq!(Scene::new(&ORCHARD, 3), Scene::new(&ORCHARD, 3));
        assert_ne!(Scene::new(&ORCHARD, 3).patch.depth, Scene::new(&ORCHARD, 4).patch.depth);
    }

    #[test]
    fn depth_lies_on_the_true_surface() {
        let quiet = Family { axial_mm: (0.0, 0.0), lateral_px: (0.0, 0.0), ..CLEAN };
        for seed in 0..20 {
            let scene = Scene::new(&quiet, seed);
            let truth = scene.fruit[0];
            assert_eq!(truth.visible, 1.0);
            for v in 1..scene.patch.owner.height as i64 - 1 {
                for u in 1..scene.patch.owner.width as i64 - 1 {
                    let depth = scene.patch.depth.get(u, v).unwrap();
                    if depth > 0.0 && scene.patch.owner.get(u, v) == Some(1) {
                        let level = level(&truth, &scene.point(u, v, depth));
                        // A depth is an f32: 0.06 um at 1 m, 1e-5 of a semi-axis; steep at the rim.
                        assert!((level - 1.0).abs() < 1e-4, "seed {seed}, pixel {u} {v}: level {level}");
                    }
                }
            }
        }
    }

    #[test]
    fn noise_is_as_large_as_asked_for() {
        let noisy = Family { axial_mm: (1.0, 1.0), lateral_px: (0.0, 0.0), ..CLEAN };
        let quiet = Family { axial_mm: (0.0, 0.0), ..noisy };
        let (mut sum, mut count) = (0.0, 0.0);
        for seed in 0..20 {
            let [noisy, quiet] = [noisy, quiet].map(|family| Scene::new(&family, seed).patch.depth);
            for (a, b) in noisy.pixels.iter().zip(&quiet.pixels).filter(|(a, b)| **a > 0.0 && **b > 0.0) {
                sum += f64::from((a - b) * (a - b));
                count += 1.0;
            }
        }
        let deviation = libm::sqrt(sum / count);
        // 1e5 pixels: 0.2 % of statistical error.
        assert!(count > 5e4 && (deviation - 1.0).abs() < 0.02, "{deviation} from {count}");
    }

    #[test]
    fn a_sighting_lists_the_mask_first_and_every_point_of_the_region_once() {
        let scene = Scene::new(&HARD, 5);
        let sighting = scene.sighting(MaskBias::default());
        let valid = |mask: &LabelImage| {
            let pairs = mask.pixels.iter().zip(&scene.patch.depth.pixels);
            pairs.filter(|(label, depth)| **label == 255 && **depth > 0.0).count()
        };
        let grown = |grow_px| MaskBias { grow_px, ..MaskBias::default() }.applied(&scene.mask);
        assert_eq!(sighting.cloud.len(), valid(&grown(scene.margin_px)));
        // One step of city-block growth lies within one pixel, three steps do not.
        assert!(sighting.in_mask >= valid(&grown(scene.margin_px.min(1))));
        let wide = Scene { margin_px: 3, ..scene.clone() }.sighting(MaskBias::default());
        assert!(wide.in_mask >= valid(&grown(1)) && wide.in_mask < wide.cloud.len());
        assert_eq!(sighting.points_only().in_mask, sighting.cloud.len());
        assert!(!sighting.outline.is_empty() && sighting.points_only().outline.is_empty());
    }

    #[test]
    fn a_decoy_has_no_truth() {
        for subject in [Subject::Disc, Subject::Ball(10.0, 17.0), scaled_jujube(0.7)] {
            assert!(Scene::new(&ORCHARD.decoy("decoy", subject), 1).fruit.is_empty());
        }
    }
}
