//! A run that is built from its specification: motions at the start, plans of its contacts, full
//! models, zones, interfaces, reduced bodies, contacts, system, in this order. Knows everything
//! that lasts for the run; nothing of it changes in time.

use std::time::Instant;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::integration::OdeSystem;
use ffr_dynamics::system::Multibody;
use ffr_dynamics::system::model::gear::Gear;

use crate::body::point_compliance::{PointCompliance, of_body};
use crate::body::{FullModel, Workshop};
use crate::error::AdaptiveError;
use crate::impact::TrialSizes;
use crate::prepared::Prepared;
use crate::record::work::{self, Work};
use crate::record::{BodyLayout, JointLayout, PointLayout, RunLayout, Timings};
use crate::sizing::SizeRequest;
use crate::sizing::impact_time::{ForceNeeds, force_needs};
use crate::sizing::mesh_touch::{MeshTouch, touches};
use crate::spec::{BodySpec, PointSpec, RunSpec, StressSpec};
use crate::state::simulation::{Observed, ObservedPoint, System};
use crate::store::ModelCache;
use crate::system::body::{BodyModel, FlexibleModel};
use crate::system::frequency_errors::FrequencyErrors;
use crate::system::rigid_surface::KnownSurfaces;
use crate::system::{joints, start};
use crate::touch::overlap::check_undeformed;
use crate::uncertainty::SAFETY;

mod arrangement;
mod default_penalty;
mod held_damping;
mod facts;
mod contacts;
mod fine_modes;
mod resolution;
mod cost;
mod stress;

pub use crate::system::joints::coordinate_names;
pub use crate::system::start::poses as start_poses;
pub use crate::system::start::turns;
pub use arrangement::{Arrangement, PlacedJoint, PlacedMarker, PlacedTouch};
use contacts::{
    adaptive_contacts, build_contact, check_refined, check_zones, interfaces, refinements, zones,
};
pub use cost::{ModelCost, costs};
pub use facts::ContactFacts;
use fine_modes::needs_fine_modes;
pub use resolution::{Subjects, subjects};

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
    /// Time spent in contacts that have left the system \[s\].
    pub contact_time: f64,
    /// Bodies in the order of the system's.
    pub bodies: Vec<BodyModel>,
    /// Time spent in building.
    pub timings: Timings,
    /// Models of earlier runs.
    pub cache: ModelCache,
    /// Where meshes are going to be touched.
    pub touches: Vec<MeshTouch>,
    points: Vec<PointSpec>,
    stress: Vec<StressSpec>,
    /// What the models were built from, where models of bodies change in the course of the run.
    source: Option<Box<RunSpec>>,
    /// Frequency up to which the modes of the bodies of each contact are to follow its force, if
    /// they touch along a line \[Hz\].
    pub force_needs: Vec<ForceNeeds>,
    /// Least yield strengths of the bodies; infinite where none is known \[Pa\].
    pub yield_strengths: Vec<f64>,
    /// As [`RunSpec::frequency_errors`].
    pub known_errors: Vec<Option<f64>>,
}

impl RunModel {
    /// Builds every model.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of the body, joint or contact.
    pub fn build(spec: &RunSpec) -> Result<Self, AdaptiveError> {
        Self::build_with(spec, &ModelCache::default())
    }

    /// As [`RunModel::build`], with the models that are in `cache`.
    ///
    /// # Errors
    /// Likewise.
    pub fn build_with(spec: &RunSpec, cache: &ModelCache) -> Result<Self, AdaptiveError> {
        Self::of(Prepared::new(spec)?, cache)
    }

