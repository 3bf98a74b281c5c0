//! What the searches of a run share: the view, the buffers, the random stream and the count of what is left.

use crate::{
    Config, Point3, kdtree, outline::OutlineRay, point::distance_squared, rng::Stream, workspace::Lists,
};

/// What a run looks at: points, and what is known of them beyond their coordinates.
#[derive(Debug, Clone, Copy)]
pub struct View<'a> {
    /// Points, mm, camera optical frame.
    pub cloud: &'a [Point3],
    /// Points before this index lie in the mask of fruit-coloured pixels; the others are what is seen around it. They
    /// show where fruit are not. The paper's search makes no difference.
    pub in_mask: usize,
    /// Outline rays found in the depth image; may be empty, at most [`MAX_OUTLINE`](crate::MAX_OUTLINE). Without a viewpoint they mean nothing.
    pub outline: &'a [OutlineRay],
    /// Angle between neighbouring points of a frontal surface, rad: one over the focal length in pixels where each pixel is
    /// a point. 0: not known, and how much of a fruit is visible is not tested.
    pub pitch_rad: f32,
}

impl<'a> From<&'a [Point3]> for View<'a> {
    /// All points in the mask, no outline, pitch not known.
    fn from(cloud: &'a [Point3]) -> Self {
        Self { cloud, in_mask: cloud.len(), outline: &[], pitch_rad: 0.0 }
    }
}

/// The field of a run.
#[derive(Debug)]
pub(crate) struct Field<'a> {
    pub(crate) config: &'a Config,
    pub(crate) view: View<'a>,
    pub(crate) scratch: Lists<'a>,
    pub(crate) stream: Stream,
    /// Unclaimed points.
    pub(crate) live: u32,
    /// Unclaimed points in the mask.
    pub(crate) seeds: u32,
    /// Targets so far: the largest label.
    pub(crate) targets: u8,
}

impl Field<'_> {
    /// Lists the unclaimed points in `members`, ascending, and arranges them as a tree in `order`; returns how many.
    pub(crate) fn plant(&mut self) -> usize {
        let live = self.scratch.list_live(self.view.cloud, |_| true);
        let (order, members) = (&mut *self.scratch.order, &*self.scratch.members);
        if let (Some(order), Some(members)) = (order.get_mut(..live), members.get(..live)) {
            order.copy_from_slice(members);
            kdtree::build(self.view.cloud, order);
        }
        live
    }

    /// The first `count` listed points are the next target's; returns its number.
    pub(crate) fn claim(&mut self, count: usize) -> u8 {
        self.targets += 1;
        for &index in self.scratch.members.get(..count).unwrap_or(&[]) {
            if let Some(label) = self.scratch.labels.get_mut(usize::from(index)) {
                *label = self.targets;
            }
            self.seeds -= u32::from(usize::from(index) < self.view.in_mask);
        }
        self.live -= count as u32;
        self.targets
    }

    /// Lists all points within `radius` of `centre` in `members`, ascending, claimed or not; returns how many. Expects the tree
    /// over the whole cloud in `order`. By the tree where they are few, by looking at every point where sorting them would
    /// cost more: the list is the same.
    pub(crate) fn list_within(&mut self, centre: &Point3, radius: f32) -> usize {
        let (cloud, scratch) = (self.view.cloud, &mut self.scratch);
        let tree = scratch.order.get(..cloud.len()).unwrap_or(&[]);
        let room = if cloud.len() < SMALL_CLOUD { 0 } else { cloud.len() / 8 };
        let few = scratch.members.get_mut(..room).unwrap_or(&mut []);
        kdtree::within(cloud, tree, centre, radius, few).unwrap_or_else(|| {
            let limit = radius * radius;
            let mut count = 0;
            for (index, point) in cloud.iter().enumerate() {
                if let Some(slot) = scratch.members.get_mut(count) {
                    *slot = index as u16;
                    count += usize::from(distance_squared(point, centre) <= limit);
                }
            }
            count
        })
    }
}

/// Below this many points a look at each of them is the quicker way.
const SMALL_CLOUD: usize = 600;
