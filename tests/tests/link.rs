//! The link under abuse: a million damaged frames, a channel that loses, doubles, delays and damages, and ends that
//! are killed in the middle of a transfer.

use std::fmt::Write as _;

use varsac_core::link::payload::Hello;
use varsac_core::link::{CloudSender, FrameReceiver, Incoming, Loss, MAX_WIRE, Message, Session, VERSION};
use varsac_core::rng::Stream;
use varsac_core::{OutlineRay, Point3, View};
use varsac_tests::bad_line::{ATTEMPTS, SEED, Step, TIMING, run, target_of};

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
    let outline = outline_of(41);
    (0..count)
        .map(|sequence| {
            let view = View {
                cloud: &cloud[..=stream.below(80) as usize],
                in_mask: 1,
                outline: &outline[..=stream.below(40) as usize],
                pitch_rad: 0.003,
            };
            let mut sender = CloudSender::new(&view);
            // Begin, points or outline.
            let skipped = stream.below(3);
            for _ in 0..skipped {
                sender.next_message().unwrap();
            }
            let message = sender.next_message().unwrap();
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
            for _ in 0..=stream.below(8) {
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
        5 => bytes = (0..=stream.below(200)).map(|_| stream.below(256) as u8).collect(),
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

fn outline_of(rays: usize) -> Vec<OutlineRay> {
    (0..rays)
        .map(|k| OutlineRay {
            inner: Point3::new(-2.0 * k as f32, k as f32, 790.0),
            outer_mm: if k % 5 == 0 { f32::INFINITY } else { 900.0 },
            sigma_rad: 0.001 + k as f32,
        })
        .collect()
}

fn cloud_of(points: usize) -> Vec<Point3> {
    (0..points).map(|k| Point3::new(k as f32, -0.25 * k as f32, 800.0 + (k % 13) as f32)).collect()
}

#[test]
fn a_bad_line_delays_the_answer_and_never_changes_it() {
    let (cloud, outline) = (cloud_of(1000), outline_of(120));
    let view = View { cloud: &cloud, in_mask: 900, outline: &outline, pitch_rad: 0.002 };
    let expected = target_of(&view, SEED);
    let mut table = String::new();
    for per_mille in [0, 10, 50, 150] {
        let (mut ticks, mut attempts) = (0, 0);
        for seed in 0..200 {
            let outcome = run(&view, per_mille, seed, |_| (false, false));
            assert_eq!(outcome.step, Step::Done, "faults {per_mille}/1000, seed {seed}");
            assert_eq!(outcome.target, Some(expected), "faults {per_mille}/1000, seed {seed}");
            if per_mille == 0 {
                assert_eq!((outcome.attempts, outcome.chunks), (1, 13 + 3));
            }
            ticks += outcome.ticks;
            attempts += outcome.attempts;
        }
        let sessions = attempts as f32 / 200.0;
        let _ =
            writeln!(table, "{per_mille:4}/1000 of each fault: {} ticks, {sessions} sessions", ticks / 200);
    }
    println!("1000 points and 120 outline rays, mean of 200 lines:\n{table}");
}

#[test]
fn killing_either_side_costs_one_new_session() {
    let (cloud, outline) = (cloud_of(1000), outline_of(120));
    let view = View { cloud: &cloud, in_mask: 900, outline: &outline, pitch_rad: 0.002 };
    let expected = target_of(&view, SEED);
    // Undisturbed this takes about 34 ticks; so every moment of it is hit.
    for moment in 1..34 {
        let device_dies = run(&view, 0, 1, |now| (now == moment, false));
        assert_eq!((device_dies.step, device_dies.target), (Step::Done, Some(expected)), "tick {moment}");
        assert!(device_dies.attempts <= 2, "tick {moment}: {} sessions", device_dies.attempts);
        let host_dies = run(&view, 0, 1, |now| (false, now == moment));
        assert_eq!((host_dies.step, host_dies.target), (Step::Done, Some(expected)), "tick {moment}");
        assert_eq!(host_dies.attempts, 1, "the new host needs one session");
    }
    // Both, again and again, on a bad line.
    for seed in 0..200 {
        let outcome =
            run(&view, 50, seed, |now| (now < 3000 && now % 211 == 7, now < 3000 && now % 307 == 5));
        assert_eq!((outcome.step, outcome.target), (Step::Done, Some(expected)), "seed {seed}");
    }
}

#[test]
fn a_dead_line_is_reported_after_a_bounded_time() {
    let cloud = cloud_of(100);
    let view = View::from(&cloud[..]);
    let outcome = run(&view, 1000, 1, |_| (false, false));
    assert_eq!(outcome.step, Step::GaveUp);
    // Each session waits for seven sendings: 1 + 2 + 4 + 4 * 8 times `resend_after`, and a tick for each.
    assert!(outcome.ticks <= ATTEMPTS * (TIMING.resend_after * 39 + 7), "{}", outcome.ticks);
}

#[test]
fn two_versions_tell_each_other() {
    let mut host = Session::host(TIMING);
    host.open(3, Hello { max_payload: 1000 }).unwrap();
    let newer =
        varsac_core::link::frame::Header { version: VERSION + 1, kind: 0x7F, sequence: 0, session: 3 };
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
    assert_eq!(found, Incoming::Lost(Loss::Version(VERSION + 1)));
}
