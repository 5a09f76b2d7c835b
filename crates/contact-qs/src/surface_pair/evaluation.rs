//! One evaluation of a surface pair: projection, point forces, their sums.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::system::force::{BodyState, GeneralisedForce};
use nalgebra::Vector3;

use super::SurfacePair;
use super::friction::move_back;
use super::motion::{Relative, resultant};
use super::projection::{Displaced, Functions, Projection, Samples, SurfacePlace};
use super::rows::Rows;
use super::solver::dot;
use super::watch::Watch;
use crate::contact_element::ContactReport;
use crate::law::penalty;
use crate::quasistatic::SolveReport;
use crate::quasistatic::problem::add_product;
use crate::quasistatic::stick_slip::NormalSolver;

/// Passes of projection and solution. Each one leaves about the ratio of contact radius and body's radius of the error, a
/// few per cent.
const MAX_PASSES: usize = 40;
/// Error of the projected gaps at convergence, as a share of the deepest penetration.
pub(super) const GAP_TOLERANCE: f64 = 1e-8;
/// Change of gaps, as a share of the penetration, when loads move by one element or turn by one radian. Measured 0.13: the
/// displacement under a load of the neighbouring element, of which there are several on a contact radius.
const LOAD_SHIFT: f64 = 0.2;
/// The compliance projected before serves until normals (in radians) or places (in elements) have moved by this.
///
/// It is only the derivative of the fixed-point iteration, whose gaps are taken on the displaced surfaces: an error of this
/// size can slow convergence to about this ratio a pass, no more than the passes leave anyway, and changes no result. Balls
/// that slide need 4.7 passes with 0.05 and with 0.01.
const REUSE: f64 = 5e-2;

/// Points nearer than this part of the penetration are counted among those that may touch when compliances are projected.
/// Around a Hertz contact of radius `a` the gap is that large at `1.35 a` (Johnson 1985, Eq. 3.42a).
const MARGIN: f64 = 0.25;

/// The power of sliding is taken from a moment ago, in which the bodies moved by this share of the penetration: slips are known
/// to some 1e-8 of it, and rates change by some such share.
const MOMENT: f64 = 3e-4;

/// What changes from one evaluation to the next and serves as a warm start.
#[derive(Debug, Clone)]
pub(super) struct WarmStart {
    pub forces: Vec<f64>,
    /// Quasistatic displacements of the contact body's points, components in turn.
    pub own: Vec<f64>,
    /// Quasistatic displacements of the target's nodes.
    pub nodes: Vec<f64>,
    pub places: Vec<SurfacePlace>,
    /// Whether places are known.
    pub is_known: bool,
    pub watch: Watch,
}

impl WarmStart {
    pub fn copy_from(&mut self, other: &Self) {
        self.forces.copy_from_slice(&other.forces);
        self.own.copy_from_slice(&other.own);
        self.nodes.copy_from_slice(&other.nodes);
        self.places.copy_from_slice(&other.places);
        self.is_known = other.is_known;
        self.watch.copy_from(&other.watch);
    }
}

/// Buffers of an evaluation.
pub(super) struct Workspace {
    pub functions: Functions,
    pub samples: Samples,
    /// Points of the contact body without and with quasistatic displacement, in its frame.
    pub low_points: Vec<[f64; 3]>,
    pub points: Vec<[f64; 3]>,
    /// Nodes of the target without and with quasistatic displacement.
    pub low_nodes: Vec<[f64; 3]>,
    pub nodes: Vec<[f64; 3]>,
    /// Displaced points in the target's frame.
    pub seen: Vec<[f64; 3]>,
    /// Points to be projected.
    pub is_wanted: Vec<bool>,
    pub projections: Vec<Projection>,
    pub rows: Rows,
    /// Rows of the last loads.
    pub loaded: Rows,
    pub free_gaps: Vec<f64>,
    /// `A λ` of the last solution.
    pub settled: Vec<f64>,
    /// Forces on the contact body's points, components in turn.
    pub loads: Vec<f64>,
    /// Forces on the target's nodes.
    pub node_loads: Vec<f64>,
    /// Forces on the target's interface freedoms and their displacements.
    pub interface_loads: Vec<f64>,
    pub interface_displacements: Vec<f64>,
}

