//! The link under abuse: a million damaged frames, a channel that loses, doubles, delays and damages, and ends that
//! are killed in the middle of a transfer.

use std::collections::VecDeque;

use varsac_core::link::message::Answer;
use varsac_core::link::payload::{Ending, Hello, REJECTIONS, Report, Search, Target, Welcome};
use varsac_core::link::{
    CloudReceiver, CloudSender, FrameReceiver, Incoming, Loss, MAX_WIRE, Message, Reason, Session, Timing,
};
use varsac_core::rng::Stream;
use varsac_core::{Finish, Point3};

/// A frame on the wire, and what it says.
struct Sent {
    wire: Vec<u8>,
    sequence: u16,
}

fn random_frames(stream: &mut Stream, count: u16) -> Vec<Sent> {
    let cloud: Vec<Point3> = (0..80)
        .map(|_| {
            Point3::new(stream.below(1000) as f32, stream.below(1000) as f32, 700.0 + stream.below(99) as f32)
        })
        .collect();
    (0..count)
        .map(|sequence| {
            let mut sender = CloudSender::new(&cloud[..1 + stream.below(80) as usize]);
            let begin = stream.below(3) == 0;
            let mut message = sender.next_message().unwrap();
            if !begin {
                message = sender.next_message().unwrap();
            }
            let mut wire = vec![0; MAX_WIRE];
            let used = message.encode(sequence, 0xC0FF_EE00, &mut wire).unwrap();
            wire.truncate(used);
            Sent { wire, sequence }
        })
        .collect()
}

/// Damages the frames in one of eight ways; the bytes as they arrive.
fn damaged(stream: &mut Stream, first: &Sent, second: &Sent) -> Vec<u8> {
    let mut bytes = first.wire.clone();
    let length = bytes.len() as u32;
    let at = stream.below(length) as usize;
    match stream.below(8) {
        0 => {
            for _ in 0..1 + stream.below(8) {
                let at = stream.below(length) as usize;
                bytes[at] ^= 1 << stream.below(8);
            }
        }
        1 => bytes.truncate(at),
        2 => {
            bytes.drain(at..(at + 1 + stream.below(9) as usize).min(bytes.len()));
        }
        3 => bytes.insert(at, stream.below(256) as u8),
        4 => {
            // The head of one frame and the tail of another, run together.
            bytes.truncate(at);
            bytes.extend(&second.wire[stream.below(second.wire.len() as u32) as usize..]);
        }
        5 => bytes = (0..1 + stream.below(200)).map(|_| stream.below(256) as u8).collect(),
        6 => {
            let filler = 1 + stream.below(255) as u8;
            bytes.splice(at..at, std::iter::repeat_n(filler, 1100));
        }
        _ => bytes.extend_from_within(..),
    }
    bytes
}

#[test]
fn a_million_damaged_frames_and_none_accepted_wrongly() {
    let mut stream = Stream::new(0x11_4B);
    let frames = random_frames(&mut stream, 500);
    let follower = {
        let mut wire = vec![0; MAX_WIRE];
        let used = Message::Poll.encode(40_000, 1, &mut wire).unwrap();
        wire.truncate(used);
        Sent { wire, sequence: 40_000 }
    };
    let mut receiver = FrameReceiver::new();
    let (mut whole, mut wrong, mut lost_followers) = (0_u32, 0_u32, 0_u32);
    for _ in 0..1_000_000 {
        let first = &frames[stream.below(frames.len() as u32) as usize];
        let second = &frames[stream.below(frames.len() as u32) as usize];
        // In step again at the next delimiter: an undamaged frame right behind the damage must arrive.
        let mut bytes = damaged(&mut stream, first, second);
        bytes.extend(&follower.wire);
        let mut followed = false;
        for byte in bytes {
            let Some(frame) = receiver.push(byte) else { continue };
            let mut wire = [0; MAX_WIRE];
            let again = Message::decode(frame.header.kind, frame.payload).and_then(|message| {
                message.encode(frame.header.sequence, frame.header.session, &mut wire).ok()
            });
            let original =
                [first, second, &follower].into_iter().find(|sent| sent.sequence == frame.header.sequence);
            match (again, original) {
                (Some(used), Some(sent)) if wire[..used] == sent.wire => whole += 1,
                _ => wrong += 1,
            }
            followed = frame.header.sequence == follower.sequence;
        }
        lost_followers += u32::from(!followed);
    }
    let damage = receiver.damage();
    println!(
        "1000000 damaged frames: {wrong} accepted wrongly, {lost_followers} followers lost, {whole} frames whole (followers included), {damage:?}"
    );
    assert_eq!((wrong, lost_followers), (0, 0));
    assert!(
        damage.truncated > 100_000 && damage.oversized > 10_000 && damage.corrupted > 100_000,
        "{damage:?}"
    );
}

