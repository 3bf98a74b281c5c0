//! The methods that are compared on one-sided views, all asked the same way: one region of a depth image, all its fruit.

use std::time::Instant;

use varsac_core::{
    Config, Covariance, Detection, Detector, Ellipsoid, Findings, RefusalCode, SizePrior, Status, View,
    Workspace,
};

use crate::{
    baseline::{RansacOptions, ransac},
    eval::EllipsoidF64,
    locate::fit_all,
    synth::onesided::Sighting,
};

/// A method.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// The default search, with mask and outline rays.
    Outline,
    /// The default search on the points alone.
    Cloud,
    /// Algorithm 1 of the paper with TEBC.
    Varsac,
    /// Nine points, distance and normal.
    Ransac,
    /// Least squares on all points.
    Direct,
}

/// One ellipsoid that a method reports.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// The ellipsoid.
    pub ellipsoid: EllipsoidF64,
    /// Why it was refused; none when it was accepted.
    pub refusal: Option<RefusalCode>,
    /// What the gate looked at, where there is one.
    pub findings: Option<Findings>,
    /// How sure, where the method says so.
    pub covariance: Option<Covariance>,
}

impl From<&Detection> for Target {
    fn from(detection: &Detection) -> Self {
        Self {
            refusal: match detection.status {
                Status::Accepted => None,
                Status::Refused(refusal) => Some(refusal.code),
            },
            findings: detection.findings,
            covariance: detection.covariance,
            ..Self::plain(EllipsoidF64::from(&detection.ellipsoid))
        }
    }
}

impl Target {
    fn plain(ellipsoid: EllipsoidF64) -> Self {
        Self { ellipsoid, refusal: None, findings: None, covariance: None }
    }
}

/// Most points of a region.
const CAPACITY: usize = 16_384;

impl Method {
    /// All of them, ours first.
    pub const ALL: [Self; 5] = [Self::Outline, Self::Cloud, Self::Varsac, Self::Ransac, Self::Direct];
    /// The default search in both forms.
    pub const OURS: [Self; 2] = [Self::Outline, Self::Cloud];

    /// Name in tables.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Outline => "default, outlines",
            Self::Cloud => "default, cloud only",
            Self::Varsac => "VARSAC+TEBC",
            Self::Ransac => "RANSAC",
            Self::Direct => "direct",
        }
    }

    /// What it finds and how long it took, wall clock in microseconds. Every method is told of jujubes by
    /// [`Config::jujube`], of at most `max_targets`, and to stop at the first search in vain.
    ///
    /// # Panics
    /// When the prior is out of the range that [`Config::check`] allows.
    pub fn find(
        self,
        sighting: &Sighting,
        prior: SizePrior,
        max_targets: u8,
        seed: u64,
    ) -> (Vec<Target>, f64) {
        let mut config = Config { max_targets, max_failures: 1, ..Config::jujube() };
        config.map.prior = prior;
        match self {
            Self::Outline => detect(config, &sighting.full(), seed),
            Self::Cloud => detect(config, &sighting.points_only(), seed),
            Self::Varsac => detect(config.paper(), &sighting.points_only(), seed),
            Self::Ransac => {
                let points: Vec<[f32; 3]> = sighting.cloud.iter().map(|p| [p.x, p.y, p.z]).collect();
                let options = RansacOptions::from(&config);
                timed(|| ransac(&points, &options, seed).iter().map(|t| Target::plain(t.ellipsoid)).collect())
            }
            Self::Direct => timed(|| {
                let surface = fit_all(&sighting.cloud, config.constraint);
                surface.iter().map(|s| Target::plain(EllipsoidF64::from(&Ellipsoid::from(s)))).collect()
            }),
        }
    }
}

fn detect(config: Config, view: &View<'_>, seed: u64) -> (Vec<Target>, f64) {
    let detector = Detector::new(config).expect("the prior is in range");
    let mut workspace = Box::new(Workspace::<CAPACITY>::new());
    let (found, micros) = timed(|| {
        let run = detector.detect_view(view, workspace.scratch(), seed);
        run.expect("a region of a patch fits").collect::<Vec<Detection>>()
    });
    (found.iter().map(Target::from).collect(), micros)
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let started = Instant::now();
    let result = work();
    (result, started.elapsed().as_secs_f64() * 1e6)
}
