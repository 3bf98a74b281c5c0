//! The text format of the vectors, simple enough for a program without a heap.
//!
//! A line is `name: words`; words are 32 bits in hex, separated by spaces. Lines of the same name follow each other
//! and are one list. After `#` comes the same in decimal, for people. A blank line ends a case.

use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Contract that the vectors belong to.
const CONTRACT_VERSION: u32 = 2;

/// How people read the words of a list.
#[derive(Clone, Copy)]
pub(crate) enum Reading {
    Float,
    Integer,
}

/// The named lists of one case.
#[derive(Default)]
pub(crate) struct Case {
    lists: Vec<(String, Vec<u32>, Reading)>,
}

impl Case {
    /// Adds a list of numbers.
    pub(crate) fn floats(mut self, name: &str, values: &[f32]) -> Self {
        // A rejected fit has no numbers; a vector with NaN would not be the same on every machine.
        assert!(values.iter().all(|value| !value.is_nan()), "{name} has a NaN: choose another case");
        self.lists.push((name.to_owned(), values.iter().map(|v| v.to_bits()).collect(), Reading::Float));
        self
    }

    /// Adds a list of integers.
    pub(crate) fn integers(mut self, name: &str, values: impl IntoIterator<Item = u32>) -> Self {
        self.lists.push((name.to_owned(), values.into_iter().collect(), Reading::Integer));
        self
    }

    /// The words of a list.
    pub(crate) fn words(&self, name: &str) -> &[u32] {
        let list = self.lists.iter().find(|(other, ..)| other == name);
        list.map_or(&[], |(_, words, _)| words)
    }

    /// The numbers of a list.
    pub(crate) fn numbers(&self, name: &str) -> Vec<f32> {
        self.words(name).iter().map(|&bits| f32::from_bits(bits)).collect()
    }

    /// The only word of a list.
    pub(crate) fn word(&self, name: &str) -> u32 {
        match self.words(name) {
            [word] => *word,
            words => panic!("{name} has {} words and not one", words.len()),
        }
    }

    /// Compares a list with what the core has.
    pub(crate) fn expect_floats(&self, name: &str, found: &[f32]) {
        let bits: Vec<u32> = found.iter().map(|value| value.to_bits()).collect();
        assert_eq!(hex(self.words(name)), hex(&bits), "{name}: the vector against the core, {found:?}");
    }

    /// Compares a list with what the core has.
    pub(crate) fn expect_integers(&self, name: &str, found: &[u32]) {
        assert_eq!(self.words(name), found, "{name}: the vector against the core");
    }
}

fn hex(words: &[u32]) -> Vec<String> {
    words.iter().map(|word| format!("{word:08x}")).collect()
}

/// Compares `tests/vectors/NAME.txt` with what the reference makes, or rewrites it when `VARSAC_BLESS` is set, and hands
/// each case that was *read* to `core`.
pub(crate) fn check_file(name: &str, what: &str, cases: &[Case], core: impl Fn(&Case)) {
    let path: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("vectors").join(format!("{name}.txt"));
    let made = render(name, what, cases);
    if std::env::var_os("VARSAC_BLESS").is_some_and(|value| value == "1") {
        std::fs::write(&path, &made).expect("tests/vectors can be written to");
    }
    let text = std::fs::read_to_string(&path).unwrap_or_default();
    for (number, (line, expected)) in text.lines().zip(made.lines()).enumerate() {
        assert_eq!(line, expected, "{}:{}: the file against the reference", path.display(), number + 1);
    }
    assert_eq!(text.len(), made.len(), "{}: VARSAC_BLESS=1 rewrites it", path.display());
    let read = parse(&text);
    assert_eq!(read.len(), cases.len());
    for case in &read {
        core(case);
    }
}

fn render(name: &str, what: &str, cases: &[Case]) -> String {
    let mut text = format!(
        "# varsac vectors: {name}\n# {what}\n# Numeric contract version {CONTRACT_VERSION} (core/docs/numerics.md). Made by varsac-reference;\n\
         # rewrite: VARSAC_BLESS=1 cargo test -p varsac-tests --test vectors\n"
    );
    for case in cases {
        text.push('\n');
        for (list, words, reading) in &case.lists {
            if words.is_empty() {
                let _ = writeln!(text, "{list}:");
            }
            for row in words.chunks(9) {
                let decimals: Vec<String> = row.iter().map(|&word| decimal(word, *reading)).collect();
                let _ = writeln!(text, "{list}: {} # {}", hex(row).join(" "), decimals.join(" "));
            }
        }
    }
    text
}

fn decimal(word: u32, reading: Reading) -> String {
    match reading {
        Reading::Float => format!("{:e}", f32::from_bits(word)),
        Reading::Integer => word.to_string(),
    }
}

fn parse(text: &str) -> Vec<Case> {
    let mut cases: Vec<Case> = Vec::new();
    let mut open = false;
    for line in text.lines() {
        let content = line.split('#').next().unwrap_or_default().trim();
        let Some((name, words)) = content.split_once(':') else {
            open = open && !line.is_empty();
            continue;
        };
        if !open {
            cases.push(Case::default());
            open = true;
        }
        let lists = &mut cases.last_mut().expect("a case is open").lists;
        let words = words.split_whitespace().map(|word| u32::from_str_radix(word, 16).expect("a hex word"));
        match lists.last_mut() {
            Some((last, list, _)) if last == name => list.extend(words),
            _ => lists.push((name.to_owned(), words.collect(), Reading::Integer)),
        }
    }
    cases
}
