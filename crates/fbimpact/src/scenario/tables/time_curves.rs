//! Quantities over time: the forms that a drive, a prescribed motion or a load can have.

use super::super::keys::{Bound, Key, Kind, Need, Range, Variant};

/// Values; far beyond any force in N or angle in rad.
pub(super) const VALUE: Range = Range::within(1e12);
/// Times \[s\].
const TIME: Range = Range::within(1e6);

/// A key for a quantity over time.
pub(super) const fn curve(name: &'static str, unit: &'static str, doc: &'static str) -> Key {
    let kind = Kind::NumberOrVariants { range: VALUE, tag: "kind", variants: CURVES };
    Key::new(name, kind, unit, Need::Optional("none"), doc)
}

/// Forms of a quantity over time.
pub const CURVES: &[Variant] = &[
    Variant {
        name: "constant",
        doc: "The same at all times.",
        keys: &[Key::new("value", Kind::Number(VALUE), "U", Need::Required, "Value.")],
    },
    Variant {
        name: "polynomial",
        doc: "`c₀ + c₁ t + c₂ t² + …`.",
        keys: &[Key::new(
            "coefficients",
            Kind::Numbers(VALUE),
            "U/s^k",
            Need::Required,
            "Coefficients, the constant first; at most 16.",
        )],
    },
    Variant {
        name: "harmonic",
        doc: "`offset + amplitude sin(2π frequency t + phase)`.",
        keys: &[
            Key::new("amplitude", Kind::Number(VALUE), "U", Need::Required, "Amplitude."),
            Key::new(
                "frequency",
                Kind::Number(Range { min: Bound::Closed(0.0), max: Bound::Closed(1e9) }),
                "Hz",
                Need::Required,
                "Frequency.",
            ),
            Key::angle(
                "phase",
                Kind::Number(Range::within(1e6)),
                "rad",
                Need::Default("0.0"),
                "Phase at time zero.",
            ),
            Key::new("offset", Kind::Number(VALUE), "U", Need::Default("0.0"), "Mean value."),
        ],
    },
    Variant {
        name: "spin-up",
        doc: "From rest to a constant rate, reached smoothly: \
              `rate/T (t²/2 + (T/2π)² (cos(2πt/T) - 1))` up to `T = duration`, then `rate (t - T/2)`.",
        keys: &[
            Key::new("rate", Kind::Number(VALUE), "U/s", Need::Required, "Final rate."),
            Key::new(
                "duration",
                Kind::Number(Range::positive(1e6)),
                "s",
                Need::Required,
                "Time at which it is reached.",
            ),
        ],
    },
    Variant {
        name: "table",
        doc: "Natural cubic spline through points, which goes on with a constant rate outside them.",
        keys: &[
            Key::new("times", Kind::Numbers(TIME), "s", Need::Required, "Rising times, two at least."),
            Key::new("values", Kind::Numbers(VALUE), "U", Need::Required, "Values, one a time."),
        ],
    },
];
