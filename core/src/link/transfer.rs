//! A cloud larger than a frame: cut into chunks of 80 points by one side, put together and checked by the other.
//!
//! The session already delivers chunks once and in order, each under its own CRC. The checksum over the whole cloud
//! guards what lies outside of that: the cutting and the putting together.

use super::frame::CRC_TABLE;
use super::message::{Answer, Message, Reason};
use super::payload::{CHUNK_POINTS, CloudBegin, CloudChunk, CloudEnd, POINT_BYTES};
use crate::Point3;
use crc::Digest;

/// Cuts a cloud into messages.
#[derive(Clone)]
pub struct CloudSender<'a> {
    cloud: &'a [Point3],
    stage: Stage,
    digest: Digest<'static, u32>,
    bytes: [u8; CHUNK_POINTS * POINT_BYTES],
}

#[derive(Debug, Clone, Copy)]
enum Stage {
    Begin,
    Points(usize),
    Done,
}

impl<'a> CloudSender<'a> {
    /// Starts with the first of at most 65 535 points; further ones are not sent.
    pub fn new(cloud: &'a [Point3]) -> Self {
        let cloud = cloud.get(..crate::point::MAX_POINTS).unwrap_or(cloud);
        Self {
            cloud,
            stage: Stage::Begin,
            digest: CRC_TABLE.digest(),
            bytes: [0; CHUNK_POINTS * POINT_BYTES],
        }
    }

    /// The next message to send: begin, chunks, end, then none.
    pub fn next_message(&mut self) -> Option<Message<'_>> {
        match self.stage {
            Stage::Begin => {
                self.stage = Stage::Points(0);
                Some(Message::CloudBegin(CloudBegin { points: self.cloud.len() as u16 }))
            }
            Stage::Points(offset) => {
                let rest = self.cloud.get(offset..).unwrap_or(&[]);
                if rest.is_empty() {
                    self.stage = Stage::Done;
                    return Some(Message::CloudEnd(CloudEnd { checksum: self.digest.clone().finalize() }));
                }
                let points = rest.get(..CHUNK_POINTS).unwrap_or(rest);
                self.stage = Stage::Points(offset + points.len());
                for (slot, value) in self.bytes.as_chunks_mut::<4>().0.iter_mut().zip(coordinates(points)) {
                    *slot = value.to_le_bytes();
                }
                let bytes = self.bytes.get(..points.len() * POINT_BYTES).unwrap_or(&[]);
                self.digest.update(bytes);
                Some(Message::CloudChunk(CloudChunk { offset: offset as u16, points: bytes }))
            }
            Stage::Done => None,
        }
    }
}

fn coordinates(points: &[Point3]) -> impl Iterator<Item = f32> {
    points.iter().flat_map(|point| [point.x, point.y, point.z])
}

/// Puts a cloud together in memory that the caller keeps.
pub struct CloudReceiver {
    announced: usize,
    received: usize,
    digest: Digest<'static, u32>,
    state: Assembly,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Assembly {
    Idle,
    Open,
    Complete,
}

impl CloudReceiver {
    /// No cloud.
    pub fn new() -> Self {
        Self { announced: 0, received: 0, digest: CRC_TABLE.digest(), state: Assembly::Idle }
    }

    /// Points of the complete cloud; none while there is none.
    pub fn complete(&self) -> Option<usize> {
        (self.state == Assembly::Complete).then_some(self.received)
    }

    /// A new cloud begins, whatever was there before.
    ///
    /// # Errors
    /// [`Reason::Capacity`].
    pub fn begin(&mut self, begin: &CloudBegin, capacity: usize) -> Answer {
        *self = Self::new();
        let announced = usize::from(begin.points);
        if announced > capacity {
            return Err(Reason::Capacity.nack(capacity as u32));
        }
        self.announced = announced;
        self.state = Assembly::Open;
        Ok(())
    }

    /// Stores the next points at their place in `cloud`.
    ///
    /// # Errors
    /// [`Reason::Order`] outside of a cloud, [`Reason::Offset`] where the points do not continue it or exceed what was
    /// announced.
    pub fn chunk(&mut self, chunk: &CloudChunk<'_>, cloud: &mut [Point3]) -> Answer {
        if self.state != Assembly::Open {
            return Err(Reason::Order.nack(0));
        }
        let expected = Reason::Offset.nack(self.received as u32);
        let count = chunk.points.len() / POINT_BYTES;
        let room = cloud.get_mut(self.received..self.announced).and_then(|rest| rest.get_mut(..count));
        let Some(room) = room.filter(|_| usize::from(chunk.offset) == self.received) else {
            return Err(expected);
        };
        for (slot, point) in room.iter_mut().zip(chunk.iter()) {
            *slot = point;
        }
        self.digest.update(chunk.points);
        self.received += count;
        Ok(())
    }

