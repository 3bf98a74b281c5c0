//! What the messages carry: plain numbers in fixed-width types, no references into either program.
//!
//! Lengths are millimetres in the camera's optical frame, as everywhere.

use serde::{Deserialize, Serialize};

use crate::{Detection, Finish, Point3};

/// Points in one [`CloudChunk`] at most: 960 bytes and the lengths before them stay below [`super::MAX_PAYLOAD`].
pub const CHUNK_POINTS: usize = 80;
/// Bytes of one point: x, y, z as little-endian `f32`.
pub const POINT_BYTES: usize = 12;

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
}

/// Announces a cloud; the device forgets the one it had.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct CloudBegin {
    /// Points that will follow.
    pub points: u16,
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

/// Completes the cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct CloudEnd {
    /// CRC-32 (ISO-HDLC) over the bytes of all points in order.
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

/// Why a target is refused: what was measured and what was allowed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TargetRefusal {
    /// Which test.
    pub code: u8,
    /// What it measured.
    pub value: f32,
    /// What it allows.
    pub limit: f32,
}

/// One fruit, sent as soon as it is found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// 1, 2, ... in the order of detection.
    pub target: u8,
    /// Why it is refused, if it is.
    pub refusal: Option<TargetRefusal>,
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
    /// Lower triangle of the 9x9 covariance by rows, cut into nine runs of five.
    pub covariance: Option<[[f32; 5]; 9]>,
}

impl From<&Detection> for Target {
    /// As it goes over the wire. The paper's search neither refuses nor knows how sure it is: both are none.
    fn from(detection: &Detection) -> Self {
        let ellipsoid = &detection.ellipsoid;
        Self {
            target: detection.target,
            refusal: None,
            centre_mm: ellipsoid.centre.coords.into(),
            semi_axes_mm: ellipsoid.semi_axes,
            axes: ellipsoid.axes,
            quaternion_xyzw: ellipsoid.quaternion_xyzw(),
            inliers: detection.score.inliers,
            candidates: detection.score.candidates,
            trials: detection.report.trials,
            covariance: None,
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
