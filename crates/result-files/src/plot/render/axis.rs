//! From values in SI units to positions on a drawn axis: prefix, offset, divisions.

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use crate::plot::figure::Axis;
use crate::plot::ticks::units::{exponent, prefixed};
use crate::plot::ticks::{self, Tick};

/// Part of the largest value below which the range is shown relative to an offset.
const SMALL_RANGE: f64 = 2e-3;
/// Room above and below curves, as a part of their range.
const ROOM: f64 = 0.06;

/// An axis ready to be drawn, in display coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// Range in display coordinates.
    pub range: (f64, f64),
    /// Divisions in display coordinates.
    pub ticks: Vec<Tick>,
    /// Words along the axis.
    pub label: String,
    is_log: bool,
    offset: f64,
    factor: f64,
}

impl Scale {
    /// The scale of `axis` for `values`, those that are not finite left out, with about `wanted`
    /// divisions.
    pub fn new<'a>(axis: &'a Axis, values: impl Iterator<Item = &'a f64>, wanted: usize) -> Self {
        let finite =
            values.chain(&axis.holds).copied().filter(|v| v.is_finite() && (!axis.is_log || *v > 0.0));
        let extremes = finite.fold(None, |range: Option<(f64, f64)>, v| match range {
            None => Some((v, v)),
            Some((a, b)) => Some((a.min(v), b.max(v))),
        });
        if axis.is_log {
            Self::logarithmic(axis, extremes, wanted)
        } else {
            Self::linear(axis, extremes, wanted)
        }
    }

    fn logarithmic(axis: &Axis, extremes: Option<(f64, f64)>, wanted: usize) -> Self {
        let (low, high) = axis.range.or(extremes).unwrap_or((1.0, 10.0));
        let (low, high) = (low.log10(), high.log10());
        let room = (ROOM * (high - low)).max(0.15);
        let range = (low - room, high + room);
        let label = label(&axis.quantity, &axis.unit);
        let ticks = ticks::logarithmic(range.0, range.1, wanted);
        Self { range, ticks, label, is_log: true, offset: 0.0, factor: 1.0 }
    }

    fn linear(axis: &Axis, extremes: Option<(f64, f64)>, wanted: usize) -> Self {
        let (low, high) = axis.range.unwrap_or_else(|| padded(extremes.unwrap_or((0.0, 1.0))));
        let largest = low.abs().max(high.abs());
        let offset = if high - low < SMALL_RANGE * largest { offset(low, high) } else { 0.0 };
        let shifted = (low - offset).abs().max((high - offset).abs());
        let power = exponent(shifted, &axis.unit);
        let factor = 10f64.powi(-power);
        let range = ((low - offset) * factor, (high - offset) * factor);
        let ticks = axis.ticks.clone().unwrap_or_else(|| ticks::linear(range.0, range.1, wanted));
        let unit = prefixed(&axis.unit, power);
        let quantity = if offset == 0.0 {
            axis.quantity.clone()
        } else {
            format!("{} {}", axis.quantity, shift(offset, &axis.unit))
        };
        Self { range, ticks, label: label(&quantity, &unit), is_log: false, offset, factor }
    }

    /// Keeps every so many-th division, so that no more than about `wanted` are left.
    pub fn keep_some(&mut self, wanted: usize) {
        let every = self.ticks.len().div_ceil(wanted.max(1));
        self.ticks = std::mem::take(&mut self.ticks).into_iter().step_by(every).collect();
    }

    /// Display coordinate of a value; `None` where there is none.
    pub fn at(&self, value: f64) -> Option<f64> {
        let position = if self.is_log { value.log10() } else { (value - self.offset) * self.factor };
        position.is_finite().then_some(position)
    }

    /// Display length of a difference of values on a linear axis.
    pub fn length(&self, difference: f64) -> f64 {
        difference * self.factor
    }

    /// Label of the division at `position`.
    fn tick_label(&self, position: f64) -> String {
        let near = self.ticks.iter().min_by(|a, b| (a.0 - position).abs().total_cmp(&(b.0 - position).abs()));
        near.map_or_else(String::new, |(_, label)| label.clone())
    }
}

