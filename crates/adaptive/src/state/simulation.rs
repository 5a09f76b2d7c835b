//! The system of a run, and what is recorded of it at an instant.

use std::ops::{Deref, DerefMut};

use contact_qs::contact_element::ActiveContact;
use contact_qs::{ContactError, ContactSides, Meeting, PressureRecovery};
use ffr_dynamics::force::BodyState;
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::system::free_body::invariants::{MeanMotion, centre_of_mass};
use ffr_dynamics::system::{Multibody, Reaction};
use iga_core::elasticity::kinematics::PointState;
use nalgebra::{Isometry3, Vector3};

use crate::record::{
    BodySample, ContactSample, Energies, EventKind, JointSample, PointSample, PressurePoint, Sample,
};
use crate::state::impact_monitor::{Hold, NearMotion};

/// A contact of a run, with what tells the pressures at its points.
pub struct RunContact {
    /// The contact.
    pub contact: Box<dyn ActiveContact>,
    recovery: Option<PressureRecovery>,
}

impl RunContact {
    /// A contact whose pressures are forces over areas.
    pub fn new(contact: Box<dyn ActiveContact>) -> Self {
        Self { contact, recovery: None }
    }

    /// With the damping `damping`, the growth of its force per closing speed [s/m].
    ///
    /// # Errors
    /// [`ContactError`] as [`ContactSides::new`].
    pub fn with_damping(mut self, damping: f64) -> Result<Self, ContactError> {
        if damping != 0.0 {
            self.contact = Box::new(ContactSides::new(self.contact, None, damping)?);
        }
        Ok(self)
    }

    /// With the pressures at its points by `recovery`, if there is one.
    #[must_use]
    pub fn with_pressures(mut self, recovery: Option<PressureRecovery>) -> Self {
        self.recovery = recovery;
        self
    }

    /// Points under pressure at the last evaluation.
    fn pressures(&mut self, out: &mut Vec<PressurePoint>) {
        out.clear();
        let (contact, Some(forces)) = (self.contact.facts(), self.contact.point_forces()) else { return };
        let mut add = |i: usize, pressure: &dyn Fn(f64) -> f64| {
            let point = contact.point(i);
            out.extend(point.map(|(position, area)| PressurePoint {
                position,
                area,
                pressure: pressure(area),
            }));
        };
        match &mut self.recovery {
            Some(recovery) => {
                let pressures = recovery.pressures(forces).iter().enumerate();
                pressures.filter(|(_, p)| **p > 0.0).for_each(|(i, p)| add(i, &|_| *p));
            }
            None => {
                let loaded = forces.iter().enumerate().filter(|(_, force)| **force > 0.0);
                loaded.for_each(|(i, force)| add(i, &|area| force / area));
            }
        }
    }

    /// Whether the contact acts on body `body`.
    pub fn acts_on(&self, body: usize) -> bool {
        let (contact, target) = self.contact.facts().bodies();
        contact == body || target == Some(body)
    }
}

impl Deref for RunContact {
    type Target = dyn ActiveContact;

    fn deref(&self) -> &Self::Target {
        self.contact.as_ref()
    }
}

impl DerefMut for RunContact {
    fn deref_mut(&mut self) -> &mut Self::Target {
        self.contact.as_mut()
    }
}

/// A point whose motion is recorded.
#[derive(Debug, Clone)]
pub struct ObservedPoint {
    /// Index of the body.
    pub body: usize,
    /// The material point.
    pub point: FlexiblePoint,
    /// Strain and stress by a unit of each elastic coordinate, if they are recorded (theory
    /// Eq. Q.7).
    pub gauge: Option<Vec<PointState>>,
}

impl ObservedPoint {
    /// What is recorded of the point by the dynamic coordinates, its body being in the state
    /// `state`.
    pub fn sample(&self, state: &BodyState) -> PointSample {
        PointSample {
            position: self.point.position(state).into(),
            velocity: self.point.velocity(state).into(),
            state: self.state(&state.elastic),
        }
    }

    /// Strain and stress by the elastic coordinates `elastic`; zero if they are not recorded.
    pub fn state(&self, elastic: &[f64]) -> PointState {
        let mut sum = PointState::default();
        let modes = self.gauge.iter().flatten().zip(elastic);
        modes.for_each(|(state, q)| sum.add_scaled(state, *q));
        sum
    }
}

/// The system of a run.
pub type System = Multibody<RunContact>;

/// What is recorded of a system in addition to bodies and contacts.
#[derive(Debug, Clone, Default)]
pub struct Observed {
    /// Points.
    pub points: Vec<ObservedPoint>,
    /// Bodies whose joints are recorded; joints that close loops are recorded after them.
    pub joints: Vec<usize>,
}

