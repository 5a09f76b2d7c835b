//! One evaluation of a surface pair: projection, point forces, their sums.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::error::Rejection;
use ffr_dynamics::system::force::{BodyState, GeneralisedForce};
use nalgebra::Vector3;

use super::SurfacePair;
use super::motion::{Relative, resultant};
use super::projection::{Displaced, Functions, Projection, Samples, SurfacePlace};
use super::solver::{Rows, dot};
use crate::contact_element::ContactReport;
use crate::law::penalty;
use crate::quasistatic::SolveReport;

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
/// size can slow convergence to about this ratio a pass, less than the passes leave anyway, and changes no result.
const REUSE: f64 = 1e-2;

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
}

impl WarmStart {
    pub fn copy_from(&mut self, other: &Self) {
        self.forces.copy_from_slice(&other.forces);
        self.own.copy_from_slice(&other.own);
        self.nodes.copy_from_slice(&other.nodes);
        self.places.copy_from_slice(&other.places);
        self.is_known = other.is_known;
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
    pub projections: Vec<Projection>,
    pub rows: Rows,
    /// Rows of the last loads.
    pub loaded: Rows,
    pub gaps: Vec<f64>,
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
        for (i, point) in points.iter_mut().enumerate() {
            *point = self.points[i];
            (0..nc).for_each(|c| point[c] += dot(self.own_row(nc * i + c), &own.elastic));
        }
        for (a, node) in nodes.iter_mut().enumerate() {
            *node = self.surface.nodes[a];
            (0..nc).for_each(|c| node[c] += dot(self.surface.low_row(nc * a + c), &target.elastic));
        }
    }

    /// Finds point forces, projections and displacements at the motion `bodies`.
    pub(super) fn find_forces(&mut self, t: f64, bodies: &[BodyState]) -> Result<SolveReport, Rejection> {
        let (own, target) = self.states(bodies);
        let relative = Relative::new(self.motion, own, target)?;
        let mut w = self.workspace.take().ok_or_else(no_workspace)?;
        let (own, target) = self.states(bodies);
        self.place_low(own, target, &mut w.low_points, &mut w.low_nodes);
        let result = self.iterate(t, &relative, &mut w);
        self.workspace = Some(w);
        result
    }

    /// Projects the points and the compliances on them without forces.
    pub(super) fn project_for_compliance(&mut self, bodies: &[BodyState]) -> Result<(), Rejection> {
        let (own, target) = self.states(bodies);
        let relative = Relative::new(self.motion, own, target)?;
        let mut w = self.workspace.take().ok_or_else(no_workspace)?;
        let (own, target) = self.states(bodies);
        self.place_low(own, target, &mut w.low_points, &mut w.low_nodes);
        let result = self.project(0.0, &relative, &mut w, f64::INFINITY);
        if let (Ok(()), Some(zone)) = (&result, &mut self.zone) {
            zone.build(&self.surface, &w.rows);
        }
        self.workspace = Some(w);
        result
    }

    fn iterate(&mut self, t: f64, relative: &Relative, w: &mut Workspace) -> Result<SolveReport, Rejection> {
        let mut report = SolveReport::default();
        self.n_passes = 0;
        let reach = self.surface.size + relative.reach();
        let (mut depth, mut error) = (0.0_f64, f64::INFINITY);
        for pass in 0..MAX_PASSES {
            self.project(t, relative, w, if pass == 0 { f64::INFINITY } else { depth })?;
            if self.zone.is_none() {
                for ((force, &gap), &area) in self.state.forces.iter_mut().zip(&w.gaps).zip(&self.areas) {
                    *force = area * penalty::pressure(self.settings.penalty, gap);
                }
                self.load(w);
                return Ok(report);
            }
            if pass > 0 {
                error = self.error(w, depth);
            }
            let is_open =
                pass == 0 && self.state.forces.iter().all(|f| *f <= 0.0) && w.gaps.iter().all(|g| *g >= 0.0);
            // Round-off of positions bounds what can be asked of gaps.
            if is_open || error <= self.tolerance * depth + 8.0 * f64::EPSILON * reach {
                self.load(w);
                return Ok(report);
            }
            let solved = self.solve(pass, w)?;
            self.n_passes += 1;
            report.code = report.code.min(solved.code);
            report.iterations += solved.iterations;
            report.factorisations += solved.factorisations;
            report.fallbacks += solved.fallbacks;
            depth = w.free_gaps.iter().fold(0.0, |d, g| d.max(-g));
        }
        let reason = format!(
            "projection and deformation of a contact have not met after {MAX_PASSES} passes at t = {t:.9e} s: gaps change by {error:.3e} m at a penetration of {depth:.3e} m, refine the contact zone"
        );
        Err(Rejection { code: -1, reason })
    }

