//! All models of a run, built from its specification.

use std::time::Instant;

use ffr_dynamics::integration::OdeSystem;
use ffr_dynamics::system::Multibody;

use crate::adaptive_contact::{AdaptiveContact, FineContact, TrySizes, ZoneModel};
use crate::body_model::{BodyModel, ElasticModel};
use crate::contact_zone::n_elements;
use crate::elastic_body::ElasticBody;
use crate::error::{AdaptiveError, ContactModelFault};
use crate::point_compliance::{PointCompliance, of_body};
use crate::record::{BodyLayout, JointLayout, Observer, RunLayout, StressState, Timings, ZoneLoad};
use crate::simulation::{Observed, ObservedPoint, System};
use crate::spec::LowModes;
use crate::spec::{BodyKind, ContactLaw, ContactSpec, RunSpec, Target};
use crate::store::{ModelCache, body_definition};
use crate::stress::StressRequest;

mod contacts;
mod default_penalty;
mod joints;
mod own;
mod plan;
mod resolution;
mod start;

pub(crate) use contacts::surface;
use contacts::{BuiltContact, adaptive_contacts, build_contact, interfaces, refinements, zones};
use own::needs_own_modes;
use plan::ContactPlan;
pub(crate) use plan::first_sites;
pub use resolution::{Subjects, subjects};
pub(crate) use start::poses as start_poses;

/// Models, initial state and requests of a run.
pub struct RunModel {
    /// The equations of motion.
    pub system: System,
    /// State at the start.
    pub initial: Vec<f64>,
    /// What is recorded besides bodies and contacts.
    pub observed: Observed,
    /// Contacts in the order of the system's force elements.
    pub contacts: Vec<ContactFacts>,
    /// Those that the program refines, with their indices.
    pub adaptive: Vec<(usize, AdaptiveContact)>,
    /// Time spent in contacts that have left the system \[s\].
    pub contact_time: f64,
    /// Bodies in the order of the system's.
    pub bodies: Vec<BodyModel>,
    /// Time spent in building.
    pub timings: Timings,
    /// Models of earlier runs.
    pub cache: ModelCache,
    point_names: Vec<String>,
    stress: Vec<StressRequest>,
    /// What the models were built from, where models of bodies change in the course of the run.
    source: Option<Box<RunSpec>>,
}

/// What of a contact does not change in a run.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactFacts {
    /// Name.
    pub name: String,
    /// Index of the contact body.
    pub body: usize,
    /// Widths of the contact interval \[m\]; zero where there is none.
    pub widths: [f64; 2],
    /// Size of the contact body \[m\].
    pub size: f64,
    /// What the contact body meets.
    pub target: Target,
    /// Overlap at the start that is allowed \[m\].
    pub allowed_overlap: f64,
    /// Radii of the two partners of a Hertz contact, infinite of a plane \[m\].
    pub radii: Option<[f64; 2]>,
    /// Speed of waves in the slower of the materials that meet [m/s].
    pub wave_speed: f64,
    /// Whether its forces act on the interfaces that its bodies were reduced for: quasistatic ones with one model for the
    /// whole run.
    pub loads_interface: bool,
}

impl RunModel {
    /// Builds every model.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of the body, joint or contact.
    pub fn build(spec: &RunSpec) -> Result<Self, AdaptiveError> {
        Self::build_with(spec, &ModelCache::default())
    }

