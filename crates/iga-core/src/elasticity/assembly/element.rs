//! Phase one of the assembly: Gram products of one element's basis.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};

use crate::SplineError;
use crate::elasticity::mapping::PointMap;
use crate::elasticity::{Material, Model};
use crate::space::{GridBasis, Integrand, Space};

/// Columns of a Gram product that are computed at once; rows above such a block are left out.
const GRAM_BLOCK: usize = 48;

/// What one element hands to phase two. Functions are sorted by their global number.
#[derive(Default)]
pub(crate) struct ElementProducts {
    /// Global numbers of the functions, rising.
    pub nodes: Vec<u32>,
    /// Gradient products `H = ∫ g_A,i g_B,j dV`, column-major of size `(n_rows n)²`, entry `(A, i)`
    /// at `n_rows A + i`. `g` are the physical derivatives and, axisymmetric, `R / r` as third row.
    /// Valid for `A >= B`.
    pub gradients: Vec<f64>,
    /// Lamé constants of the model there \[Pa\] and density [kg/m³].
    pub constants: (f64, f64, f64),
    /// Value products `∫ R_A R_B dV`, column-major `n x n`, valid for `A >= B`.
    pub values: Vec<f64>,
}

impl ElementProducts {
    /// Gives back memory beyond `bytes`.
    pub fn shrink_to(&mut self, bytes: usize) {
        for buffer in [&mut self.gradients, &mut self.values] {
            if size_of::<f64>() * buffer.capacity() > bytes {
                *buffer = Vec::new();
            }
        }
    }
}

/// Buffers of one worker.
#[derive(Default)]
pub(crate) struct Workspace {
    basis: GridBasis,
    active: Vec<u32>,
    place: Vec<usize>,
    order: Vec<usize>,
    nodes: Vec<[f64; 3]>,
    gradients: Vec<f64>,
    values: Vec<f64>,
    roots: Vec<f64>,
}

/// Rows a function has in the gradient products.
pub(crate) fn n_rows(model: &Model) -> usize {
    match model {
        Model::PlaneStrain { .. } | Model::PlaneStress { .. } => 2,
        Model::Axisymmetric | Model::Solid => 3,
    }
}

impl Workspace {
    /// Fills `out` with the products of element `e`, which is of `material`.
    ///
    /// # Errors
    /// [`SplineError::Folded`] where the Jacobian determinant is not positive, [`SplineError::Radius`] where a point of an
    /// axisymmetric body does not have a positive radius.
    pub fn products(
        &mut self,
        space: &dyn Space,
        model: &Model,
        material: &Material,
        e: usize,
        out: &mut ElementProducts,
    ) -> Result<(), SplineError> {
        let (lambda, mu) = model.lame(material);
        out.constants = (lambda, mu, material.density());
        self.evaluate(space, model, (e, Integrand::Stiffness), &mut out.nodes)?;
        let n = self.active.len();
        gram(&self.gradients, n_rows(model) * n, self.basis.n_points, &mut out.gradients);
        if !space.has_one_rule(e) {
            self.evaluate(space, model, (e, Integrand::Mass), &mut out.nodes)?;
        }
        gram(&self.values, n, self.basis.n_points, &mut out.values);
        Ok(())
    }

    /// Values and gradients of the functions of element `e` at the points of a rule, times the root
    /// of the volume that each point stands for; `nodes` receives their global numbers, rising.
    ///
    /// # Errors
    /// As [`Workspace::products`].
    pub fn evaluate(
        &mut self,
        space: &dyn Space,
        model: &Model,
        (e, integrand): (usize, Integrand),
        nodes: &mut Vec<u32>,
    ) -> Result<(), SplineError> {
        space.tabulate(e, integrand, &mut self.basis);
        self.sort_functions(space, e, nodes);
        let (n, rows) = (self.active.len(), n_rows(model));
        self.gradients.resize(rows * n * self.basis.n_points, 0.0);
        self.values.resize(n * self.basis.n_points, 0.0);
        self.roots.resize(self.basis.n_points, 0.0);
        (0..self.basis.n_points).try_for_each(|q| self.point(model, q))
    }

