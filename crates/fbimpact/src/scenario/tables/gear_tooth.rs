//! Keys of the shape `gear-tooth`.

use super::super::keys::{Condition, Key, Kind, Range};
use super::ranges::LENGTH;

/// Pressure angles \[rad\].
const PRESSURE_ANGLE: Range = Range::open(0.0, std::f64::consts::FRAC_PI_4);

/// Keys of a tooth; `spatial` says which bodies have a width of their own.
pub(super) const fn keys(spatial: &'static [Condition]) -> [Key; 7] {
    [
        Key::measured("module", Kind::Number(LENGTH), "m")
            .doc("Module: diameter of the pitch circle over the number of teeth. On the pitch circle tooth and gap are equally wide."),
        Key::measured("teeth", Kind::Integer(6, 100_000), "–").doc("Number of teeth of the whole gear."),
        Key::angle("pressure_angle", Kind::Number(PRESSURE_ANGLE), "rad")
            .otherwise("20 degrees")
            .doc("Pressure angle on the pitch circle."),
        Key::measured("addendum", Kind::Number(LENGTH), "m")
            .otherwise("`module`")
            .doc("Height of the tip over the pitch circle."),
        Key::measured("dedendum", Kind::Number(LENGTH), "m")
            .otherwise("1.25 `module`")
            .doc("Depth of the root under the pitch circle."),
        Key::measured("inner_radius", Kind::Number(LENGTH), "m")
            .doc("Inner radius of the rim, below that of the root circle."),
        Key::measured("width", Kind::Number(LENGTH), "m")
            .otherwise("must be given for solid and spatial rigid bodies")
            .doc("Width of the face, along z from z = 0.")
            .when(spatial),
    ]
}
