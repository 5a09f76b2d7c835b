//! Functions of expressions.

use super::value::Value;

/// A function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// Smallest over rows.
    Min,
    /// Largest over rows.
    Max,
    /// Mean over rows.
    Mean,
    /// Sum over rows.
    Sum,
    /// Root of the mean square over rows.
    Rms,
    /// Number of rows.
    Count,
    /// Length over components.
    Norm,
    /// Magnitude.
    Abs,
    /// Square root.
    Sqrt,
    /// Sine of an angle \[rad\].
    Sin,
    /// Cosine of an angle \[rad\].
    Cos,
    /// Angle of the vector (second, first) \[rad\].
    Atan2,
    /// Integral over time.
    Integral,
    /// Derivative over time.
    Derivative,
    /// Value at a time, linear between instants.
    At,
    /// Time of the largest value.
    TimeOfMax,
    /// Time of the smallest value.
    TimeOfMin,
}

/// Name, number of arguments and meaning of each.
const TABLE: [(Function, &str, usize, &str); 17] = [
    (
        Function::Min,
        "min",
        1,
        "smallest over rows, a component at a time; of a single row over its components",
    ),
    (Function::Max, "max", 1, "largest, likewise"),
    (Function::Mean, "mean", 1, "mean over rows, each counted once"),
    (Function::Sum, "sum", 1, "sum over rows"),
    (Function::Rms, "rms", 1, "root of the mean square over rows"),
    (Function::Count, "count", 1, "number of rows"),
    (Function::Norm, "norm", 1, "length of each row"),
    (Function::Abs, "abs", 1, "magnitude of each number"),
    (Function::Sqrt, "sqrt", 1, "square root"),
    (Function::Sin, "sin", 1, "sine of radians"),
    (Function::Cos, "cos", 1, "cosine of radians"),
    (Function::Atan2, "atan2", 2, "`atan2(y, x)`: angle of (x, y) in radians"),
    (Function::Integral, "integral", 1, "integral over time, by the trapezoidal rule"),
    (
        Function::Derivative,
        "derivative",
        1,
        "derivative over time: slope from the instant before to the one after, at the ends from or to the end; `derivative(points.tip.velocity)` is an acceleration",
    ),
    (Function::At, "at", 2, "`at(x, t)`: x at the time t in seconds, linear between instants"),
    (Function::TimeOfMax, "time_of_max", 1, "time of the largest value of a series"),
    (Function::TimeOfMin, "time_of_min", 1, "time of the smallest value of a series"),
];

impl Function {
    /// All functions.
    pub const ALL: [Self; TABLE.len()] = {
        let mut all = [Self::Min; TABLE.len()];
        let mut i = 0;
        while i < all.len() {
            all[i] = TABLE[i].0;
            i += 1;
        }
        all
    };

    /// The function called `name`.
    pub fn find(name: &str) -> Option<Self> {
        TABLE.iter().find(|(_, known, _, _)| *known == name).map(|(function, ..)| *function)
    }