    /// Builds every model that is not in `cache`; fine models are looked up there as well when contacts are refined.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of the body, joint or contact.
    pub fn build_with(spec: &RunSpec, cache: &ModelCache) -> Result<Self, AdaptiveError> {
        let started = Instant::now();
        let poses = start::poses(spec)?;
        let plans = plan::plans(spec, &poses)?;
        let refined = resolution::refined(spec, &plans);
        let spec = refined.as_ref();
        check_stress(spec, &plans)?;
        let full = full_models(spec, &plans)?;
        let assembly = started.elapsed().as_secs_f64();
        let zones = zones(spec, &plans, &full)?;
        let search = started.elapsed().as_secs_f64() - assembly;
        let interfaces = interfaces(spec, &zones)?;
        let bodies = spec.bodies.iter().zip(full).zip(interfaces);
        let bodies: Vec<BodyModel> = bodies
            .map(|((b, full), i)| BodyModel::new(b, full, i, cache))
            .collect::<Result<_, AdaptiveError>>()?;
        let contacts = spec.contacts.iter().zip(plans.iter().zip(&zones));
        let contacts =
            contacts.map(|(c, (plan, zones))| build_contact(c, (plan, zones.as_ref()), &bodies, &poses));
        let contacts: Vec<BuiltContact> = contacts.collect::<Result<_, AdaptiveError>>()?;
        for (built, contact) in contacts.iter().zip(&spec.contacts) {
            built.check_start(&poses[contact.body])?;
        }
        let facts = contacts.iter().map(|c| c.facts.clone()).collect();
        let forces = contacts.into_iter().map(|c| c.element).collect();
        let description = joints::system_spec(spec, &bodies)?;
        let mut system = Multibody::new(description, forces).map_err(AdaptiveError::Model)?;
        let initial = start::state(spec, &mut system)?;
        let reduction = started.elapsed().as_secs_f64() - assembly - search;
        Ok(Self {
            observed: Observed {
                points: observed_points(spec, &bodies)?,
                joints: spec.joints.iter().filter_map(|j| j.child.body).collect(),
            },
            contacts: facts,
            adaptive: adaptive_contacts(spec, &plans, &bodies, cache)?,
            contact_time: 0.0,
            timings: Timings { assembly, search, reduction, ..Timings::default() },
            point_names: spec.points.iter().map(|p| p.name.clone()).collect(),
            stress: spec.stress.iter().map(|s| StressRequest { spec: s.clone(), state: None }).collect(),
            source: needs_own_modes(spec, &plans, &bodies)?.then(|| Box::new(spec.clone())),
            cache: cache.clone(),
            system,
            initial,
            bodies,
        })
    }

    /// How forces at interfaces that bodies have for the whole run displace the observed points.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if a point is not in its body.
    pub fn lasting_dents(&self) -> Result<Vec<PointCompliance>, AdaptiveError> {
        let mut all = Vec::new();
        for (i, body) in self.bodies.iter().enumerate() {
            let Some(elastic) = body.elastic() else { continue };
            let Some(residual) = &elastic.reduced.residual else { continue };
            all.extend(of_body(&self.observed.points, i, &elastic.body.discretised(), residual)?);
        }
        Ok(all)
    }

    /// Names and spectra for the observer.
    pub fn layout(&self, end_time: f64) -> RunLayout {
        let frequencies = BodyModel::frequencies;
        let joint = |&body: &usize| {
            let joint = &self.system.model().bodies[body].joint;
            let (positions, velocities) = joints::coordinate_names(joint.kind);
            JointLayout { name: joint.name.clone(), kind: joint.kind.name().into(), positions, velocities }
        };
        let loops = self.system.model().loops.iter().map(|joint| JointLayout {
            name: joint.name.clone(),
            kind: joint.kind.name().into(),
            ..JointLayout::default()
        });
        RunLayout {
            bodies: self
                .bodies
                .iter()
                .map(|b| BodyLayout { name: b.name.clone(), eigenfrequencies: frequencies(b) })
                .collect(),
            contacts: self.contacts.iter().map(|c| c.name.clone()).collect(),
            points: self.point_names.clone(),
            joints: self.observed.joints.iter().map(joint).chain(loops).collect(),
            time_span: (0.0, end_time),
        }
    }

    /// Sizes of the models of contact `i`, those of both bodies together.
    pub fn try_sizes(&self, i: usize) -> TrySizes {
        let (body, target) = self.system.forces()[i].contact.bodies();
        let models = [Some(body), target].into_iter().flatten();
        models.filter_map(|b| self.bodies[b].elastic()).fold(TrySizes::default(), |sum, e| TrySizes {
            elements: sum.elements + n_elements(&e.body),
            freedoms: sum.freedoms + e.body.n_unknowns() as u64,
            interface: sum.interface + e.interface.unknowns.len() as u64,
        })
    }

