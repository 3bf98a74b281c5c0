//! Facts about the fit that can be computed by hand.

use super::*;

/// The 30 points with integer coordinates on a sphere of radius 5: a cube's worth of symmetry, exact in f32.
fn sphere() -> Vec<Point> {
    let mut points = Vec::new();
    for x in -5..=5_i8 {
        for y in -5..=5_i8 {
            for z in -5..=5_i8 {
                if i32::from(x).pow(2) + i32::from(y).pow(2) + i32::from(z).pow(2) == 25 {
                    points.push([f32::from(x), f32::from(y), f32::from(z)]);
                }
            }
        }
    }
    assert_eq!(points.len(), 30);
    points
}

fn everything(cloud: &[Point]) -> Vec<u16> {
    (0..cloud.len() as u16).collect()
}

fn assert_near(found: f32, expected: f32, tolerance: f32) {
    assert!((found - expected).abs() <= tolerance, "{found} is not {expected} within {tolerance}");
}

#[test]
fn a_sphere_is_found_under_both_constraints() {
    let cloud = sphere();
    for constraint in [Constraint::A11, Constraint::Trace] {
        let found = fit(&cloud, &everything(&cloud), constraint).expect("30 points of a sphere");
        for axis in 0..3 {
            assert_near(found.centre[axis], 0.0, 1e-6);
        }
        let s = found.shape;
        for (entry, expected) in
            [(s.xx, 0.04), (s.yy, 0.04), (s.zz, 0.04), (s.xy, 0.0), (s.xz, 0.0), (s.yz, 0.0)]
        {
            assert_near(entry, expected, 1e-7);
        }
    }
}

#[test]
fn a_shifted_axis_aligned_ellipsoid_is_found() {
    // Semi-axes 20, 10 and 5 around (100, -50, 800): the sphere stretched by 4, 2 and 1.
    let cloud: Vec<Point> =
        sphere().iter().map(|p| [100.0 + 4.0 * p[0], -50.0 + 2.0 * p[1], 800.0 + p[2]]).collect();
    let found = fit(&cloud, &everything(&cloud), Constraint::Trace).expect("30 points of an ellipsoid");
    for (found, expected) in found.centre.into_iter().zip([100.0, -50.0, 800.0]) {
        assert_near(found, expected, 1e-4);
    }
    assert_near(found.shape.xx, 1.0 / 400.0, 1e-8);
    assert_near(found.shape.yy, 1.0 / 100.0, 1e-7);
    assert_near(found.shape.zz, 1.0 / 25.0, 1e-6);
}

#[test]
fn the_events_of_a_fit_come_in_order_and_stop_where_it_does() {
    let cloud = sphere();
    let mut names = Vec::new();
    let mut normal = None;
    let _ = fit_observed(&cloud, &everything(&cloud), Constraint::A11, &mut |event| {
        names.push(match event {
            Event::Normal { matrix, .. } => {
                normal = Some(matrix);
                "normal"
            }
            Event::Solution(_) => "solution",
            Event::Quadric(_) => "quadric",
            Event::Invariants(_) => "invariants",
            Event::Hypothesis(_) => "hypothesis",
            _ => "other",
        });
    });
    assert_eq!(names, ["normal", "solution", "quadric", "invariants", "hypothesis"]);
    // Entry (5, 5) is the number of points, entry (5, 0) the sum of y^2: 250 / 16 at the scale 2^-2.
    let normal = normal.expect("a normal matrix");
    assert_eq!((normal[20], normal[15]), (30.0, 250.0 / 16.0));

    // All points in one plane: the column of z vanishes, so the factors do not exist.
    let plane: Vec<Point> = cloud.iter().map(|p| [p[0] + p[1], p[0] - 3.0 * p[1], 7.0]).collect();
    let mut count = 0;
    let result = fit_observed(&plane, &everything(&plane), Constraint::A11, &mut |_| count += 1);
    assert_eq!((result, count), (Err(Rejection::Degenerate), 1));
}

#[test]
fn too_few_equal_or_far_apart_points_are_rejected_before_the_normal_equations() {
    let cloud = vec![[1.0, 2.0, 3.0]; 12];
    assert_eq!(fit(&cloud, &[0, 1, 2, 3, 4, 5, 6, 7], Constraint::A11), Err(Rejection::TooFewPoints));
    assert_eq!(fit(&cloud, &everything(&cloud), Constraint::A11), Err(Rejection::Degenerate));
}

#[test]
fn a_hyperboloid_is_no_ellipsoid() {
    // x^2 + y^2 - z^2 = 1.
    let mut cloud: Vec<Point> = Vec::new();
    for (a, b) in [(0.6, 0.8), (-0.6, 0.8), (0.8, -0.6), (-0.8, -0.6)] {
        for (cosh, sinh) in [(1.0, 0.0), (1.25, 0.75), (1.25, -0.75), (2.125, 1.875)] {
            cloud.push([a * cosh, b * cosh, sinh]);
        }
    }
    assert_eq!(fit(&cloud, &everything(&cloud), Constraint::Trace), Err(Rejection::NotEllipsoid));
}

#[test]
fn factors_multiply_back_to_the_matrix() {
    // L with ones below the diagonal and D = 1..9 gives M[i][j] = d_0 + .. + d_(j-1) + d_j, all small integers.
    let mut m = [[0.0; 9]; 9];
    for i in 0..9 {
        for j in 0..=i {
            m[i][j] = ((j + 1) * (j + 2) / 2) as f32;
        }
    }
    let factors = factor(&m).expect("positive definite");
    for i in 0..9 {
        assert_eq!(factors.d[i], (i + 1) as f32);
        for j in 0..i {
            assert_eq!(factors.l[i][j], 1.0);
        }
    }
    // M x for x = (1, .., 1), computed with integers, is solved exactly.
    let mut b = [0.0; 9];
    for i in 0..9 {
        for j in 0..9 {
            b[i] += m[i.max(j)][i.min(j)];
        }
    }
    assert_eq!(solve(&factors, &b), [1.0; 9]);
}
