//! Static answers to given loads beside free modes: residual attachment modes (docs/theory.md
//! Eqs. R.27 to R.31; MacNeal 1971, Rubin 1975, Craig and Chang 1977).
//!
//! Free modes answer a joint force slowly. `Ψ = (F - Φ Ω⁻² Φᵀ) B` is what they leave out of the
//! static answer to the loads `B`; added to the modes as mass-orthonormal pseudo-modes of high
//! frequency, it makes the static answer of the reduced body that of the full one.

use faer::{Mat, MatRef};

use super::blocks::dense;
use super::compliance::residual_modes::PencilModes;
use super::eigen::elastic_modes_dense;
use super::modal::ReducedBasis;
use super::problem::{ElasticProblem, SOLVE_COLUMNS};
use crate::DynamicsError;
use crate::data_error::DataError;

/// Share of the energy of its whole static answer below which the part of a load's answer that
/// modes and other loads leave out is dropped: the compliance then errs by this share.
///
/// Solves err by some 1e-12 of that energy, so that what is kept has four digits at least.
pub const RANK_TOLERANCE: f64 = 1e-8;
/// Share of the largest energy of a static answer below which a load does not deform the body: it
/// balances the inertia forces of a rigid motion up to round-off. Slender bodies have shares of
/// 1e-7 between tension and bending.
const NO_DEFORMATION: f64 = 1e-13;
/// Mass that pseudo-modes may share with the modes that are kept, a tenth of the deviation from
/// mass-orthonormality that the equations of motion allow. Eigenmodes share what the eigensolver
/// has left in them, modes of an interface a good part.
const SHARED_MASS: f64 = 1e-8;

/// Loads whose static answers a basis takes.
#[derive(Debug, Clone, Copy)]
pub enum TakenLoads<'a> {
    /// Loads whose answers are linearly independent up to [`RANK_TOLERANCE`].
    ByRank,
    /// These columns, as decided for another model of the body.
    Given(&'a [usize]),
}

/// `basis` completed by the static answers to `loads` (n × k): forces on the unknowns, in columns
/// of comparable units, so that moments are those of unit forces on a lever of the body's size. The
/// columns taken are [`ReducedBasis::static_loads`].
///
/// Modes that are the body's own stay as they are, up to the accuracy of the eigensolver, with the
/// pseudo-modes behind them. Others are mixed with the pseudo-modes (Rayleigh-Ritz).
///
/// # Errors
/// [`DynamicsError::Data`] if sizes do not fit, the body is clamped or a load is not finite; [`DynamicsError::NotPositiveDefinite`] if
/// given loads depend on each other or on the modes; [`DynamicsError::Factorisation`].
pub fn with_static_answers(
    problem: &ElasticProblem<'_>,
    basis: ReducedBasis,
    loads: MatRef<'_, f64>,
    taken: TakenLoads<'_>,
) -> Result<ReducedBasis, DynamicsError> {
    check(problem, &basis, loads)?;
    let mut whole = loads.to_owned();
    for first in (0..loads.ncols()).step_by(SOLVE_COLUMNS) {
        let width = SOLVE_COLUMNS.min(loads.ncols() - first);
        problem.apply_flexibility(whole.as_mut().subcols_mut(first, width));
    }
    let energies: Vec<f64> = (0..loads.ncols()).map(|j| loads.col(j).transpose() * whole.col(j)).collect();
    let mut residual = whole;
    remove_modes(&basis, &dense::product(basis.shapes.transpose(), loads), &mut residual);
    // Once more with K itself: what is left of the modes is round-off of the solves.
    let forces = problem.stiffness_product(residual.as_ref());
    remove_modes(&basis, &dense::product(basis.shapes.transpose(), forces.as_ref()), &mut residual);
    let mut compliance = dense::product(loads.transpose(), residual.as_ref());
    dense::symmetrise(&mut compliance);
    let columns = match taken {
        TakenLoads::ByRank => independent_loads(&compliance, &energies),
        TakenLoads::Given(columns) => columns.to_vec(),
    };
    let answers = Mat::from_fn(residual.nrows(), columns.len(), |i, j| residual[(i, columns[j])]);
    let compliance = Mat::from_fn(columns.len(), columns.len(), |i, j| compliance[(columns[i], columns[j])]);
    completed(problem, basis, &answers, compliance, columns)
}

fn check(
    problem: &ElasticProblem<'_>,
    basis: &ReducedBasis,
    loads: MatRef<'_, f64>,
) -> Result<(), DynamicsError> {
    problem.free_rigid()?;
    let (n, rows) = (problem.n_unknowns(), loads.nrows());
    if rows != n || basis.shapes.nrows() != n {
        let (what, found) = ("rows of the modes or the loads".into(), rows.min(basis.shapes.nrows()));
        return Err(DataError::Count { what, found, expected: n }.into());
    }
    if !loads.col_iter().all(|load| load.iter().all(|f| f.is_finite())) {
        return Err(DataError::NotFinite { what: "a load of a marker".into() }.into());
    }
    Ok(())
}

/// Subtracts `Φ Ω⁻² a` from `x`.
fn remove_modes(basis: &ReducedBasis, amplitudes: &Mat<f64>, x: &mut Mat<f64>) {
    let scaled = Mat::from_fn(amplitudes.nrows(), amplitudes.ncols(), |i, j| {
        amplitudes[(i, j)] / (basis.omega[i] * basis.omega[i])
    });
    dense::add_product(x.as_mut(), -1.0, basis.shapes.as_ref(), scaled.as_ref());
}

