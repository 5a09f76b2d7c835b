//! Quantities over time: the forms that a drive, a prescribed motion or a load can have.

use super::super::keys::{Condition, Key, Kind, Named, Range, Test, name_values, name_variants};

/// Values; far beyond any force in N or angle in rad.
pub(super) const VALUE: Range = Range::within(1e12);
/// Times \[s\].
const TIME: Range = Range::within(1e6);

/// A key for a quantity over time.
pub(super) const fn curve(name: &'static str, unit: &'static str, doc: &'static str) -> Key {
    let kind = Kind::NumberOrVariants { range: VALUE, tag: "kind", variants: CurveKind::VARIANTS };
    Key::measured(name, kind, unit).otherwise("none").doc(doc)
}

/// Numbers stand in the scenario.
const WITHOUT_FILE: Condition = Condition::new("without `file`", Test::Without("file"));
/// Numbers stand in a file.
const WITH_FILE: Condition = Condition::new("with `file`", Test::With("file"));

/// What runs through the points of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// A cubic spline.
    Smooth,
    /// Lines.
    Linear,
    /// Each value until the next.
    Steps,
}

name_values!(Interpolation {
    Smooth: "smooth", "cubic spline", elsewhere ["spline", "cubic"];
    Linear: "linear", "lines; for forces, not for prescribed motions, whose velocity would jump", elsewhere ["lines", "polyline", "piecewise-linear"];
    Steps: "steps", "each value lasts until the next time; for forces, not for prescribed motions", elsewhere ["step", "constant", "hold", "previous", "zoh"];
});

/// Forms of a quantity over time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CurveKind {
    /// The same at all times.
    Constant,
    /// Polynomial.
    Polynomial,
    /// Sine.
    Harmonic,
    /// From rest to a constant rate.
    SpinUp,
    /// Through points.
    Table,
}

name_variants!(CurveKind {
    Constant: "constant", "The same at all times.",
        elsewhere ["const"],
        keys &[Key::measured("value", Kind::Number(VALUE), "U").doc("Value.")];
    Polynomial: "polynomial", "`c₀ + c₁ t + c₂ t² + …`.",
        elsewhere ["linear", "quadratic"],
        keys &[Key::measured("coefficients", Kind::Numbers(VALUE), "U/s^k")
            .doc("Coefficients, the constant first; at most 16.")];
    Harmonic: "harmonic", "`offset + amplitude sin(2π frequency t + phase)`.",
        elsewhere ["sine", "sin", "cosine", "sinusoidal", "periodic"],
        keys &[
            Key::measured("amplitude", Kind::Number(VALUE), "U").doc("Amplitude."),
            Key::measured("frequency", Kind::Number(Range::closed(0.0, 1e9)), "Hz")
                .doc("Frequency."),
            Key::angle("phase", Kind::Number(Range::within(1e6)), "rad")
                .default("0.0")
                .doc("Phase at time zero."),
            Key::measured("offset", Kind::Number(VALUE), "U").default("0.0").doc("Mean value."),
        ];
    SpinUp: "spin-up", "From rest to a constant rate, reached smoothly: \
              `rate/T (t²/2 + (T/2π)² (cos(2πt/T) - 1))` up to `T = duration`, then `rate (t - T/2)`.",
        elsewhere ["ramp", "smooth-step", "smoothstep"],
        keys &[
            Key::measured("rate", Kind::Number(VALUE), "U/s").doc("Final rate."),
            Key::measured("duration", Kind::Number(Range::positive(1e6)), "s")
                .doc("Time at which it is reached."),
        ];
    Table: "table", "Through points: a natural cubic spline, which goes on with a constant rate outside them, or a periodic one; or lines or steps, \
              which keep their value outside.",
        elsewhere ["tabular", "curve", "points", "interpolation", "pwl"],
        keys &[
            Key::measured("times", Kind::Numbers(TIME), "s")
                .otherwise("`file` must be given")
                .doc("Rising times, two at least.")
                .when(&[WITHOUT_FILE]),
            Key::measured("values", Kind::Numbers(VALUE), "U")
                .otherwise("`file` must be given")
                .doc("Values, one a time.")
                .when(&[WITHOUT_FILE]),
            Key::new("file", Kind::Name)
                .otherwise("`times` and `values` must be given")
                .doc("Text file with columns of numbers between commas, semicolons, tabs or blanks, relative to the scenario. A line may name them, with their units, \
                 `t [ms]`, `F (kN)`, `F / kN`, `F in kN` or `F_kN`, and a line below it hold units; a unit that is unknown is refused. Numbers may have commas for points where no commas stand between them. \
                 Lines that begin with `#` count for nothing, other lines above the names are refused. The resolved scenario of a result holds the numbers."),
            Key::new("time_column", Kind::Name)
                .otherwise("the first column")
                .doc("Column of the times, in s unless its name ends with another unit, by its name or by its number from 1 as a text, `\"2\"`.")
                .when(&[WITH_FILE]),
            Key::new("value_column", Kind::Name)
                .otherwise("the second column")
                .doc("Column of the values, in the unit of the key unless its name ends with another one, as `time_column`.")
                .when(&[WITH_FILE]),
            Key::new("interpolation", Kind::Choice(Interpolation::CHOICES))
                .default("\"smooth\"")
                .doc("What runs through the points. Steps of the integration end at points where it is not smooth."),
            Key::new("periodic", Kind::Boolean)
                .default("false")
                .doc("Whether the values repeat with the time from the first to the last one, which must have the same value."),
        ];
});
