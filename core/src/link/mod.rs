//! The link between a host and the co-processor: typed messages over any byte stream, however bad.
//!
//! From the wire upwards:
//!
//! 1. [`frame`]: one frame as bytes. Header (version, type, sequence, session, length), payload, CRC-32, COBS, 0x00.
//! 2. [`receiver`]: bytes one at a time in, whole undamaged frames out; in step again at the next 0x00.
//! 3. [`message`], [`payload`]: what is said, in plain data, postcard encoded, and the answers to it.
//! 4. [`outbox`]: the one message under way: kept until it is answered, sent again when it is not.
//! 5. [`session`]: both sides' state machine. Every message is answered once, applied once, in order.
//! 6. [`transfer`]: a cloud with its outline, larger than a frame, cut up, put together and checked as a whole.
//!
//! No clock, no allocation, no panic, no blocking: the caller brings bytes and the time in ticks of its own choosing,
//! and each call does work bounded by [`frame::MAX_FRAME`]. The format on the wire is specified in `docs/link.md`.

pub mod frame;
pub mod message;
pub mod outbox;
pub mod payload;
pub mod receiver;
pub mod session;
pub mod transfer;

pub use frame::{Frame, MAX_FRAME, MAX_PAYLOAD, MAX_WIRE, VERSION};
pub use message::{Message, Nack, Reason};
pub use receiver::FrameReceiver;
pub use session::{Incoming, Loss, SendError, Session, Timing};
pub use transfer::{CloudReceiver, CloudSender, ViewMemory};
