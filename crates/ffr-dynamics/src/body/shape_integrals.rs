//! Inertia integrals from the consistent mass matrix (docs/theory.md Eq. D.4).
//!
//! A discretised displacement field with one scalar mass matrix `m_AB` for all components turns every integral over the
//! body into a sum over pairs of control points, without further quadrature: the result is exact for the discretisation.

use faer::linalg::matmul::matmul;
use faer::sparse::SparseColMat;
use faer::{Accum, Mat, MatRef, Par};
use nalgebra::{Matrix3, Vector3};

use super::assembled::{AssembledBody, MassMatrix, RigidMotion};
use crate::error::DynamicsError;

/// Moments of the mass over undeformed positions `X` and mode shapes `φ_j`, in the body's frame.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeIntegrals {
    /// `∫ ρ` [kg].
    pub mass: f64,
    /// `∫ ρ X` [kg m].
    pub mass_moment: Vector3<f64>,
    /// `∫ ρ X Xᵀ` [kg m²].
    pub second_moment: Matrix3<f64>,
    /// `∫ ρ φ_j`, one vector a mode.
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
    /// [`DynamicsError::Inconsistent`] if sizes do not fit, a number is not finite, the mass is not positive, or the
    /// mass matrix is not of the kind [`MassMatrix::PerComponent`].
    pub fn new(body: &AssembledBody, shapes: MatRef<'_, f64>) -> Result<Self, DynamicsError> {
        let mass = check(body, shapes)?;
        let (n, n_q, n_c) = (body.nodes.len(), shapes.ncols(), body.motion.n_components());
        // Columns: one, the positions by component, the shapes by component and mode.
        let mut fields = Mat::<f64>::zeros(n, 1 + n_c + n_c * n_q);
        for (node, x) in body.nodes.iter().enumerate() {
            fields[(node, 0)] = 1.0;
            for (c, value) in x.iter().take(n_c).enumerate() {
                fields[(node, 1 + c)] = *value;
            }
        }
        for j in 0..n_q {
            for (row, dof) in body.dofs.iter().enumerate() {
                fields[(dof.node as usize, 1 + n_c + dof.component as usize * n_q + j)] = shapes[(row, j)];
            }
        }
        let weighted = symmetric_product(mass, &fields);
        let mut gram = Mat::<f64>::zeros(fields.ncols(), fields.ncols());
        matmul(gram.as_mut(), Accum::Replace, fields.transpose(), weighted.as_ref(), 1.0, Par::Seq);
        let integrals = Self::from_gram(body.motion, n_q, gram.as_ref());
        if !(integrals.mass > 0.0 && integrals.mass.is_finite()) {
            return Err(inconsistent(format!("the mass is {} kg, must be > 0", integrals.mass)));
        }
        Ok(integrals)
    }

    /// Sorts the products of all pairs of fields into the integrals.
    fn from_gram(motion: RigidMotion, n_q: usize, gram: MatRef<'_, f64>) -> Self {
        let n_c = motion.n_components();
        let shape = |c: usize, j: usize| 1 + n_c + c * n_q + j;
        let mut mass_moment = Vector3::zeros();
        let mut second_moment = Matrix3::zeros();
        let mut modal_mass = Mat::zeros(n_q, n_q);
        for a in 0..n_c {
            mass_moment[motion.direction(a)] = gram[(0, 1 + a)];
            for b in 0..n_c {
                second_moment[(motion.direction(a), motion.direction(b))] =
                    0.5 * (gram[(1 + a, 1 + b)] + gram[(1 + b, 1 + a)]);
            }
            for j in 0..n_q {
                for i in 0..n_q {
                    modal_mass[(i, j)] +=
                        0.5 * (gram[(shape(a, i), shape(a, j))] + gram[(shape(a, j), shape(a, i))]);
                }
            }
        }
        let mut shapes = vec![Vector3::zeros(); n_q];
        for (j, s) in shapes.iter_mut().enumerate() {
            for c in 0..n_c {
                s[motion.direction(c)] = gram[(0, shape(c, j))];
            }
        }
        let (mut position_shape, mut shape_shape) = (Vec::new(), Vec::new());
        if motion == RigidMotion::Axial {
            // Around the circumference radial quantities have no mean, and their squares share between x and y.
            mass_moment.x = 0.0;
            let radial = second_moment[(0, 0)];
            second_moment =
                Matrix3::from_diagonal(&Vector3::new(0.5 * radial, 0.5 * radial, second_moment[(2, 2)]));
            shapes.iter_mut().for_each(|s| s.x = 0.0);
        } else {
            for ab in 0..n_c * n_c {
                position_shape.extend((0..n_q).map(|j| gram[(1 + ab / n_c, shape(ab % n_c, j))]));
            }
            for i in 0..n_q {
                for ab in 0..n_c * n_c {
                    let (row, b) = (shape(ab / n_c, i), ab % n_c);
                    shape_shape.extend(
                        (0..n_q).map(|j| 0.5 * (gram[(row, shape(b, j))] + gram[(shape(b, j), row)])),
                    );
                }
            }
        }
        let mass = gram[(0, 0)];
        Self { mass, mass_moment, second_moment, shapes, position_shape, shape_shape, modal_mass }
    }
}

