//! Size of a local error: in energy, not in components (docs/theory.md Eq. T.7, T.8).
//!
//! An error of the state is turned into a velocity: the root mean square, over the body's mass, of the velocity error that
//! carries the error's energy. It is compared with a velocity of the motion itself. Modes count by their energy, so that
//! a high mode whose amplitude of 1e-9 rings does not decide the step, and no amplitude needs an absolute tolerance of its
//! own. What starts from rest is measured against the velocity floor.

use nalgebra::{Quaternion, Vector3};

use super::free_modes::FreeModes;
use super::layout::BodyLayout;
use crate::body::StandardInputData;
use crate::data_error::DataError;
use crate::error::DynamicsError;
use crate::kinematics::rotation::rotation_from_slice;

/// Tolerances of the error norm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorScale {
    /// Permitted error a step, as a share of the motion's velocity.
    pub relative: f64,
    /// Motion slower than this is resolved as if it were this fast, > 0 [m/s].
    pub velocity_floor: f64,
}

impl Default for ErrorScale {
    fn default() -> Self {
        Self { relative: 1e-8, velocity_floor: 1e-6 }
    }
}

impl ErrorScale {
    /// The tolerances themselves.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if one is not positive.
    pub(super) fn checked(self) -> Result<Self, DynamicsError> {
        let is_positive = |x: f64| x > 0.0 && x.is_finite();
        if is_positive(self.relative) && is_positive(self.velocity_floor) {
            return Ok(self);
        }
        let (what, value) = if is_positive(self.relative) {
            ("the velocity floor [m/s]", self.velocity_floor)
        } else {
            ("the tolerance", self.relative)
        };
        Err(DataError::OutOfRange { what: what.into(), value, range: "> 0 and finite" }.into())
    }
}

/// Longest length that position errors are compared with, as a share of the body's radius of gyration.
const LENGTH_SHARE: f64 = 1e-2;

/// Fixed scales of one body.
#[derive(Debug, Clone)]
pub(super) struct BodyScale {
    mass: f64,
    centre_of_mass: Vector3<f64>,
    /// Root mean square distance from the centre of mass \[m\].
    radius: f64,
    modes: FreeModes,
    /// Lowest elastic eigenfrequency; 0 for rigid bodies [rad/s].
    lowest: f64,
}

impl BodyScale {
    /// # Errors
    /// [`DynamicsError::NotPositiveDefinite`] if the inertia of the undeformed body is not.
    pub(super) fn new(data: &StandardInputData) -> Result<Self, DynamicsError> {
        let centre = data.centre_of_mass();
        let about_origin = data.second_moment.trace() / data.mass;
        let squared_radius = (about_origin - centre.norm_squared()).max(0.0);
        let modes = FreeModes::new(data)?;
        Ok(Self {
            mass: data.mass,
            centre_of_mass: centre,
            radius: squared_radius.sqrt(),
            lowest: modes.lowest(),
            modes,
        })
    }

    /// Highest squared eigenfrequency, 0 for rigid bodies [rad²/s²].
    pub(super) fn highest_squared(&self) -> f64 {
        self.modes.squared_frequencies.iter().copied().fold(0.0, f64::max)
    }

    /// Velocity of the motion: twice the energy over the mass, its root (Eq. T.8) [m/s].
    ///
    /// Couplings between rigid and elastic motion are left out; they don't change the size.
    pub(super) fn speed(&self, data: &StandardInputData, layout: &BodyLayout, y: &[f64]) -> f64 {
        let elastic: f64 = modal_sum(data, &y[layout.elastic()], &y[layout.elastic_rates()]);
        let rotation = self.radius * norm(&y[layout.angular_velocity()]);
        (self.centre_speed_squared(layout, y) + rotation * rotation + elastic / self.mass).sqrt()
    }

    /// Squared velocity of the undeformed centre of mass.
    fn centre_speed_squared(&self, layout: &BodyLayout, y: &[f64]) -> f64 {
        let mut state_velocity = Vector3::from_column_slice(&y[layout.velocity()]);
        if self.centre_of_mass.norm_squared() > 0.0 {
            let omega = Vector3::from_column_slice(&y[layout.angular_velocity()]);
            let rotation = rotation_from_slice(&y[layout.rotation()]);
            state_velocity += rotation * omega.cross(&self.centre_of_mass);
        }
        state_velocity.norm_squared()
    }

    /// Velocity that carries the energy of `error` at the state `y` (Eq. T.7), for motion of velocity `speed` [m/s].
    pub(super) fn error_speed(&self, layout: &BodyLayout, y: &[f64], error: &[f64], speed: f64) -> f64 {
        self.error_size(layout, y, error, self.position_rate(speed), f64::INFINITY)
    }

    /// [`BodyScale::error_speed`], but with elastic errors above the rate of positions counted as positions (Eq. T.18).
    pub(super) fn damped_error_speed(
        &self,
        layout: &BodyLayout,
        y: &[f64],
        error: &[f64],
        speed: f64,
    ) -> f64 {
        let rate = self.position_rate(speed);
        self.error_size(layout, y, error, rate, rate)
    }

    /// A position error is worth the velocity that covers it in the time scale of the body's own vibration [1/s].
    fn position_rate(&self, speed: f64) -> f64 {
        if self.radius > 0.0 { self.lowest.max(speed / (LENGTH_SHARE * self.radius)) } else { self.lowest }
    }

    /// Size of `error` with `rate` for positions and elastic energies cut at the frequency `highest`.
    fn error_size(&self, layout: &BodyLayout, y: &[f64], error: &[f64], rate: f64, highest: f64) -> f64 {
        let (q, v) = (&error[layout.elastic()], &error[layout.elastic_rates()]);
        let elastic = self.modes.cut_energy(q, v, highest * highest) / self.mass;
        let (place, velocity) = (&error[layout.position()], &error[layout.velocity()]);
        let (turn, spin) = (&error[layout.rotation()], &error[layout.angular_velocity()]);
        let mut sizes = [norm(place), 2.0 * norm(turn), norm(velocity), norm(spin)];
        if self.modes.moves_body() {
            let axes = rotation_from_slice(&y[layout.rotation()]);
            let turned = axes.inverse().into_inner() * Quaternion::new(turn[0], turn[1], turn[2], turn[3]);
            let angle = [2.0 * turned.i, 2.0 * turned.j, 2.0 * turned.k];
            for (k, (moved, turned, elastic)) in
                [(place, &angle[..], q), (velocity, spin, v)].into_iter().enumerate()
            {
                let local = axes.inverse_transform_vector(&Vector3::from_column_slice(moved));
                let mut frame = [local.x, local.y, local.z, turned[0], turned[1], turned[2]];
                self.modes.add_rigid(elastic, &mut frame);
                (sizes[2 * k], sizes[2 * k + 1]) = (norm(&frame[..3]), norm(&frame[3..]));
            }
        }
        let [position, angle, translation, rotation] = sizes;
        let (position, angle) = (rate * position, rate * self.radius * angle);
        let rotation = self.radius * rotation;
        (elastic + translation * translation + rotation * rotation + position * position + angle * angle)
            .sqrt()
    }
}

/// Twice the energy of the elastic coordinates, `Σ k_j q_j²` and that of their rates.
fn modal_sum(data: &StandardInputData, coordinates: &[f64], rates: &[f64]) -> f64 {
    let terms = data.modal_stiffness.iter().zip(coordinates);
    terms.map(|(k, q)| k * q * q).sum::<f64>() + data.modal_mass.square(rates)
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|v| v * v).sum::<f64>().sqrt()
}
