//! What can be wrong with a spline, a patch or a model built from them.

use thiserror::Error;

/// Errors of spline and geometry construction. Texts are fragments that read after "body ...: ".
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SplineError {
    /// The degree lies outside the supported range.
    #[error("degree {degree} is not supported, choose {min} to {max}")]
    Degree {
        /// The degree asked for.
        degree: usize,
        /// Smallest degree allowed here.
        min: usize,
        /// Largest degree allowed here.
        max: usize,
    },
    /// The knots do not form a clamped knot vector.
    #[error("knot vector is not valid: {0}")]
    Knots(String),
    /// The control net does not fit the knot vectors.
    #[error("control net has {found} {what}, the knot vectors ask for {expected}")]
    NetSize {
        /// "control points" or "weights".
        what: &'static str,
        /// Count found.
        found: usize,
        /// Count that the knot vectors ask for.
        expected: usize,
    },
    /// A weight is not a positive finite number.
    #[error("weight {index} is {value}, it must be positive and finite")]
    Weight {
        /// Index of the control point.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// A coordinate is not finite.
    #[error("control point {index} has a coordinate that is not a finite number")]
    ControlPoint {
        /// Index of the control point.
        index: usize,
    },
    /// A length or ratio of a named shape is impossible.
    #[error("{name} = {value}: {reason}")]
    Dimension {
        /// The parameter's name as in the scenario.
        name: &'static str,
        /// The value found.
        value: f64,
        /// The rule that it breaks.
        reason: &'static str,
    },
    /// The map from parameters to space turns inside out.
    #[error(
        "geometry is folded or inside out: Jacobian determinant {determinant:.3e} at parameters {parameters:?}"
    )]
    Folded {
        /// The determinant found (m per parameter unit, to the power of the dimension).
        determinant: f64,
        /// Where.
        parameters: [f64; 3],
    },
    /// What was asked for is not possible on several patches.
    #[error("shape of {n_patches} patches: {reason}")]
    MultiPatch {
        /// Number of patches.
        n_patches: usize,
        /// The rule that is broken, with a remedy.
        reason: &'static str,
    },
    /// A point lies outside the body or the search for it did not converge.
    #[error("point ({}, {}, {}) m is not in the body, nearest distance {distance:.3e} m", point[0], point[1], point[2])]
    PointNotFound {
        /// The point asked for \[m\].
        point: [f64; 3],
        /// Distance to the nearest point found \[m\].
        distance: f64,
    },
    /// The shape has no face of this name.
    #[error("the shape has no face \"{name}\", it has {}", known.join(", "))]
    UnknownFace {
        /// The name asked for.
        name: String,
        /// The names that there are.
        known: Vec<String>,
    },
    /// A face without area, or a disc or ball of none.
    #[error("{extent} has no area")]
    EmptyExtent {
        /// Which extent, for messages.
        extent: String,
    },
    /// A disc or ball that leaves the body.
    #[error(
        "the {kind} of radius {radius} m about ({}, {}, {}) m reaches beyond the body; choose a smaller radius, another point, or a whole face",
        point[0], point[1], point[2]
    )]
    ExtentBeyondBody {
        /// "disc" or "ball".
        kind: &'static str,
        /// Its radius \[m\].
        radius: f64,
        /// Its centre \[m\].
        point: [f64; 3],
    },
    /// A point of an axisymmetric body lies on the wrong side of the axis.
    #[error(
        "radius {radius:.3e} m at parameters {parameters:?} is not positive, an axisymmetric body must lie at r >= 0"
    )]
    Radius {
        /// The radius found \[m\].
        radius: f64,
        /// Where.
        parameters: [f64; 3],
    },
    /// A matrix has more entries than 32-bit indices can name.
    #[error("the matrices would have {entries} entries, at most 4294967295 are possible, use fewer elements")]
    TooLarge {
        /// Number of entries.
        entries: usize,
    },
    /// Poisson's ratio, Young's modulus or density is impossible.
    #[error("material {name} = {value}: {reason}")]
    Material {
        /// The constant's name as in the scenario.
        name: &'static str,
        /// The value found.
        value: f64,
        /// The rule that it breaks.
        reason: &'static str,
    },
    /// Levels of a hierarchical space do not follow from each other.
    #[error("refinement levels do not fit: {0}")]
    Levels(String),
    /// A box of elements cannot be refined.
    #[error("elements {lower:?} up to {upper:?} of refinement level {level} cannot be refined: {reason}")]
    RefinedBox {
        /// Level of the elements; 0 is the coarsest.
        level: usize,
        /// First element per direction.
        lower: [usize; 3],
        /// One past the last element per direction.
        upper: [usize; 3],
        /// The rule that the box breaks.
        reason: &'static str,
    },
    /// Displacements would tear at a seam or a collapsed edge, because it is refined on one side
    /// only.
    #[error(
        "refinement differs on the two sides of the {what} at parameters {parameters:?}, refine both sides alike"
    )]
    OpenSeam {
        /// "seam" or "collapsed edge".
        what: &'static str,
        /// Where.
        parameters: [f64; 3],
    },
    /// A space does not contain another one, and why.
    #[error("the finer space does not contain the coarser one: {0}")]
    NotContained(String),
}