    /// Projects the displaced points on the displaced target; gaps, normals and functions there. Open points that are farther
    /// than `reach` away are left as they are: displacements that are still to come are smaller than the penetration.
    fn project(
        &mut self,
        t: f64,
        relative: &Relative,
        w: &mut Workspace,
        reach: f64,
    ) -> Result<(), Rejection> {
        let nc = self.motion.n_components();
        displace(nc, &w.low_points, &self.state.own, &mut w.points);
        displace(nc, &w.low_nodes, &self.state.nodes, &mut w.nodes);
        let displaced = Displaced { surface: &self.surface, nodes: &w.nodes };
        if !self.state.is_known {
            w.samples.update(displaced);
        }
        for i in 0..self.points.len() {
            if self.state.forces[i] <= 0.0 && w.gaps[i] > reach {
                continue;
            }
            let point = relative.point(&w.points[i]);
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
                return Err(Rejection { code: 2, reason });
            }
            self.state.places[i] = found.place;
            w.gaps[i] = gap;
            w.projections[i] = found;
            w.rows.normals[i] = found.normal;
            w.rows.own_normals[i] = relative.back(&found.normal);
            w.rows.elements[i] = found.element;
            w.rows.places[i] = found.place;
            let width = w.rows.width;
            let slots = &mut w.rows.values[i * width..(i + 1) * width];
            slots.fill(0.0);
            slots.iter_mut().zip(w.functions.values()).for_each(|(slot, value)| *slot = value);
        }
        self.state.is_known = true;
        Ok(())
    }

    /// Largest difference of the gaps on the displaced surfaces from those that the solver counted with, and what the
    /// shift of the loads since then is worth at a penetration of `depth`.
    fn error(&self, w: &Workspace, depth: f64) -> f64 {
        let is_near = |i: usize| self.state.forces[i] > 0.0 || w.gaps[i] < 0.0;
        let near = (0..w.gaps.len()).filter(|i| is_near(*i));
        let error = near.fold(0.0_f64, |e, i| e.max((w.gaps[i] - w.free_gaps[i] - w.settled[i]).abs()));
        error.max(LOAD_SHIFT * depth * w.rows.moved(&w.loaded, &self.surface, is_near))
    }

    /// One solution at the projection just made, and the displacements under its forces (Eq. C.40).
    fn solve(&mut self, pass: usize, w: &mut Workspace) -> Result<SolveReport, Rejection> {
        let Some(zone) = &mut self.zone else { return Ok(SolveReport::default()) };
        let is_near = |i: usize| self.state.forces[i] > 0.0 || w.gaps[i] < 0.0;
        let moved =
            zone.built_on().map_or(f64::INFINITY, |built| w.rows.moved(built, &self.surface, is_near));
        // Should passes make no headway, the old projection is not to blame.
        if moved > REUSE || (pass > 10 && moved > 0.0) {
            zone.build(&self.surface, &w.rows);
        }
        w.loaded.copy_from(&w.rows);
        zone.settle(&self.state.forces, &mut w.settled);
        for ((free, gap), settled) in w.free_gaps.iter_mut().zip(&w.gaps).zip(&w.settled) {
            *free = gap - settled;
        }
        let report = zone.solve(&self.springs, &w.free_gaps, &mut self.state.forces)?;
        zone.settle(&self.state.forces, &mut w.settled);
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
        for (i, &force) in self.state.forces.iter().enumerate().filter(|(_, f)| **f > 0.0) {
            (0..nc).for_each(|c| w.loads[nc * i + c] = force * w.rows.own_normals[i][c]);
            let nodes = &self.surface.elements[w.rows.elements[i] as usize].nodes;
            for (&node, &value) in nodes.iter().zip(&w.rows.values[i * w.rows.width..]) {
                let load = &mut w.node_loads[nc * node as usize..][..nc];
                load.iter_mut().zip(&w.rows.normals[i]).for_each(|(l, n)| *l -= force * value * n);
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
        for (b, &load) in w.interface_loads.iter().enumerate().filter(|(_, l)| **l != 0.0) {
            let column = self.surface.compliance.col_as_slice(b);
            w.interface_displacements.iter_mut().zip(column).for_each(|(u, g)| *u += g * load);
        }
        for (u, freedom) in self.state.nodes.iter_mut().zip(&self.surface.freedoms) {
            *u = freedom.map_or(0.0, |b| w.interface_displacements[b as usize]);
        }
    }

    /// Sums up the last evaluation, whose target stands at `target`.
    pub(super) fn sum_up(&mut self, solver: SolveReport, target: &BodyState) {
        let Some(w) = &self.workspace else { return };
        let mut report = ContactReport { solver, ..ContactReport::default() };
        let mut sum = [0.0; 3];
        for (i, &force) in self.state.forces.iter().enumerate() {
            report.penetration = report.penetration.max(-w.gaps[i]);
            let found = &w.projections[i];
            // Beyond the end and below the surface: the target is too small.
            report.is_rim_touched |= found.is_beyond && found.gap < 0.0 && w.gaps[i] < self.rim_reach;
            if force > 0.0 {
                report.normal_force += force;
                report.n_active += 1;
                report.contact_area += self.areas[i];
                report.is_rim_touched |=
                    self.is_rim[i] || !self.surface.elements[found.element as usize].is_in_zone;
                (0..3).for_each(|c| sum[c] += force * found.normal[c]);
                report.energies.penalty += 0.5 * force * force * self.springs[i];
            }
        }
        report.energies.elastic_high =
            0.5 * (dot(&w.loads, &self.state.own) + dot(&w.interface_loads, &w.interface_displacements));
        if report.n_active == 0 {
            report.energies.elastic_high = 0.0;
        }
        report.force = resultant(self.motion, &target.rotation, &sum);
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
        let active = || self.state.forces.iter().enumerate().filter(|(_, f)| **f > 0.0);
        if self.motion != RigidMotion::Axial {
            for (i, &force) in active() {
                let arm = Vector3::from(w.points[i]);
                own.torque += arm.cross(&(Vector3::from(w.rows.own_normals[i]) * force));
            }
        }
        let Some(body) = self.settings.target_body else { return };
        debug_assert_eq!(bodies[body].elastic.len(), self.surface.n_modes);
        let target = &mut forces[body];
        target.force -= self.report.force;
        for (row, &load) in w.node_loads.iter().enumerate().filter(|(_, l)| **l != 0.0) {
            debug_assert!(row / nc < self.surface.nodes.len());
            target.elastic.iter_mut().zip(self.surface.low_row(row)).for_each(|(f, s)| *f += s * load);
        }
        if self.motion != RigidMotion::Axial {
            for (i, &force) in active() {
                let arm = Vector3::from(w.projections[i].point);
                target.torque -= arm.cross(&(Vector3::from(w.rows.normals[i]) * force));
            }
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

fn no_workspace() -> Rejection {
    Rejection { code: 0, reason: "a contact was evaluated from within itself".into() }
}
