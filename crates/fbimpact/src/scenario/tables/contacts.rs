//! Keys of `[contacts.NAME]`.

use adaptive::adaptivity::interval::TARGET_UTILISATION;
use adaptive::adaptivity::penalty_search::PEAK_TOLERANCE;
use adaptive::body::fine::divided::{LINEAR, QUADRATIC, TETRAHEDRA};
use adaptive::body::fine::refined::ELEMENTS;
use adaptive::spec::contact::{DivisionRule, LowModes, PointRule, TransferMethod};
use adaptive::spec::{Accuracy, Treatment};

use super::super::keys::{Condition, Fact, Key, Kind, Named, Range, Test, name_values};

/// How a contact is modelled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactModel {
    /// On a zone that the program refines.
    Adaptive,
    /// High-frequency modes follow the force.
    Quasistatic,
    /// A boundary without mass.
    Massless,
    /// Zones that vibrate, damped critically.
    Damped,
    /// Zones that vibrate.
    Dynamic,
    /// Without refinement.
    Coarse,
    /// Hertz's law.
    Hertz,
}

impl ContactModel {
    /// How its zone is treated; none by Hertz's law, which has no zone.
    pub fn treatment(self) -> Option<Treatment> {
        Some(match self {
            Self::Adaptive => Treatment::Adaptive,
            // The boundary's compliance without springs behind its points: Eq. A.34.
            Self::Quasistatic | Self::Massless => Treatment::Quasistatic,
            Self::Damped => Treatment::Damped,
            Self::Dynamic => Treatment::Dynamic,
            Self::Coarse => Treatment::Coarse,
            Self::Hertz => return None,
        })
    }

    /// Whether it has a zone of which `what` holds.
    pub fn is(self, what: impl FnOnce(Treatment) -> bool) -> bool {
        self.treatment().is_some_and(what)
    }

    /// Whether it has no penalty factor by its nature.
    pub fn is_massless(self) -> bool {
        self == Self::Massless
    }
}

name_values!(ContactModel {
    Adaptive: "adaptive", "as `quasistatic`, on a contact zone that the program refines at every impact; on the whole surfaces of bodies that touch with flat faces, edges or corners";
    Quasistatic: "quasistatic", "high-frequency modes follow the contact force statically";
    Massless: "massless", "as `quasistatic`, without penetration and without a penalty factor: the boundary has no mass and obeys the laws of Signorini and Coulomb as they are";
    Damped: "damped", "every Craig-Bampton mode is dynamic, high-frequency ones damped critically";
    Dynamic: "dynamic", "every Craig-Bampton mode is dynamic";
    Coarse: "coarse", "the modes of the free body alone, without refinement; of rigid bodies, points all over both, on springs";
    Hertz: "hertz", "Hertz's law at the closest places of two smooth surfaces that are curved against each other, rigid or flexible, or of one and a plane; of plane models that of a line";
});

/// How penetration is resisted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Constraint {
    /// By springs.
    Penalty,
    /// There is none.
    Exact,
}

name_values!(Constraint {
    Penalty: "penalty", "pressure proportional to penetration";
    Exact: "exact", "no penetration, no penalty factor; needs Greville points and the active-set solver";
});

name_values!(PointRule {
    Greville: "greville", "Greville abscissae of the surface";
    Gauss: "gauss", "Gauss points of the surface elements";
});

/// Who finds the quasistatic state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solver {
    /// The active-set method.
    ActiveSet,
    /// Algorithm 1.
    Broyden,
}

name_values!(Solver {
    ActiveSet: "active-set", "primal active-set method, converges for every penalty factor";
    Broyden: "broyden", "Algorithm 1 of Rückwald, Held and Seifried (2024)";
});

/// How the penalty factor is adapted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Search {
    /// It is not.
    Fixed,
    /// Until the peak force no longer changes.
    UntilConverged,
    /// Until the contact solver fails.
    UntilError,
}

name_values!(Search {
    Fixed: "fixed", "the factor, given or predicted, is used throughout";
    UntilConverged: "until-converged", "raised by ten until the peak force no longer changes, or the share of penetration shows that it would not; of flat faces, edges and corners as long as penetration is too large a share of the approach";
    UntilError: "until-error", "raised by ten until the contact solver fails, then lowered step by step ([A] Fig. 3)";
});

