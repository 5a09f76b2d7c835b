//! Keys of `discretisation` and `reduction`: the spline space of a body and its reduced basis.

use adaptive::sizing::{mesh, mode_count};
use ffr_dynamics::body::RigidMotion;

use super::super::keys::{Bound, Condition, Key, Kind, Named, Range, Test, name_values};
use super::ranges::{COORDINATE, LENGTH, MAX_DEGREE};

/// Elements per direction; more do not fit into memory in two dimensions.
const MAX_ELEMENTS: u64 = 10_000;

/// `[bodies.NAME.discretisation]`.
pub(super) const DISCRETISATION: &[Key] = &[
    Key::measured("degree", Kind::Counts(1, MAX_DEGREE), "–")
        .default("3")
        .doc("Spline degree; raised to that of the exact geometry where it is lower."),
    Key::measured("elements", Kind::Counts(1, MAX_ELEMENTS), "–")
        .derived(|| {
            let tolerance = 100.0 * mesh::TOLERANCE;
            format!("chosen by the program, so that the kept frequencies are right to {tolerance} %; `fbimpact modes` shows them")
        })
        .doc("Uniform elements per direction, before refinement.")
        .when(&[Condition::new("without \"knots\"", Test::Without("knots"))]),
    Key::measured("knots", Kind::Lists(Range::open(0.0, 1.0)), "–")
        .otherwise("uniform knots from `elements`")
        .doc("Interior knots per direction, which take the place of `elements`."),
    Key::new("refine", Kind::Tables(REFINE))
        .default("[]")
        .doc("Zones of small elements, from which elements grow geometrically."),
];

const REFINE: &[Key] = &[
    Key::new("marker", Kind::Name)
        .otherwise("`point` must be given")
        .doc("Named point of the shape in the middle of the zone."),
    Key::measured("point", Kind::Point(COORDINATE), "m")
        .otherwise("`marker` must be given")
        .doc("Point in the middle of the zone, in the components of the model: [x, y, z], [x, y] or [r, z]."),
    Key::measured("width", Kind::Number(LENGTH), "m")
        .doc("Width of the zone along the surface. On the axis of an axisymmetric model it is counted from the axis."),
    Key::measured("elements", Kind::Integer(1, MAX_ELEMENTS), "–")
        .default("16")
        .doc("Elements across the width."),
    Key::measured("ratio", Kind::Number(Range { min: Bound::Open(1.0), max: Bound::Closed(100.0) }), "–")
        .default("1.5")
        .doc("Largest ratio of neighbouring elements outside the zone."),
];

/// How a body is reduced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReductionMethod {
    /// After Craig and Bampton.
    CraigBampton,
    /// By free modes.
    Modal,
    /// Not at all.
    All,
}

name_values!(ReductionMethod {
    CraigBampton: "craig-bampton", "free modes, and the static answer of the zones of `quasistatic`, `massless`, `damped` and `dynamic` contacts; where no such contact is on the body the same as `modal`";
    Modal: "modal", "free modes alone; `adaptive` and `coarse` contacts need no more";
    All: "all", "every mode of the full model, for verification";
});

/// The basis leaves modes out.
const LEAVES_OUT: &[Condition] =
    &[Condition::new("for methods other than \"all\"", Test::NoneOf("method", &["all"]))
        .remark("which leaves nothing out")];

/// `[bodies.NAME.reduction]`.
pub(super) const REDUCTION: &[Key] = &[
    Key::new("method", Kind::Choice(ReductionMethod::CHOICES))
        .default("\"craig-bampton\"")
        .doc("Reduction method."),
    Key::measured("modes", Kind::Integer(1, 100_000), "–")
        .derived(|| {
            let [axial, others] = [RigidMotion::Axial, RigidMotion::Spatial].map(mode_count::least);
            format!(
                "chosen by the program from the time scale of the impacts on the body; at least {axial} in axisymmetric models \
                 and {others} in others, {} without contacts",
                mode_count::WITHOUT_FORCES
            )
        })
        .doc("Number of free modes; static answers to joints and loads add to them.")
        .when(LEAVES_OUT),
    Key::measured("fixed_interface_modes", Kind::Integer(1, 100_000), "–")
        .otherwise("`modes`, the rigid ones and a margin")
        .doc("Number of fixed-interface modes; only where a `quasistatic`, `massless`, `damped` or `dynamic` contact is on the body.")
        .when(&[Condition::new("with method \"craig-bampton\"", Test::OneOf("method", &["craig-bampton"])), Condition::new(
            "for bodies with a shape",
            Test::Around(&Test::NoneOf("model", &["imported", "mesh"])),
        ).remark("others have no contact zone")]),
    Key::new("static_answers", Kind::Boolean)
        .default("true")
        .doc("Whether the static answers to the forces and moments of the body's joints and loads, and to its spin where that strains it, are added to the modes; `false` is for \
         comparison with free modes alone.")
        .when(LEAVES_OUT),
];