/// Fills `sample` with everything recorded at time `t` in the state `y`, which forces and
/// accelerations were evaluated at last; the phase is left to the caller, and the potential of
/// gravity is that about the inertial origin.
pub fn fill_sample(system: &mut System, observed: &Observed, t: f64, y: &[f64], sample: &mut Sample) {
    let invariants = system.invariants(t, y);
    sample.time = t;
    sample.energies = Energies {
        kinetic: invariants.kinetic,
        elastic_low: invariants.elastic,
        gravity: invariants.gravity,
        springs: system.joint_energy(t, y),
        dissipated: system.dissipated_work(y),
        supplied: system.supplied_work(y),
        ..Energies::default()
    };
    sample.linear_momentum = invariants.linear_momentum.into();
    sample.angular_momentum = invariants.angular_momentum.into();
    sample.contacts.resize(system.forces().len(), ContactSample::default());
    sample.pressures.resize(system.forces().len(), Vec::new());
    sample.pressures.iter_mut().for_each(Vec::clear);
    let found: Vec<usize> = system.found().collect();
    for i in found {
        let force = system.force_as_placed(y, i).0;
        force.pressures(&mut sample.pressures[i]);
        let energies = force.energies();
        sample.energies.elastic_high += energies.elastic_high;
        sample.energies.penalty += energies.penalty;
        sample.energies.kinetic += energies.kinetic;
    }
    for (force, slot) in system.forces().iter().zip(&mut sample.contacts) {
        *slot = contact_sample(force.contact.as_ref());
    }
    let states = system.last_evaluation().0;
    sample.bodies.resize(states.len(), BodySample::default());
    for ((body, state), slot) in system.model().bodies.iter().zip(states).zip(&mut sample.bodies) {
        fill_body(state, centre_of_mass(&body.data, state), slot);
    }
    fill_places(system, observed, t, y, sample);
    sample.gears.clear();
    sample.gears.extend((0..system.model().gears.len()).map(|i| system.gear_force(i)));
}

/// Fills in points and joints of `sample` as [`fill_sample`].
pub fn fill_places(system: &System, observed: &Observed, t: f64, y: &[f64], sample: &mut Sample) {
    let states = system.last_evaluation().0;
    sample.points.clear();
    sample.points.extend(observed.points.iter().map(|p| p.sample(&states[p.body])));
    let n_joints = observed.joints.len() + system.model().loops.len();
    sample.joints.resize(n_joints, JointSample::default());
    for (&body, slot) in observed.joints.iter().zip(&mut sample.joints) {
        let kind = system.model().bodies[body].joint.kind;
        let coordinates = system.joint_coordinates(t, y, body);
        slot.positions.clear();
        slot.positions.extend(&coordinates.positions[..kind.n_positions()]);
        slot.velocities.clear();
        slot.velocities.extend(&coordinates.velocities[..kind.n_velocities()]);
        fill_reaction(&system.reaction(body), slot);
    }
    for (i, slot) in sample.joints[observed.joints.len()..].iter_mut().enumerate() {
        fill_reaction(&system.loop_reaction(i), slot);
    }
}

fn fill_reaction(reaction: &Reaction, slot: &mut JointSample) {
    slot.reaction_force = reaction.force.into();
    slot.reaction_moment = reaction.moment.into();
}

fn contact_sample(contact: &dyn ActiveContact) -> ContactSample {
    let report = contact.report();
    ContactSample {
        normal_force: report.normal_force,
        force: report.force.into(),
        friction_force: report.friction_force.into(),
        penetration: report.penetration,
        active_points: report.n_active as u32,
        sliding_points: report.n_sliding as u32,
        contact_area: report.contact_area,
        penalty: contact.facts().penalty(),
    }
}

fn fill_body(state: &BodyState, centre_of_mass: Vector3<f64>, slot: &mut BodySample) {
    let q = state.rotation.quaternion();
    slot.position = state.position.into();
    slot.rotation = [q.w, q.i, q.j, q.k];
    slot.velocity = state.velocity.into();
    slot.angular_velocity = (state.rotation * state.angular_velocity_in_body).into();
    slot.centre_of_mass = centre_of_mass.into();
    slot.elastic_coordinates.clone_from(&state.elastic);
    slot.elastic_velocities.clone_from(&state.elastic_rates);
}

