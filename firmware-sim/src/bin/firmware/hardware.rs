//! What can only be reached through pointers: the UART's registers, the memory shared with the host, the painted
//! stack; and the handler of the hard fault. Nothing else in this package is unsafe.
#![allow(
    unsafe_code,
    reason = "registers and linker symbols have no other access; each block says why it holds"
)]

use cortex_m_rt::{ExceptionFrame, exception};
use varsac_firmware_sim::rings::{self, Ring};

const EXIT_HARD_FAULT: i32 = 102;

/// Word `offset` bytes behind `base`, read as the hardware requires: once, in order, not cached.
fn read_word(base: u32, offset: u32) -> u32 {
    // SAFETY: called below with the addresses of the board table only: device registers and shared memory, aligned,
    // always mapped, and never part of a Rust object.
    unsafe { core::ptr::read_volatile((base + offset) as *const u32) }
}

/// The counterpart of [`read_word`].
fn write_word(base: u32, offset: u32, value: u32) {
    // SAFETY: as for `read_word`; no Rust object lies there that could be changed behind the compiler's back.
    unsafe { core::ptr::write_volatile((base + offset) as *mut u32, value) }
}

/// CMSDK APB UART: DATA 0x00, STATE 0x04 (bit 0: transmitter full, bit 1: receiver full), CTRL 0x08, BAUDDIV 0x10.
pub(crate) struct Uart {
    base: u32,
}

impl Uart {
    /// Switches transmitter and receiver on. The emulator ignores the baud rate but wants one.
    pub(crate) fn new(base: u32) -> Self {
        write_word(base, 0x10, 16);
        write_word(base, 0x08, 0b11);
        Self { base }
    }

    pub(crate) fn read(&mut self) -> Option<u8> {
        (read_word(self.base, 0x04) & 0b10 != 0).then(|| read_word(self.base, 0x00) as u8)
    }

    /// True when it took the byte.
    pub(crate) fn write(&mut self, byte: u8) -> bool {
        let free = read_word(self.base, 0x04) & 0b01 == 0;
        if free {
            write_word(self.base, 0x00, u32::from(byte));
        }
        free
    }
}

/// The rings of [`rings`], if the host has laid them out.
pub(crate) struct SharedMemory {
    base: u32,
}

impl SharedMemory {
    pub(crate) fn find(base: u32) -> Option<Self> {
        (read_word(base, rings::MAGIC_AT) == rings::MAGIC).then_some(Self { base })
    }

    pub(crate) fn read(&mut self) -> Option<u8> {
        let Ring { write_at, read_at, bytes_at } = rings::TO_BOARD;
        let read = read_word(self.base, read_at);
        if rings::filled(read_word(self.base, write_at), read) == 0 {
            return None;
        }
        // The index was read before the byte: on this core loads from the same region keep their order.
        let at = read % rings::RING;
        let word = read_word(self.base, bytes_at + (at & !3));
        write_word(self.base, read_at, read.wrapping_add(1));
        Some((word >> (8 * (at & 3))) as u8)
    }

    /// True when there was room for the byte.
    pub(crate) fn write(&mut self, byte: u8) -> bool {
        let Ring { write_at, read_at, bytes_at } = rings::TO_HOST;
        let write = read_word(self.base, write_at);
        if rings::filled(write, read_word(self.base, read_at)) == rings::RING {
            return false;
        }
        let at = self.base + bytes_at + write % rings::RING;
        // SAFETY: inside the ring, which the host laid out in the board's shared memory; see `write_word`.
        unsafe { core::ptr::write_volatile(at as *mut u8, byte) };
        cortex_m::asm::dmb();
        write_word(self.base, write_at, write.wrapping_add(1));
        true
    }
}

unsafe extern "C" {
    static _stack_start: u32;
    static _stack_end: u32;
}

/// Bytes of the stack that were ever written: the start-up code painted all of it.
pub(crate) fn stack_high_water() -> u32 {
    let (top, mut at) = (&raw const _stack_start as u32, &raw const _stack_end as u32);
    while at < top && read_word(at, 0) == cortex_m_rt::STACK_PAINT_VALUE {
        at += 4;
    }
    top - at
}

/// Floating-point status register as code runs with it; 0 where there is none.
pub(crate) fn fpscr() -> u32 {
    #[cfg(target_abi = "eabihf")]
    return cortex_m::register::fpscr::read().bits();
    #[cfg(not(target_abi = "eabihf"))]
    return 0;
}

/// Switches flush-to-zero on, for the proof that start-up refuses it.
#[allow(dead_code, reason = "one of the two programs needs it")]
pub(crate) fn set_flush_to_zero() {
    #[cfg(target_abi = "eabihf")]
    {
        let mut status = cortex_m::register::fpscr::read();
        status.set_fz(true);
        // SAFETY: the bit changes how subnormals are computed and nothing that the compiler relies on.
        unsafe { cortex_m::register::fpscr::write(status) };
    }
}

/// The attribute demands an `unsafe fn`: a fault handler may run in the middle of anything. This one only leaves.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    semihosting::process::exit(EXIT_HARD_FAULT)
}
