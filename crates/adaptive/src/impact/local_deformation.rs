//! What the quasistatic displacement of contact zones adds to motion, strain and stress of observed
//! points (docs/theory.md Eqs. Q.5, Q.6, Q.8).
//!
//! The residual flexibility is symmetric: one static problem for each direction of a point gives
//! the displacement of the point by the forces at all interface unknowns. With these rows at hand
//! an instant costs one dot product.

use ffr_dynamics::force::BodyState;
use iga_core::elasticity::kinematics::PointState;
use nalgebra::Vector3;

use crate::body::point_compliance::PointCompliance;
use crate::impact::FineContact;
use crate::record::PointSample;
use crate::state::simulation::{ObservedPoint, System};

/// Steps shorter than this part of the one before tell no velocity: round-off of the solver over a
/// short time.
const SHORTEST_STEP: f64 = 0.05;

/// Local deformation at the observed points, with what tells its velocity.
#[derive(Debug, Clone, Default)]
pub struct LocalDeformation {
    /// Compliances at interfaces that bodies have for the whole run.
    lasting: Vec<PointCompliance>,
    present: Present,
    velocities: Vec<Vector3<f64>>,
    /// The two instants before, the later one first.
    earlier: [Instant; 2],
    n_earlier: usize,
    forces: Vec<f64>,
}

/// Sums over the forces of contacts.
#[derive(Debug, Clone, Default)]
struct Present {
    /// Displacements in the frames of the bodies \[m\].
    displacements: Vec<Vector3<f64>>,
    /// Strain and stress.
    states: Vec<PointState>,
}

impl Present {
    fn clear(&mut self, n_points: usize) {
        self.displacements.clear();
        self.displacements.resize(n_points, Vector3::zeros());
        self.states.clear();
        self.states.resize(n_points, PointState::default());
    }

    /// Adds what the `forces` at an interface do to a point.
    fn add(&mut self, point: &PointCompliance, forces: &[f64]) {
        let displacement = point.rows.iter().zip(forces).fold(Vector3::zeros(), |u, (row, f)| u + row * *f);
        self.displacements[point.point] += displacement;
        let state = &mut self.states[point.point];
        point.states.iter().zip(forces).for_each(|(part, f)| state.add_scaled(part, *f));
    }
}

/// Displacements at a time.
#[derive(Debug, Clone, Default)]
struct Instant {
    time: f64,
    displacements: Vec<Vector3<f64>>,
}

impl LocalDeformation {
    /// Local deformation at points with the compliances `lasting` at interfaces that bodies have
    /// for the whole run.
    pub fn new(lasting: Vec<PointCompliance>) -> Self {
        Self { lasting, ..Self::default() }
    }

    /// Begins at time `t` without local deformation, as impact phases do: their contacts are open
    /// or just touch.
    pub fn begin(&mut self, t: f64, n_points: usize) {
        self.present.clear(n_points);
        self.velocities.clone_from(&self.present.displacements);
        self.earlier[0].time = t;
        self.earlier[0].displacements.clone_from(&self.present.displacements);
        self.n_earlier = 1;
    }

    /// Begins differences in time anew at the present values, as after a change of the model at
    /// time `t`.
    pub fn restart_differences(&mut self, t: f64) {
        self.earlier[0].time = t;
        self.earlier[0].displacements.clone_from(&self.present.displacements);
        self.n_earlier = 1;
    }

