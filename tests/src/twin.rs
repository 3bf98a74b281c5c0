//! The paper's search in 64 bits: the same draws as the core's, the same order of events, `f64` in every fit, size
//! check, score and bound. What differs between the two is rounding and nothing else.
//!
//! Written from `core/docs/numerics.md`; "chapter" refers to it. Neighbourhoods are decided in `f32` (chapter 4) on
//! both sides, because a point on the rim that came and went would shift every draw behind it. Scale and origin of the
//! local frame do not matter in 64 bits beyond rounding and are taken from the exact points.

use nalgebra::Vector3;
use varsac_core::{Config, Point3, point::distance_squared, rng::Stream};

use crate::{
    body::{Central64, wide},
    least_squares::{Frame, central64, design},
};

/// A target of the twin.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// The surface after the refits.
    pub surface: Central64,
    /// Its points, ascending.
    pub inliers: Vec<u16>,
    /// Trials of its search.
    pub trials: u32,
}

/// Searches a cloud as `Detector::detect` does, to the end.
pub fn search(config: &Config, cloud: &[Point3], seed: u64) -> Vec<Target> {
    let mut run = Run {
        config,
        cloud,
        points: cloud.iter().map(wide).collect(),
        live: (0..cloud.len() as u16).collect(),
        stream: Stream::new(seed),
    };
    let smallest = config.sample_sizes.iter().copied().min().map_or(0, usize::from);
    let mut targets: Vec<Target> = Vec::new();
    let mut failures = 0;
    // Chapter 10.
    while targets.len() < usize::from(config.max_targets) && failures < config.max_failures {
        let last = targets.last().map_or(0, |target| target.inliers.len());
        if run.live.len() < smallest || run.live.len() < last {
            break;
        }
        let found = run.best().map(|(surface, trials)| (run.refitted(surface), trials));
        let claimed = found.map(|(surface, trials)| {
            let inliers = run.inliers(&surface);
            Target { surface, inliers, trials }
        });
        match claimed {
            Some(target) if target.inliers.len() >= usize::from(config.min_inliers) => {
                run.live.retain(|index| target.inliers.binary_search(index).is_err());
                targets.push(target);
            }
            _ => failures += 1,
        }
    }
    targets
}

struct Run<'a> {
    config: &'a Config,
    cloud: &'a [Point3],
    points: Vec<Vector3<f64>>,
    live: Vec<u16>,
    stream: Stream,
}

impl Run<'_> {
    /// Chapter 9: the best hypothesis of one search, and its trials.
    fn best(&mut self) -> Option<(Central64, u32)> {
        let config = self.config;
        let mut best: Option<(Central64, usize)> = None;
        let mut bound = config.max_trials;
        let mut trials = 0;
        let mut sizes = config.sample_sizes.iter().cycle();
        while trials < bound {
            trials += 1;
            let size = usize::from(*sizes.next()?);
            let members = self.neighbourhood();
            let mut sample = vec![0; size];
            if !self.stream.sample(members.len() as u32, &mut sample) {
                continue;
            }
            let sample: Vec<u16> = sample.iter().map(|&position| members[usize::from(position)]).collect();
            let Some(surface) = self.valid_fit(&sample) else { continue };
            let inliers = members.iter().filter(|&&index| self.is_inlier(&surface, index)).count();
            // A quotient of two counts against a decimal such as 0.6, which 114 of 190 is: in f32, so that both sides
            // mean the same 0.6.
            let supported = inliers as f32 / members.len() as f32 >= config.min_ratio;
            if inliers < usize::from(config.min_inliers) || !supported {
                continue;
            }
            if best.is_none_or(|(_, most)| inliers > most) {
                best = Some((surface, inliers));
                bound = trials_needed(config, inliers as f64 / members.len() as f64);
            }
        }
        best.map(|(surface, _)| (surface, trials))
    }

    fn neighbourhood(&mut self) -> Vec<u16> {
        let radius = self.config.radius;
        if radius == f32::INFINITY {
            return self.live.clone();
        }
        let rank = self.stream.below(self.live.len() as u32);
        let centre = self.cloud[usize::from(self.live[rank as usize])];
        let near =
            |index: &u16| distance_squared(&self.cloud[usize::from(*index)], &centre) <= radius * radius;
        self.live.iter().copied().filter(near).collect()
    }

    /// Chapters 5 and 6.
    fn valid_fit(&self, sample: &[u16]) -> Option<Central64> {
        let points: Vec<_> = sample.iter().map(|&index| self.points[usize::from(index)]).collect();
        let surface = fit(&points, self.config.constraint)?;
        let body = surface.body();
        let (min, max) = (f64::from(self.config.semi_axis_min), f64::from(self.config.semi_axis_max));
        body.semi_axes.iter().all(|&axis| min < axis && axis < max).then_some(surface)
    }

    /// Chapter 7.
    fn is_inlier(&self, surface: &Central64, index: u16) -> bool {
        let d = f64::from(self.config.shell);
        let f = surface.value(&self.points[usize::from(index)]);
        ((1.0 - d) * (1.0 - d)..=(1.0 + d) * (1.0 + d)).contains(&f)
    }

    fn inliers(&self, surface: &Central64) -> Vec<u16> {
        self.live.iter().copied().filter(|&index| self.is_inlier(surface, index)).collect()
    }

    fn refitted(&self, mut surface: Central64) -> Central64 {
        for _ in 0..self.config.refits {
            match self.valid_fit(&self.inliers(&surface)) {
                Some(better) if better != surface => surface = better,
                _ => break,
            }
        }
        surface
    }
}

