//! One evaluation of a plane contact: gaps and slips, point forces, their sums, the power they
//! lose.

use crate::solver_fault::SolverFault;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::{BodyState, GeneralisedForce};
use nalgebra::{UnitQuaternion, Vector3};

use super::friction::PlaneFriction;
use super::{NORMAL_TOLERANCE, PlaneContact, PlaneFound, PlaneState, PlaneWorkspace};
use crate::ContactError;
use crate::contact_element::ContactReport;
use crate::law::sliding_work::SlidingWork;
use crate::quasistatic::problem::{OPEN, dot};
use crate::quasistatic::stick_slip::TOLERANCE;
use crate::quasistatic::stick_slip::rates::force_rates;
use crate::quasistatic::{Quasistatic, SolveReport, ZoneSolver};
use crate::zone::submodel::is_turned_to;

/// Share of the deepest gap below which a gap is round-off of its sum.
const ROUND_OFF: f64 = 1e-12;
/// Cosine of the angle between the normals of a plane and of a face up to which the face stands across it: rocking bodies do not load
/// their sides.
const ACROSS: f64 = 0.01;
/// Distance from the plane, over the size of the body, that no quasistatic displacement comes near:
/// strains are small.
const FAR: f64 = 0.02;

impl PlaneContact {
    /// Gap of point `i`; open if the plane cannot press it: on faces that are turned away
    /// (Eqs. C.59, C.111), and farther away than any quasistatic displacement.
    fn free_gap(&self, i: usize, offset: f64, normal: (&[f64; 3], &Vector3<f64>), elastic: &[f64]) -> f64 {
        let (components, in_body) = normal;
        let Some(facing) = self.submodel.facing.get(i) else {
            return self.gap(i, offset, components, elastic);
        };
        let is_open = match self.quasistatic {
            Some(_) => !is_turned_to(facing, in_body.as_ref()),
            None => self.shadow(i, in_body) <= 0.0,
        };
        if is_open {
            return OPEN;
        }
        let gap = self.gap(i, offset, components, elastic);
        if gap >= FAR * self.size { OPEN } else { gap }
    }

    /// Outward normal at point `i` if it stands on springs alone, under a face of its own.
    fn on_springs(&self, i: usize) -> Option<Vector3<f64>> {
        self.submodel.facing.get(i).filter(|_| self.quasistatic.is_none()).map(|facing| (*facing).into())
    }

    /// The share of the area of point `i` that a plane with the normal `in_body` sees, if it stands on springs alone (Eq. C.111).
    fn shadow(&self, i: usize, in_body: &Vector3<f64>) -> f64 {
        self.on_springs(i).map_or(1.0, |facing| ((-facing.dot(in_body) - ACROSS) / (1.0 - ACROSS)).max(0.0))
    }

    /// Plane normal in the model's components.
    pub(super) fn normal_components(&self, rotation: &UnitQuaternion<f64>) -> Result<[f64; 3], ContactError> {
        let normal = rotation.inverse_transform_vector(&self.settings.plane.normal);
        let fail =
            |requirement| Err(ContactError::Normal { normal: [normal.x, normal.y, normal.z], requirement });
        // Asked this way round, a NaN fails.
        let is_along_axis = normal.x.hypot(normal.y) < NORMAL_TOLERANCE;
        let is_in_plane = normal.z.abs() < NORMAL_TOLERANCE;
        match self.submodel.motion {
            RigidMotion::Axial if is_along_axis => Ok([0.0, normal.z, 0.0]),
            RigidMotion::Axial => fail("an axisymmetric body needs a normal along its axis z"),
            RigidMotion::Planar if is_in_plane => Ok([normal.x, normal.y, 0.0]),
            RigidMotion::Planar => fail("a plane body needs a normal in its plane x, y"),
            RigidMotion::Spatial => Ok([normal.x, normal.y, normal.z]),
        }
    }

    /// Distance of the frame's origin from the plane.
    pub(super) fn offset(&self, state: &BodyState) -> f64 {
        (state.position - self.settings.plane.point).dot(&self.settings.plane.normal)
    }

    /// Row of the low-frequency shapes of component `c` at point `i`.
    pub(super) fn low_row(&self, i: usize, c: usize) -> &[f64] {
        let n_q = self.submodel.low.ncols();
        let row = self.submodel.motion.n_components() * i + c;
        &self.low_rows[row * n_q..(row + 1) * n_q]
    }

