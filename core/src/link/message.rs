//! What the two sides say to each other: plain data, no references into either program.
//!
//! A message is a type number in the frame's header and a postcard payload. Every message is answered by one
//! [`Answer`]: taken, or not taken and why. Lengths are millimetres in the camera's optical frame, as everywhere.

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::frame::{self, Header, TooLong};
use crate::Point3;

/// Type numbers, fixed for [`frame::VERSION`] 1.
pub mod kind {
    /// Host opens a session.
    pub const HELLO: u8 = 0x01;
    /// Device introduces itself in answer to Hello.
    pub const WELCOME: u8 = 0x02;
    /// Host announces a cloud.
    pub const CLOUD_BEGIN: u8 = 0x11;
    /// Some of its points.
    pub const CLOUD_CHUNK: u8 = 0x12;
    /// The cloud is complete.
    pub const CLOUD_END: u8 = 0x13;
    /// Host orders a search of the cloud.
    pub const SEARCH: u8 = 0x20;
    /// Host ends the search.
    pub const ABORT: u8 = 0x21;
    /// Host asks whether the device is still there.
    pub const POLL: u8 = 0x22;
    /// Device found one target.
    pub const TARGET: u8 = 0x30;
    /// Its covariance.
    pub const COVARIANCE: u8 = 0x31;
    /// Device ended the search.
    pub const REPORT: u8 = 0x32;
    /// Device tells of a fault that no message of the host caused.
    pub const FAULT: u8 = 0x3F;
    /// Answer: taken.
    pub const ACK: u8 = 0x7E;
    /// Answer: not taken.
    pub const NACK: u8 = 0x7F;
}

/// Points in one [`CloudChunk`] at most: 960 bytes and the lengths before them stay below [`frame::MAX_PAYLOAD`].
pub const CHUNK_POINTS: usize = 80;
/// Bytes of one point: x, y, z as little-endian `f32`.
pub const POINT_BYTES: usize = 12;

/// One message, borrowed from the frame it came in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Message<'a> {
    /// See [`Hello`].
    Hello(Hello),
    /// See [`Welcome`].
    Welcome(Welcome),
    /// See [`CloudBegin`].
    CloudBegin(CloudBegin),
    /// See [`CloudChunk`].
    CloudChunk(CloudChunk<'a>),
    /// See [`CloudEnd`].
    CloudEnd(CloudEnd),
    /// See [`Search`].
    Search(Search),
    /// Ends the running search; its [`Report`] follows. Without a search: nothing happens.
    Abort,
    /// Means nothing; the answer shows that the device lives and knows the session.
    Poll,
    /// See [`Target`].
    Target(Target),
    /// See [`Covariance`].
    Covariance(Covariance),
    /// See [`Report`].
    Report(Report),
    /// See [`Fault`].
    Fault(Fault),
}

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
    /// 0, 1, ... in the order of detection.
    pub index: u16,
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
}

/// Uncertainty of the target before it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Covariance {
    /// [`Target::index`].
    pub index: u16,
    /// Lower triangle of the 9x9 matrix by rows, cut into nine runs of five.
    pub packed: [[f32; 5]; 9],
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Ending {
    /// By its own stopping rule.
    Complete,
    /// By [`Message::Abort`].
    Aborted,
    /// By [`Search::step_budget`].
    BudgetSpent,
}

/// Kinds of rejection a [`Report`] has room for.
pub const REJECTIONS: usize = 16;

/// The end of a search; no target follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// Why it ended.
    pub ending: Ending,
    /// Targets that were sent.
    pub targets: u16,
    /// Hypotheses that were tried.
    pub trials: u32,
    /// Steps the detector took.
    pub steps: u32,
    /// Hypotheses that died, by reason.
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

/// Why a message was not taken. The session goes on, but for [`Reason::NoSession`] and [`Reason::Version`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reason {
    /// The device knows no such session: it was restarted, or another host took over. Say Hello again.
    NoSession,
    /// The versions differ. Detail: the version of the side that says so.
    Version,
    /// The type is unknown or the payload is not one of its type.
    Malformed,
    /// A search is running: wait for its report or abort it.
    Busy,
    /// This message has no place here (a chunk without a begin, a search without a cloud).
    Order,
    /// The chunk does not continue the cloud. Detail: the offset expected.
    Offset,
    /// The cloud is larger than the memory. Detail: the capacity in points.
    Capacity,
    /// The cloud's checksum is wrong. Detail: the checksum found.
    Checksum,
    /// A coordinate is not finite or too large. Detail: the index of the point.
    Coordinate,
    /// A value of the configuration is out of range.
    Configuration,
}

