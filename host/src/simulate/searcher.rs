//! The co-processor in the place of the core: the regions of an input go over the link, one after the other.

use std::ops::ControlFlow;

use varsac_core::link::payload;
use varsac_core::{Ellipsoid, Point3, Score};

use super::client::{Client, Job};
use super::expected::compare;
use super::transport::Transport;
use crate::error::InputError;
use crate::locate::{Found, Options, Refusal, Searcher, Target, detector, seen};
use crate::region_view::RegionView;

/// A client that searches for [`crate::locate`].
pub struct CoProcessor {
    client: Client<Box<dyn Transport>>,
    check: bool,
    searches: u32,
    differences: Vec<String>,
    stack_bytes: Option<u32>,
}

impl CoProcessor {
    /// Searches over `transport`; with `check` the core does the same searches here and the bits are compared.
    pub fn new(transport: Box<dyn Transport>, check: bool) -> Self {
        Self {
            client: Client::new(transport),
            check,
            searches: 0,
            differences: Vec::new(),
            stack_bytes: None,
        }
    }

    /// Searches done.
    pub fn searches(&self) -> u32 {
        self.searches
    }

    /// What differed, a sentence each.
    pub fn differences(&self) -> &[String] {
        &self.differences
    }

    /// Deepest use of the co-processor's stack, where it is measured.
    pub fn stack_bytes(&self) -> Option<u32> {
        self.stack_bytes
    }
}

impl Searcher for CoProcessor {
    fn search(&mut self, views: &[RegionView], options: &Options) -> Result<Vec<Found>, InputError> {
        let detector = detector(options)?;
        let mut found = Vec::with_capacity(views.len());
        for (k, view) in views.iter().enumerate() {
            let seen = seen(view, options.method);
            let job = Job { config: detector.config(), view: seen, seed: options.seed, step_budget: 0 };
            let outcome = self.client.search(&job, |_| ControlFlow::Continue(())).map_err(|error| {
                InputError::at(format!("region {}", k + 1), error.to_string(), "then run the command again")
            })?;
            self.searches += 1;
            self.stack_bytes = self.stack_bytes.max(outcome.report.stack_bytes);
            if self.check {
                let difference = compare(&detector, &job, &outcome).map_err(|error| {
                    InputError::at("cloud", error.to_string(), "check the unit (--unit) and the file")
                })?;
                self.differences
                    .extend(difference.map(|difference| format!("region {}: {difference}", k + 1)));
            }
            let mut labels = labels(seen.cloud, &outcome.targets, options.config.shell);
            labels.resize(view.points.len(), 0);
            found.push((outcome.targets.iter().map(target).collect(), labels));
        }
        Ok(found)
    }
}

/// As [`crate::locate`] names things.
fn target(target: &payload::Target) -> Target {
    Target {
        region: 0,
        refusal: target.refusal.map(|why| Refusal {
            code: why.code.name(),
            value: why.value,
            limit: why.limit,
        }),
        ellipsoid: Ellipsoid {
            centre: target.centre_mm.into(),
            semi_axes: target.semi_axes_mm,
            axes: target.axes,
        },
        score: Score { inliers: target.inliers, candidates: target.candidates },
        trials: target.trials,
        covariance: target.covariance,
    }
}

/// Which target claims each point, for pictures: labels do not go over the link, so the shells are built again from
/// the semi-axes, and a point on the very edge of one may come out on its other side.
fn labels(cloud: &[Point3], targets: &[payload::Target], shell: f32) -> Vec<u32> {
    let (inner, outer) = ((1.0 - shell).powi(2), (1.0 + shell).powi(2));
    let inside = |point: &Point3, target: &payload::Target| {
        let centre = Point3::from(target.centre_mm);
        let offset = point - centre;
        let scaled = target.axes.iter().zip(target.semi_axes_mm).map(|([x, y, z], semi_axis)| {
            let along = (x * offset.x + y * offset.y + z * offset.z) / semi_axis;
            along * along
        });
        (inner..=outer).contains(&scaled.sum())
    };
    let label = |point| targets.iter().position(|target| inside(point, target)).map_or(0, |k| k as u32 + 1);
    cloud.iter().map(label).collect()
}
