//! What the two sides say to each other, and the answers to it.
//!
//! A message is a type number in the frame's header and a postcard payload (see [`super::payload`]). Every message is
//! answered by one [`Answer`]: taken, or not taken and why.

use serde::{Deserialize, Serialize};

use super::frame::{self, Header, TooLong};
use super::payload::{
    CHUNK_BYTES, CloudBegin, CloudChunk, CloudEnd, Fault, Hello, OutlineChunk, POINT_BYTES, RAY_BYTES,
    Report, Search, Target, Welcome,
};
use crate::Config;

/// Type numbers, fixed for [`frame::VERSION`] 2.
pub mod kind {
    /// Host opens a session.
    pub const HELLO: u8 = 0x01;
    /// Device introduces itself in answer to Hello.
    pub const WELCOME: u8 = 0x02;
    /// Host sets the configuration of the searches that follow.
    pub const CONFIGURE: u8 = 0x10;
    /// Host announces a cloud.
    pub const CLOUD_BEGIN: u8 = 0x11;
    /// Some of its points.
    pub const CLOUD_CHUNK: u8 = 0x12;
    /// The cloud is complete.
    pub const CLOUD_END: u8 = 0x13;
    /// Some of its outline rays.
    pub const OUTLINE_CHUNK: u8 = 0x14;
    /// Host orders a search of the cloud.
    pub const SEARCH: u8 = 0x20;
    /// Host ends the search.
    pub const ABORT: u8 = 0x21;
    /// Host asks whether the device is still there.
    pub const POLL: u8 = 0x22;
    /// Device found one target.
    pub const TARGET: u8 = 0x30;
    /// Device ended the search.
    pub const REPORT: u8 = 0x31;
    /// Device tells of a fault that no message of the host caused.
    pub const FAULT: u8 = 0x3F;
    /// Answer: taken.
    pub const ACK: u8 = 0x7E;
    /// Answer: not taken.
    pub const NACK: u8 = 0x7F;
}

/// One message, borrowed from the frame it came in.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "no heap to box into; it lives for the length of one call")]
pub enum Message<'a> {
    /// See [`Hello`].
    Hello(Hello),
    /// See [`Welcome`].
    Welcome(Welcome),
    /// Sets the configuration of the searches that follow, until the session ends.
    Configure(Config),
    /// See [`CloudBegin`].
    CloudBegin(CloudBegin),
    /// See [`CloudChunk`].
    CloudChunk(CloudChunk<'a>),
    /// See [`OutlineChunk`].
    OutlineChunk(OutlineChunk<'a>),
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
    /// See [`Report`].
    Report(Report),
    /// See [`Fault`].
    Fault(Fault),
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
    /// The cloud is larger than the memory. Detail: the capacity in points, or where the points fit, in outline rays.
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
            Self::Configure(_) => kind::CONFIGURE,
            Self::CloudBegin(_) => kind::CLOUD_BEGIN,
            Self::CloudChunk(_) => kind::CLOUD_CHUNK,
            Self::OutlineChunk(_) => kind::OUTLINE_CHUNK,
            Self::CloudEnd(_) => kind::CLOUD_END,
            Self::Search(_) => kind::SEARCH,
            Self::Abort => kind::ABORT,
            Self::Poll => kind::POLL,
            Self::Target(_) => kind::TARGET,
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
            Self::Configure(payload) => frame::encode(&header, payload, wire),
            Self::CloudBegin(payload) => frame::encode(&header, payload, wire),
            Self::CloudChunk(payload) => frame::encode(&header, payload, wire),
            Self::OutlineChunk(payload) => frame::encode(&header, payload, wire),
            Self::CloudEnd(payload) => frame::encode(&header, payload, wire),
            Self::Search(payload) => frame::encode(&header, payload, wire),
            Self::Abort | Self::Poll => frame::encode(&header, &(), wire),
            Self::Target(payload) => frame::encode(&header, payload, wire),
            Self::Report(payload) => frame::encode(&header, payload, wire),
            Self::Fault(payload) => frame::encode(&header, payload, wire),
        }
    }

    /// Reads a payload. None when the type is no message's or the payload is not exactly one of that type.
    pub fn decode(kind: u8, payload: &'a [u8]) -> Option<Self> {
        Some(match kind {
            kind::HELLO => Self::Hello(exactly(payload)?),
            kind::WELCOME => Self::Welcome(exactly(payload)?),
            kind::CONFIGURE => Self::Configure(exactly(payload)?),
            kind::CLOUD_BEGIN => {
                let begin: CloudBegin = exactly(payload)?;
                (begin.in_mask <= begin.points).then_some(Self::CloudBegin(begin))?
            }
            kind::CLOUD_CHUNK => {
                let chunk: CloudChunk<'a> = exactly(payload)?;
                is_chunk(chunk.points, POINT_BYTES).then_some(Self::CloudChunk(chunk))?
            }
            kind::OUTLINE_CHUNK => {
                let chunk: OutlineChunk<'a> = exactly(payload)?;
                is_chunk(chunk.rays, RAY_BYTES).then_some(Self::OutlineChunk(chunk))?
            }
            kind::CLOUD_END => Self::CloudEnd(exactly(payload)?),
            kind::SEARCH => Self::Search(exactly(payload)?),
            kind::ABORT if payload.is_empty() => Self::Abort,
            kind::POLL if payload.is_empty() => Self::Poll,
            kind::TARGET => Self::Target(exactly(payload)?),
            kind::REPORT => Self::Report(exactly(payload)?),
            kind::FAULT => Self::Fault(exactly(payload)?),
            _ => return None,
        })
    }
}

