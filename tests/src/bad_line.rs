//! Two programs and a bad line between them: a device that answers searches, a host that wants one, and channels that
//! lose, double, delay and damage pieces of what is written.

use std::collections::VecDeque;

use varsac_core::link::message::Answer;
use varsac_core::link::payload::{
    Ending, Hello, OUTLINE_CAPACITY, REJECTIONS, Report, Search, Target, Welcome,
};
use varsac_core::link::{
    CloudReceiver, CloudSender, FrameReceiver, Incoming, Message, Reason, Session, Timing, ViewMemory,
};
use varsac_core::rng::Stream;
use varsac_core::{Finish, OutlineRay, Point3, View};

/// Patience of both ends, in ticks.
pub const TIMING: Timing = Timing { resend_after: 20, resends: 6 };

const NO_RAY: OutlineRay = OutlineRay { inner: Point3::new(0.0, 0.0, 0.0), outer_mm: 0.0, sigma_rad: 0.0 };

/// A device that answers a search with a digest of the view.
struct Device {
    session: Session,
    receiver: FrameReceiver,
    cloud: CloudReceiver,
    points: Vec<Point3>,
    outline: Vec<OutlineRay>,
    to_send: VecDeque<Message<'static>>,
    chunks: u32,
}

impl Device {
    fn new() -> Self {
        Self {
            session: Session::device(TIMING),
            receiver: FrameReceiver::new(),
            cloud: CloudReceiver::new(),
            points: vec![Point3::origin(); 2000],
            outline: vec![NO_RAY; OUTLINE_CAPACITY],
            to_send: VecDeque::new(),
            chunks: 0,
        }
    }

    fn take(&mut self, bytes: &[u8], now: u32) {
        for &byte in bytes {
            let Some(frame) = self.receiver.push(byte) else { continue };
            let Incoming::Message(message) = self.session.receive(&frame) else { continue };
            let mut memory = ViewMemory { cloud: &mut self.points, outline: &mut self.outline };
            let answer: Answer = match message {
                Message::Hello(_) => {
                    self.to_send.clear();
                    self.cloud = CloudReceiver::new();
                    self.to_send.push_back(Message::Welcome(Welcome {
                        core_version: [0, 1, 0],
                        board: 0,
                        max_payload: 1000,
                        capacity: 2000,
                        outline_capacity: OUTLINE_CAPACITY as u16,
                    }));
                    Ok(())
                }
                Message::CloudBegin(begin) => self.cloud.begin(&begin, &memory),
                Message::CloudChunk(chunk) => {
                    self.chunks += 1;
                    self.cloud.chunk(&chunk, &mut memory)
                }
                Message::OutlineChunk(chunk) => {
                    self.chunks += 1;
                    self.cloud.outline_chunk(&chunk, &mut memory)
                }
                Message::CloudEnd(end) => self.cloud.end(&end),
                Message::Search(search) => match self.cloud.complete(&memory) {
                    Some(view) => {
                        let target = target_of(&view, search.seed);
                        let report = Report {
                            ending: Ending::Complete(Finish::FewPoints),
                            targets: 1,
                            trials: view.cloud.len() as u32,
                            steps: 1,
                            rejections: [0; REJECTIONS],
                            stack_bytes: None,
                        };
                        self.to_send.extend([Message::Target(target), Message::Report(report)]);
                        Ok(())
                    }
                    None => Err(Reason::Order.nack(0)),
                },
                _ => Ok(()),
            };
            self.session.answer(answer);
        }
        if self.session.tick(now).is_some() {
            self.to_send.clear();
        }
        if self.session.is_ready()
            && let Some(message) = self.to_send.pop_front()
        {
            self.session.send(&message).unwrap();
        }
    }
}

/// Stands for a search: depends on every bit of the view, on their order and on the seed.
pub fn target_of(view: &View<'_>, seed: u64) -> Target {
    let mut hash = 0xCBF2_9CE4_8422_2325_u64 ^ seed;
    let points = view.cloud.iter().flat_map(|point| [point.x, point.y, point.z]);
    let rays = view
        .outline
        .iter()
        .flat_map(|ray| [ray.inner.x, ray.inner.y, ray.inner.z, ray.outer_mm, ray.sigma_rad]);
    for value in points.chain(rays).chain([view.pitch_rad, view.in_mask as f32]) {
        hash = (hash ^ u64::from(value.to_bits())).wrapping_mul(0x0100_0000_01B3);
    }
    Target {
        target: 1,
        refusal: None,
        centre_mm: [1.0, 2.0, 3.0],
        semi_axes_mm: [3.0, 2.0, 1.0],
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        quaternion_xyzw: [0.0, 0.0, 0.0, 1.0],
        inliers: hash as u32,
        candidates: (hash >> 32) as u32,
        trials: view.cloud.len() as u32,
        covariance: None,
        findings: None,
    }
}

/// Where a host stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Hello is under way, or Welcome awaited.
    Opening,
    /// The cloud is under way.
    Sending,
    /// The report is awaited.
    Searching,
    /// The report is here.
    Done,
    /// Too many sessions were lost.
    GaveUp,
}

/// A host that wants one view searched and starts again, in a new session, when the session is lost.
struct Host<'a> {
    session: Session,
    receiver: FrameReceiver,
    view: View<'a>,
    sender: CloudSender<'a>,
    step: Step,
    target: Option<Target>,
    attempts: u32,
    ids: Stream,
    heard: u32,
    objections: u32,
}

