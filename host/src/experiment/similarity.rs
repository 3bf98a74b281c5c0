//! Eq. (1), (2), Fig. 3: how much fruit look like ellipsoids: delta of their front, rho of their bottom.
//!
//! The paper photographed fifty jujubes. Here silhouettes are drawn of bodies with the size and spread of jujubes that
//! are ellipsoids to different degrees: `|x/a|^e + |y/b|^e + |z/c|^e = 1`, 2 for an ellipsoid, more for fuller ends. What
//! delta the paper measured then tells which body its fruit resemble. Two masks of a real fruit can be given instead.

use std::path::Path;

use super::{
    Context, Experiment, Report,
    figure::{Axis, Chart, DARK, Figure, Mark, Series},
    table::{Column, Table, row},
};
use crate::{
    error::InputError,
    eval::statistics::mean_and_deviation,
    frame::png_file,
    image::LabelImage,
    similarity::{bottom_similarity, front_similarity},
    synth::noise::Noise,
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "similarity",
    purpose: "Likeness of fruit and ellipsoid, delta and rho, over bodies of different fullness, or of two given masks.",
    run,
};

/// Fruit the paper measured.
const FRUIT: u64 = 50;
/// Mean delta, rho and their product as printed, %.
const PRINTED: [f64; 3] = [89.2, 93.7, 89.2];
const EXPONENTS: [f64; 6] = [1.75, 2.0, 2.25, 2.5, 3.0, 4.0];
/// Exponent whose fruit are shown one by one.
const SHOWN: f64 = 2.5;
/// Mean semi-axes of a jujube, millimetres, and the deviations of the logarithms of the length, the width and of the
/// ratio of the two short ones. The last makes rho 0.937 on average, as printed: the mean of exp(-|x|).
const MEAN_MM: [f64; 2] = [21.75, 10.9];
const SPREAD: [f64; 3] = [0.035, 0.042, 0.083];
const PIXELS_PER_MM: f64 = 5.0;

fn run(context: &Context) -> Result<Report, InputError> {
    let mut table = Table::new(
        "Similarity, mean over the fruit",
        vec![
            Column::new("fruit", "fruit", 0),
            Column::new("count", "count", 0),
            Column::new("delta_percent", "delta %", 1),
            Column::new("delta_deviation", "deviation", 1),
            Column::new("rho_percent", "rho %", 1),
            Column::new("rho_deviation", "deviation", 1),
            Column::new("product_percent", "delta rho %", 1),
        ],
    );
    let [delta, rho, product] = PRINTED;
    table.push(row!["the paper's jujubes", FRUIT, delta, None::<f64>, rho, None::<f64>, product]);
    if let Some([front, bottom]) = &context.masks {
        let [delta, rho] = of_masks(front, bottom)?.map(|share| 100.0 * share);
        table.push(row!["the given masks", 1_u32, delta, None::<f64>, rho, None::<f64>, delta * rho / 100.0]);
    }
    let seeds = context.seeds(FRUIT);
    let (mut curve, mut shown, mut apart) = (Vec::new(), Vec::new(), 0.0_f64);
    for exponent in EXPONENTS {
        let fruit = context.each(&seeds, |&seed| of_body(exponent, seed));
        let percent = |k: usize| fruit.iter().map(|f| 100.0 * f[k]).collect::<Vec<f64>>();
        let products: Vec<f64> = fruit.iter().map(|f| 100.0 * f[0] * f[1]).collect();
        let [delta, rho, product] = [percent(0), percent(1), products]
            .map(|v| mean_and_deviation(&v).unwrap_or((f64::NAN, f64::NAN)));
        table.push(row![
            format!("exponent {exponent}"),
            fruit.len(),
            delta.0,
            delta.1,
            rho.0,
            rho.1,
            product.0
        ]);
        curve.push([exponent, delta.0]);
        apart = apart.max((product.0 - delta.0 * rho.0 / 100.0).abs());
        if exponent == SHOWN {
            shown = fruit;
        }
    }
    let printed = [[EXPONENTS[0], delta], [EXPONENTS[EXPONENTS.len() - 1], delta]].to_vec();
    let charts = vec![
        fruit_chart(&shown),
        Chart {
            title: "Mean delta of fuller bodies".into(),
            x: Axis::linear("exponent of the body, 2 = ellipsoid"),
            y: Axis::linear("delta %"),
            series: vec![
                Series::new("drawn", Mark::Line, 0, curve.clone()),
                Series::new("the paper's jujubes", Mark::Dashed, DARK, printed),
            ],
        },
    ];
    let findings = vec![
        format!(
            "The paper's delta of {delta} % is that of a body of exponent {}, fuller than an ellipsoid (or of a leaner one: delta does not \
             tell).",
            crossing(&curve, delta).map_or_else(|| "outside the range".to_owned(), |e| format!("{e:.2}"))
        ),
        format!(
            "The printed mean of delta rho, {product} %, equals that of delta. The product of the means is {:.1} %, and over \
             the bodies here the mean of products is within {apart:.2} points of the product of means: a misprint.",
            delta * rho / 100.0
        ),
    ];
    let caption = "Left: each fruit of exponent 2.5, as in Fig. 3. Right: the mean over the exponent.";
    Ok(Report { findings, tables: vec![table], figures: vec![Figure::charts("fruit", caption, charts)] })
}

