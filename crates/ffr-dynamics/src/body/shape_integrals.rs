//! Inertia integrals from the consistent mass matrix (docs/theory.md Eq. D.4).
//!
//! A discretised displacement field with one scalar mass matrix `m_AB` for all components turns
//! every integral over the body into a sum over pairs of control points, without further
//! quadrature: the result is exact for the discretisation.

use faer::linalg::matmul::matmul;
use faer::sparse::SparseColMat;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::{Matrix3, Vector3};

use super::assembled::{AssembledBody, MassMatrix, RigidMotion};
use crate::data_error::DataError;
use crate::error::DynamicsError;

/// Moments of the mass over undeformed positions `X` and mode shapes `φ_j`, in the body's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeIntegrals {
    /// `∫ ρ` \[kg\].
    pub mass: f64,
    /// `∫ ρ X` \[kg m\].
    pub mass_moment: Vector3<f64>,
    /// `∫ ρ X Xᵀ` [kg m²].
    pub second_moment: Matrix3<f64>,
    /// `∫ ρ φ_j`, one vector per mode.
    pub shapes: Vec<Vector3<f64>>,
    /// `∫ ρ X_a φ_jb` at `(a n_c + b) n_q + j`; empty for axial models, which do not turn.
    pub position_shape: Vec<f64>,
    /// `∫ ρ φ_ia φ_jb` at `i n_c² n_q + (a n_c + b) n_q + j`; empty for axial models.
    pub shape_shape: Vec<f64>,
    /// `∫ ρ φ_i · φ_j`, the modal mass matrix.
    pub modal_mass: Mat<f64>,
}

impl ShapeIntegrals {
    /// Integrals of a model whose modes are the columns of `shapes` (n × n_q).
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if sizes do not fit, a number is not finite or the mass is not positive.
    pub fn new(body: &AssembledBody, shapes: MatRef<'_, f64>) -> Result<Self, DynamicsError> {
        let Some(mass) = check(body, shapes)? else {
            return body.general_integrals(shapes).with_positive_mass();
        };
        let (n, n_q, n_c) = (body.nodes.len(), shapes.ncols(), body.motion.n_components());
        // A column per node; rows: one, the positions by component, the shapes by component and
        // mode.
        let mut fields = Mat::<f64>::zeros(1 + n_c + n_c * n_q, n);
        for (node, x) in body.nodes.iter().enumerate() {
            fields[(0, node)] = 1.0;
            for (c, value) in x.iter().take(n_c).enumerate() {
                fields[(1 + c, node)] = *value;
            }
        }
        for j in 0..n_q {
            for (row, dof) in body.dofs.iter().enumerate() {
                fields[(1 + n_c + dof.component as usize * n_q + j, dof.node as usize)] = shapes[(row, j)];
            }
        }
        let weighted = symmetric_product(mass, &fields);
        Self::from_fields(body.motion, n_q, fields.as_ref(), weighted.as_ref()).with_positive_mass()
    }

    fn with_positive_mass(self) -> Result<Self, DynamicsError> {
        if self.mass > 0.0 && self.mass.is_finite() {
            return Ok(self);
        }
        Err(DataError::OutOfRange { what: "the mass [kg]".into(), value: self.mass, range: "> 0" }.into())
    }

    /// Sorts the products of fields and fields times mass into the integrals.
    fn from_fields(
        motion: RigidMotion,
        n_q: usize,
        fields: MatRef<'_, f64>,
        weighted: MatRef<'_, f64>,
    ) -> Self {
        let n_c = motion.n_components();
        let rigid = gram(fields.subrows(0, 1 + n_c), weighted);
        let shape = |c: usize, j: usize| 1 + n_c + c * n_q + j;
        let mut mass_moment = Vector3::zeros();
        let mut second_moment = Matrix3::zeros();
        for a in 0..n_c {
            mass_moment[motion.direction(a)] = rigid[(0, 1 + a)];
            for b in 0..n_c {
                second_moment[(motion.direction(a), motion.direction(b))] =
                    0.5 * (rigid[(1 + a, 1 + b)] + rigid[(1 + b, 1 + a)]);
            }
        }
        let mut shapes = vec![Vector3::zeros(); n_q];
        for (j, s) in shapes.iter_mut().enumerate() {
            for c in 0..n_c {
                s[motion.direction(c)] = rigid[(0, shape(c, j))];
            }
        }
        let block =
            |a: usize, b: usize| gram(fields.subrows(shape(a, 0), n_q), weighted.subrows(shape(b, 0), n_q));
        let mut modal_mass = Mat::zeros(n_q, n_q);
        (0..n_c).for_each(|c| modal_mass += block(c, c));
        let (mut position_shape, mut shape_shape) = (Vec::new(), Vec::new());
        if motion == RigidMotion::Axial {
            // Around the circumference radial quantities have no mean, and their squares share
            // between x and y.
            mass_moment.x = 0.0;
            let radial = 0.5 * second_moment[(0, 0)];
            second_moment = Matrix3::from_diagonal(&Vector3::new(radial, radial, second_moment[(2, 2)]));
            shapes.iter_mut().for_each(|s| s.x = 0.0);
        } else {
            let size = n_c * n_c * n_q;
            shape_shape.resize(n_q * size, 0.0);
            for ab in 0..n_c * n_c {
                let (a, b) = (ab / n_c, ab % n_c);
                position_shape.extend((0..n_q).map(|j| rigid[(1 + a, shape(b, j))]));
                let (forth, back) = (block(a, b), block(b, a));
                for i in 0..n_q {
                    for j in 0..n_q {
                        // Both are the same but for round-off; the mean makes the gyroscopic terms
                        // free of work.
                        shape_shape[i * size + ab * n_q + j] = 0.5 * (forth[(i, j)] + back[(j, i)]);
                    }
                }
            }
        }
        let mass = rigid[(0, 0)];
        Self { mass, mass_moment, second_moment, shapes, position_shape, shape_shape, modal_mass }
    }
}

