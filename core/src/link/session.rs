//! The state machine at both ends: one session, opened by the host, in which every message arrives once and in order.
//!
//! The host picks a number for the session, never 0 and hardly ever the same twice, and says Hello. All frames carry
//! the number. A device that does not know it (it was restarted, or another host took over) says so, and the host
//! opens a new session; a device that hears a Hello with a new number forgets the old session (the host was
//! restarted). So either side may be killed at any moment and only the other's current work is lost.
//!
//! In each direction messages are numbered from 0 and sent one at a time. The receiver takes the number it expects,
//! answers the one before it again without applying it (its answer was lost), and drops all others.
//!
//! ```
//! use varsac_core::link::{FrameReceiver, Incoming, Message, Session, Timing, payload::Hello};
//! let timing = Timing { resend_after: 100, resends: 5 };
//! let (mut host, mut device) = (Session::host(timing), Session::device(timing));
//! host.open(0x5EED, Hello { max_payload: 1000 }).unwrap();
//!
//! let mut received = FrameReceiver::new();
//! let mut opened = false;
//! let bytes = host.outgoing(0).len();
//! for k in 0..bytes {
//!     let byte = host.outgoing(0)[k];
//!     if let Some(frame) = received.push(byte) {
//!         if let Incoming::Message(Message::Hello(_)) = device.receive(&frame) {
//!             device.answer(Ok(()));
//!             opened = true;
//!         }
//!     }
//! }
//! host.advance(bytes, 0);
//! assert!(opened && !device.outgoing(0).is_empty());
//! ```

use super::frame::{self, Frame, Header, VERSION};
use super::message::{self, Answer, Message, Nack, Reason, kind};
use super::outbox::Outbox;
pub use super::outbox::Timing;
use super::payload::Hello;

/// What a frame, or the lack of one, means to the application.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "no heap to box into; it lives for the length of one call")]
pub enum Incoming<'a> {
    /// Nothing: a repetition, a stray of another session, an answer to nothing.
    Nothing,
    /// A message, to be answered through [`Session::answer`]. A Hello also means: forget everything before it.
    Message(Message<'a>),
    /// The answer to the message under way; the next one can be sent.
    Answered(Answer),
    /// The session is over.
    Lost(Loss),
}

/// Why a session is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Loss {
    /// No answer, however often the frame was sent.
    Silence,
    /// The device does not know the session: it was restarted.
    Unknown,
    /// The other side speaks this version.
    Version(u8),
}

/// Why a message was not put under way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SendError {
    /// No session is open.
    Closed,
    /// The message before it is not yet answered.
    Waiting,
    /// It does not fit into a frame.
    TooLong,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    Host,
    Device,
}

/// An answer to go out, with the numbers of what it answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Reply {
    sequence: u16,
    session: u32,
    answer: Answer,
}

/// Which frame is being written, and how many of its bytes have left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Writing {
    Nothing,
    Reply(usize),
    Message(usize),
}

/// Bytes of an answer's frame at most: stuffing, delimiters, header, reason, detail, checksum.
const REPLY_WIRE: usize = 32;

/// One end of the link. Time comes as ticks; they may wrap.
#[derive(Debug)]
pub struct Session {
    role: Role,
    /// 0: none.
    id: u32,
    /// The session before this one, so that a late repetition of its Hello does not bring it back.
    previous: u32,
    outbox: Outbox,
    expected: u16,
    /// Answer to the message before the expected one.
    last: Option<Answer>,
    reply: Option<Reply>,
    reply_wire: [u8; REPLY_WIRE],
    reply_length: usize,
    writing: Writing,
}

impl Session {
    /// The side that opens sessions. None is open yet.
    pub const fn host(timing: Timing) -> Self {
        Self::new(Role::Host, timing)
    }

    /// The side that answers.
    pub const fn device(timing: Timing) -> Self {
        Self::new(Role::Device, timing)
    }

