//! What every program for a board needs: which board it is, how it ends, and what it refuses to run with.

use semihosting::process::exit;
use varsac_firmware_sim::board::{BOARDS, Board};

use crate::hardware;

const EXIT_PANIC: i32 = 101;
const EXIT_FLUSH_TO_ZERO: i32 = 103;

/// The board this program was built for.
pub(crate) const BOARD: Board = {
    let mut k = 0;
    while !same(BOARDS[k].name.as_bytes(), env!("VARSAC_BOARD").as_bytes()) {
        k += 1;
    }
    BOARDS[k]
};

const fn same(a: &[u8], b: &[u8]) -> bool {
    let mut k = 0;
    while k < a.len() && k < b.len() && a[k] == b[k] {
        k += 1;
    }
    a.len() == b.len() && k == a.len()
}

/// Ends the program if the arithmetic is not that of IEEE 754: with flush-to-zero (bit 24) or rounding other than to
/// nearest (bits 22 and 23) results would differ from every other machine's.
pub(crate) fn check_arithmetic() {
    if hardware::fpscr() & 0x01C0_0000 != 0 {
        exit(EXIT_FLUSH_TO_ZERO);
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(EXIT_PANIC)
}
