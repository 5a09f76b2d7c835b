//! Markers: points with a frame that move and turn with a flexible body (docs/theory.md Eq. M.4 to
//! M.6).

use nalgebra::{UnitQuaternion, Vector3};

use super::marker::FlexiblePoint;
use crate::body::{RigidMotion, TangentFrame};
use crate::data_error::DataError;
use crate::error::DynamicsError;
use crate::force::{BodyState, GeneralisedForce};
use crate::rotation::exponential::RotationVectorRates;

/// A point of a body with a frame of its own.
///
/// The point moves by `Φ q_e`, the frame turns by the rotation vector `ϑ = Ψ q_e` in the body's
/// frame: first order in the elastic coordinates, and yet a rotation matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Name for joints and messages.
    pub name: String,
    /// Undeformed position in the body's frame \[m\].
    pub position: Vector3<f64>,
    /// Rotation from the marker's frame to the body's frame, undeformed.
    pub rotation: UnitQuaternion<f64>,
    n_modes: usize,
    /// Displacement along x, y, z, then rotation about x, y, z, each by elastic coordinate; empty
    /// on rigid bodies.
    rows: Vec<f64>,
}

/// Motion of a marker within its body's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarkerMotion {
    /// Deformed position `X + Φ q_e` \[m\].
    pub arm: Vector3<f64>,
    /// Its rate `Φ dq_e/dt` [m/s].
    pub arm_rate: Vector3<f64>,
    /// Rotation from the marker's frame to the body's frame.
    pub rotation: UnitQuaternion<f64>,
    /// Angular velocity of the marker's frame in the body's frame, and its dependence on rates and
    /// accelerations.
    pub turn: RotationVectorRates,
}

impl Marker {
    /// A marker on a rigid body or on ground, which has no elastic coordinates.
    pub fn rigid(name: &str, position: Vector3<f64>, rotation: UnitQuaternion<f64>) -> Self {
        Self { name: name.to_string(), position, rotation, n_modes: 0, rows: Vec::new() }
    }

    /// A marker on a flexible body with the displacement and the rotation of each mode at its
    /// place, in the body's frame.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if their numbers differ or a number is not finite.
    pub fn flexible(
        name: &str,
        position: Vector3<f64>,
        rotation: UnitQuaternion<f64>,
        displacements: &[Vector3<f64>],
        rotations: &[Vector3<f64>],
    ) -> Result<Self, DynamicsError> {
        let n = displacements.len();
        if rotations.len() != n {
            let (what, found) = (format!("rotations of marker \"{name}\""), rotations.len());
            return Err(DataError::Count { what, found, expected: n }.into());
        }
        if !displacements.iter().chain(rotations).chain([&position]).all(|v| v.norm().is_finite()) {
            let what = format!("position or mode shape of marker \"{name}\"");
            return Err(DataError::NotFinite { what }.into());
        }
        let mut rows = Vec::with_capacity(6 * n);
        for vectors in [displacements, rotations] {
            (0..3).for_each(|c| rows.extend(vectors.iter().map(|v| v[c])));
        }
        Ok(Self { name: name.to_string(), position, rotation, n_modes: n, rows })
    }

    /// Number of elastic coordinates that move the marker; 0 if none does.
    pub fn n_modes(&self) -> usize {
        self.n_modes
    }

    /// Displacement by a unit of each elastic coordinate along `x`, `y` or `z`; empty on rigid
    /// bodies.
    pub fn displacement_row(&self, direction: usize) -> &[f64] {
        &self.rows[direction * self.n_modes..(direction + 1) * self.n_modes]
    }

    /// Rotation vector by a unit of each elastic coordinate about `x`, `y` or `z`; empty on rigid
    /// bodies.
    pub fn rotation_row(&self, direction: usize) -> &[f64] {
        self.displacement_row(3 + direction)
    }

    /// Whether the elastic coordinates neither move nor turn the marker, as at the marker of a
    /// tangent frame.
    pub fn is_still(&self) -> bool {
        self.rows.iter().all(|v| *v == 0.0)
    }

    /// Whether no elastic coordinate moves or turns the marker by more than `limit` a unit, which
    /// shapes of the size of `1/√mass` make a small number.
    pub fn is_still_within(&self, limit: f64) -> bool {
        self.rows.iter().all(|v| v.abs() <= limit)
    }

    /// The tangent frame of a model with the rigid motions `motion` that follows this marker.
    pub fn tangent_frame(&self, motion: RigidMotion) -> TangentFrame {
        let vectors = |first: usize| {
            let vector = |j: usize| Vector3::from_fn(|c, _| self.rows[(first + c) * self.n_modes + j]);
            (0..self.n_modes).map(vector).collect::<Vec<_>>()
        };
        TangentFrame::new(motion, self.position, vectors(0), vectors(3))
            .expect("displacements and rotations have the same number")
    }

    /// The marker on the body in a tangent frame.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if the number of modes differs.
    pub fn in_tangent_frame(&self, frame: &TangentFrame) -> Result<Self, DynamicsError> {
        if frame.n_modes() != self.n_modes {
            let what = format!("modes of marker \"{}\" in a tangent frame", self.name);
            return Err(DataError::Count { what, found: self.n_modes, expected: frame.n_modes() }.into());
        }
        let mut shifted = self.clone();
        for j in 0..self.n_modes {
            let (u, turn) = (frame.displacement(j, &self.position), frame.rotation(j));
            for c in 0..3 {
                shifted.rows[c * self.n_modes + j] += u[c];
                shifted.rows[(3 + c) * self.n_modes + j] += turn[c];
            }
        }
        Ok(shifted)
    }

