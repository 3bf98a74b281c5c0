//! The frame and the sample of a search: contract, chapter X3.

use super::config::MixtureConfig;
use super::look::{Distance, Scene};
use crate::fault::{self, Fault};
use crate::map::algebra::{Vector, dot, minus};
use crate::map::view::{OutlineRay, View, Viewpoint};
use crate::{Point, Stream};

/// Where the local coordinates of a search lie in the cloud.
pub(crate) struct Frame {
    pub(crate) origin: Point,
    pub(crate) unit: f32,
    inverse: f32,
}

/// X3: the value of rank `n / 2`, plus 0.
fn median(mut keys: Vec<f32>) -> f32 {
    keys.sort_by(f32::total_cmp);
    keys[keys.len() / 2] + 0.0
}

impl Frame {
    /// X3: of the live points; none where they have no extent, or one that has no reciprocal.
    pub(crate) fn of(live: &[Point], viewpoint: Viewpoint) -> Option<Self> {
        let along = |axis: usize| median(live.iter().map(|p| p[axis]).collect());
        let m = [along(0), along(1), along(2)];
        let d2 = live.iter().map(|&p| {
            let d = minus(p, m);
            dot(d, d)
        });
        let unit = libm::sqrtf(median(d2.collect()));
        let inverse = 1.0 / unit;
        let origin = match viewpoint {
            Viewpoint::None => m,
            Viewpoint::Origin => [0.0; 3],
        };
        (unit > 0.0 && inverse.is_finite()).then_some(Self { origin, unit, inverse })
    }

    /// X3: local coordinates.
    pub(crate) fn local(&self, p: Point) -> Vector {
        let d = minus(p, self.origin);
        [d[0] * self.inverse, d[1] * self.inverse, d[2] * self.inverse]
    }

    /// X3: what the local points are looked at with, the distance being that of the starts.
    pub(crate) fn scene(&self, local: &[Vector], view: &View, config: &MixtureConfig) -> Scene {
        let outline = view.outline.iter().map(|ray| OutlineRay {
            inner: self.local(ray.inner),
            outer: ray.outer * self.inverse,
            sigma: ray.sigma,
        });
        Scene {
            volume: volume(local),
            outline: outline.collect(),
            outline_offset: config.outline_offset,
            distance: match config.viewpoint {
                Viewpoint::None => Distance::Radial,
                Viewpoint::Origin => {
                    Distance::Ray { ratio: (config.noise.lateral / config.noise.axial) * self.unit }
                }
            },
        }
    }
}

/// X3: `V`.
fn volume(local: &[Vector]) -> f32 {
    let mut e = [0.0; 3];
    let mut longest = 0.0;
    for axis in 0..3 {
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for p in local {
            low = if p[axis] < low { p[axis] } else { low };
            high = if p[axis] > high { p[axis] } else { high };
        }
        let extent = high - low;
        e[axis] = if extent < 1e4 { extent } else { 1e4 };
        longest = if e[axis] > longest { e[axis] } else { longest };
    }
    let least = 0.1 * longest;
    let [x, y, z] = e.map(|extent| if extent > least { extent } else { least });
    if fault::is(Fault::Volume) { x * (y * z) } else { (x * y) * z }
}

/// X3: the sample of the live points, in the order drawn.
pub(crate) fn sample(live: &[u16], most: u16, stream: &mut Stream) -> Vec<u16> {
    let mut list = live.to_vec();
    let n = list.len();
    let s = n.min(usize::from(most));
    for k in 0..s {
        let first = if fault::is(Fault::Shuffle) { 0 } else { k };
        let j = first + stream.below((n - first) as u32) as usize;
        list.swap(k, j);
    }
    list.truncate(s);
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_upper_one_and_never_minus_zero() {
        assert_eq!(median(vec![3.0, 1.0, 2.0, 4.0]), 3.0);
        assert!(median(vec![-0.0, -0.0]).is_sign_positive());
    }

    #[test]
    fn a_plane_has_a_tenth_of_its_length_as_depth() {
        let volume = volume(&[[0.0; 3], [4.0, 2.0, 0.0]]);
        assert_eq!(volume, (4.0 * 2.0) * (0.1 * 4.0));
    }

    #[test]
    fn equal_points_have_no_frame_and_others_the_median_distance() {
        assert!(Frame::of(&[[1.0; 3]; 12], Viewpoint::None).is_none());
        let points = [[0.0; 3], [2.0, 0.0, 0.0], [-2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, -2.0, 0.0]];
        let frame = Frame::of(&points, Viewpoint::None).expect("points with extent");
        assert_eq!((frame.origin, frame.unit), ([0.0; 3], 2.0));
        assert_eq!(frame.local([1.0, 2.0, -4.0]), [0.5, 1.0, -2.0]);
    }

    #[test]
    fn a_sample_has_each_point_once() {
        let live: Vec<u16> = (0..100).collect();
        let mut drawn = sample(&live, 400, &mut Stream::seeded(1));
        assert_ne!(drawn, live);
        drawn.sort_unstable();
        assert_eq!(drawn, live);
        assert_eq!(sample(&live, 60, &mut Stream::seeded(1)).len(), 60);
    }
}
