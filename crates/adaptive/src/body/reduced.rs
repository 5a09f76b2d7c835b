//! The reduced model of a body, whatever elements its matrices come from, and what it is reduced
//! for.

use std::sync::Arc;

use faer::{Mat, MatRef};
use ffr_dynamics::DynamicsError;
use ffr_dynamics::body::{AssembledBody, ModalDamping, StandardInputData};
use ffr_dynamics::reduction::compliance::ResidualFlexibility;
use ffr_dynamics::reduction::modal::ReducedBasis;
use ffr_dynamics::reduction::problem::ElasticProblem;
use ffr_dynamics::reduction::rigid::RigidModes;
use ffr_dynamics::reduction::static_answers::{TakenLoads, with_static_answers};

use crate::body::loads::StaticLoads;
use crate::spec::InterfaceModes;
use crate::store::{StoredModel, matrix, matrix_values};

mod key;
mod stiffening;
pub(crate) mod damping;
mod reduction;

pub use key::modes_key;
pub(crate) use reduction::ReductionInput;
pub use stiffening::geometric_stiffening;

/// The reduced model of a body.
pub struct ReducedBody {
    /// Modes of the dynamic elastic coordinates at the unknowns, in the mean-axis frame.
    pub basis: ReducedBasis,
    /// The same modes in a tangent frame, if that is the frame in use.
    pub framed: Option<Mat<f64>>,
    /// Flexibility of what the modes leave out; with quasistatic contact only.
    pub residual: Option<ResidualFlexibility>,
    /// Inertia and couplings.
    pub data: StandardInputData,
    /// Loads whose static answers the basis was asked for; [`ReducedBasis::static_loads`] says
    /// which of their columns it has.
    pub loads: StaticLoads,
}

impl ReducedBody {
    /// Modes at the unknowns in the frame in use.
    pub fn shapes(&self) -> MatRef<'_, f64> {
        self.framed.as_ref().unwrap_or(&self.basis.shapes).as_ref()
    }
}

/// What the reduction of a body has to provide for contacts, joints and loads.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Interface {
    /// Unknowns of the contact interface, rising.
    pub unknowns: Vec<usize>,
    /// What becomes of the high-frequency modes.
    pub modes: InterfaceModes,
    /// Loads to which the basis has static answers.
    pub loads: StaticLoads,
}

/// The parts of a basis that the model store keeps: all but the rigid modes.
pub(crate) fn stored_basis(basis: &ReducedBasis) -> StoredModel {
    let (fewer, more) = basis.multiplet.unwrap_or((0, 0));
    let counts = [basis.n_low, basis.n_modes(), usize::from(basis.multiplet.is_some()), fewer, more];
    let counts = counts.iter().chain(&basis.static_loads).map(|n| *n as u64).collect();
    let mut values = basis.omega.clone();
    values.extend(matrix_values(&basis.shapes));
    StoredModel { counts, values }
}

/// The basis that was kept of a body with `n_unknowns` unknowns; none if it does not fit.
pub(crate) fn basis_from(
    stored: &StoredModel,
    n_unknowns: usize,
    rigid: &Arc<RigidModes>,
) -> Option<ReducedBasis> {
    let counts: Vec<usize> =
        stored.counts.iter().map(|n| usize::try_from(*n)).collect::<Result<_, _>>().ok()?;
    let (&[n_low, n_modes, has_multiplet, fewer, more], static_loads) = counts.split_first_chunk()?;
    let (omega, shapes) = stored.values.split_at_checked(n_modes)?;
    let basis = ReducedBasis {
        shapes: matrix(shapes, n_unknowns, n_modes)?,
        omega: omega.to_vec(),
        n_low,
        rigid: Arc::clone(rigid),
        multiplet: (has_multiplet == 1).then_some((fewer, more)),
        static_loads: static_loads.to_vec(),
    };
    (n_low <= n_modes).then_some(basis)
}

/// The lowest free modes, from a factorisation that the compliance uses too.
fn free_modes(problem: &ElasticProblem<'_>, n: usize) -> Result<ReducedBasis, DynamicsError> {
    Ok(ReducedBasis::from_modes(problem.lowest_modes(n)?, problem.free_rigid()?))
}

/// The lowest free modes of `body` with the static answers to `loads`.
pub(crate) fn free_modes_answering(
    body: &AssembledBody,
    n: usize,
    loads: &Mat<f64>,
) -> Result<ReducedBasis, DynamicsError> {
    let problem = ElasticProblem::free(body, &[])?;
    answering(&problem, free_modes(&problem, n)?, loads)
}

/// `basis` with the static answers to `loads`.
fn answering(
    problem: &ElasticProblem<'_>,
    basis: ReducedBasis,
    loads: &Mat<f64>,
) -> Result<ReducedBasis, DynamicsError> {
    with_static_answers(problem, basis, loads.as_ref(), TakenLoads::ByRank)
}

/// `own` damping with critical damping of the modes from `n_low` on added (Eq. F.28); `omega`:
/// their frequencies [rad/s].
pub(crate) fn with_critical(own: ModalDamping, omega: &[f64], n_low: usize) -> ModalDamping {
    let critical = omega.iter().enumerate().map(|(j, w)| if j < n_low { 0.0 } else { 2.0 * w });
    match own {
        ModalDamping::None => ModalDamping::PerMode(critical.collect()),
        ModalDamping::PerMode(own) => {
            ModalDamping::PerMode(own.iter().zip(critical).map(|(a, b)| a + b).collect())
        }
        ModalDamping::Full(mut matrix) => {
            critical.enumerate().for_each(|(j, d)| matrix[(j, j)] += d);
            ModalDamping::Full(matrix)
        }
    }
}
