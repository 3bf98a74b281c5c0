//! What the unit tests of the host share: real data where it is at hand, and broken files on purpose.

use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};

use rand_core::SeedableRng;
use rand_xoshiro::Xoshiro128PlusPlus;

/// A file or folder of the shared data, which is not part of the repository: under `VARSAC_SHARED` if that is set, else
/// beside the repository. Says so on standard error when it is absent; the test then has nothing to check.
pub(crate) fn shared_data(relative: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let path = std::env::var_os("VARSAC_SHARED").map_or(beside, PathBuf::from).join("data").join(relative);
    if path.exists() {
        return Some(path);
    }
    // Not eprintln!, which the test harness keeps to itself when a test passes.
    let message =
        format!("SKIPPED: {} is absent; set VARSAC_SHARED to the shared data to check it\n", path.display());
    let _ = std::io::stderr().write_all(message.as_bytes());
    None
}

/// A complete `calibration.json` whose coefficients name their own keys, so that a swapped name shows.
pub(crate) fn factory_parameters() -> serde_json::Value {
    let mut colour = serde_json::json!({"fx": 1081.37, "fy": 1081.37, "cx": 959.5, "cy": 539.5,
        "shift_d": 863.0, "shift_m": 52.0});
    for (axis, first) in [("mx", 0.0), ("my", 100.0)] {
        for (x, y) in (0..4).flat_map(|x| (0..4 - x).map(move |y| (x, y))) {
            colour[format!("{axis}_x{x}y{y}")] = (first + 10.0 * f64::from(x) + f64::from(y)).into();
        }
    }
    let ir = serde_json::json!({"fx": 368.9, "fy": 368.9, "cx": 259.3, "cy": 209.5, "k1": 0.0852, "k2": -0.272,
        "k3": 0.1006, "p1": 0.0, "p2": 0.0});
    serde_json::json!({"source": "made up", "ColorCameraParams": colour, "IrCameraParams": ir})
}

/// Feeds `count` mutations of `valid` to `read` and fails when one of them panics, naming its seed and bytes.
/// A mutation is one to four edits: flip a bit, set a byte, cut the end off, repeat, remove or replace a stretch.
pub(crate) fn mutate(name: &str, valid: &[u8], count: u64, read: impl Fn(&[u8])) {
    for seed in 0..count {
        let mut generator = Xoshiro128PlusPlus::seed_from_u64(seed);
        let mut bytes = valid.to_vec();
        for _ in 0..=varsac_core::rng::below(&mut generator, 4) {
            edit(&mut bytes, &mut generator);
        }
        let survived = catch_unwind(AssertUnwindSafe(|| read(&bytes))).is_ok();
        assert!(survived, "{name}: mutation {seed} panics on {:?}", String::from_utf8_lossy(&bytes));
    }
}

fn edit(bytes: &mut Vec<u8>, generator: &mut Xoshiro128PlusPlus) {
    /// Pieces of header that turn sizes and types into hostile ones.
    const PIECES: [&[u8]; 8] =
        [b"4294967295", b"18446744073709551615", b"-1", b"0", b"nan", b"1e999", b"\n", b"\xff\xff\xff\xff"];
    let mut below = |bound: usize| varsac_core::rng::below(generator, bound as u32) as usize;
    if bytes.is_empty() {
        return;
    }
    let at = below(bytes.len());
    let end = at + below((bytes.len() - at).min(16));
    match below(7) {
        0 => bytes[at] ^= 1 << below(8),
        1 => bytes[at] = below(256) as u8,
        2 => bytes.truncate(at),
        3 => {
            let stretch = bytes[at..end].to_vec();
            bytes.splice(at..at, stretch);
        }
        4 => drop(bytes.drain(at..end)),
        5 => drop(bytes.splice(at..end, PIECES[below(PIECES.len())].iter().copied())),
        // A number of the header, so that counts are hit often.
        _ => {
            let digit = bytes[at..].iter().position(u8::is_ascii_digit).map_or(at, |offset| at + offset);
            bytes[digit] = b'0' + below(10) as u8;
        }
    }
}

/// Runs `read` and fails when the address space of the process grew by two gibibytes or more meanwhile, used or only
/// reserved. Other tests run beside it, and each thread of theirs may reserve 128 MiB: hence not less.
#[cfg(target_os = "linux")]
pub(crate) fn without_gigabytes<T>(read: impl FnOnce() -> T) -> T {
    let peak_kib = || {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let line = status.lines().find(|line| line.starts_with("VmPeak:")).unwrap();
        line.split_ascii_whitespace().nth(1).unwrap().parse::<u64>().unwrap()
    };
    let before = peak_kib();
    let result = read();
    let grown = peak_kib() - before;
    assert!(grown < 2 << 20, "the address space grew by {grown} KiB");
    result
}

#[cfg(not(target_os = "linux"))]
pub(crate) fn without_gigabytes<T>(read: impl FnOnce() -> T) -> T {
    read()
}
