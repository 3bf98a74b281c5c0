//! The core computes what the numeric contract says, to the last bit: core against reference over every family of
//! inputs, and proof that the comparison fails where one side rounds once or breaks one tie differently.

use std::fmt::Write as _;
use varsac_core::Point3;
use varsac_host::check::{self, Difference, Family, Options, Outcome, RecordedView, Stage};
use varsac_host::region_view::RegionView;
use varsac_reference::{Fault, inject};

fn options(cases: u32, seed: u64) -> Options {
    Options { cases, seed, ..Options::default() }
}

/// A check on `threads` threads, with the reference making a mistake on all of them.
fn check_with(fault: Option<Fault>, threads: usize, options: &Options) -> Outcome {
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .start_handler(move |_| inject(fault))
        .build()
        .expect("a pool of threads")
        .install(|| check::run(options))
}

#[test]
fn core_and_reference_agree_in_every_bit() {
    let outcome = check::run(&options(1000, 1));
    assert!(outcome.difference.is_none(), "{outcome}");
    // No stage is agreed upon because it never happened. A refused cloud is the rarest result.
    for ((stage, plural), count) in Stage::ALL.into_iter().zip(outcome.counts) {
        assert!(count >= 5, "only {count} {plural} in {stage}");
    }
    assert!(outcome.fits() >= 12_000 && outcome.map_searches() >= 900, "{outcome}");
    assert!(outcome.mixture_searches() >= 200, "{outcome}");
}

#[test]
fn the_outcome_is_the_same_on_one_thread_and_on_many() {
    let options = options(200, 2);
    assert_eq!(check_with(None, 1, &options), check_with(None, 4, &options));
    let fault = Some(Fault::Invariants);
    assert_eq!(check_with(fault, 1, &options), check_with(fault, 4, &options));
}

#[test]
fn a_fault_in_any_stage_of_the_papers_search_is_caught_and_the_stage_is_named() {
    all_are_caught(&[
        (Fault::Draws, &[Stage::Draws][..]),
        (Fault::Neighbourhood, &[Stage::Neighbourhood]),
        (Fault::NormalMatrix, &[Stage::NormalMatrix]),
        (Fault::Solution, &[Stage::Solution]),
        (Fault::Quadric, &[Stage::Quadric]),
        (Fault::Invariants, &[Stage::Invariants]),
        (Fault::Hypothesis, &[Stage::Hypothesis]),
        (Fault::Eigenpairs, &[Stage::Eigenpairs]),
        (Fault::Ellipsoid, &[Stage::Ellipsoid]),
        (Fault::Attitude, &[Stage::Attitude]),
        (Fault::Size, &[Stage::Size]),
        (Fault::Score, &[Stage::Score]),
        (Fault::Bound, &[Stage::Bound]),
        (Fault::Best, &[Stage::Bound]),
        (Fault::Refit, &[Stage::Refit]),
        (Fault::Detection, &[Stage::Detection]),
        (Fault::Labels, &[Stage::Labels]),
    ]);
}

/// Where a hypothesis is made without a step, a wrong residual shows in its support, and a wrong step in its refinement.
#[test]
fn a_fault_in_any_stage_of_the_default_search_is_caught_and_the_stage_is_named() {
    all_are_caught(&[
        (Fault::Mask, &[Stage::Neighbourhood][..]),
        (Fault::Start, &[Stage::Hypothesis]),
        (Fault::Prior, &[Stage::Hypothesis, Stage::Refined]),
        (Fault::Contact, &[Stage::Hypothesis, Stage::Support]),
        (Fault::Moments, &[Stage::Hypothesis, Stage::Refined]),
        (Fault::Step, &[Stage::Hypothesis, Stage::Refined]),
        (Fault::Ray, &[Stage::Support, Stage::Refined]),
        (Fault::Support, &[Stage::Support]),
        (Fault::Beside, &[Stage::Refined]),
        (Fault::Displacement, &[Stage::Refined]),
        (Fault::GemanMcClure, &[Stage::Refined]),
        (Fault::Keeping, &[Stage::Refined]),
        (Fault::Refinement, &[Stage::Refined]),
        (Fault::Choice, &[Stage::Noise]),
        (Fault::Noise, &[Stage::Noise]),
        (Fault::Tukey, &[Stage::Final]),
        (Fault::Boxiness, &[Stage::Final]),
        (Fault::Claim, &[Stage::Labels]),
        (Fault::Standings, &[Stage::Labels]),
        (Fault::Challenge, &[Stage::Labels]),
        (Fault::Joint, &[Stage::Joint]),
        (Fault::Loose, &[Stage::Free]),
        (Fault::Rival, &[Stage::Findings]),
        (Fault::SizeEvidence, &[Stage::Findings]),
        (Fault::Flat, &[Stage::Findings]),
        (Fault::ContactFunction, &[Stage::Findings]),
        (Fault::Covariance, &[Stage::Covariance]),
        (Fault::Acceptance, &[Stage::Verdict]),
    ]);
}

