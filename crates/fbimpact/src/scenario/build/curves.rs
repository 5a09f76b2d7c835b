//! Quantities over time.

use adaptive::spec::TimeCurve;
use adaptive::spec::time_curve::{CubicSpline, Piecewise, PiecewiseForm};

use super::super::section::{AtFault, Checked, Section};
use super::super::tables::{CurveKind, Interpolation};

/// Longest polynomial; more terms lose all digits long before the end of a run.
const MAX_COEFFICIENTS: usize = 16;

/// The quantity of key `key`; none if it is not given.
///
/// # Errors
/// [`AtFault`].
pub fn curve(section: &Section, key: &str) -> Result<Option<TimeCurve>, AtFault> {
    section.optional(key, |section, key| match &section.item(key)?.value {
        Checked::Number(value) => Some(TimeCurve::constant(*value)),
        Checked::Table(table) => form(table),
        _ => None,
    })
}

fn form(table: &Section) -> Option<TimeCurve> {
    Some(match table.choice("kind")? {
        CurveKind::Constant => TimeCurve::constant(table.number("value")?),
        CurveKind::Polynomial => {
            let coefficients = table.numbers("coefficients")?.to_vec();
            if coefficients.len() > MAX_COEFFICIENTS {
                let message =
                    format!("{} coefficients, at most {MAX_COEFFICIENTS} make sense", coefficients.len());
                return table.refuse("coefficients", message);
            }
            TimeCurve::Polynomial { coefficients }
        }
        CurveKind::Harmonic => TimeCurve::Harmonic {
            amplitude: table.number("amplitude")?,
            frequency: table.number("frequency")?,
            phase: table.number("phase")?,
            offset: table.number("offset")?,
        },
        CurveKind::SpinUp => {
            TimeCurve::SpinUp { rate: table.number("rate")?, duration: table.number("duration")? }
        }
        CurveKind::Table => points(table)?,
    })
}

fn points(table: &Section) -> Option<TimeCurve> {
    for key in ["times", "values"] {
        if table.item(key).is_none() {
            return table.refuse(key, "required key is missing for kind \"table\" without \"file\"");
        }
    }
    let (times, values) = (table.numbers("times")?.to_vec(), table.numbers("values")?.to_vec());
    if times.len() < 2 {
        return table.refuse("times", "two times are needed at least");
    }
    if let Some(pair) = times.windows(2).find(|w| w[0] >= w[1]) {
        let message = format!("must rise, {:?} is followed by {:?}", pair[0], pair[1]);
        return table.refuse("times", message);
    }
    if times.len() != values.len() {
        let message = format!("{} values, there are {} times", values.len(), times.len());
        return table.refuse("values", message);
    }
    let is_periodic = table.boolean("periodic")?;
    let ends = (values[0], values[values.len() - 1]);
    if is_periodic && ends.0.to_bits() != ends.1.to_bits() {
        let message = format!(
            "must end as they begin where they are periodic, not with {:?} after {:?}",
            ends.1, ends.0
        );
        return table.refuse("values", message);
    }
    let form = match table.choice("interpolation")? {
        Interpolation::Smooth => None,
        Interpolation::Linear => Some(PiecewiseForm::Lines),
        Interpolation::Steps => Some(PiecewiseForm::Steps),
    };
    if let Some(form) = form {
        return Some(TimeCurve::Piecewise(Piecewise { times, values, form, is_periodic }));
    }
    let spline =
        if is_periodic { CubicSpline::periodic(times, values) } else { CubicSpline::new(times, values) };
    let Some(spline) = spline else {
        return table.refuse("values", "no spline goes through the table");
    };
    Some(TimeCurve::Table(spline))
}
