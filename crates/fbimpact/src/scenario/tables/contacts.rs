//! Keys of `[contacts.NAME]`.

use super::super::keys::{Choice, Key, Kind, Need, Range};

const MODELS: &[Choice] = &[
    Choice::new("quasistatic", "high-frequency modes follow the contact force statically"),
    Choice::new("dynamic", "every Craig-Bampton mode is dynamic"),
    Choice::later("adaptive"),
    Choice::later("damped"),
    Choice::later("coarse"),
    Choice::later("hertz"),
];

const CONSTRAINTS: &[Choice] = &[
    Choice::new("penalty", "pressure proportional to penetration"),
    Choice::new(
        "exact",
        "no penetration, no penalty factor; needs Greville points and the active-set solver",
    ),
];

const POINTS: &[Choice] = &[
    Choice::new("greville", "Greville abscissae of the surface"),
    Choice::new("gauss", "Gauss points of the surface elements"),
];

const SOLVERS: &[Choice] = &[
    Choice::new("active-set", "primal active-set method, converges for every penalty factor"),
    Choice::new("broyden", "Algorithm 1 of Rückwald, Held and Seifried (2024)"),
];

const SEARCHES: &[Choice] = &[
    Choice::new("fixed", "the given factor is used throughout"),
    Choice::later("until-converged"),
    Choice::later("until-error"),
];

/// `[contacts.NAME]`.
pub const CONTACT: &[Key] = &[
    Key::new(
        "contact_body",
        Kind::Name,
        "",
        Need::Required,
        "Body that carries the contact points; flexible.",
    ),
    Key::new(
        "target_body",
        Kind::Name,
        "",
        Need::Required,
        "Body whose surface the points meet; a rigid plane.",
    ),
    Key::new("model", Kind::Choice(MODELS), "", Need::Default("\"quasistatic\""), "Contact model."),
    Key::new(
        "constraint",
        Kind::Choice(CONSTRAINTS),
        "",
        Need::Default("\"penalty\""),
        "How penetration is resisted.",
    ),
    Key::new(
        "points",
        Kind::Choice(POINTS),
        "",
        Need::Default("\"greville\""),
        "Where the contact points are.",
    ),
    Key::new(
        "solver",
        Kind::Choice(SOLVERS),
        "",
        Need::Default("\"active-set\""),
        "Solver of the quasistatic state.",
    ),
    Key::new(
        "friction",
        Kind::Fixed(0.0),
        "–",
        Need::Default("0.0"),
        "Coefficient of friction. Only 0 is supported yet.",
    ),
    Key::new("penalty", Kind::Table(PENALTY), "", Need::Default("{}"), "Penalty factor."),
    Key::new(
        "interval",
        Kind::Table(INTERVAL),
        "",
        Need::Default("{}"),
        "Part of the surface that carries contact points, about the place of first contact.",
    ),
];

/// Soft foam to far above the stiffest contact that double precision resolves [N/m³].
const FACTOR: Range = Range::positive(1e24);

const PENALTY: &[Key] = &[
    Key::new(
        "initial",
        Kind::Number(FACTOR),
        "N/m³",
        Need::Default("1e18"),
        "Penalty factor: pressure per penetration.",
    ),
    Key::new(
        "value",
        Kind::Number(FACTOR),
        "N/m³",
        Need::Optional("`initial` holds"),
        "Another name for `initial`, for fixed factors.",
    ),
    Key::new("search", Kind::Choice(SEARCHES), "", Need::Default("\"fixed\""), "How the factor is adapted."),
];

const INTERVAL: &[Key] = &[
    Key::new(
        "width",
        Kind::Number(Range::positive(1e6)),
        "m",
        Need::Optional("the zone of the nearest `refine` entry of the contact body"),
        "Width along the surface. In an axisymmetric model it is counted from the axis outwards.",
    ),
    Key::new(
        "elements",
        Kind::Integer(1, 10_000),
        "–",
        Need::Optional("the elements that the discretisation has there"),
        "Elements across `width`, for which the body is refined; needs `width`.",
    ),
];
