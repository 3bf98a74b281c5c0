//! Contenders that take turns, and their times as ratios with a spread.
//!
//! On Unix the clock is the processor time of the thread, which stands still while other programs have the processor;
//! elsewhere, and for work that several threads share, it is the one on the wall.

use std::hint::black_box;
use std::time::{Duration, Instant};

use crate::eval::statistics::quantile;

/// A turn is at least this long, or else the clock and the caches are what is measured.
const TURN: Duration = Duration::from_millis(1);

/// One way of doing something.
pub struct Contender<'a> {
    /// Its name in tables.
    pub name: &'static str,
    /// Does it once; returns how many units of work that was (points, trials, frames).
    pub work: Box<dyn FnMut() -> u64 + Send + 'a>,
    /// Other threads have a part in it: what this thread computes is not all.
    shared: bool,
}

impl std::fmt::Debug for Contender<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Contender").field("name", &self.name).finish_non_exhaustive()
    }
}

impl<'a> Contender<'a> {
    /// A contender.
    pub fn new(name: &'static str, work: impl FnMut() -> u64 + Send + 'a) -> Self {
        Self { name, work: Box::new(work), shared: false }
    }

    /// A contender whose work is done by several threads.
    pub fn of_threads(name: &'static str, work: impl FnMut() -> u64 + Send + 'a) -> Self {
        Self { name, work: Box::new(work), shared: true }
    }

    /// Time of `repeats` runs and the units of work in them.
    fn turn(&mut self, repeats: u32) -> (Duration, u64) {
        let mut units = 0;
        let started = Moment::now();
        for _ in 0..repeats {
            units += black_box((self.work)());
        }
        (started.elapsed(self.shared), units)
    }

    /// Runs that fill a turn.
    fn repeats(&mut self) -> u32 {
        let mut repeats = 1;
        while self.turn(repeats).0 < TURN && repeats < 1 << 20 {
            repeats *= 2;
        }
        repeats
    }
}

/// The time by both clocks.
struct Moment {
    wall: Instant,
    thread: Option<Duration>,
}

impl Moment {
    fn now() -> Self {
        Self { thread: thread_time(), wall: Instant::now() }
    }

    fn elapsed(&self, shared: bool) -> Duration {
        let wall = self.wall.elapsed();
        let thread = thread_time().zip(self.thread).map(|(now, then)| now.saturating_sub(then));
        thread.filter(|_| !shared).unwrap_or(wall)
    }
}

/// Processor time of this thread, where the system tells.
#[cfg(unix)]
fn thread_time() -> Option<Duration> {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Some(Duration::new(u64::try_from(time.tv_sec).ok()?, u32::try_from(time.tv_nsec).ok()?))
}

#[cfg(not(unix))]
fn thread_time() -> Option<Duration> {
    None
}

/// What a contender took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lap {
    /// The contender.
    pub name: &'static str,
    /// Nanoseconds a unit: median over the rounds.
    pub ns: f64,
    /// How many times faster than the first contender, round by round: lower quartile, median, upper quartile.
    pub faster: [f64; 3],
}

/// Lets the contenders take turns for so many rounds; `tick` is called after each. Laps in the order of the contenders.
pub fn race(mut contenders: Vec<Contender<'_>>, rounds: usize, mut tick: impl FnMut()) -> Vec<Lap> {
    let repeats: Vec<u32> = contenders.iter_mut().map(Contender::repeats).collect();
    let mut times = vec![Vec::with_capacity(rounds); contenders.len()];
    for _ in 0..rounds.max(1) {
        for ((contender, times), &repeats) in contenders.iter_mut().zip(&mut times).zip(&repeats) {
            let (time, units) = contender.turn(repeats);
            times.push(time.as_secs_f64() * 1e9 / units.max(1) as f64);
        }
        tick();
    }
    let Some(first) = times.first().cloned() else { return Vec::new() };
    let lap = |(contender, times): (&Contender<'_>, &Vec<f64>)| {
        let [_, ns, _] = quartiles(times.iter().copied());
        let faster = quartiles(first.iter().zip(times).map(|(first, own)| first / own));
        Lap { name: contender.name, ns, faster }
    };
    contenders.iter().zip(&times).map(lap).collect()
}

fn quartiles(values: impl Iterator<Item = f64>) -> [f64; 3] {
    let mut ascending: Vec<f64> = values.collect();
    ascending.sort_by(f64::total_cmp);
    [0.25, 0.5, 0.75].map(|share| quantile(&ascending, share).unwrap_or(f64::NAN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twice_the_work_takes_about_twice_the_time_and_the_first_is_as_fast_as_itself() {
        // A chain of roundings: nothing in it can be left out or done at the same time.
        let chain = |length: u32| {
            move || {
                let sum = (0..length).fold(black_box(1.0_f64), |sum, _| sum * 1.000_000_1 + 1e-9);
                u64::from(black_box(sum) > 0.0)
            }
        };
        let mut rounds = 0;
        let contenders = vec![Contender::new("once", chain(20_000)), Contender::new("twice", chain(40_000))];
        let laps = race(contenders, 9, || rounds += 1);
        assert_eq!((rounds, laps[0].faster), (9, [1.0; 3]));
        assert!((0.3..0.8).contains(&laps[1].faster[1]), "{laps:?}");
        assert!(laps[1].faster[0] <= laps[1].faster[1] && laps[1].faster[1] <= laps[1].faster[2]);
    }
}
