//! What the core costs on a board: code, memory, stack, instructions. Each figure is printed, held by a golden file
//! (`tests/golden/budget.txt`, see [`varsac_tests::golden`]) and below a limit.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use varsac_core::{Detections, Finds, Point3, Workspace};
use varsac_firmware_sim::app::Memory;
use varsac_firmware_sim::board::{BOARDS, Board, by_name};
use varsac_host::simulate::emulator;
use varsac_host::simulate::firmware::{Program, build};
use varsac_tests::golden::{self, Figures};

const KIB: u64 = 1024;

/// Functions of the library that a program which searches calls, and all of them. All searches are in each: which one runs
/// is decided when it runs.
const SEARCH: [&str; 2] = ["varsac_config_preset", "varsac_detect"];
const EVERYTHING: [&str; 8] = [
    "varsac_begin",
    "varsac_config_preset",
    "varsac_config_problem",
    "varsac_detect",
    "varsac_status_text",
    "varsac_step",
    "varsac_verdict_text",
    "varsac_version",
];
/// What `prove counts` can be asked for. Each is a run of its own: the stack is painted once.
const SEARCHES: [&str; 3] = ["paper", "map", "mixture"];

fn tool(name: &str, arguments: &[&str]) -> String {
    let output = Command::new(name).args(arguments).output().unwrap_or_else(|error| {
        panic!("{name} cannot be started ({error}); install it with `apt-get install gcc-arm-none-eabi`")
    });
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn library(board: &Board, opt_level: &str) -> PathBuf {
    build(board, Program::Library, Some(opt_level)).unwrap_or_else(|error| panic!("{error}"))
}

/// Code and constants of a program that calls `functions` of the library, all that they need included. It links only
/// if no panic can be reached.
fn linked_size(library: &Path, functions: &[&str]) -> u64 {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let program = folder.path().join("program.elf");
    let (library, program) = (library.display().to_string(), program.display().to_string());
    let mut arguments = vec!["--gc-sections", "-e", functions[0]];
    for function in functions {
        arguments.extend(["-u", function]);
    }
    arguments.extend([library.as_str(), "-o", program.as_str()]);
    tool("arm-none-eabi-ld", &arguments);
    let sizes = tool("arm-none-eabi-size", &[&program]);
    let figures: Vec<u64> = sizes
        .lines()
        .nth(1)
        .unwrap_or_default()
        .split_whitespace()
        .map_while(|word| word.parse().ok())
        .collect();
    assert!(figures.len() >= 3, "{sizes}");
    assert_eq!(figures[1..3], [0, 0], "the library has no variables of its own");
    figures[0]
}

#[test]
fn the_core_fits_its_budget() {
    let mut figures = Figures::new();
    sizes(&mut figures);
    memory(&mut figures);
    for board in &BOARDS {
        counts(board, &mut figures);
    }
    golden::check("budget", "what the core costs on the boards: bytes and instructions", &figures);

    // The limits. What was promised and is missed is said, with what holds instead.
    let at_most = |name: &str, limit: u64| {
        let value = figures[name];
        assert!(value <= limit, "{name} is {value}, above {limit}");
    };
    // 64 KiB for everything held for size, and was missed for speed, while there were two searches; the one without a size prior
    // brings a third of what there is now. 32 KiB for the paper's search alone was for a library that had no other: which
    // search runs is decided at run time, so all are linked.
    at_most("m4f.Os.everything_bytes", 80 * KIB);
    at_most("m4f.O2.everything_bytes", 108 * KIB);
    at_most("memory.bytes_per_point", 17);
    at_most("memory.finds_bytes_host", 6 * KIB);
    at_most("m4f.tebc_point_x100", 4000);
    // 8 KiB for any search hold on every board; 4 KiB for the paper's are missed: 3 KiB of each figure are frames of the
    // measuring program.
    for board in &BOARDS {
        at_most(&format!("{}.stack_bytes", board.name), 6 * KIB + KIB / 2);
        at_most(&format!("{}.map.stack_bytes", board.name), 8 * KIB);
        at_most(&format!("{}.mixture.stack_bytes", board.name), 8 * KIB);
    }
    at_most("m4f.map.fruit", 6_000_000);
    at_most("m4f.map.longest_step", 250_000);
    at_most("m4f.mixture.surface", 22_000_000);
    at_most("m4f.mixture.longest_step", 350_000);
}

fn sizes(figures: &mut Figures) {
    for board in &BOARDS {
        let levels: &[&str] = if board.name == "m4f" { &["s", "2"] } else { &["2"] };
        for level in levels {
            let library = library(board, level);
            figures.insert(format!("{}.O{level}.search_bytes", board.name), linked_size(&library, &SEARCH));
            figures.insert(
                format!("{}.O{level}.everything_bytes", board.name),
                linked_size(&library, &EVERYTHING),
            );
        }
    }
}

fn memory(figures: &mut Figures) {
    let lists = size_of::<Workspace<4096>>() - size_of::<Finds>();
    figures
        .insert("memory.bytes_per_point".into(), (lists + size_of::<[Point3; 4096]>()).div_ceil(4096) as u64);
    figures.insert("memory.finds_bytes_host".into(), size_of::<Finds>() as u64);
    figures.insert("memory.run_bytes_host".into(), size_of::<Detections<'_>>() as u64);
    // On this machine; pointers are half as long on the boards.
    let constant = size_of::<Memory<4096>>() - 17 * 4096;
    figures.insert("memory.firmware_constant_bytes_host".into(), constant as u64);
}

fn counts(board: &Board, figures: &mut Figures) {
    let elf = build(board, Program::Prove, None).unwrap_or_else(|error| panic!("{error}"));
    for search in SEARCHES {
        let (text, code) = emulator::run(board, &elf, &["counts", search], true, Duration::from_secs(300))
            .unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(code, 0, "{}: {text}", board.name);
        for line in text.lines() {
            let (name, value) = line.split_once(' ').unwrap_or_else(|| panic!("{}: {line}", board.name));
            let value = value.parse().unwrap_or_else(|_| panic!("{line}"));
            figures.insert(format!("{}.{name}", board.name), value);
        }
    }
}

#[test]
fn the_library_has_no_panic_no_allocator_and_no_formatting() {
    for level in ["s", "2"] {
        let library = library(by_name("m4f").unwrap(), level);
        let symbols = tool("arm-none-eabi-nm", &["--no-sort", &library.display().to_string()]);
        // The archive's first object is all of the Rust code; the others are the compiler's own arithmetic, of which a
        // program gets what it calls.
        let ours = symbols
            .split("\n\n")
            .find(|object| object.contains(" T varsac_detect"))
            .expect("the library's object");
        for forbidden in ["panic", "alloc", "fmt", "unwind", "varsac_a_panic_can_be_reached"] {
            let found: Vec<&str> = ours.lines().filter(|line| line.contains(forbidden)).collect();
            assert!(found.is_empty(), "O{level}, {forbidden}: {found:?}");
        }
        let undefined: Vec<&str> = ours.lines().filter_map(|line| line.trim().strip_prefix("U ")).collect();
        println!("at O{level} the library calls only: {undefined:?}");
        let arithmetic =
            |name: &&str| name.starts_with("__aeabi_") || name.starts_with("mem") || name.starts_with("__");
        assert!(undefined.iter().all(arithmetic), "O{level}: {undefined:?}");
        for search in ["MapRun", "MixtureRun"] {
            assert!(ours.contains(search), "O{level}: {search} is not in what was looked at");
        }
    }
}