/// A payload with nothing behind it.
pub(super) fn exactly<'a, T: Deserialize<'a>>(payload: &'a [u8]) -> Option<T> {
    match postcard::take_from_bytes(payload) {
        Ok((value, [])) => Some(value),
        _ => None,
    }
}

/// Whole items, and not more than a chunk holds.
fn is_chunk(bytes: &[u8], item: usize) -> bool {
    bytes.len().is_multiple_of(item) && bytes.len() <= CHUNK_BYTES
}

#[cfg(test)]
mod tests {
    use super::super::frame::{MAX_PAYLOAD, MAX_WIRE};
    use super::super::payload::{Ending, REJECTIONS};
    use super::super::receiver::FrameReceiver;
    use super::*;
    use crate::{
        Findings, Finish, Gate, Inflation, MapConfig, Method, Noise, Refusal, RefusalCode, SizePrior,
        Viewpoint,
        mixture::{MixtureConfig, MixtureGate},
    };

    const FULL: [u8; CHUNK_BYTES] = [0xFF; CHUNK_BYTES];

    const FINDINGS: Findings = Findings {
        explained: u16::MAX,
        through: u16::MAX,
        size_conflict: 1.0,
        end_on: 0.5,
        size_sigma: 0.1,
        rival: 0.5,
        outline_rays: u16::MAX,
        outline: 0.5,
        visible: 0.9,
        colour: 0.1,
        sigma_mm: 0.5,
        flat: 3.0,
        separation: f32::INFINITY,
        clutter: 0.1,
    };