    /// Offers the present state to the stress requests; the system was evaluated at it last, with the models `fine` of the
    /// contacts that are refined at present.
    pub fn offer_to_stress(&mut self, time: f64, fine: &[Option<FineContact>]) {
        for request in &mut self.stress {
            let body = request.spec.body;
            let on_body = || self.system.forces().iter().filter(|f| f.acts_on(body));
            let force = on_body().map(|f| f.contact.report().normal_force).sum::<f64>();
            if !request.wants(time, force) {
                continue;
            }
            let state = request.state.get_or_insert_with(StressState::default);
            (state.time, state.force) = (time, force);
            state.elastic.clone_from(&self.system.last_evaluation().0[body].elastic);
            let residual = self.bodies[body].elastic().and_then(|e| e.reduced.residual.as_ref());
            let n = residual.map_or(0, |r| r.interface().len());
            state.interface_forces.clear();
            state.interface_forces.resize(n, 0.0);
            let mut part = vec![0.0; n];
            let forces = self.system.forces().iter().zip(&self.contacts);
            let forces = forces.filter(|(f, facts)| n > 0 && facts.loads_interface && f.acts_on(body));
            for (contact, _) in forces {
                contact.contact.interface_force(body, &mut part);
                state.interface_forces.iter_mut().zip(&part).for_each(|(sum, f)| *sum += f);
            }
            let mut n_zones = 0;
            for (i, (contact, fine)) in self.system.forces().iter().zip(fine).enumerate() {
                let Some(fine) = fine.as_ref().filter(|_| !contact.contact.is_idle()) else { continue };
                for zone in fine.zones.iter().filter(|zone| zone.body == body) {
                    if state.zones.len() == n_zones {
                        state.zones.push(ZoneLoad::default());
                    }
                    let load = &mut state.zones[n_zones];
                    (load.contact, load.site) = (i as u32, zone.site);
                    load.forces.resize(zone.n_unknowns, 0.0);
                    contact.contact.interface_force(body, &mut load.forces);
                    n_zones += 1;
                }
            }
            state.zones.truncate(n_zones);
        }
    }

    /// States that the stress requests hold.
    pub fn stress_states(&self) -> Vec<Option<StressState>> {
        self.stress.iter().map(|request| request.state.clone()).collect()
    }

    /// Gives the stress requests states of an earlier run; false if they are not as many.
    pub fn set_stress_states(&mut self, states: &[Option<StressState>]) -> bool {
        self.stress.iter_mut().zip(states).for_each(|(request, state)| request.state.clone_from(state));
        states.len() == self.stress.len()
    }

    /// Makes contacts and searches forget everything that the state does not tell.
    pub fn forget(&mut self) {
        self.system.forces_mut().iter_mut().for_each(|f| f.contact.forget());
        self.adaptive.iter_mut().for_each(|(_, contact)| contact.search.forget());
    }

    /// Evaluates the stress requests and reports them.
    ///
    /// # Errors
    /// [`AdaptiveError`] of the evaluation or the observer.
    pub fn report_stress(&self, observer: &mut dyn Observer) -> Result<(), AdaptiveError> {
        // Lines in one body mostly ask for the same instant: zones are built once for those that follow each other.
        let mut built: Option<(usize, Vec<ZoneModel>, &[ZoneLoad])> = None;
        for request in &self.stress {
            let body = request.spec.body;
            let (Some(elastic), Some(state)) = (self.bodies[body].elastic(), &request.state) else {
                continue;
            };
            let is_there =
                built.as_ref().is_some_and(|(of, _, loads)| *of == body && same(loads, &state.zones));
            if !is_there {
                built = Some((body, self.zone_models(elastic, &state.zones)?, &state.zones));
            }
            let zones = built.as_ref().map_or(&[][..], |(_, zones, _)| zones);
            observer.stress(&request.evaluate(&elastic.body, &elastic.reduced, zones, state)?)?;
        }
        Ok(())
    }

