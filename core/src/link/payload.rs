//! What the messages carry: plain numbers in fixed-width types, no references into either program.
//!
//! Lengths are millimetres in the camera's optical frame, as everywhere.

use serde::{Deserialize, Serialize};

use crate::{Covariance, Detection, Findings, Finish, OutlineRay, Point3, Refusal, Status};

/// Points in one [`CloudChunk`] at most: 960 bytes and the lengths before them stay below [`super::MAX_PAYLOAD`].
pub const CHUNK_POINTS: usize = 80;
/// Bytes of one point: x, y, z as little-endian `f32`.
pub const POINT_BYTES: usize = 12;
/// Rays in one [`OutlineChunk`] at most; as many bytes as a full [`CloudChunk`].
pub const CHUNK_RAYS: usize = 48;
/// Bytes of one outline ray: x, y, z of its inner point, depth behind, deviation as little-endian `f32`.
pub const RAY_BYTES: usize = 20;
/// Bytes of a full chunk of either kind.
pub const CHUNK_BYTES: usize = CHUNK_POINTS * POINT_BYTES;
const _: () = assert!(CHUNK_RAYS * RAY_BYTES == CHUNK_BYTES);
/// Outline rays a device has room for, 2.5 KiB of them. Thirty-two of a fruit are enough; where a region has more than
/// this they are to be thinned before they are sent.
pub const OUTLINE_CAPACITY: usize = 128;

/// Opens a session, whose number the frame's header carries; everything of an earlier session is forgotten.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// Largest payload the host takes, bytes.
    pub max_payload: u16,
}

/// What the device is and has room for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Welcome {
    /// Version of varsac-core: major, minor, patch.
    pub core_version: [u8; 3],
    /// Number of the board in the firmware's table of boards; 0 for the native simulation.
    pub board: u8,
    /// Largest payload the device takes, bytes.
    pub max_payload: u16,
    /// Points a cloud may have.
    pub capacity: u16,
    /// Outline rays it may come with.
    pub outline_capacity: u16,
}

/// Announces a cloud; the device forgets the one it had.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CloudBegin {
    /// Points that will follow.
    pub points: u16,
    /// How many of them, from the first, lie in the mask of fruit-coloured pixels; see [`crate::View`].
    pub in_mask: u16,
    /// Outline rays that will follow the points.
    pub outline_rays: u16,
    /// Angle between neighbouring points, rad; 0: not known.
    pub pitch_rad: f32,
}

/// Points of the cloud, in order, without gaps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CloudChunk<'a> {
    /// Index of the first of them.
    pub offset: u16,
    /// [`POINT_BYTES`] a point, at most [`CHUNK_POINTS`] points.
    #[serde(borrow)]
    pub points: &'a [u8],
}

impl<'a> CloudChunk<'a> {
    /// The points, read where they lie in the frame.
    pub fn iter(&self) -> impl Iterator<Item = Point3> + use<'a> {
        self.points.as_chunks::<POINT_BYTES>().0.iter().map(
            |&[x0, x1, x2, x3, y0, y1, y2, y3, z0, z1, z2, z3]| {
                Point3::new(
                    f32::from_le_bytes([x0, x1, x2, x3]),
                    f32::from_le_bytes([y0, y1, y2, y3]),
                    f32::from_le_bytes([z0, z1, z2, z3]),
                )
            },
        )
    }
}

/// Outline rays of the cloud, after its last point, in order, without gaps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct OutlineChunk<'a> {
    /// Index of the first of them.
    pub offset: u16,
    /// [`RAY_BYTES`] a ray, at most [`CHUNK_RAYS`] rays.
    #[serde(borrow)]
    pub rays: &'a [u8],
}

impl<'a> OutlineChunk<'a> {
    /// The rays, read where they lie in the frame.
    pub fn iter(&self) -> impl Iterator<Item = OutlineRay> + use<'a> {
        self.rays.as_chunks::<RAY_BYTES>().0.iter().map(|bytes| {
            let mut words = bytes.as_chunks::<4>().0.iter().map(|&word| f32::from_le_bytes(word));
            let mut next = || words.next().unwrap_or(0.0); // five words, always
            OutlineRay { inner: Point3::new(next(), next(), next()), outer_mm: next(), sigma_rad: next() }
        })
    }
}

/// Completes the cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct CloudEnd {
    /// CRC-32 (ISO-HDLC) over the bytes of all points, then of all outline rays, in order.
    pub checksum: u32,
}

/// Starts a search of the cloud that is there; it can be searched again with another seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Search {
    /// Seed of the random stream.
    pub seed: u64,
    /// Steps of the detector after which the search ends (a deadline in work, not in time); 0: no limit but the
    /// configuration's.
    pub step_budget: u32,
}

/// One fruit, accepted or refused, sent as soon as it is judged. What a robot needs to reach for it: lengths in
/// millimetres, angles in radians, the frame that of the cloud.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// 1, 2, ... in the order of detection.
    pub target: u8,
    /// Which test it failed, what was measured and what is allowed; none: accepted.
    pub refusal: Option<Refusal>,
    /// Centre, mm.
    pub centre_mm: [f32; 3],
    /// Semi-axes, longest first, mm.
    pub semi_axes_mm: [f32; 3],
    /// Row k is the unit vector of the k-th semi-axis.
    pub axes: [[f32; 3]; 3],
    /// Attitude, `w >= 0`.
    pub quaternion_xyzw: [f32; 4],
    /// Points that support it.
    pub inliers: u32,
    /// Points that could have.
    pub candidates: u32,
    /// Hypotheses that were tried for it.
    pub trials: u32,
    /// How sure: centre, mm; semi-axes, mm; attitude as a rotation vector, rad.
    pub covariance: Option<Covariance>,
    /// What the tests of acceptance looked at; of the default search only.
    pub findings: Option<Findings>,
}

impl From<&Detection> for Target {
    /// As it goes over the wire.
    fn from(detection: &Detection) -> Self {
        let ellipsoid = &detection.ellipsoid;
        Self {
            target: detection.target,
            refusal: match detection.status {
                Status::Accepted => None,
                Status::Refused(refusal) => Some(refusal),
            },
            centre_mm: ellipsoid.centre.coords.into(),
            semi_axes_mm: ellipsoid.semi_axes,
            axes: ellipsoid.axes,
            quaternion_xyzw: ellipsoid.quaternion_xyzw(),
            inliers: detection.score.inliers,
            candidates: detection.score.candidates,
            trials: detection.report.trials,
            covariance: detection.covariance,
            findings: detection.findings,
        }
    }
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ending {
    /// By its own stopping rule.
    Complete(Finish),
    /// By [`super::Message::Abort`].
    Aborted,
    /// By [`Search::step_budget`].
    BudgetSpent,
}

/// Kinds of rejection a [`Report`] has room for, more than there are today.
pub const REJECTIONS: usize = 16;
const _: () = assert!(crate::Rejection::COUNT <= REJECTIONS);

/// The end of a search; no target follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// Why it ended.
    pub ending: Ending,
    /// Targets that were sent.
    pub targets: u8,
    /// Hypotheses that were tried.
    pub trials: u32,
    /// Steps the detector took.
    pub steps: u32,
    /// Hypotheses that died, by number of [`crate::Rejection`].
    pub rejections: [u32; REJECTIONS],
    /// Deepest use of the stack since start, bytes; none where it is not measured.
    pub stack_bytes: Option<u32>,
}

/// A fault of the device itself.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Fault {
    /// What, by the firmware's numbering.
    pub code: u8,
    /// The offending value.
    pub value: u32,
}
