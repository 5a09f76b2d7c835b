//! What is found implausible in a run, and what to change then.

use std::fmt;

use nalgebra::Vector3;
use thiserror::Error;

/// A vector that is shown by its components in brackets, to the digits that change something; zeros
/// without sign.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Components(pub Vector3<f64>);

impl fmt::Display for Components {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.norm();
        let shown = |x: f64| if x.abs() <= 1e-9 * size { "0".to_owned() } else { format!("{x:.9e}") };
        write!(f, "[{}, {}, {}]", shown(self.0.x), shown(self.0.y), shown(self.0.z))
    }
}

/// What may leave the energy ledger open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum LedgerCause {
    /// Factors lowered in the run took at least half of the energy.
    #[error(
        "penalty factors were lowered because the contact solver found no forces with them, which took that energy; lower the coefficient of friction or give penalty.initial"
    )]
    LoweredPenalty,
    /// Anything else.
    #[error(
        "lower simulation.impact.rtol or penalty.initial, refine the contact zone, exchange contact_body and target_body if the sides of the target's mesh have kinks (warning coarse-shape), or check that bodies do not touch with edges"
    )]
    Resolution,
}

/// A quantity of a body that has a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum BodyQuantity {
    /// Against what motions and gravity reach.
    #[error("its distance from the start")]
    Distance,
    /// Against the size of the body.
    #[error("its elastic displacement")]
    Displacement,
    /// Against the speed of longitudinal waves.
    #[error("the speed of its deformation")]
    DeformationSpeed,
    /// Of the rotation of a part of the body against the whole.
    #[error("the angle by which deformation turns a part of it")]
    Turn,
    /// Against one half.
    #[error("its strain")]
    Strain,
    /// Against the load that buckles it.
    #[error("its axial load over its buckling load")]
    Load,
}

impl BodyQuantity {
    /// Unit of value and limit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Distance | Self::Displacement => "m",
            Self::DeformationSpeed => "m/s",
            Self::Turn => "rad",
            Self::Strain => "m/m",
            Self::Load => "N/N",
        }
    }

    /// What to change.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::Distance => "check loads, drives and springs",
            Self::Displacement => {
                "linear elasticity ends long before the size of the body; set geometric_stiffening = true where it spins, \
                 lower the loads, or check the units of the material"
            }
            Self::DeformationSpeed => {
                "no wave of the material is as fast; check velocities and the units of the material, or lower the time step"
            }
            Self::Turn => {
                "linear deformation ends below a tenth of that; divide the body into several, joined by `fixed`, lower the loads, set \
                 geometric_stiffening = true where it spins, or check the units of the material"
            }
            Self::Strain => {
                "linear elasticity ends long before; lower the loads or check the units of the material"
            }
            Self::Load => {
                "the body has buckled, which linear deformation does not show; lower the load, make the body thicker, or divide it into \
                 several, joined by `fixed`"
            }
        }
    }
}

/// A quantity of a contact that has a limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum ContactQuantity {
    /// Against the speed of waves in the softer material.
    #[error("the speed at which its bodies approach each other")]
    Speed,
    /// Against the size of the bodies.
    #[error("the approach of its bodies")]
    Approach,
    /// Against one half.
    #[error("the contact's radius over the radius of curvature, which its pressure means,")]
    Strain,
}

impl ContactQuantity {
    /// Unit of value and limit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Speed => "m/s",
            Self::Approach => "m",
            Self::Strain => "m/m",
        }
    }

    /// What to change.
    pub fn remedy(self) -> &'static str {
        match self {
            Self::Speed => {
                "elastic contact ends below the speed of waves in the softer material; check velocities and units"
            }
            Self::Approach => {
                "the contact is too soft for this impact; check velocities, the units of the material and penalty.initial"
            }
            Self::Strain => {
                "linear elasticity ends below a fifth of that and every material has yielded; lower the velocity or check the units of the \
                 material"
            }
        }
    }
}
