//! Fixed-interface (Craig-Bampton) reduction (Eqs. R.19 to R.21; Craig and Bampton 1968).
//!
//! `u_i = Psi u_b + Phi_n eta` with the constraint modes `Psi = -K_ii^-1 K_ib`. The reduced
//! eigenproblem turns the basis into mass-orthonormal modes; the rigid modes in it are removed, the
//! lowest elastic ones are low-frequency.

use crate::error::EigenFault;
use std::sync::Arc;

use faer::{Mat, MatRef};

use super::blocks::dense;
use super::eigen::elastic_modes_dense;
use super::eigen::modes::neighbouring_counts;
use super::modal::ReducedBasis;
use super::pencil::Pencil;
use super::problem::ElasticProblem;
use super::rigid::RigidModes;
use super::static_answers::orthonormalise;
use crate::DynamicsError;
use crate::body::AssembledBody;

/// Largest relative error of a retained frequency against the full model; then more fixed-interface
/// modes are taken.
pub const FREQUENCY_TOLERANCE: f64 = 1e-3;
/// Fixed-interface modes beyond the retained and rigid ones in the first attempt (half-disc: 6 + 1
/// + 13 reach 7e-5).
const FIRST_MARGIN: usize = 13;
/// Doublings of the margin.
const MAX_TRIES: usize = 5;

/// How many fixed-interface normal modes to take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FixedInterfaceModes {
    /// As many as the retained frequencies need to agree with the full model's within
    /// [`FREQUENCY_TOLERANCE`].
    Checked,
    /// Exactly this many (the papers' count); the error is only reported.
    Exactly(usize),
}

/// A Craig-Bampton model.
#[derive(Debug, Clone)]
pub struct CraigBampton {
    /// Mass-orthonormal elastic modes; the first `n_low` are low-frequency.
    pub basis: ReducedBasis,
    /// Interface unknowns, in the order given.
    pub interface: Vec<usize>,
    /// Number of fixed-interface normal modes taken.
    pub n_fixed_interface: usize,
    /// Largest relative error of the `n_low` retained frequencies against the full model's.
    pub frequency_error: f64,
}

/// Craig-Bampton reduction of a free body with `n_low` low-frequency modes.
///
/// # Errors
/// [`DynamicsError::Data`] if the interface is empty, does not hold the body, or leaves nothing inside;
/// [`DynamicsError::TooManyModes`]; [`DynamicsError::Eigenmodes`] if the retained frequencies do not reach the tolerance.
pub fn craig_bampton(
    body: &AssembledBody,
    interface: &[usize],
    n_low: usize,
    fixed_modes: FixedInterfaceModes,
) -> Result<CraigBampton, DynamicsError> {
    let rigid = Arc::new(RigidModes::new(body)?);
    let full = ElasticProblem::free(body, &[])?.lowest_modes(n_low)?;
    let inner = ElasticProblem::clamped(Pencil::new(body, interface)?, interface)?;
    let constraint = constraint_modes(&inner, interface);
    let available = inner.n_elastic();
    let (mut n_fixed, tries) = match fixed_modes {
        FixedInterfaceModes::Exactly(n) => (n, 1),
        FixedInterfaceModes::Checked => ((n_low + rigid.count() + FIRST_MARGIN).min(available), MAX_TRIES),
    };
    let mut error = f64::INFINITY;
    for _ in 0..tries {
        let mut basis = reduce(&inner, interface, &constraint, n_fixed, &rigid)?;
        if basis.n_modes() < n_low {
            return Err(DynamicsError::TooManyModes { wanted: n_low, available: basis.n_modes() });
        }
        error = (0..n_low).map(|i| (basis.omega[i] / full.omega[i] - 1.0).abs()).fold(0.0, f64::max);
        let checked = fixed_modes == FixedInterfaceModes::Checked;
        if !checked || error <= FREQUENCY_TOLERANCE || n_fixed == available {
            basis.n_low = n_low;
            let known: Vec<f64> = full.omega.iter().chain(&full.following).copied().collect();
            basis.multiplet = neighbouring_counts(&known, n_low);
            return Ok(CraigBampton {
                basis,
                interface: interface.to_vec(),
                n_fixed_interface: n_fixed,
                frequency_error: error,
            });
        }
        n_fixed = (2 * n_fixed).min(available);
    }
    let fault = EigenFault::FixedInterface { modes: n_fixed, error, limit: FREQUENCY_TOLERANCE };
    let frequency = full.omega.last().map_or(0.0, |w| w / std::f64::consts::TAU);
    Err(DynamicsError::Eigenmodes { found: n_low, expected: n_low, frequency, fault })
}

