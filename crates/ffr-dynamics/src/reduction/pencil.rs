//! The pair `(K, M)` of a body with one pattern, one elimination order and one symbolic
//! factorisation.
//!
//! Clamped or supported unknowns keep their place: their rows and columns are replaced by the
//! diagonal entry, so that the same analysis serves `K` supported, `K` with a clamped interface,
//! and every `K - mu M` (Eq. R.3).

pub mod cost;
pub mod inertia;

use std::borrow::Cow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use faer::sparse::{SparseColMat, SparseColMatRef, SymbolicSparseColMat};

use super::factor::numeric::Kind;
use super::factor::single_precision::SinglePrecisionFactor;
use super::factor::{CholeskyFactor, SymbolicFactor};
use super::ordering::elimination_order;
use crate::DynamicsError;
use crate::body::{AssembledBody, MassMatrix};
use crate::data_error::{DataError, EntryFault};
use inertia::{Inertia, SINGLE_FROM, ShiftedFactor};

const STIFFNESS: &str = "the supported stiffness matrix";

/// Stiffness and mass of a body, ready to be combined and factorised.
#[derive(Debug, Clone)]
pub struct Pencil<'a> {
    body: &'a AssembledBody,
    /// `K` on the union of the patterns of `K` and `M`.
    stiffness: Cow<'a, SparseColMat<u32, f64>>,
    symbolic: Arc<SymbolicFactor>,
    digits: Digits,
}

/// Whether single precision has enough digits for the matrices of a body, as far as its factors have
/// shown: the thinner a body, and the finer its mesh, the fewer are left.
#[derive(Debug, Clone, Default)]
pub struct Digits {
    known: Arc<TooFew>,
}

/// For which matrices digits are too few.
#[derive(Debug, Default)]
struct TooFew {
    /// The stiffness, whose factor is to be solved with.
    definite: AtomicBool,
    /// Shifted matrices, whose pivots are counted.
    shifted: AtomicBool,
}

impl<'a> Pencil<'a> {
    /// Checks the matrices and analyses the factorisation; the unknowns `last` are eliminated last,
    /// in this order.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if sizes do not fit, an entry is not finite, an unknown has no positive stiffness or
    /// mass, or `last` holds an unknown twice or one that does not exist.
    pub fn new(body: &'a AssembledBody, last: &[usize]) -> Result<Self, DynamicsError> {
        check(body)?;
        check_unknowns(last, body.n_unknowns())?;
        let stiffness = unite(body)?;
        let pattern = stiffness.symbolic();
        let order = elimination_order(pattern, &body.dofs, &body.anchors, last);
        let symbolic = Arc::new(SymbolicFactor::new(pattern, order, last.len())?);
        Ok(Self { body, stiffness, symbolic, digits: Digits::default() })
    }

    /// The same with what other meshes of the body have shown, and for those that follow.
    #[must_use]
    pub fn with_digits(self, digits: Digits) -> Self {
        Self { digits, ..self }
    }

    /// Whether a factor in single precision is worth its while: the matrix is large, and digits have
    /// not been found `too_few`.
    fn tries_single(&self, too_few: &AtomicBool) -> bool {
        self.symbolic.n_entries() >= SINGLE_FROM && !too_few.load(Ordering::Relaxed)
    }

    /// Takes note that the stiffness needs double precision, here and on meshes that follow.
    pub(super) fn note_too_few_digits(&self) {
        self.digits.known.definite.store(true, Ordering::Relaxed);
    }

    /// Inertia and factor of a shifted `matrix` in single precision; `None` if that is not tried, or
    /// the factor too inaccurate to count.
    fn counted_single(
        &self,
        matrix: SparseColMatRef<'_, u32, f64>,
    ) -> Result<Option<(Inertia, ShiftedFactor)>, DynamicsError> {
        let too_few = &self.digits.known.shifted;
        if !self.tries_single(too_few) {
            return Ok(None);
        }
        let counted = self.symbolic.counted_single(matrix)?;
        // Less than that may be due to the shift alone.
        let is_hopeless = |(inertia, _): &(Inertia, _)| inertia.contraction.is_some_and(|c| c > 1.0);
        if counted.as_ref().is_some_and(is_hopeless) {
            too_few.store(true, Ordering::Relaxed);
        }
        Ok(counted.filter(|(inertia, _)| inertia.stands()))
    }

