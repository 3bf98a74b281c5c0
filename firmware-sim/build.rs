//! For a board: writes its memory.x, tells the linker, and names it to the program. For a PC: nothing.

use std::path::Path;
use std::{env, fs};

#[path = "src/board.rs"]
#[allow(
    dead_code,
    unreachable_pub,
    reason = "the same file is a module of the library, where all of it is used"
)]
mod board;

fn main() {
    println!("cargo:rerun-if-env-changed=VARSAC_BOARD");
    println!("cargo:rerun-if-changed=src/board.rs");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let names: Vec<_> = board::BOARDS.iter().map(|board| board.name).collect();
    let target = env::var("TARGET").expect("cargo sets TARGET");
    let name = env::var("VARSAC_BOARD").unwrap_or_default();
    let board = board::by_name(&name)
        .unwrap_or_else(|| panic!("VARSAC_BOARD is '{name}'; set it to one of {}", names.join(", ")));
    assert!(board.target == target, "board {name} is built with --target {}, not {target}", board.target);

    let folder = env::var("OUT_DIR").expect("cargo sets OUT_DIR");
    let memory = format!(
        "MEMORY\n{{\n  FLASH : ORIGIN = {:#x}, LENGTH = {:#x}\n  RAM : ORIGIN = {:#x}, LENGTH = {:#x}\n}}\n\
         _stack_end = ORIGIN(RAM) + LENGTH(RAM) - {:#x};\n",
        board.flash.origin,
        board.flash.length,
        board.ram.origin,
        board.ram.length,
        board::STACK_BYTES,
    );
    fs::write(Path::new(&folder).join("memory.x"), memory).expect("OUT_DIR can be written");
    println!("cargo:rustc-link-search={folder}");
    for argument in ["-Tlink.x", "-Tdefmt.x", "--nmagic"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
    println!("cargo:rustc-env=VARSAC_BOARD={name}");
}