    /// Gap of point `i` without quasistatic displacement (Eq. C.1).
    pub(super) fn gap(&self, i: usize, offset: f64, normal: &[f64; 3], elastic: &[f64]) -> f64 {
        let motion = self.submodel.motion;
        let mut gap = offset;
        for (c, &normal_c) in normal[..motion.n_components()].iter().enumerate() {
            if normal_c != 0.0 {
                let low = dot(self.low_row(i, c), elastic);
                gap += normal_c * (self.submodel.points[i][motion.direction(c)] + low);
            }
        }
        gap
    }

    /// Displaced place of point `i` in the body's frame, without quasistatic displacement \[m\].
    pub(super) fn local_place(&self, i: usize, elastic: &[f64]) -> Vector3<f64> {
        let motion = self.submodel.motion;
        let mut place = Vector3::from(self.submodel.points[i]);
        for c in 0..motion.n_components() {
            place[motion.direction(c)] += dot(self.low_row(i, c), elastic);
        }
        place
    }

    /// Normal, gaps and slips at `body`.
    pub(super) fn locate(
        &self,
        t: f64,
        body: &BodyState,
        state: &mut PlaneState,
        workspace: &mut PlaneWorkspace,
        found: &mut PlaneFound,
    ) -> Result<(), EvaluationFailure> {
        found.normal = self.normal_components(&body.rotation).map_err(SolverFault::Alignment)?;
        let offset = self.offset(body);
        let in_body = body.rotation.inverse_transform_vector(&self.settings.plane.normal);
        for i in 0..self.submodel.n_points() {
            let gap = self.free_gap(i, offset, (&found.normal, &in_body), &body.elastic);
            if !gap.is_finite() {
                return Err(SolverFault::Gap { point: i, gap, time: t }.into());
            }
            workspace.free_gaps[i] = gap;
            workspace.springs[i] = self.springs[i] / self.shadow(i, &in_body);
        }
        let Some(friction) = &mut state.friction else { return Ok(()) };
        friction.turn(&body.rotation);
        let motion = self.submodel.motion;
        let origin = body.position - self.settings.plane.point;
        for i in 0..self.submodel.n_points() {
            let place = self.local_place(i, &body.elastic);
            for a in 0..friction.n_t {
                let tangent = &friction.tangents[a];
                let local: f64 =
                    (0..motion.n_components()).map(|c| tangent[c] * place[motion.direction(c)]).sum();
                friction.coordinates[friction.n_t * i + a] = friction.world[a].dot(&origin) + local;
            }
        }
        friction.measure();
        Ok(())
    }

    /// Point forces at the gaps and slips just found, by the solver or the penalty law.
    pub(super) fn solve(
        &self,
        state: &mut PlaneState,
        workspace: &mut PlaneWorkspace,
        found: &mut PlaneFound,
    ) -> Result<SolveReport, EvaluationFailure> {
        let free_gaps = &workspace.free_gaps;
        let PlaneState { zone, friction } = state;
        let PlaneFound { normal, gaps, forces, displacements, .. } = &mut *found;
        let (Some(model), Some(zone)) = (&self.quasistatic, zone) else {
            for ((force, gap), spring) in forces.iter_mut().zip(free_gaps).zip(&workspace.springs) {
                *force = (-gap).max(0.0) / spring;
            }
            gaps.copy_from_slice(free_gaps);
            if let Some(friction) = friction {
                friction.stick_slip.solve_points(&friction.slips, forces)?;
            }
            self.load_found(friction.as_deref(), found);
            return Ok(SolveReport::default());
        };
        // A body in flight needs no projections; Algorithm 1 keeps its own state there.
        let is_touching = free_gaps.iter().any(|g| *g < 0.0);
        if is_touching && !model.needs_springs() {
            return self.solve_pressed((model, zone), friction.as_deref_mut(), workspace, found);
        }
        if model.needs_springs() {
            zone.project(model, *normal);
        }
        let report = match friction {
            None => zone.solve(&self.springs, free_gaps, forces)?,
            Some(f) => f.stick_slip.solve(TOLERANCE, zone, &self.springs, (free_gaps, &f.slips), forces)?,
        };
        zone.displace((&self.springs, forces), free_gaps, gaps, displacements);
        self.load_found(friction.as_deref(), found);
        if let Some(friction) = friction {
            friction.follow_open(&found.displacements);
        }
        Ok(report)
    }