/// The answer "not taken".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Nack {
    /// Why.
    pub reason: Reason,
    /// What the reason says it is; 0 where it says nothing.
    pub detail: u32,
}

/// Every message gets one.
pub type Answer = Result<(), Nack>;

impl Reason {
    /// The answer with this reason.
    pub const fn nack(self, detail: u32) -> Nack {
        Nack { reason: self, detail }
    }
}

impl<'a> Message<'a> {
    /// Its type number.
    pub const fn kind(&self) -> u8 {
        match self {
            Self::Hello(_) => kind::HELLO,
            Self::Welcome(_) => kind::WELCOME,
            Self::CloudBegin(_) => kind::CLOUD_BEGIN,
            Self::CloudChunk(_) => kind::CLOUD_CHUNK,
            Self::CloudEnd(_) => kind::CLOUD_END,
            Self::Search(_) => kind::SEARCH,
            Self::Abort => kind::ABORT,
            Self::Poll => kind::POLL,
            Self::Target(_) => kind::TARGET,
            Self::Covariance(_) => kind::COVARIANCE,
            Self::Report(_) => kind::REPORT,
            Self::Fault(_) => kind::FAULT,
        }
    }

    /// Writes the message as one frame; returns its length on the wire.
    ///
    /// # Errors
    /// [`TooLong`], see [`frame::encode`].
    pub fn encode(&self, sequence: u16, session: u32, wire: &mut [u8]) -> Result<usize, TooLong> {
        let header = Header { version: frame::VERSION, kind: self.kind(), sequence, session };
        match self {
            Self::Hello(payload) => frame::encode(&header, payload, wire),
            Self::Welcome(payload) => frame::encode(&header, payload, wire),
            Self::CloudBegin(payload) => frame::encode(&header, payload, wire),
            Self::CloudChunk(payload) => frame::encode(&header, payload, wire),
            Self::CloudEnd(payload) => frame::encode(&header, payload, wire),
            Self::Search(payload) => frame::encode(&header, payload, wire),
            Self::Abort | Self::Poll => frame::encode(&header, &(), wire),
            Self::Target(payload) => frame::encode(&header, payload, wire),
            Self::Covariance(payload) => frame::encode(&header, payload, wire),
            Self::Report(payload) => frame::encode(&header, payload, wire),
            Self::Fault(payload) => frame::encode(&header, payload, wire),
        }
    }

    /// Reads a payload. None when the type is no message's or the payload is not exactly one of that type.
    pub fn decode(kind: u8, payload: &'a [u8]) -> Option<Self> {
        Some(match kind {
            kind::HELLO => Self::Hello(exactly(payload)?),
            kind::WELCOME => Self::Welcome(exactly(payload)?),
            kind::CLOUD_BEGIN => Self::CloudBegin(exactly(payload)?),
            kind::CLOUD_CHUNK => {
                let (chunk, []) = postcard::take_from_bytes::<CloudChunk<'a>>(payload).ok()? else {
                    return None;
                };
                let whole = chunk.points.len().is_multiple_of(POINT_BYTES);
                let fits = chunk.points.len() <= CHUNK_POINTS * POINT_BYTES;
                if !whole || !fits {
                    return None;
                }
                Self::CloudChunk(chunk)
            }
            kind::CLOUD_END => Self::CloudEnd(exactly(payload)?),
            kind::SEARCH => Self::Search(exactly(payload)?),
            kind::ABORT if payload.is_empty() => Self::Abort,
            kind::POLL if payload.is_empty() => Self::Poll,
            kind::TARGET => Self::Target(exactly(payload)?),
            kind::COVARIANCE => Self::Covariance(exactly(payload)?),
            kind::REPORT => Self::Report(exactly(payload)?),
            kind::FAULT => Self::Fault(exactly(payload)?),
            _ => return None,
        })
    }
}

