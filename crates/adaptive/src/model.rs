//! All models of a run, built from its specification.

use std::time::Instant;

use contact_qs::plane::{Plane, PlaneContact, PlaneContactSettings};
use contact_qs::points::{InterfaceCompliance, contact_submodel};
use ffr_dynamics::system::force::BodyState;
use ffr_dynamics::system::free_bodies::{FreeBodies, FreeBody};
use nalgebra::Unit;

use crate::contact_zone::{ContactZone, wanted_refinement};
use crate::elastic_body::{ElasticBody, Interface, ReducedBody};
use crate::error::AdaptiveError;
use crate::record::{BodyLayout, Observer, RunLayout, Timings};
use crate::simulation::{ObservedPoint, System, TimedContact};
use crate::spec::{PlaneContactSpec, ReductionSpec, RunSpec};
use crate::stress::{StressRequest, StressState};

/// Models, initial state and requests of a run.
pub struct RunModel {
    /// The equations of motion.
    pub system: System,
    /// Motion at the start.
    pub initial: Vec<BodyState>,
    /// Observed points.
    pub points: Vec<ObservedPoint>,
    /// Names of the contacts.
    pub contact_names: Vec<String>,
    /// Widths of the contact intervals \[m\].
    pub interval_widths: Vec<[f64; 2]>,
    /// Sizes of the bodies \[m\].
    pub sizes: Vec<f64>,
    /// Time spent in building.
    pub timings: Timings,
    /// Full models.
    pub bodies: Vec<ElasticBody>,
    /// Reduced models.
    pub reduced: Vec<ReducedBody>,
    /// Interfaces that the bodies were reduced for.
    pub interfaces: Vec<Interface>,
    point_names: Vec<String>,
    stress: Vec<StressRequest>,
}

/// Sizes for the log of tries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrySizes {
    /// Elements of the contact body.
    pub elements: u64,
    /// Its freedoms.
    pub freedoms: u64,
    /// Its interface freedoms.
    pub interface: u64,
}

impl RunModel {
    /// Builds every model.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of the body or contact.
    pub fn build(spec: &RunSpec) -> Result<Self, AdaptiveError> {
        let started = Instant::now();
        let mut wanted = spec.bodies.clone();
        for contact in &spec.contacts {
            let body = &mut wanted[contact.body];
            body.discretisation.refine.extend(wanted_refinement(body, contact)?);
        }
        let bodies = wanted.into_iter().map(ElasticBody::build).collect::<Result<Vec<_>, AdaptiveError>>()?;
        let assembly = started.elapsed().as_secs_f64();
        let zones = spec
            .contacts
            .iter()
            .map(|c| ContactZone::new(&bodies[c.body], c))
            .collect::<Result<Vec<_>, AdaptiveError>>()?;
        let search = started.elapsed().as_secs_f64() - assembly;
        let interfaces = (0..bodies.len())
            .map(|b| interface_of(b, &bodies[b], &spec.contacts, &zones))
            .collect::<Result<Vec<_>, AdaptiveError>>()?;
        let reduced = bodies
            .iter()
            .zip(&interfaces)
            .map(|(body, interface)| body.reduce(interface))
            .collect::<Result<Vec<_>, AdaptiveError>>()?;
        let contacts = spec
            .contacts
            .iter()
            .zip(&zones)
            .map(|(c, zone)| plane_contact(c, zone, &bodies[c.body], &reduced[c.body], &interfaces[c.body]))
            .collect::<Result<Vec<_>, AdaptiveError>>()?;
        let free = bodies.iter().zip(&reduced);
        let free = free.map(|(b, r)| FreeBody { name: b.spec.name.clone(), data: r.data.clone() }).collect();
        let system =
            FreeBodies::new(free, spec.settings.gravity, contacts).map_err(AdaptiveError::Dynamics)?;
        let points = spec
            .points
            .iter()
            .map(|p| {
                let point = bodies[p.body].flexible_point(&p.place, reduced[p.body].basis.shapes.as_ref())?;
                Ok(ObservedPoint { body: p.body, point })
            })
            .collect::<Result<Vec<_>, AdaptiveError>>()?;
        let reduction = started.elapsed().as_secs_f64() - assembly - search;
        Ok(Self {
            initial: bodies.iter().zip(&reduced).map(|(b, r)| initial_state(b, r)).collect(),
            system,
            points,
            contact_names: spec.contacts.iter().map(|c| c.name.clone()).collect(),
            interval_widths: zones.iter().map(|z| [z.width, 0.0]).collect(),
            sizes: bodies.iter().map(ElasticBody::size).collect(),
            timings: Timings { assembly, search, reduction, ..Timings::default() },
            point_names: spec.points.iter().map(|p| p.name.clone()).collect(),
            stress: spec.stress.iter().map(|s| StressRequest { spec: s.clone(), state: None }).collect(),
            bodies,
            reduced,
            interfaces,
        })
    }

    /// Names and spectra for the observer.
    pub fn layout(&self, end_time: f64) -> RunLayout {
        let frequencies = |r: &ReducedBody| r.basis.omega.iter().map(|w| w / std::f64::consts::TAU).collect();
        let bodies = self.bodies.iter().zip(&self.reduced);
        RunLayout {
            bodies: bodies
                .map(|(b, r)| BodyLayout { name: b.spec.name.clone(), eigenfrequencies: frequencies(r) })
                .collect(),
            contacts: self.contact_names.clone(),
            points: self.point_names.clone(),
            time_span: (0.0, end_time),
        }
    }