    /// Builds every model of a run that is not in `cache`; fine models are looked up there as well when
    /// contacts are refined.
    ///
    /// # Errors
    /// [`AdaptiveError`] with the name of the body, joint or contact.
    pub fn of(run: Prepared<'_>, cache: &ModelCache) -> Result<Self, AdaptiveError> {
        let started = Instant::now();
        check(&run)?;
        let refined = resolution::refined(&run);
        let run = run.refined(refined.as_ref());
        let spec = run.spec();
        let full = full_models(&run)?;
        let assembly = started.elapsed().as_secs_f64();
        let zones = zones(&run, &full)?;
        let search = started.elapsed().as_secs_f64() - assembly;
        let interfaces = interfaces(&run, &zones, &start::turns(spec)?)?;
        let bodies = spec.bodies.iter().zip(full).zip(interfaces).enumerate();
        let mut surfaces = KnownSurfaces::default();
        let mut bodies: Vec<BodyModel> = bodies
            .map(|(k, ((b, full), i))| {
                let _work = at_body(spec, k, &format!("modes of {} unknowns", full.n_unknowns()));
                BodyModel::new(b.name.clone(), full, i, cache, &mut surfaces)
            })
            .collect::<Result<_, AdaptiveError>>()?;
        let built =
            run.contacts().zip(&zones).map(|(c, zones)| build_contact(&run, c, zones.as_ref(), &bodies));
        let built = built.collect::<Result<Vec<_>, AdaptiveError>>()?;
        let (forces, mut contacts): (Vec<_>, Vec<_>) = built.into_iter().unzip();
        let description = joints::system_spec(spec, &bodies)?;
        let mut system = Multibody::new(description, forces).map_err(AdaptiveError::Model)?;
        let initial = start::state(spec, &mut system)?;
        held_damping::hold(spec, &mut bodies, &mut system, (0.0, &initial))?;
        let reduction = started.elapsed().as_secs_f64() - assembly - search;
        let observed = Observed {
            points: observed_points(spec, &bodies)?,
            joints: spec.joints.iter().filter_map(|j| j.child.body).collect(),
        };
        for (i, refinement) in adaptive_contacts(&run, &bodies, cache)? {
            contacts[i].refinement = Some(refinement);
        }
        Ok(Self {
            observed,
            contacts,
            contact_time: 0.0,
            timings: Timings { assembly, search, reduction, ..Timings::default() },
            points: spec.points.clone(),
            stress: spec.stress.clone(),
            source: needs_fine_modes(spec, &bodies)?.then(|| Box::new(spec.clone())),
            cache: cache.clone(),
            touches: spec.contacts.iter().flat_map(|c| touches(&run.touches, c)).collect(),
            force_needs: force_needs(&run.touches),
            yield_strengths: spec.bodies.iter().map(|body| body.kind.yield_strength()).collect(),
            known_errors: spec.frequency_errors.clone(),
            system,
            initial,
            bodies,
        })
    }

    /// How forces at interfaces that bodies have for the whole run displace the observed points.
    ///
    /// # Errors
    /// [`AdaptiveError::Geometry`] if a point is not in its body.
    pub fn lasting_local_deformation(&self) -> Result<Vec<PointCompliance>, AdaptiveError> {
        let mut all = Vec::new();
        for (i, body) in self.bodies.iter().enumerate() {
            let Some(flexible) = body.flexible() else { continue };
            let Some(residual) = &flexible.reduced.residual else { continue };
            all.extend(of_body(&self.observed.points, (i, flexible.body.as_ref()), residual)?);
        }
        Ok(all)
    }

    /// Names and spectra for the observer.
    pub fn layout(&self, end_time: f64) -> RunLayout {
        let body = |(b, body): (usize, &BodyModel)| {
            let eigenfrequencies = body.frequencies();
            let errors = self.frequency_errors(b);
            let n_free = body.coordinates().free;
            // Static answers are no vibrations that a finer mesh would have, too.
            let band = |(k, frequency): (usize, &f64)| match errors {
                Some(errors) if k < n_free => SAFETY * frequency * errors.at(*frequency),
                _ => f64::NAN,
            };
            let frequency_bands = eigenfrequencies.iter().enumerate().map(band).collect();
            BodyLayout { name: body.name.clone(), eigenfrequencies, frequency_bands }
        };
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
        let gear = |gear: &Gear| {
            let kind = self.system.model().bodies[gear.second.body].joint.kind;
            (gear.name.clone(), if kind.is_angle(gear.second.velocity) { "N m" } else { "N" }.to_owned())
        };
        RunLayout {
            gears: self.system.model().gears.iter().map(gear).collect(),
            bodies: self.bodies.iter().enumerate().map(body).collect(),
            contacts: self.contacts.iter().map(|c| c.name.clone()).collect(),
            stops: self
                .system
                .model()
                .stops()
                .into_iter()
                .map(|stop| format!("stop of {}", stop.joint))
                .collect(),
            points: self.points.iter().map(|p| self.point_layout(p)).collect(),
            joints: self.observed.joints.iter().map(joint).chain(loops).collect(),
            time_span: (0.0, end_time),
        }
    }

