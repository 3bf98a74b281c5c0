//! Points, the fixed-capacity point buffer and the check at the door.
//!
//! Unit: millimetres everywhere in the product (the mathematics does not care). Frame: camera optical frame,
//! x right, y down, z forward, origin at the centre of projection.

use heapless::Vec;

/// A point of the cloud: three `f32`, millimetres, camera optical frame.
pub type Point3 = nalgebra::Point3<f32>;

/// A direction or a difference of two points.
pub type Vector3 = nalgebra::Vector3<f32>;

/// A cloud with room for `N` points in place: 12 bytes a point, no heap.
///
/// ```
/// use varsac_core::{Point3, PointBuffer};
/// let mut cloud: PointBuffer<4> = PointBuffer::new();
/// cloud.push(Point3::new(1.0, 2.0, 700.0)).unwrap();
/// assert_eq!(cloud.as_slice().len(), 1);
/// ```
pub type PointBuffer<const N: usize> = Vec<Point3, N>;

/// The largest number of points a cloud may have: indices are `u16`.
pub const MAX_POINTS: usize = 65_535;

/// Largest magnitude a coordinate may have. Beyond it the squares and products of the squares that the fit forms
/// in its local frame would leave the range of `f32`. A kilometre in millimetres is 1e6, so nothing real is refused.
pub const MAX_COORDINATE: f32 = 1.0e9;

/// Why a cloud is refused before any work is done.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum CloudError {
    /// A coordinate is NaN, infinite or larger than [`MAX_COORDINATE`].
    Coordinate {
        /// Index of the first such point.
        index: u32,
        /// 0 = x, 1 = y, 2 = z.
        axis: u8,
        /// The offending value.
        value: f32,
    },
    /// The cloud has more points than the workspace (or than `u16` indices) can hold.
    TooManyPoints {
        /// Points in the cloud.
        count: u32,
        /// Points there is room for.
        capacity: u32,
    },
    /// The view has more outline rays than [`MAX_OUTLINE`](crate::MAX_OUTLINE).
    TooManyRays {
        /// Rays in the view.
        count: u32,
    },
}

impl core::fmt::Display for CloudError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Coordinate { index, axis, value } => {
                let name = match axis {
                    0 => 'x',
                    1 => 'y',
                    _ => 'z',
                };
                write!(
                    f,
                    "point {index}: {name} is {value}; coordinates must be finite and within +-{MAX_COORDINATE:e}"
                )
            }
            Self::TooManyRays { count } => {
                write!(f, "the view has {count} outline rays; thin them to {} or fewer", crate::MAX_OUTLINE)
            }
            Self::TooManyPoints { count, capacity } => {
                write!(
                    f,
                    "the cloud has {count} points and the workspace holds {capacity}; decimate it or enlarge the workspace"
                )
            }
        }
    }
}

impl core::error::Error for CloudError {}

/// Checks every coordinate and the number of points. `O(n)`.
///
/// # Errors
/// The first offending point, or the count when there are more than `capacity`.
pub fn check_cloud(cloud: &[Point3], capacity: usize) -> Result<(), CloudError> {
    let capacity = capacity.min(MAX_POINTS);
    if cloud.len() > capacity {
        return Err(CloudError::TooManyPoints { count: cloud.len() as u32, capacity: capacity as u32 });
    }
    for (index, point) in cloud.iter().enumerate() {
        for (axis, value) in [point.x, point.y, point.z].into_iter().enumerate() {
            // Written so that NaN fails it too.
            if !(-MAX_COORDINATE..=MAX_COORDINATE).contains(&value) {
                return Err(CloudError::Coordinate { index: index as u32, axis: axis as u8, value });
            }
        }
    }
    Ok(())
}

/// The point with this index. Index lists are built by this crate and are always in range; the origin stands in for
/// an index that is not, so that no panic can be reached.
#[inline(always)]
pub(crate) fn at(cloud: &[Point3], index: u16) -> Point3 {
    cloud.get(usize::from(index)).copied().unwrap_or(Point3::new(0.0, 0.0, 0.0))
}

/// Squared distance, summed x, y, z. Rounding is monotone, which the k-d tree's pruning relies on.
#[inline]
pub fn distance_squared(a: &Point3, b: &Point3) -> f32 {
    let (dx, dy, dz) = (a.x - b.x, a.y - b.y, a.z - b.z);
    dx * dx + dy * dy + dz * dz
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bad_coordinate_is_named_with_its_index() {
        let mut cloud = [Point3::new(0.0, 0.0, 1.0); 5];
        assert_eq!(check_cloud(&cloud, 5), Ok(()));
        cloud[3].y = f32::INFINITY;
        assert_eq!(
            check_cloud(&cloud, 5),
            Err(CloudError::Coordinate { index: 3, axis: 1, value: f32::INFINITY })
        );
        cloud[1].z = f32::NAN;
        assert!(
            matches!(check_cloud(&cloud, 5), Err(CloudError::Coordinate { index: 1, axis: 2, value }) if value.is_nan())
        );
    }

    #[test]
    fn one_point_too_many_is_an_error() {
        let cloud = [Point3::origin(); 5];
        assert_eq!(check_cloud(&cloud, 4), Err(CloudError::TooManyPoints { count: 5, capacity: 4 }));
    }
}
