//! Displacement, strain, stress and von Mises stress at parameter points (theory Eq. E.1 to E.6).

use faer::Mat;

use crate::SplineError;
use crate::elasticity::kinematics::PointState;
use crate::elasticity::mapping::PointMap;
use crate::elasticity::{Material, Model};
use crate::space::{GridBasis, Space};

/// Step towards the middle of the element, in parts of its size, by which a point on a singular
/// line is moved before strains are taken: gradients do not exist on the line itself. The strain
/// changes by about this part of its variation over the element.
const SINGULAR_STEP: f64 = 1e-4;
/// Ratio of the determinants at a point and at the one moved into the element above which the map
/// counts as regular: one but for 1e-4 of its variation on regular sides, less than a half within
/// 1e-4 of the element's size from a singular line.
const REGULAR: f64 = 0.5;
/// Below this part of the largest radius of the element `u_r / r` is replaced by its limit
/// `∂u_r/∂r`: the limit is wrong by the square of this number, the quotient would be by round-off
/// divided by it.
const AXIS_LIMIT: f64 = 1e-7;

/// A shape function at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FunctionAtPoint {
    /// Number of the function.
    pub number: u32,
    /// Value.
    pub value: f64,
    /// Derivatives along the model's components [1/m].
    pub gradient: [f64; 3],
}

/// Buffers for point evaluations; reuse them, so that an evaluation allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct RecoveryWorkspace {
    basis: GridBasis,
    active: Vec<u32>,
    nodes: Vec<[f64; 3]>,
    /// Derivatives of the functions along the model's components [1/m].
    slopes: Vec<[f64; 3]>,
}

impl RecoveryWorkspace {
    /// Displacement at `xi` of element `e` from control values `displacement`, which are
    /// node-major: component `c` of function `A` at `A * n_components + c` \[m\].
    ///
    /// # Panics
    /// If `displacement` is shorter than the space asks for.
    pub fn displacement(
        &mut self,
        space: &dyn Space,
        n_components: usize,
        displacement: &[f64],
        e: usize,
        xi: &[f64; 3],
    ) -> [f64; 3] {
        space.evaluate_grid(e, xi.each_ref().map(std::slice::from_ref), &mut self.basis);
        space.active_functions(e, &mut self.active);
        let mut u = [0.0; 3];
        for (&a, value) in self.active.iter().zip(self.basis.values_at(0)) {
            let at = a as usize * n_components;
            for (sum, control) in u.iter_mut().zip(&displacement[at..at + n_components]) {
                *sum += value * control;
            }
        }
        u
    }

    /// Strain and stress at `xi` of element `e` from node-major control values `displacement`
    /// \[m\].
    ///
    /// On the axis of an axisymmetric model `ε_θθ = ∂u_r/∂r`. On singular lines of the
    /// parametrisation the state is taken at a point moved into the element by 1e-4 of its size.
    ///
    /// # Errors
    /// [`SplineError::Folded`] where the Jacobian determinant is not positive beside the singular lines.
    ///
    /// # Panics
    /// If `displacement` is shorter than the space asks for.
    pub fn stress(
        &mut self,
        space: &dyn Space,
        model: &Model,
        material: &Material,
        displacement: &[f64],
        e: usize,
        xi: &[f64; 3],
    ) -> Result<PointState, SplineError> {
        let map = self.regular_map(space, e, xi)?;
        self.take_slopes(&map, model.dimension());
        Ok(self.state(model, material, displacement, &map))
    }