    const fn new(role: Role, timing: Timing) -> Self {
        Self {
            role,
            id: 0,
            previous: 0,
            outbox: Outbox::new(timing),
            expected: 0,
            last: None,
            reply: None,
            reply_wire: [0; REPLY_WIRE],
            reply_length: 0,
            writing: Writing::Nothing,
        }
    }

    /// Opens a session as the host: whatever was under way is forgotten and Hello is put under way.
    ///
    /// `id` must differ from the sessions before it, also from those of a host that was killed: draw it at random.
    /// 0 is taken as 1.
    ///
    /// # Errors
    /// None in practice: Hello fits into a frame.
    pub fn open(&mut self, id: u32, hello: Hello) -> Result<(), SendError> {
        self.restart(id.max(1));
        self.send(&Message::Hello(hello))
    }

    /// Number of the open session, if one is.
    pub fn id(&self) -> Option<u32> {
        (self.id != 0).then_some(self.id)
    }

    /// A message can be put under way.
    pub fn is_ready(&self) -> bool {
        self.id != 0 && self.outbox.is_empty()
    }

    /// Puts a message under way.
    ///
    /// # Errors
    /// See [`SendError`]; nothing has changed then.
    pub fn send(&mut self, message: &Message<'_>) -> Result<(), SendError> {
        if self.id == 0 {
            return Err(SendError::Closed);
        }
        if !self.outbox.is_empty() {
            return Err(SendError::Waiting);
        }
        self.outbox.load(message, self.id).map_err(|_| SendError::TooLong)
    }

    /// Bytes to write now; empty when nothing is due. Answers go before messages, a frame begun is finished first.
    pub fn outgoing(&mut self, now: u32) -> &[u8] {
        if self.writing == Writing::Nothing {
            if let Some(reply) = self.reply.take() {
                self.reply_length = reply.encode(&mut self.reply_wire);
                self.writing = Writing::Reply(0);
            } else if self.outbox.due(now) {
                self.writing = Writing::Message(0);
            }
        }
        let (wire, from) = match self.writing {
            Writing::Nothing => return &[],
            Writing::Reply(from) => (self.reply_wire.get(..self.reply_length), from),
            Writing::Message(from) => (Some(self.outbox.wire()), from),
        };
        wire.and_then(|wire| wire.get(from..)).unwrap_or(&[])
    }

    /// `count` of the bytes that [`Self::outgoing`] showed have left.
    pub fn advance(&mut self, count: usize, now: u32) {
        self.writing = match self.writing {
            Writing::Reply(from) if count < self.reply_length.saturating_sub(from) => {
                Writing::Reply(from + count)
            }
            Writing::Message(from) if count < self.outbox.wire().len().saturating_sub(from) => {
                Writing::Message(from + count)
            }
            Writing::Message(_) => {
                self.outbox.sent(now);
                Writing::Nothing
            }
            Writing::Nothing | Writing::Reply(_) => Writing::Nothing,
        };
    }

    /// The session ends here if the other side has been silent too long. To be called now and then.
    pub fn tick(&mut self, now: u32) -> Option<Loss> {
        let silent = self.id != 0 && self.outbox.is_overdue(now);
        silent.then(|| self.lose(Loss::Silence))
    }

