//! How fast: every way of doing a thing takes turns with the others within one run ([`crate::speed`]), so that the ratios
//! hold on a busy machine too.
//!
//! A "seed" is a round of turns here: the data stay the same, the clock does not. Times are medians over the rounds, ratios
//! are taken round by round and shown with their quartiles. Everything runs on one thread but for the last table.

use super::{
    Context, Experiment, Report,
    table::{Column, Table, row},
};
use crate::{
    error::InputError,
    speed::{
        Contender, Lap, frames::Stages, kernels::Scoring, race, searches, trees::Neighbourhoods, workload,
    },
};

/// The entry of the registry.
pub(super) const EXPERIMENT: Experiment = Experiment {
    name: "speed",
    purpose: "Time of a point, a hypothesis, a fruit and a frame, ours and others side by side, and how it grows.",
    run,
};

/// Rounds by default.
const ROUNDS: u64 = 15;
/// Points that are scored: what fits the nearest cache.
const SCORED: usize = 4096;
/// One-sided views for hypotheses and fruit.
const VIEWS: u64 = 4;
/// Fruit of the frame.
const FRAME_FRUIT: usize = 10;
/// Sizes of clouds.
const CLOUDS: [usize; 4] = [1_000, 4_000, 16_000, 64_000];
/// Fruit in a cloud.
const FRUIT: [u8; 4] = [1, 3, 10, 30];
/// Points around each of them.
const POINTS_EACH: usize = 1000;

fn run(context: &Context) -> Result<Report, InputError> {
    let one_thread = threads(1)?;
    let mut report = Report::default();
    let scoring = Scoring::new(SCORED, context.seed);
    let views = workload::views(VIEWS, context.seed);
    let stages = Stages::of(workload::frame(FRAME_FRUIT, context.seed))?;

    let mut tables = one_thread.install(|| {
        let clock = Clock::new(context);
        vec![
            clock.race(format!("Scoring {SCORED} points, one point"), Unit::Point, scoring.contenders()),
            clock.race("One hypothesis on a one-sided view", Unit::Short, searches::hypotheses(&views)),
            clock.race("One fruit on a one-sided view", Unit::Short, searches::fruit(&views)),
            clock.race(
                format!("A frame of {} regions and {} points, by stage", stages.regions(), stages.points()),
                Unit::Frame,
                stages.contenders(),
            ),
            clock.points(),
            clock.fruit(),
            clock.trees(),
        ]
    });
    tables.push(Clock::new(context).threads(&stages)?);
    report.findings.push(format!(
        "All ways of counting between two ellipsoids count the same {} of {SCORED} points.",
        scoring.tebc_one_by_one()
    ));
    report.tables = tables;
    Ok(report)
}

/// What a time is printed as.
#[derive(Debug, Clone, Copy)]
enum Unit {
    /// Nanoseconds, as microseconds per thousand.
    Point,
    /// Microseconds.
    Short,
    /// Milliseconds.
    Frame,
}

impl Unit {
    fn column(self) -> Column {
        match self {
            Self::Point => Column::new("thousand_us", "ns", 3),
            Self::Short => Column::new("time_us", "µs", 1),
            Self::Frame => Column::new("time_ms", "ms", 2),
        }
    }

    fn of(self, lap: &Lap) -> f64 {
        match self {
            Self::Point => lap.ns,
            Self::Short => lap.ns * 1e-3,
            Self::Frame => lap.ns * 1e-6,
        }
    }
}

/// Races with so many rounds.
struct Clock<'a> {
    context: &'a Context,
    rounds: usize,
}

impl<'a> Clock<'a> {
    fn new(context: &'a Context) -> Self {
        Self { context, rounds: context.seeds(ROUNDS).len() }
    }

    fn laps(&self, contenders: Vec<Contender<'_>>) -> Vec<Lap> {
        self.context.progress.inc_length(self.rounds as u64);
        race(contenders, self.rounds, || self.context.progress.inc(1))
    }

