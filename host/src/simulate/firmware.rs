//! Builds the programs for the boards, with the compiler that is there, and says what is missing where it is not.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};

use varsac_firmware_sim::board::Board;

use crate::error::InputError;

/// A program of the firmware package.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Program {
    /// The co-processor.
    Firmware,
    /// The measurements.
    Prove,
}

impl Program {
    const fn name(self) -> &'static str {
        match self {
            Self::Firmware => "firmware",
            Self::Prove => "prove",
        }
    }
}

/// Builds of one target share a folder, and a program has one name there for all boards: one build at a time.
static BUILDING: Mutex<()> = Mutex::new(());

/// The folder of the workspace this program was compiled from.
pub fn workspace() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Builds `program` for `board` (nothing happens when it is up to date) and returns the path of its ELF file.
/// `opt_level` replaces the profile's.
///
/// # Errors
/// When the sources, the compiler or its target are missing, with what to install; or the compiler's own words.
pub fn build(board: &Board, program: Program, opt_level: Option<&str>) -> Result<PathBuf, InputError> {
    let _one = BUILDING.lock().unwrap_or_else(PoisonError::into_inner);
    let workspace = workspace();
    let manifest = workspace.join("firmware-sim/Cargo.toml");
    if !manifest.exists() {
        return Err(InputError::in_file(
            &manifest,
            "is not there",
            "run from a copy of the sources, or use --native",
        ));
    }
    check_target(board.target)?;
    let target_folder = workspace.join("target/firmware");
    let mut command = Command::new("cargo");
    command
        .args(["build", "--quiet", "--package", "varsac-firmware-sim", "--features", "bare-metal"])
        .args(["--bin", program.name(), "--profile", "firmware", "--target", board.target, "--target-dir"])
        .arg(&target_folder)
        .env("VARSAC_BOARD", board.name)
        // Everything is logged; who does not want it does not look.
        .env("DEFMT_LOG", "debug")
        // Flags of the surrounding build are for a PC.
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env_remove("CARGO_TARGET_DIR")
        .env("RUSTFLAGS", board.cpu.map_or(String::new(), |cpu| format!("-C target-cpu={cpu}")))
        .current_dir(workspace);
    if let Some(level) = opt_level {
        command.env("CARGO_PROFILE_FIRMWARE_OPT_LEVEL", level);
    }
    let output = run(&mut command, "cargo", "install Rust from https://rustup.rs")?;
    if !output.status.success() {
        return Err(InputError::at(
            format!("building the firmware for {}", board.name),
            String::from_utf8_lossy(&output.stderr).into_owned(),
            "correct what the compiler says",
        ));
    }
    let built = target_folder.join(board.target).join("firmware").join(program.name());
    let kept = target_folder.join(format!("{}-{}.elf", board.name, program.name()));
    std::fs::copy(&built, &kept).map_err(|error| InputError::unreadable(&built, &error))?;
    Ok(kept)
}

/// The compiler has the library of this target.
fn check_target(target: &str) -> Result<(), InputError> {
    let mut command = Command::new("rustc");
    command.args(["--print", "target-libdir", "--target", target]);
    let output = run(&mut command, "rustc", "install Rust from https://rustup.rs")?;
    let folder = PathBuf::from(String::from_utf8_lossy(&output.stdout).trim());
    if output.status.success() && folder.is_dir() {
        return Ok(());
    }
    Err(InputError::at(
        format!("target {target}"),
        "is not installed for the Rust compiler",
        format!("run `rustup target add {target}`"),
    ))
}

fn run(command: &mut Command, name: &str, remedy: &str) -> Result<Output, InputError> {
    command.output().map_err(|error| InputError::at(name, format!("cannot be started ({error})"), remedy))
}
