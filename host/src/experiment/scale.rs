//! An axis of a chart: its ends, its ticks and what is written at them.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::figure::{Axis, Chart, Mark, Series};

/// Most steps between ticks on an axis.
const TICKS: f64 = 8.0;

/// An axis with its ends and ticks, in the logarithm if it is logarithmic.
#[derive(Debug, Clone)]
pub(super) struct Scale {
    logarithmic: bool,
    pub(super) low: f64,
    high: f64,
    ticks: Vec<f64>,
    decimals: usize,
}

impl Scale {
    /// Coordinate `which` of the chart's series, along `axis`.
    pub(super) fn new(axis: &Axis, chart: &Chart, which: usize) -> Self {
        let mut scale =
            Self { logarithmic: axis.logarithmic, low: 0.0, high: 1.0, ticks: Vec::new(), decimals: 0 };
        let places = |values: &mut dyn Iterator<Item = f64>| {
            let ends = (f64::INFINITY, f64::NEG_INFINITY);
            values.filter_map(|v| scale.place(v)).fold(ends, |(low, high), v| (low.min(v), high.max(v)))
        };
        let (low, high) = match axis.range {
            Some([low, high]) => places(&mut [low, high].into_iter()),
            None => places(&mut chart.series.iter().flat_map(|series| reach(series, which))),
        };
        if low <= high {
            // A twentieth of room, but none below a zero that is an end.
            let room = if axis.range.is_some() { 0.0 } else { (high - low) * 0.05 };
            let flat = if high > low { 0.0 } else { 0.5 };
            let below = if low == 0.0 && !axis.logarithmic { 0.0 } else { room + flat };
            (scale.low, scale.high) = (low - below, high + room + flat);
        }
        scale.set_ticks();
        scale
    }

    fn set_ticks(&mut self) {
        let step = nice_step((self.high - self.low) / TICKS);
        if self.logarithmic && step < 1.0 && self.high - self.low < 3.0 {
            // Few decades: 1, 2 and 5 of each.
            let decades = self.low.floor() as i32..=self.high.ceil() as i32;
            let all = decades.flat_map(|d| [1.0, 2.0, 5.0].map(|m: f64| f64::from(d) + m.log10()));
            self.ticks = all.filter(|&t| self.holds(t)).collect();
            return;
        }
        let step = if self.logarithmic { step.max(1.0).round() } else { step };
        let (first, last) =
            ((self.low / step - 1e-9).ceil() as i64, (self.high / step + 1e-9).floor() as i64);
        self.ticks = (first..=last).map(|k| k as f64 * step).collect();
        self.decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    }

    /// Where a value lies; nothing for what cannot be shown.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        let place = if self.logarithmic { value.log10() } else { value };
        place.is_finite().then_some(place)
    }

    pub(super) fn holds(&self, place: f64) -> bool {
        place >= self.low - 1e-9 && place <= self.high + 1e-9
    }

    fn label(&self, place: f64) -> String {
        if !self.logarithmic {
            return format!("{place:.*}", self.decimals);
        }
        let value = 10_f64.powf(place);
        if (1e-4..1e6).contains(&value) {
            let decimals = (-place.floor()).clamp(0.0, 6.0) as usize;
            format!("{value:.decimals$}")
        } else {
            format!("1e{place:.0}")
        }
    }
}

impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, (from, to): (i32, i32)) -> i32 {
        let share = (place - self.low) / (self.high - self.low);
        from + (share * f64::from(to - from)).round() as i32
    }

    /// The ticks; there are no lighter ones in between.
    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Scale {
    fn format(place: &f64) -> String {
        place.to_string()
    }

    fn format_ext(&self, place: &f64) -> String {
        self.label(*place)
    }
}

/// What a series needs of an axis: bars stand on 0 and have a width.
fn reach(series: &Series, which: usize) -> Vec<f64> {
    let values = series.points.iter().map(|p| p[which]);
    match (series.mark, which) {
        (Mark::Bars(width), 0) => values.flat_map(|v| [v - width / 2.0, v + width / 2.0]).collect(),
        (Mark::Bars(_), _) => values.chain([0.0]).collect(),
        _ => values.collect(),
    }
}

/// The least of 1, 2 and 5 times a power of ten that is not below `least`.
fn nice_step(least: f64) -> f64 {
    let power = 10_f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0]
        .into_iter()
        .map(|m| m * power)
        .find(|step| *step >= least * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(x: Axis, points: Vec<[f64; 2]>) -> Chart {
        let series = vec![Series::new("one", Mark::Line, 0, points)];
        Chart { title: "title".into(), x, y: Axis::linear("up"), series }
    }

    #[test]
    fn ticks_are_round_and_inside() {
        let chart = chart(Axis::linear("right"), vec![[0.0, -3.0], [17.0, 4.0]]);
        let x = Scale::new(&chart.x, &chart, 0);
        assert_eq!(x.ticks, [0.0, 5.0, 10.0, 15.0]);
        assert_eq!(x.label(5.0), "5");
        let y = Scale::new(&chart.y, &chart, 1);
        assert!(y.low < -3.0 && y.high > 4.0 && y.ticks == [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0, 4.0]);
    }

    #[test]
    fn logarithmic_axes_leave_out_what_has_no_logarithm() {
        let chart =
            chart(Axis::logarithmic("right"), vec![[0.0, 1.0], [0.1, 1.0], [100.0, 2.0], [f64::NAN, 1.0]]);
        let x = Scale::new(&chart.x, &chart, 0);
        assert!((x.low + 1.15).abs() < 1e-12 && (x.high - 2.15).abs() < 1e-12);
        assert_eq!(x.place(0.0), None);
        let labels: Vec<String> = x.ticks.iter().map(|&t| x.label(t)).collect();
        assert_eq!(labels, ["0.1", "1", "10", "100"]);
    }
}