    /// The cloud is complete if all its points came and their checksum is right.
    ///
    /// # Errors
    /// [`Reason::Order`], [`Reason::Offset`] when points are missing, [`Reason::Checksum`].
    pub fn end(&mut self, end: &CloudEnd) -> Answer {
        if self.state != Assembly::Open {
            return Err(Reason::Order.nack(0));
        }
        if self.received != self.announced {
            return Err(Reason::Offset.nack(self.received as u32));
        }
        let found = self.digest.clone().finalize();
        self.state = if found == end.checksum { Assembly::Complete } else { Assembly::Idle };
        if self.state == Assembly::Complete { Ok(()) } else { Err(Reason::Checksum.nack(found)) }
    }
}

impl Default for CloudReceiver {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud<const N: usize>() -> [Point3; N] {
        core::array::from_fn(|k| Point3::new(k as f32, -0.5 * k as f32, 700.0 + k as f32))
    }

    /// Sends all messages of a cloud but those that `skip` names, and returns the first objection.
    fn transfer(
        cloud: &[Point3],
        memory: &mut [Point3],
        skip: impl Fn(usize) -> bool,
    ) -> (CloudReceiver, Answer) {
        let (mut sender, mut receiver) = (CloudSender::new(cloud), CloudReceiver::new());
        let mut number = 0;
        let mut outcome = Ok(());
        while let Some(message) = sender.next_message() {
            if !skip(number) {
                let answer = match message {
                    Message::CloudBegin(begin) => receiver.begin(&begin, memory.len()),
                    Message::CloudChunk(chunk) => receiver.chunk(&chunk, memory),
                    Message::CloudEnd(end) => receiver.end(&end),
                    other => panic!("{other:?}"),
                };
                outcome = outcome.and(answer);
            }
            number += 1;
        }
        (receiver, outcome)
    }

    #[test]
    fn clouds_of_every_size_about_a_chunk_arrive() {
        let points = cloud::<241>();
        for size in [0, 1, 79, 80, 81, 159, 160, 161, 240, 241] {
            let mut memory = [Point3::origin(); 241];
            let (receiver, outcome) = transfer(&points[..size], &mut memory, |_| false);
            assert_eq!(outcome, Ok(()));
            assert_eq!(receiver.complete(), Some(size));
            assert_eq!(memory[..size], points[..size]);
        }
    }

    #[test]
    fn what_is_missing_is_noticed() {
        let points = cloud::<200>();
        let mut memory = [Point3::origin(); 200];
        let cases = [
            (0, Reason::Order, 0),  // begin
            (1, Reason::Offset, 0), // first chunk
            (2, Reason::Offset, 80),
            (3, Reason::Offset, 160), // last chunk, noticed by the end
        ];
        for (missing, reason, detail) in cases {
            let (receiver, outcome) = transfer(&points, &mut memory, |number| number == missing);
            assert_eq!(outcome, Err(reason.nack(detail)));
            assert_eq!(receiver.complete(), None);
        }
        let (receiver, outcome) = transfer(&points, &mut memory[..199], |_| false);
        assert_eq!(outcome, Err(Reason::Capacity.nack(199)));
        assert_eq!(receiver.complete(), None);
    }

    #[test]
    fn a_wrong_checksum_or_too_many_points_make_no_cloud() {
        let mut memory = [Point3::origin(); 4];
        let mut receiver = CloudReceiver::new();
        assert_eq!(receiver.begin(&CloudBegin { points: 2 }, 4), Ok(()));
        let three = [0; 3 * POINT_BYTES];
        let chunk = CloudChunk { offset: 0, points: &three };
        assert_eq!(receiver.chunk(&chunk, &mut memory), Err(Reason::Offset.nack(0)));
        let chunk = CloudChunk { offset: 0, points: &three[..2 * POINT_BYTES] };
        assert_eq!(receiver.chunk(&chunk, &mut memory), Ok(()));
        assert!(
            matches!(receiver.end(&CloudEnd { checksum: 1 }), Err(nack) if nack.reason == Reason::Checksum)
        );
        assert_eq!(receiver.complete(), None);
        assert_eq!(receiver.end(&CloudEnd { checksum: 1 }), Err(Reason::Order.nack(0)));
    }
}
