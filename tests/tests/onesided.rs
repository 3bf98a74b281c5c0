//! The default search on seeded one-sided views: accuracy, acceptance, decoys, coverage, touching fruit.
//!
//! Scenes, methods and readings of the criteria are those of `varsac experiment one-sided`, `outline`, `decoys`,
//! `calibration` and `touching`; here are fewer seeds, and limits. A limit is what the search is for; where a share or a
//! quantile of so few scenes has a statistical error that matters, the limit says how much was allowed for it.
//! `--nocapture` prints every figure beside its limit.

use varsac_host::{
    experiment::{
        Context,
        onesided::{Bunches, Case, Method, Outcome, Summary, bunches, measure, measure::Judged},
    },
    synth::onesided::{
        Subject, VARIED_JUJUBE, boxy_jujube,
        families::{CLEAN, HARD, OCCLUDED, ORCHARD, TOUCHING, TOUCHING_LEAVES},
        scaled_jujube,
    },
};
use varsac_tests::tolerance::Bound::{self, AtLeast, AtMost};

/// A figure, how it is taken from a summary, and its limit.
type Figure<S> = (&'static str, fn(&S) -> f64, Bound);

/// Prints the figures beside their limits; returns the names of those beyond.
fn beyond<S>(name: &str, figures: &[Figure<S>], summary: &S) -> Vec<String> {
    let mut beyond = Vec::new();
    for (figure, of, bound) in figures {
        let value = of(summary);
        let (sign, limit, holds) = match *bound {
            AtMost(limit) => ("<=", limit, value <= limit),
            AtLeast(limit) => (">=", limit, value >= limit),
        };
        let line = format!("{name:<34} {figure:<26} {value:>9.4} {sign} {limit}");
        println!("{line}");
        if !holds {
            beyond.push(line);
        }
    }
    beyond
}

/// Seeds with the largest errors, and how to see one of them again.
fn replay(experiment: &str, outcomes: &[Outcome]) -> String {
    let mut worst: Vec<(f64, u64)> = outcomes.iter().map(|o| (badness(o), o.seed)).collect();
    worst.sort_by(|p, q| q.0.total_cmp(&p.0));
    let seeds: Vec<String> =
        worst.iter().take(8).map(|(error, seed)| format!("seed {seed}: {error:.2} mm")).collect();
    let seed = worst.first().map_or(0, |w| w.1);
    format!(
        "largest errors: {}\nto replay the first: varsac experiment {experiment} --seed {seed} --seeds 1",
        seeds.join(", ")
    )
}

/// Error of a subject; of a scene without, 1000 for each accepted detection.
fn badness(outcome: &Outcome) -> f64 {
    let taken = outcome.detections.iter().filter(|judged| judged.is_accepted()).count();
    if outcome.distance_mm > 0.0 { outcome.centre_mm() } else { 1e3 * taken as f64 }
}

fn seeds(count: u64) -> Vec<u64> {
    Context::default().seeds(count)
}

/// Holds methods on one kind of scenes to limits; each scene is made once.
fn hold(experiment: &str, case: &Case, count: u64, methods: &[(Method, &[Figure<Summary>])]) {
    let names: Vec<Method> = methods.iter().map(|(method, _)| *method).collect();
    let measured = measure(&Context::default(), &[*case], &names, &seeds(count)).concat();
    for ((method, figures), outcomes) in methods.iter().zip(&measured) {
        let name = format!("{} x {count}, {}", case.name, method.name());
        let beyond = beyond(&name, figures, &Summary::of(outcomes));
        assert!(
            beyond.is_empty(),
            "beyond the limits:\n{}\n{}",
            beyond.join("\n"),
            replay(experiment, outcomes)
        );
    }
}

const RIGHT: (&str, fn(&Summary) -> f64) = ("centre within 5 mm", |s| s.right);
const FAR: (&str, fn(&Summary) -> f64) = ("beyond short axis", |s| s.far);
const RMS_C: (&str, fn(&Summary) -> f64) = ("RMS-c, mm", |s| s.rms_c_mm);
const RMS_S: (&str, fn(&Summary) -> f64) = ("RMS-s, mm", |s| s.rms_s_mm);
const CENTRE: (&str, fn(&Summary) -> f64) = ("centre median, mm", |s| s.centre_mm[0]);
const CENTRE_90: (&str, fn(&Summary) -> f64) = ("centre 90 %, mm", |s| s.centre_mm[1]);
const AXIS: (&str, fn(&Summary) -> f64) = ("long axis median, deg", |s| s.axis_deg[0]);
const AXIS_90: (&str, fn(&Summary) -> f64) = ("long axis 90 %, deg", |s| s.axis_deg[1]);
const AXIS_RMS: (&str, fn(&Summary) -> f64) = ("long axis RMS, deg", |s| s.axis_rms_deg);
const ACCEPTED: (&str, fn(&Summary) -> f64) = ("accepted", |s| s.accepted);
const WRONG: (&str, fn(&Summary) -> f64) = ("accepted and wrong, share", |s| s.wrong().unwrap_or(1.0));

fn limit<S>((name, of): (&'static str, fn(&S) -> f64), bound: Bound) -> Figure<S> {
    (name, of, bound)
}

#[test]
fn clean_views() {
    let figures = [
        limit(RIGHT, AtLeast(0.995)),
        limit(RMS_C, AtMost(0.30)),
        limit(RMS_S, AtMost(0.30)),
        limit(AXIS_RMS, AtMost(1.5)),
    ];
    hold("one-sided", &Case::of(CLEAN), 300, &[(Method::Cloud, &figures)]);
}

#[test]
fn hard_views() {
    let cloud = [
        limit(RIGHT, AtLeast(0.96)),
        limit(RMS_C, AtMost(0.65)),
        limit(RMS_S, AtMost(0.45)),
        limit(AXIS, AtMost(2.2)),
    ];
    let outline = [
        limit(RIGHT, AtLeast(0.97)),
        limit(CENTRE, AtMost(0.7)),
        limit(CENTRE_90, AtMost(1.8)),
        limit(AXIS, AtMost(2.0)),
    ];
    for (family, count) in [(HARD, 300), (HARD.averaged("hard, pixels average"), 200)] {
        let methods: [(Method, &[_]); 2] = [(Method::Cloud, &cloud), (Method::Outline, &outline)];
        hold("outline", &Case::of(family), count, &methods);
    }
}

#[test]
fn sizes_that_vary_under_a_loose_prior() {
    let varied = Case::of(HARD.of("sizes +-15 %", VARIED_JUJUBE)).spread(0.15);
    hold("outline", &varied, 250, &[(Method::Outline, &[limit(CENTRE, AtMost(0.9))])]);
}

#[test]
fn a_mask_that_is_wrong_by_a_pixel_does_no_harm() {
    let hard = Case::of(HARD);
    for case in [
        hard.biased("1 px too large", 1, [0, 0]),
        hard.biased("1 px too small", -1, [0, 0]),
        hard.biased("1 px to the right", 0, [1, 0]),
    ] {
        let figures =
            [limit(RIGHT, AtLeast(0.97)), limit(CENTRE, AtMost(0.7)), limit(CENTRE_90, AtMost(1.8))];
        hold("outline", &case, 150, &[(Method::Outline, &figures)]);
    }
}

#[test]
fn covered_views_from_the_cloud_alone() {
    // The goal is a median of .7 mm: .64 in the first 150 scenes, .72 in the first 500.
    let figures = [
        limit(CENTRE, AtMost(0.76)),
        limit(CENTRE_90, AtMost(1.8)),
        limit(AXIS, AtMost(2.6)),
        limit(AXIS_90, AtMost(8.0)),
        limit(FAR, AtMost(0.0)),
    ];
    hold("one-sided", &Case::of(OCCLUDED), 400, &[(Method::Cloud, &figures)]);
}

#[test]
fn mixed_views_are_accepted_or_refused() {
    // The goals are 84 % with .15 % of them wrong, and 68 % with .7 % wrong. The share accepted of 1000 scenes has a
    // statistical error of 1.2 and 1.5 %; of about 1050 accepted detections two wrong ones are .19 %. Measured on 5000: 85.0 %
    // with .04 %, and 66.6 % with .07 %: from the cloud alone the gate is stricter than it would have to be.
    let outline = [limit(ACCEPTED, AtLeast(0.82)), limit(WRONG, AtMost(0.002))];
    let cloud = [limit(ACCEPTED, AtLeast(0.63)), limit(WRONG, AtMost(0.007))];
    let methods: [(Method, &[_]); 2] = [(Method::Outline, &outline), (Method::Cloud, &cloud)];
    hold("calibration", &Case::of(ORCHARD), 1000, &methods);
}

#[test]
fn decoys_are_refused() {
    // 400 scenes: a share of 1 % has a standard deviation of .5 %, one of 3 % of .85 %; two of them are allowed for. From
    // the cloud alone the larger fruit falls short of the goal of 3 %: 5.3 % of 400, 6.8 % of 600.
    for (name, subject, with_outlines, cloud_only) in [
        ("ball", Subject::Ball(10.0, 17.0), 0.02, 0.02),
        ("apple", Subject::Ball(32.0, 42.0), 0.02, 0.02),
        ("disc", Subject::Disc, 0.02, 0.02),
        ("branch", Subject::Branch(6.0, 12.0), 0.02, 0.02),
        ("0.7x fruit", scaled_jujube(0.7), 0.047, 0.047),
        ("1.3x fruit", scaled_jujube(1.3), 0.047, 0.075),
    ] {
        let case = Case::of(ORCHARD.decoy(name, subject));
        let measured = measure(&Context::default(), &[case], &Method::OURS, &seeds(400)).concat();
        for (method, (outcomes, limit)) in
            Method::OURS.iter().zip(measured.iter().zip([with_outlines, cloud_only]))
        {
            let taken = |outcome: &&Outcome| outcome.detections.iter().any(Judged::is_accepted);
            let share = outcomes.iter().filter(taken).count() as f64 / outcomes.len() as f64;
            println!("{name}, {}: accepted {share:.4} <= {limit}", method.name());
            assert!(share <= limit, "{name}: {share} > {limit}; {}", replay("decoys", outcomes));
        }
    }
}

#[test]
fn ninety_five_per_cent_regions_hold_the_truth() {
    // 400 scenes: the statistical error of a share of 95 % is 1.1 %; two of them are allowed for below the goal of 93 %.
    type Of = fn(&Summary) -> f64;
    const BLOCK: [(&str, Of); 3] = [
        ("95 % region of the centre", |s| s.coverage.map_or(0.0, |c| c[0])),
        ("95 % region of the sizes", |s| s.coverage.map_or(0.0, |c| c[1])),
        ("95 % region of the long axis", |s| s.coverage.map_or(0.0, |c| c[2])),
    ];
    // Super-ellipsoids of exponent 2.5 seen as a cloud alone fall short of the 93 % that are the goal: 91.5 % of 686.
    for (family, least) in [(CLEAN, 0.91), (HARD, 0.91), (HARD.of("exponent 2.5", boxy_jujube(2.5)), 0.89)] {
        let figures = BLOCK.map(|block| limit(block, AtLeast(least)));
        let methods = Method::OURS.map(|method| (method, &figures[..]));
        hold("calibration", &Case::of(family), 400, &methods);
    }
}

#[test]
fn touching_fruit_are_found_one_by_one() {
    type Of = fn(&Bunches) -> f64;
    let (found, accepted): (Of, Of) = (|b| b.recall, |b| b.accepted_recall);
    for (family, least) in [(TOUCHING, 0.88), (TOUCHING_LEAVES, 0.81)] {
        let figures: [Figure<Bunches>; 6] = [
            ("recall before the gate", found, AtLeast(0.97)),
            ("accepted recall", accepted, AtLeast(least)),
            ("false targets", |b| b.false_targets as f64, AtMost(0.0)),
            ("counted twice", |b| b.double as f64, AtMost(0.0)),
            ("accepted and wrong, share", |b| b.wrong as f64 / b.accepted.max(1) as f64, AtMost(0.005)),
            ("centre median, mm", |b| b.centre.map_or(f64::INFINITY, |c| c.median), AtMost(0.7)),
        ];
        let measured = bunches(&Context::default(), &[Case::of(family)], &[Method::Outline], &seeds(150));
        let beyond = beyond(family.name, &figures, &measured[0][0]);
        assert!(
            beyond.is_empty(),
            "beyond the limits:\n{}\nto replay: varsac experiment touching --seeds 150",
            beyond.join("\n")
        );
    }
}
