//! The co-processor's firmware: start-up checks, then the main loop for ever.
//!
//! Exit codes towards the emulator: 101 panic, 102 hard fault, 103 flush-to-zero is on.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is a program for a board; `varsac simulate --board m4f` builds and starts it");
}

#[cfg(target_os = "none")]
mod board_main;
#[cfg(target_os = "none")]
mod hardware;
#[cfg(target_os = "none")]
mod startup;