    /// One of each, with the values that take the most room.
    fn largest() -> [Message<'static>; 13] {
        [
            Message::Hello(Hello { max_payload: u16::MAX }),
            Message::Welcome(Welcome {
                core_version: [255; 3],
                board: 255,
                max_payload: u16::MAX,
                capacity: u16::MAX,
                outline_capacity: u16::MAX,
            }),
            Message::Configure(Config {
                sample_sizes: core::iter::repeat_n(32, crate::MAX_SIZES).collect(),
                max_trials: u32::MAX,
                min_inliers: u16::MAX,
                map: MapConfig { hypotheses: u16::MAX, ..Config::jujube().map },
                mixture: MixtureConfig { sample: u16::MAX, ..MixtureConfig::VIEW },
                ..Config::jujube()
            }),
            Message::CloudBegin(CloudBegin {
                points: u16::MAX,
                in_mask: u16::MAX,
                outline_rays: u16::MAX,
                pitch_rad: 0.01,
            }),
            Message::CloudChunk(CloudChunk { offset: u16::MAX, points: &FULL }),
            Message::OutlineChunk(OutlineChunk { offset: u16::MAX, rays: &FULL }),
            Message::CloudEnd(CloudEnd { checksum: u32::MAX }),
            Message::Search(Search { seed: u64::MAX, step_budget: u32::MAX }),
            Message::Abort,
            Message::Poll,
            Message::Target(Target {
                target: u8::MAX,
                refusal: Some(Refusal { code: RefusalCode::Vague, value: 1.0, limit: -1.0 }),
                centre_mm: [1.0, -2.0, 700.0],
                semi_axes_mm: [22.0, 11.0, 11.0],
                axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
                inliers: u32::MAX,
                candidates: u32::MAX,
                trials: u32::MAX,
                covariance: exactly(&[0x3E; 180]),
                findings: Some(FINDINGS),
            }),
            Message::Report(Report {
                ending: Ending::Complete(Finish::Failures),
                targets: u8::MAX,
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
                    assert_eq!(Message::decode(frame.header.kind, frame.payload), Some(message.clone()));
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
                Message::Configure(m) => postcard::to_slice(m, &mut content).unwrap().len(),
                Message::Abort | Message::Poll => 0,
                Message::Hello(m) => postcard::to_slice(m, &mut content).unwrap().len(),
                Message::CloudChunk(m) => postcard::to_slice(m, &mut content).unwrap().len(),
                Message::OutlineChunk(m) => postcard::to_slice(m, &mut content).unwrap().len(),
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
    fn a_chunk_holds_whole_items_and_not_too_many() {
        let mut content = [0; MAX_PAYLOAD];
        for (kind, item) in [(kind::CLOUD_CHUNK, POINT_BYTES), (kind::OUTLINE_CHUNK, RAY_BYTES)] {
            let too_many = [0; CHUNK_BYTES + RAY_BYTES];
            let too_many = &too_many[..CHUNK_BYTES + item];
            for (points, allowed) in [
                (&FULL[..], true),
                (&FULL[..2 * item], true),
                (&FULL[..2 * item - 1], false),
                (too_many, false),
            ] {
                let payload = postcard::to_slice(&CloudChunk { offset: 0, points }, &mut content).unwrap();
                assert_eq!(Message::decode(kind, payload).is_some(), allowed, "{} bytes", points.len());
            }
        }
    }

    #[test]
    fn a_mask_is_part_of_its_cloud() {
        let mut content = [0; 16];
        for (in_mask, allowed) in [(0, true), (7, true), (8, false)] {
            let begin = CloudBegin { points: 7, in_mask, outline_rays: 0, pitch_rad: 0.0 };
            let payload = postcard::to_slice(&begin, &mut content).unwrap();
            assert_eq!(Message::decode(kind::CLOUD_BEGIN, payload).is_some(), allowed);
        }
    }

    /// The payload of Configure follows the fields of [`Config`]: whoever changes those changes the wire.
    #[test]
    fn the_bytes_of_a_configuration_belong_to_this_version() {
        let mut content = [0; MAX_PAYLOAD];
        // The printed values of Table 5 do not change; the numbers of the other searches count up.
        let map = MapConfig {
            prior: SizePrior {
                semi_axes_mm: [1.0, 2.0, 3.0],
                spread: [4.0, 5.0, 6.0],
                spread_ab: 7.0,
                spread_bc: 8.0,
            },
            boxiness: 9.0,
            noise: Noise { axial_mm: 10.0, lateral_rad: 11.0 },
            independence: 12.0,
            viewpoint: Viewpoint::None,
            outline_offset_rad: 13.0,
            hypotheses: 300,
            hypothesis_steps: 31,
            kept: 32,
            refine_steps: 33,
            final_steps: 34,
            inflation: Inflation { base: 14.0, per_conflict: 15.0, per_clutter: 16.0 },
            gate: Gate {
                min_points: 301,
                size_conflict: 17.0,
                size_conflict_end_on: 18.0,
                size_unknown: 19.0,
                ambiguous: 20.0,
                outline: 21.0,
                visible: 22.0,
                colour: 23.0,
                uncertain_mm: 24.0,
                flat: 25.0,
                through: 26.0,
                shared_volume: 27.0,
            },
        };
        let mixture = MixtureConfig {
            viewpoint: Viewpoint::Origin,
            noise: Noise { axial_mm: 28.0, lateral_rad: 29.0 },
            sample: 302,
            starts: 35,
            area_weight: 30.0,
            shape_spread: 31.0,
            outline_offset_rad: 32.0,
            inflation: 33.0,
            inflation_thin: 34.0,
            inflation_outliers: 35.0,
            gate: MixtureGate {
                min_points: 36.0,
                gain: 37.0,
                coverage: 38.0,
                flat: 39.0,
                misfit: 40.0,
                uncertain: 41.0,
            },
        };
        let config = Config { method: Method::Mixture, map, mixture, ..Config::table5() };
        let bytes = postcard::to_slice(&config, &mut content).unwrap();
        let paper = [
            0x33, 0x33, 0x73, 0x3F, // confidence 0.95
            4, 9, 10, 11, 12, // four sample sizes
            0xCD, 0xCC, 0xCC, 0x3D, // shell 0.1
            0x00, 0x00, 0xF0, 0x41, // radius 30
            0x00, 0x00, 0x20, 0x41, // semi_axis_min 10
            0x00, 0x00, 0xB8, 0x41, // semi_axis_max 23
            0xB8, 0x17, // max_trials 3000
            1,    // refits
            20,   // min_inliers
            0x00, 0x00, 0x00, 0x00, // min_ratio 0
            16,   // max_targets
            1,    // max_failures
            0,    // constraint a11
            2,    // method mixture
        ];
        let floats = |numbers: core::ops::RangeInclusive<u8>| {
            numbers.flat_map(|number| f32::from(number).to_le_bytes())
        };
        let expected = paper
            .into_iter()
            .chain(floats(1..=12)) // prior, boxiness, noise, independence
            .chain([1]) // viewpoint none
            .chain(floats(13..=13)) // outline_offset_rad
            .chain([0xAC, 0x02, 31, 32, 33, 34]) // hypotheses 300, steps, kept, steps
            .chain(floats(14..=16)) // inflation
            .chain([0xAD, 0x02]) // min_points 301
            .chain(floats(17..=27)) // the other limits
            .chain([0]) // mixture: viewpoint origin
            .chain(floats(28..=29)) // noise
            .chain([0xAE, 0x02, 35]) // sample 302, starts
            .chain(floats(30..=41)); // weight, spread, offset, inflation, limits
        assert_eq!(frame::VERSION, 2);
        assert!(bytes.iter().copied().eq(expected), "{bytes:?}");
    }

    #[test]
    fn the_numbers_of_the_refusals_belong_to_this_version() {
        let in_order = [
            "few_points",
            "size_conflict",
            "size_unknown",
            "ambiguous",
            "outline",
            "visible",
            "colour",
            "uncertain",
            "flat",
            "through",
            "shared_volume",
            "singular",
            "clutter",
            "coverage",
            "shape",
            "vague",
        ];
        for (number, name) in (0_u8..).zip(in_order) {
            assert_eq!(exactly(&[number]).map(RefusalCode::name), Some(name));
        }
        assert_eq!(exactly::<RefusalCode>(&[in_order.len() as u8]), None);
    }
}
