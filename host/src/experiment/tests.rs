//! What holds for every experiment.

use super::*;

/// Values whose key says that the clock has a say in them.
fn without_times(value: &mut Value) {
    match value {
        Value::Object(object) => {
            object.retain(|key, _| !table::TIMING_SUFFIXES.iter().any(|suffix| key.ends_with(suffix)));
            object.values_mut().for_each(without_times);
        }
        Value::Array(values) => values.iter_mut().for_each(without_times),
        _ => {}
    }
}

/// Report and figures of a small run, without times. Figures as drawn: numbers that are none differ from themselves.
fn finished(experiment: &Experiment, threads: usize, seed: u64) -> (Value, Vec<String>) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let context = Context { seed, seeds: Some(2), ..Context::default() };
    let finished = pool.install(|| Finished::of(experiment, &context)).unwrap();
    let mut json = finished.to_json();
    without_times(&mut json);
    let drawn = finished.report.figures.iter().map(|figure| figure.to_svg().unwrap()).collect();
    (json, drawn)
}

#[test]
fn the_same_seed_gives_the_same_report_with_one_thread_and_with_two() {
    for experiment in EXPERIMENTS {
        let (json, figures) = finished(experiment, 1, 7);
        let (again, figures_again) = finished(experiment, 2, 7);
        assert_eq!(json, again, "{}", experiment.name);
        assert!(figures == figures_again, "{}: other figures", experiment.name);
    }
}

#[test]
fn names_are_file_names_and_purposes_are_sentences() {
    for (place, experiment) in EXPERIMENTS.iter().enumerate() {
        let is_plain =
            experiment.name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-');
        assert!(is_plain && !["all", "list", "index"].contains(&experiment.name), "{}", experiment.name);
        assert!(
            experiment.purpose.ends_with('.') && !experiment.purpose.contains('\n'),
            "{}",
            experiment.name
        );
        assert!(
            EXPERIMENTS[..place].iter().all(|other| other.name != experiment.name),
            "{}",
            experiment.name
        );
    }
}

#[test]
fn every_file_is_written_and_the_page_needs_no_other() {
    let folder = tempfile::tempdir().unwrap();
    let chart = figure::Chart {
        title: "a < b".into(),
        x: figure::Axis::linear("x"),
        y: figure::Axis::logarithmic("y"),
        series: vec![figure::Series::new("s", figure::Mark::Dashed, 1, vec![[0.0, 1.0], [1.0, 1000.0]])],
    };
    let picture = crate::image::ColourImage::filled(4, 4, [9; 3]);
    let report = Report {
        findings: vec!["One & all.".into()],
        tables: vec![Table::new("t", vec![table::Column::new("k", "K", 0)])],
        figures: vec![
            Figure::charts("curves", "Curves.", vec![chart]),
            Figure::picture("pixels", "Pixels.", picture),
        ],
    };
    let experiment = Experiment { name: "trial", purpose: "A trial.", run: |_| Ok(Report::default()) };
    let one = Finished { experiment, report, seed: 3, elapsed_ms: 1.0 };
    let page = write::write(std::slice::from_ref(&one), &folder.path().join("new/folder")).unwrap();
    let mut names: Vec<String> = std::fs::read_dir(page.parent().unwrap())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected = ["curves.png", "curves.svg", "pixels.png", "pixels.svg"].map(|end| format!("trial-{end}"));
    assert_eq!(names[..4], expected);
    assert_eq!(names[4..], ["trial.html", "trial.json", "trial.md"]);
    let html = std::fs::read_to_string(&page).unwrap();
    assert!(html.contains("One &amp; all.") && html.contains("data:image/png;base64,"));
    assert!(!html.contains("<script") && !html.contains("<link") && !html.contains("src=\"http"));
    let json: Value = serde_json::from_slice(&std::fs::read(page.with_extension("json")).unwrap()).unwrap();
    assert_eq!((&json["experiment"], &json["seed"]), (&"trial".into(), &3.into()));

    let several = write::write(&[one.clone(), one], folder.path()).unwrap();
    assert_eq!(several.file_name().unwrap(), "index.html");
    assert!(std::fs::read_to_string(several).unwrap().contains("href=\"#trial\""));
}

#[test]
fn a_folder_that_is_a_file_is_refused() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let error = write::write(&[], file.path()).unwrap_err();
    assert!(error.to_string().contains("--out"), "{error}");
}

#[test]
fn seeds_follow_the_first_and_there_is_always_one() {
    let context = Context { seed: u64::MAX, ..Context::default() };
    assert_eq!(context.seeds(3), [u64::MAX, 0, 1]);
    assert_eq!(Context { seeds: Some(0), ..context }.seeds(3).len(), 1);
}
