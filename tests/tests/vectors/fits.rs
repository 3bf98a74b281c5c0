//! Vectors of the fit, step by step.

use crate::format::{Case, check_file};
use crate::{everything, points_read, surface_numbers, view};
use varsac_core::{Constraint, Observer, Quadric, fit, linalg};
use varsac_reference as reference;

/// Compares what the core shows of a fit.
struct FitAgainst<'a>(&'a Case);

impl Observer for FitAgainst<'_> {
    fn normal_equations(&mut self, matrix: &linalg::Symmetric9, rhs: &[f32; 9]) {
        self.0.expect_floats("matrix", &matrix.0);
        self.0.expect_floats("rhs", rhs);
    }

    fn solution(&mut self, x: &[f32; 9]) {
        self.0.expect_floats("solution", x);
    }

    fn quadric(&mut self, q: &Quadric) {
        let numbers = [q.a11, q.a22, q.a33, q.a12, q.a13, q.a23, q.a14, q.a24, q.a34, q.a44];
        self.0.expect_floats("quadric", &numbers);
        let i = q.invariants();
        self.0.expect_floats("invariants", &[i.i1, i.i2, i.i3, i.i4]);
    }
}

#[test]
fn fits() {
    let mut stream = reference::Stream::seeded(5);
    let mut cases = Vec::new();
    // Bent into z = 700 + bend x y + flat z: a saddle is no ellipsoid, and a plane determines no quadric.
    for (count, constraint, bend) in [
        (9, 0, None),
        (9, 1, None),
        (12, 0, None),
        (12, 1, None),
        (40, 1, None),
        (12, 1, Some((0.05, 0.1))),
        (12, 0, Some((0.0, 0.0))),
    ] {
        let mut points = view(&mut stream, count);
        for p in &mut points {
            if let Some((bend, flat)) = bend {
                p[2] = 700.0 + bend * (p[0] - 30.0) * (p[1] + 20.0) + flat * (p[2] - 700.0);
            }
        }
        let mut case =
            Case::default().floats("points", points.as_flattened()).integers("trace", [constraint]);
        let kind = if constraint == 0 { reference::Constraint::A11 } else { reference::Constraint::Trace };
        let mut events = Vec::new();
        let fitted =
            reference::fit_observed(&points, &everything(count), kind, &mut |event| events.push(event));
        for event in events {
            case = match event {
                reference::Event::Normal { matrix, rhs } => {
                    case.floats("matrix", &matrix).floats("rhs", &rhs)
                }
                reference::Event::Solution(x) => case.floats("solution", &x),
                reference::Event::Quadric(numbers) => case.floats("quadric", &numbers),
                reference::Event::Invariants(numbers) => case.floats("invariants", &numbers),
                _ => case,
            };
        }
        cases.push(match fitted {
            Ok(surface) => case.floats("surface", &surface_numbers(&surface)),
            Err(rejection) => case.integers("rejected", [rejection as u32]),
        });
    }
    let what =
        "Chapter 5: points, constraint (0 = a11, 1 = trace), then every step, or the kind of rejection.";
    check_file("fits", what, &cases, |case| {
        let cloud = points_read(case);
        let constraint = if case.word("trace") == 0 { Constraint::A11 } else { Constraint::Trace };
        let mut observer = FitAgainst(case);
        match fit::fit_observed(&cloud, &everything(cloud.len()), constraint, &mut observer) {
            Ok(found) => {
                let (c, s) = (&found.centre, &found.shape);
                case.expect_floats("surface", &[c.x, c.y, c.z, s.xx, s.yy, s.zz, s.xy, s.xz, s.yz]);
            }
            Err(rejection) => case.expect_integers("rejected", &[rejection as u32]),
        }
    });
    let ended = |name: &str| cases.iter().filter(|case| !case.words(name).is_empty()).count();
    assert_eq!((ended("surface"), ended("rejected")), (5, 2), "vectors of both ends");
}
