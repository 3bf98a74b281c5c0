//! The search of one region: the core's, a baseline's, or one ellipsoid through everything.

use rayon::prelude::*;
use varsac_core::{Detection, Detector, Ellipsoid, Score, Status, View, Workspace, geometric::Criterion};

use super::{MAX_CAPACITY, Method, Options, Refusal, Target, whole};
use crate::{
    baseline::{RansacOptions, ransac},
    error::InputError,
    region_view::RegionView,
};

/// Who searches the regions of an input.
pub trait Searcher {
    /// Searches each view; the results in their order.
    ///
    /// # Errors
    /// A cloud or a configuration that cannot be searched.
    fn search(&mut self, views: &[RegionView], options: &Options) -> Result<Vec<Found>, InputError>;
}

/// This program, all regions side by side.
#[derive(Debug, Clone, Copy)]
pub struct Here;

impl Searcher for Here {
    fn search(&mut self, views: &[RegionView], options: &Options) -> Result<Vec<Found>, InputError> {
        let detector = detector(options)?;
        views.par_iter().map(|view| search_region(view, &detector, options)).collect()
    }
}

/// The detector of these options.
///
/// # Errors
/// A configuration out of range.
pub fn detector(options: &Options) -> Result<Detector, InputError> {
    Detector::new(options.config.clone())
        .map_err(|error| InputError::at("configuration", error.to_string(), "change the option that sets it"))
}

/// Targets of one region and the label of each of its points (0, or the target's number in the region).
pub type Found = (Vec<Target>, Vec<u32>);

/// What the method may look at: all of the view, or (the paper's methods, which know nothing of surroundings) its region.
pub fn seen(view: &RegionView, method: Method) -> View<'_> {
    match method {
        Method::Map | Method::Mixture => view.view(),
        _ => View::from(view.points.get(..view.in_mask).unwrap_or(&view.points)),
    }
}

fn search_region(view: &RegionView, detector: &Detector, options: &Options) -> Result<Found, InputError> {
    let seen = seen(view, options.method);
    let cloud = seen.cloud;
    let (targets, mut labels) = match options.method {
        Method::Map | Method::Mixture | Method::Varsac => {
            let mut workspace = RegionWorkspace::new(cloud.len());
            let mut run =
                detector.detect_view(&seen, workspace.scratch(), options.seed).map_err(|error| {
                    InputError::at("cloud", error.to_string(), "check the unit (--unit) and the file")
                })?;
            let targets = run.by_ref().map(|detection| Target::from(&detection)).collect();
            (targets, run.labels().iter().map(|&label| u32::from(label)).collect())
        }
        Method::Ransac => {
            let points: Vec<[f32; 3]> = cloud.iter().map(|p| [p.x, p.y, p.z]).collect();
            let found = ransac(&points, &RansacOptions::from(&options.config), options.seed);
            let mut labels = vec![0; cloud.len()];
            let mut targets = Vec::new();
            for (k, one) in found.iter().enumerate() {
                for &index in &one.inliers {
                    labels[index as usize] = k as u32 + 1;
                }
                let score = Score { inliers: one.inliers.len() as u32, candidates: one.candidates as u32 };
                targets.push(target(Ellipsoid::from(&one.ellipsoid), score, one.trials));
            }
            (targets, labels)
        }
        Method::Direct => whole::direct(cloud, options.config.constraint, options.config.shell),
        Method::Algebraic => whole::fitted(cloud, Criterion::Algebraic, options.config.shell),
        Method::Geometric => whole::fitted(cloud, Criterion::Geometric, options.config.shell),
    };
    labels.resize(view.points.len(), 0);
    Ok((targets, labels))
}

pub(super) fn target(ellipsoid: Ellipsoid, score: Score, trials: u32) -> Target {
    Target { region: 0, refusal: None, ellipsoid, score, trials, covariance: None }
}

impl From<&Detection> for Target {
    fn from(detection: &Detection) -> Self {
        let refusal = match detection.status {
            Status::Accepted => None,
            Status::Refused(why) => {
                Some(Refusal { code: why.code.name(), value: why.value, limit: why.limit })
            }
        };
        Self {
            refusal,
            covariance: detection.covariance,
            ..target(detection.ellipsoid, detection.score, detection.report.trials)
        }
    }
}

/// A workspace of a fitting size, on the heap; most regions are small.
enum RegionWorkspace {
    Small(Box<Workspace<4096>>),
    Large(Box<Workspace<MAX_CAPACITY>>),
}

impl RegionWorkspace {
    fn new(points: usize) -> Self {
        if points <= 4096 { Self::Small(Box::default()) } else { Self::Large(Box::default()) }
    }

    fn scratch(&mut self) -> varsac_core::Scratch<'_> {
        match self {
            Self::Small(workspace) => workspace.scratch(),
            Self::Large(workspace) => workspace.scratch(),
        }
    }
}
