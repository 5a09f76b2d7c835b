//! One evaluation of a surface pair: projection, point forces, their sums.

use crate::solver_fault::SolverFault;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::BodyState;

use super::SurfacePair;
use super::friction::PairFriction;
use super::projection::normal_walk::SLACK;
use super::projection::warm_start::WarmStart;
use super::projection::{Displaced, Functions, Projection, Samples, SurfacePlace};
use super::relative_pose::RelativePose;
use super::solver::PairBodies;
use super::state::{Buffers, PairFound, PairState, Work};
use crate::law::penalty;
use crate::quasistatic::SolveReport;
use crate::quasistatic::problem::{OPEN, add_product};
use crate::quasistatic::stick_slip::NormalSolver;

/// Limit of the passes of projection and solution. Each pass reduces the error to about the ratio
/// of contact radius to body radius, a few per cent.
const MAX_PASSES: usize = 40;
/// Number of passes after which a point stays on its piece of the target, unless it leaves it by
/// more than `HELD` in the parameters of the piece: a point near an edge must not change between
/// two pieces for ever. Balls need four or five passes; so near to an edge the normals of both
/// pieces agree to 1e-5.
const STEADY: usize = 6;
const HELD: f64 = 1e-4;
/// Error of the projected gaps at convergence, as a share of the deepest penetration: a force that errs by so much changes the velocity in
/// one of a hundred steps of an impact by a hundredth of what the step may err by.
pub(super) const GAP_TOLERANCE: f64 = 1e-7;
/// Round-off of positions, as a share of the lengths that they are found with, which bounds what can be asked of gaps.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;
/// Change of gaps, as a share of the penetration, when loads move by one element or turn by one
/// radian. Measured 0.13: the displacement under a load of the neighbouring element, of which there
/// are several on a contact radius.
const LOAD_SHIFT: f64 = 0.2;
/// The projected compliance is used again until normals (in radians) or places (in elements) have
/// moved by this.
///
/// It is only the derivative of the fixed-point iteration, whose gaps are taken on the displaced
/// surfaces: an error of this size can slow convergence to about this ratio a pass, no more than
/// the passes leave anyway, and changes no result. Balls that slide need 4.7 passes with 0.05 and
/// with 0.01.
const REUSE: f64 = 5e-2;

/// Points whose gap is smaller than this share of the deepest penetration count as points that may
/// touch when compliances are projected. Around a Hertz contact of radius `a` the gap is that large
/// at `1.35 a` (Johnson 1985, Eq. 3.42a).
const MARGIN: f64 = 0.25;

