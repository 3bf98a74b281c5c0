//! The rules of a session, one by one, over a perfect line.

use super::super::payload::CloudBegin;
use super::super::receiver::FrameReceiver;
use super::*;

const TIMING: Timing = Timing { resend_after: 10, resends: 3 };
const HELLO: Hello = Hello { max_payload: 1000 };
const BEGIN: Message<'static> =
    Message::CloudBegin(CloudBegin { points: 3, in_mask: 2, outline_rays: 1, pitch_rad: 0.5 });

/// Carries what `from` has to say to `to`; messages are taken with `Ok`. Returns the last thing that happened.
fn carry(from: &mut Session, to: &mut Session, now: u32) -> Option<Incoming<'static>> {
    let mut receiver = FrameReceiver::new();
    let mut last = None;
    while let Some(&byte) = from.outgoing(now).first() {
        from.advance(1, now);
        let Some(frame) = receiver.push(byte) else { continue };
        last = Some(match to.receive(&frame) {
            Incoming::Message(message) => {
                to.answer(Ok(()));
                Incoming::Message(match message {
                    Message::Hello(hello) => Message::Hello(hello),
                    Message::CloudBegin(begin) => Message::CloudBegin(begin),
                    Message::Poll => Message::Poll,
                    other => panic!("{other:?}"),
                })
            }
            Incoming::Nothing => Incoming::Nothing,
            Incoming::Answered(answer) => Incoming::Answered(answer),
            Incoming::Lost(loss) => Incoming::Lost(loss),
        });
    }
    last
}

fn opened() -> (Session, Session) {
    let (mut host, mut device) = (Session::host(TIMING), Session::device(TIMING));
    host.open(7, HELLO).unwrap();
    assert_eq!(carry(&mut host, &mut device, 0), Some(Incoming::Message(Message::Hello(HELLO))));
    assert_eq!(carry(&mut device, &mut host, 0), Some(Incoming::Answered(Ok(()))));
    (host, device)
}

#[test]
fn a_lost_answer_is_repeated_and_the_message_not_applied_twice() {
    let (mut host, mut device) = opened();
    host.send(&BEGIN).unwrap();
    assert_eq!(host.send(&BEGIN), Err(SendError::Waiting));
    assert_eq!(carry(&mut host, &mut device, 1), Some(Incoming::Message(BEGIN)));
    // The answer gets lost on the way.
    device.advance(usize::MAX, 1);
    let lost = device.outgoing(1).len();
    device.advance(lost, 1);
    assert_eq!(carry(&mut host, &mut device, 10), None);
    assert_eq!(carry(&mut host, &mut device, 11), Some(Incoming::Nothing));
    assert_eq!(carry(&mut device, &mut host, 11), Some(Incoming::Answered(Ok(()))));
    assert!(host.is_ready());
}

#[test]
fn messages_cross_without_waiting_for_each_other() {
    let (mut host, mut device) = opened();
    host.send(&BEGIN).unwrap();
    device.send(&Message::Poll).unwrap();
    assert_eq!(carry(&mut host, &mut device, 1), Some(Incoming::Message(BEGIN)));
    // The answer goes first, then the device's own message.
    assert_eq!(carry(&mut device, &mut host, 1), Some(Incoming::Message(Message::Poll)));
    assert!(host.is_ready());
    assert_eq!(carry(&mut host, &mut device, 1), Some(Incoming::Answered(Ok(()))));
    assert!(device.is_ready());
}

#[test]
fn a_restarted_device_asks_for_a_new_session() {
    let (mut host, _) = opened();
    let mut device = Session::device(TIMING);
    host.send(&BEGIN).unwrap();
    assert_eq!(carry(&mut host, &mut device, 1), Some(Incoming::Nothing));
    assert_eq!(carry(&mut device, &mut host, 1), Some(Incoming::Lost(Loss::Unknown)));
    assert_eq!(host.send(&BEGIN), Err(SendError::Closed));
    host.open(8, HELLO).unwrap();
    assert_eq!(carry(&mut host, &mut device, 2), Some(Incoming::Message(Message::Hello(HELLO))));
    assert_eq!(device.id(), Some(8));
}

#[test]
fn a_restarted_host_takes_over_and_the_old_hello_stays_dead() {
    let (_, mut device) = opened();
    device.send(&Message::Poll).unwrap();
    let mut host = Session::host(TIMING);
    host.open(9, HELLO).unwrap();
    assert_eq!(carry(&mut host, &mut device, 1), Some(Incoming::Message(Message::Hello(HELLO))));
    assert!(device.is_ready(), "what was under way to the old host is forgotten");
    let mut late = Session::host(TIMING);
    late.open(7, HELLO).unwrap();
    assert_eq!(carry(&mut late, &mut device, 1), Some(Incoming::Nothing));
    assert_eq!(device.id(), Some(9));
}

#[test]
fn silence_ends_the_session_and_nothing_goes_out_any_more() {
    let (mut host, _) = opened();
    host.send(&BEGIN).unwrap();
    let mut sendings = 0;
    for now in 0..300 {
        let bytes = host.outgoing(now).len();
        if bytes > 0 {
            sendings += 1;
            host.advance(bytes, now);
        }
        match host.tick(now) {
            Some(loss) => {
                assert_eq!((loss, now, sendings), (Loss::Silence, 150, 4));
                assert_eq!(host.id(), None);
            }
            None => assert!(now != 150),
        }
    }
    assert_eq!(sendings, 4);
}

#[test]
fn another_version_is_named() {
    let (mut host, mut device) = opened();
    let strange = Header { version: 9, kind: 0x70, sequence: 1, session: 7 };
    let frame = Frame { header: strange, payload: &[1, 2, 3] };
    assert_eq!(device.receive(&frame), Incoming::Nothing);
    assert!(!device.outgoing(0).is_empty(), "the device answers");
    assert_eq!(host.receive(&frame), Incoming::Lost(Loss::Version(9)));
}

#[test]
fn a_malformed_message_is_refused_and_the_next_one_taken() {
    let (mut host, mut device) = opened();
    let header = Header { version: VERSION, kind: 0x6A, sequence: 1, session: 7 };
    assert_eq!(device.receive(&Frame { header, payload: &[] }), Incoming::Nothing);
    // The host sent it as number 1: pretend so, and carry the objection.
    host.send(&Message::Poll).unwrap();
    host.outgoing(0);
    let refused = Err(Reason::Malformed.nack(0x6A));
    assert_eq!(carry(&mut device, &mut host, 0), Some(Incoming::Answered(refused)));
    host.send(&BEGIN).unwrap();
    assert_eq!(carry(&mut host, &mut device, 1), Some(Incoming::Message(BEGIN)));
}
