//! A k-d tree that is nothing but a permutation of `u16` indices: two bytes a point, no nodes, no heap.
//!
//! The tree over `order[low..high]` has its root at the middle; what lies before it is not larger on the splitting
//! axis and what lies behind it not smaller. The axes take turns x, y, z with the depth. Subtrees of a few points are not
//! split: looking at each of their points costs less than going down to it. Which permutation the build
//! arrives at never shows: a search returns the set of points within the radius, in ascending index order.

use crate::{
    Point3,
    order::{select_by_key, sort},
    point::{at, distance_squared},
};

/// Subtrees waiting on the way down: at most one a level, and 65 535 points make 16 levels.
const STACK: usize = 17;

/// Subtrees of so many points are leaves.
const LEAF: u16 = 8;

/// A pending subtree: `order[low..high]`, split on `axis`.
#[derive(Clone, Copy, Default)]
struct Subtree {
    low: u16,
    high: u16,
    axis: u8,
}

impl Subtree {
    fn is_leaf(self) -> bool {
        self.high - self.low <= LEAF
    }

    fn middle(self) -> u16 {
        self.low + (self.high - self.low) / 2
    }

    fn halves(self) -> [Self; 2] {
        let axis = if self.axis == 2 { 0 } else { self.axis + 1 };
        let middle = self.middle();
        [Self { high: middle, axis, ..self }, Self { low: middle + 1, axis, ..self }]
    }
}

/// Last in, first out, bounded by the depth of the tree.
struct Pending {
    subtrees: heapless::Vec<Subtree, STACK>,
}

impl Pending {
    fn new(count: usize) -> Self {
        let mut pending = Self { subtrees: heapless::Vec::new() };
        pending.push(Subtree { low: 0, high: count as u16, axis: 0 });
        pending
    }

    fn push(&mut self, subtree: Subtree) {
        if subtree.low < subtree.high {
            // Never full: see STACK.
            let _ = self.subtrees.push(subtree);
        }
    }

    fn pop(&mut self) -> Option<Subtree> {
        self.subtrees.pop()
    }
}

fn coordinate(p: &Point3, axis: u8) -> f32 {
    match axis {
        0 => p.x,
        1 => p.y,
        _ => p.z,
    }
}

/// Arranges the indices in `order` (distinct, at most 65 535) into a tree. `O(n log n)`.
pub fn build(cloud: &[Point3], order: &mut [u16]) {
    let mut pending = Pending::new(order.len());
    while let Some(subtree) = pending.pop() {
        if subtree.is_leaf() {
            continue;
        }
        let (low, high) = (usize::from(subtree.low), usize::from(subtree.high));
        let middle = usize::from(subtree.middle());
        if let Some(part) = order.get_mut(low..high) {
            // Ties by index: a cloud of equal points must not make the selection quadratic.
            select_by_key(part, middle - low, |index| (coordinate(&at(cloud, index), subtree.axis), index));
        }
        let [before, behind] = subtree.halves();
        pending.push(behind);
        pending.push(before);
    }
}

/// Writes the indices of all points of the tree within `radius` of `centre` (bound included) into `members`, ascending,
/// and returns how many there are; `None` when they do not fit. `O(sqrt n + m log m)` for m members as a rule.
///
/// Pruning is exact: a point beyond the splitting plane has `|dx|` not smaller than the plane's, and rounding is
/// monotone, so its computed squared distance is not smaller than the square tested here.
pub fn within(
    cloud: &[Point3],
    order: &[u16],
    centre: &Point3,
    radius: f32,
    members: &mut [u16],
) -> Option<usize> {
    let limit = radius * radius;
    let mut count = 0;
    let mut take_if_within = |index: u16, point: &Point3| {
        if distance_squared(point, centre) <= limit {
            *members.get_mut(count)? = index;
            count += 1;
        }
        Some(())
    };
    let mut pending = Pending::new(order.len());
    while let Some(subtree) = pending.pop() {
        if subtree.is_leaf() {
            for &index in order.get(usize::from(subtree.low)..usize::from(subtree.high)).unwrap_or(&[]) {
                take_if_within(index, &at(cloud, index))?;
            }
            continue;
        }
        let Some(&index) = order.get(usize::from(subtree.middle())) else { continue };
        let point = at(cloud, index);
        take_if_within(index, &point)?;
        let offset = coordinate(centre, subtree.axis) - coordinate(&point, subtree.axis);
        let crosses = offset * offset <= limit;
        let [before, behind] = subtree.halves();
        if offset >= 0.0 || crosses {
            pending.push(behind);
        }
        if offset <= 0.0 || crosses {
            pending.push(before);
        }
    }
    sort(members.get_mut(..count)?);
    Some(count)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    fn linear(cloud: &[Point3], centre: &Point3, radius: f32) -> impl Iterator<Item = u16> {
        let limit = radius * radius;
        (0..cloud.len() as u16).filter(move |&i| distance_squared(&cloud[usize::from(i)], centre) <= limit)
    }

    fn check(cloud: &[Point3], order: &mut [u16]) {
        for (k, slot) in order.iter_mut().enumerate() {
            *slot = k as u16;
        }
        build(cloud, order);
        let mut members = [0_u16; 700];
        for (k, centre) in cloud.iter().enumerate() {
            let radius = (k % 40) as f32;
            let count = within(cloud, order, centre, radius, &mut members).unwrap();
            assert!(members[..count].iter().copied().eq(linear(cloud, centre, radius)), "point {k}");
        }
    }

    #[test]
    fn the_tree_agrees_with_a_linear_scan() {
        let mut stream = Stream::new(11);
        // A coarse grid, so that many coordinates and distances are equal.
        let cloud: [Point3; 700] = core::array::from_fn(|_| {
            Point3::new(stream.below(60) as f32, stream.below(60) as f32, 700.0 + stream.below(30) as f32)
        });
        check(&cloud, &mut [0; 700]);
    }

    #[test]
    fn equal_points_and_small_clouds() {
        check(&[Point3::new(1.0, 2.0, 3.0); 700], &mut [0; 700]);
        check(&[], &mut []);
        check(&[Point3::origin()], &mut [0]);
        check(&[Point3::origin(), Point3::new(0.0, 1.0, 0.0)], &mut [0; 2]);
    }

    #[test]
    fn what_does_not_fit_is_said() {
        let cloud = [Point3::origin(); 8];
        let mut order = [0, 1, 2, 3, 4, 5, 6, 7];
        build(&cloud, &mut order);
        let mut three = [0; 3];
        assert_eq!(within(&cloud, &order, &Point3::origin(), 1.0, &mut three), None);
        assert_eq!(within(&cloud, &order, &Point3::origin(), 1.0, &mut [0; 8]), Some(8));
    }
}