fn fruit_chart(fruit: &[[f64; 2]]) -> Chart {
    let series = |name: &str, mark, colour, value: &dyn Fn(&[f64; 2]) -> f64| {
        let points = fruit.iter().enumerate().map(|(k, f)| [k as f64 + 1.0, 100.0 * value(f)]).collect();
        Series::new(name, mark, colour, points)
    };
    Chart {
        title: "Similarity of each fruit".into(),
        x: Axis::linear("fruit"),
        y: Axis::linear("%"),
        series: vec![
            series("delta", Mark::Dots, 0, &|f| f[0]),
            series("rho", Mark::Dots, 1, &|f| f[1]),
            series("delta rho", Mark::Line, 2, &|f| f[0] * f[1]),
        ],
    }
}

/// Where a falling curve crosses a level, linear between its points.
fn crossing(curve: &[[f64; 2]], level: f64) -> Option<f64> {
    curve.windows(2).rev().find_map(|pair| {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        ((y0 - level) * (y1 - level) <= 0.0 && y0 != y1).then(|| x0 + (x1 - x0) * (level - y0) / (y1 - y0))
    })
}

/// delta and rho of one body of this exponent, its silhouettes turned at random.
fn of_body(exponent: f64, seed: u64) -> [f64; 2] {
    let mut noise = Noise::new(seed);
    let [length, width, ratio] = SPREAD.map(|spread| spread * noise.normal());
    let [a, middle] = [MEAN_MM[0] * libm::exp(length), MEAN_MM[1] * libm::exp(width)];
    let [b, c] = [0.5, -0.5].map(|half| middle * libm::exp(half * ratio));
    let mut view = |p, q| silhouette(p, q, exponent, noise.between(0.0, std::f64::consts::PI));
    let (front, bottom) = (view(a, b), view(b, c));
    [front_similarity(&front).unwrap_or(f64::NAN), bottom_similarity(&bottom).unwrap_or(f64::NAN)]
}

/// The outline of a body with semi-axes p and q, millimetres, seen along the third, filled.
fn silhouette(p: f64, q: f64, exponent: f64, turn: f64) -> LabelImage {
    // A super-ellipse of a large exponent reaches out to its rectangle's corners.
    let size = (2.1 * (p * p + q * q).sqrt() * PIXELS_PER_MM) as usize;
    let middle = (size as f64 - 1.0) / 2.0;
    let (sin, cos) = libm::sincos(turn);
    let mut mask = LabelImage::filled(size, size, 0);
    for v in 0..size {
        for u in 0..size {
            let (x, y) = ((u as f64 - middle) / PIXELS_PER_MM, (v as f64 - middle) / PIXELS_PER_MM);
            let (along, across) = ((x * cos + y * sin).abs() / p, (y * cos - x * sin).abs() / q);
            if libm::pow(along, exponent) + libm::pow(across, exponent) <= 1.0 {
                mask.set(u as i64, v as i64, 255);
            }
        }
    }
    mask
}

/// delta of the first mask, rho of the second.
fn of_masks(front: &Path, bottom: &Path) -> Result<[f64; 2], InputError> {
    let empty = |path| InputError::in_file(path, "no pixel is set", "give a mask that shows one fruit");
    let delta =
        front_similarity(&png_file::read(front, png_file::decode_mask)?).ok_or_else(|| empty(front))?;
    let rho =
        bottom_similarity(&png_file::read(bottom, png_file::decode_mask)?).ok_or_else(|| empty(bottom))?;
    Ok([delta, rho])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ellipsoid_is_similar_to_itself_and_a_full_body_less() {
        let [delta, rho] = of_body(2.0, 1);
        assert!(delta > 0.97 && (0.7..=1.0).contains(&rho), "{delta} {rho}");
        // Area of the super-ellipse of exponent 4: 3.7081 a b, so delta = pi / 3.7081.
        assert!((of_body(4.0, 1)[0] - 0.8472).abs() < 0.02);
    }

    #[test]
    fn a_level_is_found_between_two_points() {
        assert_eq!(crossing(&[[1.0, 10.0], [2.0, 20.0], [3.0, 10.0]], 15.0), Some(2.5));
        assert_eq!(crossing(&[[1.0, 10.0], [2.0, 20.0]], 30.0), None);
    }

    #[test]
    fn given_masks_are_measured() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["front.png", "bottom.png"].map(|name| folder.path().join(name));
        let mut mask = LabelImage::filled(40, 30, 0);
        (5..25).for_each(|v| (5..35).for_each(|u| mask.set(u, v, 255)));
        for path in &paths {
            std::fs::write(path, png_file::encode_labels(&mask).unwrap()).unwrap();
        }
        let context = Context { masks: Some(paths.clone()), seeds: Some(1), ..Context::default() };
        let rows = run(&context).unwrap().tables[0].to_json()["rows"].clone();
        assert!((rows[1]["rho_percent"].as_f64().unwrap() - 200.0 / 3.0).abs() < 1e-9, "{rows}");
        std::fs::remove_file(&paths[0]).unwrap();
        assert!(run(&context).is_err());
    }
}
