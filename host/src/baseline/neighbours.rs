//! Exact neighbours of a point: the k nearest, and all within a radius.
//!
//! A balanced k-d tree over `f64` points, stored as a permutation (the median of each range is its node). The core's
//! tree searches by range only and in `f32`; the baseline stands on its own feet.

/// Ranges up to this size are scanned.
const LEAF: usize = 12;

/// A k-d tree over points that it owns. Build `O(n log n)`.
#[derive(Debug, Clone)]
pub struct NeighbourTree {
    points: Vec<[f64; 3]>,
    order: Vec<u32>,
    /// Splitting axis of the node at the same place in `order`.
    axes: Vec<u8>,
}

/// A neighbour: squared distance and index, compared in that order.
type Neighbour = (f64, u32);

impl NeighbourTree {
    /// Over finite points, at most `u32::MAX` of them.
    pub fn new(points: Vec<[f64; 3]>) -> Self {
        let order = (0..points.len() as u32).collect();
        let mut tree = Self { axes: vec![0; points.len()], points, order };
        tree.split(0, tree.points.len());
        tree
    }

    /// The points, in the order in which they were given.
    pub fn points(&self) -> &[[f64; 3]] {
        &self.points
    }

    /// Sorts `order[low..high]` about its median along the widest axis, then both halves. Depth: log2 n.
    fn split(&mut self, low: usize, high: usize) {
        if high - low <= LEAF {
            return;
        }
        let axis = self.widest_axis(low, high);
        let points = &self.points;
        let middle = low + (high - low) / 2;
        self.order[low..high].select_nth_unstable_by(middle - low, |&i, &j| {
            points[i as usize][axis].total_cmp(&points[j as usize][axis]).then(i.cmp(&j))
        });
        self.axes[middle] = axis as u8;
        self.split(low, middle);
        self.split(middle + 1, high);
    }

    fn widest_axis(&self, low: usize, high: usize) -> usize {
        let extent = |axis: usize| {
            let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
            for &i in &self.order[low..high] {
                let value = self.points[i as usize][axis];
                least = least.min(value);
                most = most.max(value);
            }
            most - least
        };
        let extents = [extent(0), extent(1), extent(2)];
        (0..3).fold(0, |widest, axis| if extents[axis] > extents[widest] { axis } else { widest })
    }

    /// Indices of all points at most `radius` from `centre`, ascending, into `found` (cleared first).
    ///
    /// Past an eighth of the cloud, sorting what the tree finds costs more than looking at every point in order; the
    /// list is the same.
    pub fn within(&self, centre: [f64; 3], radius: f64, found: &mut Vec<u32>) {
        let (limit, few) = (radius * radius, self.points.len() / 8);
        found.clear();
        self.visit(0, self.points.len(), centre, &mut |(squared, index)| {
            if squared <= limit {
                found.push(index);
            }
            // A negative limit ends the search: no distance is below it.
            if found.len() > few { -1.0 } else { limit }
        });
        if found.len() > few {
            let all = 0..self.points.len() as u32;
            found.clear();
            found.extend(all.filter(|&index| self.neighbour(index, centre).0 <= limit));
        } else {
            found.sort_unstable();
        }
    }

    /// Indices of the `count` points nearest to `centre` (fewer in a smaller cloud), nearest first; of equally near
    /// ones the lower index. A point of the cloud is its own nearest neighbour.
    pub fn nearest(&self, centre: [f64; 3], count: usize, found: &mut Vec<u32>) {
        let mut best: Vec<Neighbour> = Vec::with_capacity(count.min(self.points.len()) + 1);
        let mut limit = f64::INFINITY;
        self.visit(0, self.points.len(), centre, &mut |candidate| {
            // Most candidates are too far, and that is all there is to know about them.
            if candidate.0 <= limit {
                let place = best.partition_point(|kept| before(*kept, candidate));
                best.insert(place, candidate);
                best.truncate(count);
                if best.len() == count {
                    limit = best.last().map_or(-1.0, |worst| worst.0);
                }
            }
            limit
        });
        found.clear();
        found.extend(best.iter().map(|&(_, index)| index));
    }