    /// Fine models of `elastic` for `loads`.
    fn zone_models(
        &self,
        elastic: &ElasticModel,
        loads: &[ZoneLoad],
    ) -> Result<Vec<ZoneModel>, AdaptiveError> {
        let model = |load: &ZoneLoad| {
            let contact = self.adaptive.iter().find(|(index, _)| *index == load.contact as usize);
            let Some((_, contact)) = contact else {
                return Err(AdaptiveError::Unsupported {
                    subject: format!("stress in body \"{}\"", elastic.body.name),
                    reason: format!("contact {} has no fine models", load.contact),
                });
            };
            let zone = contact.zone_model(elastic, &load.site)?;
            let (n, n_forces) = (zone.residual.interface().len(), load.forces.len());
            if n != n_forces {
                let fault = ContactModelFault::ForcesOfAnotherZone { forces: n_forces, unknowns: n };
                return Err(AdaptiveError::ContactModel { contact: contact.name.clone(), fault });
            }
            Ok(zone)
        };
        loads.iter().map(model).collect()
    }

    /// Time spent so far; contact solver included, output left to the caller.
    pub fn timings(&self) -> Timings {
        let present: f64 = self.system.forces().iter().map(|f| f.elapsed().as_secs_f64()).sum();
        let searches: f64 = self.adaptive.iter().map(|(_, c)| c.search.elapsed().as_secs_f64()).sum();
        Timings {
            contact: present + self.contact_time,
            search: self.timings.search + searches,
            cache: self.cache.used(),
            ..self.timings
        }
    }

    /// Number of state variables.
    pub fn dimension(&self) -> usize {
        self.system.dimension()
    }
}

/// Full models of the elastic bodies; equal ones are built once.
fn full_models(spec: &RunSpec, plans: &[ContactPlan]) -> Result<Vec<Option<ElasticBody>>, AdaptiveError> {
    let mut models: Vec<Option<ElasticBody>> = Vec::with_capacity(spec.bodies.len());
    let mut definitions: Vec<Vec<u8>> = Vec::with_capacity(spec.bodies.len());
    for (i, body) in spec.bodies.iter().enumerate() {
        let BodyKind::Elastic(elastic) = &body.kind else {
            models.push(None);
            definitions.push(Vec::new());
            continue;
        };
        let mut elastic = (**elastic).clone();
        elastic.discretisation.refine.extend(refinements(spec, plans, i)?);
        let definition = body_definition(&elastic);
        let equal = definitions.iter().position(|d| *d == definition).and_then(|k| models[k].as_ref());
        let model = match equal {
            Some(equal) => equal.copied(&body.name, elastic),
            None => ElasticBody::build(&body.name, elastic)?,
        };
        models.push(Some(model));
        definitions.push(definition);
    }
    Ok(models)
}

/// Whether two lists of loads ask for the same models.
fn same(a: &[ZoneLoad], b: &[ZoneLoad]) -> bool {
    let model = |load: &ZoneLoad| (load.contact, load.site, load.forces.len());
    a.iter().map(model).eq(b.iter().map(model))
}

/// Refuses stress in bodies whose zones, refined during the run, move by more than quasistatic displacements on prolonged modes.
fn check_stress(spec: &RunSpec, plans: &[ContactPlan]) -> Result<(), AdaptiveError> {
    let refined = || spec.contacts.iter().zip(plans).filter(|(_, plan)| **plan == ContactPlan::AtTouch);
    let unsupported = |contact: &ContactSpec| match &contact.law {
        ContactLaw::Surface(law) if law.hand_over.modes == LowModes::Own => Some("modes = \"prolonged\""),
        ContactLaw::Surface(law) if law.treatment.is_vibrating() => {
            Some("model \"adaptive\" or \"quasistatic\"")
        }
        _ => None,
    };
    for request in &spec.stress {
        let takes_part = |c: &ContactSpec| c.body == request.body || c.target == Target::Body(request.body);
        for (contact, _) in refined().filter(|(c, _)| takes_part(c)) {
            let Some(remedy) = unsupported(contact) else { continue };
            return Err(AdaptiveError::Unsupported {
                subject: format!("output.stress.{}", request.name),
                reason: format!(
                    "contact \"{}\" refines the body during the run in a way that stress is not supported for; choose {remedy} for the contact",
                    contact.name
                ),
            });
        }
    }
    Ok(())
}

fn observed_points(spec: &RunSpec, bodies: &[BodyModel]) -> Result<Vec<ObservedPoint>, AdaptiveError> {
    let point = |p: &crate::spec::PointSpec| {
        let point = bodies[p.body].point(&p.place)?;
        Ok(ObservedPoint { body: p.body, point })
    };
    spec.points.iter().map(point).collect()
}