const TIMING: Timing = Timing { resend_after: 20, resends: 6 };

/// A device that answers a search with the sum of the coordinates of the cloud.
struct Device {
    session: Session,
    receiver: FrameReceiver,
    cloud: CloudReceiver,
    memory: Vec<Point3>,
    to_send: VecDeque<Message<'static>>,
    chunks: u32,
}

impl Device {
    fn new() -> Self {
        Self {
            session: Session::device(TIMING),
            receiver: FrameReceiver::new(),
            cloud: CloudReceiver::new(),
            memory: vec![Point3::origin(); 2000],
            to_send: VecDeque::new(),
            chunks: 0,
        }
    }

    fn take(&mut self, bytes: &[u8], now: u32) {
        for &byte in bytes {
            let Some(frame) = self.receiver.push(byte) else { continue };
            let Incoming::Message(message) = self.session.receive(&frame) else { continue };
            let answer: Answer = match message {
                Message::Hello(_) => {
                    self.to_send.clear();
                    self.cloud = CloudReceiver::new();
                    self.to_send.push_back(Message::Welcome(Welcome {
                        core_version: [0, 1, 0],
                        board: 0,
                        max_payload: 1000,
                        capacity: 2000,
                    }));
                    Ok(())
                }
                Message::CloudBegin(begin) => self.cloud.begin(&begin, self.memory.len()),
                Message::CloudChunk(chunk) => {
                    self.chunks += 1;
                    self.cloud.chunk(&chunk, &mut self.memory)
                }
                Message::CloudEnd(end) => self.cloud.end(&end),
                Message::Search(search) => match self.cloud.complete() {
                    Some(points) => {
                        let target = target_of(&self.memory[..points], search.seed);
                        let report = Report {
                            ending: Ending::Complete(Finish::FewPoints),
                            targets: 1,
                            trials: points as u32,
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

/// Stands for a search: depends on every bit of the cloud, on their order and on the seed.
fn target_of(cloud: &[Point3], seed: u64) -> Target {
    let mut hash = 0xCBF2_9CE4_8422_2325_u64 ^ seed;
    for value in cloud.iter().flat_map(|point| [point.x, point.y, point.z]) {
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
        trials: cloud.len() as u32,
        covariance: None,
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Step {
    Opening,
    Sending,
    Searching,
    Done,
    GaveUp,
}

/// A host that wants one cloud searched and starts again, in a new session, when the session is lost.
struct Host<'a> {
    session: Session,
    receiver: FrameReceiver,
    cloud: &'a [Point3],
    sender: CloudSender<'a>,
    step: Step,
    target: Option<Target>,
    attempts: u32,
    ids: Stream,
    heard: u32,
    objections: u32,
}

/// Sessions a host tries before it gives up.
const ATTEMPTS: u32 = 40;
const SEED: u64 = 0xF00D;

impl<'a> Host<'a> {
    fn new(cloud: &'a [Point3], id_seed: u64) -> Self {
        Self {
            session: Session::host(TIMING),
            receiver: FrameReceiver::new(),
            cloud,
            sender: CloudSender::new(cloud),
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
        self.sender = CloudSender::new(self.cloud);
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

struct Outcome {
    ticks: u32,
    attempts: u32,
    step: Step,
    target: Option<Target>,
    chunks: u32,
}

/// Runs until the host is done or has given up. `kill` says who dies at a tick: the device, the host.
fn run(cloud: &[Point3], per_mille: u32, seed: u64, kill: impl Fn(u32) -> (bool, bool)) -> Outcome {
    let mut stream = Stream::new(seed);
    let mut host = Host::new(cloud, seed ^ 0xAAAA);
    let mut device = Device::new();
    let mut up = Line { per_mille, flying: Vec::new() };
    let mut down = Line { per_mille, flying: Vec::new() };
    for now in 0..1_000_000 {
        let (kill_device, kill_host) = kill(now);
        if kill_device {
            device = Device { chunks: device.chunks, ..Device::new() };
        }
        if kill_host {
            host = Host::new(cloud, seed ^ u64::from(now));
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

fn cloud_of(points: usize) -> Vec<Point3> {
    (0..points).map(|k| Point3::new(k as f32, -0.25 * k as f32, 800.0 + (k % 13) as f32)).collect()
}

#[test]
fn a_bad_line_delays_the_answer_and_never_changes_it() {
    let cloud = cloud_of(1000);
    let expected = target_of(&cloud, SEED);
    let mut table = String::new();
    for per_mille in [0, 10, 50, 150] {
        let (mut ticks, mut attempts) = (0, 0);
        for seed in 0..200 {
            let outcome = run(&cloud, per_mille, seed, |_| (false, false));
            assert_eq!(outcome.step, Step::Done, "faults {per_mille}/1000, seed {seed}");
            assert_eq!(outcome.target, Some(expected), "faults {per_mille}/1000, seed {seed}");
            if per_mille == 0 {
                assert_eq!((outcome.attempts, outcome.chunks), (1, 13));
            }
            ticks += outcome.ticks;
            attempts += outcome.attempts;
        }
        table += &format!(
            "{per_mille:4}/1000 of each fault: {} ticks, {} sessions\n",
            ticks / 200,
            attempts as f32 / 200.0
        );
    }
    println!("1000 points, mean of 200 lines:\n{table}");
}

#[test]
fn killing_either_side_costs_one_new_session() {
    let cloud = cloud_of(1000);
    let expected = target_of(&cloud, SEED);
    // Undisturbed this takes about 34 ticks; so every moment of it is hit.
    for moment in 1..34 {
        let device_dies = run(&cloud, 0, 1, |now| (now == moment, false));
        assert_eq!((device_dies.step, device_dies.target), (Step::Done, Some(expected)), "tick {moment}");
        assert!(device_dies.attempts <= 2, "tick {moment}: {} sessions", device_dies.attempts);
        let host_dies = run(&cloud, 0, 1, |now| (false, now == moment));
        assert_eq!((host_dies.step, host_dies.target), (Step::Done, Some(expected)), "tick {moment}");
        assert_eq!(host_dies.attempts, 1, "the new host needs one session");
    }
    // Both, again and again, on a bad line.
    for seed in 0..200 {
        let outcome =
            run(&cloud, 50, seed, |now| (now < 3000 && now % 211 == 7, now < 3000 && now % 307 == 5));
        assert_eq!((outcome.step, outcome.target), (Step::Done, Some(expected)), "seed {seed}");
    }
}

#[test]
fn a_dead_line_is_reported_after_a_bounded_time() {
    let cloud = cloud_of(100);
    let outcome = run(&cloud, 1000, 1, |_| (false, false));
    assert_eq!(outcome.step, Step::GaveUp);
    // Each session waits for seven sendings: 1 + 2 + 4 + 4 * 8 times `resend_after`, and a tick for each.
    assert!(outcome.ticks <= ATTEMPTS * (TIMING.resend_after * 39 + 7), "{}", outcome.ticks);
}

#[test]
fn two_versions_tell_each_other() {
    let mut host = Session::host(TIMING);
    host.open(3, Hello { max_payload: 1000 }).unwrap();
    let newer = varsac_core::link::frame::Header { version: 2, kind: 0x7F, sequence: 0, session: 3 };
    let mut wire = [0; MAX_WIRE];
    let used = varsac_core::link::frame::encode(&newer, &7_u32, &mut wire).unwrap();
    let mut receiver = FrameReceiver::new();
    let mut found = Incoming::Nothing;
    for &byte in &wire[..used] {
        if let Some(frame) = receiver.push(byte) {
            found = match host.receive(&frame) {
                Incoming::Lost(loss) => Incoming::Lost(loss),
                other => panic!("{other:?}"),
            };
        }
    }
    assert_eq!(found, Incoming::Lost(Loss::Version(2)));
}
