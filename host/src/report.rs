//! What a located input looks like to a program (`--json`, one object a line) and to a person (a table).

use std::fmt::Write as _;

use serde::Serialize;
use varsac_core::Ellipsoid;

use crate::{
    digest::Digest,
    locate::{LearntSize, Located, Refusal, Target},
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
    /// The mean size that was looked for, where it was learnt from the run's own fruit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub learnt_size: Option<LearntSize>,
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
            learnt_size: located.learnt_size,
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

/// "2 targets accepted, 1 refused".
fn counted(located: &Located) -> String {
    let accepted = located.accepted().count();
    let refused = located.targets.len() - accepted;
    let mut text = match accepted {
        0 if refused == 0 => "nothing found".to_owned(),
        0 => "nothing accepted".to_owned(),
        1 => "1 target accepted".to_owned(),
        n => format!("{n} targets accepted"),
    };
    if refused > 0 {
        let _ = write!(text, ", {refused} refused");
    }
    text
}

/// A line of the table. Lengths have the decimals that four digits of the shortest semi-axis need: fruit in millimetres and
/// simulations of unit size alike.
fn line(number: usize, target: &Target) -> String {
    let (c, s, a) = (target.ellipsoid.centre, target.ellipsoid.semi_axes, target.ellipsoid.axes[0]);
    let fine = (3.0 - s[2].log10().floor()).clamp(1.0, 9.0) as usize;
    let coarse = fine.saturating_sub(1);
    let sigma =
        target.covariance.map_or_else(|| "-".to_owned(), |c| format!("{:.fine$}", c.sigma_centre_max_mm()));
    let status = target.refusal.as_ref().map_or_else(|| "accepted".to_owned(), ToString::to_string);
    format!(
        "  {number:>3}  {:>8.coarse$} {:>8.coarse$} {:>8.coarse$} {sigma:>6}  {:>6.fine$} {:>6.fine$} {:>6.fine$}  \
         {:>5.2} {:>5.2} {:>5.2}  {:>4.0}% {:>7}  {status}\n",
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
    )
}

/// The table for a person: a heading line and a line a target.
pub fn table(located: &Located) -> String {
    let mut text = format!(
        "{}: {} in {} points, {:.1} ms ({}, seed {})\n",
        located.input,
        counted(located),
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
        "  {:>3}  {:>8} {:>8} {:>8} {:>6}  {:>6} {:>6} {:>6}  {:>17}  {:>5} {:>7}  status",
        "#", "x mm", "y mm", "z mm", "+- mm", "a mm", "b mm", "c mm", "long axis", "score", "inliers"
    );
    for (k, target) in located.targets.iter().enumerate() {
        text.push_str(&line(k + 1, target));
    }
    text
}
