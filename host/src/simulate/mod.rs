//! The co-processor from the host's side: hand it a configuration and a cloud, get its targets, check every bit.
//!
//! * [`Transport`]: bytes to and from a co-processor: a thread ([`transport::Thread`]), an emulated board ([`emulator`])
//!   over its UART or over shared memory, or a real one on a serial port ([`transport::Serial`]).
//! * [`client`]: the protocol on top of it, including what happens when either side is restarted.
//! * [`firmware`]: builds the program for an emulated board and says what is missing if it cannot.
//! * [`searcher`]: the co-processor in the place of the core when an input is located.
//! * [`expected`]: what the core on the host finds in the same cloud, for comparison.

pub mod client;
pub mod emulator;
pub mod expected;
pub mod firmware;
#[cfg(feature = "firmware-log")]
pub mod log;
pub mod searcher;
pub mod transport;

pub use client::{Client, Job, Outcome};
pub use emulator::{Carrier, Emulator};
pub use expected::{Difference, compare};
pub use searcher::CoProcessor;
pub use transport::Transport;
