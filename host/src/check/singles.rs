//! Single fits of both sides: points of a cloud in any order, by either criterion.

use super::cases::{Case, Dice};
use super::convert;
use super::record::{Recorder, Stage};
use varsac_core::geometric::{self, Criterion};
use varsac_reference as reference;

/// The lists of points that are fitted: all of them, and some of them in any order.
fn lists(case: &Case) -> [Vec<u16>; 2] {
    let dice = &mut Dice::new(case.seed, 1);
    let n = case.view.points.len() as u32;
    let some = if n == 0 { 0 } else { 8 + dice.below(40) };
    [(0..n as u16).collect(), (0..some).map(|_| dice.below(n) as u16).collect()]
}

/// What one fit comes to.
struct Fitted<'a> {
    centre: [f32; 3],
    semi_axes: [f32; 3],
    axes: &'a [[f32; 3]; 3],
    covariance: &'a [f32],
    rms: f32,
}

fn record(recorder: &mut Recorder, fitted: &Fitted) {
    let Fitted { centre, semi_axes, axes, covariance, rms } = fitted;
    recorder.floats(Stage::Single, "ellipsoid and rms", &[centre, semi_axes, axes.as_flattened(), &[*rms]]);
    recorder.floats(Stage::Single, "covariance", &[covariance]);
}

/// The single fits of the core.
pub(crate) fn core(case: &Case, recorder: &mut Recorder) {
    for list in lists(case) {
        for criterion in [Criterion::Algebraic, Criterion::Geometric] {
            match geometric::fit(&case.view.points, &list, criterion) {
                Err(rejection) => recorder.integers(Stage::Single, "rejected", [rejection as u32]),
                Ok(fitted) => {
                    let e = &fitted.ellipsoid;
                    let covariance = fitted.covariance.as_ref().map_or(&[][..], |c| c.packed());
                    let (centre, semi_axes) = (e.centre.coords.into(), e.semi_axes);
                    let rms = fitted.rms;
                    record(recorder, &Fitted { centre, semi_axes, axes: &e.axes, covariance, rms });
                }
            }
        }
    }
}

/// The same fits of the reference.
pub(crate) fn reference(case: &Case, recorder: &mut Recorder) {
    let cloud = convert::points(&case.view.points);
    for list in lists(case) {
        for criterion in [reference::Criterion::Algebraic, reference::Criterion::Geometric] {
            match reference::fit_single(&cloud, &list, criterion) {
                Err(rejection) => {
                    let number = super::reference_side::number_of(rejection) as u32;
                    recorder.integers(Stage::Single, "rejected", [number]);
                }
                Ok(fitted) => {
                    let e = &fitted.ellipsoid;
                    let covariance = fitted.covariance.as_ref().map_or(&[][..], |c| c);
                    let (centre, semi_axes, rms) = (e.centre, e.semi_axes, fitted.rms);
                    record(recorder, &Fitted { centre, semi_axes, axes: &e.axes, covariance, rms });
                }
            }
        }
    }
}