/// Refuses models whose parts do not fit; returns the node by node mass matrix.
fn check<'a>(
    body: &'a AssembledBody,
    shapes: MatRef<'_, f64>,
) -> Result<&'a SparseColMat<u32, f64>, DynamicsError> {
    let (n, n_nodes, n_c) = (body.dofs.len(), body.nodes.len(), body.motion.n_components());
    let MassMatrix::PerComponent(mass) = &body.mass else {
        return Err(inconsistent("inertia integrals need a mass matrix node by node".to_string()));
    };
    if shapes.nrows() != n {
        return Err(inconsistent(format!(
            "mode shapes have {} rows, the model has {n} unknowns",
            shapes.nrows()
        )));
    }
    if mass.nrows() != n_nodes || mass.ncols() != n_nodes {
        return Err(inconsistent(format!(
            "mass matrix of size {} for {n_nodes} control points",
            mass.nrows()
        )));
    }
    let is_outside = |d: &&super::Dof| d.node as usize >= n_nodes || d.component as usize >= n_c;
    if let Some(dof) = body.dofs.iter().find(is_outside) {
        return Err(inconsistent(format!(
            "unknown of control point {}, component {}",
            dof.node, dof.component
        )));
    }
    let is_finite = (0..shapes.ncols()).all(|j| (0..n).all(|i| shapes[(i, j)].is_finite()))
        && body.nodes.iter().flatten().all(|x| x.is_finite());
    if is_finite {
        Ok(mass)
    } else {
        Err(inconsistent("mode shapes or control points are not finite".to_string()))
    }
}

fn inconsistent(reason: String) -> DynamicsError {
    DynamicsError::Inconsistent { reason }
}

/// `M fields` with `M` given by its lower triangle.
fn symmetric_product(lower: &SparseColMat<u32, f64>, fields: &Mat<f64>) -> Mat<f64> {
    let mut product = Mat::<f64>::zeros(fields.nrows(), fields.ncols());
    let (symbolic, values) = (lower.symbolic(), lower.val());
    for column in 0..fields.ncols() {
        let (x, y) = (fields.col(column), &mut product.as_mut().col_mut(column));
        for j in 0..lower.ncols() {
            let range = symbolic.col_range(j);
            for (&i, &m) in symbolic.row_idx()[range.clone()].iter().zip(&values[range]) {
                let i = i as usize;
                if i < j {
                    continue; // entries above the diagonal, if stored, repeat those below
                }
                y[i] += m * x[j];
                if i != j {
                    y[j] += m * x[i];
                }
            }
        }
    }
    product
}
