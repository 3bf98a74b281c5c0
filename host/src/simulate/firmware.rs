//! Builds what runs on the boards, with the compiler that is there, and says what is missing where it is not.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::{Mutex, PoisonError};

use varsac_firmware_sim::board::Board;

use crate::error::InputError;

/// What can be built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Program {
    /// The co-processor.
    Firmware,
    /// The measurements.
    Prove,
    /// The library for C, such that a panic that can be reached does not link.
    Library,
}

impl Program {
    /// Name of the file that the compiler makes, and of the kept one's end.
    const fn names(self) -> [&'static str; 2] {
        match self {
            Self::Firmware => ["firmware", "firmware.elf"],
            Self::Prove => ["prove", "prove.elf"],
            Self::Library => ["libvarsac.a", "libvarsac.a"],
        }
    }

    const fn arguments(self) -> &'static [&'static str] {
        match self {
            Self::Firmware => {
                &["--package", "varsac-firmware-sim", "--features", "bare-metal", "--bin", "firmware"]
            }
            Self::Prove => {
                &["--package", "varsac-firmware-sim", "--features", "bare-metal", "--bin", "prove"]
            }
            Self::Library => &["--package", "varsac-capi", "--features", "no-panic-proof"],
        }
    }
}

/// Builds of one target share a folder, and a program has one name there for all boards: one build at a time.
static BUILDING: Mutex<()> = Mutex::new(());

/// The folder of the workspace this program was compiled from.
pub fn workspace() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// Builds `program` for `board` (nothing happens when it is up to date) and returns the path of its file.
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
        .args(["build", "--quiet"])
        .args(program.arguments())
        .args(["--profile", "firmware", "--target", board.target, "--target-dir"])
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
    let [built, kept] = program.names();
    let built = target_folder.join(board.target).join("firmware").join(built);
    let kept = target_folder.join(format!("{}-O{}-{kept}", board.name, opt_level.unwrap_or("2")));
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
