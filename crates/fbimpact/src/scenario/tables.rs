//! Every key of the scenario file: the one place where names, types, units, ranges, defaults and
//! texts stand.

mod files;
mod models;
mod ranges;
mod gear_tooth;
mod shapes;
mod discretisation;
mod bodies;
mod time_curves;
mod joints;
mod contacts;
mod resolution;
mod simulation;

pub use bodies::{Arrangement, COPIED, FrameKind, MOST_COPIES};
pub use contacts::{Constraint, ContactModel, Search, Solver};
pub use discretisation::ReductionMethod;
pub use files::LengthUnit;
pub use joints::JointType;
pub use models::BodyModel;
pub use shapes::{ModelFacts, ShapeName};
pub use time_curves::{CurveKind, Interpolation};

use super::keys::{Key, Kind, Named, name_values};
use adaptive::spec::Accuracy;

name_values!(Accuracy {
    Fast: "fast", "three times the error of frequencies, modes up to 0.6 of the frequency (of flat faces all), 10 elements across a contact zone for 16, five times `penalty.tolerance`, ten times `rtol`";
    Normal: "normal", "the defaults as they stand on this page";
    Fine: "fine", "0.3 of the error of frequencies, modes up to 1.5 times the frequency, 24 elements across a contact zone for 16, a quarter of the penetration and of `penalty.tolerance`, a tenth of `rtol` and half the longest steps of impacts";
});

/// The top level of a scenario.
pub const SCENARIO: &[Key] = &[
    Key::new("title", Kind::Text).default("\"\"").doc("Title for reports and plots."),
    Key::new("accuracy", Kind::Choice(Accuracy::CHOICES))
        .default("\"normal\"")
        .doc("How fine everything is that the program chooses: meshes, modes, contact zones, penalty factors, time steps. What the scenario gives is left as it is."),
    Key::new("simulation", Kind::Table(simulation::SIMULATION))
        .doc("Time span, gravity and time integration."),
    Key::new("materials", Kind::Named(bodies::MATERIAL))
        .default("{}")
        .doc("Linear elastic, isotropic materials, by name."),
    Key::new("bodies", Kind::Named(bodies::BODY)).doc("Bodies, by name. Their order is that of the results."),
    Key::new("joints", Kind::Named(joints::JOINT))
        .default("{}")
        .doc("Joints between bodies, or between a body and ground, by name. A body that is the child of none moves freely."),
    Key::new("gears", Kind::Named(joints::GEAR))
        .default("{}")
        .doc("Gears, racks, screws, belts: fixed ratios between the rates of two joint coordinates, by name. The coordinates at the start \
         are as the joints say."),
    Key::new("loads", Kind::Named(joints::LOAD))
        .default("{}")
        .doc("Forces and moments on bodies over time, by name."),
    Key::new("contacts", Kind::Named(contacts::CONTACT))
        .default("{}")
        .doc("Pairs of bodies that may touch, by name."),
    Key::new("resolution", Kind::Table(resolution::RESOLUTION))
        .otherwise("no factors")
        .doc("Factors on what the keys of bodies, contacts and integration say, or their defaults: a twin of the scenario that is \
         finer by so much, as `fbimpact converge` runs them."),
    Key::new("uncertainty", Kind::Table(simulation::UNCERTAINTY))
        .default("{}")
        .doc("Bands of the numbers of impacts."),
    Key::new("output", Kind::Table(simulation::OUTPUT)).default("{}").doc("What is stored."),
];

/// Keys of the file that `geometry.file` names.
pub const NURBS_FILE: &[Key] = shapes::NURBS_NET;
