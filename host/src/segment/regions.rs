//! Connected regions of a mask, small and large ones removed (paper III.B.1, Fig. 9d), and regions given by instance.
//!
//! Two passes over horizontal runs instead of pixels. The first finds the runs of each row and joins those that touch
//! a run of the row above (8-neighbourhood) by union-find; the second numbers the joined sets and draws them.
//! A set is named by its first run, so that regions come in the raster order of their first pixel, always.

use crate::image::{Image, LabelImage};

/// Region number of each pixel, 1 for the first region; 0 = no region.
pub type RegionImage = Image<u32>;

/// One region of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// Its number in the [`RegionImage`]: 1, 2, ... in the order of the list.
    pub label: u32,
    /// Value of its pixels in the mask or instance image it came from.
    pub value: u8,
    /// Pixels.
    pub area_px: u32,
    /// Leftmost column.
    pub u_min: u32,
    /// Rightmost column.
    pub u_max: u32,
    /// Topmost row.
    pub v_min: u32,
    /// Lowest row.
    pub v_max: u32,
}

/// Areas that are kept, pixels, both ends included.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct AreaLimits {
    /// Smaller regions are removed.
    pub min_px: u32,
    /// Larger regions are removed.
    pub max_px: u32,
}

impl AreaLimits {
    /// Keeps every region.
    pub const ALL: Self = Self { min_px: 1, max_px: u32::MAX };
}

/// The regions of an image and where they are.
#[derive(Debug, Clone, PartialEq)]
pub struct Regions {
    /// Region number of each pixel; same size as the image.
    pub image: RegionImage,
    /// `list[k]` is the region with label `k + 1`.
    pub list: Vec<Region>,
}

/// Pixels `start..end` of one row, all foreground; `parent` is a run of the same region that is not later.
#[derive(Debug, Clone, Copy)]
struct Run {
    row: u32,
    start: u32,
    end: u32,
    parent: u32,
}

/// The connected regions (8-neighbourhood) of all pixels that are not 0, numbered by their first pixel in raster
/// order. `O(pixels)`; the mask may hold any values, which play no part: 1 beside 2 is one region.
pub fn connected_regions(mask: &LabelImage, limits: AreaLimits) -> Regions {
    let mut runs = joined_runs(mask);
    // Parents are never later than their children, so one pass upwards leads every run to its first.
    for index in 0..runs.len() {
        let parent = runs[index].parent as usize;
        runs[index].parent = runs[parent].parent;
    }
    let mut list: Vec<Region> = Vec::new();
    let mut place_of_root = vec![usize::MAX; runs.len()];
    for (index, run) in runs.iter().enumerate() {
        let root = run.parent as usize;
        if root == index {
            place_of_root[root] = list.len();
            let value = mask.pixels[run.row as usize * mask.width + run.start as usize];
            list.push(Region::empty(value));
        }
        list[place_of_root[root]].take(run.row, run.start, run.end);
    }
    let labels = keep(&mut list, limits);
    let mut image = RegionImage::filled(mask.width, mask.height, 0);
    for run in &runs {
        let label = labels[place_of_root[run.parent as usize]];
        if label > 0 {
            let row = run.row as usize * mask.width;
            image.pixels[row + run.start as usize..row + run.end as usize].fill(label);
        }
    }
    Regions { image, list }
}

/// One region for each value other than 0, in ascending order of the value; its pixels need not be connected.
pub fn instance_regions(instances: &LabelImage, limits: AreaLimits) -> Regions {
    let mut list: Vec<Region> = (0..=u8::MAX).map(Region::empty).collect();
    for_each_run(instances, |row, start, end, value| list[usize::from(value)].take(row, start, end));
    // Value 0 is the background; values that do not occur have no area.
    let labels = keep(&mut list, AreaLimits { min_px: limits.min_px.max(1), ..limits });
    let pixels = instances.pixels.iter().map(|&value| labels[usize::from(value)]).collect();
    Regions { image: RegionImage { width: instances.width, height: instances.height, pixels }, list }
}

impl Region {
    fn empty(value: u8) -> Self {
        Self { label: 0, value, area_px: 0, u_min: u32::MAX, u_max: 0, v_min: u32::MAX, v_max: 0 }
    }

