//! Keys of `[resolution]`: factors on modes, meshes, contact zones, integration and penalty
//! factors.

use super::super::keys::{Bound, Key, Kind, Need, Range};

/// Largest factor on a number of modes or elements; a mesh a hundred times as fine fits into memory
/// nowhere.
const MAX_FACTOR: u64 = 100;
/// Factors on penalty factors; more decades than a contact between solids can use.
const PENALTY: Range = Range { min: Bound::Closed(1.0), max: Bound::Closed(1e6) };
/// Factors on tolerances: less than 1e-6 of any default cannot be met.
const TOLERANCE: Range = Range { min: Bound::Closed(1e-6), max: Bound::Closed(1.0) };

const MODES: &str = "Factor on the number of modes.";
const MESH: &str =
    "Factor on the elements in each direction outside of contact zones; `knots` are divided, too.";
const ZONE: &str = "Factor on the elements across contact zones: on `interval.elements`, or on the refinement of a body that the zone lies in.";
const STIFFER: &str =
    "Factor on penalty factors, given or first tried; `penalty.tolerance` of a search is divided by it.";

/// `[resolution]`.
pub(super) const RESOLUTION: &[Key] = &[
    Key::new("modes", Kind::Integer(1, MAX_FACTOR), "–", Need::Default("1"), MODES),
    Key::new("mesh", Kind::Integer(1, MAX_FACTOR), "–", Need::Default("1"), MESH),
    Key::new("zone", Kind::Integer(1, MAX_FACTOR), "–", Need::Default("1"), ZONE),
    Key::new(
        "tolerance",
        Kind::Number(TOLERANCE),
        "–",
        Need::Default("1.0"),
        "Factor on `rtol` in all phases; a tenth also halves the longest steps.",
    ),
    Key::new("penalty", Kind::Number(PENALTY), "–", Need::Default("1.0"), STIFFER),
    Key::new(
        "bodies",
        Kind::Named(OF_BODY),
        "",
        Need::Default("{}"),
        "Factors for single bodies, by their names.",
    ),
    Key::new(
        "contacts",
        Kind::Named(OF_CONTACT),
        "",
        Need::Default("{}"),
        "Factors for single contacts, by their names.",
    ),
];

const OF_BODY: &[Key] = &[
    Key::new("modes", Kind::Integer(1, MAX_FACTOR), "–", Need::Optional("`resolution.modes`"), MODES),
    Key::new("mesh", Kind::Integer(1, MAX_FACTOR), "–", Need::Optional("`resolution.mesh`"), MESH),
];

const OF_CONTACT: &[Key] = &[
    Key::new("zone", Kind::Integer(1, MAX_FACTOR), "–", Need::Optional("`resolution.zone`"), ZONE),
    Key::new("penalty", Kind::Number(PENALTY), "–", Need::Optional("`resolution.penalty`"), STIFFER),
];
