//! Vectors of the single stages around the fit.

use crate::format::{Case, check_file};
use crate::{between, everything, points_read, surface, surface_numbers, surface_read};
use varsac_core::{Ellipsoid, jacobi, kdtree, rng, tebc, trials};
use varsac_reference as reference;

#[test]
fn draws() {
    let cases = [0, 1, 0x1234_5678_9abc_def0_u64].map(|seed| {
        let mut stream = reference::Stream::seeded(seed);
        let bounds = [1, 2, 9, 1000, 65_535, 3 << 30, u32::MAX];
        let below = bounds.map(|bound| stream.below(bound));
        let sample = stream.sample(30, 12).expect("12 of 30");
        Case::default()
            .integers("seed", [seed as u32, (seed >> 32) as u32])
            .integers("bounds", bounds)
            .integers("below", below)
            .integers("population", [30])
            .integers("sample", sample)
    });
    check_file(
        "draws",
        "Chapter 3: seed (low word first), draws below the bounds, then one sample.",
        &cases,
        |case| {
            let [low, high] = case.words("seed") else { panic!("two words") };
            let mut stream = rng::Stream::new(u64::from(*low) | u64::from(*high) << 32);
            let below: Vec<u32> = case.words("bounds").iter().map(|&bound| stream.below(bound)).collect();
            case.expect_integers("below", &below);
            let mut sample = vec![0; case.words("sample").len()];
            assert!(stream.sample(case.word("population"), &mut sample));
            case.expect_integers("sample", &sample.into_iter().map(u32::from).collect::<Vec<_>>());
        },
    );
}

#[test]
fn neighbourhood() {
    let mut stream = reference::Stream::seeded(4);
    let cases = [3.0, 5.0, 9.0].map(|radius| {
        // Integer coordinates: many points lie exactly at the radius.
        let points: Vec<reference::Point> =
            (0..40).map(|_| [(); 3].map(|()| stream.below(11) as f32 - 5.0)).collect();
        let members = reference::neighbourhood(&points, &[0; 40], 7, radius);
        Case::default()
            .floats("points", points.as_flattened())
            .integers("seed_point", [7])
            .floats("radius", &[radius])
            .integers("members", members.into_iter().map(u32::from))
    });
    check_file("neighbourhood", "Chapter 4: points, seed point, radius, members.", &cases, |case| {
        let cloud = points_read(case);
        let mut order = everything(cloud.len());
        kdtree::build(&cloud, &mut order);
        let mut members = vec![0; cloud.len()];
        let centre = cloud[case.word("seed_point") as usize];
        let count = kdtree::within(&cloud, &order, &centre, case.numbers("radius")[0], &mut members);
        members.truncate(count.expect("there is room for all"));
        case.expect_integers("members", &members.into_iter().map(u32::from).collect::<Vec<_>>());
    });
}

#[test]
fn ellipsoids() {
    let mut stream = reference::Stream::seeded(6);
    let cases = [0.0, 0.1, 1.0, 1.0, 1.0].map(|off| {
        let surface = surface(&mut stream, off);
        let eigen = reference::ascending(&reference::eigen(&surface.shape));
        let found = reference::ellipsoid_of(&surface);
        Case::default()
            .floats("surface", &surface_numbers(&surface))
            .floats("eigenvalues", &eigen.values)
            .floats("eigenvectors", eigen.vectors.as_flattened())
            .floats("semi_axes", &found.semi_axes)
            .floats("axes", found.axes.as_flattened())
            .floats("quaternion_xyzw", &found.quaternion)
            .floats("angles_xyz", &found.angles)
    });
    let what = "Chapter 11: surface (centre; shape xx yy zz xy xz yz), eigenpairs, ellipsoid, attitude.";
    check_file("ellipsoids", what, &cases, |case| {
        let surface = surface_read(case);
        let eigen = jacobi::eigen(&surface.shape);
        case.expect_floats("eigenvalues", &eigen.values);
        case.expect_floats("eigenvectors", eigen.vectors.as_flattened());
        let found = Ellipsoid::from(&surface);
        case.expect_floats("semi_axes", &found.semi_axes);
        case.expect_floats("axes", found.axes.as_flattened());
        case.expect_floats("quaternion_xyzw", &found.quaternion_xyzw());
        case.expect_floats("angles_xyz", &found.attitude_rad());
    });
}

#[test]
fn sizes_and_scores() {
    let mut stream = reference::Stream::seeded(7);
    let cases = [0.05, 0.1, 0.25].map(|d| {
        let surface = surface(&mut stream, 1.0);
        let points: Vec<reference::Point> =
            (0..30).map(|_| surface.centre.map(|c| c + between(&mut stream, -15.0, 15.0))).collect();
        let inside = points.iter().map(|&p| u32::from(reference::shell_contains(&surface, d, p)));
        let limits = [[9.5, 24.5], [5.0, 60.0], [1.0, 12.0]];
        let accepted = limits.map(|[min, max]| reference::size_accepted(&surface.shape, min, max));
        Case::default()
            .floats("surface", &surface_numbers(&surface))
            .floats("limits", limits.as_flattened())
            .integers("accepted", accepted.map(u32::from))
            .floats("d", &[d])
            .floats("points", points.as_flattened())
            .integers("inside", inside)
    });
    let what = "Chapters 6 and 7: surface, pairs of limits and whether it is accepted, shell, points and whether inside.";
    check_file("sizes_and_scores", what, &cases, |case| {
        let surface = surface_read(case);
        let limits = case.numbers("limits");
        let accepted = limits.chunks(2).map(|pair| u32::from(surface.semi_axes_within(pair[0], pair[1])));
        case.expect_integers("accepted", &accepted.collect::<Vec<_>>());
        let shell = tebc::Shell::new(&surface, case.numbers("d")[0]);
        let inside: Vec<u32> = points_read(case).iter().map(|p| u32::from(shell.contains(p))).collect();
        case.expect_integers("inside", &inside);
    });
}

#[test]
fn bounds_on_trials() {
    let sizes = [9, 10, 11, 12];
    let cases = [0.95, 0.98, 0.5].map(|confidence| {
        let ratios: Vec<f32> = (0..=20).map(|k| k as f32 / 20.0).collect();
        let bounds: Vec<u32> =
            ratios.iter().map(|&ratio| reference::trials(confidence, &sizes, ratio, 3000)).collect();
        Case::default()
            .floats("confidence", &[confidence])
            .integers("sizes", sizes.map(u32::from))
            .integers("max", [3000])
            .floats("ratios", &ratios)
            .integers("bounds", bounds)
    });
    check_file(
        "trials",
        "Chapter 8: confidence, sample sizes, maximum, ratios and their bounds.",
        &cases,
        |case| {
            let sizes: Vec<u8> = case.words("sizes").iter().map(|&size| size as u8).collect();
            let (confidence, max) = (case.numbers("confidence")[0], case.word("max"));
            let ratios = case.numbers("ratios");
            let bounds = ratios.iter().map(|&ratio| trials::trials(confidence, &sizes, ratio, max));
            case.expect_integers("bounds", &bounds.collect::<Vec<_>>());
        },
    );
}
