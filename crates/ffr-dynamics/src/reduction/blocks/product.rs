//! Products of the stored lower triangles with blocks of vectors.
//!
//! Columns are gathered so that the values which meet one matrix entry are neighbours in memory;
//! for [`MassMatrix::PerComponent`] the displacement components of a node travel together, too. One
//! pass over the stored triangle then serves 8 or 12 numbers per entry.

use faer::sparse::SparseColMatRef;
use faer::{Mat, MatMut, MatRef};

use crate::body::{AssembledBody, MassMatrix};

/// Columns that are multiplied in one pass over a matrix of unknowns, and of nodes.
const COLUMNS: usize = 8;
const NODE_COLUMNS: usize = 4;
/// Entries of a matrix from which groups of columns are multiplied side by side: a tenth of a
/// millisecond each.
const MIN_PARALLEL: usize = 50_000;

impl AssembledBody {
    /// Number of unknowns.
    pub fn n_unknowns(&self) -> usize {
        self.dofs.len()
    }

    /// Product `M x` with the consistent mass matrix; `x` and the result are n x k.
    ///
    /// # Panics
    /// If `x` has not one row per unknown.
    pub fn mass_product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut y = Mat::zeros(x.nrows(), x.ncols());
        match &self.mass {
            MassMatrix::General(m) => symmetric_product(m.as_ref(), x, y.as_mut()),
            MassMatrix::PerComponent(m) => {
                let place = |i: usize| (self.dofs[i].node as usize, self.dofs[i].component as usize);
                match self.motion.n_components() {
                    2 => gathered::<NODE_COLUMNS, 8>(m.as_ref(), place, x, y.as_mut()),
                    _ => gathered::<NODE_COLUMNS, 12>(m.as_ref(), place, x, y.as_mut()),
                }
            }
        }
        y
    }

    /// Product `K x` with the stiffness matrix; `x` and the result are n x k.
    ///
    /// # Panics
    /// If `x` has not one row per unknown.
    pub fn stiffness_product(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        let mut y = Mat::zeros(x.nrows(), x.ncols());
        symmetric_product(self.stiffness.as_ref(), x, y.as_mut());
        y
    }
}

/// Product `y = A x` with a symmetric matrix of which the lower triangle is stored.
///
/// # Panics
/// If the sizes differ.
pub fn symmetric_product(lower: SparseColMatRef<'_, u32, f64>, x: MatRef<'_, f64>, y: MatMut<'_, f64>) {
    assert_eq!(lower.nrows(), x.nrows(), "matrix and vectors differ in size");
    gathered::<COLUMNS, COLUMNS>(lower, |i| (i, 0), x, y);
}

/// Multiplies columns in groups of `C`, groups of large matrices side by side: `place` names the
/// matrix row and the component of each unknown.
fn gathered<const C: usize, const W: usize>(
    lower: SparseColMatRef<'_, u32, f64>,
    place: impl Fn(usize) -> (usize, usize) + Copy + Sync,
    x: MatRef<'_, f64>,
    y: MatMut<'_, f64>,
) {
    if x.ncols() > C && lower.val().len() >= MIN_PARALLEL {
        let half = x.ncols().div_ceil(C) / 2 * C;
        let (left, right) = y.split_at_col_mut(half);
        let (x_left, x_right) = x.split_at_col(half);
        rayon::join(
            || gathered::<C, W>(lower, place, x_left, left),
            || gathered::<C, W>(lower, place, x_right, right),
        );
        return;
    }
    let mut y = y;
    let mut from = vec![[0.0; W]; lower.nrows()];
    let mut to = vec![[0.0; W]; lower.nrows()];
    let arch = pulp::Arch::new();
    for first in (0..x.ncols()).step_by(C) {
        let width = C.min(x.ncols() - first);
        for c in 0..width {
            for (i, &value) in x.col(first + c).iter().enumerate() {
                let (row, component) = place(i);
                from[row][C * component + c] = value;
            }
        }
        to.fill([0.0; W]);
        arch.dispatch(Multiply { lower, from: &from, to: &mut to });
        for c in 0..width {
            for (i, value) in y.as_mut().col_mut(first + c).iter_mut().enumerate() {
                let (row, component) = place(i);
                *value = to[row][C * component + c];
            }
        }
    }
}

/// [`multiply`] compiled for the vector registers that the processor has.
struct Multiply<'a, const W: usize> {
    lower: SparseColMatRef<'a, u32, f64>,
    from: &'a [[f64; W]],
    to: &'a mut [[f64; W]],
}

impl<const W: usize> pulp::NullaryFnOnce for Multiply<'_, W> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        multiply(self.lower, self.from, self.to);
    }
}

/// One pass over the lower triangle: every stored entry below the diagonal acts twice.
#[inline(always)]
fn multiply<const W: usize>(lower: SparseColMatRef<'_, u32, f64>, from: &[[f64; W]], to: &mut [[f64; W]]) {
    for j in 0..lower.ncols() {
        let x_j = from[j];
        let mut sum = [0.0; W];
        for (i, &a) in lower.row_idx_of_col(j).zip(lower.val_of_col(j)) {
            if i == j {
                for k in 0..W {
                    sum[k] += a * x_j[k];
                }
            } else {
                let (x_i, y_i) = (&from[i], &mut to[i]);
                for k in 0..W {
                    y_i[k] += a * x_j[k];
                    sum[k] += a * x_i[k];
                }
            }
        }
        for k in 0..W {
            to[j][k] += sum[k];
        }
    }
}
