//! Many outcomes in one line: shares, quantiles, root mean squares, acceptance, coverage, time.

use super::{Method, Outcome};
use crate::{
    eval::statistics::{quantile, root_mean_square},
    experiment::table::{Cell, Column, row},
};

/// Figures of the outcomes of one method on the scenes of one case. How they are read: see the [module](super).
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Scenes.
    pub scenes: usize,
    /// Share of subjects with the centre within 5 mm.
    pub right: f64,
    /// Share of subjects with the centre off by more than the short semi-axis, or not found.
    pub far: f64,
    /// RMS-c, mm.
    pub rms_c_mm: f64,
    /// RMS-s, mm.
    pub rms_s_mm: f64,
    /// Root mean square of the angle between the long axes, degrees.
    pub axis_rms_deg: f64,
    /// Centre error at the quantiles .5, .9, .99, mm.
    pub centre_mm: [f64; 3],
    /// Angle between the long axes at the quantiles .5, .9, degrees.
    pub axis_deg: [f64; 2],
    /// Share of subjects whose fit was accepted.
    pub accepted: f64,
    /// Accepted detections of all fruit of the scenes.
    pub accepted_detections: usize,
    /// Those of them that are wrong.
    pub wrong_detections: usize,
    /// Those of them that are far.
    pub far_detections: usize,
    /// Share of the accepted fits whose 95 % regions of centre, sizes and long axis hold the truth.
    pub coverage: Option<[f64; 3]>,
    /// Median of the time per detection, microseconds.
    pub time_us: f64,
}

/// Nominal level of the regions whose coverage is stated.
pub const LEVEL: f64 = 0.95;

impl Summary {
    /// Of the outcomes of one method.
    pub fn of(outcomes: &[Outcome]) -> Self {
        let scenes = outcomes.len();
        let share = |count: usize| count as f64 / scenes as f64;
        let counted = |is: &dyn Fn(&&Outcome) -> bool| outcomes.iter().filter(is).count();
        let right: Vec<_> = outcomes.iter().filter_map(Outcome::right).collect();
        let rms = |of: fn(&super::measure::Fit) -> f64| {
            root_mean_square(right.iter().map(|fit| of(fit))).unwrap_or(f64::NAN)
        };
        let quantiles = |of: fn(&Outcome) -> f64| {
            let mut ascending: Vec<f64> = outcomes.iter().map(of).collect();
            ascending.sort_by(f64::total_cmp);
            move |q: f64| quantile(&ascending, q).unwrap_or(f64::NAN)
        };
        let centre = quantiles(Outcome::centre_mm);
        let axis = quantiles(|outcome| outcome.fit.map_or(f64::INFINITY, |fit| fit.axis_deg));
        let time = quantiles(|outcome| outcome.micros / outcome.detections.len().max(1) as f64);
        let detections = || outcomes.iter().flat_map(|outcome| &outcome.detections);
        let accepted = || detections().filter(|judged| judged.is_accepted());
        Self {
            scenes,
            right: share(right.len()),
            far: share(counted(&|outcome| outcome.fit.is_none_or(|fit| fit.is_far))),
            rms_c_mm: rms(|fit| fit.centre_mean_mm),
            rms_s_mm: rms(|fit| fit.size_mean_mm),
            axis_rms_deg: rms(|fit| fit.axis_deg),
            centre_mm: [0.5, 0.9, 0.99].map(centre),
            axis_deg: [0.5, 0.9].map(axis),
            accepted: share(counted(&|outcome| outcome.accepted().is_some())),
            accepted_detections: accepted().count(),
            wrong_detections: accepted().filter(|judged| judged.is_wrong()).count(),
            far_detections: accepted().filter(|judged| judged.is_far).count(),
            coverage: coverage(outcomes, LEVEL),
            time_us: time(0.5),
        }
    }

    /// Share of the accepted detections that are wrong; nothing of nothing.
    pub fn wrong(&self) -> Option<f64> {
        (self.accepted_detections > 0).then(|| self.wrong_detections as f64 / self.accepted_detections as f64)
    }
}

/// Share of the accepted fits whose regions of this nominal level hold the truth; nothing without covariances.
pub fn coverage(outcomes: &[Outcome], level: f64) -> Option<[f64; 3]> {
    let levels: Vec<[f64; 3]> = outcomes.iter().filter_map(|outcome| outcome.accepted()?.levels).collect();
    let held = |block: usize| levels.iter().filter(|l| l[block] <= level).count();
    (!levels.is_empty()).then(|| [0, 1, 2].map(|block| held(block) as f64 / levels.len() as f64))
}

