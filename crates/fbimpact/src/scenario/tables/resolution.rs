//! Keys of `[resolution]`: factors on modes, meshes, contact zones, integration and penalty
//! factors.

use super::super::keys::{Key, Kind, Range};

/// Largest factor on a number of modes or elements; a mesh a hundred times as fine fits into memory
/// nowhere.
const MAX_FACTOR: u64 = 100;
/// Factors on penalty factors; more decades than a contact between solids can use.
const PENALTY: Range = Range::closed(1.0, 1e6);
/// Factors on tolerances: less than 1e-6 of any default cannot be met.
const TOLERANCE: Range = Range::closed(1e-6, 1.0);

const MODES: &str = "Factor on the number of modes.";
const MESH: &str =
    "Factor on the elements in each direction outside of contact zones; `knots` are divided, too.";
const ZONE: &str = "Factor on the elements across contact zones: on `interval.elements`, or on the refinement of a body that the zone lies in.";
const STIFFER: &str =
    "Factor on penalty factors, given or first tried; `penalty.tolerance` of a search is divided by it.";

/// `[resolution]`.
pub(super) const RESOLUTION: &[Key] = &[
    Key::measured("modes", Kind::Integer(1, MAX_FACTOR), "–").default("1").doc(MODES),
    Key::measured("mesh", Kind::Integer(1, MAX_FACTOR), "–").default("1").doc(MESH),
    Key::measured("zone", Kind::Integer(1, MAX_FACTOR), "–").default("1").doc(ZONE),
    Key::measured("tolerance", Kind::Number(TOLERANCE), "–")
        .default("1.0")
        .doc("Factor on `rtol` in all phases; a tenth also halves the longest steps."),
    Key::measured("penalty", Kind::Number(PENALTY), "–").default("1.0").doc(STIFFER),
    Key::new("bodies", Kind::Named(OF_BODY)).default("{}").doc("Factors for single bodies, by their names."),
    Key::new("contacts", Kind::Named(OF_CONTACT))
        .default("{}")
        .doc("Factors for single contacts, by their names."),
];

const OF_BODY: &[Key] = &[
    Key::measured("modes", Kind::Integer(1, MAX_FACTOR), "–").otherwise("`resolution.modes`").doc(MODES),
    Key::measured("mesh", Kind::Integer(1, MAX_FACTOR), "–").otherwise("`resolution.mesh`").doc(MESH),
];

const OF_CONTACT: &[Key] = &[
    Key::measured("zone", Kind::Integer(1, MAX_FACTOR), "–").otherwise("`resolution.zone`").doc(ZONE),
    Key::measured("penalty", Kind::Number(PENALTY), "–").otherwise("`resolution.penalty`").doc(STIFFER),
];
