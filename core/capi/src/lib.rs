//! The core for C: `include/varsac.h` says what each function promises; this is its other half.
//!
//! * [`types`]: the structs that cross the border, and the sizes that the header asserts too.
//! * [`search`]: detection in one call and step by step.
//! * [`text`]: words for codes, in flash only if they are called for.
//!
//! No heap, no globals, no panic. Every pointer is checked for null and nothing else: C cannot be helped further.
#![cfg_attr(target_os = "none", no_std)]

pub mod search;
pub mod text;
pub mod types;

/// `VARSAC_VERSION` of the library: major, minor and patch in one byte each, from bit 16 down.
#[unsafe(no_mangle)]
pub extern "C" fn varsac_version() -> u32 {
    let [major, minor, patch] = varsac_core::VERSION;
    u32::from_be_bytes([0, major, minor, patch])
}

#[cfg(all(target_os = "none", feature = "no-panic-proof"))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        fn varsac_a_panic_can_be_reached() -> !;
    }
    // SAFETY: never called; if the linker looks for it, the proof has failed.
    unsafe { varsac_a_panic_can_be_reached() }
}

#[cfg(all(target_os = "none", not(feature = "no-panic-proof")))]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    loop {
        core::hint::spin_loop();
    }
}
