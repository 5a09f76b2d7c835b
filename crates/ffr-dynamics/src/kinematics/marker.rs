//! Points on a flexible body (docs/theory.md Eq. D.2, D.3).

use faer::MatRef;
use nalgebra::Vector3;

use crate::body::RigidMotion;
use crate::force::{BodyState, GeneralisedForce};

/// A material point of a flexible body.
#[derive(Debug, Clone, PartialEq)]
pub struct FlexiblePoint {
    /// Undeformed position in the body's frame \[m\].
    pub position: Vector3<f64>,
    /// Displacement of the point in the body's frame by a unit of each elastic coordinate.
    pub shapes: Vec<Vector3<f64>>,
}

impl FlexiblePoint {
    /// A point of a rigid body, or one that doesn't feel the deformation.
    pub fn rigid(position: Vector3<f64>) -> Self {
        Self { position, shapes: Vec::new() }
    }

    /// A point from the rows `first_row..first_row + n_components` of a matrix of shapes in the
    /// model's own components.
    ///
    /// # Panics
    /// If the matrix has too few rows.
    pub fn from_rows(
        motion: RigidMotion,
        position: Vector3<f64>,
        shapes: MatRef<'_, f64>,
        first_row: usize,
    ) -> Self {
        let shape = |j: usize| {
            let mut direction = Vector3::zeros();
            for c in 0..motion.n_components() {
                direction[motion.direction(c)] = shapes[(first_row + c, j)];
            }
            direction
        };
        Self { position, shapes: (0..shapes.ncols()).map(shape).collect() }
    }

    /// Deformed position in the body's frame, `X + Φ q_e` \[m\].
    pub fn local_position(&self, elastic: &[f64]) -> Vector3<f64> {
        self.position + self.combination(elastic)
    }

    /// Position in the inertial frame (Eq. D.2) \[m\].
    pub fn position(&self, state: &BodyState) -> Vector3<f64> {
        state.position + state.rotation * self.local_position(&state.elastic)
    }

    /// Velocity in the inertial frame (Eq. D.2) [m/s].
    pub fn velocity(&self, state: &BodyState) -> Vector3<f64> {
        let arm = self.local_position(&state.elastic);
        let local = state.angular_velocity_in_body.cross(&arm) + self.combination(&state.elastic_rates);
        state.velocity + state.rotation * local
    }

    /// Adds a force on the point, expressed in the inertial frame \[N\], to the forces on its body
    /// (Eq. D.3).
    pub fn add_force(&self, state: &BodyState, force: &Vector3<f64>, sum: &mut GeneralisedForce) {
        let local = state.rotation.inverse_transform_vector(force);
        sum.force += force;
        sum.torque_in_body += self.local_position(&state.elastic).cross(&local);
        for (f, shape) in sum.elastic.iter_mut().zip(&self.shapes) {
            *f += shape.dot(&local);
        }
    }

    fn combination(&self, coordinates: &[f64]) -> Vector3<f64> {
        self.shapes.iter().zip(coordinates).fold(Vector3::zeros(), |sum, (shape, q)| sum + shape * *q)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    fn moving_body() -> BodyState {
        BodyState {
            position: Vector3::new(0.3, -0.2, 1.0),
            rotation: UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.9, 0.2)),
            velocity: Vector3::new(1.0, 2.0, -0.5),
            angular_velocity_in_body: Vector3::new(-3.0, 0.7, 1.9),
            elastic: vec![0.01, -0.03],
            elastic_rates: vec![0.4, 0.9],
        }
    }

    #[test]
    fn power_of_a_point_force_equals_power_of_its_generalised_force() {
        let point = FlexiblePoint {
            position: Vector3::new(0.1, 0.2, -0.3),
            shapes: vec![Vector3::new(1.0, 0.5, -0.2), Vector3::new(-0.3, 0.8, 0.6)],
        };
        let (state, force) = (moving_body(), Vector3::new(5.0, -7.0, 11.0));
        let mut sum = GeneralisedForce::zeros(2);
        point.add_force(&state, &force, &mut sum);
        let modal: f64 = sum.elastic.iter().zip(&state.elastic_rates).map(|(f, v)| f * v).sum();
        let power =
            sum.force.dot(&state.velocity) + sum.torque_in_body.dot(&state.angular_velocity_in_body) + modal;
        assert!((power - force.dot(&point.velocity(&state))).abs() < 1e-13 * 30.0); // round-off of terms of order 30
    }

    #[test]
    fn rows_of_an_axisymmetric_model_point_along_x_and_z() {
        let shapes = faer::mat![[0.0], [0.0], [2.0], [3.0]];
        let point = FlexiblePoint::from_rows(RigidMotion::Axial, Vector3::zeros(), shapes.as_ref(), 2);
        assert_eq!(point.shapes, vec![Vector3::new(2.0, 0.0, 3.0)]);
    }
}
