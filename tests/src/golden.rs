//! Figures kept in files: growth is allowed, silence about it is not.
//!
//! A golden file is text: a header of `#` lines (what, how made, which compiler) and one `name value` a line. A test
//! hands over what it measured; a difference fails it and prints both values. `VARSAC_BLESS=1 cargo test` rewrites
//! the files, and a person reviews the change. With another compiler than the file's, counts and sizes of generated
//! code may differ without anybody's doing: then the difference is printed and only the limits of the test hold.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::Command;

/// Measured figures by name.
pub type Figures = BTreeMap<String, u64>;

/// `tests/golden/NAME.txt`.
fn path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden").join(format!("{name}.txt"))
}

/// The compiler at work, as it names itself.
fn compiler() -> String {
    let output = Command::new("rustc").arg("--version").output();
    output
        .map_or_else(|_| "unknown".into(), |output| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

/// Holds `figures` against the golden file `name`, or rewrites it when VARSAC_BLESS is set.
///
/// # Panics
/// When a figure differs, with all differences and the command that accepts them.
pub fn check(name: &str, about: &str, figures: &Figures) {
    let path = path(name);
    let compiler = compiler();
    let mut text =
        format!("# {about}\n# rewritten by: VARSAC_BLESS=1 cargo test -p varsac-tests --test {name}\n");
    let _ = writeln!(text, "# compiler: {compiler}");
    for (figure, value) in figures {
        let _ = writeln!(text, "{figure} {value}");
    }
    println!("{text}");
    if std::env::var_os("VARSAC_BLESS").is_some() {
        std::fs::create_dir_all(path.parent().expect("a file has a folder")).expect("the folder can be made");
        std::fs::write(&path, text).expect("the golden file can be written");
        return;
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    let kept: Figures = golden
        .lines()
        .filter_map(|line| line.split_once(' '))
        .filter_map(|(figure, value)| Some((figure.to_owned(), value.parse().ok()?)))
        .collect();
    let mut differences = String::new();
    for figure in kept.keys().chain(figures.keys().filter(|figure| !kept.contains_key(*figure))) {
        let (before, now) = (kept.get(figure), figures.get(figure));
        if before != now {
            let show = |value: Option<&u64>| value.map_or("-".into(), u64::to_string);
            let _ = writeln!(differences, "  {figure}: {} -> {}", show(before), show(now));
        }
    }
    if differences.is_empty() {
        return;
    }
    let same_compiler = golden.contains(&format!("# compiler: {compiler}\n"));
    let message = format!(
        "figures differ from {} (kept -> now):\n{differences}if that is meant: VARSAC_BLESS=1 cargo test -p varsac-tests --test {name}",
        path.display()
    );
    assert!(!same_compiler, "{message}");
    println!("another compiler than the file's ({compiler}), so only told:\n{message}");
}