/// The drawing library sees display coordinates only, and divisions that are chosen already.
impl Ranged for Scale {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first, last): (i32, i32)) -> i32 {
        let part = (value - self.range.0) / (self.range.1 - self.range.0);
        first + (part.clamp(0.0, 1.0) * f64::from(last - first)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _hint: Hint) -> Vec<f64> {
        self.ticks.iter().map(|tick| tick.0).collect()
    }

    fn range(&self) -> std::ops::Range<f64> {
        self.range.0..self.range.1
    }
}

impl ValueFormatter<f64> for Scale {
    fn format(value: &f64) -> String {
        value.to_string()
    }

    fn format_ext(&self, value: &f64) -> String {
        self.tick_label(*value)
    }
}

fn label(quantity: &str, unit: &str) -> String {
    if unit.is_empty() { quantity.to_owned() } else { format!("{quantity} [{unit}]") }
}

/// Range with room; a single value gets room by its size.
fn padded((low, high): (f64, f64)) -> (f64, f64) {
    let spread = high - low;
    // Below 1e-12 of the value it is round-off.
    let room = if spread > 1e-12 * low.abs().max(high.abs()) {
        ROOM * spread
    } else {
        (0.5 * high.abs()).max(1e-12)
    };
    (low - room, high + room)
}

/// A round value near the middle of a short range far from zero.
#[expect(clippy::float_cmp, reason = "an empty range has no digits")]
fn offset(low: f64, high: f64) -> f64 {
    if low == high {
        return 0.0;
    }
    let digit = 10f64.powf((high - low).log10().ceil());
    (0.5 * (low + high) / digit).round() * digit
}

/// ` − 1.01 m`: what has been taken off.
fn shift(offset: f64, unit: &str) -> String {
    let power = exponent(offset.abs(), unit);
    let digits = format!("{:.9}", offset.abs() * 10f64.powi(-power));
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    let sign = if offset < 0.0 { "+" } else { "−" };
    format!("{sign} {digits} {}", prefixed(unit, power))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axis_carries_prefix_and_unit() {
        let scale = Scale::new(&Axis::new("force", "N"), [0.0, 5200.0].iter(), 5);
        assert_eq!(scale.label, "force [kN]");
        assert_eq!(scale.at(1000.0), Some(1.0));
        assert!(scale.range.0 < 0.0 && scale.range.1 > 5.2);
    }

    #[test]
    fn short_range_far_from_zero_is_shown_relative_to_a_round_value() {
        let scale = Scale::new(&Axis::new("z", "m"), [1.010_001, 1.010_003].iter(), 5);
        assert_eq!(scale.label, "z − 1.01 m [µm]");
        let shown = scale.at(1.010_001).expect("finite");
        // Round-off of one metre against a micrometre.
        assert!((shown - 1.0).abs() < 1e-8);
    }

    #[test]
    fn values_without_a_place_are_left_out() {
        let log = Axis { is_log: true, ..Axis::new("penalty factor", "N/m³") };
        let scale = Scale::new(&log, [0.0, f64::INFINITY, 1e15, 1e18].iter(), 5);
        assert_eq!(scale.at(0.0), None);
        assert!(scale.range.0 > 14.0 && scale.range.1 < 19.0);
        let empty = Scale::new(&Axis::new("force", "N"), [f64::NAN].iter(), 5);
        assert!(empty.range.1 > empty.range.0);
        let constant = Scale::new(&Axis::new("force", "N"), [3.0, 3.0].iter(), 5);
        assert!(constant.range.0 < 3.0 && constant.range.1 > 3.0 && !constant.ticks.is_empty());
    }
}