/// Sessions a host tries before it gives up.
pub const ATTEMPTS: u32 = 40;
/// Seed of the search that the host orders.
pub const SEED: u64 = 0xF00D;

impl<'a> Host<'a> {
    fn new(view: &View<'a>, id_seed: u64) -> Self {
        Self {
            session: Session::host(TIMING),
            receiver: FrameReceiver::new(),
            view: *view,
            sender: CloudSender::new(view),
            step: Step::Opening,
            target: None,
            attempts: 0,
            ids: Stream::new(id_seed),
            heard: 0,
            objections: 0,
        }
    }

    fn start(&mut self, now: u32) {
        if self.attempts == ATTEMPTS {
            self.step = Step::GaveUp;
            return;
        }
        self.attempts += 1;
        self.step = Step::Opening;
        self.target = None;
        self.sender = CloudSender::new(&self.view);
        self.heard = now;
        self.session.open(self.ids.below(u32::MAX), Hello { max_payload: 1000 }).unwrap();
    }

    fn take(&mut self, bytes: &[u8], now: u32) {
        let mut lost = self.session.id().is_none();
        for &byte in bytes {
            let Some(frame) = self.receiver.push(byte) else { continue };
            match self.session.receive(&frame) {
                Incoming::Nothing => {}
                Incoming::Message(message) => {
                    match message {
                        Message::Welcome(_) if self.step == Step::Opening => self.step = Step::Sending,
                        Message::Target(target) => self.target = Some(target),
                        Message::Report(_) => self.step = Step::Done,
                        _ => {}
                    }
                    self.session.answer(Ok(()));
                    self.heard = now;
                }
                Incoming::Answered(answer) => {
                    self.heard = now;
                    self.objections += u32::from(answer.is_err());
                }
                Incoming::Lost(_) => lost = true,
            }
        }
        if !matches!(self.step, Step::Done | Step::GaveUp) && (lost || self.session.tick(now).is_some()) {
            self.start(now);
        }
        if self.session.is_ready() {
            let next = match self.step {
                Step::Sending => Some(self.sender.next_message().unwrap_or_else(|| {
                    self.step = Step::Searching;
                    Message::Search(Search { seed: SEED, step_budget: 0 })
                })),
                Step::Opening | Step::Searching if now.wrapping_sub(self.heard) > 50 => {
                    self.heard = now;
                    Some(Message::Poll)
                }
                _ => None,
            };
            if let Some(message) = next {
                self.session.send(&message).unwrap();
            }
        }
    }
}

/// One direction of a bad line. Each fault happens to `per_mille` of the pieces that are written.
struct Line {
    per_mille: u32,
    flying: Vec<(u32, Vec<u8>)>,
}

impl Line {
    fn write(&mut self, from: &mut Session, now: u32, stream: &mut Stream) {
        loop {
            let mut piece = from.outgoing(now).to_vec();
            if piece.is_empty() {
                return;
            }
            piece.truncate(1 + stream.below(piece.len() as u32 * 4) as usize);
            from.advance(piece.len(), now);
            let mut happens = || stream.below(1000) < self.per_mille;
            let (drop, double, damage, delay) = (happens(), happens(), happens(), happens());
            if drop {
                continue;
            }
            if damage {
                let at = stream.below(piece.len() as u32) as usize;
                piece[at] ^= 1 << stream.below(8);
            }
            let arrives = now + 1 + if delay { stream.below(60) } else { 0 };
            if double {
                self.flying.push((arrives + stream.below(80), piece.clone()));
            }
            self.flying.push((arrives, piece));
        }
    }

    fn read(&mut self, now: u32) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.flying.retain(|(arrives, piece)| {
            let here = *arrives <= now;
            if here {
                bytes.extend(piece);
            }
            !here
        });
        bytes
    }
}

/// How a run ended.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// Ticks it took.
    pub ticks: u32,
    /// Sessions the last host opened.
    pub attempts: u32,
    /// Done or gave up.
    pub step: Step,
    /// What the device answered.
    pub target: Option<Target>,
    /// Chunks the device applied.
    pub chunks: u32,
}

/// Runs until the host is done or has given up. `kill` says who dies at a tick: the device, the host.
///
/// # Panics
/// When neither happens, or the device objects to something on a perfect line.
pub fn run(view: &View<'_>, per_mille: u32, seed: u64, kill: impl Fn(u32) -> (bool, bool)) -> Outcome {
    let mut stream = Stream::new(seed);
    let mut host = Host::new(view, seed ^ 0xAAAA);
    let mut device = Device::new();
    let mut up = Line { per_mille, flying: Vec::new() };
    let mut down = Line { per_mille, flying: Vec::new() };
    for now in 0..1_000_000 {
        let (kill_device, kill_host) = kill(now);
        if kill_device {
            device = Device { chunks: device.chunks, ..Device::new() };
        }
        if kill_host {
            host = Host::new(view, seed ^ u64::from(now));
        }
        host.take(&down.read(now), now);
        device.take(&up.read(now), now);
        up.write(&mut host.session, now, &mut stream);
        down.write(&mut device.session, now, &mut stream);
        if matches!(host.step, Step::Done | Step::GaveUp) {
            assert!(per_mille > 0 || host.objections == 0, "the device objected on a perfect line");
            let (attempts, step, target) = (host.attempts, host.step, host.target);
            return Outcome { ticks: now, attempts, step, target, chunks: device.chunks };
        }
    }
    panic!("seed {seed}: neither done nor given up");
}