    /// A table of contenders, compared with the first.
    fn race(&self, title: impl Into<String>, unit: Unit, contenders: Vec<Contender<'_>>) -> Table {
        let columns = vec![
            Column::new("what", "what", 0),
            unit.column(),
            Column::new("faster_ratio", "times faster than the first", 2),
            Column::new("lower_quartile_ratio", "lower quartile", 2),
            Column::new("upper_quartile_ratio", "upper quartile", 2),
        ];
        let mut table = Table::new(title, columns);
        for lap in self.laps(contenders) {
            let [lower, median, upper] = lap.faster;
            table.push(row![lap.name, unit.of(&lap), median, lower, upper]);
        }
        table
    }

    /// The first fruit in ever larger clouds of the same density.
    fn points(&self) -> Table {
        let columns = vec![
            Column::new("points", "points", 0),
            Column::new("paper_us", "the paper's search µs", 0),
            Column::new("default_us", "default search µs", 0),
            Column::new("default_point_us", "default search µs per 1000 points", 1),
        ];
        let mut table = Table::new("Growth with the points: the first fruit of a cloud", columns);
        for points in CLOUDS {
            let cloud = workload::wall(points / POINTS_EACH, POINTS_EACH, self.context.seed);
            let [paper, ours] = two(&self.laps(searches::in_one_cloud(&cloud, 1)));
            table.push(row![cloud.len(), paper, ours, ours * 1e3 / points as f64]);
        }
        table
    }

    /// All fruit of ever larger walls.
    fn fruit(&self) -> Table {
        let columns = vec![
            Column::new("fruit", "fruit", 0),
            Column::new("points", "points", 0),
            Column::new("paper_us", "the paper's search µs", 0),
            Column::new("default_us", "default search µs", 0),
            Column::new("default_fruit_us", "default search µs per fruit", 0),
        ];
        let mut table = Table::new("Growth with the fruit: all of a cloud", columns);
        for fruit in FRUIT {
            let cloud = workload::wall(usize::from(fruit), POINTS_EACH, self.context.seed);
            let [paper, ours] = two(&self.laps(searches::in_one_cloud(&cloud, fruit)));
            table.push(row![u32::from(fruit), cloud.len(), paper, ours, ours / f64::from(fruit)]);
        }
        table
    }

    /// Neighbourhoods: build and query.
    fn trees(&self) -> Table {
        let columns = vec![
            Column::new("points", "points", 0),
            Column::new("what", "what", 0),
            Column::new("build_us", "build µs", 1),
            Column::new("query_us", "query µs", 2),
            Column::new("faster_ratio", "query: times faster than every point", 2),
            Column::new("lower_quartile_ratio", "lower quartile", 2),
            Column::new("upper_quartile_ratio", "upper quartile", 2),
        ];
        let mut table =
            Table::new("The neighbourhood of a point, 20 mm, as a list in ascending order", columns);
        for points in CLOUDS {
            let neighbourhoods = Neighbourhoods::new(points, self.context.seed);
            let builds = self.laps(neighbourhoods.builds());
            for lap in self.laps(neighbourhoods.queries()) {
                let build = builds.iter().find(|build| build.name == lap.name).map(|build| build.ns * 1e-3);
                let [lower, median, upper] = lap.faster;
                table.push(row![points, lap.name, build, lap.ns * 1e-3, median, lower, upper]);
            }
        }
        table
    }

    /// The whole frame on one thread and on two.
    fn threads(&self, stages: &Stages) -> Result<Table, InputError> {
        let contender = |name, pool: rayon::ThreadPool| {
            let mut whole = stages.whole(name);
            Contender::of_threads(name, move || pool.install(|| (whole.work)()))
        };
        let contenders = vec![contender("1 thread", threads(1)?), contender("2 threads", threads(2)?)];
        Ok(self.race("The frame by threads: regions are searched side by side", Unit::Frame, contenders))
    }
}

/// A pool of so many threads.
fn threads(count: usize) -> Result<rayon::ThreadPool, InputError> {
    rayon::ThreadPoolBuilder::new().num_threads(count).build().map_err(|error| {
        InputError::at("threads", error.to_string(), "run on a machine that lets a program start threads")
    })
}

/// Microseconds of two contenders.
fn two(laps: &[Lap]) -> [f64; 2] {
    [0, 1].map(|k| laps.get(k).map_or(f64::NAN, |lap: &Lap| lap.ns * 1e-3))
}
