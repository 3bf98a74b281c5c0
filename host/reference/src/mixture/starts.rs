//! From several starts to at most three shells: contract, chapter X8.

use super::blob::Blob;
use super::climb::climb;
use super::config::MixtureConfig;
use super::look::{Look, Scene};
use super::numbers::{smallest, within};
use super::shell::{Shell, held};
use crate::fault::{self, Fault};
use crate::map::algebra::{Vector, dot};
use crate::map::model::{Estimate, apart2};
use crate::map::view::Viewpoint;

/// X8: the sample of a search.
pub(crate) struct Sample {
    /// Local points in the order drawn.
    pub(crate) points: Vec<Vector>,
    /// Those of them that lie in the mask, in this order.
    pub(crate) seeds: Vec<Vector>,
}

/// A shell and its gain over the sample.
#[derive(Clone, Copy)]
pub(crate) struct Kept {
    pub(crate) shell: Shell,
    pub(crate) gain: f32,
}

/// X8: the shells kept, best first.
pub(crate) fn kept(scene: &Scene, sample: &Sample, config: &MixtureConfig) -> Vec<Kept> {
    let mut kept = Vec::new();
    let mut remembered = Vec::new();
    for k in 0..=usize::from(config.starts) {
        let Some((blob, steps)) = first_blob(k, sample) else { break };
        let Some(blob) = followed(blob, steps, sample, scene) else { continue };
        let start = first_shell(&blob, config.viewpoint);
        if let Some(shell) = grown(start, scene, sample, config, &mut remembered) {
            let gain = Look::new(scene, &shell, shell.ln_area(), &sample.points).gain();
            keep(&mut kept, Kept { shell, gain });
        }
    }
    kept
}

/// X8: `same(A, B, part)`.
fn same(a: &Estimate, b: &Estimate, part: f32) -> bool {
    let n = part * smallest(a.x);
    let z = |e: &Estimate| e.x[0] + e.x[1] + e.x[2];
    apart2(a, b) < n * n && libm::fabsf(z(a) - z(b)) < part
}

/// X8.1: the blob of start `k` and the number of its steps; none where the starts are over.
fn first_blob(k: usize, sample: &Sample) -> Option<(Blob, usize)> {
    if k == 0 {
        let mut sum = [0.0; 3];
        for p in &sample.points {
            sum = [sum[0] + p[0], sum[1] + p[1], sum[2] + p[2]];
        }
        let s = sample.points.len() as f32;
        return Some((Blob::round([sum[0] / s, sum[1] / s, sum[2] / s], 1.0, 0.5), 20));
    }
    let mean = *sample.seeds.get(k - 1)?;
    let deviation = if k.is_multiple_of(2) { 0.2 } else { 0.4 };
    Some((Blob::round(mean, deviation, 0.8), 3))
}

/// X8.1: the blob after its steps, unless it is lost.
fn followed(mut blob: Blob, steps: usize, sample: &Sample, scene: &Scene) -> Option<Blob> {
    for _ in 0..steps {
        blob = blob.step(&sample.points, scene.volume)?;
    }
    Some(blob)
}

/// X8.2.
fn first_shell(blob: &Blob, viewpoint: Viewpoint) -> Shell {
    let mut estimate = blob.shell().estimate;
    if viewpoint == Viewpoint::Origin {
        estimate.centre = pushed_back(&estimate);
    }
    let estimate = held(&estimate);
    let [x1, x2, x3] = estimate.x;
    let mean = libm::expf((x1 + x2 + x3) / 3.0);
    let sigma = 0.35 * libm::sqrtf(mean * smallest(estimate.x));
    Shell { estimate, sigma, share: within(blob.share, 0.02, 0.99) }
}

/// X8.2: the centre behind the half that is seen.
fn pushed_back(estimate: &Estimate) -> Vector {
    const H: f32 = 2.0 / 3.0;
    let c = estimate.centre;
    let range = libm::sqrtf(dot(c, c));
    let mut z = 0.0;
    for k in 0..3 {
        let a = libm::expf(estimate.x[k]) * (dot(estimate.axes[k], c) / range);
        z += a * a;
    }
    let f = 1.0 + H * (libm::sqrtf(z) / range);
    [c[0] * f, c[1] * f, c[2] * f]
}

/// X8.3: the shell after its steps; none where the start ends early.
fn grown(
    mut shell: Shell,
    scene: &Scene,
    sample: &Sample,
    config: &MixtureConfig,
    remembered: &mut Vec<Estimate>,
) -> Option<Shell> {
    let first = shell.ln_area();
    for i in 0..22 {
        let (ln_area, most) =
            if i < 16 { (first, 0.8 * shell.sigma) } else { (shell.ln_area(), f32::INFINITY) };
        let pass = Look::new(scene, &shell, ln_area, &sample.points).pass(0.0, config.shape_spread);
        let before = shell.estimate;
        shell = climb(&shell, &pass, 0.002, most)?.shell;
        if i == 8 {
            if remembered.iter().any(|old| same(old, &before, 0.25)) && !fault::is(Fault::Remembered) {
                return None;
            }
            remembered.push(before);
        }
    }
    Some(shell)
}

/// X8.4.
fn keep(list: &mut Vec<Kept>, new: Kept) {
    let worse = |old: &Kept| new.gain > old.gain;
    if let Some(position) = list.iter().position(|old| same(&old.shell.estimate, &new.shell.estimate, 0.1)) {
        if !worse(&list[position]) || fault::is(Fault::Kept) {
            return;
        }
        list.remove(position);
    } else if list.len() == 3 {
        if !worse(&list[2]) {
            return;
        }
        list.pop();
    }
    let position = list.iter().position(worse).unwrap_or(list.len());
    list.insert(position, new);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f32, gain: f32) -> Kept {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let estimate = Estimate { centre: [x, 0.0, 0.0], axes, x: [0.0; 3], boxiness: 0.0 };
        Kept { shell: Shell { estimate, sigma: 0.1, share: 0.5 }, gain }
    }

    fn gains(list: &[Kept]) -> Vec<f32> {
        list.iter().map(|kept| kept.gain).collect()
    }

    #[test]
    fn three_are_kept_best_first_and_none_twice() {
        let mut list = Vec::new();
        for (x, gain) in [(0.0, 2.0), (1.0, 3.0), (2.0, 2.0), (3.0, 1.0), (0.05, 2.0)] {
            keep(&mut list, at(x, gain));
        }
        assert_eq!(gains(&list), [3.0, 2.0, 2.0]);
        assert_eq!(list[1].shell.estimate.centre[0], 0.0, "of two equal ones the earlier stands first");
        keep(&mut list, at(2.05, 4.0));
        assert_eq!(gains(&list), [4.0, 3.0, 2.0]);
        keep(&mut list, at(9.0, 2.5));
        assert_eq!(gains(&list), [4.0, 3.0, 2.5]);
    }
}