impl SurfacePair {
    /// Poses of contact body and target.
    pub(super) fn states<'a>(&'a self, bodies: &'a [BodyState]) -> (&'a BodyState, &'a BodyState) {
        let target = self.settings.target_body.map_or(&self.ground, |b| &bodies[b]);
        (&bodies[self.settings.contact_body], target)
    }

    /// Places of points and nodes under the low modes alone.
    pub(super) fn place_low(
        &self,
        body: &BodyState,
        target: &BodyState,
        points: &mut [[f64; 3]],
        nodes: &mut [[f64; 3]],
    ) {
        points.copy_from_slice(&self.points);
        deform(&self.low_columns, &body.elastic, points);
        nodes.copy_from_slice(&self.surface.nodes);
        deform(&self.surface.low_columns, &target.elastic, nodes);
    }

    /// Finds point forces, projections and displacements at the motions `body` and `target`.
    pub(super) fn find_forces(
        &self,
        t: f64,
        body: &BodyState,
        target: &BodyState,
        work: &mut Work<'_>,
    ) -> Result<SolveReport, EvaluationFailure> {
        let relative = RelativePose::new(self.motion, body, target)?;
        let Buffers { low_points, low_nodes, .. } = &mut *work.buffers;
        self.place_low(body, target, low_points, low_nodes);
        self.iterate(t, &relative, work)
    }

    /// Projects the points and the compliances on them without forces.
    pub(super) fn project_for_compliance(
        &self,
        bodies: &[BodyState],
        work: &mut Work<'_>,
    ) -> Result<(), EvaluationFailure> {
        let (body, target) = self.states(bodies);
        let relative = RelativePose::new(self.motion, body, target)?;
        let Buffers { low_points, low_nodes, .. } = &mut *work.buffers;
        self.place_low(body, target, low_points, low_nodes);
        self.project(0.0, SLACK, &relative, work)?;
        let PairState { zone, friction, .. } = &mut *work.state;
        if let (Some(both), Some(zone)) = (self.both(), zone) {
            let stick_slip = friction.as_mut().map(|f| &mut f.stick_slip);
            zone.take((&work.found.jacobian, true), |_| true, |_| 0.0);
            zone.project(both, stick_slip);
        }
        Ok(())
    }

    fn iterate(
        &self,
        t: f64,
        relative: &RelativePose,
        work: &mut Work<'_>,
    ) -> Result<SolveReport, EvaluationFailure> {
        let mut report = SolveReport::default();
        work.found.n_passes = 0;
        let reach = self.surface.size + relative.largest_offset();
        let (mut depth, mut error) = (0.0_f64, f64::INFINITY);
        for pass in 0..MAX_PASSES {
            let slack = if pass < STEADY { SLACK } else { HELD };
            self.project(t, slack, relative, work)?;
            if work.state.zone.is_none() {
                self.press_springs(work)?;
                return Ok(report);
            }
            if pass > 0 {
                error = self.error(work, depth);
            }
            let PairState { start, friction, .. } = &mut *work.state;
            let is_open = pass == 0
                && start.forces.iter().all(|f| *f <= 0.0)
                && start.proximity.gaps.iter().all(|g| *g >= 0.0);
            if is_open && let Some(friction) = friction {
                friction.clear_forces();
            }
            if is_open || error <= self.tolerance * depth + ROUND_OFF * reach {
                self.load(work.state, work.found);
                return Ok(report);
            }
            report.add(self.solve(pass, work)?);
            work.found.n_passes += 1;
            depth = work.buffers.free_gaps.iter().fold(0.0, |d, g| d.max(-g));
            if let (Some(friction), Some(both)) = (&mut work.state.friction, self.both()) {
                friction.depth = depth;
                // A solution with friction costs several projections: loads follow their displacements before the next one.
                self.project(t, slack, relative, work)?;
                if self.error(work, depth) <= self.tolerance * depth + ROUND_OFF * reach {
                    self.load(work.state, work.found);
                    return Ok(report);
                }
                self.displace(both, work);
            }
        }
        Err(SolverFault::Passes { passes: MAX_PASSES, time: t, change: error, depth }.into())
    }

    /// Point forces of the penalty springs at the projection just made, where all modes are
    /// dynamic.
    fn press_springs(&self, work: &mut Work<'_>) -> Result<(), EvaluationFailure> {
        let PairState { start: WarmStart { proximity, forces, .. }, friction, .. } = &mut *work.state;
        for ((force, &gap), &area) in forces.iter_mut().zip(&proximity.gaps).zip(&self.areas) {
            *force = area * penalty::pressure(self.settings.penalty, gap);
        }
        if let Some(friction) = friction {
            friction.point_along_slips(&work.found.jacobian);
            friction.stick_slip.solve_points(&friction.slips, forces)?;
            friction.depth = proximity.gaps.iter().fold(0.0, |d, g| d.max(-g));
        }
        self.load(work.state, work.found);
        Ok(())
    }

    /// Projects the displaced points on the displaced target; gaps, normals and functions there.
    /// Points that are open for certain are left as they are
    /// ([`super::projection::proximity_cache::ProximityCache`]).
    fn project(
        &self,
        t: f64,
        slack: f64,
        relative: &RelativePose,
        work: &mut Work<'_>,
    ) -> Result<(), EvaluationFailure> {
        let nc = self.motion.n_components();
        let PairState { start, friction, .. } = &mut *work.state;
        let Buffers { functions, samples, normals, low_points, low_nodes, .. } = &mut *work.buffers;
        let PairFound { points, nodes, points_in_target, is_wanted, projections, jacobian, .. } =
            &mut *work.found;
        displace(nc, low_points, &start.body, points);
        displace(nc, low_nodes, &start.nodes, nodes);
        points_in_target.iter_mut().zip(&*points).for_each(|(x, p)| *x = relative.transform_point(p));
        let WarmStart { proximity, forces, is_known, places, .. } = start;
        // With friction, the places of points that may soon be loaded are needed as references.
        let margin = friction.as_ref().map_or(0.0, |f| MARGIN * f.depth);
        let shift = proximity.choose(points_in_target, nodes, forces, is_known.then_some(margin), is_wanted);
        self.surface.normals(nodes, normals);
        let displaced = Displaced { surface: &self.surface, nodes, normals, slack };
        if let Some(friction) = friction {
            friction.begin(nodes);
            (0..self.points.len()).filter(|i| !is_wanted[*i]).for_each(|i| friction.clear_slip(i));
        }
        let mut is_sampled = false;
        for i in (0..self.points.len()).filter(|i| is_wanted[*i]) {
            let point = points_in_target[i];
            let from = is_known.then_some(places[i]);
            let search = (&mut *samples, &mut is_sampled);
            let mut found = self.project_point((i, &point), from, relative, (displaced, functions), search);
            if !found.is_beyond && self.surface.is_joined() {
                found = displaced.across_seams(found, samples, &mut is_sampled, functions);
            }
            let gap = found.distance(&point);
            if !gap.is_finite() || !found.normal[0].is_finite() {
                return Err(SolverFault::Gap { point: i, gap, time: t }.into());
            }
            found.is_at_edge = gap < 0.0 && displaced.is_at_edge(&found, self.rim_reach, functions);
            places[i] = found.place;
            // A point beyond the end is projected every time, to see whether it stays there.
            let is_held = found.is_beyond && !self.surface.is_complete;
            proximity.note(i, &point, gap, if is_held { f64::INFINITY } else { shift });
            projections[i] = found;
            jacobian.set(i, &found, relative.inverse_transform_vector(&found.normal), functions.values());
            match friction {
                Some(friction) if found.is_on_plane => {
                    friction.set_slip_on_plane(i, &found, relative, jacobian);
                }
                Some(friction) => {
                    friction.set_slip(i, displaced, (&found, &point, gap), functions, relative, jacobian);
                }
                None => {}
            }
        }
        *is_known = true;
        Ok(())
    }

    /// Projection of the point `i` at `point`, from its last place `from` if it is known; `samples`
    /// of the surface are moved with it when they are first needed.
    pub(super) fn project_point(
        &self,
        (i, point): (usize, &[f64; 3]),
        from: Option<SurfacePlace>,
        relative: &RelativePose,
        (displaced, functions): (Displaced<'_>, &mut Functions),
        (samples, is_sampled): (&mut Samples, &mut bool),
    ) -> Projection {
        if let Some(found) = self.on_meeting_plane(i, point, displaced, functions) {
            return found;
        }
        let start = from.unwrap_or_else(|| {
            samples.update_once(displaced, is_sampled);
            samples.nearest(point)
        });
        let found = displaced.closest_from(&start, point, functions);
        if self.surface.is_complete {
            let facing = self.facing.get(i).map(|normal| relative.transform_vector(normal));
            if from.is_none() || !displaced.may_stand(&found, facing.as_ref()) {
                samples.update_once(displaced, is_sampled);
                let known = from.map(|_| &found);
                return displaced.on_all_faces(point, (known, facing.as_ref()), samples, functions);
            }
        } else if found.is_beyond && self.surface.is_joined() {
            // Another face may be nearer, or go on from there.
            samples.update_once(displaced, is_sampled);
            return displaced.on_joined_faces(found, point, samples, functions);
        }
        found
    }

    /// Error of the last pass: the largest difference of the gaps on the displaced surfaces from
    /// those that the solver used, with the change of gaps that the shift of the loads since then
    /// causes at a penetration of `depth`.
    fn error(&self, work: &Work<'_>, depth: f64) -> f64 {
        let (w, WarmStart { forces, deflections, .. }) = (&*work.buffers, &work.state.start);
        let gaps = work.state.gaps();
        let is_near = |i: usize| forces[i] > 0.0 || gaps[i] < 0.0;
        let near = (0..gaps.len()).filter(|i| is_near(*i));
        let error = near.fold(0.0_f64, |e, i| e.max((gaps[i] - w.free_gaps[i] - deflections[i]).abs()));
        let moved = work.found.jacobian.moved(&w.loaded, &self.surface, is_near);
        let mut error = error.max(LOAD_SHIFT * depth * moved);
        if let Some(f) = &work.state.friction {
            for k in (0..f.slips.len()).filter(|k| forces[k / f.n_t] > 0.0) {
                error = error.max((f.slips[k] - f.free_slips[k] - f.deflections[k]).abs());
            }
            // The error that the alternations between normal and friction forces have left.
            error = error.max(depth * f.alternation_tolerance);
        }
        error
    }

    /// One solution at the projection just made, and the displacements under its forces (Eq. C.41).
    fn solve(&self, pass: usize, work: &mut Work<'_>) -> Result<SolveReport, EvaluationFailure> {
        let (Some(both), PairState { start, zone: Some(zone), friction, .. }) =
            (self.both(), &mut *work.state)
        else {
            return Ok(SolveReport::default());
        };
        let (w, jacobian) = (&mut *work.buffers, &work.found.jacobian);
        let WarmStart { proximity, forces, deflections, .. } = start;
        let gaps = &proximity.gaps;
        let is_near = |i: usize| forces[i] > 0.0 || gaps[i] < 0.0;
        let moved = zone.moved(jacobian, &self.surface, is_near);
        // If passes do not converge, the compliance is projected anew, so that an old projection
        // cannot be the reason.
        let is_new = moved > REUSE || (pass > 10 && moved > 0.0);
        let has_others = is_new || zone.lacks(is_near);
        let depth =
            |deflections: &[f64]| gaps.iter().zip(deflections).fold(0.0_f64, |d, (g, s)| d.max(s - g));
        if has_others {
            let depth = depth(deflections);
            let is_member = |i: usize| is_near(i) || gaps[i] < MARGIN * depth;
            zone.take((jacobian, is_new), is_member, |i| gaps[i] - deflections[i]);
        }
        let mut stick_slip = friction.as_mut().map(|f| &mut f.stick_slip);
        let (surfaces, members) = zone.surfaces(both);
        if !stick_slip.as_mut().is_some_and(|s| s.take(&surfaces, |i| members.contains(i), &self.springs)) {
            zone.project(both, stick_slip);
        }
        // Of these forces, with these compliances, they are left from the solution before.
        match friction {
            _ if !has_others => {}
            None => zone.deflect(forces, deflections),
            Some(f) => {
                let of_normal = |gaps: &mut [f64]| zone.deflect(forces, gaps);
                f.stick_slip.deflect(of_normal, forces, deflections, &mut f.deflections);
            }
        }
        if let Some(f) = friction {
            let depth = depth(deflections);
            f.alternation_tolerance =
                f.alternation_tolerance_for(self.tolerance, gaps, &self.springs, forces, depth);
            for ((free, slip), deflection) in f.free_slips.iter_mut().zip(&f.slips).zip(&f.deflections) {
                *free = slip - deflection;
            }
        }
        for ((free, gap), deflection) in w.free_gaps.iter_mut().zip(gaps).zip(&*deflections) {
            *free = gap - deflection;
        }
        if self.surface.is_complete {
            // No face may press these points where they are, however near the surface is.
            let open =
                work.found.projections.iter().zip(&mut w.free_gaps).filter(|(found, _)| found.is_beyond);
            open.for_each(|(_, free)| *free = OPEN);
        }
        let report = match friction {
            None => zone.solve_normal(&self.springs, &w.free_gaps, forces)?,
            Some(f) => {
                let (tolerance, slips) = (f.alternation_tolerance, &f.free_slips);
                let given = (&*w.free_gaps, slips.as_slice());
                match f.stick_slip.solve_taken(tolerance, &self.springs, given, forces) {
                    Some(report) => report,
                    None => {
                        zone.project(both, Some(&mut f.stick_slip));
                        f.stick_slip.solve(tolerance, zone, &self.springs, given, forces)?
                    }
                }
            }
        };
        match friction {
            None => zone.deflect_solved(&self.springs, &w.free_gaps, forces, deflections),
            Some(f) => {
                let of_normal =
                    |gaps: &[f64], out: &mut [f64]| zone.deflect_solved(&self.springs, gaps, forces, out);
                let PairFriction { stick_slip, free_slips, deflections: slips, .. } = &mut **f;
                stick_slip.deflect_solved(of_normal, (free_slips, forces), deflections, slips);
            }
        }
        self.displace(both, work);
        Ok(report)
    }

    /// Loads of the forces at the projection just made, and the quasistatic displacements of the points and of the target's nodes under
    /// them.
    fn displace(&self, both: PairBodies<'_>, work: &mut Work<'_>) {
        let Work { state, found, buffers } = work;
        self.load(state, found);
        buffers.loaded.copy_from(&found.jacobian);
        if let Some(zone) = &mut state.zone {
            zone.displace_body(both.compliances, &found.loads, &mut state.start.body);
        }
        if !self.surface.is_quasistatic() {
            return;
        }
        let PairFound { interface_loads, interface_displacements, .. } = found;
        interface_displacements.fill(0.0);
        add_product(&self.surface.compliance, interface_loads, interface_displacements);
        for (u, dof) in state.start.nodes.iter_mut().zip(&self.surface.dofs) {
            *u = dof.map_or(0.0, |b| interface_displacements[b as usize]);
        }
    }
}