/// Eq. (17) with one ratio for all sizes, chapter 8.
pub fn trials_needed(config: &Config, ratio: f64) -> u32 {
    let w = ratio.min(0.9999);
    let sum: f64 = config.sample_sizes.iter().map(|&n| libm::log1p(-libm::pow(w, f64::from(n)))).sum();
    let k = config.sample_sizes.len() as f64 * libm::log1p(-f64::from(config.confidence)) / sum;
    if k < f64::from(config.max_trials) { (libm::ceil(k) as u32).max(1) } else { config.max_trials }
}

/// Chapter 5: normal equations, `L D L^T` with the core's limit on the pivots, one refinement.
pub fn fit(points: &[Vector3<f64>], constraint: varsac_core::Constraint) -> Option<Central64> {
    if points.len() < 9 {
        return None;
    }
    let frame = Frame::around(points);
    let rows: Vec<_> =
        points.iter().map(|p| design(&((p - frame.origin) * frame.scale), constraint)).collect();
    let mut m = [[0.0; 9]; 9];
    for (row, _) in &rows {
        for i in 0..9 {
            for j in 0..=i {
                m[i][j] += row[i] * row[j];
            }
        }
    }
    let pivots = factor(&mut m)?;
    let against = |x: &[f64; 9]| {
        let mut sum = [0.0; 9];
        for (row, target) in &rows {
            let residual = row.iter().zip(x).fold(*target, |rest, (r, x)| rest - r * x);
            for k in 0..9 {
                sum[k] += row[k] * residual;
            }
        }
        solve(&m, &pivots, sum)
    };
    let mut x = against(&[0.0; 9]);
    let correction = against(&x);
    for k in 0..9 {
        x[k] += correction[k];
    }
    central64(&x, constraint, &frame)
}

/// Unit lower triangle in place; returns the pivots.
fn factor(m: &mut [[f64; 9]; 9]) -> Option<[f64; 9]> {
    let mut d = [0.0; 9];
    for i in 0..9 {
        let diagonal = m[i][i];
        for j in 0..i {
            let known: f64 = (0..j).map(|k| m[i][k] * d[k] * m[j][k]).sum();
            m[i][j] = (m[i][j] - known) / d[j];
        }
        d[i] = diagonal - (0..i).map(|k| m[i][k] * m[i][k] * d[k]).sum::<f64>();
        let usable = d[i] > f64::from(varsac_core::linalg::MIN_PIVOT_RATIO) * diagonal;
        if !usable {
            return None;
        }
    }
    Some(d)
}

fn solve(l: &[[f64; 9]; 9], d: &[f64; 9], mut x: [f64; 9]) -> [f64; 9] {
    for i in 0..9 {
        x[i] -= (0..i).map(|k| l[i][k] * x[k]).sum::<f64>();
    }
    for i in 0..9 {
        x[i] /= d[i];
    }
    for i in (0..9).rev() {
        x[i] -= (i + 1..9).map(|k| l[k][i] * x[k]).sum::<f64>();
    }
    x
}
