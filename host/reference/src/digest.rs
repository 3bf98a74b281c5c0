//! One number for all bits of a result, so that builds and machines can be compared at a glance.

use crate::{Detection, Run};

/// FNV-1a with 64 bits (Fowler, Noll and Vo).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fnv1a(u64);

impl Fnv1a {
    /// The hash of nothing.
    pub fn new() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }

    /// Takes the bytes in, one after the other.
    pub fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 ^= u64::from(byte);
            self.0 = self.0.wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// The hash of everything written so far.
    pub fn finish(self) -> u64 {
        self.0
    }
}

impl Default for Fnv1a {
    fn default() -> Self {
        Self::new()
    }
}

/// The digest of a result: FNV-1a over the little-endian bytes of, for each detection in order, target (1 byte),
/// centre (3 f32), semi-axes (3 f32), axes by rows (9 f32), quaternion x y z w (4 f32), angles x y z (3 f32),
/// inliers, candidates and trials (u32 each); then the label of every point (1 byte each).
pub fn digest(run: &Run) -> u64 {
    let mut hash = Fnv1a::new();
    for Detection { target, ellipsoid, score, report, .. } in &run.detections {
        hash.write(&[*target]);
        let mut numbers = Vec::new();
        numbers.extend_from_slice(&ellipsoid.centre);
        numbers.extend_from_slice(&ellipsoid.semi_axes);
        for axis in &ellipsoid.axes {
            numbers.extend_from_slice(axis);
        }
        numbers.extend_from_slice(&ellipsoid.quaternion);
        numbers.extend_from_slice(&ellipsoid.angles);
        for number in numbers {
            hash.write(&number.to_bits().to_le_bytes());
        }
        for count in [score.inliers, score.candidates, report.trials] {
            hash.write(&count.to_le_bytes());
        }
    }
    hash.write(&run.labels);
    hash.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Finish;

    #[test]
    fn the_published_hashes_come_out() {
        for (text, expected) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut hash = Fnv1a::new();
            hash.write(text.as_bytes());
            assert_eq!(hash.finish(), expected);
        }
    }

    #[test]
    fn a_run_without_targets_is_the_hash_of_its_labels() {
        let run = Run { detections: Vec::new(), labels: vec![b'f'; 3], finish: Finish::Failures };
        let mut hash = Fnv1a::new();
        hash.write(b"fff");
        assert_eq!(digest(&run), hash.finish());
    }
}