    fn row(self) -> &'static (Self, &'static str, usize, &'static str) {
        &TABLE[self as usize]
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.row().1
    }

    /// Number of values that it takes.
    pub fn n_arguments(self) -> usize {
        self.row().2
    }

    /// What it is, for the reference.
    pub fn meaning(self) -> &'static str {
        self.row().3
    }

    /// Its value; `time` are the stored instants \[s\].
    ///
    /// # Errors
    /// What does not fit, a fragment.
    pub fn apply(self, values: &[Value], time: &[f64]) -> Result<Value, String> {
        let [x, ..] = values else { return Err("takes a value".into()) };
        match self {
            Self::Min => x.reduced(self.name(), |v| v.fold(f64::NAN, f64::min)),
            Self::Max => x.reduced(self.name(), |v| v.fold(f64::NAN, f64::max)),
            Self::Sum => x.reduced(self.name(), f64_sum),
            Self::Mean => x.reduced(self.name(), mean),
            Self::Rms => x.reduced(self.name(), |v| mean(&mut v.map(|x| x * x)).sqrt()),
            Self::Count => Ok(Value::number(x.rows.unwrap_or(1) as f64, "–")),
            Self::Norm => x.norm(),
            Self::Abs => Ok(x.mapped(&x.unit, f64::abs)),
            Self::Sqrt => Ok(x.mapped("", f64::sqrt)),
            Self::Sin => Ok(x.mapped("–", f64::sin)),
            Self::Cos => Ok(x.mapped("–", f64::cos)),
            Self::Atan2 => x.with(&values[1], "rad", f64::atan2),
            Self::Integral => {
                let width = self.over_time(x, time)?;
                let component = |c: usize| {
                    let at = |i: usize| x.data[i * width + c];
                    (1..time.len()).map(|i| 0.5 * (time[i] - time[i - 1]) * (at(i) + at(i - 1))).sum()
                };
                Ok(x.row((0..width).map(component).collect(), ""))
            }
            Self::Derivative => {
                let width = self.over_time(x, time)?;
                let last = time.len() - 1;
                let slope = |i: usize, c: usize| {
                    let (a, b) = (i.saturating_sub(1), (i + 1).min(last));
                    (x.data[b * width + c] - x.data[a * width + c]) / (time[b] - time[a])
                };
                let data = (0..=last)
                    .flat_map(|i| (0..width).map(move |c| (i, c)))
                    .map(|(i, c)| slope(i, c))
                    .collect();
                let unit = match x.unit.as_str() {
                    "m" => "m/s",
                    "m/s" => "m/s²",
                    "rad" => "rad/s",
                    "rad/s" => "rad/s²",
                    _ => "",
                };
                Ok(Value { data, unit: unit.to_owned(), ..x.clone() })
            }
            Self::At => {
                let width = self.over_time(x, time)?;
                let t = values[1].single().ok_or("the time must be a single number")?;
                let (first, last) = (time[0], time[time.len() - 1]);
                if !(first..=last).contains(&t) {
                    return Err(format!(
                        "no instant is stored at {t:e} s, the result holds {first:e} s to {last:e} s"
                    ));
                }
                let after =
                    time.partition_point(|x| *x < t).clamp(1, time.len().max(2) - 1).min(time.len() - 1);
                let before = after.saturating_sub(1);
                let step = time[after] - time[before];
                let s = if step > 0.0 { (t - time[before]) / step } else { 1.0 };
                let value = |c: usize| (1.0 - s) * x.data[before * width + c] + s * x.data[after * width + c];
                Ok(x.row((0..width).map(value).collect(), &x.unit))
            }
            Self::TimeOfMax => self.time_of(x, time, |new, old| new > old),
            Self::TimeOfMin => self.time_of(x, time, |new, old| new < old),
        }
    }

    /// Numbers in a row of `x`, which must have a row a stored instant.
    fn over_time(self, x: &Value, time: &[f64]) -> Result<usize, String> {
        if !x.is_over_time || x.rows != Some(time.len()) {
            return Err(format!(
                "{} needs a row for every stored instant, this is {}",
                self.name(),
                x.shown()
            ));
        }
        if time.is_empty() {
            return Err("there is no stored instant".into());
        }
        Ok(x.width.unwrap_or(1))
    }

    fn time_of(self, x: &Value, time: &[f64], is_better: fn(f64, f64) -> bool) -> Result<Value, String> {
        if self.over_time(x, time)? != 1 {
            return Err(format!(
                "{} needs one number per row, this is {}; name a component",
                self.name(),
                x.shown()
            ));
        }
        let mut best: Option<usize> = None;
        for (i, value) in x.data.iter().enumerate().filter(|(_, v)| !v.is_nan()) {
            if best.is_none_or(|b| is_better(*value, x.data[b])) {
                best = Some(i);
            }
        }
        best.map(|i| Value::number(time[i], "s")).ok_or_else(|| "all values are no numbers".into())
    }
}

/// The functions as a table in Markdown.
pub fn markdown() -> String {
    let row = |f: &Function| format!("| `{}` | {} |\n", f.name(), f.meaning());
    format!("| function | value |\n|---|---|\n{}", Function::ALL.iter().map(row).collect::<String>())
}