    /// Point forces by the points alone that lie below the plane, and those that their forces press
    /// against it: what stays open needs no compliance.
    fn solve_pressed(
        &self,
        (model, zone): (&Quasistatic, &mut ZoneSolver),
        mut friction: Option<&mut PlaneFriction>,
        workspace: &mut PlaneWorkspace,
        found: &mut PlaneFound,
    ) -> Result<SolveReport, EvaluationFailure> {
        let PlaneWorkspace { free_gaps, is_member, pressed_gaps, buffers, .. } = workspace;
        is_member.fill(false);
        match &friction {
            None => zone.add_start(is_member),
            Some(f) => f.stick_slip.add_start(is_member),
        }
        // In the unknowns of the surface, what was pressed is enough to start from.
        if friction.is_none() || !is_member.contains(&true) {
            add_below(free_gaps, is_member);
        }
        let (springs, deepest) = (&self.springs, free_gaps.iter().copied().fold(0.0, f64::min));
        let mut total = SolveReport::default();
        loop {
            let forces = &mut found.forces;
            match &mut friction {
                None => {
                    zone.project_members(model, found.normal, is_member, true);
                    press(free_gaps, is_member, pressed_gaps);
                    total.add(zone.solve(springs, pressed_gaps, forces)?);
                    zone.displace((springs, forces), free_gaps, &mut found.gaps, &mut found.displacements);
                    self.load_found(None, found);
                }
                Some(f) => {
                    let directions = [found.normal, f.tangents[0], f.tangents[1]];
                    let given = (&**free_gaps, &*f.slips);
                    f.stick_slip.take(&model.surface(directions), |i| is_member[i], springs);
                    let report = match f.stick_slip.solve_taken(TOLERANCE, springs, given, forces) {
                        Some(report) => report,
                        None => {
                            add_below(free_gaps, is_member);
                            zone.project_members(model, found.normal, is_member, false);
                            press(free_gaps, is_member, pressed_gaps);
                            f.stick_slip.project(model, directions, is_member, &mut buffers[0]);
                            f.stick_slip.solve(TOLERANCE, zone, springs, (pressed_gaps, &f.slips), forces)?
                        }
                    };
                    total.add(report);
                    self.load_found(Some(f), found);
                    model.displacements(&found.loads, buffers, &mut found.displacements);
                    self.open_gaps(free_gaps, found);
                }
            }
            let mut has_new = false;
            let limit = ROUND_OFF * deepest + zone.doubt();
            for (is_member, gap) in is_member.iter_mut().zip(&found.gaps) {
                if !*is_member && *gap < limit {
                    (*is_member, has_new) = (true, true);
                }
            }
            if !has_new {
                if let Some(friction) = friction {
                    friction.follow_open(&found.displacements);
                }
                return Ok(total);
            }
        }
    }

    /// Gaps under the displacements found.
    fn open_gaps(&self, free_gaps: &[f64], found: &mut PlaneFound) {
        let nc = self.submodel.motion.n_components();
        let points = found.displacements.chunks_exact(nc);
        for ((gap, free), u) in found.gaps.iter_mut().zip(free_gaps).zip(points) {
            *gap = free + dot(u, &found.normal[..nc]);
        }
    }

    /// Components of the point forces found.
    fn load_found(&self, friction: Option<&PlaneFriction>, found: &mut PlaneFound) {
        let tangential = friction.map_or(&[][..], |friction| friction.stick_slip.forces());
        self.load_points((found.normal, &found.forces), (friction, tangential), &mut found.loads);
    }

