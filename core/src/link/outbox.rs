//! The one message under way: kept as the bytes of its frame until it is answered, sent again when no answer comes.
//!
//! One at a time is enough: a frame of 80 points takes 89 ms at 115 200 baud, the answer's round trip a few.
//! And it keeps the memory of either side at one frame, and its state in one page.

use super::frame::{MAX_WIRE, TooLong};
use super::message::Message;

/// How long to wait for answers, in ticks of the caller's choosing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timing {
    /// Ticks after which an unanswered frame is sent again for the first time: longer than the other side's longest
    /// step and the time two frames take on the wire. The wait doubles each time, up to [`LONGEST_WAIT`] times this: a
    /// line that has become slow must not be filled with repetitions.
    pub resend_after: u32,
    /// Times it is sent again before the other side counts as silent.
    pub resends: u8,
}

/// The longest wait for an answer, in units of [`Timing::resend_after`].
pub const LONGEST_WAIT: u32 = 8;

impl Timing {
    /// Ticks to wait for an answer to the n-th sending (0 is the first).
    const fn wait(self, times: u8) -> u32 {
        let doubled = if times < 3 { 1 << times } else { LONGEST_WAIT };
        self.resend_after.saturating_mul(doubled)
    }
}

/// Where the message under way stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    Empty,
    /// To be sent now, for the n-th time (0 is the first).
    Ready(u8),
    /// Sent for the n-th time, at this tick.
    Sent(u8, u32),
}

/// Buffer and timer of the message under way.
#[derive(Debug)]
pub struct Outbox {
    timing: Timing,
    state: State,
    sequence: u16,
    wire: [u8; MAX_WIRE],
    length: usize,
}

impl Outbox {
    /// Empty, next message number 0.
    pub const fn new(timing: Timing) -> Self {
        Self { timing, state: State::Empty, sequence: 0, wire: [0; MAX_WIRE], length: 0 }
    }

    /// Empties it and starts the numbers again.
    pub fn reset(&mut self) {
        self.state = State::Empty;
        self.sequence = 0;
    }

    /// Nothing is under way.
    pub fn is_empty(&self) -> bool {
        self.state == State::Empty
    }

    /// Puts a message in. The caller has looked whether it is empty.
    ///
    /// # Errors
    /// [`TooLong`], and the outbox stays empty.
    pub fn load(&mut self, message: &Message<'_>, session: u32) -> Result<(), TooLong> {
        self.length = message.encode(self.sequence, session, &mut self.wire)?;
        self.state = State::Ready(0);
        Ok(())
    }

    /// The frame, if it is to be sent now: it was not yet, or its answer is overdue and it may be sent again.
    pub fn due(&mut self, now: u32) -> bool {
        if let State::Sent(times, at) = self.state
            && now.wrapping_sub(at) >= self.timing.wait(times)
            && times < self.timing.resends
        {
            self.state = State::Ready(times + 1);
        }
        matches!(self.state, State::Ready(_))
    }

    /// Bytes of the frame, both delimiters included.
    pub fn wire(&self) -> &[u8] {
        self.wire.get(..self.length).unwrap_or(&[])
    }

    /// Its last byte has left: the wait for the answer begins.
    pub fn sent(&mut self, now: u32) {
        if let State::Ready(times) = self.state {
            self.state = State::Sent(times, now);
        }
    }

    /// Takes an answer. True when it belongs to the message under way, which then is done with.
    pub fn answered(&mut self, sequence: u16) -> bool {
        let mine = self.state != State::Empty && sequence == self.sequence;
        if mine {
            self.state = State::Empty;
            self.sequence = self.sequence.wrapping_add(1);
        }
        mine
    }

    /// The last permitted sending was not answered in time.
    pub fn is_overdue(&self, now: u32) -> bool {
        match self.state {
            State::Sent(times, at) => {
                times >= self.timing.resends && now.wrapping_sub(at) >= self.timing.wait(times)
            }
            State::Empty | State::Ready(_) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_sent_again_so_many_times_and_then_given_up() {
        let mut outbox = Outbox::new(Timing { resend_after: 10, resends: 5 });
        assert!(!outbox.due(0));
        outbox.load(&Message::Poll, 1).unwrap();
        let start = u32::MAX - 15; // across the wrap of the tick counter
        let mut sendings: heapless::Vec<u32, 8> = heapless::Vec::new();
        for tick in 0..400 {
            let now = start.wrapping_add(tick);
            if outbox.due(now) {
                sendings.push(tick).unwrap();
                outbox.sent(now);
            }
            assert_eq!(outbox.is_overdue(now), tick >= 310, "tick {tick}");
        }
        assert_eq!(sendings.as_slice(), [0, 10, 30, 70, 150, 230]);
    }

    #[test]
    fn only_its_own_answer_ends_the_wait() {
        let mut outbox = Outbox::new(Timing { resend_after: 10, resends: 2 });
        assert!(!outbox.answered(0));
        for sequence in [0, 1, 2] {
            outbox.load(&Message::Poll, 1).unwrap();
            assert!(!outbox.answered(sequence + 1));
            assert!(!outbox.answered(sequence.wrapping_sub(1)));
            assert!(outbox.answered(sequence));
            assert!(!outbox.answered(sequence), "the second answer to the same frame is nobody's");
            assert!(outbox.is_empty());
        }
    }
}
