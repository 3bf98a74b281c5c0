//! Clouds and configurations that no camera and no reasonable person delivers.

use nalgebra::Vector3;
use varsac_core::{Config, Constraint, Point3};

use crate::{
    body::{Body, narrow},
    random::Dice,
};

/// A named way to make `n` points.
pub type Family = (&'static str, fn(&mut Dice, usize) -> Vec<Point3>);

/// Every family; sizes and seeds are the caller's.
pub const FAMILIES: &[Family] = &[
    ("all equal", |dice, n| vec![narrow(&dice.in_cube(1000.0)); n]),
    ("two places", |dice, n| {
        let places = [dice.in_cube(30.0), dice.in_cube(30.0)].map(|p| narrow(&p));
        (0..n).map(|_| places[dice.below(2)]).collect()
    }),
    ("nine equal points and a few others", |dice, n| {
        let place = dice.in_cube(20.0);
        points(n, dice, |dice, k| if k < 9 { place } else { place + dice.in_cube(15.0) })
    }),
    ("line", |dice, n| {
        let (start, along) = (dice.in_cube(500.0), dice.direction());
        points(n, dice, |dice, _| start + along * dice.between(-30.0, 30.0))
    }),
    ("plane", |dice, n| {
        let (start, a, b) = (dice.in_cube(500.0), dice.direction(), dice.direction());
        points(n, dice, |dice, _| start + a * dice.between(-30.0, 30.0) + b * dice.between(-30.0, 30.0))
    }),
    ("sheet with noise", |dice, n| {
        let (r, noise) = (dice.rotation(), libm::pow(10.0, dice.between(-6.0, 1.0)));
        points(n, dice, |dice, _| {
            r * Vector3::new(dice.between(-30.0, 30.0), dice.between(-30.0, 30.0), noise * dice.normal())
        })
    }),
    ("lattice", |dice, n| {
        points(n, dice, |dice, _| Vector3::from_fn(|_, _| dice.below(4) as f64 * 8.0 + 640.0))
    }),
    ("sphere", |dice, n| {
        let centre = dice.in_cube(900.0);
        points(n, dice, |dice, _| centre + 12.0 * dice.direction())
    }),
    ("ball", |dice, n| points(n, dice, |dice, _| 12.0 * dice.unit() * dice.direction())),
    ("cylinder", |dice, n| {
        let r = dice.rotation();
        points(n, dice, |dice, _| {
            let turn = dice.between(0.0, 6.3);
            r * Vector3::new(11.0 * libm::cos(turn), 11.0 * libm::sin(turn), dice.between(-25.0, 25.0))
        })
    }),
    ("saddle", |dice, n| {
        points(n, dice, |dice, _| {
            let (x, y) = (dice.between(-20.0, 20.0), dice.between(-20.0, 20.0));
            Vector3::new(x, y, 700.0 + 0.05 * (x * x - y * y))
        })
    }),
    ("two touching fruit", |dice, n| {
        let near = Body::jujube(dice, Vector3::new(0.0, 0.0, 700.0));
        let other = Body::jujube(dice, Vector3::new(22.0, 0.0, 700.0));
        points(n, dice, |dice, k| if k % 2 == 0 { near } else { other }.surface_point(dice))
    }),
    ("needle and disc", |dice, n| {
        let thin = libm::pow(10.0, dice.between(-4.0, 1.0));
        let semi_axes = Vector3::new(20.0, if dice.unit() < 0.5 { thin } else { 20.0 }, thin);
        let body = Body { centre: dice.in_cube(700.0), semi_axes, axes: dice.rotation() };
        points(n, dice, |dice, _| body.from_sphere(&dice.direction()))
    }),
    ("subnormal spread", |dice, n| points(n, dice, |dice, _| dice.in_cube(1e-40))),
    ("spread at the end of the exponents", |dice, n| {
        let size = libm::pow(10.0, dice.between(-38.0, -15.0));
        points(n, dice, |dice, _| size * dice.direction())
    }),
    ("corners of the allowed cube", |dice, n| {
        points(n, dice, |dice, _| Vector3::from_fn(|_, _| if dice.unit() < 0.5 { -1e9 } else { 1e9 }))
    }),
    ("a body as large as the allowed cube", |dice, n| points(n, dice, |dice, _| 1e9 * dice.direction())),
    ("one point far away", |dice, n| {
        points(n, dice, |dice, k| if k == 0 { Vector3::repeat(1e9) } else { 12.0 * dice.direction() })
    }),
    ("all magnitudes", |dice, n| {
        points(n, dice, |dice, _| dice.direction() * libm::pow(10.0, dice.between(-44.0, 9.0)))
    }),
    ("any bits", |dice, n| {
        let mut coordinate = || loop {
            let value = f32::from_bits(dice.bits() as u32);
            if value.abs() <= 1e9 {
                break value;
            }
        };
        (0..n).map(|_| Point3::new(coordinate(), coordinate(), coordinate())).collect()
    }),
    ("signed zeros", |dice, n| {
        let mut zero = || if dice.unit() < 0.5 { 0.0 } else { -0.0 };
        (0..n).map(|_| Point3::new(zero(), zero(), zero())).collect()
    }),
];

fn points(n: usize, dice: &mut Dice, point: impl Fn(&mut Dice, usize) -> Vector3<f64>) -> Vec<Point3> {
    // Rounding to f32 may step over the limit on coordinates by nothing: 1e9 is an f32.
    (0..n).map(|k| narrow(&point(dice, k))).collect()
}

/// A valid configuration from anywhere in the allowed ranges, ends included; at most `max_trials` trials a search.
pub fn config(dice: &mut Dice, max_trials: usize) -> Config {
    loop {
        let config = any_config(dice, max_trials);
        if config.check().is_ok() {
            return config;
        }
    }
}

fn any_config(dice: &mut Dice, max_trials: usize) -> Config {
    let length = |dice: &mut Dice, low: f64, high: f64| libm::pow(10.0, dice.between(low, high)) as f32;
    let open_unit = |dice: &mut Dice| match dice.below(6) {
        0 => f32::from_bits(1),
        1 => 1.0 - f32::EPSILON / 2.0,
        _ => dice.between(0.001, 0.999) as f32,
    };
    let (confidence, shell) = (open_unit(dice), open_unit(dice));
    let (semi_axis_min, semi_axis_max) = match dice.below(4) {
        0 => (1e-9, 1e9),
        1 => {
            let min = length(dice, -9.0, 8.9);
            (min, min * (1.0 + f32::EPSILON) * 1.01)
        }
        2 => (length(dice, -9.0, 0.0), length(dice, 0.1, 9.0)),
        _ => (5.0, 60.0),
    };
    let mut config = Config {
        confidence,
        shell,
        radius: if dice.unit() < 0.3 { f32::INFINITY } else { length(dice, -8.9, 8.9) },
        semi_axis_min,
        semi_axis_max,
        max_trials: 1 + dice.below(max_trials) as u32,
        refits: dice.below(11) as u8,
        min_inliers: if dice.unit() < 0.5 { 1 } else { 1 + dice.below(40) as u16 },
        min_ratio: if dice.unit() < 0.5 { 0.0 } else { dice.unit() as f32 },
        max_targets: if dice.unit() < 0.1 { 255 } else { 1 + dice.below(8) as u8 },
        max_failures: 1 + dice.below(4) as u8,
        constraint: if dice.unit() < 0.5 { Constraint::A11 } else { Constraint::Trace },
        ..Config::table5()
    };
    config.sample_sizes.clear();
    for _ in 0..=dice.below(16) {
        config.sample_sizes.push(9 + dice.below(24) as u8).expect("sixteen fit");
    }
    config
}
