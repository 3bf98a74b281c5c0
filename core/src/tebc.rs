//! Two-ellipsoid-bounding-counting: how many points lie between the fitted ellipsoid scaled by `1 - d` and by `1 + d`.
//!
//! Scaling an ellipsoid about its centre changes only the constant of its general equation, Eq. (23)-(27):
//! `a44'' = a44 + (s^2 - 1) I4 / I3`. In the central form that is `f(p) = s^2`, so a point is an inlier when
//! `(1 - d)^2 <= f(p) <= (1 + d)^2`, both bounds included, Eq. (28)-(30). The shell is `2 d` times each semi-axis
//! thick: for a jujube with `d = 0.1`, 4.4 mm along the long axis in all and 2.2 mm across.
//!
//! # Side by side
//!
//! Scoring is the inner loop of the paper's search. Each point's `f` is a fixed sequence of roundings, but the count is
//! an integer: points may be counted in any order, and so as many at a time as the machine has lanes. The loops here
//! are written so that a compiler can do that by itself - no branch on data, no early end, a fixed number of points a
//! block - which needs neither intrinsics nor `unsafe`, and every width gives the same count:
//! * [`Shell::count`] takes points that lie side by side. It is inlined always, so that a caller that was compiled for
//!   wider registers counts in those.
//! * [`Shell::score`] takes a list of indices, `LANES` at a time: their coordinates are brought side by side first.

use crate::{CentralQuadric, Point3, point::at};

/// A count of inliers among candidates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Score {
    /// Points inside the shell.
    pub inliers: u32,
    /// Points looked at.
    pub candidates: u32,
}

impl Score {
    /// `inliers / candidates`, 0 when there is none.
    pub fn ratio(&self) -> f32 {
        if self.candidates == 0 { 0.0 } else { self.inliers as f32 / self.candidates as f32 }
    }
}

/// Listed points that are counted at a time. Eight fill two of the 128-bit registers that all 64-bit machines have; with
/// more, the coordinates no longer stay in registers and go through memory, at half the speed. A microcontroller has no
/// such registers: there it is the plain loop. Results do not depend on it.
const LANES: usize = if cfg!(target_pointer_width = "64") { 8 } else { 1 };

/// The space between the two auxiliary ellipsoids of Eq. (24).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shell {
    surface: CentralQuadric,
    lower: f32,
    upper: f32,
}

impl Shell {
    /// The shell from `1 - d` to `1 + d` times `surface`.
    #[inline]
    pub fn new(surface: &CentralQuadric, d: f32) -> Self {
        let (inner, outer) = (1.0 - d, 1.0 + d);
        Self { surface: *surface, lower: inner * inner, upper: outer * outer }
    }

    /// True when the point lies in the shell, bounds included. 20 flops, no division, no root.
    #[inline(always)]
    pub fn contains(&self, point: &Point3) -> bool {
        let f = self.surface.value(point);
        // Both sides always: a branch on data would keep the points from being taken side by side.
        (f >= self.lower) & (f <= self.upper)
    }

    /// How many of the points lie in the shell.
    #[inline(always)]
    pub fn count(&self, points: &[Point3]) -> u32 {
        let mut inliers = 0;
        for point in points {
            inliers += u32::from(self.contains(point));
        }
        inliers
    }

    /// Counts the listed points of the cloud.
    #[inline]
    pub fn score(&self, cloud: &[Point3], indices: &[u16]) -> Score {
        let (blocks, rest) = indices.as_chunks::<LANES>();
        let mut inliers = 0;
        for block in blocks {
            let (mut x, mut y, mut z) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
            for lane in 0..LANES {
                let point = at(cloud, block[lane]);
                (x[lane], y[lane], z[lane]) = (point.x, point.y, point.z);
            }
            for lane in 0..LANES {
                inliers += u32::from(self.contains(&Point3::new(x[lane], y[lane], z[lane])));
            }
        }
        for &index in rest {
            inliers += u32::from(self.contains(&at(cloud, index)));
        }
        Score { inliers, candidates: indices.len() as u32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::jacobi::Symmetric3;

    fn ball(radius: f32) -> CentralQuadric {
        let s = 1.0 / (radius * radius);
        CentralQuadric {
            centre: Point3::new(1.0, 1.0, 1.0),
            shape: Symmetric3 { xx: s, yy: s, zz: s, ..Default::default() },
        }
    }

    #[test]
    fn both_bounds_belong_to_the_shell() {
        // Radius 2, d = 0.5: 1 and 3 are exact in binary.
        let shell = Shell::new(&ball(2.0), 0.5);
        let on = |r: f32| shell.contains(&Point3::new(1.0 + r, 1.0, 1.0));
        assert!(on(1.0) && on(2.0) && on(3.0));
        assert!(!on(0.9999) && !on(3.0001));
    }

    #[test]
    fn counting_follows_the_list() {
        let shell = Shell::new(&ball(2.0), 0.1);
        let cloud = [Point3::new(3.0, 1.0, 1.0), Point3::new(1.0, 1.0, 1.0), Point3::new(1.0, -1.1, 1.0)];
        assert_eq!(shell.score(&cloud, &[0, 1, 2]), Score { inliers: 2, candidates: 3 });
        assert_eq!(shell.score(&cloud, &[1]), Score { inliers: 0, candidates: 1 });
        assert_eq!(Score::default().ratio(), 0.0);
    }

    #[test]
    fn lists_of_every_length_count_as_one_point_at_a_time() {
        let shell = Shell::new(&ball(2.0), 0.1);
        // Along a ray through the shell, to and fro.
        let cloud: [Point3; 61] = core::array::from_fn(|k| {
            let radius = 1.5 + (k * 7 % 11) as f32 * 0.1;
            Point3::new(1.0 + radius * 0.6, 1.0 - radius * 0.8, 1.0)
        });
        let mut list: [u16; 60] = core::array::from_fn(|k| (k * 23 % 61) as u16);
        // A point listed twice counts twice; an index beyond the cloud is the origin, which is not in this shell.
        (list[5], list[40]) = (list[6], 61);
        for length in 0..=list.len() {
            let list = &list[..length];
            let one_by_one = list.iter().filter(|&&index| shell.contains(&at(&cloud, index))).count() as u32;
            assert_eq!(shell.score(&cloud, list), Score { inliers: one_by_one, candidates: length as u32 });
        }
        for length in 0..=cloud.len() {
            let points = &cloud[..length];
            let one_by_one = points.iter().filter(|&point| shell.contains(point)).count() as u32;
            assert_eq!(shell.count(points), one_by_one);
        }
        assert!((10..40).contains(&shell.count(&cloud)), "{}", shell.count(&cloud));
    }
}
