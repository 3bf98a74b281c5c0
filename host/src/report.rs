//! What a located input looks like to a program (`--json`, one object a line) and to a person (a table).

use std::fmt::Write as _;

use serde::Serialize;
use varsac_core::Ellipsoid;

use crate::{
    digest::Digest,
    locate::{Located, Refusal, Target},
};

/// The JSON object of one input.
#[derive(Debug, Serialize)]
pub struct InputReport<'a> {
    /// The input as named on the command line.
    pub input: &'a str,
    /// Name of the frame or cloud.
    pub frame_id: &'a str,
    /// Search method.
    pub method: &'a str,
    /// Seed of the random stream.
    pub seed: u64,
    /// Points that were searched.
    pub points: usize,
    /// Wall time of segmentation, back-projection and search, without reading and drawing.
    pub elapsed_ms: f64,
    /// Targets in the order found, region by region.
    pub detections: Vec<DetectionReport>,
}

/// One target.
#[derive(Debug, Serialize)]
pub struct DetectionReport {
    /// `accepted` or `refused`.
    pub status: &'static str,
    /// Why, when refused.
    pub refusal: Option<Refusal>,
    /// Camera optical frame.
    pub centre_mm: [f32; 3],
    /// Longest first.
    pub semi_axes_mm: [f32; 3],
    /// Rows are the unit vectors of the semi-axes.
    pub axes: [[f32; 3]; 3],
    /// The attitude.
    pub quaternion_xyzw: [f32; 4],
    /// Angles about x, y, z of the intrinsic Z-Y-X sequence.
    pub attitude_rad: [f32; 3],
    /// `inliers / candidates`.
    pub score: f32,
    /// Points on the surface.
    pub inliers: u32,
    /// Points that were still unclaimed.
    pub candidates: u32,
    /// Trials of the search.
    pub trials: u32,
    /// One standard deviation of the centre along x, y, z; null where the method has no uncertainty.
    pub sigma_centre_mm: Option<[f32; 3]>,
    /// Of centre (mm), semi-axes (mm) and attitude (rad); null where the method has no uncertainty.
    pub covariance: Option<Vec<[f32; 9]>>,
    /// Fingerprint of the f32 bits of centre, semi-axes and axes.
    pub bits: String,
}

impl<'a> InputReport<'a> {
    /// The report of `located`.
    pub fn new(located: &'a Located) -> Self {
        Self {
            input: &located.input,
            frame_id: &located.name,
            method: located.method.name(),
            seed: located.seed,
            points: located.points.len(),
            elapsed_ms: (located.elapsed.as_secs_f64() * 1e5).round() / 100.0,
            detections: located.targets.iter().map(DetectionReport::new).collect(),
        }
    }
}

impl DetectionReport {
    fn new(target: &Target) -> Self {
        let e = &target.ellipsoid;
        Self {
            status: if target.refusal.is_some() { "refused" } else { "accepted" },
            refusal: target.refusal,
            centre_mm: [e.centre.x, e.centre.y, e.centre.z],
            semi_axes_mm: e.semi_axes,
            axes: e.axes,
            quaternion_xyzw: e.quaternion_xyzw(),
            attitude_rad: e.attitude_rad(),
            score: target.score.ratio(),
            inliers: target.score.inliers,
            candidates: target.score.candidates,
            trials: target.trials,
            sigma_centre_mm: target.covariance.map(|c| c.sigma_centre_mm()),
            covariance: target.covariance.map(|c| c.rows().to_vec()),
            bits: bits(e).to_string(),
        }
    }
}

/// Fingerprint of an ellipsoid: centre, semi-axes, axes.
pub fn bits(ellipsoid: &Ellipsoid) -> Digest {
    let mut digest = Digest::default();
    let c = ellipsoid.centre;
    digest.floats(&[c.x, c.y, c.z]);
    digest.floats(&ellipsoid.semi_axes);
    for axis in &ellipsoid.axes {
        digest.floats(axis);
    }
    digest
}

/// The table for a person: a heading line and a line a target.
pub fn table(located: &Located) -> String {
    let mut text = format!(
        "{}: {} in {} points, {:.1} ms ({}, seed {})\n",
        located.input,
        match located.targets.len() {
            0 => "nothing found".to_owned(),
            1 => "1 target".to_owned(),
            n => format!("{n} targets"),
        },
        located.points.len(),
        located.elapsed.as_secs_f64() * 1e3,
        located.method.name(),
        located.seed,
    );
    for note in &located.notes {
        let _ = writeln!(text, "  note: {note}");
    }
    if located.targets.is_empty() {
        return text;
    }
    let _ = writeln!(
        text,
        "  {:>3}  {:>8} {:>8} {:>8}  {:>6} {:>6} {:>6}  {:>17}  {:>5} {:>7}  status",
        "#", "x mm", "y mm", "z mm", "a mm", "b mm", "c mm", "long axis", "score", "inliers"
    );
    for (k, target) in located.targets.iter().enumerate() {
        let (c, s, a) = (target.ellipsoid.centre, target.ellipsoid.semi_axes, target.ellipsoid.axes[0]);
        let status = target.refusal.as_ref().map_or_else(|| "accepted".to_owned(), ToString::to_string);
        let _ = writeln!(
            text,
            "  {:>3}  {:>8.1} {:>8.1} {:>8.1}  {:>6.2} {:>6.2} {:>6.2}  {:>5.2} {:>5.2} {:>5.2}  {:>4.0}% {:>7}  {status}",
            k + 1,
            c.x,
            c.y,
            c.z,
            s[0],
            s[1],
            s[2],
            a[0],
            a[1],
            a[2],
            100.0 * target.score.ratio(),
            target.score.inliers
        );
    }
    text
}
