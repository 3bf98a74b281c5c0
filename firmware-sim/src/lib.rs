//! The co-processor: receives a cloud, searches it, reports each fruit as soon as it is found.
//!
//! * [`app`]: the main loop, the same on a board and on a PC. It knows the link and the core and nothing of hardware;
//!   a [`app::Machine`] carries its bytes and tells it the time.
//! * [`board`]: the boards the emulator has, and how large a cloud and how long a search each of them is given.
//! * [`rings`]: the link's bytes in memory that host and board share, for bulk.
//! * [`scene`], [`view`], [`body`]: clouds, views with mask and outline, and complete surfaces that board and host can both make
//!   from a number, for proofs without a link.
//! * `native` (feature): the main loop in a thread of a PC program, held to the limits of a board.
//!
//! The programs for the boards are `src/bin/firmware` (the co-processor) and `src/bin/prove` (measurements).
#![no_std]

#[cfg(feature = "native")]
extern crate std;

pub mod app;
pub mod board;
pub mod body;
#[cfg(feature = "native")]
pub mod native;
pub mod rings;
pub mod scene;
pub mod view;
