//! A board in the emulator (QEMU), with the host at the other end of its UART or in its memory.

use std::fs::{File, OpenOptions};
use std::os::unix::net::UnixListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;
use varsac_firmware_sim::board::Board;

use super::transport::{Rings, Socket, Transport};
use crate::error::InputError;

/// What carries the frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Carrier {
    /// The emulated UART: as slow as the emulator's.
    Uart,
    /// Memory shared with the board: for bulk.
    Memory,
}

/// The program that emulates.
const QEMU: &str = "qemu-system-arm";
/// Longest wait for the emulator to open its end of the UART.
const START: Duration = Duration::from_secs(20);

/// A running emulator; dropping it ends it.
pub struct Emulator {
    child: Child,
    folder: TempDir,
}

impl Emulator {
    /// Starts `elf` on `board` and connects to it.
    ///
    /// # Errors
    /// When the emulator is not installed or does not start, or the board has no memory to share.
    pub fn start(
        board: &Board,
        elf: &Path,
        carrier: Carrier,
    ) -> Result<(Self, Box<dyn Transport>), InputError> {
        let folder = tempfile::tempdir().map_err(|error| {
            InputError::at(
                "temporary folder",
                format!("cannot be made ({error})"),
                "check TMPDIR and the disk",
            )
        })?;
        let mut command = Command::new(QEMU);
        command.args(["-nographic", "-monitor", "none"]);
        let (transport, listener): (Option<Box<dyn Transport>>, _) = match carrier {
            Carrier::Memory => {
                let region = board.shared.ok_or_else(|| {
                    InputError::at(
                        board.name,
                        "has no memory that the emulator can share",
                        "leave the memory carrier out",
                    )
                })?;
                let path = folder.path().join("memory");
                let rings =
                    shared_file(&path, u64::from(region.length)).map_err(|error| io_error(&path, &error))?;
                command
                    .args(["-M", &format!("{},memory-backend=psram", board.machine), "-object"])
                    .arg(format!(
                        "memory-backend-file,id=psram,size={},mem-path={},share=on",
                        region.length,
                        path.display()
                    ))
                    .args(["-serial", "null"]);
                (Some(Box::new(rings)), None)
            }
            Carrier::Uart => {
                let path = folder.path().join("uart");
                let listener = UnixListener::bind(&path).map_err(|error| io_error(&path, &error))?;
                listener.set_nonblocking(true).map_err(|error| io_error(&path, &error))?;
                command
                    .args(["-M", board.machine, "-chardev"])
                    .arg(format!("socket,id=u0,path={}", path.display()))
                    .args(["-serial", "chardev:u0"]);
                (None, Some(listener))
            }
        };
        let log = folder.path().join("log");
        let log_file = File::create(&log).map_err(|error| io_error(&log, &error))?;
        let errors = folder.path().join("errors");
        let error_file = File::create(&errors).map_err(|error| io_error(&errors, &error))?;
        command
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(elf)
            .stdin(Stdio::null())
            .stdout(log_file)
            .stderr(error_file);
        let child = command.spawn().map_err(|error| missing(&error))?;
        let mut emulator = Self { child, folder };
        let transport = match (transport, listener) {
            (Some(transport), _) => transport,
            (None, Some(listener)) => emulator.accept(&listener)?,
            (None, None) => unreachable!("one of the two was made above"),
        };
        Ok((emulator, transport))
    }

    /// What the firmware logged so far, as it came (defmt frames).
    pub fn log_path(&self) -> PathBuf {
        self.folder.path().join("log")
    }

    /// What the emulator itself complained about.
    pub fn errors(&self) -> String {
        std::fs::read_to_string(self.folder.path().join("errors")).unwrap_or_default()
    }

    /// Ends the board as a power cut would.
    pub fn kill(&mut self) {
        // Both fail only if it has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }

    fn accept(&mut self, listener: &UnixListener) -> Result<Box<dyn Transport>, InputError> {
        let start = Instant::now();
        loop {
            if let Ok((stream, _)) = listener.accept() {
                stream.set_nonblocking(false).map_err(|error| io_error(Path::new("socket"), &error))?;
                return Ok(Box::new(Socket(stream)));
            }
            let ended = matches!(self.child.try_wait(), Ok(Some(_)));
            if ended || start.elapsed() > START {
                let words = self.errors();
                let what = if words.is_empty() { "did not start".into() } else { words };
                return Err(InputError::at(QEMU, what, "check its version: 7.2 or newer is needed"));
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        self.kill();
    }
}

/// Runs a program that needs no link and ends by itself; its output and exit code.
///
/// # Errors
/// When the emulator is not installed, or takes longer than `patience`.
pub fn run(
    board: &Board,
    elf: &Path,
    arguments: &[&str],
    counting: bool,
    patience: Duration,
) -> Result<(String, i32), InputError> {
    // The first argument is the program's name.
    let words: Vec<&str> = ["prove"].into_iter().chain(arguments.iter().copied()).collect();
    let mut command = Command::new("timeout");
    command.arg(patience.as_secs().to_string()).arg(QEMU);
    command.args(["-nographic", "-monitor", "none", "-serial", "null", "-M", board.machine]);
    if counting {
        // 64 ns of virtual time an instruction, so that the timers of all boards can resolve one.
        command.args(["-icount", "shift=6"]);
    }
    command
        .args([
            "-semihosting-config",
            &format!("enable=on,target=native,arg={}", words.join(",arg=")),
            "-kernel",
        ])
        .arg(elf);
    let output = command.stdin(Stdio::null()).output().map_err(|error| missing(&error))?;
    match output.status.code() {
        Some(124) => Err(InputError::at(
            format!("{} on {}", arguments.join(" "), board.name),
            format!("took longer than {} s", patience.as_secs()),
            "run it on a machine with less to do",
        )),
        Some(127) => Err(missing(&std::io::Error::from(std::io::ErrorKind::NotFound))),
        code => {
            let text = String::from_utf8_lossy(&output.stdout).into_owned();
            Ok((text, code.unwrap_or(-1)))
        }
    }
}

fn shared_file(path: &Path, length: u64) -> std::io::Result<Rings> {
    let file = OpenOptions::new().read(true).write(true).create(true).truncate(true).open(path)?;
    Rings::lay_out(file, length)
}

fn io_error(path: &Path, error: &std::io::Error) -> InputError {
    InputError::in_file(path, format!("cannot be made ({error})"), "check TMPDIR and the disk")
}

fn missing(error: &std::io::Error) -> InputError {
    InputError::at(
        QEMU,
        format!("cannot be started ({error})"),
        "install the emulator, for example with `apt-get install qemu-system-arm`, or use --native",
    )
}
