//! Measurements on a board, without a link. What to do comes as the emulator's argument:
//!
//! * `digests N`: searches scenes 0 to N-1 by the paper's search and prints one digest each, to be compared with the host's;
//! * `views N`: the same for views 0 to N-1 and the default search;
//! * `bodies N`: the same for the search without a size prior;
//! * `counts paper`, `counts map`, `counts mixture`: instructions of a search and its parts (run with `-icount shift=6`) and the deepest use of
//!   the stack, which is why each has a run of its own;
//! * `flush-to-zero`: switches it on and goes through start-up, which must refuse it (exit code 103).
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("this is a program for a board; the tests of varsac-tests build and start it");
}

#[cfg(target_os = "none")]
mod counts;
#[cfg(target_os = "none")]
mod default_counts;
#[cfg(target_os = "none")]
#[path = "../firmware/hardware.rs"]
#[allow(dead_code, reason = "the firmware uses the rest")]
mod hardware;
#[cfg(target_os = "none")]
mod mixture_counts;
#[cfg(target_os = "none")]
mod prove_main;
#[cfg(target_os = "none")]
#[path = "../firmware/startup.rs"]
mod startup;
