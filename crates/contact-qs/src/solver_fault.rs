//! Why the forces of a contact cannot be found.

use ffr_dynamics::error::{EvaluationFault, FailureKind};
use thiserror::Error;

use crate::ContactError;

/// Why the forces of a contact cannot be found at a state.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SolverFault {
    /// A gap that is no number.
    #[error("the gap of contact point {point} is {gap} at t = {time:.9e} s")]
    Gap {
        /// Number of the point.
        point: usize,
        /// What was found \[m\].
        gap: f64,
        /// Time \[s\].
        time: f64,
    },
    /// A gap of a Hertz contact that is no number.
    #[error("the gap of a Hertz contact is {gap} m at t = {time:.9e} s")]
    HertzGap {
        /// What was found \[m\].
        gap: f64,
        /// Time \[s\].
        time: f64,
    },
    /// A touch that Hertz's theory of points has no answer for.
    #[error(
        "{why} at t = {time:.9e} s, where Hertz's law needs smooth surfaces that are curved against each other; choose model = \"adaptive\" for the contact"
    )]
    NoHertzPoint {
        /// What was found.
        why: &'static str,
        /// Time \[s\].
        time: f64,
    },
    /// A problem or a solution with values that are not finite.
    #[error(
        "a {value} is not finite; forces or motions of the bodies are too large, check units, loads and velocities"
    )]
    NotFinite {
        /// What value, in the singular.
        value: &'static str,
    },
    /// A singular compliance of the points in contact.
    #[error("the compliance of the {points} contact points in contact is singular, {}", remedy(*is_exact))]
    SingularCompliance {
        /// Number of points in contact.
        points: usize,
        /// Whether the penalty factor is infinite.
        is_exact: bool,
    },
    /// A singular compliance along the tangents.
    #[error("the tangential compliance of {directions} free directions is singular, {}", remedy(*is_exact))]
    SingularTangential {
        /// Number of free directions.
        directions: usize,
        /// Whether the penalty factor is infinite.
        is_exact: bool,
    },
    /// A set of points in contact that is not found.
    #[error(
        "which of the {points} contact points are in contact was not found in {iterations} iterations; give penalty.initial a lower number, or interval.elements a smaller one"
    )]
    ActiveSet {
        /// Number of contact points.
        points: usize,
        /// Iterations allowed.
        iterations: usize,
    },
    /// A set of sliding points that is not found.
    #[error(
        "which of the {points} contact points slide was not found in {iterations} iterations; give penalty.initial a lower number, friction a smaller one, or interval.elements a smaller one"
    )]
    SlidingSet {
        /// Number of contact points.
        points: usize,
        /// Iterations allowed.
        iterations: usize,
    },
    /// Normal and friction forces that do not come to rest.
    #[error(
        "normal and friction forces did not converge in {alternations} alternations, the friction coefficient {coefficient} is too large for this surface; give friction a smaller number"
    )]
    Alternation {
        /// Alternations allowed.
        alternations: usize,
        /// Friction coefficient.
        coefficient: f64,
    },
    /// Projection and deformation of a pair that do not come to rest.
    #[error(
        "projection and deformation of a contact have not met after {passes} passes at t = {time:.9e} s: gaps change by {change:.3e} m at a penetration of {depth:.3e} m, give interval.elements a larger number, or leave interval.width and model out if an edge may touch"
    )]
    Passes {
        /// Passes allowed.
        passes: usize,
        /// Time \[s\].
        time: f64,
        /// Change of the gaps in the last pass \[m\].
        change: f64,
        /// Penetration \[m\].
        depth: f64,
    },
    /// Algorithm 1 without a solution (line 30).
    #[error(
        "Algorithm 1 has not converged, its last step changed the coordinates by {change:.1e} of them, lower the penalty factor or use the active-set solver"
    )]
    Broyden {
        /// Relative change of the coordinates in the last step.
        change: f64,
    },
    /// A singular Jacobian of Algorithm 1 (line 11).
    #[error(
        "the Jacobian of the quasistatic contact is singular (reciprocal condition number {rcond:.2e}), lower the penalty factor or use the active-set solver"
    )]
    BroydenSingular {
        /// Reciprocal condition number.
        rcond: f64,
    },
    /// A Jacobian of Algorithm 1 that is not finite (line 13).
    #[error(
        "the Jacobian of the quasistatic contact is not finite, lower the penalty factor or use the active-set solver"
    )]
    BroydenNotFinite,
    /// Bodies of axisymmetric or plane models that share no axis or no plane.
    #[error("{0}")]
    Apart(String),
    /// A body of an axisymmetric or plane model that has left it.
    #[error("{body} body in contact is tilted by {tilt:e} out of its model")]
    Tilted {
        /// "a plane" or "an axisymmetric".
        body: &'static str,
        /// Sine of the angle.
        tilt: f64,
    },
    /// A body of an axisymmetric or plane model before a plane that it does not admit.
    #[error(transparent)]
    Alignment(ContactError),
}

/// What helps against a singular compliance.
fn remedy(is_exact: bool) -> &'static str {
    if is_exact {
        "as where its points outnumber the surface functions, or the body is too thin; with constraint = \"exact\" or model = \"massless\" give points = \"greville\" and interval.elements a smaller number, or choose constraint = \"penalty\""
    } else {
        "round-off of the bodies' compliance exceeds that of the penalty springs; take a lower penalty factor, or a thicker body or a smaller piece of it (penalty.initial)"
    }
}

impl EvaluationFault for SolverFault {
    fn kind(&self) -> FailureKind {
        match self {
            Self::Gap { .. } | Self::HertzGap { .. } | Self::NotFinite { .. } | Self::BroydenNotFinite => {
                FailureKind::NotFinite
            }
            Self::SingularCompliance { .. }
            | Self::SingularTangential { .. }
            | Self::BroydenSingular { .. } => FailureKind::Singular,
            Self::ActiveSet { .. }
            | Self::SlidingSet { .. }
            | Self::Alternation { .. }
            | Self::Passes { .. }
            | Self::Broyden { .. } => FailureKind::IterationLimit,
            Self::NoHertzPoint { .. } | Self::Apart(_) | Self::Tilted { .. } | Self::Alignment(_) => {
                FailureKind::OutOfModel
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_solver_sees_comes_with_keys_that_can_be_changed() {
        let singular = |is_exact| SolverFault::SingularCompliance { points: 1, is_exact };
        for (fault, keys) in [
            (singular(false), &["penalty.initial"][..]),
            (singular(true), &["constraint = \"penalty\"", "points = \"greville\"", "interval.elements"]),
            (SolverFault::SingularTangential { directions: 2, is_exact: false }, &["penalty.initial"]),
            (SolverFault::ActiveSet { points: 3, iterations: 9 }, &["penalty.initial", "interval.elements"]),
            (SolverFault::SlidingSet { points: 3, iterations: 9 }, &["penalty.initial", "friction"]),
            (SolverFault::Alternation { alternations: 9, coefficient: 2.0 }, &["friction"]),
            (SolverFault::NotFinite { value: "gap" }, &["units, loads and velocities"]),
        ] {
            let text = fault.to_string();
            assert!(keys.iter().all(|key| text.contains(key)), "{text}");
            assert!(!text.contains("finite penalty factor"), "where none was set: {text}");
        }
    }
}
