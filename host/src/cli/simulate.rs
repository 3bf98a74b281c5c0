//! `varsac simulate`: `varsac locate` with the search done by a co-processor.

use clap::Args;
use varsac_firmware_sim::app::Event;
use varsac_firmware_sim::board::{BOARDS, Board, by_name};
use varsac_firmware_sim::native::{Native, limits};

use super::Outcome;
use super::locate::{self, LocateArgs};
use crate::error::InputError;
use crate::locate::Method;
use crate::simulate::firmware::{Program, build};
use crate::simulate::transport::{Serial, Thread};
use crate::simulate::{Carrier, CoProcessor, Emulator, Transport};

/// Options of `varsac simulate`.
#[derive(Debug, Args)]
#[command(after_help = "\
Boards (emulated by QEMU; the firmware is built when needed): m3, m4f, m7, m33, m55. With --native and --board the
co-processor is a thread that is held to the limits of that board.

Examples:
  varsac simulate scan.ply --check
  varsac simulate frames/tree-1 --board m4f --check --log
  varsac simulate scan.ply --fruit none --viewpoint none --check
  varsac simulate frames/* --board m7 --memory --json
  varsac simulate frames/tree-1 --serial /dev/ttyACM0 --baud 921600")]
#[allow(clippy::struct_excessive_bools, reason = "each is a switch of the command line")]
pub(super) struct SimulateArgs {
    #[command(flatten)]
    locate: LocateArgs,
    /// Emulate this board.
    #[arg(long, value_name = "NAME", value_parser = parse_board)]
    board: Option<&'static Board>,
    /// Run the co-processor's program in a thread [default, unless a board or a serial port is named].
    #[arg(long)]
    native: bool,
    /// Let the frames pass through memory shared with the emulated board instead of its UART.
    #[arg(long, requires = "board", conflicts_with = "native")]
    memory: bool,
    /// Use the co-processor at this serial port.
    #[arg(long, value_name = "DEVICE", conflicts_with_all = ["native", "board"])]
    serial: Option<String>,
    /// Speed of the serial port.
    #[arg(long, default_value_t = 115_200, requires = "serial")]
    baud: u32,
    /// Do every search on this machine too and compare bit by bit; a difference is exit code 1.
    #[arg(long)]
    check: bool,
    /// Show the firmware's log on standard error.
    #[arg(long, conflicts_with = "serial")]
    log: bool,
}

fn parse_board(name: &str) -> Result<&'static Board, String> {
    by_name(name).ok_or_else(|| {
        let names: Vec<&str> = BOARDS.iter().map(|board| board.name).collect();
        format!("there are {}", names.join(", "))
    })
}

/// Runs the command.
pub(super) fn run(args: &SimulateArgs) -> Result<Outcome, InputError> {
    if !matches!(args.locate.method(), Method::Map | Method::Mixture | Method::Varsac) {
        return Err(InputError::at(
            "--method",
            "is not one of the co-processor's",
            "leave it out, or give map, mixture or varsac",
        ));
    }
    let (emulated, transport) = connect(args)?;
    let mut co_processor = CoProcessor::new(transport, args.check);
    let located = locate::run_with(&args.locate, &mut co_processor);
    if let Some(emulated) = emulated {
        emulated.finish(args.log)?;
    }
    let outcome = located?;
    if let Some(bytes) = co_processor.stack_bytes() {
        eprintln!("co-processor: {bytes} bytes of stack at most");
    }
    if !args.check {
        return Ok(outcome);
    }
    for difference in co_processor.differences() {
        eprintln!("varsac: {difference}");
    }
    let (searches, differing) = (co_processor.searches(), co_processor.differences().len());
    eprintln!("check: {searches} searches on the co-processor and here, {differing} with other bits");
    Ok(if differing > 0 { Outcome::NothingFound } else { outcome })
}

/// An emulated board, and the program on it.
struct Emulated {
    emulator: Emulator,
    #[cfg_attr(not(feature = "firmware-log"), allow(dead_code, reason = "the words of the log are in it"))]
    elf: std::path::PathBuf,
}

impl Emulated {
    /// Ends the board and shows what it logged.
    fn finish(mut self, log: bool) -> Result<(), InputError> {
        self.emulator.kill();
        if !log {
            return Ok(());
        }
        #[cfg(feature = "firmware-log")]
        for line in crate::simulate::log::decode(&self.elf, &self.emulator.log_path())? {
            eprintln!("{line}");
        }
        #[cfg(not(feature = "firmware-log"))]
        return Err(InputError::at(
            "--log",
            "this program was built without the decoder of the board's log",
            "build it with `--features firmware-log`",
        ));
        #[cfg(feature = "firmware-log")]
        Ok(())
    }
}

fn connect(args: &SimulateArgs) -> Result<(Option<Emulated>, Box<dyn Transport>), InputError> {
    if let Some(device) = &args.serial {
        return Ok((None, Box::new(Serial::open(device, args.baud)?)));
    }
    match args.board {
        Some(board) if !args.native => {
            eprintln!("building the firmware for {} ({})", board.name, board.processor);
            let elf = build(board, Program::Firmware, None)?;
            let carrier = if args.memory { Carrier::Memory } else { Carrier::Uart };
            let (emulator, transport) = Emulator::start(board, &elf, carrier)?;
            Ok((Some(Emulated { emulator, elf }), transport))
        }
        board => {
            let log = args.log;
            let show = move |event: Event| {
                if log {
                    eprintln!("co-processor: {event:?}");
                }
            };
            Ok((None, Box::new(Thread(Native::start(limits(board), show)))))
        }
    }
}