name_values!(DivisionRule {
    Graded: "graded", "levels that halve the elements, as many as the interval needs";
    Printed: "printed", "Algorithm 3 as [A] prints it: five levels, ten knots per element and level; too few for some intervals";
});

name_values!(LowModes {
    Prolonged: "prolonged", "those of the coarse model; the motion goes on without a jump";
    Fine: "own", "modes of the fine model itself; the motion is projected onto them at the touch and back afterwards";
});

name_values!(TransferMethod {
    MassOrthogonal: "projection", "mass-orthogonal projection, the best approximation in kinetic energy";
    Printed: "printed", "Rückwald, Held and Seifried (2024), section 4.4: least squares and interpolation";
});

/// The contact has contact points on a surface.
const SURFACE: &[Condition] =
    &[Condition::new("with contact points", Test::NoneOf("model", &["hertz"])).remark("\"hertz\" has none")];
/// The contact has points in a zone.
const ON_FLEXIBLE: &[Condition] = &[
    SURFACE[0],
    Condition::new("with a flexible contact body", Test::Fact(Fact::IsOnFlexible))
        .remark("a rigid one has points all over its surface"),
];
/// The contact has a law to choose.
const CHOSEN: &[Condition] = &[
    SURFACE[0],
    Condition::new("with a law to choose", Test::NoneOf("model", &["massless"]))
        .remark("\"massless\" has no penetration and no penalty factor"),
];
/// The contact is one of surfaces of splines.
const ON_SPLINES: &[Condition] = &[
    ON_FLEXIBLE[0],
    ON_FLEXIBLE[1],
    Condition::new("between bodies with a shape", Test::Fact(Fact::IsOnSplines))
        .remark("contacts of bodies with model \"mesh\" have Gauss points"),
];
/// The program refines the contact zone by itself.
const REFINED: Condition =
    Condition::new("where the program refines the contact zone", Test::Fact(Fact::IsRefined))
        .remark("as with model \"adaptive\" and between two flexible bodies");

/// `[contacts.NAME]`.
pub const CONTACT: &[Key] = &[
    Key::new("contact_body", Kind::Name)
        .doc("Body that carries the contact points, flexible; with `coarse`, where no body is flexible, and with `hertz`, which has none, also a rigid one. Of a flexible and a rigid body it is \
         the flexible one. With a `*`, such as `ball-*`, all bodies with such a name: the table is a contact for each pair of different bodies, called by its \
         name and what the `*` stand for."),
    Key::new("target_body", Kind::Name)
        .doc("Body whose surface the points meet: a flexible body with the same `model`, `mesh` counting as `solid`; a rigid body with a shape and the \
         `motion` that goes with it, free, on joints or held by a joint to ground; a rigid plane. With `hertz` any body with a shape that moves as \
         the contact body does, or a plane. With a `*` all bodies with such a name, as for `contact_body`."),
    Key::new("model", Kind::Choice(ContactModel::CHOICES)).default("\"adaptive\"").doc("Contact model."),
    Key::new("constraint", Kind::Choice(Constraint::CHOICES))
        .default("\"penalty\"")
        .doc("How penetration is resisted.")
        .when(CHOSEN),
    Key::new("points", Kind::Choice(PointRule::CHOICES))
        .default("\"greville\"")
        .doc("Where the contact points are.")
        .when(ON_SPLINES),
    Key::new("solver", Kind::Choice(Solver::CHOICES))
        .default("\"active-set\"")
        .doc("Solver of the quasistatic state.")
        .when(SURFACE),
    Key::measured("friction", Kind::Number(Range::closed(0.0, 100.0)), "–")
        .default("0.0")
        .doc("Coefficient of friction, of stick and slip alike; needs the active-set solver. With `hertz` the contact yields along the surface as Mindlin's does, \
         without effect on turns about the normal."),
    Key::measured("damping", Kind::Number(Range::closed(0.0, 1e6)), "s/m")
        .default("0.0")
        .doc("Growth of the contact force per speed at which the contact closes, of normal force and friction alike: after an approach at `v` two bodies part \
         with the restitution `e` of `damping v (1 + e) = ln((1 + damping v) / (1 - e damping v))`, `1 - 2/3 damping v` where that is little."),
    Key::new("modes", Kind::Choice(LowModes::CHOICES))
        .default("\"prolonged\"")
        .doc("Low-frequency modes of the fine models, where the program refines. A body in two contacts at once keeps those that it \
         had at the first touch.")
        .when(SURFACE),
    Key::new("transfer", Kind::Choice(TransferMethod::CHOICES))
        .default("\"projection\"")
        .doc("How the state is handed over between coarse and fine models, with modes = \"own\".")
        .when(SURFACE),
    Key::measured("initial_overlap", Kind::Number(Range::closed(0.0, 1e6)), "m")
        .default("0.0")
        .doc("Overlap of the bodies at the start that is allowed; the run begins with its energy. More is an error, round-off is not."),
    Key::new("penalty", Kind::Table(PENALTY)).default("{}").doc("Penalty factor.").when(CHOSEN),
    Key::new("interval", Kind::Table(INTERVAL))
        .default("{}")
        .doc("Part of the surface that carries contact points, about the place of first contact.")
        .when(ON_FLEXIBLE),
];

