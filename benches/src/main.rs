//! `varsac-bench counts`: instructions of every contender, counted by Valgrind.
//!
//! The program starts itself under `valgrind --tool=cachegrind` twice for each contender, with different numbers of runs; the
//! difference of the two counts, divided by the difference in units of work, is what one unit costs. What comes before
//! the first run (data, normals, trees, reading the frame) is the same in both and drops out. The figures repeat to
//! a few instructions, whatever else the machine is doing.
//!
//! Valgrind tells the program that its processor is an older one, so that "widest registers" are 128 bits here and the
//! counts of that row, and of the colour gate, are those of the narrowest PC.

use std::path::Path;
use std::process::{Command, ExitCode};

use varsac_bench::{Group, render_frame};

/// Runs of the shorter of the two.
const SHORT: u32 = 1;
/// Runs of the longer one.
const LONG: u32 = 3;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let outcome = match words[..] {
        ["counts"] => counts(&Group::ALL),
        ["counts", name] => match Group::ALL.into_iter().find(|group| group.name() == name) {
            Some(group) => counts(&[group]),
            None => Err(format!("{name} is no group: give point, neighbourhood, hypothesis, fruit or frame")),
        },
        ["work", group, place, runs, frame] => work(group, place, runs, Path::new(frame)),
        _ => Err("usage: varsac-bench counts [point|neighbourhood|hypothesis|fruit|frame]".to_owned()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("varsac-bench: {problem}");
            ExitCode::FAILURE
        }
    }
}

/// Prints the table.
fn counts(groups: &[Group]) -> Result<(), String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    if groups.contains(&Group::Frame) {
        render_frame(folder.path()).map_err(|error| error.to_string())?;
    }
    println!("| what | unit | instructions a unit | first / this |");
    println!("| --- | --- | ---: | ---: |");
    for &group in groups {
        let names = group
            .with(folder.path(), |contenders| contenders.iter().map(|c| c.name).collect::<Vec<_>>())
            .map_err(|error| error.to_string())?;
        let mut first = None;
        for (place, name) in names.iter().enumerate() {
            let [short, long] = [SHORT, LONG].map(|runs| counted(group, place, runs, folder.path()));
            let (short, long) = (short?, long?);
            let units = long.units.checked_sub(short.units).filter(|&units| units > 0);
            let units = units.ok_or_else(|| format!("{name}: more runs did no more work"))?;
            let each = (long.instructions as f64 - short.instructions as f64) / units as f64;
            let ratio = *first.get_or_insert(each) / each;
            let decimals = usize::from(each < 1000.0);
            println!("| {name} | {} | {each:.decimals$} | {ratio:.2} |", group.name());
        }
    }
    Ok(())
}

/// What one run of this program under Valgrind came to.
struct Counted {
    instructions: u64,
    units: u64,
}

fn counted(group: Group, place: usize, runs: u32, frame: &Path) -> Result<Counted, String> {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let output = Command::new("valgrind")
        .args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"])
        .arg(program)
        .args(["work", group.name(), &place.to_string(), &runs.to_string()])
        .arg(frame)
        // One thread: what the second one does while it waits for work is nobody's cost.
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .map_err(|error| {
            format!("valgrind cannot be started ({error}); install it with `apt-get install valgrind`")
        })?;
    let (report, said) = (String::from_utf8_lossy(&output.stderr), String::from_utf8_lossy(&output.stdout));
    // "==123== I   refs:      1,234,567"
    let digits = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>();
    let line = report.lines().find_map(|line| line.split_once("refs:").map(|(_, count)| digits(count)));
    match (line.and_then(|count| count.parse().ok()), said.trim().parse()) {
        (Some(instructions), Ok(units)) if output.status.success() => Ok(Counted { instructions, units }),
        _ => Err(format!("no count in what valgrind said:\n{report}")),
    }
}

/// The part that runs under Valgrind: does the work and prints how many units it was.
fn work(group: &str, place: &str, runs: &str, frame: &Path) -> Result<(), String> {
    let group = Group::ALL.into_iter().find(|known| known.name() == group).ok_or("no such group")?;
    let (place, runs): (usize, u32) =
        place.parse().ok().zip(runs.parse().ok()).ok_or("place and runs are numbers")?;
    let units: Option<u64> = group
        .with(frame, |contenders| {
            let mut contender = contenders.into_iter().nth(place)?;
            Some((0..runs).map(|_| (contender.work)()).sum())
        })
        .map_err(|error| error.to_string())?;
    println!("{}", units.ok_or("no such contender")?);
    Ok(())
}
