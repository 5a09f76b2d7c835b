//! Reduction of assembled matrices, whatever elements they come from.

use std::sync::Arc;

use faer::Mat;
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, StandardInputData};
use ffr_dynamics::reduction::compliance::ResidualFlexibility;
use ffr_dynamics::reduction::craig_bampton::{FixedInterfaceModes, craig_bampton};
use ffr_dynamics::reduction::modal::{ReducedBasis, all_modes};
use ffr_dynamics::reduction::problem::ElasticProblem;
use ffr_dynamics::reduction::rigid::RigidModes;

use super::{
    Interface, ReducedBody, answering, basis_from, free_modes, free_modes_answering, stored_basis,
    with_critical,
};
use crate::body::reduced::damping::damping;
use crate::spec::{DampingSpec, InterfaceModes, ReductionSpec};
use crate::store::{ModelCache, ModelKey};

/// The data of a reduction besides the interface.
pub(crate) struct ReductionInput<'a> {
    /// The matrices.
    pub body: &'a AssembledBody,
    /// The basis.
    pub reduction: ReductionSpec,
    /// Damping of its coordinates.
    pub damping: &'a DampingSpec,
    /// Key of the modes.
    pub key: ModelKey,
}

impl ReductionInput<'_> {
    /// The reduction with static answers to `loads`, the columns of those of `interface`; modes
    /// that `cache` has are not computed again.
    ///
    /// # Errors
    /// [`DynamicsError`] if modes or flexibility cannot be computed.
    pub fn reduce(
        self,
        interface: &Interface,
        loads: &Mat<f64>,
        cache: &ModelCache,
    ) -> Result<ReducedBody, DynamicsError> {
        let body = self.body;
        // Rigid modes come from the matrices at no cost, and errors of theirs before those of the
        // elastic ones.
        let rigid = Arc::new(RigidModes::new(body)?);
        let from = |stored: &_| basis_from(stored, body.dofs.len(), &rigid);
        let (basis, residual) = match self.reduction {
            ReductionSpec::CraigBampton { modes, .. } if interface.modes == InterfaceModes::Quasistatic => {
                let problem = ElasticProblem::free(body, &interface.unknowns)?;
                let build = || answering(&problem, free_modes(&problem, modes)?, loads);
                let basis = cache.recent(self.key, from, build, stored_basis)?;
                let residual = ResidualFlexibility::new(&problem, &interface.unknowns, &basis)?;
                (basis, Some(residual))
            }
            reduction => {
                let build = || dynamic_modes(body, reduction, interface, loads);
                (cache.recent(self.key, from, build, stored_basis)?, None)
            }
        };
        let stiffness: Vec<f64> = basis.omega.iter().map(|w| w * w).collect();
        let mut data = StandardInputData::new(body, basis.shapes.as_ref(), &stiffness)?;
        data.modal_damping = damping(self.damping, &stiffness, basis.first_static())?;
        if interface.modes == InterfaceModes::Damped {
            data.modal_damping = with_critical(data.modal_damping, &basis.omega, basis.n_low);
        }
        Ok(ReducedBody { basis, framed: None, residual, data, loads: interface.loads.clone() })
    }
}

/// The modes of a reduction without a quasistatic interface.
fn dynamic_modes(
    body: &AssembledBody,
    reduction: ReductionSpec,
    interface: &Interface,
    loads: &Mat<f64>,
) -> Result<ReducedBasis, DynamicsError> {
    match reduction {
        ReductionSpec::All => all_modes(body),
        ReductionSpec::CraigBampton { modes, fixed_interface_modes } if !interface.unknowns.is_empty() => {
            let count =
                fixed_interface_modes.map_or(FixedInterfaceModes::Checked, FixedInterfaceModes::Exactly);
            let basis = craig_bampton(body, &interface.unknowns, modes, count)?.basis;
            if loads.ncols() == 0 {
                return Ok(basis);
            }
            answering(&ElasticProblem::free(body, &[])?, basis, loads)
        }
        ReductionSpec::Modal { modes } | ReductionSpec::CraigBampton { modes, .. } => {
            free_modes_answering(body, modes, loads)
        }
    }
}