    /// The body.
    pub fn body(&self) -> &'a AssembledBody {
        self.body
    }

    /// The shared analysis.
    pub fn symbolic(&self) -> &Arc<SymbolicFactor> {
        &self.symbolic
    }

    /// Cholesky factor of `K + shift M` with the rows and columns of `fixed` unknowns reduced to
    /// their diagonal.
    ///
    /// # Errors
    /// [`DynamicsError::NotPositiveDefinite`] if the rest can still move without energy.
    pub fn cholesky(&self, shift: f64, fixed: &[bool]) -> Result<CholeskyFactor, DynamicsError> {
        if shift.abs() > 0.0 {
            return self.with_combination(shift, fixed, |matrix| self.symbolic.cholesky(matrix, "K + s M"));
        }
        self.symbolic.cholesky_held(self.stiffness.as_ref().as_ref(), fixed, STIFFNESS)
    }

    /// As [`Self::cholesky`] of `K` in single precision; `None` if the matrix is small, a pivot not
    /// positive, or the digits known to be too few.
    pub(super) fn single_precision(
        &self,
        fixed: &[bool],
    ) -> Result<Option<SinglePrecisionFactor>, DynamicsError> {
        if !self.tries_single(&self.digits.known.definite) {
            return Ok(None);
        }
        self.symbolic.check_memory(size_of::<f32>())?;
        let stiffness = self.stiffness.as_ref().as_ref();
        Ok(SinglePrecisionFactor::new(&self.symbolic, stiffness, fixed, Kind::Definite))
    }

    /// Inertia of `K - mu M` on the unknowns that are not `fixed`: how many eigenvalues are below
    /// `mu` [(rad/s)²].
    ///
    /// # Errors
    /// [`DynamicsError::FactorTooLarge`] if memory does not suffice.
    pub fn inertia(&self, mu: f64, fixed: &[bool]) -> Result<Inertia, DynamicsError> {
        Ok(self.with_combination(-mu, fixed, |matrix| self.symbolic.counted_double(matrix))?.0)
    }

    /// As [`Self::inertia`] in single precision; `None` if the matrix is small, or the factor too
    /// inaccurate to count.
    ///
    /// # Errors
    /// [`DynamicsError::FactorTooLarge`] if memory does not suffice.
    pub fn inertia_single(&self, mu: f64, fixed: &[bool]) -> Result<Option<Inertia>, DynamicsError> {
        let counted = self.with_combination(-mu, fixed, |matrix| self.counted_single(matrix))?;
        Ok(counted.map(|(inertia, _)| inertia))
    }

    /// The inertia of `K - mu M` with the factor that tells it: in single precision if the matrix
    /// is large and such a factor accurate enough, in double precision otherwise. No factor if a
    /// pivot vanishes.
    pub(super) fn shifted(&self, mu: f64) -> Result<(Inertia, Option<ShiftedFactor>), DynamicsError> {
        let free = vec![false; self.body.n_unknowns()];
        self.with_combination(-mu, &free, |matrix| match self.counted_single(matrix)? {
            Some((inertia, factor)) => Ok((inertia, Some(factor))),
            None => self.symbolic.counted_double(matrix),
        })
    }

    /// Lower triangle of `K + shift M` on the common pattern, rows and columns of `fixed` unknowns
    /// reduced to their diagonal.
    pub fn combination(&self, shift: f64, fixed: &[bool]) -> SparseColMat<u32, f64> {
        let mut combined = self.stiffness.as_ref().clone();
        combined.val_mut().copy_from_slice(&self.combined_values(shift, fixed));
        combined
    }

    /// Calls `work` with [`Self::combination`], of which only the values are made.
    fn with_combination<R>(
        &self,
        shift: f64,
        fixed: &[bool],
        work: impl FnOnce(SparseColMatRef<'_, u32, f64>) -> R,
    ) -> R {
        let values = self.combined_values(shift, fixed);
        work(SparseColMatRef::new(self.stiffness.symbolic(), &values))
    }

    fn combined_values(&self, shift: f64, fixed: &[bool]) -> Vec<f64> {
        let k = self.stiffness.as_ref();
        let mut values = k.val().to_vec();
        let mass = mass_lower(self.body).val();
        if shift.abs() > 0.0 {
            let is_part = with_mass_places(k, self.body, |place, index| values[place] += shift * mass[index]);
            debug_assert!(is_part, "the pattern holds that of the mass");
        }
        if fixed.contains(&true) {
            for j in 0..k.ncols() {
                for p in k.symbolic().col_range(j) {
                    let i = k.row_idx()[p] as usize;
                    if fixed[i] || fixed[j] {
                        values[p] = if i == j { k.val()[p] } else { 0.0 };
                    }
                }
            }
        }
        values
    }
}

