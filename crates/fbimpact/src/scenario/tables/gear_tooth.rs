//! Keys of the shape `gear-tooth`.

use super::super::keys::{Bound, Condition, Key, Kind, Need, Range};
use super::ranges::LENGTH;

/// Pressure angles \[rad\].
const PRESSURE_ANGLE: Range = Range { min: Bound::Open(0.0), max: Bound::Open(std::f64::consts::FRAC_PI_4) };

/// Keys of a tooth; `spatial` says which bodies have a width of their own.
pub(super) const fn keys(spatial: &'static [Condition]) -> [Key; 7] {
    [
        Key::new(
            "module",
            Kind::Number(LENGTH),
            "m",
            Need::Required,
            "Module: diameter of the pitch circle over the number of teeth. On the pitch circle tooth and gap are equally wide.",
        ),
        Key::new(
            "teeth",
            Kind::Integer(6, 100_000),
            "–",
            Need::Required,
            "Number of teeth of the whole gear.",
        ),
        Key::angle(
            "pressure_angle",
            Kind::Number(PRESSURE_ANGLE),
            "rad",
            Need::Optional("20 degrees"),
            "Pressure angle on the pitch circle.",
        ),
        Key::new(
            "addendum",
            Kind::Number(LENGTH),
            "m",
            Need::Optional("`module`"),
            "Height of the tip over the pitch circle.",
        ),
        Key::new(
            "dedendum",
            Kind::Number(LENGTH),
            "m",
            Need::Optional("1.25 `module`"),
            "Depth of the root under the pitch circle.",
        ),
        Key::new(
            "inner_radius",
            Kind::Number(LENGTH),
            "m",
            Need::Required,
            "Inner radius of the rim, below that of the root circle.",
        ),
        Key::new(
            "width",
            Kind::Number(LENGTH),
            "m",
            Need::Optional("must be given for solid and spatial rigid bodies"),
            "Width of the face, along z from z = 0.",
        )
        .when(spatial),
    ]
}
