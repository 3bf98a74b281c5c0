//! A view larger than a frame: cut into chunks of 80 points and of 48 outline rays by one side, put together and
//! checked by the other.
//!
//! The session already delivers chunks once and in order, each under its own CRC. The checksum over the whole cloud
//! guards what lies outside of that: the cutting and the putting together.

use super::frame::CRC_TABLE;
use super::message::{Answer, Message, Reason};
use super::payload::{
    CHUNK_BYTES, CHUNK_POINTS, CHUNK_RAYS, CloudBegin, CloudChunk, CloudEnd, OutlineChunk, POINT_BYTES,
    RAY_BYTES,
};
use crate::{OutlineRay, Point3, View, point::MAX_POINTS};
use crc::Digest;

/// Cuts a view into messages.
#[derive(Clone)]
pub struct CloudSender<'a> {
    view: View<'a>,
    stage: Stage,
    digest: Digest<'static, u32>,
    bytes: [u8; CHUNK_BYTES],
}

#[derive(Debug, Clone, Copy)]
enum Stage {
    Begin,
    Points(usize),
    Rays(usize),
    Done,
}

impl<'a> CloudSender<'a> {
    /// Starts with the first of at most 65 535 points and as many rays; further ones are not sent.
    pub fn new(view: &View<'a>) -> Self {
        let cloud = view.cloud.get(..MAX_POINTS).unwrap_or(view.cloud);
        let outline = view.outline.get(..MAX_POINTS).unwrap_or(view.outline);
        let in_mask = if view.in_mask < cloud.len() { view.in_mask } else { cloud.len() };
        Self {
            view: View { cloud, in_mask, outline, ..*view },
            stage: Stage::Begin,
            digest: CRC_TABLE.digest(),
            bytes: [0; CHUNK_BYTES],
        }
    }

    /// The next message to send: begin, points, outline rays, end, then none.
    pub fn next_message(&mut self) -> Option<Message<'_>> {
        let View { cloud, in_mask, outline, pitch_rad } = self.view;
        if let Stage::Begin = self.stage {
            self.stage = Stage::Points(0);
            return Some(Message::CloudBegin(CloudBegin {
                points: cloud.len() as u16,
                in_mask: in_mask as u16,
                outline_rays: outline.len() as u16,
                pitch_rad,
            }));
        }
        if let Stage::Points(offset) = self.stage {
            let points = next_chunk(cloud, offset, CHUNK_POINTS);
            if !points.is_empty() {
                self.stage = Stage::Points(offset + points.len());
                let coordinates = points.iter().flat_map(|point| [point.x, point.y, point.z]);
                let points = self.write(coordinates, points.len() * POINT_BYTES);
                return Some(Message::CloudChunk(CloudChunk { offset: offset as u16, points }));
            }
            self.stage = Stage::Rays(0);
        }
        if let Stage::Rays(offset) = self.stage {
            let rays = next_chunk(outline, offset, CHUNK_RAYS);
            if !rays.is_empty() {
                self.stage = Stage::Rays(offset + rays.len());
                let numbers = rays
                    .iter()
                    .flat_map(|ray| [ray.inner.x, ray.inner.y, ray.inner.z, ray.outer_mm, ray.sigma_rad]);
                let rays = self.write(numbers, rays.len() * RAY_BYTES);
                return Some(Message::OutlineChunk(OutlineChunk { offset: offset as u16, rays }));
            }
            self.stage = Stage::Done;
            return Some(Message::CloudEnd(CloudEnd { checksum: self.digest.clone().finalize() }));
        }
        None
    }

    /// The bytes of a chunk, counted in the checksum.
    fn write(&mut self, numbers: impl Iterator<Item = f32>, length: usize) -> &[u8] {
        for (slot, number) in self.bytes.as_chunks_mut::<4>().0.iter_mut().zip(numbers) {
            *slot = number.to_le_bytes();
        }
        let bytes = self.bytes.get(..length).unwrap_or(&[]);
        self.digest.update(bytes);
        bytes
    }
}