    fn take(&mut self, row: u32, start: u32, end: u32) {
        self.area_px += end - start;
        self.u_min = self.u_min.min(start);
        self.u_max = self.u_max.max(end - 1);
        self.v_min = self.v_min.min(row);
        self.v_max = self.v_max.max(row);
    }
}

/// Removes regions outside the limits and numbers the rest; gives the label (0 = removed) of each former place.
fn keep(list: &mut Vec<Region>, limits: AreaLimits) -> Vec<u32> {
    let mut labels = Vec::with_capacity(list.len());
    let mut kept = 0;
    list.retain_mut(|region| {
        let keep = (limits.min_px..=limits.max_px).contains(&region.area_px);
        kept += u32::from(keep);
        region.label = if keep { kept } else { 0 };
        labels.push(region.label);
        keep
    });
    labels
}

/// Calls `visit(row, start, end, value)` for each run of equal values other than 0, in raster order.
fn for_each_run(image: &LabelImage, mut visit: impl FnMut(u32, u32, u32, u8)) {
    if image.width == 0 {
        return;
    }
    for (row, pixels) in image.pixels.chunks_exact(image.width).enumerate() {
        let mut start = 0;
        loop {
            start += equal_pixels(&pixels[start..], 0);
            let Some(&value) = pixels.get(start) else { break };
            let end = start + equal_pixels(&pixels[start..], value);
            visit(row as u32, start as u32, end as u32, value);
            start = end;
        }
    }
}

/// How many pixels from the first on have this value. Most of a mask is background: it is passed by in blocks, without a
/// question for each pixel.
fn equal_pixels(pixels: &[u8], value: u8) -> usize {
    let (blocks, _) = pixels.as_chunks::<32>();
    let differs =
        |block: &[u8; 32]| block.iter().fold(0, |differing, &pixel| differing | (pixel ^ value)) != 0;
    let passed = 32 * blocks.iter().take_while(|block| !differs(block)).count();
    passed + pixels[passed..].iter().take_while(|&&pixel| pixel == value).count()
}

/// First pass: all runs in raster order, each with a parent in the same region.
fn joined_runs(mask: &LabelImage) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    // Runs of the row above that may still touch: `above..above_end`.
    let (mut above, mut above_end, mut current_row) = (0, 0, 0);
    for_each_run(mask, |row, start, end, _| {
        let index = runs.len();
        if row != current_row {
            above = if row == current_row + 1 { above_end } else { index };
            above_end = index;
            current_row = row;
        }
        runs.push(Run { row, start, end, parent: index as u32 });
        // Runs of equal value that lie side by side are one region as well.
        if index > above_end && runs[index - 1].end == start {
            join(&mut runs, index - 1, index);
        }
        while above < above_end && runs[above].end < start {
            above += 1;
        }
        let mut touching = above;
        while touching < above_end && runs[touching].start <= end {
            join(&mut runs, touching, index);
            touching += 1;
        }
    });
    runs
}

/// The first run known of the region of `index`, halving the path on the way.
fn root(runs: &mut [Run], mut index: usize) -> usize {
    while runs[index].parent as usize != index {
        let grandparent = runs[runs[index].parent as usize].parent;
        runs[index].parent = grandparent;
        index = grandparent as usize;
    }
    index
}