/// `left rightᵀ`.
pub(super) fn gram(left: MatRef<'_, f64>, right: MatRef<'_, f64>) -> Mat<f64> {
    let mut product = Mat::<f64>::zeros(left.nrows(), right.nrows());
    matmul(product.as_mut(), Accum::Replace, left, right.transpose(), 1.0, Par::Seq);
    product
}

/// Refuses models whose parts do not fit; returns the mass matrix if it is node by node.
pub(super) fn check<'a>(
    body: &'a AssembledBody,
    shapes: MatRef<'_, f64>,
) -> Result<Option<&'a SparseColMat<u32, f64>>, DynamicsError> {
    let (n, n_nodes, n_c) = (body.dofs.len(), body.nodes.len(), body.motion.n_components());
    let (mass, size, n_dof) = match &body.mass {
        MassMatrix::PerComponent(mass) => (mass, n_nodes, n_c),
        MassMatrix::General(mass) => (mass, n, n_c + body.motion.n_rotations()),
    };
    if shapes.nrows() != n {
        let (what, found) = ("rows of the mode shapes".into(), shapes.nrows());
        return Err(DataError::Count { what, found, expected: n }.into());
    }
    if mass.nrows() != size || mass.ncols() != size {
        let (what, found) = ("the mass matrix".into(), (mass.nrows(), mass.ncols()));
        return Err(DataError::Size { what, found, expected: (size, size) }.into());
    }
    let is_outside = |d: &&super::Dof| d.node as usize >= n_nodes || d.component as usize >= n_dof;
    if let Some(dof) = body.dofs.iter().find(is_outside) {
        let what = format!("unknowns of component {}, control point", dof.component);
        return Err(DataError::Index { what, number: dof.node as usize, count: n_nodes }.into());
    }
    let is_finite = (0..shapes.ncols()).all(|j| (0..n).all(|i| shapes[(i, j)].is_finite()))
        && body.nodes.iter().flatten().all(|x| x.is_finite());
    if is_finite {
        Ok(matches!(body.mass, MassMatrix::PerComponent(_)).then_some(mass))
    } else {
        Err(DataError::NotFinite { what: "a mode shape or control point".into() }.into())
    }
}

/// `fields M` with `M` given by its lower triangle; a column per node.
pub(super) fn symmetric_product(lower: &SparseColMat<u32, f64>, fields: &Mat<f64>) -> Mat<f64> {
    let mut product = Mat::<f64>::zeros(fields.nrows(), fields.ncols());
    let (symbolic, values) = (lower.symbolic(), lower.val());
    for j in 0..lower.ncols() {
        let range = symbolic.col_range(j);
        for (&i, &m) in symbolic.row_idx()[range.clone()].iter().zip(&values[range]) {
            let i = i as usize;
            if i < j {
                continue; // entries above the diagonal, if stored, repeat those below
            }
            add_multiple(&mut product, i, m, fields, j);
            if i != j {
                add_multiple(&mut product, j, m, fields, i);
            }
        }
    }
    product
}

/// `target[:, to] += factor source[:, from]`.
fn add_multiple(target: &mut Mat<f64>, to: usize, factor: f64, source: &Mat<f64>, from: usize) {
    let (target, source) = (target.col_as_slice_mut(to), source.col_as_slice(from));
    for (t, s) in target.iter_mut().zip(source) {
        *t += factor * s;
    }
}