    /// Replaces `loads` by the components of the point forces `forces` along `normal` and `tangential` along the tangents.
    fn load_points(
        &self,
        (normal, forces): ([f64; 3], &[f64]),
        (friction, tangential): (Option<&PlaneFriction>, &[f64]),
        loads: &mut [f64],
    ) {
        let nc = self.submodel.motion.n_components();
        for (load, &force) in loads.chunks_exact_mut(nc).zip(forces) {
            load.iter_mut().zip(normal).for_each(|(l, n)| *l = n * force);
        }
        let Some(friction) = friction else { return };
        let points = tangential.chunks_exact(friction.n_t);
        for (load, point) in loads.chunks_exact_mut(nc).zip(points) {
            for (force, tangent) in point.iter().zip(&friction.tangents) {
                load.iter_mut().zip(tangent).for_each(|(l, t)| *l += t * force);
            }
        }
    }

    /// Sums up what was found.
    pub(super) fn sum_up(
        &self,
        solver: SolveReport,
        state: &PlaneState,
        workspace: &PlaneWorkspace,
        found: &mut PlaneFound,
    ) {
        let mut report = ContactReport { solver, ..ContactReport::default() };
        let (mut couple, mut indented) = (Vector3::zeros(), 0.0);
        for (i, &force) in found.forces.iter().enumerate() {
            if let Some(facing) = self.on_springs(i).filter(|_| force > 0.0) {
                let stretch = force * workspace.springs[i];
                couple += facing * (0.5 * stretch * stretch / self.springs[i] / (1.0 - ACROSS));
            }
            let left_out = self.submodel.left_out_at(i);
            report.penetration = report.penetration.max(-found.gaps[i] - left_out * force);
            if force > 0.0 {
                report.normal_force += force;
                report.n_active += 1;
                report.contact_area += self.submodel.areas[i];
                report.is_rim_touched |= self.is_rim[i];
                // Work of the normal displacement of the zone, Eq. C.7; zero when all modes are
                // dynamic.
                report.energies.elastic_high += 0.5 * force * (found.gaps[i] - workspace.free_gaps[i]);
                report.energies.penalty += 0.5 * force * force * (workspace.springs[i] - left_out);
                indented += 0.5 * force * force * left_out;
            }
        }
        report.force = self.settings.plane.normal.into_inner() * report.normal_force;
        if let Some(friction) = &state.friction {
            // The work of the tangential displacement beside it, Eq. F.13.
            report.energies.elastic_high = 0.5 * dot(&found.loads, &found.displacements);
            report.energies.penalty += friction.stick_slip.spring_energy();
            report.friction_force = friction.resultant(friction.stick_slip.forces());
            report.force += report.friction_force;
            report.n_sliding = friction.n_sliding();
        }
        report.energies.elastic_high += indented;
        found.report = report;
        found.couple = couple;
    }

    /// Work of sliding (Eqs. F.12, F.15).
    pub(super) fn sliding_work(
        &self,
        body: &BodyState,
        state: &mut PlaneState,
        workspace: &mut PlaneWorkspace,
        found: &PlaneFound,
    ) -> Result<SlidingWork, EvaluationFailure> {
        let PlaneState { zone, friction: Some(friction) } = state else {
            return Ok(SlidingWork::default());
        };
        if found.report.n_sliding == 0 {
            return Ok(SlidingWork::default());
        }
        self.find_rates(body, Some(friction), workspace, found);
        let PlaneWorkspace { gap_rates, slip_rates, springs, .. } = workspace;
        let pressed = (springs.as_slice(), found.forces.as_slice());
        friction.stick_slip.sliding_work(zone.as_mut(), pressed, gap_rates, slip_rates)
    }

    /// Adds the rates of the forces while `body` moves with its velocities to `target` (Eq. C.109); false where the solver does
    /// not tell.
    pub(super) fn add_force_rates(
        &self,
        body: &BodyState,
        state: &mut PlaneState,
        workspace: &mut PlaneWorkspace,
        found: &PlaneFound,
        target: &mut GeneralisedForce,
    ) -> bool {
        let PlaneState { zone, friction } = state;
        self.find_rates(body, friction.as_deref(), workspace, found);
        let PlaneWorkspace {
            gap_rates, slip_rates, rates: [normal, tangential], load_rates, springs, ..
        } = workspace;
        let pressed = (springs.as_slice(), found.forces.as_slice());
        let stick_slip = friction.as_mut().map(|friction| &mut friction.stick_slip);
        if !force_rates(stick_slip, zone.as_mut(), pressed, [gap_rates, slip_rates], [normal, tangential]) {
            return false;
        }
        self.load_points((found.normal, normal), (friction.as_deref(), tangential), load_rates);
        let sum = self.settings.plane.normal.into_inner() * normal.iter().sum::<f64>()
            + friction.as_ref().map_or_else(Vector3::zeros, |friction| friction.resultant(tangential));
        self.push((&body.elastic, sum), load_rates, found, target);
        true
    }

