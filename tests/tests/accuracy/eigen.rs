//! Jacobi's eigen-decomposition against multi-precision, and how many sweeps it needs.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use varsac_core::jacobi::{self, MAX_SWEEPS, Symmetric3};
use varsac_tests::{exact, random::Dice, statistics::Sample, sweeps, tolerance as limit};

use super::U;

fn symmetric(m: &Matrix3<f64>) -> Symmetric3 {
    let f = |i, j| m[(i, j)] as f32;
    Symmetric3 { xx: f(0, 0), yy: f(1, 1), zz: f(2, 2), xy: f(0, 1), xz: f(0, 2), yz: f(1, 2) }
}

/// Ten to a power between two exponents.
fn magnitude(dice: &mut Dice, low: f64, high: f64) -> f64 {
    libm::pow(10.0, dice.between(low, high))
}

fn normal_matrix(dice: &mut Dice) -> Matrix3<f64> {
    Matrix3::from_fn(|_, _| dice.normal())
}

/// Families of matrices, most of them wicked.
type Family = (&'static str, fn(&mut Dice) -> Matrix3<f64>);
const FAMILIES: [Family; 8] = [
    ("dense", |dice| {
        let g = normal_matrix(dice);
        g + g.transpose()
    }),
    ("spread eigenvalues", |dice| turned(dice, |dice| Vector3::from_fn(|_, _| magnitude(dice, -4.0, 4.0)))),
    ("graded", |dice| {
        let d = Matrix3::from_diagonal(&Vector3::from_fn(|_, _| magnitude(dice, -6.0, 6.0)));
        let g = normal_matrix(dice);
        d * (g * g.transpose() + Matrix3::identity()) * d
    }),
    ("nearly equal eigenvalues", |dice| {
        turned(dice, |dice| {
            let e = magnitude(dice, -9.0, 0.0);
            Vector3::new(1.0, 1.0 + e, 1.0 - e * dice.unit())
        })
    }),
    ("nearly a spheroid jujube", |dice| {
        turned(dice, |dice| {
            let b = 1.0 / 121.0;
            Vector3::new(1.0 / 484.0, b, b * (1.0 + magnitude(dice, -9.0, -1.0)))
        })
    }),
    ("nearly diagonal", |dice| {
        let g = magnitude(dice, -9.0, 0.0) * normal_matrix(dice);
        Matrix3::from_diagonal(&dice.normal3()) + g + g.transpose()
    }),
    ("small integers and a speck", |dice| {
        let g = Matrix3::from_fn(|_, _| [0.0, 1.0, -1.0, 2.0, 0.5, 1e-7, 3.0][dice.below(7)]);
        g.upper_triangle() + g.upper_triangle().transpose()
    }),
    ("subnormal", |dice| {
        let g = magnitude(dice, -44.0, -36.0) * normal_matrix(dice);
        g + g.transpose()
    }),
];

/// A diagonal seen from a random direction.
fn turned(dice: &mut Dice, diagonal: fn(&mut Dice) -> Vector3<f64>) -> Matrix3<f64> {
    let (r, d) = (dice.rotation(), diagonal(dice));
    r * Matrix3::from_diagonal(&d) * r.transpose()
}

#[test]
fn sweeps_of_jacobi_stay_below_their_bound() {
    let mut most = 0;
    for (name, family) in FAMILIES {
        let mut histogram = [0_u32; 10];
        for case in 0..20_000 {
            let a = symmetric(&family(&mut Dice::new(name, case)));
            let (count, mut values) = sweeps::needed(&a);
            most = most.max(count);
            histogram[(count as usize).min(9)] += 1;
            // The count is of the core's own algorithm only as long as the results are the same bits.
            values.sort_by(f32::total_cmp);
            assert_eq!(values.map(f32::to_bits), jacobi::eigen(&a).values.map(f32::to_bits), "{name} {case}");
        }
        println!("{name:<28} matrices by sweeps needed, 0..: {histogram:?}");
    }
    println!("most sweeps needed: {most}, allowed: {MAX_SWEEPS}");
    assert!(most < MAX_SWEEPS);
}

#[test]
fn eigenpairs_against_multi_precision() {
    for (name, family) in &FAMILIES[..6] {
        let (mut value, mut vector, mut orthonormal) =
            (Sample::default(), Sample::default(), Sample::default());
        for case in 0..400 {
            let a = symmetric(&family(&mut Dice::new(name, case)));
            let result = jacobi::eigen(&a);
            let (values, vectors) = exact::eigen(&a);
            let norm = values[0].abs().max(values[2].abs());
            let ours = result.vectors.map(|v| Vector3::from(v.map(f64::from)));
            for k in 0..3 {
                let (i, j) = ((k + 1) % 3, (k + 2) % 3);
                let gap = (values[i] - values[k]).abs().min((values[j] - values[k]).abs());
                value.push((f64::from(result.values[k]) - values[k]).abs() / (norm * U));
                let sine = ours[k].cross(&Vector3::from(vectors[k])).norm();
                vector.push(sine * gap / (norm * U));
                orthonormal.push((ours[k].norm() - 1.0).abs() / U);
                orthonormal.push(ours[k].dot(&ours[i]).abs() / U);
            }
        }
        limit::EIGEN_VALUE.check_for(name, value.max());
        limit::EIGEN_VECTOR.check_for(name, vector.max());
        limit::EIGEN_ORTHONORMAL.check_for(name, orthonormal.max());
    }
}

#[test]
fn eigenvalues_of_graded_matrices_keep_their_digits() {
    let mut error = Sample::default();
    for case in 0..1500 {
        // Semi-axes up to 1 : 100, then any grading on top.
        let mut dice = Dice::new("graded digits", case);
        let b = turned(&mut dice, |dice| Vector3::from_fn(|_, _| magnitude(dice, -4.0, 0.0)));
        let d = Matrix3::from_diagonal(&Vector3::from_fn(|_, _| magnitude(&mut dice, -5.0, 5.0)));
        let a = symmetric(&(d * b * d));
        let (values, _) = exact::eigen(&a);
        let ours = jacobi::eigen(&a).values;
        // Condition of the matrix scaled to ones on its diagonal.
        let unit = |i: usize, j: usize, v: f32| f64::from(v) / libm::sqrt(diagonal(&a, i) * diagonal(&a, j));
        let (xy, xz, yz) = (unit(0, 1, a.xy), unit(0, 2, a.xz), unit(1, 2, a.yz));
        let scaled = SymmetricEigen::new(Matrix3::new(1.0, xy, xz, xy, 1.0, yz, xz, yz, 1.0)).eigenvalues;
        for k in 0..3 {
            let relative = (f64::from(ours[k]) - values[k]).abs() / values[k].abs();
            error.push(relative / (U * scaled.max() / scaled.min().abs()));
        }
    }
    limit::EIGEN_VALUE_GRADED.check(error.max());
}

fn diagonal(a: &Symmetric3, i: usize) -> f64 {
    f64::from([a.xx, a.yy, a.zz][i])
}
