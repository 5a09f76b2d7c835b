//! Inertia integrals from a mass matrix unknown by unknown (docs/theory.md Eq. M.11), as another
//! program exports it.
//!
//! Fields of displacement are written as values of the unknowns; a rotation among them takes half
//! the curl. Rigid motions are exact for any mass matrix that knows them. Products of single
//! components are exact for elements whose unknowns are displacements, with the same mass for every
//! component; for beams and shells they lack terms of the size of the rotary inertia.

use faer::{Mat, MatRef};
use nalgebra::{Matrix3, Vector3};

use super::assembled::{AssembledBody, Dof, RigidMotion};
use super::shape_integrals::{ShapeIntegrals, gram};

impl AssembledBody {
    /// Values of the unknowns for a unit translation along x, y, z (`direction` 0 to 2) or a unit
    /// rotation about an axis through the frame's origin (3 to 5).
    ///
    /// # Panics
    /// If `direction` exceeds 5.
    pub fn rigid_field(&self, direction: usize) -> Vec<f64> {
        assert!(direction < 6, "there are six rigid motions");
        let (axis, n_c) = (Vector3::ith(direction % 3, 1.0), self.motion.n_components());
        let value = |dof: &Dof| {
            let component = dof.component as usize;
            match (direction < 3, component < n_c) {
                (true, true) => axis[self.motion.direction(component)],
                (true, false) => 0.0,
                (false, true) => axis.cross(&Vector3::from(self.nodes[dof.node as usize]))
                    [self.motion.direction(component)],
                (false, false) => self.motion.rotation_axis(dof.component).map_or(0.0, |k| axis[k]),
            }
        };
        self.dofs.iter().map(value).collect()
    }

    /// Whether rotations are among the unknowns, as in beams and shells.
    pub fn has_rotations(&self) -> bool {
        let n_c = self.motion.n_components();
        self.dofs.iter().any(|d| d.component as usize >= n_c)
    }

    /// The field `X_a e_b` in the model's components, one column.
    pub(crate) fn linear_field(&self, a: usize, b: usize) -> Mat<f64> {
        // Half the curl of X_a e_b.
        let turn = 0.5 * Vector3::<f64>::ith(a, 1.0).cross(&Vector3::ith(b, 1.0));
        Mat::from_fn(self.dofs.len(), 1, |i, _| {
            let dof = self.dofs[i];
            match self.motion.rotation_axis(dof.component) {
                Some(axis) => turn[axis],
                None if dof.component as usize == b => self.nodes[dof.node as usize][a],
                None => 0.0,
            }
        })
    }

    /// The fields that have component `a` of each of `shapes` along `e_b`, and nothing else.
    fn component_field(&self, shapes: MatRef<'_, f64>, a: usize, b: usize) -> Mat<f64> {
        let n_c = self.motion.n_components();
        let mut number = vec![[None; 6]; self.nodes.len()];
        for (i, dof) in self.dofs.iter().enumerate() {
            number[dof.node as usize][dof.component as usize] = Some(i);
        }
        let mut field = Mat::zeros(shapes.nrows(), shapes.ncols());
        for (i, dof) in self.dofs.iter().enumerate() {
            let own = &number[dof.node as usize];
            if let Some(axis) = self.motion.rotation_axis(dof.component) {
                for j in 0..shapes.ncols() {
                    let mut turn = Vector3::<f64>::zeros();
                    for (c, unknown) in own.iter().enumerate().skip(n_c) {
                        if let (Some(k), Some(unknown)) = (self.motion.rotation_axis(c as u8), unknown) {
                            turn[k] = shapes[(*unknown, j)];
                        }
                    }
                    // Gradient of component a under the rotation `turn`, then half the curl of that
                    // component along e_b.
                    let gradient = turn.cross_matrix().row(a).transpose();
                    field[(i, j)] = 0.5 * gradient.cross(&Vector3::ith(b, 1.0))[axis];
                }
            } else if let (true, Some(source)) = (dof.component as usize == b, own[a]) {
                (0..shapes.ncols()).for_each(|j| field[(i, j)] = shapes[(source, j)]);
            }
        }
        field
    }

