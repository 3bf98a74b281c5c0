//! Clouds on their way out: binary PLY, points coloured by the fruit they belong to.
//!
//! One element `vertex` with `float x y z` (millimetres), `uchar red green blue` and `int target`: the number of the
//! target that the point belongs to, 0 for none. MeshLab, CloudCompare and Open3D read it.

use std::io::Write as _;
use std::path::Path;

use crate::draw::colour_of;
use crate::error::{InputError, write_whole};

/// The file's bytes. `targets[k]` is the number of the target of point k; a missing entry counts as 0.
pub fn ply_bytes(points: &[[f32; 3]], targets: &[u32]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(300 + 19 * points.len());
    // Writing to memory does not fail.
    let _ = write!(
        bytes,
        "ply\nformat binary_little_endian 1.0\ncomment millimetres; target 0 = none\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\n\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty int target\nend_header\n",
        points.len()
    );
    for (index, point) in points.iter().enumerate() {
        let target = targets.get(index).copied().unwrap_or(0);
        for coordinate in point {
            bytes.extend(coordinate.to_le_bytes());
        }
        bytes.extend(colour_of(target));
        bytes.extend((target as i32).to_le_bytes());
    }
    bytes
}

/// Writes the cloud, whole or not at all.
///
/// # Errors
/// When the file cannot be written.
pub fn write_ply(path: &Path, points: &[[f32; 3]], targets: &[u32]) -> Result<(), InputError> {
    write_whole(path, &ply_bytes(points, targets))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bytes_are_what_the_header_says() {
        let bytes = ply_bytes(&[[1.0, -2.5, 700.0], [0.0, 0.25, 701.0]], &[2]);
        let header_end = bytes.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
        let header = std::str::from_utf8(&bytes[..header_end]).unwrap();
        assert!(header.contains("element vertex 2\n"), "{header}");
        let records: Vec<&[u8]> = bytes[header_end..].chunks(19).collect();
        assert_eq!(records.len(), 2);
        assert_eq!(records[0][..12], [1.0_f32, -2.5, 700.0].map(f32::to_le_bytes).concat());
        assert_eq!(records[0][12..15], colour_of(2));
        assert_eq!(records[0][15..], 2_i32.to_le_bytes());
        assert_eq!(records[1][12..15], colour_of(0));
        assert_eq!(records[1][15..], [0; 4]);
    }

    #[test]
    fn an_unwritable_place_is_named_and_nothing_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_ply(&folder.path().join("no/such/folder.ply"), &[], &[]).unwrap_err();
        assert!(error.to_string().contains("no/such/folder.ply"), "{error}");
        write_ply(&folder.path().join("empty.ply"), &[], &[]).unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
