//! Two-ellipsoid bounding counting (TEBC): contract, chapter 7; Eq. (23) to (30).

use crate::fault::{self, Fault};
use crate::{Central, Point};

/// How many points lie in the shell of a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Points inside the shell.
    pub inliers: u32,
    /// Points looked at.
    pub candidates: u32,
}

impl Score {
    /// Chapter 7: inliers over candidates, 0 for no candidates.
    pub fn ratio(&self) -> f32 {
        if self.candidates == 0 {
            return 0.0;
        }
        self.inliers as f32 / self.candidates as f32
    }
}

/// Chapter 7: whether `p` lies between `surface` scaled by `1 - d` and by `1 + d`, both bounds included.
pub fn shell_contains(surface: &Central, d: f32, p: Point) -> bool {
    let inner = 1.0 - d;
    let outer = 1.0 + d;
    let c = surface.centre;
    let s = surface.shape;
    let dx = p[0] - c[0];
    let dy = p[1] - c[1];
    let dz = p[2] - c[2];
    let x = s.xx * dx + (2.0 * s.xy) * dy + (2.0 * s.xz) * dz;
    let y = s.yy * dy + (2.0 * s.yz) * dz;
    let f = dx * x + dy * y + (s.zz * dz) * dz;
    if fault::is(Fault::Score) && f == outer * outer {
        return false;
    }
    f >= inner * inner && f <= outer * outer
}

/// Chapter 7: the support of `surface` among the points `list` of the cloud.
pub fn score(surface: &Central, d: f32, cloud: &[Point], list: &[u16]) -> Score {
    let mut inliers = 0;
    for &index in list {
        if shell_contains(surface, d, cloud[index as usize]) {
            inliers += 1;
        }
    }
    Score { inliers, candidates: list.len() as u32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Symmetric;

    /// A sphere of radius 2 around (1, 0, 0).
    const SPHERE: Central = Central {
        centre: [1.0, 0.0, 0.0],
        shape: Symmetric { xx: 0.25, yy: 0.25, zz: 0.25, xy: 0.0, xz: 0.0, yz: 0.0 },
    };

    #[test]
    fn both_bounds_belong_to_the_shell() {
        let at = |radius: f32| shell_contains(&SPHERE, 0.25, [1.0, -radius, 0.0]);
        assert!(at(2.0) && at(1.5) && at(2.5));
        assert!(!at(1.499) && !at(2.501) && !at(0.0));
    }

    #[test]
    fn the_mixed_terms_count_twice() {
        // f = dx^2 + dy^2 + dz^2 + dx dy + dx dz + dy dz = 6 at (1, 1, 1).
        let shape = Symmetric { xx: 1.0, yy: 1.0, zz: 1.0, xy: 0.5, xz: 0.5, yz: 0.5 };
        let surface = Central { centre: [0.0; 3], shape };
        assert!(!shell_contains(&surface, 1.0, [1.0, 1.0, 1.0]), "f = 6, bounds 0 and 4");
        assert!(shell_contains(&surface, 1.5, [1.0, 1.0, 1.0]), "f = 6, bounds 0.25 and 6.25");
    }

    #[test]
    fn the_score_counts_the_points_of_the_list_only() {
        let cloud = [[3.0, 0.0, 0.0], [1.0, 2.0, 0.0], [1.0, 0.0, 0.0]];
        let counted = score(&SPHERE, 0.1, &cloud, &[1, 2]);
        assert_eq!(counted, Score { inliers: 1, candidates: 2 });
        assert_eq!(counted.ratio(), 0.5);
        assert_eq!(Score::default().ratio(), 0.0);
    }
}
