//! From an unreduced body to its geometric stiffening (docs/theory.md Eq. M.43).
//!
//! The discretisation solves for the stress under each reference load and integrates
//! `∫ ∇R_Aᵀ σ ∇R_B`; loads and the reduction to modal coordinates are found here.

use faer::sparse::SparseColMat;
use faer::{Mat, MatRef};

use super::assembled::{AssembledBody, RigidMotion};
use super::geometric_stiffening::GeometricStiffening;
use super::shape_integrals::{check, gram, symmetric_product};
use crate::data_error::DataError;
use crate::error::DynamicsError;

/// A load per volume on the undeformed body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReferenceLoad {
    /// `ρ e_b`, for an acceleration of 1 m/s².
    Translation {
        /// Direction `b`.
        direction: usize,
    },
    /// `ρ X_a e_b`, for 1/s².
    Position {
        /// Coordinate `a`.
        coordinate: usize,
        /// Direction `b`.
        direction: usize,
    },
}

impl ReferenceLoad {
    /// All loads of a model: 2 + 4 of a plane one, 3 + 9 of a solid one.
    pub fn all(motion: RigidMotion) -> impl Iterator<Item = Self> {
        let n_c = motion.n_components();
        let translations = (0..n_c).map(|direction| Self::Translation { direction });
        let pairs = (0..n_c).flat_map(move |a| (0..n_c).map(move |b| (a, b)));
        translations.chain(pairs.map(|(coordinate, direction)| Self::Position { coordinate, direction }))
    }
}

impl AssembledBody {
    /// Forces of a reference load on the unknowns, by the consistent mass matrix \[N\].
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if sizes do not fit.
    pub fn reference_load(&self, load: ReferenceLoad) -> Result<Vec<f64>, DynamicsError> {
        let Some(mass) = check(self, Mat::<f64>::zeros(self.dofs.len(), 0).as_ref())? else {
            return Ok(self.general_reference_load(load));
        };
        let field = Mat::from_fn(1, self.nodes.len(), |_, a| match load {
            ReferenceLoad::Translation { .. } => 1.0,
            ReferenceLoad::Position { coordinate, .. } => self.nodes[a][coordinate],
        });
        let (ReferenceLoad::Translation { direction } | ReferenceLoad::Position { direction, .. }) = load;
        let nodal = symmetric_product(mass, &field);
        let on = |dof: &super::Dof| {
            if usize::from(dof.component) == direction { nodal[(0, dof.node as usize)] } else { 0.0 }
        };
        Ok(self.dofs.iter().map(on).collect())
    }

    fn general_reference_load(&self, load: ReferenceLoad) -> Vec<f64> {
        let field = match load {
            ReferenceLoad::Translation { direction } => {
                let field = self.rigid_field(self.motion.direction(direction));
                Mat::from_fn(field.len(), 1, |i, _| field[i])
            }
            ReferenceLoad::Position { coordinate, direction } => self.linear_field(coordinate, direction),
        };
        self.mass_product(field.as_ref()).col(0).iter().copied().collect()
    }
}

impl GeometricStiffening {
    /// Modal matrices of the modes `shapes` (n × n_q) from the node by node matrices
    /// `∫ ∇R_Aᵀ σ ∇R_B` (lower triangle), which `stiffness` gives for the stress under each load;
    /// `None` stands for zero.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if sizes do not fit; those of `stiffness`.
    pub fn from_nodal<E: From<DynamicsError>>(
        body: &AssembledBody,
        shapes: MatRef<'_, f64>,
        mut stiffness: impl FnMut(ReferenceLoad) -> Result<Option<SparseColMat<u32, f64>>, E>,
    ) -> Result<Self, E> {
        check(body, shapes)?;
        let (n, n_q, n_c) = (body.nodes.len(), shapes.ncols(), body.motion.n_components());
        // A column per node; rows: the shapes by component and mode.
        let mut fields = Mat::<f64>::zeros(n_c * n_q, n);
        for j in 0..n_q {
            for (row, dof) in body.dofs.iter().enumerate().filter(|(_, d)| (d.component as usize) < n_c) {
                fields[(dof.component as usize * n_q + j, dof.node as usize)] = shapes[(row, j)];
            }
        }
        Self::from_modal(body.motion, n_q, |load| {
            let Some(nodal) = stiffness(load)? else { return Ok(None) };
            check_size(&nodal, n, "control points")?;
            let weighted = symmetric_product(&nodal, &fields);
            let mut modal = Mat::<f64>::zeros(n_q, n_q);
            for c in 0..n_c {
                modal += gram(fields.subrows(c * n_q, n_q), weighted.subrows(c * n_q, n_q));
            }
            Ok(Some(modal))
        })
    }

    /// Sorts the modal matrices of all loads; `None` stands for zero.
    fn from_modal<E: From<DynamicsError>>(
        motion: RigidMotion,
        n_q: usize,
        mut modal: impl FnMut(ReferenceLoad) -> Result<Option<Mat<f64>>, E>,
    ) -> Result<Self, E> {
        let none = || Mat::<f64>::zeros(0, 0);
        let mut all = Self {
            translation: std::array::from_fn(|_| none()),
            position: std::array::from_fn(|_| std::array::from_fn(|_| none())),
        };
        for load in ReferenceLoad::all(motion) {
            let matrix = modal(load)?.unwrap_or_else(|| Mat::zeros(n_q, n_q));
            match load {
                ReferenceLoad::Translation { direction } => all.translation[direction] = matrix,
                ReferenceLoad::Position { coordinate, direction } => {
                    all.position[coordinate][direction] = matrix
                }
            }
        }
        Ok(all)
    }
}

fn check_size(matrix: &SparseColMat<u32, f64>, n: usize, what: &str) -> Result<(), DynamicsError> {
    if matrix.nrows() == n && matrix.ncols() == n {
        return Ok(());
    }
    let what = format!("the geometric stiffness of {what}");
    let found = (matrix.nrows(), matrix.ncols());
    Err(DataError::Size { what, found, expected: (n, n) }.into())
}
