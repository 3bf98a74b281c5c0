//! Thousands of hostile clouds, configurations and index lists.

use varsac_core::{Constraint, Rejection, fit::fit};
use varsac_tests::{
    bound,
    hostile::{self, FAMILIES},
    random::Dice,
};

use super::run;

#[test]
fn hostile_clouds_and_configurations_never_break_the_bounds() {
    let (mut found, mut longest) = (0, 0.0_f64);
    let mut finishes = [0_u32; 3];
    for case in 0..4000 {
        let mut dice = Dice::new("storm", case);
        let (_, make) = FAMILIES[case as usize % FAMILIES.len()];
        let points = dice.below(150);
        let cloud = make(&mut dice, points);
        let config = hostile::config(&mut dice, 60);
        let seed = [0, u64::MAX, dice.bits()][dice.below(3)];
        let run = run(&config, &cloud, seed);
        found += run.found.len();
        longest = longest.max(run.steps as f64 / bound::steps(&config) as f64);
        finishes[run.finish as usize] += 1;
    }
    println!("4000 hostile runs: {found} detections; ended by few points, targets, failures: {finishes:?}");
    println!("the longest took {:.1} % of the steps it was allowed", 100.0 * longest);
    assert!(found > 100 && finishes.iter().all(|&count| count > 20), "the storm must reach every ending");
}

#[test]
fn hostile_lists_never_break_a_fit() {
    let (mut fitted, mut rejected) = (0, [0; Rejection::COUNT]);
    for case in 0..20_000 {
        let mut dice = Dice::new("lists", case);
        let (name, make) = FAMILIES[case as usize % FAMILIES.len()];
        let cloud = make(&mut dice, 40);
        // Any indices at all: repeated ones, and ones beyond the cloud (the origin stands in for them).
        let sample: Vec<u16> = (0..dice.below(40)).map(|_| dice.below(42) as u16).collect();
        let constraint = if dice.unit() < 0.5 { Constraint::A11 } else { Constraint::Trace };
        match fit(&cloud, &sample, constraint) {
            Ok(surface) => {
                fitted += 1;
                assert!(surface.centre.iter().all(|v| v.is_finite()), "{name} {case}: {surface:?}");
                // Below this spread 1 / semi-axis^2 leaves the range of f32; the size check of a search refuses it.
                let extent = cloud.iter().flat_map(|p| p.iter()).fold(0.0_f32, |most, v| most.max(v.abs()));
                let s = surface.shape;
                let finite = [s.xx, s.yy, s.zz, s.xy, s.xz, s.yz].iter().all(|v| v.is_finite());
                assert!(finite || extent < 1e-18, "{name} {case}: {surface:?}");
            }
            Err(reason) => rejected[reason as usize] += 1,
        }
    }
    println!("20000 hostile lists: {fitted} ellipsoids; rejected {rejected:?}");
    assert!(fitted > 500 && rejected[0] > 500 && rejected[1] > 500 && rejected[2] > 500);
}
