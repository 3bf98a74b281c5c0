//! The library for C: its example on this machine and on an emulated Cortex-M4F, with the same output to the last
//! bit; and the manifests that other build systems read.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

use varsac_firmware_sim::board::by_name;
use varsac_host::simulate::emulator;
use varsac_host::simulate::firmware::{Program, build, workspace};

fn capi() -> PathBuf {
    workspace().join("core/capi")
}

fn run(command: &mut Command, install: &str) -> Output {
    let output = command.output().unwrap_or_else(|error| {
        let program = command.get_program().display();
        panic!("{program} cannot be started ({error}); install it with `apt-get install {install}`")
    });
    assert!(output.status.success(), "{command:?}:\n{}", String::from_utf8_lossy(&output.stderr));
    output
}

/// Strict C, and no fused multiply-add: the example makes its own cloud.
const FLAGS: [&str; 7] =
    ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O2", "-ffp-contract=off"];

fn on_this_machine(folder: &Path) -> String {
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--quiet", "--package", "varsac-capi", "--profile", "firmware", "--target-dir"]);
    cargo.arg(workspace().join("target/firmware")).current_dir(workspace()).env_remove("RUSTFLAGS");
    run(&mut cargo, "cargo");
    let program = folder.join("find_fruit");
    let mut gcc = Command::new("cc");
    gcc.args(FLAGS).arg("-I").arg(capi().join("include")).arg(capi().join("example/find_fruit.c"));
    gcc.arg(workspace().join("target/firmware/firmware/libvarsac.a"))
        .args(["-lm", "-lpthread", "-ldl", "-o"])
        .arg(&program);
    run(&mut gcc, "gcc");
    String::from_utf8_lossy(&run(&mut Command::new(&program), "gcc").stdout).into_owned()
}

fn on_the_board(folder: &Path) -> String {
    let m4f = by_name("m4f").unwrap();
    let library = build(m4f, Program::Library, None).unwrap_or_else(|error| panic!("{error}"));
    let (program, example) = (folder.join("find_fruit.elf"), capi().join("example"));
    let mut gcc = Command::new("arm-none-eabi-gcc");
    gcc.args(FLAGS).args([
        "-mcpu=cortex-m4",
        "-mthumb",
        "-mfloat-abi=hard",
        "-mfpu=fpv4-sp-d16",
        "--specs=rdimon.specs",
    ]);
    gcc.arg("-I").arg(capi().join("include")).arg("-T").arg(example.join("cortex-m/mps2.ld"));
    gcc.arg(example.join("cortex-m/startup.c")).arg(example.join("find_fruit.c")).arg(&library);
    gcc.args(["-Wl,--gc-sections", "-o"]).arg(&program);
    run(&mut gcc, "gcc-arm-none-eabi libnewlib-arm-none-eabi");
    let (text, code) = emulator::run(m4f, &program, &[], false, Duration::from_secs(60))
        .unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(code, 0, "{text}");
    text
}

#[test]
fn the_c_example_prints_the_same_bits_here_and_on_a_cortex_m4f() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let here = on_this_machine(folder.path());
    println!("{here}");
    assert!(here.contains("found 1\n"), "{here}");
    assert!(here.contains("step by step: the same bits"), "{here}");
    assert!(here.contains("fruit 1: accepted\n"), "{here}");
    assert!(here.contains("fruit 1: refused: uncertain, "), "{here}");
    assert!(here.contains("the paper's search: found 1\n"), "{here}");
    assert!(here.contains("a limit of -1: a field of the configuration is out of range"), "{here}");
    assert!(here.ends_with("names it: map.gate.flat\n"), "{here}");
    let there = on_the_board(folder.path());
    assert_eq!(here, there.replace('\r', ""));
}

#[test]
fn the_header_is_c_and_cpp() {
    let header = capi().join("include/varsac.h");
    for (compiler, language, standard) in [("cc", "c", "-std=c11"), ("c++", "c++", "-std=c++11")] {
        let mut command = Command::new(compiler);
        command.args([
            standard,
            "-Wall",
            "-Wextra",
            "-Wpedantic",
            "-Werror",
            "-fsyntax-only",
            "-x",
            language,
        ]);
        run(command.arg(&header), "gcc g++");
    }
}