    /// Relative errors of the frequencies of body `b` by its mesh; none of a body whose mesh is not there.
    pub fn frequency_errors(&self, b: usize) -> Option<FrequencyErrors> {
        FrequencyErrors::new(&self.bodies[b], self.known_errors.get(b).copied().flatten())
    }

    fn point_layout(&self, point: &PointSpec) -> PointLayout {
        let motion = self.bodies[point.body].data.motion;
        PointLayout {
            name: point.name.clone(),
            gauge: point.gauge,
            is_axisymmetric: motion == RigidMotion::Axial,
        }
    }

    /// Name of the observed point `k`.
    pub fn point_name(&self, k: usize) -> &str {
        &self.points[k].name
    }

    /// Sizes of the models of contact `i`, those of both bodies together.
    pub fn trial_sizes(&self, i: usize) -> TrialSizes {
        let (body, target) = self.system.forces()[i].contact.facts().bodies();
        let models = [Some(body), target].into_iter().flatten();
        models.filter_map(|b| self.bodies[b].flexible()).fold(TrialSizes::default(), |sum, e| TrialSizes {
            elements: sum.elements + e.body.space().n_elements() as u64,
            dofs: sum.dofs + e.reduced.basis.shapes.nrows() as u64,
            interface: sum.interface + e.interface.unknowns.len() as u64,
        })
    }

    /// Makes contacts forget everything that the state vector does not tell.
    pub fn forget(&mut self) {
        self.system.forces_mut().iter_mut().for_each(|f| f.contact.forget());
    }

    /// Time spent so far; contact solver included, searches of a run once it has ended, output left
    /// to the caller.
    pub fn timings(&self) -> Timings {
        let present: f64 = self.system.forces().iter().map(|f| f.elapsed().as_secs_f64()).sum();
        Timings { contact: present + self.contact_time, cache: self.cache.used(), ..self.timings }
    }

    /// Number of state variables.
    pub fn dimension(&self) -> usize {
        self.system.dimension()
    }
}

/// Refuses what a build refuses whatever its meshes are: stress that contacts do not give, modes that
/// bodies cannot have for them.
fn check(run: &Prepared<'_>) -> Result<(), AdaptiveError> {
    stress::check(run)?;
    fine_modes::check(run)?;
    (0..run.spec().bodies.len()).try_for_each(|body| contacts::interface_modes(run, body).map(|_| ()))
}

/// Checks that a run whose sizes the program is to choose by `wishes`, one per body, can be simulated, as
/// far as shapes, meshes and the motions at the start tell; builds nothing.
///
/// # Errors
/// [`AdaptiveError`] as a run, for zones that are not found, stress and modes that contacts do not
/// give, and bodies that overlap.
pub fn check_unbuilt(run: &Prepared<'_>, wishes: &[SizeRequest]) -> Result<(), AdaptiveError> {
    check(run)?;
    check_refined(run, wishes)?;
    check_zones(run, wishes)?;
    check_undeformed(run.spec(), &run.touches.poses)
}

/// Begins work at body `i`.
fn at_body(spec: &RunSpec, i: usize, what: &str) -> Work {
    work::begin(format!("body \"{}\" ({} of {}), {what}", spec.bodies[i].name, i + 1, spec.bodies.len()))
}

/// Full models of the bodies; equal ones are built once.
fn full_models<'a>(run: &Prepared<'a>) -> Result<Vec<FullModel<'a>>, AdaptiveError> {
    let spec = run.spec();
    let mut workshop = Workshop::default();
    let full = |(i, body): (usize, &'a BodySpec)| {
        let (name, _work) = (body.name.as_str(), at_body(spec, i, "matrices"));
        workshop.build(name, &body.kind, refinements(run, i)?)
    };
    spec.bodies.iter().enumerate().map(full).collect()
}

fn observed_points(spec: &RunSpec, bodies: &[BodyModel]) -> Result<Vec<ObservedPoint>, AdaptiveError> {
    let point = |p: &PointSpec| {
        let body = &bodies[p.body];
        let gauge = if p.gauge.is_any() { Some(body.gauge(&p.place)?) } else { None };
        Ok(ObservedPoint { body: p.body, point: body.point(&p.place)?, gauge })
    };
    spec.points.iter().map(point).collect()
}
