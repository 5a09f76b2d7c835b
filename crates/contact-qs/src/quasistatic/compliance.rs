//! Compliance of the points of a zone, as an operator.
//!
//! What the points yield is `C = N_b G N_bᵀ` (docs/theory.md Eq. C.2). Where the points have more
//! components than the interface has unknowns, as Gauss points and those of whole surfaces have, `C`
//! is of low rank and not formed: its product with the point forces is one with the sparse `N_bᵀ`,
//! one with `G`, and one with the sparse `N_b`.

use faer::Mat;
use ffr_dynamics::data_error::{DataError, check_square};

pub mod sparse_rows;

use super::problem::{add_columns, add_product};
use sparse_rows::SparseRows;

/// Compliance of the points of a zone.
#[derive(Debug, Clone, PartialEq)]
pub enum ZoneCompliance {
    /// `C`, rows and columns `n_components * point + component` [m/N]; zero-sized when all modes are
    /// dynamic.
    Points(Mat<f64>),
    /// `G` of the interface in terms of which the points' functions are given [m/N].
    Interface(Mat<f64>),
}

impl ZoneCompliance {
    /// The compliance of a body whose modes are all dynamic.
    pub fn none() -> Self {
        Self::Points(Mat::zeros(0, 0))
    }

    /// Whether there is any.
    pub fn is_some(&self) -> bool {
        let (Self::Points(matrix) | Self::Interface(matrix)) = self;
        matrix.nrows() > 0
    }

    /// Checks the size for points with the rows `functions`, `n_rows` in all.
    pub(crate) fn check(&self, functions: &SparseRows, n_rows: usize) -> Result<(), DataError> {
        match self {
            Self::Points(matrix) => {
                check_square("the compliance of the contact points", matrix.as_ref(), n_rows)
            }
            Self::Interface(matrix) => {
                let n_b = functions.n_columns();
                check_square("the compliance of the interface", matrix.as_ref(), n_b)?;
                let (what, found) = ("rows of interface functions".to_owned(), functions.n_rows());
                if found == n_rows { Ok(()) } else { Err(DataError::Count { what, found, expected: n_rows }) }
            }
        }
    }

    /// `C` of points with the rows `functions`, exactly symmetric.
    pub fn of_points(&self, functions: &SparseRows) -> Mat<f64> {
        let compliance = match self {
            Self::Points(matrix) => return matrix.clone(),
            Self::Interface(matrix) => matrix,
        };
        let (n, n_b) = (functions.n_rows(), functions.n_columns());
        // G N_bᵀ, column by column.
        let mut half = Mat::<f64>::zeros(n_b, n);
        for j in 0..n {
            add_columns(compliance, functions.row(j).iter().copied(), half.col_as_slice_mut(j));
        }
        let mut full =
            Mat::from_fn(n, n, |i, j| functions.row(i).iter().map(|&(b, value)| value * half[(b, j)]).sum());
        for j in 0..n {
            for i in 0..j {
                let mean: f64 = 0.5 * (full[(i, j)] + full[(j, i)]);
                full[(i, j)] = mean;
                full[(j, i)] = mean;
            }
        }
        full
    }
}

impl From<Mat<f64>> for ZoneCompliance {
    fn from(points: Mat<f64>) -> Self {
        Self::Points(points)
    }
}

/// Surfaces under points.
pub(crate) trait Surfaces {
    /// Number of their unknowns.
    fn n_unknowns(&self) -> usize;

    /// Passes each unknown, and its share in the displacement of point `i` along direction `d` (0: normal), to `entry`.
    fn row(&self, i: usize, d: usize, entry: &mut dyn FnMut(usize, f64));

    /// Displacement of unknown `i` under a unit force on unknown `j` [m/N].
    fn compliance(&self, i: usize, j: usize) -> f64;
}

/// The product with the compliance of points, in the smaller of its two forms.
pub(crate) struct Yielding {
    /// Rows of the points; none where `matrix` is `C` itself.
    functions: Option<SparseRows>,
    matrix: Mat<f64>,
}

