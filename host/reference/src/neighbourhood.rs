//! Seed point and neighbourhood by linear scans: contract, chapter 4.

use crate::fault::{self, Fault};
use crate::{Point, Stream};

/// Chapter 2: the points that no target has claimed, ascending.
pub fn live_points(labels: &[u8]) -> Vec<u16> {
    let mut live = Vec::new();
    for index in 0..labels.len() {
        if labels[index] == 0 {
            live.push(index as u16);
        }
    }
    live
}

/// Chapter 4: the live point with `below(live)` live points before it; none in a cloud without live points.
pub fn seed_point(labels: &[u8], stream: &mut Stream) -> Option<u16> {
    let live = live_points(labels);
    let rank = stream.below(live.len() as u32);
    live.get(rank as usize).copied()
}

/// Chapter 4: the live points within a finite `radius` of the point `seed`, ascending.
pub fn neighbourhood(cloud: &[Point], labels: &[u8], seed: u16, radius: f32) -> Vec<u16> {
    let s = cloud[seed as usize];
    let mut members = Vec::new();
    for index in live_points(labels) {
        let q = cloud[index as usize];
        let dx = q[0] - s[0];
        let dy = q[1] - s[1];
        let dz = q[2] - s[2];
        let d2 = dx * dx + dy * dy + dz * dz;
        if d2 <= radius * radius && !(fault::is(Fault::Neighbourhood) && d2 == radius * radius) {
            members.push(index);
        }
    }
    members
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOUD: [Point; 4] = [[0.0, 0.0, 0.0], [3.0, 4.0, 0.0], [0.0, 0.0, 5.000_001], [0.0, -1.0, 0.0]];

    #[test]
    fn the_boundary_belongs_to_the_neighbourhood() {
        assert_eq!(neighbourhood(&CLOUD, &[0; 4], 0, 5.0), [0, 1, 3]);
    }

    #[test]
    fn claimed_points_are_neither_members_nor_seeds() {
        assert_eq!(neighbourhood(&CLOUD, &[0, 2, 0, 0], 0, 5.0), [0, 3]);
        let mut stream = Stream::seeded(1);
        for _ in 0..20 {
            assert!(matches!(seed_point(&[1, 0, 2, 0], &mut stream), Some(1 | 3)));
        }
        assert_eq!(seed_point(&[1, 1], &mut stream), None);
    }
}
