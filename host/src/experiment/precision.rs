//! The table behind the numbers of the core: why 32 bits suffice, and what they need for it.
//!
//! Samples of one-sided jujubes before a camera are fitted in every way of [`super::solvers`] and compared with the
//! least squares in 64 bits by Givens rotations in a local frame, which stands for the exact solution. A second table
//! looks at the two constraints themselves: how far the exact solution moves when the frame is turned, and how far it
//! is from the truth.

use nalgebra::{Matrix3, Vector3};
use varsac_core::{Constraint, Ellipsoid, Point3, fit::fit, rng::Stream};

use super::{
    Context, Experiment, Report,
    families::Kind,
    figure::{Axis, Chart, Figure, Mark, Series},
    solvers::{Frame, Solver, solve},
    table::{Cell, Column, Table, row},
};
use crate::{
    error::InputError,
    eval::statistics::quantile,
    synth::{noise::Noise, onesided},
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "precision",
    purpose: "Why f32: precision, frame, constraint and solver of the least squares against the exact solution.",
    run,
};

/// Points of a sample: minimal, the largest of the paper, and as many as a refit has.
const SIZES: [usize; 3] = [9, 12, 100];
/// Solutions farther than this from the exact one count as off, millimetres.
const OFF_MM: f64 = 0.5;

/// Centre of a solution.
type Solution = Option<Vector3<f64>>;

/// One of the ways.
struct Way {
    name: &'static str,
    constraint: Constraint,
    solve: fn(&[[f64; 3]], Constraint) -> Solution,
}

/// The centre that [`solve`] finds.
macro_rules! centre_of {
    ($scalar:ty, $frame:ident, $solver:ident) => {
        |points, constraint| {
            solve::<$scalar>(points, Frame::$frame, constraint, Solver::$solver).map(|(centre, _)| centre)
        }
    };
}

/// What stands for the exact solution.
const EXACT: fn(&[[f64; 3]], Constraint) -> Solution = centre_of!(f64, Local, Givens);