    /// Number of Gauss points of the element evaluated last.
    pub fn n_points(&self) -> usize {
        self.basis.n_points
    }

    /// Physical gradients at point `q` of the element evaluated last, one entry per row and
    /// function, the function's rows next to each other, times the second number returned: the root
    /// of the volume.
    pub fn gradients_at(&self, q: usize) -> (&[f64], f64) {
        let size = self.gradients.len() / self.basis.n_points.max(1);
        (&self.gradients[q * size..(q + 1) * size], self.roots[q])
    }

    /// Lists the functions by rising number; `place` tells where each local function went.
    fn sort_functions(&mut self, space: &dyn Space, e: usize, nodes: &mut Vec<u32>) {
        space.active_functions(e, &mut self.active);
        self.nodes.clear();
        self.nodes.extend(self.active.iter().map(|&a| space.control_points()[a as usize]));
        self.order.clear();
        self.order.extend(0..self.active.len());
        let active = &self.active;
        self.order.sort_unstable_by_key(|&a| active[a]);
        self.place.resize(active.len(), 0);
        nodes.clear();
        for (place, &a) in self.order.iter().enumerate() {
            self.place[a] = place;
            nodes.push(active[a]);
        }
    }

    /// Column `q` of the factors: values and gradients times the root of the volume that the point
    /// stands for.
    fn point(&mut self, model: &Model, q: usize) -> Result<(), SplineError> {
        let dimension = model.dimension();
        let (weight, parameters) = (self.basis.weights[q], self.basis.parameters[q]);
        let (values, first) = (self.basis.values_at(q), self.basis.first_at(q));
        let map = PointMap::new(dimension, &self.nodes, values, first);
        let ratio = map.volume_ratio(parameters)?;
        let radius = map.position[0];
        if *model == Model::Axisymmetric && (radius <= 0.0 || radius.is_nan()) {
            return Err(SplineError::Radius { radius, parameters });
        }
        let root = (weight * ratio * model.measure(&map.position)).sqrt();
        self.roots[q] = root;
        let mut inverse = map.inverse();
        for entry in inverse.iter_mut().flatten() {
            *entry *= root;
        }
        let (n, rows) = (self.active.len(), n_rows(model));
        let value_column = &mut self.values[q * n..(q + 1) * n];
        let gradient_column = &mut self.gradients[q * n * rows..(q + 1) * n * rows];
        for a in 0..n {
            let place = self.place[a];
            value_column[place] = root * values[a];
            let slot = &mut gradient_column[rows * place..rows * (place + 1)];
            let d = [first[0][a], first[1][a], first[2][a]];
            for (i, g) in slot.iter_mut().enumerate() {
                *g = d[0] * inverse[0][i] + d[1] * inverse[1][i] + d[2] * inverse[2][i];
            }
            if *model == Model::Axisymmetric {
                slot[2] = root * values[a] / map.position[0];
            }
        }
        Ok(())
    }
}

/// Lower triangle of `F Fᵀ` by block columns; `F` is column-major `n x n_points`.
fn gram(factor: &[f64], n: usize, n_points: usize, out: &mut Vec<f64>) {
    out.resize(n * n, 0.0);
    let factor = MatRef::from_column_major_slice(&factor[..n * n_points], n, n_points);
    let mut product = MatMut::from_column_major_slice_mut(&mut out[..n * n], n, n);
    for start in (0..n).step_by(GRAM_BLOCK) {
        let width = GRAM_BLOCK.min(n - start);
        let block = product.as_mut().submatrix_mut(start, start, n - start, width);
        let lower = factor.submatrix(start, 0, n - start, n_points);
        let right = factor.submatrix(start, 0, width, n_points);
        matmul(block, Accum::Replace, lower, right.transpose(), 1.0, Par::Seq);
    }
}