    /// Takes the forces of the last evaluation, at time `t`, of `system` with the models `fine` of
    /// its refined contacts. `loads_interface` tells of each contact whether it acts on a lasting
    /// interface.
    pub fn update<'a>(
        &mut self,
        t: f64,
        system: &System,
        fine: impl Fn(usize) -> Option<&'a FineContact>,
        loads_interface: impl Fn(usize) -> bool,
    ) {
        self.present.clear(self.velocities.len());
        for (i, force) in system.forces().iter().enumerate() {
            let contact = &force.contact;
            if contact.report().n_active == 0 {
                continue;
            }
            let refined = fine(i).map_or(&[][..], |f| &f.points);
            let lasting = self.lasting.iter().filter(|p| loads_interface(i) && force.acts_on(p.body));
            let mut loaded = None;
            for p in refined.iter().chain(lasting) {
                let of = Some((p.body, p.rows.len()));
                if loaded != of {
                    self.forces.resize(p.rows.len(), 0.0);
                    loaded = of.filter(|_| contact.interface_force(p.body, &mut self.forces));
                }
                if loaded.is_some() {
                    self.present.add(p, &self.forces);
                }
            }
        }
        self.differentiate(t);
    }

    /// Takes the forces `loads` on interfaces at time `t`, each with what it does to a point.
    pub fn take<'a>(&mut self, t: f64, loads: impl Iterator<Item = (&'a PointCompliance, &'a [f64])>) {
        self.present.clear(self.velocities.len());
        loads.for_each(|(point, forces)| self.present.add(point, forces));
        self.differentiate(t);
    }

    /// Velocities from the parabola through the present and the two instants before, from the chord
    /// if there is one.
    fn differentiate(&mut self, t: f64) {
        let [last, before] = &self.earlier;
        let step = t - last.time;
        let known = if self.n_earlier > 1 { last.time - before.time } else { 0.0 };
        if self.n_earlier == 0 || step <= SHORTEST_STEP * known {
            return;
        }
        for (i, velocity) in self.velocities.iter_mut().enumerate() {
            let chord = (self.present.displacements[i] - last.displacements[i]) / step;
            let turn = if known > 0.0 {
                let earlier = (last.displacements[i] - before.displacements[i]) / known;
                (chord - earlier) * (step / (step + known))
            } else {
                Vector3::zeros()
            };
            *velocity = chord + turn;
        }
        self.earlier.swap(0, 1);
        self.earlier[0].time = t;
        self.earlier[0].displacements.clone_from(&self.present.displacements);
        self.n_earlier = (self.n_earlier + 1).min(2);
    }

    /// Adds the local deformation at `points` to what is recorded of them; the bodies are in the
    /// `states`.
    pub fn add_to(&self, samples: &mut [PointSample], points: &[ObservedPoint], states: &[BodyState]) {
        for ((sample, point), (u, rate)) in
            samples.iter_mut().zip(points).zip(self.present.displacements.iter().zip(&self.velocities))
        {
            let state = &states[point.body];
            let moved = state.rotation * u;
            let rate = state.rotation * (state.angular_velocity_in_body.cross(u) + rate);
            sample.position = (Vector3::from(sample.position) + moved).into();
            sample.velocity = (Vector3::from(sample.velocity) + rate).into();
        }
        samples
            .iter_mut()
            .zip(&self.present.states)
            .for_each(|(sample, state)| sample.state.add_scaled(state, 1.0));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(times: &[f64], u: impl Fn(f64) -> f64) -> f64 {
        let mut local_deformation = LocalDeformation::default();
        local_deformation.begin(times[0], 1);
        local_deformation.earlier[0].displacements[0].x = u(times[0]);
        for &t in &times[1..] {
            local_deformation.present.displacements[0].x = u(t);
            local_deformation.differentiate(t);
        }
        local_deformation.velocities[0].x
    }

    #[test]
    fn velocity_of_a_parabola_is_exact_with_any_steps() {
        let found = after(&[0.0, 0.3, 0.45, 1.0], |t| 2.0 * t * t - t + 3.0);
        assert!((found - 3.0).abs() < 1e-14, "{found}"); // round-off
    }

    #[test]
    fn velocity_converges_with_the_square_of_the_step() {
        let error = |n: usize| {
            let times: Vec<f64> = (0..=n).map(|i| i as f64 / n as f64).collect();
            (after(&times, f64::sin) - 1.0_f64.cos()).abs()
        };
        let rate = (error(20) / error(40)).log2();
        assert!((rate - 2.0).abs() < 0.1, "{rate}"); // next term: a step of 1/20
    }

    #[test]
    fn a_tiny_step_does_not_make_velocity_of_noise() {
        let found = after(&[0.0, 1.0, 2.0, 2.0 + 1e-9], |t| if t > 2.0 { 2.1 } else { t });
        assert!((found - 1.0).abs() < 1e-15, "{found}");
    }
}
