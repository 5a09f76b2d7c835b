//! The modes of one body without coupling, in place of its elastic coordinates (docs/theory.md
//! section M.7).

use faer::Mat;
use nalgebra::ComplexField;

use crate::body::{ModalDamping, ModalMass, StandardInputData};
use crate::error::DynamicsError;
use crate::reduction::blocks::dense;

/// `q = Z z` with `Zᵀ M_e Z = 1` and `Zᵀ K_e Z` diagonal.
#[derive(Debug, Clone)]
pub struct UncoupledModes {
    /// `Z` (n x n) column by column; empty for the identity.
    shapes: Vec<f64>,
    /// `Zᵀ K_e Z` [rad²/s²].
    pub(in crate::system) stiffness: Vec<f64>,
    /// Diagonal of `Zᵀ D_e Z`; the rest is left out [1/s].
    pub(in crate::system) damping: Vec<f64>,
}

impl UncoupledModes {
    /// # Errors
    /// [`DynamicsError`] if the modal mass matrix is not positive definite.
    pub(in crate::system) fn new(data: &StandardInputData) -> Result<Self, DynamicsError> {
        let n = data.n_modes();
        let damping = |i: usize, j: usize| match &data.modal_damping {
            ModalDamping::PerMode(d) if i == j => d[i],
            ModalDamping::None | ModalDamping::PerMode(_) => 0.0,
            ModalDamping::Full(d) => d[(i, j)],
        };
        if data.modal_mass == ModalMass::Identity || n == 0 {
            return Ok(Self {
                shapes: Vec::new(),
                stiffness: data.modal_stiffness.clone(),
                damping: (0..n).map(|j| damping(j, j)).collect(),
            });
        }
        let factor = dense::cholesky(data.modal_mass.to_matrix(n), "modal mass matrix")?;
        let mut whitened = Mat::from_fn(n, n, |i, j| if i == j { data.modal_stiffness[i] } else { 0.0 });
        dense::solve_lower(factor.as_ref(), whitened.as_mut());
        let mut whitened = whitened.transpose().to_owned();
        dense::solve_lower(factor.as_ref(), whitened.as_mut());
        dense::symmetrise(&mut whitened);
        let (stiffness, mut shapes) = dense::symmetric_eigen(whitened.as_ref())?;
        dense::solve_lower_transposed(factor.as_ref(), shapes.as_mut());
        let along = |k: usize| -> f64 {
            let pairs = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
            pairs.map(|(i, j)| shapes[(i, k)] * damping(i, j) * shapes[(j, k)]).sum()
        };
        Ok(Self {
            stiffness,
            damping: (0..n).map(along).collect(),
            shapes: (0..n).flat_map(|k| shapes.col(k).iter().copied().collect::<Vec<_>>()).collect(),
        })
    }

    /// Six rows by elastic coordinates as six rows by modes; a column for each.
    pub(in crate::system) fn columns(&self, by_coordinates: &[[f64; 6]], by_modes: &mut [[f64; 6]]) {
        let n = self.stiffness.len();
        if self.shapes.is_empty() || by_modes.is_empty() {
            by_modes.copy_from_slice(by_coordinates);
            return;
        }
        for (out, shapes) in by_modes.chunks_mut(ABREAST).zip(self.shapes.chunks(ABREAST * n)) {
            let shapes = abreast(shapes, n);
            let mut sums = [[0.0; 6]; ABREAST];
            for (j, column) in by_coordinates.iter().enumerate() {
                for (sum, shape) in sums.iter_mut().zip(&shapes) {
                    sum.iter_mut().zip(column).for_each(|(s, c)| *s += shape[j] * c);
                }
            }
            out.copy_from_slice(&sums[..out.len()]);
        }
    }

    /// Forces on elastic coordinates as forces on modes.
    pub(in crate::system) fn forces<T>(&self, forces: &[T], out: &mut [T])
    where
        T: ComplexField<RealField = f64> + Copy,
    {
        if self.shapes.is_empty() {
            out.copy_from_slice(forces);
            return;
        }
        for (out, shapes) in out.chunks_mut(ABREAST).zip(self.shapes.chunks(ABREAST * forces.len())) {
            let shapes = abreast(shapes, forces.len());
            let mut sums = [T::zero(); ABREAST];
            for (j, force) in forces.iter().enumerate() {
                sums.iter_mut().zip(&shapes).for_each(|(sum, shape)| *sum += force.scale(shape[j]));
            }
            out.copy_from_slice(&sums[..out.len()]);
        }
    }

    /// Sets `out` to the elastic coordinates of the modes `modes`.
    pub(in crate::system) fn coordinates<T>(&self, modes: &[T], out: &mut [T])
    where
        T: ComplexField<RealField = f64> + Copy,
    {
        if self.shapes.is_empty() {
            out.copy_from_slice(modes);
            return;
        }
        out.fill(T::zero());
        let n = out.len();
        for (modes, shapes) in modes.chunks(ABREAST).zip(self.shapes.chunks(ABREAST * n)) {
            let shapes = abreast(shapes, n);
            let mut weights = [T::zero(); ABREAST];
            weights[..modes.len()].copy_from_slice(modes);
            for (j, o) in out.iter_mut().enumerate() {
                *o += weights.iter().zip(&shapes).fold(T::zero(), |sum, (m, shape)| sum + m.scale(shape[j]));
            }
        }
    }
}

/// Modes taken side by side: their sums do not wait for each other.
const ABREAST: usize = 4;

/// The next modes of `n` coordinates each; past the last one that again, whose sum nobody takes.
fn abreast(shapes: &[f64], n: usize) -> [&[f64]; ABREAST] {
    let last = shapes.len() / n - 1;
    std::array::from_fn(|k| &shapes[k.min(last) * n..][..n])
}