    /// The states of [`RecoveryWorkspace::stress`] at each of `points` of element `e`, by each of several `displacements`, a list each: one
    /// product of the functions' values and slopes with all control values.
    ///
    /// # Errors
    /// As [`RecoveryWorkspace::stress`].
    ///
    /// # Panics
    /// As [`RecoveryWorkspace::stress`].
    pub fn stresses(
        &mut self,
        space: &dyn Space,
        (model, material): (&Model, &Material),
        displacements: &[Vec<f64>],
        e: usize,
        points: &[[f64; 3]],
    ) -> Result<Vec<Vec<PointState>>, SplineError> {
        let n = model.dimension();
        space.active_functions(e, &mut self.active);
        let controls = Mat::from_fn(self.active.len(), n * displacements.len(), |local, column| {
            displacements[column / n][self.active[local] as usize * n + column % n]
        });
        // A row of slopes a direction, and one of values, a point.
        let mut rows = Mat::zeros(points.len() * (n + 1), self.active.len());
        let mut radii = Vec::with_capacity(points.len());
        for (first, xi) in points.iter().enumerate().map(|(p, xi)| (p * (n + 1), xi)) {
            let map = self.regular_map(space, e, xi)?;
            self.take_slopes(&map, n);
            radii.push(self.radius(&map));
            for (local, (slopes, value)) in self.slopes.iter().zip(self.basis.values_at(0)).enumerate() {
                slopes.iter().take(n).enumerate().for_each(|(j, slope)| rows[(first + j, local)] = *slope);
                rows[(first + n, local)] = *value;
            }
        }
        let found = rows * controls;
        let state = |(p, radius): (usize, &Option<f64>), k: usize| {
            let at =
                |c: usize, j: usize| if c < n && j < n { found[(p * (n + 1) + j, k * n + c)] } else { 0.0 };
            let gradient = std::array::from_fn(|c| std::array::from_fn(|j| at(c, j)));
            let hoop = radius.map_or(gradient[0][0], |radius| found[(p * (n + 1) + n, k * n)] / radius);
            PointState::new(model, material, &gradient, hoop)
        };
        let of_all = |k| radii.iter().enumerate().map(|point| state(point, k)).collect();
        Ok((0..displacements.len()).map(of_all).collect())
    }

    /// Derivatives along the model's components at the point of `map`.
    fn take_slopes(&mut self, map: &PointMap, n_components: usize) {
        let (first, inverse) = (self.basis.first_at(0), map.inverse());
        let slope = |local: usize, j: usize| -> f64 {
            (0..n_components).map(|d| first[d][local] * inverse[d][j]).sum()
        };
        let of_function =
            |local| std::array::from_fn(|j| if j < n_components { slope(local, j) } else { 0.0 });
        self.slopes.clear();
        self.slopes.extend((0..self.active.len()).map(of_function));
    }

    /// The state by `displacement` at the point of `map`, which the slopes are of.
    fn state(&self, model: &Model, material: &Material, displacement: &[f64], map: &PointMap) -> PointState {
        let n_components = model.dimension();
        let (mut gradient, mut radial) = ([[0.0; 3]; 3], 0.0);
        for ((&a, value), slopes) in self.active.iter().zip(self.basis.values_at(0)).zip(&self.slopes) {
            let control = &displacement[a as usize * n_components..][..n_components];
            radial += value * control[0];
            for (row, u) in gradient.iter_mut().zip(control) {
                row.iter_mut().zip(slopes).take(n_components).for_each(|(sum, slope)| *sum += u * slope);
            }
        }
        let hoop = self.radius(map).map_or(gradient[0][0], |radius| radial / radius);
        PointState::new(model, material, &gradient, hoop)
    }

    /// Strain and stress at `xi` of element `e` by a unit of each component of every function that
    /// may not be zero there [1/m]: summed with the control values of a displacement they are the
    /// state of [`RecoveryWorkspace::stress`].
    ///
    /// # Errors
    /// [`SplineError::Folded`] where the Jacobian determinant is not positive beside the singular lines.
    pub fn unit_states(
        &mut self,
        space: &dyn Space,
        model: &Model,
        material: &Material,
        e: usize,
        xi: &[f64; 3],
    ) -> Result<Vec<(u32, Vec<PointState>)>, SplineError> {
        let map = self.regular_map(space, e, xi)?;
        let n_components = model.dimension();
        self.take_slopes(&map, n_components);
        let radius = self.radius(&map);
        let functions = self.active.iter().zip(self.basis.values_at(0)).zip(&self.slopes);
        let states = functions.map(|((&a, value), row)| {
            let by_component = (0..n_components).map(|c| {
                let mut gradient = [[0.0; 3]; 3];
                gradient[c] = *row;
                let radial = if c == 0 { *value } else { 0.0 };
                let hoop = radius.map_or(gradient[0][0], |r| radial / r);
                PointState::new(model, material, &gradient, hoop)
            });
            (a, by_component.collect())
        });
        Ok(states.collect())
    }

