//! Keys of `[simulation]` and `[output]`.

use adaptive::spec::{FREE_INTERVAL, IMPACT_TOLERANCE, Start};
use ffr_dynamics::integration::Method;

use super::super::keys::{Choice, Condition, Key, Kind, Named, Range, Test, name_values};
use super::super::types::Compression;

/// Longest time that can be asked for: far above any impact, far below where `t + dt == t` for a
/// step of 1 ns.
const TIME: Range = Range::positive(1e6);

name_values!(Start {
    Given: "given", "as it is given, bodies undeformed";
    Elastic: "elastic", "bodies deformed, joints where they are given: under weight, springs, loads and the centrifugal and damping forces of the velocities given elastic coordinates are in equilibrium; contacts do not take part, and joints that close loops and gears are not known";
    Static: "static", "all that is at rest is in static equilibrium, contacts among it: bodies and joints move from where they are given until nothing accelerates. What has a velocity keeps its pose";
    StaticOnly: "static-only", "the same, and the run ends there: one state, as `fbimpact static` makes it";
});

name_values!(Method {
    DormandPrince: "dormand-prince", "explicit Runge-Kutta method of order 5(4) with error control; the free vibration of bodies without flexible joints is exact";
    Gauss: "gauss", "Gauss collocation, implicit, symmetric, of order 8 with error control: takes no energy from vibration, whatever the step";
    TrBdf2: "tr-bdf2", "implicit, L-stable, of order 2 with error control; damps what it does not resolve";
    Esdirk4: "esdirk4", "implicit, L-stable, of order 4 with error control; keeps more of what rings than `tr-bdf2` at larger steps";
});

/// A relative tolerance: below round-off it cannot be met, above 0.1 it means nothing.
const TOLERANCE: Range = Range::closed(1e-14, 0.1);

/// `[simulation]`.
pub const SIMULATION: &[Key] = &[
    Key::measured("end_time", Kind::Number(TIME), "s").doc("End of the simulated time; it starts at zero."),
    Key::measured("gravity", Kind::Vector(3, Range::within(1e6)), "m/s²")
        .default("[0.0, 0.0, 0.0]")
        .doc("Acceleration of gravity."),
    Key::new("static_start", Kind::Boolean)
        .default("false")
        .doc("As `start = \"elastic\"`.")
        .when(&[Condition::new("with start \"given\"", Test::OneOf("start", &["given"]))]),
    Key::new("start", Kind::Choice(Start::CHOICES))
        .default("\"given\"")
        .doc("The pose from which the run starts."),
    Key::measured("quiet_time", Kind::Number(TIME), "s")
        .otherwise("chosen from the step size, no longer than a touch of rigid bodies lasts")
        .doc("An impact has ended when no contact force has acted for so long and the bodies separate."),
    Key::measured("stop_after_impacts", Kind::Integer(1, 1_000_000), "–")
        .otherwise("the run goes on to `end_time`")
        .doc("The run ends when so many impacts, rows of `/impacts`, have ended and no further touch can belong to them, or at `end_time`."),
    Key::new("stop_at_rest", Kind::Table(REST))
        .otherwise("the run goes on to `end_time`")
        .doc("The run ends as soon as its bodies are at rest, or at `end_time`."),
    Key::measured("energy_tolerance", Kind::Number(Range::closed(1e-9, 1e6)), "–")
        .default("1e-3")
        .doc("A run whose energy ledger is open by more than this share of the largest energy has failed. What \
         `tr-bdf2` and `esdirk4` damp away numerically (`numerical_damping`; it may add up to a tenth) is recorded apart and not part of it."),
    Key::new("free", Kind::Table(FREE)).default("{}").doc("Time integration between impacts."),
    Key::new("impact", Kind::Table(IMPACT)).default("{}").doc("Time integration during impacts."),
    Key::new("lasting", Kind::Table(LASTING))
        .default("{}")
        .doc("Time integration where a contact has lasted for several times as long as its force took to rise, or for a hundred periods of the slowest \
         vibration of its bodies."),
];

const REST: &[Key] = &[
    Key::measured("speed", Kind::Number(Range::positive(1e6)), "m/s")
        .doc("Bodies are slow while the root of their mean square speed, `sqrt(2 T / m)` with the kinetic energy and the mass of all of them, \
         is no higher. Vibration counts."),
    Key::measured("duration", Kind::Number(TIME), "s")
        .doc("Bodies are at rest when they have been slow for so long: more than half a period of what swings, whose motion is slow for a moment \
         where it turns."),
];

const fn rtol(default: fn() -> String) -> Key {
    Key::measured("rtol", Kind::Number(TOLERANCE), "–")
        .derived(default)
        .doc("Error allowed in a step, as a share of the motion's velocity.")
}

fn default_tolerances(explicit: f64) -> String {
    let implicit = Method::Gauss.default_tolerance();
    format!("{explicit:e} for `dormand-prince`, {implicit:e} for the implicit methods")
}

const RTOL: Key = rtol(|| default_tolerances(Method::DormandPrince.default_tolerance()));

const FREE: &[Key] = &[
    Key::new("integrator", Kind::Choice(Method::CHOICES))
        .otherwise("`gauss` where bodies vibrate on joints that hold them by places that deform, else `dormand-prince`")
        .doc("Time integration method."),
    Key::measured("max_step", Kind::Number(TIME), "s").default("1e-4").doc("Longest step."),
    RTOL,
];

