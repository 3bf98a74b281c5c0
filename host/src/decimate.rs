//! Thins a cloud to the capacity of the core: of `n` points, those at `floor(i n / capacity)`, i = 0, 1, ...
//!
//! Why an even stride over the input order, and not a random draw or a voxel grid: it needs no seed, no unit and no
//! cell size; it is exact in integers, hence the same on every machine; kept points are measured points, bit for bit;
//! their order stays, and with it the order of every later sum. Depth cameras and back-projection deliver points row
//! by row, so a stride keeps each region's share of the points and with it the density that neighbourhood radii and
//! inlier counts are tuned to; a voxel grid would level the density and average the noise away.
//!
//! Limit: where `n / capacity` is a simple fraction of the row length of a *gapless* organised cloud, the kept points
//! line up in columns (512 columns, stride 64: 8 of them). Clouds with gaps, as cameras deliver them, do not.

use std::fmt;

use varsac_core::Point3;

/// A cloud that fits the capacity, and where its points came from.
#[derive(Debug, Clone, PartialEq)]
pub struct Decimated {
    /// The points kept, in input order.
    pub points: Vec<Point3>,
    /// Their indices in the input, ascending: `points[k] == input[kept[k]]`.
    pub kept: Vec<usize>,
    /// Points in the input.
    pub input_count: usize,
}

impl Decimated {
    /// Whether any point was left out.
    pub fn is_thinned(&self) -> bool {
        self.kept.len() < self.input_count
    }
}

/// `kept 8192 of 20311 points`.
impl fmt::Display for Decimated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "kept {} of {} points", self.kept.len(), self.input_count)
    }
}

/// Keeps at most `capacity` evenly spaced points; all of them when there is room. `O(capacity)`.
///
/// ```
/// use varsac_core::Point3;
/// let cloud: Vec<Point3> = (0..10).map(|z| Point3::new(0.0, 0.0, z as f32)).collect();
/// let thinned = varsac_host::decimate::decimate(&cloud, 4);
/// assert_eq!(thinned.kept, [0, 2, 5, 7]);
/// assert_eq!(thinned.to_string(), "kept 4 of 10 points");
/// ```
pub fn decimate(points: &[Point3], capacity: usize) -> Decimated {
    let kept = evenly_spaced(points.len(), capacity);
    Decimated { points: kept.iter().map(|&index| points[index]).collect(), kept, input_count: points.len() }
}

/// The indices `floor(i count / capacity)` for i below `capacity`, or `0..count` when they all fit: strictly
/// ascending, gaps differ by at most one.
pub fn evenly_spaced(count: usize, capacity: usize) -> Vec<usize> {
    if count <= capacity {
        return (0..count).collect();
    }
    // u128: the product of two usize cannot overflow it.
    (0..capacity).map(|i| (i as u128 * count as u128 / capacity as u128) as usize).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_ascend_and_gaps_differ_by_at_most_one() {
        for (count, capacity) in [(20_311, 8192), (65_536, 65_535), (307_200, 8192), (3, 2), (1_000_000, 1)] {
            let kept = evenly_spaced(count, capacity);
            assert_eq!(kept.len(), capacity);
            assert_eq!(kept[0], 0);
            let mut gaps: Vec<usize> = kept.windows(2).map(|pair| pair[1] - pair[0]).collect();
            gaps.push(count - kept[capacity - 1]);
            let (least, most) = (gaps.iter().min().unwrap(), gaps.iter().max().unwrap());
            assert!(*least >= 1 && most - least <= 1, "{count} to {capacity}: gaps {least}..{most}");
        }
    }

    #[test]
    fn what_fits_is_kept_whole() {
        let cloud = [Point3::new(1.0, 2.0, 3.0), Point3::new(4.0, 5.0, 6.0)];
        for capacity in [2, 3, usize::MAX] {
            let whole = decimate(&cloud, capacity);
            assert_eq!((whole.points.as_slice(), whole.is_thinned()), (&cloud[..], false));
        }
        assert_eq!(decimate(&cloud, 0).kept, Vec::<usize>::new());
        assert_eq!(decimate(&[], 5).to_string(), "kept 0 of 0 points");
    }

    /// The claim above: each region of a camera image keeps its share.
    #[test]
    fn every_tile_of_an_image_keeps_its_share() {
        let (width, height, capacity) = (640, 480, 8192);
        let (tile_width, tile_height) = (64, 48);
        let mut kept_in_tile = [0_usize; 100];
        for index in evenly_spaced(width * height, capacity) {
            let (column, row) = (index % width, index / width);
            kept_in_tile[row / tile_height * 10 + column / tile_width] += 1;
        }
        // 81.92 expected; each of the 48 rows of a tile may round its 1.71 points up or down.
        for (tile, &kept) in kept_in_tile.iter().enumerate() {
            assert!((70..=94).contains(&kept), "tile {tile} keeps {kept}");
        }
    }
}
