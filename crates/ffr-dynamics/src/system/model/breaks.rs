//! Where the right-hand side of a multibody system is not smooth: in time by what is given, in the
//! state by stops and friction of joints (docs/theory.md Eq. T.32, M.22).

use super::{MultibodyModel, TreeBody};
use crate::system::joints::form::{change_of_driven_form, change_of_form, change_of_sliding};
use crate::system::joints::{CoordinateForce, TimeFunction};

/// Longest step over the one that resolves a prescribed motion: the power that it takes, a force
/// times a velocity, has half its period, and of a body that moves along with it no state has an
/// error to choose steps by.
const STEP_OF_MOTION: f64 = 0.2;

impl MultibodyModel {
    /// The next time after `t` at which something given over time is not smooth.
    pub(in crate::system) fn next_break(&self, t: f64) -> f64 {
        self.time_functions().map(|function| function.next_break(t)).fold(f64::INFINITY, f64::min)
    }

    /// Longest step from time `t` that resolves what is given over time \[s\].
    pub(in crate::system) fn longest_step(&self, t: f64) -> f64 {
        let forces = self.forces_over_time().map(|force| force.longest_step(t));
        let motions = self.motions().map(|motion| STEP_OF_MOTION * motion.longest_step(t));
        forces.chain(motions).fold(f64::INFINITY, f64::min)
    }

    /// A quarter of the shortest period of what is given over time and lasts beyond the time `t`
    /// \[s\]; infinite if nothing does.
    pub fn quarter_period(&self, t: f64) -> f64 {
        self.time_functions().map(|function| function.longest_step(t)).fold(f64::INFINITY, f64::min)
    }

    /// All that is given over time.
    fn time_functions(&self) -> impl Iterator<Item = &TimeFunction> {
        self.forces_over_time().chain(self.motions())
    }

    /// Drives and loads.
    fn forces_over_time(&self) -> impl Iterator<Item = &TimeFunction> {
        let drives = self.coordinates().filter_map(|coordinate| coordinate.drive.as_ref());
        let of_loads = self.loads.iter().flat_map(|load| load.components.iter().flatten());
        drives.chain(of_loads)
    }

    /// Prescribed motions of joints.
    fn motions(&self) -> impl Iterator<Item = &TimeFunction> {
        self.coordinates().filter_map(|coordinate| coordinate.motion.as_ref())
    }

    fn coordinates(&self) -> impl Iterator<Item = &CoordinateForce> {
        self.bodies.iter().flat_map(|body| &body.joint.coordinates)
    }

    /// Share of a step of size `h` from time `t` between two states at which the force of a joint
    /// changes its form, if one does.
    pub(in crate::system) fn change_of_form(&self, t: f64, y0: &[f64], y1: &[f64], h: f64) -> Option<f64> {
        let shares = self.bodies.iter().flat_map(|TreeBody { joint, layout, .. }| {
            let (positions, velocities) = (layout.positions(), layout.velocities());
            let start = (&y0[positions.clone()], &y0[velocities.clone()]);
            let end = (&y1[positions], &y1[velocities]);
            let forces = joint.free_velocities().map(|k| joint.coordinates.get(k)).enumerate();
            let bearing = joint.bearing.as_ref().filter(|_| layout.n_velocities == joint.kind.n_velocities());
            let slides = bearing.and_then(|bearing| change_of_sliding(joint.kind, bearing, start, end, h));
            forces
                .filter_map(move |(k, force)| change_of_form(joint.kind, force?, k, start, end, h))
                .chain(slides)
        });
        let driven = self.coordinates().filter_map(|force| change_of_driven_form(force, t, h));
        shares.chain(driven).min_by(f64::total_cmp)
    }
}