    /// Mass, first moment and second moment about the frame's origin.
    pub(crate) fn rigid_integrals(&self) -> (f64, Vector3<f64>, Matrix3<f64>) {
        let n_c = self.motion.n_components();
        let n = self.dofs.len();
        let column = |field: Vec<f64>| Mat::from_fn(n, 1, |i, _| field[i]);
        let with_mass = |x: &Mat<f64>, y: &Mat<f64>| (x.transpose() * self.mass_product(y.as_ref()))[(0, 0)];
        let linear: Vec<Mat<f64>> = (0..n_c * n_c).map(|ab| self.linear_field(ab / n_c, ab % n_c)).collect();
        let mut second = Matrix3::zeros();
        for (a, b) in (0..n_c).flat_map(|a| (0..=a).map(move |b| (a, b))) {
            let sum: f64 = (0..n_c).map(|c| with_mass(&linear[a * n_c + c], &linear[b * n_c + c])).sum();
            second[(a, b)] = sum / n_c as f64;
            second[(b, a)] = second[(a, b)];
        }
        if self.motion == RigidMotion::Axial {
            let along = column(self.rigid_field(2));
            let square = |a: usize| with_mass(&linear[a * n_c + a], &linear[a * n_c + a]);
            let (radial, axial) = (0.5 * square(0), square(1));
            let first = Vector3::z() * with_mass(&along, &linear[3]);
            return (
                with_mass(&along, &along),
                first,
                Matrix3::from_diagonal(&Vector3::new(radial, radial, axial)),
            );
        }
        let [e, turns] = [0, 3].map(|k| [0, 1, 2].map(|c| column(self.rigid_field(k + c))));
        let mass = (0..n_c).map(|c| with_mass(&e[c], &e[c])).sum::<f64>() / n_c as f64;
        let mut first = Vector3::zeros();
        let mut inertia = Matrix3::zeros();
        for k in axes_of(n_c) {
            for l in axes_of(n_c) {
                inertia[(k, l)] = with_mass(&turns[k], &turns[l]);
            }
            // e_b · (e_k × X), twice for each coordinate of a solid model, once in the plane.
            for b in (0..n_c).filter(|b| *b != k) {
                let product = with_mass(&e[b], &turns[k]);
                let x = 3 - b - k;
                let sign = Vector3::<f64>::ith(k, 1.0).cross(&Vector3::ith(x, 1.0))[b];
                first[x] += sign * product / (n_c - 1) as f64;
            }
        }
        if n_c == 3 {
            second = Matrix3::identity() * (0.5 * inertia.trace()) - inertia;
            second = 0.5 * (second + second.transpose());
        } else {
            let missing = 0.5 * (inertia[(2, 2)] - second.trace());
            second[(0, 0)] += missing;
            second[(1, 1)] += missing;
        }
        (mass, first, second)
    }

    /// All inertia integrals of the modes `shapes`, by products with the whole mass matrix.
    pub(super) fn general_integrals(&self, shapes: MatRef<'_, f64>) -> ShapeIntegrals {
        let (n_c, n_q) = (self.motion.n_components(), shapes.ncols());
        let (mass, mass_moment, second_moment) = self.rigid_integrals();
        let weighted = self.mass_product(shapes);
        let mut modal_mass = shapes.transpose() * &weighted;
        for (i, j) in (0..n_q).flat_map(|i| (0..i).map(move |j| (i, j))) {
            let mean = 0.5 * (modal_mass[(i, j)] + modal_mass[(j, i)]);
            (modal_mass[(i, j)], modal_mass[(j, i)]) = (mean, mean);
        }
        let mut moments = vec![Vector3::zeros(); n_q];
        for c in 0..n_c {
            let direction = self.motion.direction(c);
            if self.motion == RigidMotion::Axial && c == 0 {
                continue;
            }
            for (i, value) in self.rigid_field(direction).into_iter().enumerate() {
                moments.iter_mut().enumerate().for_each(|(j, m)| m[direction] += value * weighted[(i, j)]);
            }
        }
        let (mut position_shape, mut shape_shape) = (Vec::new(), Vec::new());
        if self.motion != RigidMotion::Axial {
            for ab in 0..n_c * n_c {
                let product = self.linear_field(ab / n_c, ab % n_c).transpose() * &weighted;
                position_shape.extend((0..n_q).map(|j| product[(0, j)]));
            }
            shape_shape = self.pair_integrals(shapes);
        }
        ShapeIntegrals {
            mass,
            mass_moment,
            second_moment,
            shapes: moments,
            position_shape,
            shape_shape,
            modal_mass,
        }
    }

    /// `∫ ρ φ_ia φ_jb`: the mean over the directions along which both components are laid.
    fn pair_integrals(&self, shapes: MatRef<'_, f64>) -> Vec<f64> {
        let (n_c, n_q) = (self.motion.n_components(), shapes.ncols());
        let size = n_c * n_c * n_q;
        let mut pairs = vec![0.0; n_q * size];
        for c in 0..n_c {
            let fields: Vec<Mat<f64>> = (0..n_c).map(|a| self.component_field(shapes, a, c)).collect();
            let weighted: Vec<Mat<f64>> = fields.iter().map(|f| self.mass_product(f.as_ref())).collect();
            for ab in 0..n_c * n_c {
                let (a, b) = (ab / n_c, ab % n_c);
                let forth = gram(fields[a].transpose(), weighted[b].transpose());
                let back = gram(weighted[a].transpose(), fields[b].transpose());
                for (i, j) in (0..n_q).flat_map(|i| (0..n_q).map(move |j| (i, j))) {
                    pairs[i * size + ab * n_q + j] += 0.5 * (forth[(i, j)] + back[(i, j)]) / n_c as f64;
                }
            }
        }
        pairs
    }
}

/// Axes about which a model of `n_c` components turns.
fn axes_of(n_c: usize) -> std::ops::Range<usize> {
    if n_c == 3 { 0..3 } else { 2..3 }
}