    /// The marker's point, for forces and output.
    pub fn point(&self) -> FlexiblePoint {
        let shape = |j: usize| Vector3::from_fn(|c, _| self.rows[c * self.n_modes + j]);
        FlexiblePoint { position: self.position, shapes: (0..self.n_modes).map(shape).collect() }
    }

    /// Motion of the marker within its body's frame (Eq. M.4 to M.6). Does not allocate.
    pub fn motion(&self, elastic: &[f64], rates: &[f64]) -> MarkerMotion {
        let [[moved, vector], [arm_rate, rate]] = self.combine_both(elastic, rates);
        MarkerMotion {
            arm: self.position + moved,
            arm_rate,
            rotation: if self.n_modes == 0 {
                self.rotation
            } else {
                UnitQuaternion::from_scaled_axis(vector) * self.rotation
            },
            turn: RotationVectorRates::new(&vector, &rate),
        }
    }

    /// Rotation from the marker's frame to the inertial frame.
    pub fn orientation(&self, state: &BodyState) -> UnitQuaternion<f64> {
        state.rotation * self.motion(&state.elastic, &state.elastic_rates).rotation
    }

    /// Position of the marker in the inertial frame \[m\].
    pub fn place(&self, state: &BodyState) -> Vector3<f64> {
        state.position + state.rotation * (self.position + self.combine(0, &state.elastic))
    }

    /// Velocity of the marker in the inertial frame [m/s].
    pub fn velocity(&self, state: &BodyState) -> Vector3<f64> {
        let arm = self.position + self.combine(0, &state.elastic);
        let local = state.angular_velocity_in_body.cross(&arm) + self.combine(0, &state.elastic_rates);
        state.velocity + state.rotation * local
    }

    /// Angular velocity of the marker's frame in the inertial frame [rad/s].
    pub fn angular_velocity(&self, state: &BodyState) -> Vector3<f64> {
        let turn = self.motion(&state.elastic, &state.elastic_rates).turn;
        state.rotation * (state.angular_velocity_in_body + turn.spin)
    }

    /// Adds a force \[N\] and a moment \[N m\] at the marker, both in the inertial frame, to the
    /// forces on its body (Eq. M.7).
    pub fn add_wrench(
        &self,
        state: &BodyState,
        force: &Vector3<f64>,
        moment: &Vector3<f64>,
        sum: &mut GeneralisedForce,
    ) {
        let motion = self.motion(&state.elastic, &state.elastic_rates);
        let local = state.rotation.inverse_transform_vector(force);
        let local_moment = state.rotation.inverse_transform_vector(moment);
        sum.force += force;
        sum.torque_in_body += motion.arm.cross(&local) + local_moment;
        self.add_elastic(&local, &motion.turn.jacobian.tr_mul(&local_moment), &mut sum.elastic);
    }

    /// Adds `Φᵀ force + Ψᵀ moment` to modal forces; `moment` belongs to the rotation vector.
    pub(crate) fn add_elastic(&self, force: &Vector3<f64>, moment: &Vector3<f64>, elastic: &mut [f64]) {
        for c in 0..3 {
            let rows = self.displacement_row(c).iter().zip(self.rotation_row(c));
            for (f, (u, turn)) in elastic.iter_mut().zip(rows) {
                *f += u * force[c] + turn * moment[c];
            }
        }
    }

    /// Displacement and rotation vector by elastic coordinates, and the same by their rates. The
    /// sums are those of [`Marker::combine`], side by side, so that none waits for another.
    fn combine_both(&self, elastic: &[f64], rates: &[f64]) -> [[Vector3<f64>; 2]; 2] {
        let n = self.n_modes.min(elastic.len()).min(rates.len());
        let rows: [&[f64]; 6] = std::array::from_fn(|c| &self.displacement_row(c)[..n]);
        let mut sums = [[0.0; 2]; 6];
        for (j, (q, rate)) in elastic[..n].iter().zip(&rates[..n]).enumerate() {
            for (sum, row) in sums.iter_mut().zip(&rows) {
                sum[0] += row[j] * q;
                sum[1] += row[j] * rate;
            }
        }
        let vector = |first: usize, of: usize| Vector3::from_fn(|c, _| sums[first + c][of]);
        [0, 1].map(|of| [vector(0, of), vector(3, of)])
    }

    /// Displacement (`first = 0`) or rotation vector (`first = 3`) by elastic coordinates.
    fn combine(&self, first: usize, coordinates: &[f64]) -> Vector3<f64> {
        let row = |c: usize| self.displacement_row(first + c).iter().zip(coordinates);
        Vector3::from_fn(|c, _| row(c).map(|(shape, q)| shape * q).sum())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marker_on_a_rigidly_turning_field_turns_with_it() {
        let (turn, place) = (Vector3::new(0.3, -0.7, 0.2), Vector3::new(1.0, 2.0, -0.5));
        let field = turn.cross(&place);
        let marker =
            Marker::flexible("m", place, UnitQuaternion::identity(), &[field], &[turn]).expect("sizes fit");
        for c in 0..3 {
            assert!((marker.rotation_row(c)[0] - turn[c]).abs() < 1e-15); // round-off
            assert!((marker.displacement_row(c)[0] - field[c]).abs() < 1e-15);
        }
        let frame = marker.tangent_frame(RigidMotion::Spatial);
        let far = Marker::flexible("far", -place, UnitQuaternion::identity(), &[-field], &[turn])
            .and_then(|m| m.in_tangent_frame(&frame))
            .expect("sizes fit");
        let largest = (0..3).map(|c| far.displacement_row(c)[0].abs() + far.rotation_row(c)[0].abs());
        assert!(largest.fold(0.0, f64::max) < 1e-15, "a rigid field vanishes in a tangent frame");
    }
}
