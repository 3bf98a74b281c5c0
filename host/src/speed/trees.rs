//! The neighbourhood of a point: the core's k-d tree, a plain look at every point, the baseline's tree, and (with the
//! feature `peers`) the crate kiddo. All give the same list: all points within the radius, ascending.

use std::hint::black_box;

use varsac_core::{Point3, kdtree, point::distance_squared};

use super::{race::Contender, workload};
use crate::baseline::neighbours::NeighbourTree;

/// Radius of a query, mm: a neighbourhood of the default search.
pub const RADIUS_MM: f32 = 20.0;
/// Queries in a run.
const QUERIES: usize = 64;
/// Points around each fruit of the wall.
const POINTS_EACH: usize = 1000;

/// A cloud and its trees.
#[derive(Debug)]
pub struct Neighbourhoods {
    cloud: Vec<Point3>,
    order: Vec<u16>,
    baseline: NeighbourTree,
    #[cfg(feature = "peers")]
    kiddo: kiddo::ImmutableKdTree<f32, 3>,
    centres: Vec<Point3>,
}

impl Neighbourhoods {
    /// A wall of fruit of so many points, at most 65 535.
    pub fn new(count: usize, seed: u64) -> Self {
        let mut cloud = workload::wall(count.div_ceil(POINTS_EACH), POINTS_EACH, seed);
        cloud.truncate(count);
        let step = (cloud.len() / QUERIES).max(1);
        let centres = cloud.iter().step_by(step).take(QUERIES).copied().collect();
        Self {
            order: planted(&cloud),
            baseline: planted_f64(&cloud),
            #[cfg(feature = "peers")]
            kiddo: planted_kiddo(&cloud),
            cloud,
            centres,
        }
    }

    /// Looks at every point.
    pub fn linear(&self, centre: &Point3, found: &mut Vec<u32>) {
        let limit = RADIUS_MM * RADIUS_MM;
        found.clear();
        let within =
            self.cloud.iter().enumerate().filter(|(_, point)| distance_squared(point, centre) <= limit);
        found.extend(within.map(|(index, _)| index as u32));
    }

    /// The core's tree; `members` has room for all points.
    pub fn core(&self, centre: &Point3, members: &mut [u16], found: &mut Vec<u32>) {
        found.clear();
        let count = kdtree::within(&self.cloud, &self.order, centre, RADIUS_MM, members).unwrap_or(0);
        found.extend(members[..count].iter().map(|&index| u32::from(index)));
    }

    /// The baseline's tree.
    pub fn baseline(&self, centre: &Point3, found: &mut Vec<u32>) {
        self.baseline.within([centre.x, centre.y, centre.z].map(f64::from), f64::from(RADIUS_MM), found);
    }

    /// The peer's tree, sorted by index like the others.
    #[cfg(feature = "peers")]
    pub fn kiddo(&self, centre: &Point3, found: &mut Vec<u32>) {
        found.clear();
        let query = [centre.x, centre.y, centre.z];
        let within =
            self.kiddo.query(&query).within::<kiddo::SquaredEuclidean<f32>>(RADIUS_MM * RADIUS_MM).unsorted();
        found.extend(within.execute().iter().map(|item| item.item));
        found.sort_unstable();
    }

    /// Queries; the first looks at every point. The unit is a query.
    pub fn queries(&self) -> Vec<Contender<'_>> {
        let mut members = vec![0; self.cloud.len()];
        #[allow(unused_mut, reason = "one more with the feature")]
        let mut contenders = vec![
            self.query("every point", Self::linear),
            self.query("core", move |all, centre, found| all.core(centre, &mut members, found)),
            self.query("baseline, f64", Self::baseline),
        ];
        #[cfg(feature = "peers")]
        contenders.push(self.query("kiddo", Self::kiddo));
        contenders
    }

    fn query<'a>(
        &'a self,
        name: &'static str,
        mut within: impl FnMut(&Self, &Point3, &mut Vec<u32>) + Send + 'a,
    ) -> Contender<'a> {
        let mut found = Vec::new();
        Contender::new(name, move || {
            for centre in &self.centres {
                within(self, centre, &mut found);
                black_box(&found);
            }
            self.centres.len() as u64
        })
    }

    /// Building the trees. The unit is a tree.
    pub fn builds(&self) -> Vec<Contender<'_>> {
        #[allow(unused_mut, reason = "one more with the feature")]
        let mut contenders = vec![
            Contender::new("core", || {
                black_box(planted(&self.cloud));
                1
            }),
            Contender::new("baseline, f64", || {
                black_box(planted_f64(&self.cloud));
                1
            }),
        ];
        #[cfg(feature = "peers")]
        contenders.push(Contender::new("kiddo", || {
            black_box(planted_kiddo(&self.cloud));
            1
        }));
        contenders
    }
}

fn planted(cloud: &[Point3]) -> Vec<u16> {
    let mut order: Vec<u16> = (0..cloud.len()).map(|index| index as u16).collect();
    kdtree::build(cloud, &mut order);
    order
}

fn planted_f64(cloud: &[Point3]) -> NeighbourTree {
    NeighbourTree::new(cloud.iter().map(|p| [p.x, p.y, p.z].map(f64::from)).collect())
}

#[cfg(feature = "peers")]
fn planted_kiddo(cloud: &[Point3]) -> kiddo::ImmutableKdTree<f32, 3> {
    let points: Vec<[f32; 3]> = cloud.iter().map(|p| [p.x, p.y, p.z]).collect();
    kiddo::ImmutableKdTree::new_from_slice(&points).expect("finite points make a tree")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_trees_find_the_same() {
        let all = Neighbourhoods::new(2500, 6);
        let (mut expected, mut found, mut members) = (Vec::new(), Vec::new(), vec![0; 2500]);
        let mut total = 0;
        for centre in &all.centres {
            all.linear(centre, &mut expected);
            all.core(centre, &mut members, &mut found);
            assert_eq!(found, expected);
            all.baseline(centre, &mut found);
            assert_eq!(found, expected);
            #[cfg(feature = "peers")]
            {
                all.kiddo(centre, &mut found);
                assert_eq!(found, expected);
            }
            total += expected.len();
        }
        assert!(total > 20 * all.centres.len(), "{total}");
    }
}
