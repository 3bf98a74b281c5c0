//! The memory of a search: five bytes a point and room for what is found, in place or lent.
//!
//! With the 12 bytes of the point itself a cloud costs 17 bytes a point. Found fruit are kept here and not in the run, so
//! that a run is small enough for the stack of a microcontroller. The capacity `N` is known here and nowhere
//! below: [`Workspace`] owns, [`Scratch`] borrows, algorithms take slices.

use crate::{Point3, map::Finds, point::MAX_POINTS};

/// Owns the buffers for clouds of up to `N` points. Place it on the stack or in a `static`.
///
/// ```
/// use varsac_core::Workspace;
/// let mut workspace = Workspace::<2048>::new();
/// assert_eq!(workspace.scratch().capacity(), 2048);
/// assert_eq!(size_of::<Workspace<2048>>(), 5 * 2048 + size_of::<varsac_core::Finds>());
/// ```
#[derive(Debug, Clone)]
pub struct Workspace<const N: usize> {
    order: [u16; N],
    members: [u16; N],
    labels: [u8; N],
    finds: Finds,
}

impl<const N: usize> Workspace<N> {
    /// An empty workspace.
    pub const fn new() -> Self {
        const { assert!(N <= MAX_POINTS, "indices are u16: a workspace holds at most 65535 points") };
        Self { order: [0; N], members: [0; N], labels: [0; N], finds: Finds::new() }
    }

    /// Lends the buffers to one search.
    pub fn scratch(&mut self) -> Scratch<'_> {
        Scratch::new(&mut self.order, &mut self.members, &mut self.labels, &mut self.finds)
    }
}

impl<const N: usize> Default for Workspace<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Borrowed buffers of one search; what they held before does not matter.
#[derive(Debug)]
pub struct Scratch<'a> {
    pub(crate) lists: Lists<'a>,
    pub(crate) finds: &'a mut Finds,
}

/// The part of it that holds something for each point.
#[derive(Debug)]
pub(crate) struct Lists<'a> {
    /// Permutation of the live points: the k-d tree.
    pub(crate) order: &'a mut [u16],
    /// Neighbourhood of the seed point, or inliers of a model, ascending.
    pub(crate) members: &'a mut [u16],
    /// 0 while a point is live, then the number of the target that claimed it.
    pub(crate) labels: &'a mut [u8],
}

impl<'a> Scratch<'a> {
    /// Buffers from elsewhere (a C program's, say); the shortest decides the capacity.
    pub fn new(
        order: &'a mut [u16],
        members: &'a mut [u16],
        labels: &'a mut [u8],
        finds: &'a mut Finds,
    ) -> Self {
        Self { lists: Lists { order, members, labels }, finds }
    }

    /// Points there is room for.
    pub fn capacity(&self) -> usize {
        let Lists { order, members, labels } = &self.lists;
        order.len().min(members.len()).min(labels.len()).min(MAX_POINTS)
    }

    /// Declares the first `count` points live: for searches that are run by hand, see [`crate::mixture`].
    pub fn reset(&mut self, count: usize) {
        self.lists.labels.iter_mut().take(count).for_each(|label| *label = 0);
    }
}

impl Lists<'_> {
    /// Copies the first `count` members to `order` and lends them there.
    pub(crate) fn copy_members(&mut self, count: usize) -> &mut [u16] {
        for (slot, &index) in self.order.iter_mut().zip(self.members.iter()).take(count) {
            *slot = index;
        }
        self.order.get_mut(..count).unwrap_or(&mut [])
    }

    /// Lists the unclaimed points that satisfy `wanted` in `members`, ascending; returns how many. `O(n)`.
    pub(crate) fn list_live(&mut self, cloud: &[Point3], wanted: impl Fn(&Point3) -> bool) -> usize {
        let mut count = 0;
        for ((index, point), &label) in cloud.iter().enumerate().zip(self.labels.iter()) {
            // Written always and counted when wanted: no branch that the data decides.
            if let Some(slot) = self.members.get_mut(count) {
                *slot = index as u16;
                count += usize::from((label == 0) & wanted(point));
            }
        }
        count
    }
}