fn next_chunk<T>(items: &[T], offset: usize, most: usize) -> &[T] {
    let rest = items.get(offset..).unwrap_or(&[]);
    rest.get(..most).unwrap_or(rest)
}

/// Where a view is put together.
#[derive(Debug)]
pub struct ViewMemory<'a> {
    /// Room for its points.
    pub cloud: &'a mut [Point3],
    /// Room for its outline rays.
    pub outline: &'a mut [OutlineRay],
}

/// Puts a view together in memory that the caller keeps.
pub struct CloudReceiver {
    announced: CloudBegin,
    points: usize,
    rays: usize,
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
        Self {
            announced: CloudBegin { points: 0, in_mask: 0, outline_rays: 0, pitch_rad: 0.0 },
            points: 0,
            rays: 0,
            digest: CRC_TABLE.digest(),
            state: Assembly::Idle,
        }
    }

    /// The complete view; none while there is none.
    pub fn complete<'m>(&self, memory: &'m ViewMemory<'_>) -> Option<View<'m>> {
        if self.state != Assembly::Complete {
            return None;
        }
        Some(View {
            cloud: memory.cloud.get(..self.points)?,
            in_mask: usize::from(self.announced.in_mask),
            outline: memory.outline.get(..self.rays)?,
            pitch_rad: self.announced.pitch_rad,
        })
    }

    /// A new cloud begins, whatever was there before.
    ///
    /// # Errors
    /// [`Reason::Capacity`], with the points or else the rays that there is room for.
    pub fn begin(&mut self, begin: &CloudBegin, memory: &ViewMemory<'_>) -> Answer {
        *self = Self::new();
        let (points, rays) = (memory.cloud.len(), memory.outline.len());
        if usize::from(begin.points) > points {
            return Err(Reason::Capacity.nack(points as u32));
        }
        if usize::from(begin.outline_rays) > rays {
            return Err(Reason::Capacity.nack(rays as u32));
        }
        self.announced = *begin;
        self.state = Assembly::Open;
        Ok(())
    }

    /// Stores the next points at their place.
    ///
    /// # Errors
    /// [`Reason::Order`] outside of a cloud, [`Reason::Offset`] where the points do not continue it or exceed what was
    /// announced.
    pub fn chunk(&mut self, chunk: &CloudChunk<'_>, memory: &mut ViewMemory<'_>) -> Answer {
        if self.state != Assembly::Open {
            return Err(Reason::Order.nack(0));
        }
        let count = chunk.points.len() / POINT_BYTES;
        let room = (self.points, usize::from(self.announced.points), count);
        store(chunk.iter(), memory.cloud, room, chunk.offset)?;
        self.digest.update(chunk.points);
        self.points += count;
        Ok(())
    }

    /// Stores the next outline rays at their place.
    ///
    /// # Errors
    /// [`Reason::Order`] before the last point, [`Reason::Offset`] as for points.
    pub fn outline_chunk(&mut self, chunk: &OutlineChunk<'_>, memory: &mut ViewMemory<'_>) -> Answer {
        if self.state != Assembly::Open || self.points != usize::from(self.announced.points) {
            return Err(Reason::Order.nack(0));
        }
        let count = chunk.rays.len() / RAY_BYTES;
        let room = (self.rays, usize::from(self.announced.outline_rays), count);
        store(chunk.iter(), memory.outline, room, chunk.offset)?;
        self.digest.update(chunk.rays);
        self.rays += count;
        Ok(())
    }

    /// The cloud is complete if all its points and rays came and their checksum is right.
    ///
    /// # Errors
    /// [`Reason::Order`], [`Reason::Offset`] when points or rays are missing, [`Reason::Checksum`].
    pub fn end(&mut self, end: &CloudEnd) -> Answer {
        if self.state != Assembly::Open {
            return Err(Reason::Order.nack(0));
        }
        for (received, announced) in
            [(self.points, self.announced.points), (self.rays, self.announced.outline_rays)]
        {
            if received != usize::from(announced) {
                return Err(Reason::Offset.nack(received as u32));
            }
        }
        let found = self.digest.clone().finalize();
        self.state = if found == end.checksum { Assembly::Complete } else { Assembly::Idle };
        if self.state == Assembly::Complete { Ok(()) } else { Err(Reason::Checksum.nack(found)) }
    }
}