fn mass_lower(body: &AssembledBody) -> &SparseColMat<u32, f64> {
    match &body.mass {
        MassMatrix::PerComponent(m) | MassMatrix::General(m) => m,
    }
}

/// Sizes and finiteness.
fn check(body: &AssembledBody) -> Result<(), DynamicsError> {
    let (n, n_nodes) = (body.dofs.len(), body.nodes.len());
    let (k, m) = (&body.stiffness, mass_lower(body));
    let m_size = if matches!(body.mass, MassMatrix::General(_)) { n } else { n_nodes };
    if n == 0 {
        return Err(DataError::Count { what: "unknowns of the body".into(), found: 0, expected: 1 }.into());
    }
    for (what, matrix, size) in [("K", k, n), ("M", m, m_size)] {
        let found = (matrix.nrows(), matrix.ncols());
        if found != (size, size) {
            return Err(DataError::Size { what: what.into(), found, expected: (size, size) }.into());
        }
    }
    if body.anchors.len() != n_nodes {
        let (what, found) = ("anchors of the nodes".into(), body.anchors.len());
        return Err(DataError::Count { what, found, expected: n_nodes }.into());
    }
    let known = |d: &crate::body::Dof| {
        let n_rotations =
            if matches!(body.mass, MassMatrix::General(_)) { body.motion.n_rotations() } else { 0 };
        (d.node as usize) < n_nodes && (d.component as usize) < body.motion.n_components() + n_rotations
    };
    if let Some(number) = body.dofs.iter().position(|d| !known(d)) {
        let what = "unknowns with a node and component of the model".into();
        return Err(DataError::Index { what, number, count: n }.into());
    }
    if let Some(number) =
        body.dofs.windows(2).position(|d| (d[0].node, d[0].component) >= (d[1].node, d[1].component))
    {
        return Err(
            DataError::Unsorted { what: "the unknowns by node and component", number: number + 1 }.into()
        );
    }
    for (name, matrix) in [("K", k), ("M", m)] {
        for j in 0..matrix.ncols() {
            let mut diagonal = 0.0;
            for (i, &value) in matrix.row_idx_of_col(j).zip(matrix.val_of_col(j)) {
                let fault = match value.is_finite() {
                    true if i >= j => None,
                    true => Some(EntryFault::AboveDiagonal),
                    false => Some(EntryFault::NotFinite(value)),
                };
                if let Some(fault) = fault {
                    return Err(DataError::Entry { matrix: name.into(), row: i, column: j, fault }.into());
                }
                diagonal += if i == j { value } else { 0.0 };
            }
            if diagonal <= 0.0 {
                let fault = EntryFault::NotPositive(diagonal);
                return Err(DataError::Entry { matrix: name.into(), row: j, column: j, fault }.into());
            }
        }
    }
    let anchors = body.anchors.iter().chain(&body.nodes).flatten();
    if anchors.into_iter().any(|x| !x.is_finite()) {
        return Err(DataError::NotFinite { what: "a node or anchor".into() }.into());
    }
    Ok(())
}