    /// Rates of the points along normal and tangents without those of the forces (Eq. F.9).
    fn find_rates(
        &self,
        body: &BodyState,
        friction: Option<&PlaneFriction>,
        workspace: &mut PlaneWorkspace,
        found: &PlaneFound,
    ) {
        let motion = self.submodel.motion;
        let (nc, n_t) = (motion.n_components(), friction.map_or(0, |friction| friction.n_t));
        let turning =
            if motion == RigidMotion::Axial { Vector3::zeros() } else { body.angular_velocity_in_body };
        let frame = body.rotation.inverse_transform_vector(&body.velocity);
        // Forces that keep their sizes turn in the body's frame, which moves the points.
        for (load, rates) in found.loads.chunks_exact(nc).zip(workspace.load_rates.chunks_exact_mut(nc)) {
            let mut force = Vector3::zeros();
            (0..nc).for_each(|c| force[motion.direction(c)] = load[c]);
            let turned = force.cross(&turning);
            (0..nc).for_each(|c| rates[c] = turned[motion.direction(c)]);
        }
        let PlaneWorkspace { load_rates, displacement_rates, buffers, .. } = &mut *workspace;
        if let Some(zone) = &self.quasistatic {
            zone.displacements(load_rates, buffers, displacement_rates);
        }
        let mut drift = [0.0; 3];
        // What stays open has no part in the rates of the forces.
        for i in (0..self.submodel.n_points()).filter(|i| workspace.is_member[*i]) {
            let mut arm = self.local_place(i, &body.elastic);
            (0..nc).for_each(|c| arm[motion.direction(c)] += found.displacements[nc * i + c]);
            let rigid = frame + turning.cross(&arm);
            for (c, d) in drift[..nc].iter_mut().enumerate() {
                *d = rigid[motion.direction(c)] + dot(self.low_row(i, c), &body.elastic_rates);
                *d += workspace.displacement_rates[nc * i + c];
            }
            workspace.gap_rates[i] = dot(&drift[..nc], &found.normal[..nc]);
            for (a, tangent) in friction.iter().flat_map(|friction| &friction.tangents[..n_t]).enumerate() {
                workspace.slip_rates[n_t * i + a] = dot(&drift[..nc], &tangent[..nc]);
            }
        }
    }

    /// Adds forces of `loads` on the points, with the resultant `sum`, to `target`: resultant, moment about the frame's origin (Eq. C.17),
    /// modal forces.
    pub(super) fn push(
        &self,
        (elastic, sum): (&[f64], Vector3<f64>),
        loads: &[f64],
        found: &PlaneFound,
        target: &mut GeneralisedForce,
    ) {
        let motion = self.submodel.motion;
        let nc = motion.n_components();
        target.force += sum;
        for (i, load) in loads.chunks_exact(nc).enumerate().filter(|(i, _)| found.forces[*i] > 0.0) {
            for (c, &factor) in load.iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
                target.elastic.iter_mut().zip(self.low_row(i, c)).for_each(|(f, s)| *f += s * factor);
            }
            if motion != RigidMotion::Axial {
                let mut arm = self.local_place(i, elastic);
                let mut force = Vector3::zeros();
                for c in 0..nc {
                    arm[motion.direction(c)] += found.displacements[nc * i + c];
                    force[motion.direction(c)] = load[c];
                }
                target.torque_in_body += arm.cross(&force);
            }
        }
    }
}

/// Marks the points below the plane as members.
fn add_below(gaps: &[f64], is_member: &mut [bool]) {
    is_member.iter_mut().zip(gaps).for_each(|(is_member, gap)| *is_member |= *gap < 0.0);
}

/// Replaces `pressed` by the gaps of members; nothing presses the others.
fn press(gaps: &[f64], is_member: &[bool], pressed: &mut [f64]) {
    for ((pressed, gap), is_member) in pressed.iter_mut().zip(gaps).zip(is_member) {
        *pressed = if *is_member { *gap } else { OPEN };
    }
}