fn f64_sum(values: &mut dyn Iterator<Item = f64>) -> f64 {
    values.sum()
}

fn mean(values: &mut dyn Iterator<Item = f64>) -> f64 {
    let (n, sum) = values.fold((0.0, 0.0), |(n, sum), x| (n + 1.0, sum + x));
    sum / n
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(data: &[f64], width: Option<usize>) -> Value {
        let rows = Some(data.len() / width.unwrap_or(1));
        Value { data: data.to_vec(), rows, width, is_over_time: true, ..Value::number(0.0, "m") }
    }

    #[test]
    fn every_function_has_its_row() {
        for function in Function::ALL {
            assert_eq!(Function::find(function.name()), Some(function));
            assert_eq!(TABLE[function as usize].0, function);
        }
    }

    #[test]
    fn functions_have_their_values() {
        let time = [0.0, 1.0, 3.0];
        let x = series(&[1.0, 4.0, -2.0], None);
        let v = series(&[3.0, 4.0, 0.0, 1.0, -6.0, 8.0], Some(2));
        let of = |f: Function, values: &[Value]| f.apply(values, &time).expect("a value").data;
        let number = |x| Value::number(x, "");
        for (function, expected) in [
            (Function::Min, -2.0),
            (Function::Max, 4.0),
            (Function::Mean, 1.0),
            (Function::Sum, 3.0),
            (Function::Rms, 7.0_f64.sqrt()),
            (Function::Count, 3.0),
            // 2.5 over the first second, 1 over the next two.
            (Function::Integral, 4.5),
            (Function::TimeOfMax, 1.0),
            (Function::TimeOfMin, 3.0),
        ] {
            let found = of(function, std::slice::from_ref(&x));
            assert!(
                found.len() == 1 && (found[0] - expected).abs() < 1e-15,
                "{}: {found:?}",
                function.name()
            );
        }
        assert_eq!(of(Function::Derivative, std::slice::from_ref(&x)), [3.0, -1.0, -3.0]);
        assert_eq!(of(Function::Derivative, std::slice::from_ref(&v))[2..4], [-3.0, 4.0 / 3.0]);
        assert_eq!(of(Function::At, &[x.clone(), number(2.0)]), [1.0]);
        assert_eq!(of(Function::At, &[x.clone(), number(0.0)]), [1.0]);
        assert_eq!(of(Function::At, &[x.clone(), number(3.0)]), [-2.0]);
        assert_eq!(of(Function::At, &[v.clone(), number(0.5)]), [1.5, 2.5]);
        assert_eq!(of(Function::Norm, std::slice::from_ref(&v)), [5.0, 1.0, 10.0]);
        assert_eq!(of(Function::Max, std::slice::from_ref(&v)), [3.0, 8.0]);
        assert_eq!(of(Function::Max, &[v.index(2).expect("a row")]), [8.0]);
        assert_eq!(of(Function::Atan2, &[number(1.0), number(0.0)]), [std::f64::consts::FRAC_PI_2]);
        // What is no number counts only where there is nothing else.
        assert_eq!(of(Function::Max, &[series(&[f64::NAN, 2.0, 1.0], None)]), [2.0]);
    }

    #[test]
    fn what_does_not_fit_is_told() {
        let time = [0.0, 1.0, 3.0];
        let table = Value { is_over_time: false, ..series(&[1.0, 2.0], None) };
        for (function, values, words) in [
            (Function::Integral, vec![table.clone()], "every stored instant"),
            (Function::TimeOfMax, vec![series(&[1.0; 6], Some(2))], "name a component"),
            (Function::At, vec![series(&[1.0; 3], None), Value::number(4.0, "")], "0e0 s to 3e0 s"),
            (Function::At, vec![series(&[1.0; 3], None), table], "single number"),
            (Function::Norm, vec![Value::number(1.0, "")], "abs"),
            (Function::Max, vec![series(&[], None)], "series of 0"),
        ] {
            let reason = function.apply(&values, &time).expect_err("a reason");
            assert!(reason.contains(words), "{reason}");
        }
    }
}
