//! Scenes in; for each method and scene out what became of its subject and of everything that was found.

use varsac_core::{Findings, RefusalCode, SizePrior};

use super::{
    WRONG_MM,
    coverage::levels,
    methods::{Method, Target},
};
use crate::{
    eval::{EllipsoidF64, attitude::angle_between_lines_deg, norm, subtract},
    experiment::Context,
    synth::onesided::{Family, MaskBias, Scene, Truth},
};

/// Scenes of a family, what the search is told of the size of fruit, what is wrong with the mask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Case {
    /// Name in tables.
    pub name: &'static str,
    /// Where scenes come from.
    pub family: Family,
    /// Size prior of the default search.
    pub prior: SizePrior,
    /// Error of the mask.
    pub bias: MaskBias,
}

impl Case {
    /// A family with the jujube's prior and a mask as the scene has it.
    pub const fn of(family: Family) -> Self {
        let bias = MaskBias { grow_px: 0, shift_px: [0, 0] };
        Self { name: family.name, family, prior: SizePrior::JUJUBE, bias }
    }

    /// With a spread of the whole size instead, as for an orchard whose fruit vary.
    pub const fn spread(self, spread: f32) -> Self {
        Self { prior: self.prior.with_spread(spread), ..self }
    }

    /// With a mask that is wrong, under another name.
    pub const fn biased(self, name: &'static str, grow_px: i64, shift_px: [i64; 2]) -> Self {
        Self { name, bias: MaskBias { grow_px, shift_px }, ..self }
    }

    /// Targets to look for: as many as there can be, and in a bunch some more.
    fn max_targets(&self) -> u8 {
        match self.family {
            Family { touching: (_, most), .. } if most >= 1.0 => 8,
            Family { neighbour, .. } if neighbour > 0.0 => 2,
            _ => 1,
        }
    }
}

/// What a method made of one scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Seed of the scene and of the search.
    pub seed: u64,
    /// Distance of the subject, mm; 0 in a scene without truth.
    pub distance_mm: f64,
    /// Visible share of the subject.
    pub visible: f64,
    /// The detection nearest to the subject.
    pub fit: Option<Fit>,
    /// All detections.
    pub detections: Vec<Judged>,
    /// Wall clock of the search, microseconds.
    pub micros: f64,
}

/// A fit of the subject beside the truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// Distance of the centres, mm.
    pub centre_mm: f64,
    /// Mean absolute difference of their coordinates, mm: the inner term of RMS-c.
    pub centre_mean_mm: f64,
    /// Mean absolute difference of the semi-axes, mm: the inner term of RMS-s.
    pub size_mean_mm: f64,
    /// Angle between the long axes, degrees.
    pub axis_deg: f64,
    /// True when the centre is off by more than the true short semi-axis.
    pub is_far: bool,
    /// Levels of the regions that just hold the truth ([`levels`]), where there is a covariance.
    pub levels: Option<[f64; 3]>,
    /// Index of the detection.
    pub detection: usize,
}

/// A detection as a robot sees it: is it a fruit?
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Judged {
    /// Distance to the nearest true centre, mm; infinite in a scene without fruit.
    pub error_mm: f64,
    /// True when that is more than the short semi-axis of that fruit.
    pub is_far: bool,
    /// Why it was refused; none when it was accepted.
    pub refusal: Option<RefusalCode>,
    /// What the gate looked at.
    pub findings: Option<Findings>,
}

impl Judged {
    fn of(target: &Target, fruit: &[Truth]) -> Self {
        let near = fruit
            .iter()
            .map(|truth| (distance_mm(&target.ellipsoid, &truth.ellipsoid), truth.ellipsoid.semi_axes_mm[2]))
            .min_by(|p, q| p.0.total_cmp(&q.0));
        let (error_mm, short_mm) = near.unwrap_or((f64::INFINITY, 0.0));
        Self { error_mm, is_far: error_mm > short_mm, refusal: target.refusal, findings: target.findings }
    }

    /// Accepted.
    pub fn is_accepted(&self) -> bool {
        self.refusal.is_none()
    }

    /// Accepted and wrong.
    pub fn is_wrong(&self) -> bool {
        self.is_accepted() && self.error_mm > WRONG_MM
    }
}

