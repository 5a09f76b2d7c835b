//! Where the right-hand side of a multibody system is not smooth: in time by what is given, in the
//! state by stops and friction of joints (docs/theory.md Eq. T.32, M.22).

use super::{MultibodyModel, TreeBody};
use crate::system::joints::TimeFunction;
use crate::system::joints::form::{change_of_form, change_of_sliding};

impl MultibodyModel {
    /// The next time after `t` at which something given over time is not smooth.
    pub(in crate::system) fn next_break(&self, t: f64) -> f64 {
        self.time_functions().map(|function| function.next_break(t)).fold(f64::INFINITY, f64::min)
    }

    /// Longest step from time `t` that resolves what is given over time \[s\].
    pub(in crate::system) fn longest_step(&self, t: f64) -> f64 {
        self.time_functions().map(|function| function.longest_step(t)).fold(f64::INFINITY, f64::min)
    }

    /// All that is given over time: drives, prescribed motions, loads.
    fn time_functions(&self) -> impl Iterator<Item = &TimeFunction> {
        let of_joints = self.bodies.iter().flat_map(|body| &body.joint.coordinates);
        let of_joints = of_joints.flat_map(|c| [c.drive.as_ref(), c.motion.as_ref()]);
        let of_loads = self.loads.iter().flat_map(|load| load.components.iter().map(Option::as_ref));
        of_joints.chain(of_loads).flatten()
    }

    /// Share of a step of size `h` between two states at which the force of a joint changes its
    /// form, if one does.
    pub(in crate::system) fn change_of_form(&self, y0: &[f64], y1: &[f64], h: f64) -> Option<f64> {
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
        shares.min_by(f64::total_cmp)
    }
}