impl Yielding {
    /// The compliance of points with the rows `functions`; `is_formed`: whether `C` is needed
    /// itself.
    pub fn new(compliance: ZoneCompliance, functions: &SparseRows, is_formed: bool) -> Self {
        match compliance {
            ZoneCompliance::Interface(matrix) if !is_formed && matrix.nrows() < functions.n_rows() => {
                Self { functions: Some(functions.clone()), matrix }
            }
            other => Self { functions: None, matrix: other.of_points(functions) },
        }
    }

    /// `C`, or the core `G` of its product.
    pub fn matrix(&self) -> &Mat<f64> {
        &self.matrix
    }

    /// Passes each row of the matrix, and its share in the component `row` of the points, to `entry`.
    pub fn row(&self, row: usize, factor: f64, entry: &mut dyn FnMut(usize, f64)) {
        match &self.functions {
            None if self.matrix.nrows() == 0 => {}
            None => entry(row, factor),
            Some(functions) => functions.row(row).iter().for_each(|&(b, value)| entry(b, factor * value)),
        }
    }

    /// Replaces `half`, as long as [`Self::matrix`], by its answer to `loads`, components of forces on
    /// rows of the points.
    pub fn load(&self, loads: impl Iterator<Item = (usize, f64)>, half: &mut [f64]) {
        if half.is_empty() {
            return;
        }
        half.fill(0.0);
        match &self.functions {
            None => add_columns(&self.matrix, loads, half),
            Some(functions) => {
                let share = |(row, load): (usize, f64)| {
                    functions.row(row).iter().map(move |&(b, value)| (b, value * load))
                };
                add_columns(&self.matrix, loads.flat_map(share), half);
            }
        }
    }

    /// Displacement in the component `row` of the points, of which `half` is the answer of the
    /// matrix.
    pub fn displacement(&self, row: usize, half: &[f64]) -> f64 {
        match &self.functions {
            None => half[row],
            Some(functions) => functions.row(row).iter().map(|&(b, value)| value * half[b]).sum(),
        }
    }

    /// Replaces `out` by the displacements of the points under `loads`, one for each row; `buffers`
    /// are as long as the matrix.
    pub fn displacements(&self, loads: &[f64], buffers: &mut [Vec<f64>; 2], out: &mut [f64]) {
        let Some(functions) = &self.functions else {
            out.fill(0.0);
            return add_product(&self.matrix, loads, out);
        };
        let [shares, half] = buffers;
        functions.spread(loads, shares);
        half.fill(0.0);
        add_product(&self.matrix, shares, half);
        out.iter_mut().enumerate().for_each(|(row, u)| *u = self.displacement(row, half));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_yield_alike() {
        let mut seed = 3_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        let (n, n_b) = (12, 7);
        let v = Mat::from_fn(n_b, n_b, |_, _| random());
        let g = &v * v.transpose();
        let mut functions = SparseRows::new(n_b);
        (0..n).for_each(|row| functions.push([(row % n_b, random()), ((row + 3) % n_b, random())]));
        let zone = ZoneCompliance::Interface(g);
        let formed = Yielding::new(zone.clone(), &functions, true);
        let applied = Yielding::new(zone, &functions, false);
        assert!(formed.functions.is_none() && applied.functions.is_some());
        // Points without force have no share.
        let loads: Vec<f64> = (0..n).map(|row| if row % 3 == 0 { 0.0 } else { random() }).collect();
        let of = |yielding: &Yielding| {
            let m = yielding.matrix().nrows();
            let (mut buffers, mut out) = ([vec![1.0; m], vec![1.0; m]], vec![1.0; n]);
            yielding.displacements(&loads, &mut buffers, &mut out);
            let mut half = vec![1.0; m];
            yielding.load(loads.iter().copied().enumerate(), &mut half);
            let each: Vec<f64> = (0..n).map(|row| yielding.displacement(row, &half)).collect();
            (out, each)
        };
        let ((a, b), (c, d)) = (of(&formed), of(&applied));
        // Round-off of sums of some ten terms of order one.
        for other in [b, c, d] {
            assert!(a.iter().zip(&other).all(|(x, y)| (x - y).abs() < 1e-13));
        }
        // Where the points are fewer, their own compliance is the smaller one.
        let few = Yielding::new(ZoneCompliance::Points(Mat::zeros(2, 2)), &SparseRows::new(0), false);
        assert!(few.functions.is_none());
    }
}