/// Of a search without a prior only its results are seen, so that a fault on the way shows in the ellipsoid, or in what
/// becomes of the search where there is none; and one that the ellipsoid forgets in what is said about it.
#[test]
fn a_fault_in_any_stage_of_the_search_without_a_prior_and_of_the_single_fit_is_caught_and_the_stage_is_named()
{
    const ANYWHERE: &[Stage] =
        &[Stage::Ellipsoid, Stage::Attitude, Stage::Findings, Stage::Covariance, Stage::Body, Stage::Labels];
    all_are_caught(&[
        (Fault::Volume, ANYWHERE),
        (Fault::Shuffle, ANYWHERE),
        (Fault::Blob, ANYWHERE),
        (Fault::Area, ANYWHERE),
        (Fault::Odds, ANYWHERE),
        (Fault::Foot, &[Stage::Ellipsoid, Stage::Findings, Stage::Covariance, Stage::Body, Stage::Single]),
        (Fault::Bend, ANYWHERE),
        (Fault::Past, ANYWHERE),
        (Fault::Rays, ANYWHERE),
        (Fault::Climb, ANYWHERE),
        (Fault::Remembered, ANYWHERE),
        (Fault::Kept, ANYWHERE),
        (Fault::FinalFit, ANYWHERE),
        (Fault::Information, &[Stage::Findings, Stage::Covariance]),
        (Fault::Cells, &[Stage::Findings]),
        (Fault::Coverage, &[Stage::Findings]),
        (Fault::Claimed, &[Stage::Body]),
        (Fault::Damping, &[Stage::Single]),
        (Fault::Spread, &[Stage::Single]),
    ]);
}

/// With each of three seeds, every fault is caught in one of its stages and can be replayed; all that is wrong is told at once.
fn all_are_caught(faults: &[(Fault, &[Stage])]) {
    let mut wrong = String::new();
    for &(fault, stages) in faults {
        for seed in 1..4 {
            match first_difference(fault, seed) {
                None => {
                    let _ = writeln!(wrong, "{fault:?} is not caught with seed {seed}");
                }
                Some(found) if !stages.contains(&found.stage) => {
                    let _ = writeln!(wrong, "{fault:?}, seed {seed}, is taken for another: {found}");
                }
                Some(found) => is_replayed(fault, seed, &found),
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// A few dozen cases are enough for most faults; two fruit in one place are rarer.
fn first_difference(fault: Fault, seed: u64) -> Option<Difference> {
    [32, 128, 512].into_iter().find_map(|cases| check_with(Some(fault), 1, &options(cases, seed)).difference)
}

/// The replay of the case shows the same difference while the fault is there, and none without it.
fn is_replayed(fault: Fault, seed: u64, found: &Difference) {
    assert_ne!(found.core, found.reference, "{fault:?}, seed {seed}");
    assert_eq!(found.replay, format!("varsac check --seed {seed} --case {}", found.case));
    let replay = Options { case: Some(found.case as u32), ..options(1, seed) };
    assert_eq!(check_with(Some(fault), 1, &replay).difference.as_ref(), Some(found));
    assert_eq!(check_with(None, 1, &replay).difference, None);
}

#[test]
fn recorded_views_are_searched_and_named_in_the_replay() {
    // A spiral over the front of a jujube, 22 x 11 x 11 mm, 700 mm away.
    let points = (0..200).map(|k| {
        let depth = 1.0 - (k as f32 + 0.5) / 200.0;
        let (sin, cos) = (2.4 * k as f32).sin_cos();
        let rim = (1.0 - depth * depth).sqrt();
        Point3::new(22.0 * rim * cos, 11.0 * rim * sin, 700.0 - 11.0 * depth)
    });
    let view = RegionView::of_cloud(points.collect());
    let recorded = vec![RecordedView { name: "spiral.ply".to_owned(), view }];
    let replay = Options { recorded, case: Some(3), ..options(1, 8) };
    let outcome = check_with(None, 1, &replay);
    assert!(outcome.difference.is_none() && outcome.fits() > 0, "{outcome}");
    let found = check_with(Some(Fault::NormalMatrix), 1, &replay).difference.expect("a difference");
    assert_eq!((found.family, found.case), (Family::Recorded, 3));
    assert_eq!(found.replay, "varsac check --seed 8 --case 3 spiral.ply");
    let replay = Options { case: Some(1), ..replay };
    let outcome = check_with(None, 1, &replay);
    assert!(outcome.difference.is_none() && outcome.map_searches() > 0, "{outcome}");
    let found = check_with(Some(Fault::Contact), 1, &replay).difference.expect("a difference");
    assert_eq!((found.family, found.stage), (Family::Recorded, Stage::Hypothesis));
}