/// Constraint modes on all unknowns (n x n_b): column j is the answer to a unit move of interface
/// unknown j [m/m].
fn constraint_modes(inner: &ElasticProblem<'_>, interface: &[usize]) -> Mat<f64> {
    let n = inner.n_unknowns();
    let unit = Mat::from_fn(n, interface.len(), |i, j| if i == interface[j] { 1.0 } else { 0.0 });
    let mut modes = inner.stiffness_product(unit.as_ref());
    modes *= faer::Scale(-1.0);
    inner.solve_held(modes.as_mut());
    modes += unit;
    modes
}

/// Reduced matrices, reduced eigenproblem, expansion to all unknowns.
fn reduce(
    inner: &ElasticProblem<'_>,
    interface: &[usize],
    constraint: &Mat<f64>,
    n_fixed: usize,
    rigid: &Arc<RigidModes>,
) -> Result<ReducedBasis, DynamicsError> {
    let normal = inner.lowest_modes(n_fixed)?;
    let (n, n_b) = (inner.n_unknowns(), interface.len());
    let size = n_b + n_fixed;
    let mut basis = Mat::zeros(n, size);
    basis.as_mut().subcols_mut(0, n_b).copy_from(constraint);
    basis.as_mut().subcols_mut(n_b, n_fixed).copy_from(&normal.shapes);

    // K: the Schur complement on the interface (rows of K Psi there), the squared frequencies
    // inside; no coupling.
    let pulled = inner.stiffness_product(constraint.as_ref());
    let mut k = Mat::zeros(size, size);
    for j in 0..n_b {
        for i in 0..n_b {
            k[(i, j)] = pulled[(interface[i], j)];
        }
    }
    for (j, omega) in normal.omega.iter().enumerate() {
        k[(n_b + j, n_b + j)] = omega * omega;
    }
    dense::symmetrise(&mut k);
    let mass_basis = inner.mass_product(basis.as_ref());
    let mut m = dense::product(basis.transpose(), mass_basis.as_ref());
    dense::symmetrise(&mut m);
    let reduced_rigid =
        rigid_coordinates(rigid.modes.as_ref(), interface, constraint, &normal.shapes, &mass_basis);
    let (lambda, reduced) = elastic_modes_dense(k.as_ref(), m.as_ref(), reduced_rigid.as_ref())?;
    let mut shapes = dense::product(basis.as_ref(), reduced.as_ref());
    orthonormalise(&mut shapes, |x| inner.mass_product(x))?;
    Ok(ReducedBasis {
        shapes,
        omega: lambda.iter().map(|l| l.sqrt()).collect(),
        n_low: lambda.len(),
        rigid: Arc::clone(rigid),
        multiplet: None,
        static_loads: Vec::new(),
    })
}

/// Coordinates of the rigid modes in the reduced basis: their interface values; the constraint
/// modes carry them exactly, so the normal modes take part only with round-off.
fn rigid_coordinates(
    rigid: MatRef<'_, f64>,
    interface: &[usize],
    constraint: &Mat<f64>,
    normal: &Mat<f64>,
    mass_basis: &Mat<f64>,
) -> Mat<f64> {
    let n_b = interface.len();
    let at_interface = Mat::from_fn(n_b, rigid.ncols(), |i, j| rigid[(interface[i], j)]);
    let mut rest = rigid.to_owned();
    dense::add_product(rest.as_mut(), -1.0, constraint.as_ref(), at_interface.as_ref());
    let mass_normal = mass_basis.as_ref().subcols(n_b, normal.ncols());
    let inside = dense::product(mass_normal.transpose(), rest.as_ref());
    Mat::from_fn(n_b + normal.ncols(), rigid.ncols(), |i, j| {
        if i < n_b { at_interface[(i, j)] } else { inside[(i - n_b, j)] }
    })
}