/// Soft foam to far above the stiffest contact that double precision resolves [N/m³].
const FACTOR: Range = Range::positive(1e24);

const PENALTY: &[Key] = &[
    Key::measured("initial", Kind::Number(FACTOR), "N/m³")
        .otherwise("predicted from the compliance of the model, of rigid bodies from weight and approach")
        .doc("Penalty factor: pressure per penetration. A search starts from it.")
        .when(&[Condition::new(
            "with constraint \"penalty\"",
            Test::Around(&Test::NoneOf("constraint", &["exact"])),
        )]),
    Key::measured("tolerance", Kind::Number(Range::open(0.0, 1.0)), "–")
        .derived(|| {
            format!(
                "{PEAK_TOLERANCE:?}, with `accuracy` \"fast\" {:?}, with \"fine\" {:?}",
                Accuracy::Fast.peak_tolerance(),
                Accuracy::Fine.peak_tolerance()
            )
        })
        .doc("Relative change of the peak force below which the search ends.")
        .when(&[Condition::new("with search \"until-converged\"", Test::Fact(Fact::SearchConverges))]),
    Key::new("search", Kind::Choice(Search::CHOICES))
        .otherwise("\"until-converged\" with `adaptive`, else \"fixed\"")
        .doc("How the factor, given or predicted, is adapted, with `adaptive`. \"until-error\" needs the solver \"broyden\", and between flat faces, edges and corners does as \"until-converged\"."),
];

/// A share of a whole, neither nothing nor all of it.
const SHARE: Range = Range::open(0.0, 1.0);

const INTERVAL: &[Key] = &[
    Key::measured("width", Kind::Number(Range::positive(1e6)), "m")
        .otherwise("predicted by Hertz's theory where the program refines, else the zone of the nearest `refine` entry of the \
             contact body")
        .doc("Width along the surface; with `adaptive` that of the first trial. In an axisymmetric model it is counted from the \
         axis outwards."),
    Key::measured("elements", Kind::Integer(1, 10_000), "–")
        .derived(|| {
            format!(
                "{ELEMENTS} where the program refines, on a mesh {QUADRATIC}, {TETRAHEDRA} of quadratic tetrahedra, {LINEAR} of linear elements, else the elements that the \
                 discretisation has there"
            )
        })
        .doc("Elements across `width`, for which the body is refined; on a plane it needs `width`, except with `adaptive`. Elements of a mesh are halved until \
         there are as many at least.")
        .when(&[Condition::new(
        "with a zone that is refined",
        Test::Around(&Test::NoneOf("model", &["coarse"])),
    ).remark("\"coarse\" refines nothing")]),
    Key::measured("target_utilisation", Kind::Number(SHARE), "–")
        .constant(TARGET_UTILISATION)
        .doc("Share of the elements that shall touch; a new width aims at it. An interval is too wide below five sevenths of it.")
        .when(&[Condition::new(
        "with model \"adaptive\"",
        Test::Around(&Test::OneOf("model", &["adaptive"])),
    )]),
    Key::new("division", Kind::Choice(DivisionRule::CHOICES))
        .default("\"graded\"")
        .doc("How the elements about the interval are divided.")
        .when(&[REFINED]),
];