#[test]
fn versions_agree() {
    let [major, minor, patch] = varsac_core::VERSION;
    let header = std::fs::read_to_string(capi().join("include/varsac.h")).unwrap();
    let expected = format!("#define VARSAC_VERSION VARSAC_VERSION_OF({major}, {minor}, {patch})");
    assert!(header.contains(&expected), "the header lacks: {expected}");
    let manifest = std::fs::read_to_string(capi().join("library.json")).unwrap();
    assert!(manifest.contains(&format!("\"version\": \"{major}.{minor}.{patch}\"")), "{manifest}");
}

/// The identifiers right before an opening parenthesis that are names of the library.
fn functions(text: &str) -> Vec<String> {
    let part_of_a_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let before = text.split('(').map(|piece| piece.rsplit(|c| !part_of_a_name(c)).next().unwrap_or_default());
    let mut names: Vec<String> =
        before.filter(|name| name.starts_with("varsac_")).map(str::to_owned).collect();
    names.sort();
    names.dedup();
    names
}

#[test]
fn every_function_of_the_header_is_in_the_library_and_the_other_way_round() {
    let header = std::fs::read_to_string(capi().join("include/varsac.h")).unwrap();
    let mut exported = String::new();
    for name in ["lib.rs", "search.rs", "text.rs"] {
        let source = std::fs::read_to_string(capi().join("src").join(name)).unwrap();
        exported.extend(
            source.lines().filter(|line| line.starts_with("pub") && line.contains("extern \"C\" fn")),
        );
    }
    assert_eq!(functions(&header), functions(&exported));
    assert_eq!(functions(&exported).len(), 8);
}

/// What stands between `before` and the next `after`.
fn between<'a>(text: &'a str, before: &str, after: &str) -> &'a str {
    let start = text.find(before).unwrap_or_else(|| panic!("{before} is missing")) + before.len();
    let rest = &text[start..];
    &rest[..rest.find(after).unwrap_or_else(|| panic!("{after} is missing behind {before}"))]
}

#[test]
fn header_and_library_agree_on_the_memory_of_a_search() {
    let header = std::fs::read_to_string(capi().join("include/varsac.h")).unwrap();
    let source = std::fs::read_to_string(capi().join("src/search.rs")).unwrap();
    // That a search fits is asserted when the library is compiled, for each target.
    assert_eq!(
        between(&header, "#define VARSAC_SEARCH_WORDS ", "\n"),
        between(&source, "const SEARCH_WORDS: usize = ", ";")
    );
    let source = std::fs::read_to_string(capi().join("src/types.rs")).unwrap();
    assert_eq!(
        between(&header, "#define VARSAC_FINDS_WORDS ", "\n"),
        between(&source, "const FINDS_WORDS: usize = ", ";")
    );
}

#[test]
fn every_refusal_has_its_number_in_the_header() {
    let header = std::fs::read_to_string(capi().join("include/varsac.h")).unwrap();
    let source = std::fs::read_to_string(capi().join("src/types.rs")).unwrap();
    let numbers = between(&source, "const fn verdict_number", "\n}\n");
    let mut count = 0;
    for line in numbers.lines().filter_map(|line| line.trim().strip_prefix("RefusalCode::")) {
        let (name, number) = line.trim_end_matches(',').split_once(" => ").unwrap();
        let mut constant = String::from("VARSAC_REFUSED");
        for letter in name.chars() {
            constant.extend(letter.is_uppercase().then_some('_'));
            constant.extend(letter.to_uppercase());
        }
        let expected = format!(" {constant} = {number}");
        assert!(header.contains(&expected), "the header lacks:{expected}");
        count += 1;
    }
    assert_eq!(count, header.matches(" VARSAC_REFUSED_").count());
}

