//! What the point forces of a surface pair do to its bodies: loads, sums, generalised forces, and the rates of these.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::{BodyState, GeneralisedForce};
use nalgebra::Vector3;

use super::SurfacePair;
use super::contact_jacobian::ContactJacobian;
use super::relative_pose::resultant;
use super::state::{Buffers, PairFound, PairState, RateBuffers, Work};
use crate::contact_element::ContactReport;
use crate::quasistatic::SolveReport;
use crate::quasistatic::problem::dot;
use crate::quasistatic::stick_slip::rates::force_rates;

impl SurfacePair {
    /// Components of the point forces on both bodies at the last projection.
    pub(super) fn load(&self, state: &PairState, found: &mut PairFound) {
        let PairFound { jacobian, loads, node_loads, interface_loads, .. } = found;
        self.load_points(jacobian, (&state.start.forces, state.tangential_forces()), (loads, node_loads));
        interface_loads.fill(0.0);
        if !interface_loads.is_empty() {
            for (load, dof) in node_loads.iter().zip(&self.surface.dofs) {
                if let Some(b) = dof {
                    interface_loads[*b as usize] = *load;
                }
            }
        }
    }

    /// Replaces `loads` and `node_loads` by the components of point forces along the rows of `jacobian`, `normal` ones and those
    /// along the tangents.
    fn load_points(
        &self,
        jacobian: &ContactJacobian,
        (normal, tangential): (&[f64], &[f64]),
        (loads, node_loads): (&mut [f64], &mut [f64]),
    ) {
        let nc = self.motion.n_components();
        loads.fill(0.0);
        node_loads.fill(0.0);
        for (i, force) in normal.iter().enumerate().filter(|(_, f)| **f != 0.0) {
            for (d, &force) in std::iter::once(force).chain(of_point(tangential, i, jacobian.n_t)).enumerate()
            {
                let load = loads[nc * i..][..nc].iter_mut();
                load.zip(jacobian.direction_in_body(i, d)).for_each(|(l, x)| *l += force * x);
                for (node, share) in jacobian.shares(&self.surface, i, d) {
                    let load = node_loads[nc * node as usize..][..nc].iter_mut();
                    load.zip(share).for_each(|(l, x)| *l -= force * x);
                }
            }
        }
    }

    /// Sums up the last evaluation, whose target stands at `target`.
    pub(super) fn sum_up(&self, solver: SolveReport, target: &BodyState, work: &mut Work<'_>) {
        let (state, w) = (&*work.state, &mut *work.found);
        let mut report = ContactReport { solver, ..ContactReport::default() };
        let is_end = self.surface.edges.is_none();
        let mut indented = 0.0;
        for (i, &force) in state.start.forces.iter().enumerate() {
            let gap = state.start.proximity.gaps[i];
            let left_out = self.left_out.get(i).copied().unwrap_or_default();
            report.penetration = report.penetration.max(-gap - left_out * force);
            let found = &w.projections[i];
            // Beyond the end and below the surface: the target is too small. Of points that were
            // not projected, being open for certain, an earlier projection says nothing: it may be
            // that of a step given up.
            report.is_rim_touched |=
                w.is_wanted[i] && is_end && found.is_beyond && found.gap < 0.0 && gap < self.rim_reach;
            if force > 0.0 {
                report.normal_force += force;
                report.n_active += 1;
                report.contact_area += self.areas[i];
                report.is_rim_touched |= self.is_rim[i]
                    || found.is_at_edge
                    || !self.surface.elements[found.element as usize].is_in_zone;
                report.energies.penalty += 0.5 * force * force * (self.springs[i] - left_out);
                indented += 0.5 * force * force * left_out;
            }
        }
        report.energies.elastic_high = indented
            + 0.5 * (dot(&w.loads, &state.start.body) + dot(&w.interface_loads, &w.interface_displacements));
        if report.n_active == 0 {
            report.energies.elastic_high = 0.0;
        }
        let forces = (state.start.forces.as_slice(), state.tangential_forces());
        [report.force, report.friction_force] = self.resultants(&w.jacobian, forces, target);
        report.force += report.friction_force;
        if let Some(law) = &state.friction {
            report.n_sliding = law.n_sliding(&state.start.forces);
            if report.n_active > 0 {
                report.energies.penalty += law.stick_slip.spring_energy();
            }
        }
        w.report = report;
    }

    /// Sums of point forces along the rows of `jacobian` in the inertial frame: of `normal` ones and of those along the tangents.
    fn resultants(
        &self,
        jacobian: &ContactJacobian,
        (normal, tangential): (&[f64], &[f64]),
        target: &BodyState,
    ) -> [Vector3<f64>; 2] {
        let mut sums = [[0.0; 3]; 2];
        for (i, force) in normal.iter().enumerate().filter(|(_, f)| **f != 0.0) {
            for (d, force) in std::iter::once(force).chain(of_point(tangential, i, jacobian.n_t)).enumerate()
            {
                let direction = jacobian.direction_in_target(i, d);
                sums[d.min(1)].iter_mut().zip(direction).for_each(|(s, x)| *s += force * x);
            }
        }
        sums.map(|sum| resultant(self.motion, &target.rotation, &sum))
    }

    /// Adds the point forces to the contact body, their opposites to the target (Eqs. C.42, C.43).
    pub(super) fn push(
        &self,
        bodies: &[BodyState],
        state: &PairState,
        w: &PairFound,
        forces: &mut [GeneralisedForce],
    ) {
        let points = (state.start.forces.as_slice(), state.tangential_forces());
        self.push_points((bodies, w), points, (&w.loads, &w.node_loads, w.report.force), forces);
    }

