//! Two-ellipsoid-bounding-counting: how many points lie between the fitted ellipsoid scaled by `1 - d` and by `1 + d`.
//!
//! Scaling an ellipsoid about its centre changes only the constant of its general equation, Eq. (23)-(27):
//! `a44'' = a44 + (s^2 - 1) I4 / I3`. In the central form that is `f(p) = s^2`, so a point is an inlier when
//! `(1 - d)^2 <= f(p) <= (1 + d)^2`, both bounds included, Eq. (28)-(30). The shell is `2 d` times each semi-axis
//! thick: for a jujube with `d = 0.1`, 4.4 mm along the long axis in all and 2.2 mm across.

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

    /// True when the point lies in the shell, bounds included. 22 flops, no division, no root.
    #[inline(always)]
    pub fn contains(&self, point: &Point3) -> bool {
        let f = self.surface.value(point);
        f >= self.lower && f <= self.upper
    }

    /// Counts the listed points of the cloud.
    #[inline]
    pub fn score(&self, cloud: &[Point3], indices: &[u16]) -> Score {
        let mut inliers = 0;
        for &index in indices {
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
}