/// Checks that `list` names unknowns of the model, each at most once.
pub(crate) fn check_unknowns(list: &[usize], n: usize) -> Result<(), DynamicsError> {
    let mut seen = vec![false; n];
    for &i in list {
        match seen.get_mut(i) {
            Some(slot) if !*slot => *slot = true,
            _ => return Err(DataError::Index { what: "unknowns".into(), number: i, count: n }.into()),
        }
    }
    Ok(())
}

/// Columns of the mass matrix, unknown by unknown: (row, index of the value).
fn mass_column<'b>(
    body: &'b AssembledBody,
    number: &'b [[u32; 6]],
    j: usize,
) -> Box<dyn Iterator<Item = (u32, u32)> + 'b> {
    let m = mass_lower(body);
    match &body.mass {
        MassMatrix::General(_) => Box::new(m.symbolic().col_range(j).map(|p| (m.row_idx()[p], p as u32))),
        MassMatrix::PerComponent(_) => {
            let dof = body.dofs[j];
            let range = m.symbolic().col_range(dof.node as usize);
            let row = move |p: usize| number[m.row_idx()[p] as usize][dof.component as usize];
            Box::new(range.map(move |p| (row(p), p as u32)).filter(|&(i, _)| i != u32::MAX))
        }
    }
}

/// Unknown of every component of every node.
fn numbers(body: &AssembledBody) -> Vec<[u32; 6]> {
    let mut number = vec![[u32::MAX; 6]; body.nodes.len()];
    for (i, dof) in body.dofs.iter().enumerate() {
        number[dof.node as usize][dof.component as usize] = i as u32;
    }
    number
}

/// Stiffness on the union of both patterns.
fn unite(body: &AssembledBody) -> Result<Cow<'_, SparseColMat<u32, f64>>, DynamicsError> {
    if with_mass_places(&body.stiffness, body, |_, _| ()) {
        return Ok(Cow::Borrowed(&body.stiffness));
    }
    let number = numbers(body);
    let k = &body.stiffness;
    let (mut starts, mut rows, mut values) = (vec![0u32], Vec::new(), Vec::new());
    for j in 0..k.ncols() {
        let mut column: Vec<(u32, f64)> =
            k.row_idx_of_col(j).map(|i| i as u32).zip(k.val_of_col(j).iter().copied()).collect();
        column.extend(mass_column(body, &number, j).map(|(i, _)| (i, 0.0)));
        column.sort_by_key(|&(i, _)| i);
        column.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            kept.1 += if same { next.1 } else { 0.0 };
            same
        });
        rows.extend(column.iter().map(|c| c.0));
        values.extend(column.iter().map(|c| c.1));
        starts.push(rows.len() as u32);
    }
    let symbolic = SymbolicSparseColMat::new_checked(k.nrows(), k.ncols(), starts, None, rows);
    let united = SparseColMat::new(symbolic, values);
    match with_mass_places(&united, body, |_, _| ()) {
        true => Ok(Cow::Owned(united)),
        false => Err(DataError::ForeignMass.into()),
    }
}

/// Calls `work` with the place of every mass entry among the values of `k`, whose pattern is sorted,
/// and with its index among those of the mass; false if there is no place for one.
fn with_mass_places(
    k: &SparseColMat<u32, f64>,
    body: &AssembledBody,
    mut work: impl FnMut(usize, usize),
) -> bool {
    let number = numbers(body);
    for j in 0..k.ncols() {
        let range = k.symbolic().col_range(j);
        let mut p = range.start;
        for (row, index) in mass_column(body, &number, j) {
            while p < range.end && k.row_idx()[p] < row {
                p += 1;
            }
            if p == range.end || k.row_idx()[p] != row {
                return false;
            }
            work(p, index as usize);
        }
    }
    true
}
