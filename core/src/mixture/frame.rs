//! The search's own frame: whatever the unit of the cloud, the bodies in it are of the size of one.
//!
//! Origin: per axis the median of the live points. Unit: their median distance from it. Medians, so that a few strays
//! far away do not shrink the body to a dot. With a viewpoint the origin stays where it is (all rays pass through it) and
//! only the unit changes.

use crate::{
    Point3,
    order::select_by_key,
    outline::OutlineRay,
    point::{at, distance_squared},
    residual::Viewpoint,
    rng::Stream,
};

/// `local = (p - origin) * inverse`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Frame {
    pub(crate) origin: Point3,
    /// Length of one local unit in the unit of the cloud.
    pub(crate) unit: f32,
    inverse: f32,
    /// Volume of the box around the live points, local units cubed.
    pub(crate) volume: f32,
}

/// Edges of the box are at least this part of the longest: what lies in a plane is a plane, and not clutter in a flat box.
const THINNEST: f32 = 0.1;
/// And at most this long, so that no density leaves the range of `f32` for the sake of a stray point.
const LONGEST: f32 = 1e4;

impl Frame {
    /// The frame of the listed points; permutes the list. `None` when half of the points coincide.
    pub(crate) fn around(cloud: &[Point3], list: &mut [u16], viewpoint: Viewpoint) -> Option<Self> {
        let middle = list.len() / 2;
        let mut median = |key: &dyn Fn(&Point3) -> f32| {
            select_by_key(list, middle, |index| key(&at(cloud, index)));
            // The sign of a zero would depend on which of two equal keys was selected.
            list.get(middle).map_or(0.0, |&index| key(&at(cloud, index)) + 0.0)
        };
        let centre = Point3::new(median(&|p| p.x), median(&|p| p.y), median(&|p| p.z));
        let unit = libm::sqrtf(median(&|p| distance_squared(p, &centre)));
        let inverse = 1.0 / unit;
        if !(unit > 0.0 && inverse.is_finite()) {
            return None;
        }
        let origin = match viewpoint {
            Viewpoint::Origin => Point3::new(0.0, 0.0, 0.0),
            Viewpoint::None => centre,
        };
        let mut frame = Self { origin, unit, inverse, volume: 0.0 };
        frame.volume = frame.box_volume(cloud, list);
        Some(frame)
    }

    fn box_volume(&self, cloud: &[Point3], list: &[u16]) -> f32 {
        let mut low = [f32::INFINITY; 3];
        let mut high = [f32::NEG_INFINITY; 3];
        for &index in list {
            let p = self.local(&at(cloud, index));
            for (k, value) in [p.x, p.y, p.z].into_iter().enumerate() {
                low[k] = if value < low[k] { value } else { low[k] };
                high[k] = if value > high[k] { value } else { high[k] };
            }
        }
        let mut edges = [0.0; 3];
        let mut longest = 0.0;
        for k in 0..3 {
            let length = high[k] - low[k];
            edges[k] = if length < LONGEST { length } else { LONGEST };
            longest = if edges[k] > longest { edges[k] } else { longest };
        }
        let least = THINNEST * longest;
        let [x, y, z] = edges.map(|edge| if edge > least { edge } else { least });
        (x * y) * z
    }

    /// A point of the cloud in local units.
    #[inline(always)]
    pub(crate) fn local(&self, p: &Point3) -> Point3 {
        let o = &self.origin;
        Point3::new((p.x - o.x) * self.inverse, (p.y - o.y) * self.inverse, (p.z - o.z) * self.inverse)
    }

    /// An outline ray in local units; the origin is the camera's.
    #[inline]
    pub(crate) fn local_ray(&self, ray: &OutlineRay) -> OutlineRay {
        OutlineRay {
            inner: self.local(&ray.inner),
            outer_mm: ray.outer_mm * self.inverse,
            sigma_rad: ray.sigma_rad,
        }
    }

    /// A local point in the cloud's frame and unit.
    pub(crate) fn cloud(&self, p: &Point3) -> Point3 {
        let o = &self.origin;
        Point3::new(o.x + p.x * self.unit, o.y + p.y * self.unit, o.z + p.z * self.unit)
    }
}

/// Moves a random choice of `count` members to the front of the list, in the order drawn (the beginning of the shuffle
/// of Fisher and Yates). Fewer members than that: all of them.
pub(crate) fn shuffle_front(list: &mut [u16], count: usize, stream: &mut Stream) {
    let length = list.len();
    let count = if count < length { count } else { length };
    for k in 0..count {
        let other = k + stream.below((length - k) as u32) as usize;
        if let (Some(&a), Some(&b)) = (list.get(k), list.get(other)) {
            if let Some(slot) = list.get_mut(k) {
                *slot = b;
            }
            if let Some(slot) = list.get_mut(other) {
                *slot = a;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(scale: f32, shift: f32) -> [Point3; 101] {
        core::array::from_fn(|k| {
            let t = k as f32 - 50.0;
            Point3::new(scale * t + shift, scale * (t * t * 0.01), -scale * t)
        })
    }

    #[test]
    fn any_unit_is_one() {
        for (scale, shift) in [(1e-6, 0.0), (1.0, 1000.0), (1e6, 0.0)] {
            let cloud = cloud(scale, shift);
            let mut list: [u16; 101] = core::array::from_fn(|k| k as u16);
            let frame = Frame::around(&cloud, &mut list, Viewpoint::None).unwrap();
            assert!((frame.unit / (scale * 36.0) - 1.0).abs() < 0.05, "{frame:?}");
            let back = frame.cloud(&frame.local(&cloud[90]));
            assert!((back.x - cloud[90].x).abs() <= 1e-6 * (scale * 100.0 + shift));
        }
    }

    #[test]
    fn coincident_points_have_no_frame() {
        let cloud = [Point3::new(1.0, 2.0, 3.0); 40];
        let mut list: [u16; 40] = core::array::from_fn(|k| k as u16);
        assert!(Frame::around(&cloud, &mut list, Viewpoint::None).is_none());
    }

    #[test]
    fn the_front_is_a_choice_without_repetition() {
        let mut stream = Stream::new(5);
        let mut list: [u16; 50] = core::array::from_fn(|k| k as u16);
        shuffle_front(&mut list, 20, &mut stream);
        let mut seen = [false; 50];
        for index in list {
            assert!(!core::mem::replace(&mut seen[usize::from(index)], true));
        }
        assert!(list[..20].windows(2).any(|pair| pair[0] > pair[1]));
    }
}