    /// Adds to `forces` point forces of which `loads` and `node_loads` are the components and `sum` the resultant.
    fn push_points(
        &self,
        (bodies, w): (&[BodyState], &PairFound),
        (normal, tangential): (&[f64], &[f64]),
        (loads, node_loads, sum): (&[f64], &[f64], Vector3<f64>),
        forces: &mut [GeneralisedForce],
    ) {
        let nc = self.motion.n_components();
        let body = &mut forces[self.settings.contact_body];
        body.force += sum;
        for (row, &load) in loads.iter().enumerate().filter(|(_, l)| **l != 0.0) {
            body.elastic.iter_mut().zip(self.body_row(row)).for_each(|(f, s)| *f += s * load);
        }
        let is_turning = self.motion != RigidMotion::Axial;
        let active = || normal.iter().enumerate().filter(|(_, force)| is_turning && **force != 0.0);
        for (i, _) in active() {
            let mut force = Vector3::zeros();
            force.iter_mut().zip(&loads[nc * i..][..nc]).for_each(|(f, l)| *f = *l);
            body.torque_in_body += Vector3::from(w.points[i]).cross(&force);
        }
        let Some(body) = self.settings.target_body else { return };
        debug_assert_eq!(bodies[body].elastic.len(), self.surface.n_modes);
        let target = &mut forces[body];
        target.force -= sum;
        for (row, &load) in node_loads.iter().enumerate().filter(|(_, l)| **l != 0.0) {
            debug_assert!(row / nc < self.surface.nodes.len());
            target.elastic.iter_mut().zip(self.surface.low_row(row)).for_each(|(f, s)| *f += s * load);
        }
        for (i, normal) in active() {
            let mut force = Vector3::from(w.jacobian.normals_in_target[i]) * *normal;
            for (a, tangential) in of_point(tangential, i, w.jacobian.n_t).iter().enumerate() {
                force += Vector3::from(w.jacobian.direction_in_target(i, a + 1)) * *tangential;
            }
            // At the same point of space as the force on the contact body.
            target.torque_in_body -= Vector3::from(w.points_in_target[i]).cross(&force);
        }
    }

    /// Adds the rates of the forces while the bodies move with their velocities to `rates` (Eq. C.109); false where the solver does
    /// not tell.
    pub(super) fn add_force_rates(
        &self,
        bodies: &[BodyState],
        (state, buffers): (&mut PairState, &mut Buffers),
        found: &PairFound,
        rates: &mut [GeneralisedForce],
    ) -> bool {
        let (own, target) = self.states(bodies);
        let RateBuffers { along, normal, tangential, loads, node_loads } = &mut buffers.rates;
        self.rates_of_points((own, target), (&state.start.forces, found), along);
        let PairState { start, zone, friction, .. } = state;
        let pressed = (self.springs.as_slice(), start.forces.as_slice());
        let stick_slip = friction.as_mut().map(|friction| &mut friction.stick_slip);
        let along = [&*along[0], &*along[1]];
        if !force_rates(stick_slip, zone.as_mut(), pressed, along, [normal, tangential]) {
            return false;
        }
        let points = (normal.as_slice(), tangential.as_slice());
        self.load_points(&found.jacobian, points, (loads, node_loads));
        let [sum, of_friction] = self.resultants(&found.jacobian, points, target);
        self.push_points((bodies, found), points, (loads, node_loads, sum + of_friction), rates);
        true
    }

    /// Rates of the points that `forces` press along normals and tangents by the motions of the bodies, as stiff as they stand but for
    /// their modes; zero of others.
    fn rates_of_points(
        &self,
        (own, target): (&BodyState, &BodyState),
        (forces, found): (&[f64], &PairFound),
        [gap_rates, slip_rates]: &mut [Vec<f64>; 2],
    ) {
        let (nc, jacobian) = (self.motion.n_components(), &found.jacobian);
        let velocity = |body: &BodyState, place: &[f64; 3]| {
            let turning = body.angular_velocity_in_body.cross(&Vector3::from(*place));
            body.rotation.inverse_transform_vector(&body.velocity) + turning
        };
        let components = |velocity: Vector3<f64>| self.motion.components(&velocity.into());
        gap_rates.fill(0.0);
        slip_rates.fill(0.0);
        for i in (0..forces.len()).filter(|i| forces[*i] > 0.0) {
            let [mut moved, beside] = match self.motion {
                RigidMotion::Axial => [own, target].map(|body| components(velocity(body, &[0.0; 3]))),
                _ => [
                    velocity(own, &found.points[i]).into(),
                    velocity(target, &found.points_in_target[i]).into(),
                ],
            };
            (0..nc).for_each(|c| moved[c] += dot(self.body_row(nc * i + c), &own.elastic_rates));
            for d in 0..=jacobian.n_t {
                let mut rate = dot(&jacobian.direction_in_body(i, d), &moved)
                    - dot(&jacobian.direction_in_target(i, d), &beside);
                for (node, share) in
                    jacobian.shares(&self.surface, i, d).filter(|_| !target.elastic_rates.is_empty())
                {
                    let low =
                        |c: usize| dot(self.surface.low_row(nc * node as usize + c), &target.elastic_rates);
                    rate -= (0..nc).map(|c| share[c] * low(c)).sum::<f64>();
                }
                if d == 0 { gap_rates[i] = rate } else { slip_rates[jacobian.n_t * i + d - 1] = rate }
            }
        }
    }
}

/// Components along the `n_t` tangents of point `i`; none without friction.
fn of_point(tangential: &[f64], i: usize, n_t: usize) -> &[f64] {
    tangential.get(n_t * i..n_t * (i + 1)).unwrap_or_default()
}