impl SurfacePair {
    /// Poses of contact body and target.
    pub(super) fn states<'a>(&'a self, bodies: &'a [BodyState]) -> (&'a BodyState, &'a BodyState) {
        let target = self.settings.target_body.map_or(&self.ground, |b| &bodies[b]);
        (&bodies[self.settings.contact_body], target)
    }

    /// Places of points and nodes under the low modes alone.
    pub(super) fn place_low(
        &self,
        own: &BodyState,
        target: &BodyState,
        points: &mut [[f64; 3]],
        nodes: &mut [[f64; 3]],
    ) {
        let nc = self.motion.n_components();
        points.copy_from_slice(&self.points);
        deform(nc, &self.low_columns, &own.elastic, points);
        nodes.copy_from_slice(&self.surface.nodes);
        deform(nc, &self.surface.low_columns, &target.elastic, nodes);
    }

    /// Finds point forces, projections and displacements at the motions `own` and `target`.
    pub(super) fn find_forces(
        &mut self,
        t: f64,
        own: &BodyState,
        target: &BodyState,
    ) -> Result<SolveReport, EvaluationFailure> {
        let relative = Relative::new(self.motion, own, target)?;
        let mut w = self.workspace.take().ok_or_else(no_workspace)?;
        self.place_low(own, target, &mut w.low_points, &mut w.low_nodes);
        let result = self.iterate(t, &relative, &mut w);
        self.workspace = Some(w);
        result
    }

    /// Finds the slip increments a moment before the motions `own` and `target`, for the power lost to sliding; returns how long
    /// before, none if nothing moves.
    pub(super) fn look_back(
        &mut self,
        t: f64,
        own: &BodyState,
        target: &BodyState,
    ) -> Result<Option<f64>, EvaluationFailure> {
        let speed = self.speed(own, target);
        let Some(friction) = &mut self.friction else { return Ok(None) };
        let time = friction.look_back_time(t, MOMENT * friction.depth / speed);
        if !(time.is_finite() && time > 0.0) {
            return Ok(None);
        }
        let mut moment = friction.moment.take().ok_or_else(no_workspace)?;
        move_back(own, time, &mut moment[0]);
        move_back(target, time, &mut moment[1]);
        let found = self.find_forces(t, &moment[0], &moment[1]);
        if let Some(friction) = &mut self.friction {
            friction.moment = Some(moment);
            friction.note_earlier(&self.state.forces);
        }
        found.map(|_| Some(time))
    }

    /// Largest speed of the points in contact relative to the target, that of the modes taken at one of them; a function of the
    /// motion and the remembered state alone.
    fn speed(&self, own: &BodyState, target: &BodyState) -> f64 {
        let nc = self.motion.n_components();
        let is_axial = self.motion == RigidMotion::Axial;
        let (mut largest, mut of_modes) = (0.0_f64, None);
        for i in (0..self.points.len()).filter(|i| self.state.forces[*i] > 0.0) {
            let mut difference = own.velocity - target.velocity;
            if !is_axial {
                let arm = own.rotation * Vector3::from(self.points[i]);
                let spin = own.rotation * own.angular_velocity;
                difference += spin.cross(&arm);
                let spin = target.rotation * target.angular_velocity;
                difference -= spin.cross(&(own.position + arm - target.position));
            }
            largest = largest.max(difference.norm());
            of_modes.get_or_insert_with(|| {
                let place = &self.state.places[i];
                let element = self.surface.faces[place.face as usize].element(&place.xi);
                let node = self.surface.elements[element].nodes.first().map_or(0, |node| *node as usize);
                (0..nc).fold(0.0_f64, |sum, c| {
                    let own = dot(self.own_row(nc * i + c), &own.elastic_rates);
                    sum.hypot(own).hypot(dot(self.surface.low_row(nc * node + c), &target.elastic_rates))
                })
            });
        }
        largest + of_modes.unwrap_or(0.0)
    }

    /// Projects the points and the compliances on them without forces.
    pub(super) fn project_for_compliance(&mut self, bodies: &[BodyState]) -> Result<(), EvaluationFailure> {
        let (own, target) = self.states(bodies);
        let relative = Relative::new(self.motion, own, target)?;
        let mut w = self.workspace.take().ok_or_else(no_workspace)?;
        let (own, target) = self.states(bodies);
        self.place_low(own, target, &mut w.low_points, &mut w.low_nodes);
        let result = self.project(0.0, &relative, &mut w);
        if let (Ok(()), Some(zone)) = (&result, &mut self.zone) {
            let stick_slip = self.friction.as_mut().map(|f| &mut f.stick_slip);
            zone.build(&self.surface, &w.rows, stick_slip, |_| true);
        }
        self.workspace = Some(w);
        result
    }

    fn iterate(
        &mut self,
        t: f64,
        relative: &Relative,
        w: &mut Workspace,
    ) -> Result<SolveReport, EvaluationFailure> {
        let mut report = SolveReport::default();
        self.n_passes = 0;
        let reach = self.surface.size + relative.reach();
        let (mut depth, mut error) = (0.0_f64, f64::INFINITY);
        for pass in 0..MAX_PASSES {
            self.project(t, relative, w)?;
            if self.zone.is_none() {
                let gaps = &self.state.watch.gaps;
                for ((force, &gap), &area) in self.state.forces.iter_mut().zip(gaps).zip(&self.areas) {
                    *force = area * penalty::pressure(self.settings.penalty, gap);
                }
                if let Some(friction) = &mut self.friction {
                    friction.point_along_slips(&w.rows);
                    friction.stick_slip.solve_points(&friction.slips, &self.state.forces)?;
                    friction.depth = gaps.iter().fold(0.0, |d, g| d.max(-g));
                }
                self.load(w);
                return Ok(report);
            }
            if pass > 0 {
                error = self.error(w, depth);
            }
            let is_open = pass == 0
                && self.state.forces.iter().all(|f| *f <= 0.0)
                && self.state.watch.gaps.iter().all(|g| *g >= 0.0);
            // Round-off of positions bounds what can be asked of gaps.
            if is_open && let Some(friction) = &mut self.friction {
                friction.stick_slip.clear_forces();
            }
            if is_open || error <= self.tolerance * depth + 8.0 * f64::EPSILON * reach {
                self.load(w);
                return Ok(report);
            }
            let solved = self.solve(pass, w)?;
            self.n_passes += 1;
            report.hit_iteration_limit |= solved.hit_iteration_limit;
            report.iterations += solved.iterations;
            report.factorisations += solved.factorisations;
            report.fallbacks += solved.fallbacks;
            depth = w.free_gaps.iter().fold(0.0, |d, g| d.max(-g));
            if let Some(friction) = &mut self.friction {
                friction.depth = depth;
            }
        }
        let reason = format!(
            "projection and deformation of a contact have not met after {MAX_PASSES} passes at t = {t:.9e} s: gaps change by {error:.3e} m at a penetration of {depth:.3e} m, refine the contact zone"
        );
        Err(EvaluationFailure::iteration_limit(reason))
    }

    /// Projects the displaced points on the displaced target; gaps, normals and functions there. Points that are open for
    /// certain are left as they are ([`Watch`]).
    fn project(&mut self, t: f64, relative: &Relative, w: &mut Workspace) -> Result<(), EvaluationFailure> {
        let nc = self.motion.n_components();
        displace(nc, &w.low_points, &self.state.own, &mut w.points);
        displace(nc, &w.low_nodes, &self.state.nodes, &mut w.nodes);
        w.seen.iter_mut().zip(&w.points).for_each(|(x, p)| *x = relative.point(p));
        let WarmStart { watch, forces, is_known, .. } = &mut self.state;
        // With friction, points that may soon be loaded shall know where they were.
        let margin = self.friction.as_ref().map_or(0.0, |f| MARGIN * f.depth);
        let shift = watch.choose(&w.seen, &w.nodes, forces, is_known.then_some(margin), &mut w.is_wanted);
        let displaced = Displaced { surface: &self.surface, nodes: &w.nodes };
        if !self.state.is_known {
            w.samples.update(displaced);
        }
        if let Some(friction) = &mut self.friction {
            friction.begin(&w.nodes);
            (0..self.points.len()).filter(|i| !w.is_wanted[*i]).for_each(|i| friction.leave(i));
        }
        for i in (0..self.points.len()).filter(|i| w.is_wanted[*i]) {
            let point = w.seen[i];
            let start = if self.state.is_known { self.state.places[i] } else { w.samples.nearest(&point) };
            let mut found = displaced.closest_from(&start, &point, &mut w.functions);
            if found.is_beyond && self.surface.faces.len() > 1 {
                // Another face may be nearer.
                w.samples.update(displaced);
                found = displaced.closest_from(&w.samples.nearest(&point), &point, &mut w.functions);
            }
            let gap = found.distance(&point);
            if !gap.is_finite() || !found.normal[0].is_finite() {
                let reason = format!("the gap of contact point {i} is {gap} at t = {t:.9e} s");
                return Err(EvaluationFailure::not_finite(reason));
            }
            self.state.places[i] = found.place;
            // Whether a point beyond the end stays there is seen at every look.
            self.state.watch.note(i, &point, gap, if found.is_beyond { f64::INFINITY } else { shift });
            w.projections[i] = found;
            w.rows.set(i, &found, relative.back(&found.normal), w.functions.values());
            if let Some(friction) = &mut self.friction {
                friction.look(i, displaced, (&found, gap), &w.functions, relative, &mut w.rows);
            }
        }
        self.state.is_known = true;
        Ok(())
    }

    /// Largest difference of the gaps on the displaced surfaces from those that the solver counted with, and what the
    /// shift of the loads since then is worth at a penetration of `depth`.
    fn error(&self, w: &Workspace, depth: f64) -> f64 {
        let gaps = &self.state.watch.gaps;
        let is_near = |i: usize| self.state.forces[i] > 0.0 || gaps[i] < 0.0;
        let near = (0..gaps.len()).filter(|i| is_near(*i));
        let error = near.fold(0.0_f64, |e, i| e.max((gaps[i] - w.free_gaps[i] - w.settled[i]).abs()));
        let mut error = error.max(LOAD_SHIFT * depth * w.rows.moved(&w.loaded, &self.surface, is_near));
        if let Some(f) = &self.friction {
            for k in (0..f.slips.len()).filter(|k| self.state.forces[k / f.n_t] > 0.0) {
                error = error.max((f.slips[k] - f.free_slips[k] - f.settled[k]).abs());
            }
            // What the turns between normal and friction forces have left.
            error = error.max(depth * f.turn_tolerance);
        }
        error
    }

    /// One solution at the projection just made, and the displacements under its forces (Eq. C.40).
    fn solve(&mut self, pass: usize, w: &mut Workspace) -> Result<SolveReport, EvaluationFailure> {
        let Some(zone) = &mut self.zone else { return Ok(SolveReport::default()) };
        let gaps = &self.state.watch.gaps;
        let is_near = |i: usize| self.state.forces[i] > 0.0 || gaps[i] < 0.0;
        let moved = zone.moved(&w.rows, &self.surface, is_near);
        // Should passes make no headway, the old projection is not to blame.
        let is_new = moved > REUSE || (pass > 10 && moved > 0.0);
        if is_new {
            let depth = gaps.iter().zip(&w.settled).fold(0.0_f64, |d, (g, s)| d.max(s - g));
            let stick_slip = self.friction.as_mut().map(|f| &mut f.stick_slip);
            let is_member = |i: usize| is_near(i) || gaps[i] < MARGIN * depth;
            zone.build(&self.surface, &w.rows, stick_slip, is_member);
        }
        w.loaded.copy_from(&w.rows);
        // The solution before has left the products of these forces with this compliance.
        if is_new || pass == 0 {
            zone.settle(&self.state.forces, &mut w.settled);
            if let Some(f) = &mut self.friction {
                f.stick_slip.settle(&self.state.forces, &mut w.settled, &mut f.settled);
            }
        }
        if let Some(f) = &mut self.friction {
            let depth = gaps.iter().zip(&w.settled).fold(0.0_f64, |d, (g, s)| d.max(s - g));
            f.turn_tolerance =
                f.tolerance_of_turns(self.tolerance, gaps, &self.springs, &self.state.forces, depth);
            for ((free, slip), settled) in f.free_slips.iter_mut().zip(&f.slips).zip(&f.settled) {
                *free = slip - settled;
            }
        }
        for ((free, gap), settled) in w.free_gaps.iter_mut().zip(gaps).zip(&w.settled) {
            *free = gap - settled;
        }
        let forces = &mut self.state.forces;
        let report = match &mut self.friction {
            None => zone.solve_normal(&self.springs, &w.free_gaps, forces)?,
            Some(f) => {
                let slips = &f.free_slips;
                f.stick_slip.solve_within(
                    f.turn_tolerance,
                    zone,
                    &self.springs,
                    &w.free_gaps,
                    slips,
                    forces,
                )?
            }
        };
        zone.settle(forces, &mut w.settled);
        if let Some(f) = &mut self.friction {
            f.stick_slip.settle(forces, &mut w.settled, &mut f.settled);
        }
        self.load(w);
        if let Some(zone) = &self.zone {
            zone.own_displacements(&w.loads, &mut self.state.own);
        }
        self.displace_target(w);
        Ok(report)
    }

    /// Components of the point forces on both bodies at the last projection.
    fn load(&self, w: &mut Workspace) {
        let nc = self.motion.n_components();
        w.loads.fill(0.0);
        w.node_loads.fill(0.0);
        for (i, &normal) in self.state.forces.iter().enumerate().filter(|(_, f)| **f > 0.0) {
            let tangential = self.friction.as_ref().map_or(&[][..], |f| f.force(i));
            for (d, &force) in std::iter::once(&normal).chain(tangential).enumerate() {
                let load = w.loads[nc * i..][..nc].iter_mut();
                load.zip(w.rows.own_direction(i, d)).for_each(|(l, x)| *l += force * x);
                for (node, share) in w.rows.shares(&self.surface, i, d) {
                    let load = w.node_loads[nc * node as usize..][..nc].iter_mut();
                    load.zip(share).for_each(|(l, x)| *l -= force * x);
                }
            }
        }
        w.interface_loads.fill(0.0);
        if !w.interface_loads.is_empty() {
            for (load, freedom) in w.node_loads.iter().zip(&self.surface.freedoms) {
                if let Some(b) = freedom {
                    w.interface_loads[*b as usize] = *load;
                }
            }
        }
    }

    /// Quasistatic displacements of the target's nodes under the loads.
    fn displace_target(&mut self, w: &mut Workspace) {
        if !self.surface.is_quasistatic() {
            return;
        }
        w.interface_displacements.fill(0.0);
        add_product(&self.surface.compliance, &w.interface_loads, &mut w.interface_displacements);
        for (u, freedom) in self.state.nodes.iter_mut().zip(&self.surface.freedoms) {
            *u = freedom.map_or(0.0, |b| w.interface_displacements[b as usize]);
        }
    }

    /// Sums up the last evaluation, whose target stands at `target`.
    pub(super) fn sum_up(&mut self, solver: SolveReport, target: &BodyState) {
        let Some(w) = &self.workspace else { return };
        let mut report = ContactReport { solver, ..ContactReport::default() };
        let (mut sum, mut friction) = ([0.0; 3], [0.0; 3]);
        for (i, &force) in self.state.forces.iter().enumerate() {
            let gap = self.state.watch.gaps[i];
            report.penetration = report.penetration.max(-gap);
            let found = &w.projections[i];
            // Beyond the end and below the surface: the target is too small.
            report.is_rim_touched |= found.is_beyond && found.gap < 0.0 && gap < self.rim_reach;
            if force > 0.0 {
                report.normal_force += force;
                report.n_active += 1;
                report.contact_area += self.areas[i];
                report.is_rim_touched |=
                    self.is_rim[i] || !self.surface.elements[found.element as usize].is_in_zone;
                (0..3).for_each(|c| sum[c] += force * found.normal[c]);
                let tangential = self.friction.as_ref().map_or(&[][..], |f| f.force(i));
                for (a, force) in tangential.iter().enumerate() {
                    let direction = w.rows.direction(i, a + 1);
                    friction.iter_mut().zip(direction).for_each(|(s, x)| *s += force * x);
                }
                report.energies.penalty += 0.5 * force * force * self.springs[i];
            }
        }
        report.energies.elastic_high =
            0.5 * (dot(&w.loads, &self.state.own) + dot(&w.interface_loads, &w.interface_displacements));
        if report.n_active == 0 {
            report.energies.elastic_high = 0.0;
        }
        report.force = resultant(self.motion, &target.rotation, &sum);
        if let Some(law) = &self.friction {
            report.friction_force = resultant(self.motion, &target.rotation, &friction);
            report.force += report.friction_force;
            report.n_sliding = law.n_sliding(&self.state.forces);
            if report.n_active > 0 {
                report.energies.penalty += law.stick_slip.spring_energy();
            }
        }
        self.report = report;
    }

    /// Adds the point forces to the contact body, their opposites to the target (Eqs. C.41, C.42).
    pub(super) fn push(&self, bodies: &[BodyState], forces: &mut [GeneralisedForce]) {
        let Some(w) = &self.workspace else { return };
        let nc = self.motion.n_components();
        let own = &mut forces[self.settings.contact_body];
        own.force += self.report.force;
        for (row, &load) in w.loads.iter().enumerate().filter(|(_, l)| **l != 0.0) {
            own.elastic.iter_mut().zip(self.own_row(row)).for_each(|(f, s)| *f += s * load);
        }
        let is_turning = self.motion != RigidMotion::Axial;
        let active = || (0..self.points.len()).filter(|i| is_turning && self.state.forces[*i] > 0.0);
        for i in active() {
            let mut force = Vector3::zeros();
            force.iter_mut().zip(&w.loads[nc * i..][..nc]).for_each(|(f, l)| *f = *l);
            own.torque += Vector3::from(w.points[i]).cross(&force);
        }
        let Some(body) = self.settings.target_body else { return };
        debug_assert_eq!(bodies[body].elastic.len(), self.surface.n_modes);
        let target = &mut forces[body];
        target.force -= self.report.force;
        for (row, &load) in w.node_loads.iter().enumerate().filter(|(_, l)| **l != 0.0) {
            debug_assert!(row / nc < self.surface.nodes.len());
            target.elastic.iter_mut().zip(self.surface.low_row(row)).for_each(|(f, s)| *f += s * load);
        }
        for i in active() {
            let mut force = Vector3::from(w.rows.normals[i]) * self.state.forces[i];
            if let Some(friction) = &self.friction {
                for (a, tangential) in friction.force(i).iter().enumerate() {
                    force += Vector3::from(w.rows.direction(i, a + 1)) * *tangential;
                }
            }
            // At the same point of space as the force on the contact body.
            target.torque -= Vector3::from(w.seen[i]).cross(&force);
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

/// Adds the displacements `columns q` to `places`.
fn deform(nc: usize, columns: &[f64], q: &[f64], places: &mut [[f64; 3]]) {
    let n_rows = nc * places.len();
    for (column, &q) in columns.chunks_exact(n_rows.max(1)).zip(q).filter(|(_, q)| **q != 0.0) {
        if nc == 3 {
            let places = places.as_flattened_mut();
            places.iter_mut().zip(column).for_each(|(x, shape)| *x += q * shape);
        } else {
            for (x, shapes) in places.iter_mut().zip(column.chunks_exact(nc)) {
                x.iter_mut().zip(shapes).for_each(|(x, shape)| *x += q * shape);
            }
        }
    }
}

fn no_workspace() -> EvaluationFailure {
    EvaluationFailure::out_of_model("a contact was evaluated from within itself")
}