/// Columns of [`cells`].
pub(super) fn columns() -> Vec<Column> {
    vec![
        Column::new("case", "scenes", 0),
        Column::new("method", "method", 0),
        Column::new("scenes", "number", 0),
        Column::new("within_5_mm_percent", "within 5 mm %", 1),
        Column::new("far_percent", "beyond short axis %", 2),
        Column::new("rms_c_mm", "RMS-c mm", 2),
        Column::new("rms_s_mm", "RMS-s mm", 2),
        Column::new("centre_median_mm", "centre median mm", 2),
        Column::new("centre_p90_mm", "90 %", 2),
        Column::new("centre_p99_mm", "99 %", 2),
        Column::new("axis_median_deg", "axis median deg", 1),
        Column::new("axis_p90_deg", "90 %", 1),
        Column::new("axis_rms_deg", "RMS deg", 1),
        Column::new("accepted_percent", "accepted %", 1),
        Column::new("accepted_detections", "accepted in all", 0),
        Column::new("wrong_detections", "wrong", 0),
        Column::new("far_detections", "far", 0),
        Column::new("wrong_percent", "wrong %", 2),
        Column::new("time_us", "time per fruit us", 0),
    ]
}

/// A row.
pub(super) fn cells(case: &str, method: Method, summary: &Summary) -> Vec<Cell> {
    let Summary { centre_mm, axis_deg, .. } = summary;
    row![
        case,
        method.name(),
        summary.scenes,
        100.0 * summary.right,
        100.0 * summary.far,
        summary.rms_c_mm,
        summary.rms_s_mm,
        centre_mm[0],
        centre_mm[1],
        centre_mm[2],
        axis_deg[0],
        axis_deg[1],
        summary.axis_rms_deg,
        100.0 * summary.accepted,
        summary.accepted_detections,
        summary.wrong_detections,
        summary.far_detections,
        summary.wrong().map(|share| 100.0 * share),
        summary.time_us,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::onesided::measure::{Fit, Judged};
    use varsac_core::RefusalCode;

    fn outcome(centre_mm: f64, refusal: Option<RefusalCode>, level: f64) -> Outcome {
        let fit = Fit {
            centre_mm,
            centre_mean_mm: 0.5 * centre_mm,
            size_mean_mm: 0.1 * centre_mm,
            axis_deg: 2.0 * centre_mm,
            is_far: centre_mm > 10.0,
            levels: Some([level, 0.5, 0.99]),
            detection: 0,
        };
        let judged = Judged { error_mm: centre_mm, is_far: fit.is_far, refusal, findings: None };
        let detections = vec![judged];
        Outcome { seed: 1, distance_mm: 700.0, visible: 1.0, fit: Some(fit), detections, micros: 300.0 }
    }

    #[test]
    fn a_summary_by_hand() {
        let nothing = Outcome { fit: None, detections: Vec::new(), ..outcome(0.0, None, 0.0) };
        let all = [
            outcome(1.0, None, 0.2),
            outcome(7.0, None, 0.96),
            outcome(12.0, Some(RefusalCode::Flat), 0.1),
            outcome(5.0, None, 0.95),
            nothing,
        ];
        let summary = Summary::of(&all);
        assert_eq!((summary.scenes, summary.right, summary.far, summary.accepted), (5, 0.4, 0.4, 0.6));
        // Over the two within 5 mm: sqrt((1 + 25) / 2) = 3.6056.
        assert!((summary.rms_c_mm - 0.5 * 13.0_f64.sqrt()).abs() < 1e-12);
        assert!((summary.rms_s_mm - 0.1 * 13.0_f64.sqrt()).abs() < 1e-12);
        assert!((summary.axis_rms_deg - 2.0 * 13.0_f64.sqrt()).abs() < 1e-12);
        // 1, 5, 7, 12, none: what was not found is worse than anything.
        assert_eq!((summary.centre_mm[0], summary.centre_mm[1]), (7.0, f64::INFINITY));
        assert_eq!(
            (summary.accepted_detections, summary.wrong_detections, summary.far_detections),
            (3, 1, 0)
        );
        assert_eq!(summary.wrong(), Some(1.0 / 3.0));
        assert_eq!(summary.coverage, Some([2.0 / 3.0, 1.0, 0.0]));
        assert_eq!(Summary::of(&all[4..]).wrong(), None);
    }
}