    /// Sizes of the contact body of contact `i`.
    pub fn try_sizes(&self, i: usize) -> TrySizes {
        let body = self.system.forces()[i].body;
        TrySizes {
            elements: crate::contact_zone::n_elements(&self.bodies[body]),
            freedoms: self.bodies[body].n_unknowns() as u64,
            interface: self.interfaces[body].unknowns.len() as u64,
        }
    }

    /// Offers the present state to the stress requests; the system was evaluated at it last.
    pub fn offer_to_stress(&mut self, time: f64) {
        for request in &mut self.stress {
            let body = request.spec.body;
            let on_body = || self.system.forces().iter().filter(|f| f.body == body);
            let force = on_body().map(|f| f.contact.report().normal_force).sum::<f64>();
            if !request.wants(time, force) {
                continue;
            }
            let state = request.state.get_or_insert_with(StressState::default);
            (state.time, state.force) = (time, force);
            state.elastic.clone_from(&self.system.last_evaluation().0[body].elastic);
            let n = self.reduced[body].residual.as_ref().map_or(0, |r| r.interface().len());
            state.interface_forces.clear();
            state.interface_forces.resize(n, 0.0);
            let mut part = vec![0.0; n];
            for contact in on_body().filter(|f| f.contact.zone().is_some()) {
                contact.contact.interface_force(&mut part);
                state.interface_forces.iter_mut().zip(&part).for_each(|(sum, f)| *sum += f);
            }
        }
    }

    /// Evaluates the stress requests and reports them.
    ///
    /// # Errors
    /// [`AdaptiveError`] of the evaluation or the observer.
    pub fn report_stress(&self, observer: &mut dyn Observer) -> Result<(), AdaptiveError> {
        for request in &self.stress {
            let body = request.spec.body;
            if let Some(record) = request.evaluate(&self.bodies[body], &self.reduced[body])? {
                observer.stress(&record)?;
            }
        }
        Ok(())
    }

    /// Time spent so far; contact solver included, output left to the caller.
    pub fn timings(&self) -> Timings {
        let contact = self.system.forces().iter().map(|f| f.elapsed().as_secs_f64()).sum();
        Timings { contact, ..self.timings }
    }
}

/// Union of the interfaces of all contacts of body `index`.
fn interface_of(
    index: usize,
    body: &ElasticBody,
    contacts: &[PlaneContactSpec],
    zones: &[ContactZone],
) -> Result<Interface, AdaptiveError> {
    let mine = || contacts.iter().zip(zones).filter(|(c, _)| c.body == index);
    let is_quasistatic = mine().any(|(c, _)| c.is_quasistatic);
    let unsupported = |reason: &str| AdaptiveError::Unsupported {
        subject: format!("body \"{}\"", body.spec.name),
        reason: reason.into(),
    };
    if is_quasistatic && mine().any(|(c, _)| !c.is_quasistatic) {
        return Err(unsupported(
            "quasistatic and dynamic contacts on one body cannot be mixed, choose one model",
        ));
    }
    if is_quasistatic && !matches!(body.spec.reduction, ReductionSpec::CraigBampton { .. }) {
        return Err(unsupported("quasistatic contact needs reduction.method = \"craig-bampton\""));
    }
    let mut unknowns: Vec<usize> = mine().flat_map(|(_, zone)| zone.unknowns.iter().copied()).collect();
    unknowns.sort_unstable();
    unknowns.dedup();
    Ok(Interface { unknowns, is_quasistatic })
}

/// The force element of a contact.
fn plane_contact(
    spec: &PlaneContactSpec,
    zone: &ContactZone,
    body: &ElasticBody,
    reduced: &ReducedBody,
    interface: &Interface,
) -> Result<TimedContact, AdaptiveError> {
    let fail = |source| AdaptiveError::Contact { contact: spec.name.clone(), source };
    let compliance = reduced
        .residual
        .as_ref()
        .map(|r| InterfaceCompliance { dofs: &interface.unknowns, compliance: r.compliance().as_ref() });
    let shapes = reduced.basis.shapes.as_ref();
    let submodel = contact_submodel(body.assembled.motion, &zone.points, &body.lookup, shapes, compliance)
        .map_err(fail)?;
    let settings = PlaneContactSettings {
        body: spec.body,
        plane: Plane { point: spec.plane_point, normal: Unit::new_normalize(spec.plane_normal) },
        penalty: spec.penalty,
        method: spec.method,
    };
    let contact = PlaneContact::new(submodel, settings).map_err(fail)?;
    contact.check_alignment(&body.spec.motion.rotation).map_err(fail)?;
    Ok(TimedContact::new(contact, spec.body, spec.plane_normal.normalize()))
}

fn initial_state(body: &ElasticBody, reduced: &ReducedBody) -> BodyState {
    let motion = &body.spec.motion;
    BodyState {
        position: motion.position,
        rotation: motion.rotation,
        velocity: motion.velocity,
        angular_velocity: motion.rotation.inverse_transform_vector(&motion.angular_velocity),
        ..BodyState::at_rest(reduced.data.n_modes())
    }
}