impl Fit {
    fn of(detection: usize, target: &Target, truth: &EllipsoidF64) -> Self {
        let fit = &target.ellipsoid;
        let mean = |p: [f64; 3], q: [f64; 3]| subtract(p, q).iter().map(|x| x.abs()).sum::<f64>() / 3.0;
        let centre_mm = distance_mm(fit, truth);
        Self {
            centre_mm,
            centre_mean_mm: mean(fit.centre_mm, truth.centre_mm),
            size_mean_mm: mean(fit.semi_axes_mm, truth.semi_axes_mm),
            axis_deg: angle_between_lines_deg(fit.axes[0], truth.axes[0]),
            is_far: centre_mm > truth.semi_axes_mm[2],
            levels: target.covariance.map(|covariance| levels(fit, &covariance, truth)),
            detection,
        }
    }
}

impl Outcome {
    fn of(seed: u64, scene: &Scene, targets: &[Target], micros: f64) -> Self {
        let subject = scene.fruit.first();
        let nearest = |truth: &Truth| {
            let fits = targets.iter().enumerate().map(|(k, target)| Fit::of(k, target, &truth.ellipsoid));
            fits.min_by(|p, q| p.centre_mm.total_cmp(&q.centre_mm))
        };
        Self {
            seed,
            distance_mm: subject.map_or(0.0, |truth| norm(truth.ellipsoid.centre_mm)),
            visible: subject.map_or(0.0, |truth| truth.visible),
            fit: subject.and_then(nearest),
            detections: targets.iter().map(|target| Judged::of(target, &scene.fruit)).collect(),
            micros,
        }
    }

    /// The subject's centre error, mm; infinite when nothing was found.
    pub fn centre_mm(&self) -> f64 {
        self.fit.map_or(f64::INFINITY, |fit| fit.centre_mm)
    }

    /// The fit of the subject, if its centre is within [`WRONG_MM`].
    pub fn right(&self) -> Option<&Fit> {
        self.fit.as_ref().filter(|fit| fit.centre_mm <= WRONG_MM)
    }

    /// The fit of the subject, if it was accepted.
    pub fn accepted(&self) -> Option<&Fit> {
        self.fit.as_ref().filter(|fit| self.detections[fit.detection].is_accepted())
    }
}

/// Distance of the centres.
pub(super) fn distance_mm(fit: &EllipsoidF64, truth: &EllipsoidF64) -> f64 {
    norm(subtract(fit.centre_mm, truth.centre_mm))
}

/// Outcomes by case, method and seed: each scene is made once and given to every method.
pub fn measure(
    context: &Context,
    cases: &[Case],
    methods: &[Method],
    seeds: &[u64],
) -> Vec<Vec<Vec<Outcome>>> {
    let outcome = |scene: &Scene, targets: &[Target], seed, micros| Outcome::of(seed, scene, targets, micros);
    each(context, cases, methods, seeds, outcome)
}

/// [`measure`] with another view of what was found.
pub(super) fn each<T: Send>(
    context: &Context,
    cases: &[Case],
    methods: &[Method],
    seeds: &[u64],
    outcome: impl Fn(&Scene, &[Target], u64, f64) -> T + Sync,
) -> Vec<Vec<Vec<T>>> {
    let jobs: Vec<(&Case, u64)> =
        cases.iter().flat_map(|case| seeds.iter().map(move |&seed| (case, seed))).collect();
    let of_scenes = context.each(&jobs, |&(case, seed)| {
        let scene = Scene::new(&case.family, seed);
        let sighting = scene.sighting(case.bias);
        let of_method = |method: &Method| {
            let (targets, micros) = method.find(&sighting, case.prior, case.max_targets(), seed);
            outcome(&scene, &targets, seed, micros)
        };
        methods.iter().map(of_method).collect::<Vec<T>>()
    });
    let mut by_case = Vec::new();
    let mut of_scenes = of_scenes.into_iter();
    for _ in cases {
        let mut by_method: Vec<Vec<T>> = methods.iter().map(|_| Vec::with_capacity(seeds.len())).collect();
        for of_methods in of_scenes.by_ref().take(seeds.len()) {
            for (list, outcome) in by_method.iter_mut().zip(of_methods) {
                list.push(outcome);
            }
        }
        by_case.push(by_method);
    }
    by_case
}