    /// Functions that may not be zero at `xi` of element `e`, with their values and their
    /// derivatives in space.
    ///
    /// On singular lines of the parametrisation derivatives are taken at a point moved into the
    /// element by 1e-4 of its size.
    ///
    /// # Errors
    /// [`SplineError::Folded`] where the Jacobian determinant is not positive beside the singular lines.
    pub fn functions(
        &mut self,
        space: &dyn Space,
        e: usize,
        xi: &[f64; 3],
    ) -> Result<Vec<FunctionAtPoint>, SplineError> {
        space.evaluate_grid(e, xi.each_ref().map(std::slice::from_ref), &mut self.basis);
        let values = self.basis.values_at(0).to_vec();
        let map = self.regular_map(space, e, xi)?;
        self.take_slopes(&map, space.dimension());
        let functions = self.active.iter().zip(&values).zip(&self.slopes);
        let function = |((&number, &value), &gradient): ((&u32, &f64), &[f64; 3])| FunctionAtPoint {
            number,
            value,
            gradient,
        };
        Ok(functions.map(function).collect())
    }

    /// Determinant of the map from parameters to space at `xi` of element `e`; on singular lines
    /// that of a point moved into the element.
    ///
    /// # Errors
    /// As [`RecoveryWorkspace::functions`].
    pub fn determinant(&mut self, space: &dyn Space, e: usize, xi: &[f64; 3]) -> Result<f64, SplineError> {
        Ok(self.regular_map(space, e, xi)?.determinant)
    }

    /// Distance of the point from the axis of an axisymmetric model; none on the axis, where the
    /// hoop strain is `∂u_r/∂r`.
    fn radius(&self, map: &PointMap) -> Option<f64> {
        let largest = self.nodes.iter().fold(0.0f64, |m, x| m.max(x[0].abs()));
        Some(map.position[0]).filter(|radius| *radius > AXIS_LIMIT * largest)
    }

    /// The map at `xi`, or at a point beside it where the map is singular there; the basis belongs
    /// to the same point.
    fn regular_map(&mut self, space: &dyn Space, e: usize, xi: &[f64; 3]) -> Result<PointMap, SplineError> {
        space.active_functions(e, &mut self.active);
        self.nodes.clear();
        self.nodes.extend(self.active.iter().map(|&a| space.control_points()[a as usize]));
        let (mut point, mut is_at_side) = (*xi, false);
        let element = space.element(e);
        for (x, (lower, upper)) in point.iter().zip(element.lower.iter().zip(&element.upper)) {
            is_at_side |= (*x - lower).min(upper - *x) < SINGULAR_STEP * (upper - lower);
        }
        let centre = element.centre();
        point.iter_mut().zip(centre).for_each(|(x, middle)| *x += SINGULAR_STEP * (middle - *x));
        let map = self.map(space, e, xi);
        if !is_at_side {
            map.volume_ratio(*xi)?;
            return Ok(map);
        }
        // Singular lines are sides of elements. A place that a search found lies beside them by
        // round-off, where the determinant is not zero but far below that of a point nearby.
        let beside = self.map(space, e, &point);
        let is_regular = map.determinant > REGULAR * beside.determinant;
        if !is_regular {
            beside.volume_ratio(point)?;
            return Ok(beside);
        }
        let map = self.map(space, e, xi);
        map.volume_ratio(*xi)?;
        Ok(map)
    }

    fn map(&mut self, space: &dyn Space, e: usize, xi: &[f64; 3]) -> PointMap {
        space.evaluate_grid(e, xi.each_ref().map(std::slice::from_ref), &mut self.basis);
        PointMap::new(space.dimension(), &self.nodes, self.basis.values_at(0), self.basis.first_at(0))
    }
}