fn ways() -> Vec<Way> {
    let way =
        |name, solve| [Constraint::A11, Constraint::Trace].map(|constraint| Way { name, constraint, solve });
    [
        way("f32, raw, normal equations", centre_of!(f32, Raw, Normal)),
        way("f32, raw, Givens", centre_of!(f32, Raw, Givens)),
        way("f64, raw, normal equations", centre_of!(f64, Raw, Normal)),
        way("f32, local, normal equations", centre_of!(f32, Local, Normal)),
        way("f32, local, one refinement", centre_of!(f32, Local, Refined)),
        way("f32, local, Givens", centre_of!(f32, Local, Givens)),
        way("f64, local, normal equations", centre_of!(f64, Local, Normal)),
        way("the core", core),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The core's own fit, all of it.
fn core(points: &[[f64; 3]], constraint: Constraint) -> Solution {
    let cloud: Vec<Point3> = points.iter().map(|p| Point3::from(p.map(|v| v as f32))).collect();
    let all: Vec<u16> = (0..cloud.len() as u16).collect();
    let surface = fit(&cloud, &all, constraint).ok()?;
    Some(Ellipsoid::from(&surface).centre.coords.cast())
}

fn run(context: &Context) -> Result<Report, InputError> {
    let seeds = context.seeds(2000);
    let mut columns = vec![Column::new("way", "way", 0), Column::new("constraint", "constraint", 0)];
    let keys =
        [["lost_9", "off_9", "p90_9"], ["lost_12", "off_12", "p90_12"], ["lost_100", "off_100", "p90_100"]];
    for (size, [lost, off, p90]) in SIZES.into_iter().zip(keys) {
        columns.push(Column::new(lost, format!("n = {size}: lost %"), 2));
        columns.push(Column::new(off, format!("off > {OFF_MM} mm %"), 2));
        columns.push(Column::new(p90, "p90 mm", 5));
    }
    let title =
        format!("Against the exact solution, {} samples of one-sided jujubes of each size", seeds.len());
    let mut table = Table::new(title, columns);
    let ways = ways();
    let by_size = SIZES.map(|size| context.each(&seeds, |&seed| compare(&ways, size, seed)));
    let mut curves = Vec::new();
    for (k, way) in ways.iter().enumerate() {
        let mut cells = row![way.name, name_of(way.constraint)];
        for (place, samples) in by_size.iter().enumerate() {
            let errors: Vec<f64> = samples.iter().filter_map(|sample| sample[k]).collect();
            cells.extend(errors_of(&errors));
            if place == 0 && way.constraint == Constraint::Trace {
                curves.push((way.name, errors));
            }
        }
        table.push(cells);
    }
    let findings = findings(&table);
    let (constraints, turned) = constraint_table(context, &seeds);
    let chart = Chart {
        title: "Minimal samples (n = 9), trace = 3: distance from the exact centre".into(),
        x: Axis::logarithmic("distance mm").within(1e-6, 1e3),
        y: Axis::linear("share of samples within %").within(0.0, 100.0),
        series: curves.iter().enumerate().map(|(k, (name, errors))| distribution(name, k, errors)).collect(),
    };
    let caption = "Share of minimal samples whose centre is within a distance of the exact solution.";
    Ok(Report {
        findings: findings.into_iter().chain(turned).collect(),
        tables: vec![table, constraints],
        figures: vec![Figure::charts("solvers", caption, vec![chart])],
    })
}

fn name_of(constraint: Constraint) -> &'static str {
    match constraint {
        Constraint::A11 => "a11 = 1",
        Constraint::Trace => "trace = 3",
    }
}

/// A point farther than this from the true surface is the background's, at the rim, or a fault: it says nothing about
/// numbers.
const OTHERS_MM: f64 = 3.0;

/// `size` points of the visible side of a jujube, without replacement; fewer where it shows fewer.
fn sample(size: usize, seed: u64) -> (Vec<[f64; 3]>, [f64; 3]) {
    let (mut cloud, truth) = Kind::Views(&onesided::families::CLEAN).cloud(seed);
    cloud.retain(|point| truth.distance_mm(&point.cast()).abs() < OTHERS_MM);
    let mut stream = Stream::new(seed);
    let size = size.min(cloud.len());
    for k in 0..size {
        let from = k + stream.below((cloud.len() - k) as u32) as usize;
        cloud.swap(k, from);
    }
    (cloud[..size].iter().map(|p| [p.x, p.y, p.z].map(f64::from)).collect(), truth.centre_mm)
}

/// For each way the distance from the exact centre, infinite where the way found no ellipsoid; nothing where there is
/// no exact solution to compare with.
fn compare(ways: &[Way], size: usize, seed: u64) -> Vec<Option<f64>> {
    let (points, _) = sample(size, seed);
    let exact = [Constraint::A11, Constraint::Trace].map(|constraint| EXACT(&points, constraint));
    let against = |way: &Way| {
        let exact = exact[usize::from(way.constraint == Constraint::Trace)]?;
        Some((way.solve)(&points, way.constraint).map_or(f64::INFINITY, |centre| (centre - exact).norm()))
    };
    ways.iter().map(against).collect()
}

/// Lost %, off %, 90 % quantile of the found.
fn errors_of(errors: &[f64]) -> Vec<Cell> {
    let percent = |count: usize| 100.0 * count as f64 / errors.len().max(1) as f64;
    let mut found: Vec<f64> = errors.iter().copied().filter(|error| error.is_finite()).collect();
    found.sort_by(f64::total_cmp);
    let off = found.iter().filter(|error| **error > OFF_MM).count();
    row![percent(errors.len() - found.len()), percent(off), quantile(&found, 0.9)]
}

fn distribution(name: &str, colour: usize, errors: &[f64]) -> Series {
    let share = |limit: f64| errors.iter().filter(|error| **error <= limit).count() as f64;
    let limits = (-60..=30).map(|tenths| libm::exp10(f64::from(tenths) / 10.0));
    let points = limits.map(|limit| [limit, 100.0 * share(limit) / errors.len().max(1) as f64]).collect();
    // Eight ways and seven colours that differ: the core is what its own way is, dashed over it.
    if name == "the core" {
        Series::new(name, Mark::Dashed, 6, points)
    } else {
        Series::new(name, Mark::Line, colour, points)
    }
}

/// How much the constraint itself matters: movement of the exact centre under a turn of the frame, and its error.
fn constraint_table(context: &Context, seeds: &[u64]) -> (Table, Vec<String>) {
    let mut table = Table::new(
        "The constraint: the exact solution in a turned frame, and against the truth",
        vec![
            Column::new("constraint", "constraint", 0),
            Column::new("sample_size", "n", 0),
            Column::new("ellipsoids_percent", "ellipsoids %", 1),
            Column::new("moved_median", "moved by a turn, median mm", 4),
            Column::new("moved_p90", "p90 mm", 4),
            Column::new("error_median", "error, median mm", 2),
        ],
    );
    let mut findings = Vec::new();
    for constraint in [Constraint::A11, Constraint::Trace] {
        for size in SIZES {
            let runs = context.each(seeds, |&seed| {
                let (points, truth) = sample(size, seed);
                let centre = EXACT(&points, constraint)?;
                Some((
                    moved_by_a_turn(&points, &centre, constraint, seed),
                    (centre - Vector3::from(truth)).norm(),
                ))
            });
            let found: Vec<_> = runs.iter().flatten().collect();
            let sorted = |mut values: Vec<f64>| {
                values.sort_by(f64::total_cmp);
                values
            };
            let moved = sorted(found.iter().filter_map(|run| run.0).collect());
            let errors = sorted(found.iter().map(|run| run.1).collect());
            let percent = 100.0 * found.len() as f64 / runs.len() as f64;
            let median = quantile(&moved, 0.5);
            table.push(row![
                name_of(constraint),
                size,
                percent,
                median,
                quantile(&moved, 0.9),
                quantile(&errors, 0.5)
            ]);
            if size == SIZES[2] {
                findings.push(format!(
                    "With {} a turn of the frame moves the centre of {size} one-sided points by {:.3} mm (median).",
                    name_of(constraint),
                    median.unwrap_or(f64::NAN)
                ));
            }
        }
    }
    (table, findings)
}

/// Turns the points about their mean, solves, turns back; nothing where the turned points give no ellipsoid.
fn moved_by_a_turn(
    points: &[[f64; 3]],
    centre: &Vector3<f64>,
    constraint: Constraint,
    seed: u64,
) -> Option<f64> {
    let mut noise = Noise::new(seed);
    let first = noise.direction();
    let turn: Matrix3<f64> = noise.axes_about(first);
    let mean = points.iter().map(|p| Vector3::from(*p)).sum::<Vector3<f64>>() / points.len() as f64;
    let turned: Vec<[f64; 3]> = points.iter().map(|p| (turn * (Vector3::from(*p) - mean)).into()).collect();
    let found = turn.transpose() * EXACT(&turned, constraint)? + mean;
    Some((found - centre).norm())
}

fn findings(table: &Table) -> Vec<String> {
    let json = table.to_json();
    let value = |way: &str, key: &str| {
        let rows = json["rows"].as_array().map(Vec::as_slice).unwrap_or_default();
        let row = rows.iter().find(|row| row["way"] == way && row["constraint"] == "trace = 3");
        row.and_then(|row| row[key].as_f64()).unwrap_or(f64::NAN)
    };
    let wrong = |way: &str, n: &str| value(way, &format!("lost_{n}")) + value(way, &format!("off_{n}"));
    vec![
        format!(
            "In the camera's coordinates f32 normal equations lose or misplace {:.0} % of the minimal samples; in a local \
             frame {:.2} %, with one step of refinement {:.2} %, by Givens rotations {:.2} %.",
            wrong("f32, raw, normal equations", "9"),
            wrong("f32, local, normal equations", "9"),
            wrong("f32, local, one refinement", "9"),
            wrong("f32, local, Givens", "9")
        ),
        format!(
            "From 12 points on plain f32 normal equations in the local frame fail on {:.2} % and from 100 points on {:.2} %. The \
             core: {:.2}, {:.2} and {:.2} % at 9, 12 and 100 points.",
            wrong("f32, local, normal equations", "12"),
            wrong("f32, local, normal equations", "100"),
            wrong("the core", "9"),
            wrong("the core", "12"),
            wrong("the core", "100")
        ),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_trace_does_not_move_with_the_frame_and_a11_does() {
        let moved = |constraint| {
            let of = |seed| {
                let (points, _) = sample(100, seed);
                let centre = EXACT(&points, constraint)?;
                moved_by_a_turn(&points, &centre, constraint, seed)
            };
            (0..20).filter_map(of).fold(0.0, f64::max)
        };
        assert!(moved(Constraint::Trace) < 1e-6 && moved(Constraint::A11) > 0.1);
    }

    #[test]
    fn the_core_is_its_own_way() {
        for seed in 0..20 {
            let (points, _) = sample(100, seed);
            let same = solve::<f32>(&points, Frame::Local, Constraint::Trace, Solver::Refined)
                .map(|(centre, _)| centre);
            if let (Some(ours), Some(same)) = (core(&points, Constraint::Trace), same) {
                assert!((ours - same).norm() < 1e-2, "seed {seed}: {ours} {same}");
            }
        }
    }
}