/// A payload with nothing behind it.
pub(super) fn exactly<T: DeserializeOwned>(payload: &[u8]) -> Option<T> {
    match postcard::take_from_bytes(payload) {
        Ok((value, [])) => Some(value),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::frame::{MAX_PAYLOAD, MAX_WIRE};
    use super::super::receiver::FrameReceiver;
    use super::*;

    const POINTS: [u8; CHUNK_POINTS * POINT_BYTES] = [0xFF; CHUNK_POINTS * POINT_BYTES];

    /// One of each, with the values that take the most room.
    fn largest() -> [Message<'static>; 12] {
        [
            Message::Hello(Hello { max_payload: u16::MAX }),
            Message::Welcome(Welcome {
                core_version: [255; 3],
                board: 255,
                max_payload: u16::MAX,
                capacity: u16::MAX,
            }),
            Message::CloudBegin(CloudBegin { points: u16::MAX }),
            Message::CloudChunk(CloudChunk { offset: u16::MAX, points: &POINTS }),
            Message::CloudEnd(CloudEnd { checksum: u32::MAX }),
            Message::Search(Search { seed: u64::MAX, step_budget: u32::MAX }),
            Message::Abort,
            Message::Poll,
            Message::Target(Target {
                index: u16::MAX,
                refusal: Some(TargetRefusal { code: 255, value: 1.0, limit: -1.0 }),
                centre_mm: [1.0, -2.0, 700.0],
                semi_axes_mm: [22.0, 11.0, 11.0],
                axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
                inliers: u32::MAX,
                candidates: u32::MAX,
                trials: u32::MAX,
            }),
            Message::Covariance(Covariance { index: u16::MAX, packed: [[0.5; 5]; 9] }),
            Message::Report(Report {
                ending: Ending::BudgetSpent,
                targets: u16::MAX,
                trials: u32::MAX,
                steps: u32::MAX,
                rejections: [u32::MAX; REJECTIONS],
                stack_bytes: Some(u32::MAX),
            }),
            Message::Fault(Fault { code: 255, value: u32::MAX }),
        ]
    }

    #[test]
    fn every_message_fits_into_a_frame_and_comes_back() {
        let mut wire = [0; MAX_WIRE];
        let mut receiver = FrameReceiver::new();
        for message in largest() {
            let used = message.encode(9, 77, &mut wire).unwrap();
            let mut found = false;
            for &byte in &wire[..used] {
                if let Some(frame) = receiver.push(byte) {
                    assert_eq!((frame.header.sequence, frame.header.session), (9, 77));
                    assert_eq!(Message::decode(frame.header.kind, frame.payload), Some(message));
                    found = true;
                }
            }
            assert!(found, "{message:?}");
        }
    }

    #[test]
    fn a_payload_must_be_exact() {
        let mut content = [0; MAX_PAYLOAD + 1];
        for message in largest() {
            let payload = match &message {
                Message::Abort | Message::Poll => 0,
                Message::Hello(m) => postcard::to_slice(m, &mut content).unwrap().len(),
                Message::CloudChunk(m) => postcard::to_slice(m, &mut content).unwrap().len(),
                Message::Target(m) => postcard::to_slice(m, &mut content).unwrap().len(),
                Message::Report(m) => postcard::to_slice(m, &mut content).unwrap().len(),
                _ => continue,
            };
            let kind = message.kind();
            assert!(Message::decode(kind, &content[..payload]).is_some());
            assert_eq!(Message::decode(kind, &content[..=payload]), None, "a byte too many: {message:?}");
            for short in 0..payload {
                assert_eq!(Message::decode(kind, &content[..short]), None, "{short} bytes of {message:?}");
            }
        }
        for kind in [0, 0x10, kind::ACK, kind::NACK, 0xFF] {
            assert_eq!(Message::decode(kind, &[]), None);
        }
    }

    #[test]
    fn a_chunk_holds_whole_points_and_not_too_many() {
        let mut content = [0; MAX_PAYLOAD];
        let too_many = [0; (CHUNK_POINTS + 1) * POINT_BYTES];
        for (points, allowed) in [(&POINTS[..24], true), (&POINTS[..23], false), (&too_many[..], false)] {
            let payload = postcard::to_slice(&CloudChunk { offset: 0, points }, &mut content).unwrap();
            assert_eq!(Message::decode(kind::CLOUD_CHUNK, payload).is_some(), allowed);
        }
    }
}