/// Writes `count` items behind the `received` ones, of `announced` in all, if that is where they belong.
fn store<T>(
    items: impl Iterator<Item = T>,
    memory: &mut [T],
    (received, announced, count): (usize, usize, usize),
    offset: u16,
) -> Answer {
    let room = memory.get_mut(received..announced).and_then(|rest| rest.get_mut(..count));
    let Some(room) = room.filter(|_| usize::from(offset) == received) else {
        return Err(Reason::Offset.nack(received as u32));
    };
    for (slot, item) in room.iter_mut().zip(items) {
        *slot = item;
    }
    Ok(())
}

impl Default for CloudReceiver {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_RAY: OutlineRay =
        OutlineRay { inner: Point3::new(0.0, 0.0, 0.0), outer_mm: 0.0, sigma_rad: 0.0 };

    fn cloud<const N: usize>() -> [Point3; N] {
        core::array::from_fn(|k| Point3::new(k as f32, -0.5 * k as f32, 700.0 + k as f32))
    }

    fn outline<const N: usize>() -> [OutlineRay; N] {
        core::array::from_fn(|k| OutlineRay {
            inner: Point3::new(-1.5 * k as f32, k as f32, 690.0),
            outer_mm: if k % 3 == 0 { f32::INFINITY } else { 800.0 + k as f32 },
            sigma_rad: 0.001 * k as f32,
        })
    }