    /// Offers every point that may matter; `offer` answers with the squared distance beyond which none does.
    /// Returns that limit as the last call left it.
    fn visit(
        &self,
        low: usize,
        high: usize,
        centre: [f64; 3],
        offer: &mut impl FnMut(Neighbour) -> f64,
    ) -> f64 {
        let mut limit = f64::INFINITY;
        if high - low <= LEAF {
            for &index in &self.order[low..high] {
                limit = offer(self.neighbour(index, centre));
            }
            return limit;
        }
        let middle = low + (high - low) / 2;
        let index = self.order[middle];
        let axis = usize::from(self.axes[middle]);
        let offset = centre[axis] - self.points[index as usize][axis];
        let (near, far) = if offset < 0.0 {
            ((low, middle), (middle + 1, high))
        } else {
            ((middle + 1, high), (low, middle))
        };
        self.visit(near.0, near.1, centre, offer);
        limit = offer(self.neighbour(index, centre));
        // Equal distances are visited: a lower index may wait there.
        if offset * offset <= limit {
            limit = self.visit(far.0, far.1, centre, offer);
        }
        limit
    }

    fn neighbour(&self, index: u32, centre: [f64; 3]) -> Neighbour {
        let [x, y, z] = self.points[index as usize];
        let (dx, dy, dz) = (x - centre[0], y - centre[1], z - centre[2]);
        (dx * dx + dy * dy + dz * dz, index)
    }
}

fn before(p: Neighbour, q: Neighbour) -> bool {
    p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)).is_lt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use varsac_core::rng::Stream;

    /// Points on a coarse grid, so that many distances are equal and many points coincide.
    fn cloud(count: usize, cells: u32) -> Vec<[f64; 3]> {
        let mut stream = Stream::new(3);
        (0..count).map(|_| std::array::from_fn(|_| f64::from(stream.below(cells)))).collect()
    }

    fn scanned(points: &[[f64; 3]], centre: [f64; 3]) -> Vec<Neighbour> {
        let mut all: Vec<Neighbour> = points
            .iter()
            .enumerate()
            .map(|(i, p)| {
                (
                    (p[0] - centre[0]).powi(2) + (p[1] - centre[1]).powi(2) + (p[2] - centre[2]).powi(2),
                    i as u32,
                )
            })
            .collect();
        all.sort_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        all
    }

    #[test]
    fn both_searches_agree_with_a_scan_ties_included() {
        for (count, cells) in [(1, 5), (12, 3), (13, 1), (300, 6), (2000, 1000)] {
            let points = cloud(count, cells);
            let tree = NeighbourTree::new(points.clone());
            let mut found = Vec::new();
            for centre in points.iter().copied().step_by(17).chain([[-4.0, 2.5, 900.0]]) {
                let all = scanned(&points, centre);
                tree.nearest(centre, 13, &mut found);
                let expected: Vec<u32> = all.iter().take(13).map(|n| n.1).collect();
                assert_eq!(found, expected);
                for radius in [0.0, 1.0, 3.5, 200.0] {
                    tree.within(centre, radius, &mut found);
                    let mut expected: Vec<u32> =
                        all.iter().filter(|n| n.0 <= radius * radius).map(|n| n.1).collect();
                    expected.sort_unstable();
                    assert_eq!(found, expected);
                }
            }
        }
    }

    #[test]
    fn an_empty_cloud_has_no_neighbours() {
        let tree = NeighbourTree::new(Vec::new());
        let mut found = vec![7];
        tree.nearest([0.0; 3], 3, &mut found);
        assert!(found.is_empty());
        tree.within([0.0; 3], 3.0, &mut found);
        assert!(found.is_empty());
    }
}