/// Places plus displacements.
fn displace(nc: usize, places: &[[f64; 3]], displacements: &[f64], out: &mut [[f64; 3]]) {
    for ((x, low), u) in out.iter_mut().zip(places).zip(displacements.chunks_exact(nc)) {
        *x = *low;
        x.iter_mut().zip(u).for_each(|(x, u)| *x += u);
    }
}

/// Adds the displacements `columns q` to `places`, four columns at a time: a place is loaded and
/// stored once for them.
fn deform(columns: &[f64], q: &[f64], places: &mut [[f64; 3]]) {
    let places = places.as_flattened_mut();
    let n = places.len().max(1);
    for (columns, q) in columns.chunks(4 * n).zip(q.chunks(4)).filter(|(_, q)| q.iter().any(|q| *q != 0.0)) {
        if let [x, y, z, w] = *q {
            let (first, second) = columns.split_at(2 * n);
            let ((a, b), (c, d)) = (first.split_at(n), second.split_at(n));
            for ((((place, a), b), c), d) in places.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                *place += (x * a + y * b) + (z * c + w * d);
            }
        } else {
            for (column, q) in columns.chunks_exact(n).zip(q) {
                places.iter_mut().zip(column).for_each(|(place, shape)| *place += q * shape);
            }
        }
    }
}