    /// Takes a frame.
    pub fn receive<'a>(&mut self, frame: &Frame<'a>) -> Incoming<'a> {
        let Header { version, kind, sequence, session } = frame.header;
        if version != VERSION {
            return self.other_version(frame.header);
        }
        match kind {
            kind::ACK | kind::NACK => self.receive_answer(frame),
            _ if self.id != 0 && session == self.id => self.receive_message(frame),
            kind::HELLO
                if self.role == Role::Device && sequence == 0 && session != 0 && session != self.previous =>
            {
                if Message::decode(kind, frame.payload).is_none() {
                    return self.object(frame.header, Reason::Malformed.nack(u32::from(kind)));
                }
                self.restart(session);
                self.receive_message(frame)
            }
            _ if self.role == Role::Device => self.object(frame.header, Reason::NoSession.nack(0)),
            _ => Incoming::Nothing,
        }
    }

    /// Answers the message that [`Self::receive`] gave out last: it counts as received and is not given out again.
    pub fn answer(&mut self, answer: Answer) {
        self.reply = Some(Reply { sequence: self.expected, session: self.id, answer });
        self.last = Some(answer);
        self.expected = self.expected.wrapping_add(1);
    }

    fn receive_message<'a>(&mut self, frame: &Frame<'a>) -> Incoming<'a> {
        let Header { kind, sequence, session, .. } = frame.header;
        if sequence == self.expected {
            let message = Message::decode(kind, frame.payload);
            if message.is_none() {
                self.answer(Err(Reason::Malformed.nack(u32::from(kind))));
            }
            message.map_or(Incoming::Nothing, Incoming::Message)
        } else {
            if sequence == self.expected.wrapping_sub(1)
                && let Some(answer) = self.last
            {
                self.reply = Some(Reply { sequence, session, answer });
            }
            Incoming::Nothing
        }
    }

    fn receive_answer<'a>(&mut self, frame: &Frame<'a>) -> Incoming<'a> {
        let Header { kind, sequence, session, .. } = frame.header;
        if self.id == 0 || session != self.id {
            return Incoming::Nothing;
        }
        let answer = match (kind, frame.payload) {
            (kind::ACK, []) => Ok(()),
            (kind::NACK, payload) => match message::exactly::<Nack>(payload) {
                Some(Nack { reason: Reason::NoSession, .. }) => {
                    return Incoming::Lost(self.lose(Loss::Unknown));
                }
                Some(nack) => Err(nack),
                None => return Incoming::Nothing,
            },
            _ => return Incoming::Nothing,
        };
        if !self.outbox.answered(sequence) {
            return Incoming::Nothing;
        }
        // The rest of a repetition that is being written is no longer of use; the next delimiter ends it.
        if matches!(self.writing, Writing::Message(_)) {
            self.writing = Writing::Nothing;
        }
        Incoming::Answered(answer)
    }

    /// A frame of another version: the device says so in its own, the host gives up.
    fn other_version<'a>(&mut self, header: Header) -> Incoming<'a> {
        match self.role {
            Role::Device => self.object(header, Reason::Version.nack(u32::from(VERSION))),
            Role::Host if self.id != 0 && header.session == self.id => {
                Incoming::Lost(self.lose(Loss::Version(header.version)))
            }
            Role::Host => Incoming::Nothing,
        }
    }

    /// Answers a frame that belongs to no session of ours.
    fn object<'a>(&mut self, Header { sequence, session, .. }: Header, nack: Nack) -> Incoming<'a> {
        self.reply = Some(Reply { sequence, session, answer: Err(nack) });
        Incoming::Nothing
    }

    fn restart(&mut self, id: u32) {
        self.previous = self.id;
        self.id = id;
        self.outbox.reset();
        self.expected = 0;
        self.last = None;
        self.reply = None;
        self.writing = Writing::Nothing;
    }

    fn lose(&mut self, loss: Loss) -> Loss {
        self.restart(0);
        loss
    }
}

impl Reply {
    /// Length of its frame in `wire`; 0 if it did not fit, which [`REPLY_WIRE`] rules out.
    fn encode(&self, wire: &mut [u8]) -> usize {
        let kind = if self.answer.is_ok() { kind::ACK } else { kind::NACK };
        let header = Header { version: VERSION, kind, sequence: self.sequence, session: self.session };
        match &self.answer {
            Ok(()) => frame::encode(&header, &(), wire),
            Err(nack) => frame::encode(&header, nack, wire),
        }
        .unwrap_or(0)
    }
}

#[cfg(test)]
mod tests;