#[test]
fn every_method_and_every_preset_has_its_number_in_the_header() {
    let header = std::fs::read_to_string(capi().join("include/varsac.h")).unwrap();
    let types = std::fs::read_to_string(capi().join("src/types.rs")).unwrap();
    let search = std::fs::read_to_string(capi().join("src/search.rs")).unwrap();
    // `0 => Method::Map,` and `0 => Config::jujube(),`.
    let arms = |source: &str, of: &str| -> Vec<(String, String)> {
        let arms = source.lines().filter_map(|line| line.trim().split_once(&format!(" => {of}::")));
        let numbered = arms.filter(|(number, _)| number.parse::<u8>().is_ok());
        let named = |name: &str| name.trim_end_matches(',').trim_end_matches("()").to_uppercase();
        numbered.map(|(number, name)| (number.to_owned(), named(name))).collect()
    };
    for (prefix, arms) in [("METHOD", arms(&types, "Method")), ("PRESET", arms(&search, "Config"))] {
        for (number, name) in &arms {
            let expected = format!(" VARSAC_{prefix}_{name} = {number}");
            let ends = |rest: &str| rest.starts_with([',', ' ', '/', '\n']);
            assert!(header.split(&expected).skip(1).any(ends), "the header lacks:{expected}");
        }
        assert!(arms.len() >= 3, "{prefix}: {arms:?}");
        let prefix = format!("VARSAC_{prefix}_");
        assert_eq!(arms.len(), header.lines().filter(|line| line.trim().starts_with(&prefix)).count());
    }
}

#[test]
fn every_verdict_has_its_words() {
    let header = std::fs::read_to_string(capi().join("include/varsac.h")).unwrap();
    let source = std::fs::read_to_string(capi().join("src/text.rs")).unwrap();
    let words = between(&source, "extern \"C\" fn varsac_verdict_text", "\n}\n");
    let refusals = header.matches(" VARSAC_REFUSED_").count();
    for number in 0..=refusals {
        assert!(words.contains(&format!(" {number} => c\"")), "no words for verdict {number}");
    }
    assert_eq!(words.matches(" => c\"").count(), refusals + 2, "and one text for what is none");
}

#[test]
fn every_field_that_the_core_can_object_to_has_its_name_in_c() {
    let names = std::fs::read_to_string(capi().join("src/text.rs")).unwrap();
    let header = std::fs::read_to_string(capi().join("include/varsac.h")).unwrap();
    let mut count = 0;
    for file in ["config.rs", "map/config.rs", "accept.rs"] {
        let source = std::fs::read_to_string(workspace().join("core/src").join(file)).unwrap();
        for name in source.split('"').filter(|text| text.starts_with("map.")) {
            assert!(names.contains(&format!("c\"{name}\"")), "text.rs lacks {name}");
            let field = name.rsplit('.').next().unwrap();
            assert!(header.contains(&format!(" {field}")), "the header lacks {field} of {name}");
            count += 1;
        }
    }
    assert!(count > 20, "{count}");
}

#[test]
fn the_manifests_of_other_build_systems_name_files_that_exist() {
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(capi().join("library.json")).unwrap()).unwrap();
    let folder = capi();
    let exists = |path: &str| assert!(folder.join(path).exists(), "{path} is named and missing");
    exists(&format!(
        "{}/{}",
        json["build"]["includeDir"].as_str().unwrap(),
        json["headers"].as_str().unwrap()
    ));
    exists(json["build"]["extraScript"].as_str().unwrap());
    let example = &json["examples"][0];
    exists(&format!("{}/{}", example["base"].as_str().unwrap(), example["files"][0].as_str().unwrap()));

    // Two levels of `key: value`: no need of a YAML library.
    let module = std::fs::read_to_string(capi().join("zephyr/module.yml")).unwrap();
    let value = |key: &str| {
        let line = module.lines().map(str::trim).find_map(|line| line.strip_prefix(key)?.strip_prefix(": "));
        line.unwrap_or_else(|| panic!("module.yml lacks {key}"))
    };
    assert_eq!(value("name"), "varsac");
    exists(&format!("{}/CMakeLists.txt", value("cmake")));
    exists(value("kconfig"));
}
