//! Vectors of the single fit: four clouds, by both criteria.

use crate::format::{Case, check_file};
use crate::{everything, points_read, view};
use varsac_core::geometric::{Criterion, fit};
use varsac_reference as reference;

#[test]
fn single_fits() {
    let mut stream = reference::Stream::seeded(17);
    let mut cases = Vec::new();
    for count in [12, 30, 60, 120] {
        let points = view(&mut stream, count);
        for criterion in [reference::Criterion::Algebraic, reference::Criterion::Geometric] {
            let Ok(single) = reference::fit_single(&points, &everything(count), criterion) else { continue };
            let e = &single.ellipsoid;
            let geometric = criterion == reference::Criterion::Geometric;
            cases.push(
                Case::default()
                    .integers("geometric", [u32::from(geometric)])
                    .floats("points", points.as_flattened())
                    .floats("centre", &e.centre)
                    .floats("semi_axes", &e.semi_axes)
                    .floats("axes", e.axes.as_flattened())
                    .floats("rms", &[single.rms])
                    .floats("covariance", single.covariance.as_ref().map_or(&[][..], |entries| entries)),
            );
        }
    }
    assert!(cases.len() >= 6, "only {} of the clouds are ellipsoids", cases.len());
    let what =
        "Chapter G1, all points in order: criterion (0 algebraic, 1 geometric), ellipsoid, rms, covariance.";
    check_file("single-fits", what, &cases, |case| {
        let cloud = points_read(case);
        let criterion = if case.word("geometric") == 1 { Criterion::Geometric } else { Criterion::Algebraic };
        let single = fit(&cloud, &everything(cloud.len()), criterion).expect("an ellipsoid");
        let e = &single.ellipsoid;
        case.expect_floats("centre", &[e.centre.x, e.centre.y, e.centre.z]);
        case.expect_floats("semi_axes", &e.semi_axes);
        case.expect_floats("axes", e.axes.as_flattened());
        case.expect_floats("rms", &[single.rms]);
        case.expect_floats("covariance", single.covariance.as_ref().map_or(&[][..], |c| c.packed()));
    });
}