/// Smallest gap of contact `index` at time `t` in the state `y` \[m\].
pub fn smallest_gap(system: &mut System, t: f64, y: &[f64], index: usize) -> f64 {
    system.body_states(t, y);
    gap_as_placed(system, y, index)
}

/// The same; nothing but the bodies of the contact is placed.
pub fn gap_alone(system: &mut System, t: f64, y: &[f64], index: usize) -> f64 {
    system.place_pair(t, y, system.forces()[index].contact.facts().bodies());
    gap_as_placed(system, y, index)
}

/// The same in the state `y` that the bodies were placed in last.
pub fn gap_as_placed(system: &mut System, y: &[f64], index: usize) -> f64 {
    let (force, motion) = system.force_as_placed(y, index);
    force.contact.meeting(motion).gap
}

/// The place of contact `index` in the state `y` that the bodies were placed in last, the normal, and the relative motion of its
/// bodies there. The normal is the direction of the normal force that acts, whose points are many;
/// without force it is that of the nearest point, off by the turn of the surface over half their
/// spacing.
pub fn normal_motion(
    system: &mut System,
    y: &[f64],
    index: usize,
) -> (Vector3<f64>, Vector3<f64>, NearMotion) {
    let (force, motion) = system.force_as_placed(y, index);
    let Meeting { normal, place, .. } = force.contact.meeting(motion);
    let report = force.contact.report();
    let pressed = (report.force - report.friction_force).try_normalize(0.0);
    let pressed = pressed.filter(|_| report.normal_force > 0.0);
    (place, pressed.unwrap_or(normal), motion_at(system, index, &place))
}

/// What contact `index` does beside its normal force in the last evaluation, its bodies touching at `place`; `has_friction`: whether it
/// has, `size`: that of the contact body \[m\].
pub fn hold_at(
    system: &System,
    index: usize,
    (place, has_friction, size): (Vector3<f64>, bool, f64),
) -> Hold {
    let element = &system.forces()[index].contact;
    let (report, (body, target)) = (element.report(), element.facts().bodies());
    let slip = match report.n_sliding {
        0 => EventKind::Stick,
        n if n < report.n_active => EventKind::PartialSlip,
        _ => EventKind::Slip,
    };
    let states = system.last_evaluation().0;
    let bodies = [Some(body), target];
    let pose = |body: usize| Isometry3::from_parts(states[body].position.into(), states[body].rotation);
    let mobility: f64 = bodies.iter().flatten().map(|b| system.model().bodies[*b].data.mass.recip()).sum();
    let held = report.energies.elastic_high + report.energies.penalty;
    Hold {
        slip: has_friction.then_some(slip),
        friction: report.friction_force.norm(),
        yielded: if report.normal_force > 0.0 { 2.0 * held / report.normal_force } else { 0.0 },
        place,
        poses: bodies.map(|body| body.map(pose)),
        mass: mobility.recip(),
        size,
    }
}

/// Rigid motion of the bodies of contact `index` relative to each other at its nearest point, at
/// time `t` in the state `y`; nothing but the bodies of the contact is placed.
pub fn near_motion(system: &mut System, t: f64, y: &[f64], index: usize) -> NearMotion {
    system.place_pair(t, y, system.forces()[index].contact.facts().bodies());
    let (force, motion) = system.force_as_placed(y, index);
    let near = force.contact.meeting(motion).place;
    motion_at(system, index, &near)
}

/// Rigid motion of the bodies of contact `index` relative to each other at the place `near`, in the
/// motions of the last evaluation (theory Eq. Q.2); bodies that `fixed` joints connect move as one.
pub fn motion_at(system: &System, index: usize, near: &Vector3<f64>) -> NearMotion {
    let (body, target) = system.forces()[index].contact.facts().bodies();
    let (states, _) = system.last_evaluation();
    let alone = |body: usize| MeanMotion::of(&system.model().bodies[body].data, &states[body]);
    let motion = |body: usize| {
        let others = system.model().fixed_to(body).filter(|other| *other != body);
        others.fold(alone(body), |sum, other| sum.with(&alone(other)))
    };
    let motions = [Some(body), target].map(|body| body.map(motion));
    let [own, other] =
        motions.map(|motion| motion.map_or_else(Vector3::zeros, |motion| motion.velocity_at(near)));
    let sum = |of: fn(&MeanMotion) -> f64| motions.iter().flatten().map(of).sum::<f64>();
    let (energy, mobility) = (sum(|motion| motion.vibration), sum(|motion| motion.mass.recip()));
    NearMotion {
        velocity: (own - other).into(),
        speed: own.norm() + other.norm(),
        vibration: (2.0 * energy * mobility).sqrt(),
    }
}