const IMPACT: &[Key] = &[
    Key::new("integrator", Kind::Choice(Method::CHOICES))
        .default("\"dormand-prince\"")
        .doc("Time integration method."),
    Key::measured("max_step", Kind::Number(TIME), "s")
        .otherwise("1 / (2 f_max), with f_max the highest eigenfrequency of the dynamic coordinates")
        .doc("Longest step."),
    rtol(|| default_tolerances(IMPACT_TOLERANCE)),
];

const LASTING: &[Key] = &[
    Key::new("integrator", Kind::Choice(Method::CHOICES))
        .otherwise("`esdirk4` from the time on when vibrations of the bodies hold a ten thousandth of the largest energy of deformation, else steps stay those of impacts")
        .doc("Time integration method. One that is given serves as soon as the contact lasts: what rings too fast for the steps of `esdirk4` or `tr-bdf2` is \
         damped, and recorded as such; `gauss` keeps it; with `dormand-prince` steps stay those of impacts."),
    Key::measured("max_step", Kind::Number(TIME), "s")
        .otherwise("what the tolerance allows")
        .doc("Longest step."),
    RTOL,
];

name_values!(Compression {
    None: "none", "fastest";
    Gzip: "gzip", "shuffle and gzip level 1; smooth histories shrink by about a tenth";
});

/// Coordinates and lengths in a body \[m\].
const PLACE: Range = Range::within(1e6);

/// `[uncertainty]`.
pub const UNCERTAINTY: &[Key] = &[
    Key::new("enabled", Kind::Boolean)
        .default("true")
        .doc("Whether it is estimated by how much peak force, duration, impulse, separating speed and restitution of each impact may be off because \
     of what the run is resolved to: the columns `…_uncertainty` of `/impacts` (docs/uncertainty.md). Motion and forces are the same without."),
    Key::new("accuracy", Kind::Number(Range::closed(1e-4, 1.0)))
        .otherwise("bands are as wide as they come")
        .doc("How wide the band of a peak force may be, as a share of it, contacts of model \"adaptive\" get more elements across their zones, four times as many at \
     most, and stiffer springs until it is as narrow; a warning says what it would take where other parts of the band are too wide."),
];

/// `[output]`.
pub const OUTPUT: &[Key] = &[
    Key::measured("free_interval", Kind::Number(TIME), "s")
        .derived(|| {
            format!(
                "{FREE_INTERVAL:?} s, or a quarter of the shortest period of harmonic forces and motions; after an impact a quarter of the shortest period at which a body vibrates strongly, if that is less"
            )
        })
        .doc("Time between stored states between impacts."),
    Key::measured("impact_interval", Kind::Number(Range::closed(0.0, 1e6)), "s")
        .default("0.0")
        .doc("Least time between stored states during impacts; with 0 every step is stored."),
    Key::measured("phase_states", Kind::Number(Range::closed(10.0, 1e12)), "–")
        .otherwise("1000, none in free phases whose `free_interval` is given")
        .doc("States of one phase are stored at intervals of at least the time since its start over this number: a phase that goes on and on has so \
         many more for each factor of 2.7 in time."),
    Key::new("pressure", Kind::Boolean)
        .default("true")
        .doc("Whether the pressures at contact points are stored; a result with many points in contact is smaller without."),
    Key::new("compression", Kind::Choice(Compression::CHOICES))
        .default("\"none\"")
        .doc("Compression of the time histories."),
    Key::new("arrays", Kind::Boolean)
        .otherwise("true with more than 500 bodies")
        .doc("Whether the motion of all bodies is stored in datasets that they share, /arrays/bodies, time × body × component, in place of five for each body."),
    Key::new("points", Kind::Named(POINT))
        .default("{}")
        .doc("Points whose motion is stored, and stress and strain where asked for, by name."),
    Key::new("stress", Kind::Named(STRESS))
        .default("{}")
        .doc("Straight lines along which stress is stored at one instant, by name."),
];

const POINT: &[Key] = &[
    Key::new("body", Kind::Name).doc("Name of the body."),
    Key::new("marker", Kind::Name).otherwise("`point` must be given").doc("Named point of the body's shape."),
    Key::measured("point", Kind::Point(PLACE), "m")
        .otherwise("`marker` must be given")
        .doc("Point in the components of the body's model: [x, y, z], [x, y] or [r, z]."),
    Key::new("stress", Kind::Boolean)
        .default("false")
        .doc("Whether the stress at the point is stored, too, in the axes of the body; of a flexible body with a shape or a mesh, at a single point."),
    Key::new("strain", Kind::Boolean)
        .default("false")
        .doc("Whether the strain is, under the same conditions: what strain gauges read."),
];

const STRESS_TIMES: &[Choice] =
    &[Choice::new("peak-force", "when the largest contact force of the run acts on the body")];

const STRESS: &[Key] = &[
    Key::new("body", Kind::Name).doc("Name of the body."),
    Key::measured("from", Kind::Place(PLACE), "m").doc("First point, or the name of a marker."),
    Key::measured("to", Kind::Place(PLACE), "m").doc("Last point, or the name of a marker."),
    Key::measured("samples", Kind::Integer(2, 100_000), "–")
        .default("201")
        .doc("Number of points, ends included."),
    Key::measured("at", Kind::ChoiceOrNumber(STRESS_TIMES, Range::closed(0.0, 1e6)), "s")
        .default("\"peak-force\"")
        .doc("Instant; in an impact the end of the step that is nearest to it."),
];