    /// Sends all messages of a view but those that `skip` names, and returns the first objection.
    fn transfer(
        view: &View<'_>,
        memory: &mut ViewMemory<'_>,
        skip: impl Fn(usize) -> bool,
    ) -> (CloudReceiver, Answer) {
        let (mut sender, mut receiver) = (CloudSender::new(view), CloudReceiver::new());
        let mut number = 0;
        let mut outcome = Ok(());
        while let Some(message) = sender.next_message() {
            if !skip(number) {
                let answer = match message {
                    Message::CloudBegin(begin) => receiver.begin(&begin, memory),
                    Message::CloudChunk(chunk) => receiver.chunk(&chunk, memory),
                    Message::OutlineChunk(chunk) => receiver.outline_chunk(&chunk, memory),
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
    fn views_of_every_size_about_a_chunk_arrive() {
        let (points, rays) = (cloud::<241>(), outline::<97>());
        for size in [0, 1, 79, 80, 81, 159, 160, 161, 240, 241] {
            for ray_count in [0, 1, 47, 48, 49, 96, 97] {
                let (mut cloud, mut outline) = ([Point3::origin(); 241], [NO_RAY; 97]);
                let mut memory = ViewMemory { cloud: &mut cloud, outline: &mut outline };
                let view = View {
                    cloud: &points[..size],
                    in_mask: size / 2,
                    outline: &rays[..ray_count],
                    pitch_rad: 0.001 * size as f32,
                };
                let (receiver, outcome) = transfer(&view, &mut memory, |_| false);
                assert_eq!(outcome, Ok(()));
                let arrived = receiver.complete(&memory).unwrap();
                assert_eq!(
                    (arrived.cloud, arrived.in_mask, arrived.outline),
                    (view.cloud, view.in_mask, view.outline)
                );
            }
        }
    }

    #[test]
    fn what_is_missing_is_noticed() {
        let (points, rays) = (cloud::<200>(), outline::<60>());
        let view = View { cloud: &points, in_mask: 200, outline: &rays, pitch_rad: 0.0 };
        let (mut cloud, mut outline) = ([Point3::origin(); 200], [NO_RAY; 60]);
        let cases = [
            (0, Reason::Order, 0),  // begin
            (1, Reason::Offset, 0), // first chunk
            (2, Reason::Offset, 80),
            (3, Reason::Order, 0),   // last points: the rays come too early
            (4, Reason::Offset, 0),  // first rays
            (5, Reason::Offset, 48), // last rays, noticed by the end
        ];
        for (missing, reason, detail) in cases {
            let mut memory = ViewMemory { cloud: &mut cloud, outline: &mut outline };
            let (receiver, outcome) = transfer(&view, &mut memory, |number| number == missing);
            assert_eq!(outcome, Err(reason.nack(detail)), "message {missing} missing");
            assert!(receiver.complete(&memory).is_none());
        }
        let without = View { outline: &[], ..view };
        let mut memory = ViewMemory { cloud: &mut cloud, outline: &mut [] };
        let (_, outcome) = transfer(&without, &mut memory, |number| number == 3);
        assert_eq!(outcome, Err(Reason::Offset.nack(160)), "the last points, noticed by the end");
        for (points, rays, detail) in [(199, 60, 199), (200, 59, 59), (0, 0, 0)] {
            let mut memory = ViewMemory { cloud: &mut cloud[..points], outline: &mut outline[..rays] };
            let (receiver, outcome) = transfer(&view, &mut memory, |_| false);
            assert_eq!(outcome, Err(Reason::Capacity.nack(detail)));
            assert!(receiver.complete(&memory).is_none());
        }
    }

    #[test]
    fn the_checksum_covers_points_and_rays() {
        let (points, rays) = (cloud::<90>(), outline::<50>());
        let view = View { cloud: &points, in_mask: 90, outline: &rays, pitch_rad: 0.0 };
        for damaged in 1..5 {
            let (mut cloud, mut outline) = ([Point3::origin(); 90], [NO_RAY; 50]);
            let mut memory = ViewMemory { cloud: &mut cloud, outline: &mut outline };
            let (mut sender, mut receiver) = (CloudSender::new(&view), CloudReceiver::new());
            let (mut number, mut outcome) = (0, Ok(()));
            while let Some(message) = sender.next_message() {
                let mut bytes = [0; CHUNK_BYTES];
                let mut spoil = |sent: &[u8]| {
                    bytes[..sent.len()].copy_from_slice(sent);
                    bytes[7] ^= u8::from(number == damaged);
                };
                outcome = match message {
                    Message::CloudBegin(begin) => receiver.begin(&begin, &memory),
                    Message::CloudChunk(CloudChunk { offset, points }) => {
                        spoil(points);
                        receiver.chunk(&CloudChunk { offset, points: &bytes[..points.len()] }, &mut memory)
                    }
                    Message::OutlineChunk(OutlineChunk { offset, rays }) => {
                        spoil(rays);
                        receiver
                            .outline_chunk(&OutlineChunk { offset, rays: &bytes[..rays.len()] }, &mut memory)
                    }
                    Message::CloudEnd(end) => receiver.end(&end),
                    other => panic!("{other:?}"),
                };
                number += 1;
            }
            assert!(matches!(outcome, Err(nack) if nack.reason == Reason::Checksum), "message {damaged}");
            assert!(receiver.complete(&memory).is_none());
            assert_eq!(receiver.end(&CloudEnd { checksum: 1 }), Err(Reason::Order.nack(0)));
        }
    }

    #[test]
    fn more_than_announced_is_not_taken() {
        let (mut cloud, mut outline) = ([Point3::origin(); 4], [NO_RAY; 4]);
        let mut memory = ViewMemory { cloud: &mut cloud, outline: &mut outline };
        let mut receiver = CloudReceiver::new();
        let begin = CloudBegin { points: 2, in_mask: 2, outline_rays: 1, pitch_rad: 0.0 };
        assert_eq!(receiver.begin(&begin, &memory), Ok(()));
        let bytes = [0; 3 * RAY_BYTES];
        let points = |count: usize| CloudChunk { offset: 0, points: &bytes[..count * POINT_BYTES] };
        assert_eq!(receiver.chunk(&points(3), &mut memory), Err(Reason::Offset.nack(0)));
        assert_eq!(receiver.chunk(&points(2), &mut memory), Ok(()));
        let rays = |count: usize| OutlineChunk { offset: 0, rays: &bytes[..count * RAY_BYTES] };
        assert_eq!(receiver.outline_chunk(&rays(2), &mut memory), Err(Reason::Offset.nack(0)));
        assert_eq!(receiver.outline_chunk(&rays(1), &mut memory), Ok(()));
    }
}
