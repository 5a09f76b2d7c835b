//! Every key of the scenario file: the one place where names, types, units, ranges, defaults and texts stand.

mod bodies;
mod contacts;
mod simulation;

pub use bodies::{ModelFacts, SHAPES, ShapeFacts};

use super::keys::{Key, Kind, Need};

/// The top level of a scenario.
pub const SCENARIO: &[Key] = &[
    Key::new("title", Kind::Text, "", Need::Default("\"\""), "Title for reports and plots."),
    Key::new(
        "simulation",
        Kind::Table(simulation::SIMULATION),
        "",
        Need::Required,
        "Time span, gravity and time integration.",
    ),
    Key::new(
        "materials",
        Kind::Named(bodies::MATERIAL),
        "",
        Need::Default("{}"),
        "Linear elastic, isotropic materials, by name.",
    ),
    Key::new(
        "bodies",
        Kind::Named(bodies::BODY),
        "",
        Need::Required,
        "Bodies, by name. Their order is that of the results.",
    ),
    Key::new(
        "contacts",
        Kind::Named(contacts::CONTACT),
        "",
        Need::Default("{}"),
        "Pairs of bodies that may touch, by name.",
    ),
    Key::new("output", Kind::Table(simulation::OUTPUT), "", Need::Default("{}"), "What is stored."),
];

/// Keys of the file that `geometry.file` names.
pub const NURBS_FILE: &[Key] = bodies::NURBS_NET;
