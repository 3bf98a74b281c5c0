//! Vectors of the default search: a dozen views, and what each stage makes of them.

use crate::format::{Case, check_file};
use crate::traces::{Entry, of_the_core, of_the_reference};
use varsac_core::{Config, OutlineRay, Point3, Viewpoint};
use varsac_host::region_view::RegionView;
use varsac_host::synth::onesided::families::{CLEAN, Family, HARD, OCCLUDED, ORCHARD, TOUCHING};
use varsac_host::synth::onesided::{MaskBias, Scene, Sighting};
use varsac_reference as reference;

/// Trials of which the hypotheses are kept.
const TRIALS: usize = 8;

/// A view with the seed of its run; the preset jujube searches it, from all around if it says so.
pub(crate) struct Task {
    pub(crate) view: RegionView,
    pub(crate) seed: u64,
    pub(crate) all_around: bool,
}

impl Task {
    /// The configuration of the search.
    pub(crate) fn config(&self) -> Config {
        let mut config = Config::jujube();
        if self.all_around {
            config.map.viewpoint = Viewpoint::None;
        }
        config
    }

    fn case(&self) -> Case {
        let view = &self.view;
        let points: Vec<[f32; 3]> = view.points.iter().map(|p| [p.x, p.y, p.z]).collect();
        let ray = |ray: &OutlineRay| [ray.inner.x, ray.inner.y, ray.inner.z, ray.outer_mm, ray.sigma_rad];
        let rays: Vec<[f32; 5]> = view.outline.iter().map(ray).collect();
        Case::default()
            .floats("points", points.as_flattened())
            .integers("in_mask", [view.in_mask as u32])
            .floats("outline", rays.as_flattened())
            .floats("pitch_rad", &[view.pitch_rad])
            .integers("seed", [self.seed as u32])
            .integers("all_around", [u32::from(self.all_around)])
    }

    fn read(case: &Case) -> Self {
        let point = |p: &[f32]| Point3::new(p[0], p[1], p[2]);
        let ray = |r: &[f32]| OutlineRay { inner: point(r), outer_mm: r[3], sigma_rad: r[4] };
        let view = RegionView {
            points: case.numbers("points").chunks(3).map(point).collect(),
            in_mask: case.word("in_mask") as usize,
            outline: case.numbers("outline").chunks(5).map(ray).collect(),
            pitch_rad: case.numbers("pitch_rad")[0],
        };
        Self { view, seed: u64::from(case.word("seed")), all_around: case.word("all_around") == 1 }
    }
}

/// Rendered views of one fruit and of several, a scan from all around, and a plane; about 1 m away, so that they are small.
fn tasks() -> Vec<Task> {
    let families = [CLEAN, CLEAN, HARD, HARD, HARD, OCCLUDED, OCCLUDED, ORCHARD, ORCHARD, TOUCHING];
    let rendered = families.into_iter().zip(1..).map(|(family, seed)| {
        let scene = Scene::new(&Family { distance_mm: (950.0, 1100.0), ..family }, seed);
        let Sighting { cloud, in_mask, outline, pitch_rad } = scene.sighting(MaskBias::default());
        Task { view: RegionView { points: cloud, in_mask, outline, pitch_rad }, seed, all_around: false }
    });
    let mut stream = reference::Stream::seeded(9);
    let flat = (0..80).map(|_| {
        let [x, y, depth] = [20.0, 20.0, 0.2].map(|reach| crate::between(&mut stream, -reach, reach));
        Point3::new(x, y, 900.0 + depth)
    });
    let around = (0..120).map(|k| {
        let z = (k as f32 + 0.5) / 60.0 - 1.0;
        let (sin, cos) = (libm::sinf(2.4 * k as f32), libm::cosf(2.4 * k as f32));
        let rim = libm::sqrtf(1.0 - z * z);
        Point3::new(3.0 + 21.0 * rim * cos, 11.0 * rim * sin, 10.5 * z)
    });
    let (flat, around) = (RegionView::of_cloud(flat.collect()), RegionView::of_cloud(around.collect()));
    rendered
        .chain([
            Task { view: flat, seed: 11, all_around: false },
            Task { view: around, seed: 12, all_around: true },
        ])
        .collect()
}