/// Loads whose answers are independent, by Cholesky's algorithm with pivoting on the residual
/// compliance, each load scaled to unit energy `energies` of its whole static answer; in the order
/// of the pivots.
fn independent_loads(compliance: &Mat<f64>, energies: &[f64]) -> Vec<usize> {
    let n = energies.len();
    let largest = energies.iter().copied().fold(0.0, f64::max);
    let scale: Vec<f64> =
        energies.iter().map(|&e| if e > NO_DEFORMATION * largest { 1.0 / e.sqrt() } else { 0.0 }).collect();
    let mut rest = Mat::from_fn(n, n, |i, j| scale[i] * compliance[(i, j)] * scale[j]);
    let mut columns = Vec::new();
    for _ in 0..n {
        let free = (0..n).filter(|j| !columns.contains(j));
        // The first of equal ones, so that the order of the loads decides.
        let best =
            free.reduce(|a, b| if rest[(b, b)] > rest[(a, a)] * (1.0 + RANK_TOLERANCE) { b } else { a });
        let Some(pivot) = best.filter(|&j| rest[(j, j)] > RANK_TOLERANCE) else { break };
        let column: Vec<f64> = (0..n).map(|i| rest[(i, pivot)]).collect();
        for j in 0..n {
            for i in 0..n {
                rest[(i, j)] -= column[i] * column[j] / column[pivot];
            }
        }
        columns.push(pivot);
    }
    columns
}

/// `basis` with the span of `answers`, which are orthogonal to it in stiffness and have the
/// stiffness matrix `compliance` (R.28).
fn completed(
    problem: &ElasticProblem<'_>,
    basis: ReducedBasis,
    answers: &Mat<f64>,
    compliance: Mat<f64>,
    columns: Vec<usize>,
) -> Result<ReducedBasis, DynamicsError> {
    if columns.is_empty() {
        return Ok(basis);
    }
    let momenta = problem.mass_product(answers.as_ref());
    let mut mass = dense::product(answers.transpose(), momenta.as_ref());
    dense::symmetrise(&mut mass);
    let pseudo = PencilModes::new(&compliance, mass)?;
    let coordinates = pseudo.coordinates();
    let shapes = dense::product(answers.as_ref(), coordinates.as_ref());
    let shared = dense::product(
        dense::product(basis.shapes.transpose(), momenta.as_ref()).as_ref(),
        coordinates.as_ref(),
    );
    let omega = pseudo.omega;
    let all_low = basis.n_low == basis.n_modes();
    let mut joined = joined(&basis, shapes.as_ref(), &omega);
    if shared.norm_max() > SHARED_MASS {
        joined = rayleigh_ritz(joined, &shared, basis.n_modes())?;
        orthonormalise(&mut joined.shapes, |x| problem.mass_product(x))?;
    }
    joined.n_low = if all_low { joined.omega.len() } else { basis.n_low };
    joined.static_loads = columns;
    Ok(joined)
}

/// Modes and pseudo-modes side by side.
fn joined(basis: &ReducedBasis, shapes: MatRef<'_, f64>, omega: &[f64]) -> ReducedBasis {
    let (n, m) = (basis.n_modes(), omega.len());
    let mut all = Mat::zeros(basis.shapes.nrows(), n + m);
    all.as_mut().subcols_mut(0, n).copy_from(&basis.shapes);
    all.as_mut().subcols_mut(n, m).copy_from(shapes);
    ReducedBasis { shapes: all, omega: basis.omega.iter().chain(omega).copied().collect(), ..basis.clone() }
}

/// Makes modes of rising frequency that are mass-orthonormal up to the round-off of a projected
/// eigenproblem so up to that of sums. Every mode loses its share of lower ones, which weighs less
/// in the stiffness than in the mass.
///
/// # Errors
/// [`DynamicsError::NotPositiveDefinite`] if they are linearly dependent.
pub(super) fn orthonormalise(
    shapes: &mut Mat<f64>,
    mass_product: impl Fn(MatRef<'_, f64>) -> Mat<f64>,
) -> Result<(), DynamicsError> {
    let mut gram = dense::product(shapes.transpose(), mass_product(shapes.as_ref()).as_ref());
    dense::symmetrise(&mut gram);
    let factor = dense::cholesky(gram, "the mass of the modes")?;
    let mut transposed = shapes.transpose().to_owned();
    dense::solve_lower(factor.as_ref(), transposed.as_mut());
    *shapes = transposed.transpose().to_owned();
    Ok(())
}

/// Modes of the span of `basis`, whose stiffness is diagonal; its first `n` shapes have the mass
/// `shared` with the others.
fn rayleigh_ritz(basis: ReducedBasis, shared: &Mat<f64>, n: usize) -> Result<ReducedBasis, DynamicsError> {
    let size = basis.n_modes();
    let mut stiffness = Mat::zeros(size, size);
    let mut mass = Mat::<f64>::identity(size, size);
    for (i, omega) in basis.omega.iter().enumerate() {
        stiffness[(i, i)] = omega * omega;
    }
    for j in 0..size - n {
        for i in 0..n {
            mass[(i, n + j)] = shared[(i, j)];
            mass[(n + j, i)] = shared[(i, j)];
        }
    }
    let (lambda, vectors) =
        elastic_modes_dense(stiffness.as_ref(), mass.as_ref(), Mat::zeros(size, 0).as_ref())?;
    Ok(ReducedBasis {
        shapes: dense::product(basis.shapes.as_ref(), vectors.as_ref()),
        omega: lambda.iter().map(|l| l.sqrt()).collect(),
        ..basis
    })
}