/// Joins two regions under the earlier of their first runs.
fn join(runs: &mut [Run], a: usize, b: usize) {
    let (a, b) = (root(runs, a), root(runs, b));
    runs[a.max(b)].parent = a.min(b) as u32;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mask(rows: &[&str]) -> LabelImage {
        let pixels = rows.iter().flat_map(|row| row.bytes()).map(|c| if c == b'.' { 0 } else { c - b'0' });
        LabelImage { width: rows[0].len(), height: rows.len(), pixels: pixels.collect() }
    }

    fn drawn(regions: &Regions) -> Vec<String> {
        let digit = |&label: &u32| if label == 0 { '.' } else { char::from(b'0' + label as u8) };
        regions.image.pixels.chunks(regions.image.width).map(|row| row.iter().map(digit).collect()).collect()
    }

    /// Flood fill from each unlabelled pixel in raster order.
    fn flooded(mask: &LabelImage) -> RegionImage {
        let mut image = RegionImage::filled(mask.width, mask.height, 0);
        let mut label = 0;
        for v in 0..mask.height as i64 {
            for u in 0..mask.width as i64 {
                let mut stack = vec![(u, v)];
                let mut fresh = true;
                while let Some((u, v)) = stack.pop() {
                    if mask.get(u, v).is_some_and(|value| value != 0) && image.get(u, v) == Some(0) {
                        label += u32::from(std::mem::take(&mut fresh));
                        image.set(u, v, label);
                        stack.extend((-1..=1).flat_map(|dv| (-1..=1).map(move |du| (u + du, v + dv))));
                    }
                }
            }
        }
        image
    }

    #[test]
    fn diagonal_steps_and_late_joints_make_one_region() {
        let picture = mask(&["1..1..1.1", ".1.1.1..1", "..1....11", "1.....1..", "1.......1"]);
        let regions = connected_regions(&picture, AreaLimits::ALL);
        // The strokes from columns 0 and 3 meet in the third row; the one from column 6 stays apart.
        assert_eq!(drawn(&regions), ["1..1..2.3", ".1.1.2..3", "..1....33", "4.....3..", "4.......5"]);
    }

    #[test]
    fn agrees_with_flood_fill_on_random_masks_of_every_density() {
        let mut state = 7_u32;
        for density in 1..16 {
            for (width, height) in [(31, 17), (1, 20), (20, 1), (64, 5)] {
                let mut picture = LabelImage::filled(width, height, 0);
                for pixel in &mut picture.pixels {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    // Two values, so that runs of different value lie side by side.
                    *pixel = if (state >> 28) < density { 1 + ((state >> 20) & 1) as u8 } else { 0 };
                }
                let regions = connected_regions(&picture, AreaLimits::ALL);
                assert_eq!(regions.image, flooded(&picture));
                for region in &regions.list {
                    let pixels = (0..width * height).filter(|&i| regions.image.pixels[i] == region.label);
                    let places: Vec<_> = pixels.map(|i| ((i % width) as u32, (i / width) as u32)).collect();
                    assert_eq!(region.area_px as usize, places.len());
                    assert_eq!(Some(region.u_min), places.iter().map(|p| p.0).min());
                    assert_eq!(Some(region.u_max), places.iter().map(|p| p.0).max());
                    assert_eq!(Some(region.v_min), places.iter().map(|p| p.1).min());
                    assert_eq!(Some(region.v_max), places.iter().map(|p| p.1).max());
                }
            }
        }
    }

    #[test]
    fn area_limits_are_inclusive_and_labels_stay_dense() {
        let picture = mask(&["11.1.111", "........", "1111.1.1"]);
        let regions = connected_regions(&picture, AreaLimits { min_px: 2, max_px: 3 });
        assert_eq!(drawn(&regions), ["11...222", "........", "........"]);
        assert_eq!(
            regions.list.iter().map(|region| (region.label, region.area_px)).collect::<Vec<_>>(),
            [(1, 2), (2, 3)]
        );
    }

    #[test]
    fn instances_are_regions_by_value_connected_or_not() {
        let picture = mask(&["7.2.7", "77222", "3...."]);
        let regions = instance_regions(&picture, AreaLimits { min_px: 2, max_px: u32::MAX });
        assert_eq!(drawn(&regions), ["2.1.2", "22111", "....."]);
        assert_eq!(
            regions.list.iter().map(|region| (region.value, region.area_px)).collect::<Vec<_>>(),
            [(2, 4), (7, 4)]
        );
    }

    #[test]
    fn an_empty_image_has_no_regions() {
        for (width, height) in [(0, 0), (0, 3), (3, 0), (3, 3)] {
            let picture = LabelImage::filled(width, height, 0);
            assert!(connected_regions(&picture, AreaLimits::ALL).list.is_empty());
            assert!(instance_regions(&picture, AreaLimits::ALL).list.is_empty());
        }
    }
}