#[test]
fn views_and_their_labels() {
    let labels = |labels: &[u8]| labels.iter().map(|&label| u32::from(label)).collect::<Vec<_>>();
    let cases: Vec<Case> = tasks()
        .iter()
        .map(|task| task.case().integers("labels", labels(&of_the_reference(task).labels)))
        .collect();
    let what = "Chapters M2 and M3, the preset jujube: points, outline rays (inner point, outer depth, sigma), labels at the end.";
    check_file("map-views", what, &cases, |case| {
        case.expect_integers("labels", &labels(&of_the_core(&Task::read(case)).labels));
    });
}

/// Checks `tests/vectors/NAME.txt`: of the trace of each view of `map-views.txt` the lists that `of` makes of it.
fn check_traces(name: &str, what: &str, of: impl Fn(&[Entry]) -> Vec<(&'static str, Vec<f32>)>) {
    let tasks = tasks();
    let mut cases = Vec::new();
    for (number, task) in tasks.iter().enumerate() {
        let mut case = Case::default().integers("view", [number as u32]);
        for (list, numbers) in of(&of_the_reference(task).entries) {
            case = case.floats(list, &numbers);
        }
        cases.push(case);
    }
    check_file(name, what, &cases, |case| {
        let task = &tasks[case.word("view") as usize];
        for (list, numbers) in of(&of_the_core(task).entries) {
            case.expect_floats(list, &numbers);
        }
    });
}

#[test]
fn hypotheses() {
    let what = "Chapters M11 and M8, the first trials: estimates (centre, axes by rows, logarithms of the semi-axes, boxiness), supports.";
    check_traces("map-hypotheses", what, |entries| {
        let (mut estimates, mut supports) = (Vec::new(), Vec::new());
        let mut trials = 0;
        for entry in entries {
            match entry {
                Entry::Hypothesis(_) if trials == TRIALS => break,
                Entry::Hypothesis(estimate) => {
                    trials += 1;
                    estimates.extend_from_slice(estimate);
                }
                Entry::Support(support) => supports.extend_from_slice(support),
                _ => break,
            }
        }
        vec![("estimates", estimates), ("supports", supports)]
    });
}

#[test]
fn refined() {
    let what = "Chapter M12, the candidates of all searches after their last step: estimates and supports.";
    check_traces("map-refined", what, |entries| {
        let (mut estimates, mut supports) = (Vec::new(), Vec::new());
        for pair in entries.windows(2) {
            if let [Entry::Refined(estimate), Entry::Support(support)] = pair {
                estimates.extend_from_slice(estimate);
                supports.extend_from_slice(support);
            }
        }
        vec![("estimates", estimates), ("supports", supports)]
    });
}

#[test]
fn final_fits() {
    let what = "Chapters M13, M14 and M17: every noise (axial, lateral), every step of the final fit, the last of each turn.";
    check_traces("map-final", what, |entries| {
        let (mut noises, mut finals, mut joints) = (Vec::new(), Vec::new(), Vec::new());
        for entry in entries {
            match entry {
                Entry::Noise(noise) => noises.extend_from_slice(noise),
                Entry::Final(estimate) => finals.extend_from_slice(estimate),
                _ => {}
            }
        }
        for pair in entries.windows(2) {
            if let [Entry::Joint(estimate), Entry::Noise(_)] = pair {
                joints.extend_from_slice(estimate);
            }
        }
        vec![("noises", noises), ("final_steps", finals), ("joint", joints)]
    });
}

#[test]
fn findings() {
    let what = "Chapters M18 to M21, each fruit: ellipsoid (centre, semi-axes, axes), findings (explained, through, conflict, end_on, \
                size_sigma, rival, rays, outline, visible, colour, sigma_mm, flat, separation, clutter), covariance, code of \
                refusal (0: accepted, 1 to 12: in the order of M21, Singular last), value and limit.";
    check_traces("map-findings", what, |entries| {
        let (mut ellipsoids, mut findings, mut covariances, mut refusals) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for entry in entries {
            if let Entry::Judged(judged) = entry {
                ellipsoids.extend_from_slice(&judged.ellipsoid);
                findings.extend_from_slice(&judged.findings);
                covariances.extend_from_slice(&judged.covariance);
                refusals.extend_from_slice(&judged.refusal);
            }
        }
        vec![
            ("ellipsoids", ellipsoids),
            ("findings", findings),
            ("covariances", covariances),
            ("refusals", refusals),
        ]
    });
}
