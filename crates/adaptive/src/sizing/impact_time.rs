//! How fast the forces of impacts may change, from what is known at the start of a run (theory
//! Eqs. N.8, N.9).
//!
//! The duration of an impact of compact bodies follows from Hertz's law and the masses. Between
//! long bodies the force rises faster, until waves carry the motion away, and this rise has to be
//! resolved. Durations go with the speed to the power -1/5, so that an estimate of the speed is
//! enough.

pub(crate) mod radiation;
pub mod rise;

use std::f64::consts::PI;
use std::fmt;

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use iga_core::elasticity::mass_properties::MassProperties;
use iga_core::elasticity::{Material, MaterialField};
use iga_core::nurbs::shape::lengths::lengths;
use nalgebra::{Matrix3, Vector3};

use super::extent::extent;
use crate::sizing::impact_time::radiation::Radiation;
pub use crate::sizing::impact_time::rise::TimeScale;
use crate::sizing::impact_time::rise::{TouchLine, Touching, length_along, line_time, point_time};
use crate::spec::{BodyKind, ContactSpec, HertzSphere, Place, RunSpec, Target};
use crate::surface::SurfacePlace;
use crate::touch::first::{FirstTouch, FirstTouches};
use crate::touch::hertz::local_surface::{SurfaceView, plane_compliance};
use crate::touch::hertz::{LocalSurface, across_line, inverse_effective_mass};
use crate::touch::parts::{TouchKind, TouchZone};
use crate::touch::sites::Sites;
use crate::touch::tolerances::{FACING, SHORTEST_LINE};

/// Speed of impacts when nothing moves and nothing falls at the start [m/s].
const UNKNOWN_SPEED: f64 = 1.0;
/// Frequency times duration up to which modes follow the force of flat faces, which jumps: what
/// rings above takes less than a thousandth of the velocity of separation, and an impact ends `1/f`
/// late (Eq. C.69). Stout bodies have more modes below it than are taken.
const FLAT: f64 = 60.0;
/// Frequency times duration up to which modes of solid bodies follow that force; their number grows
/// with the cube of the frequency.
const FLAT_SOLID: f64 = 10.0;

/// Share of a pulse's energy that may lie above the highest kept frequency. Amplitudes go with its
/// root, 1 %, and the static answer of the modes that are left out corrects most of that.
const NEGLECTED: f64 = 1e-4;

/// Frequency \[Hz\] above which the spectrum of half a sine of `duration` \[s\] has the share
/// `NEGLECTED` of its energy (Eq. N.9).
pub fn pulse_frequency(duration: f64) -> f64 {
    (4.0 * PI / (3.0 * NEGLECTED)).cbrt() / (2.0 * PI * duration)
}

/// How fast the forces on a body change.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceTime {
    /// Name of the contact.
    pub contact: String,
    /// What determines the time.
    pub scale: TimeScale,
    /// The time \[s\].
    pub duration: f64,
    /// Speed that it was estimated for [m/s].
    pub speed: f64,
    /// Frequency up to which the body has modes \[Hz\].
    pub frequency: f64,
}

/// Ratio of successive values to which frequencies are rounded up. Ten times the speed gives 1.6
/// times the frequency, four such values: runs at similar speeds share the models that are chosen.
const STEP: f64 = 1.122_018_454_301_963_3;

/// The least of the rounded frequencies that is not below `frequency`.
fn rounded_up(frequency: f64) -> f64 {
    if frequency > 0.0 && frequency.is_finite() {
        STEP.powf((frequency.ln() / STEP.ln() - 1e-9).ceil())
    } else {
        frequency
    }
}

impl fmt::Display for ForceTime {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { contact, scale, duration, speed, frequency } = self;
        let what = match scale {
            TimeScale::Hertz => "an impact by Hertz's theory",
            TimeScale::Waves => "the rise of the force while waves run into the bodies",
            TimeScale::Line => "an impact along a line",
            TimeScale::LineWaves => "the rise of the force along a line while waves run into the bodies",
            TimeScale::Flat => {
                return write!(
                    out,
                    "contact \"{contact}\", a wave through the body between flat faces or at an edge takes {duration:.2e} s; force rises and falls \
                     within half a period of the highest mode, and more of them (reduction.modes) sharpen it"
                );
            }
        };
        write!(
            out,
            "contact \"{contact}\", {what} at {speed:.3} m/s takes {duration:.2e} s; that needs modes up to {frequency:.2e} Hz"
        )
    }
}

/// The fastest forces on each body at the first touches; bodies that joints connect share them.
pub fn shortest(touches: &FirstTouches<'_>) -> Vec<Option<ForceTime>> {
    let spec = touches.spec;
    let mut times: Vec<Option<ForceTime>> = vec![None; spec.bodies.len()];
    let assembly = assemblies(spec);
    for contact in &spec.contacts {
        for BodyForce { body: of, time, of_force, .. } in
            Scene::at(touches, touches.of(contact).as_deref()).forces(contact)
        {
            let joined: Vec<usize> = (0..times.len()).filter(|&i| assembly[i] == assembly[of]).collect();
            // Joints pass on the whole force; that a massive body takes little of its energy does
            // not count for its neighbours.
            let frequency = if joined.len() == 1 { time.frequency } else { of_force };
            for i in joined {
                if times[i].as_ref().is_none_or(|t| t.frequency < frequency) {
                    times[i] = Some(ForceTime { frequency, ..time.clone() });
                }
            }
        }
    }
    times
}

/// Frequencies up to which the bodies of a contact need modes, for other reasons than the duration
/// of its force.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ForceNeeds {
    /// Frequency up to which modes are to follow a force along a line \[Hz\].
    pub line: Option<f64>,
    /// Bodies without joints, with the energy that their waves take from a force at a point.
    radiation: Vec<(usize, Radiation)>,
}

impl ForceNeeds {
    /// Frequency above which waves in `body` take a negligible share of the energy of an impact at
    /// a point \[Hz\]: one with the `impulse` \[N s\] and the `duration` \[s\] of bodies that have
    /// met with the `speed` [m/s]. Infinite where it is not known.
    pub fn radiated(&self, body: usize, (impulse, speed, duration): (f64, f64, f64)) -> f64 {
        let mass = 0.5 * impulse.abs() / speed.abs();
        let of_body = self.radiation.iter().find(|(b, _)| *b == body && mass.is_finite());
        of_body.map_or(f64::INFINITY, |(_, radiation)| radiation.frequency(mass, duration))
    }
}

/// The needs of each contact.
pub fn force_needs(touches: &FirstTouches<'_>) -> Vec<ForceNeeds> {
    let (spec, assembly) = (touches.spec, assemblies(touches.spec));
    let is_free = |body: &usize| assembly.iter().filter(|n| **n == assembly[*body]).count() == 1;
    let is_rigid = |body: usize| matches!(spec.bodies[body].kind, BodyKind::Rigid(_));
    let of_contact = |contact: &ContactSpec| {
        if contact.bodies().all(is_rigid) {
            return ForceNeeds::default();
        }
        let touch = touches.of(contact);
        let scene = Scene::at(touches, touch.as_deref());
        let forces = scene.forces(contact);
        let line = forces.first().filter(|f| f.time.scale.is_line()).map(|f| f.time.frequency);
        let free = forces.iter().filter(|f| is_free(&f.body) && scene.is_pulse(contact.body, f.time.scale));
        ForceNeeds { line, radiation: free.filter_map(|f| Some((f.body, f.radiation?))).collect() }
    };
    spec.contacts.iter().map(of_contact).collect()
}

/// For each body, the lowest number of a body that it is joined to.
fn assemblies(spec: &RunSpec) -> Vec<usize> {
    let mut assembly: Vec<usize> = (0..spec.bodies.len()).collect();
    for joint in spec.joints.iter().chain(&spec.loops) {
        if let (Some(a), Some(b)) = (joint.parent.body, joint.child.body) {
            let (low, high) = (assembly[a].min(assembly[b]), assembly[a].max(assembly[b]));
            assembly.iter_mut().filter(|n| **n == high).for_each(|n| *n = low);
        }
    }
    assembly
}

/// One partner of an impact.
struct Partner {
    /// Along the normal [1/kg].
    inverse_mass: f64,
    /// Inverse impedance against waves along the body [s/kg].
    mobility: f64,
    /// The energy that waves take up; none in rigid bodies.
    radiation: Option<Radiation>,
    /// Velocity of the place that touches [m/s].
    velocity: Vector3<f64>,
}

/// The bodies at the first touch of a contact.
pub(super) struct Scene<'a> {
    touches: &'a FirstTouches<'a>,
    /// Bodies and contacts.
    pub spec: &'a RunSpec,
    /// Motions of the bodies just before it, as far as it is known; otherwise at the start.
    pub poses: &'a [BodyState],
    /// The places that touch; none where a body has no surface.
    sites: Option<Sites>,
    /// What touches, if it is known.
    kind: Option<TouchKind>,
}

/// Surfaces and places of both partners.
pub(super) struct Meeting {
    /// Surfaces of contact body and target, where Hertz's theory holds for them.
    pub surfaces: Option<[LocalSurface; 2]>,
    /// Angle between the outward normal of the contact body and the opposite of the target's
    /// \[rad\].
    pub miss: f64,
    /// From the target to the contact body.
    pub normal: Vector3<f64>,
    points: [Vector3<f64>; 2],
}

/// The force of a contact on one of its bodies.
struct BodyForce {
    body: usize,
    /// How fast it changes, and up to which frequency the body has modes for it.
    time: ForceTime,
    /// Frequency above which the spectrum of the force is negligible \[Hz\].
    of_force: f64,
    radiation: Option<Radiation>,
}

/// Two bodies that are going to meet.
pub(super) struct Impact {
    /// Surfaces and places.
    pub meeting: Meeting,
    /// Closing speed [m/s].
    pub speed: f64,
    /// Inverse of the effective mass of both bodies along the normal [1/kg].
    pub inverse_mass: f64,
    /// Sum of the inverse impedances of both bodies against waves along the normal [s/kg].
    pub mobility: f64,
    /// The energy that waves take up in each of the two bodies.
    radiation: Vec<Option<Radiation>>,
}

impl<'a> Scene<'a> {
    /// The bodies at `touch`, one of `touches`.
    pub(super) fn at(touches: &'a FirstTouches<'a>, touch: Option<&'a FirstTouch>) -> Self {
        let poses = touch.map_or(&touches.poses, |touch| &touch.poses);
        let kind = touch.and_then(|touch| touch.kind);
        Self { touches, spec: touches.spec, poses, sites: touch.map(|touch| touch.sites), kind }
    }

    /// The force of `contact` on each of its bodies.
    fn forces(&self, contact: &ContactSpec) -> Vec<BodyForce> {
        let Impact { meeting, speed, inverse_mass, mobility, radiation } = self.impact(contact);
        let touching = Touching { inverse_mass, mobility, speed };
        let line = self.line(contact, &meeting);
        // Where a flat face, an edge or a corner touches, curvatures of nodes around are round-off.
        let has_law = self.kind.is_none_or(|kind| kind.zone() == TouchZone::Interval);
        let surfaces = meeting.surfaces.as_ref().filter(|_| has_law);
        let known = surfaces.and_then(|surfaces| match line {
            Some(line) => line_time(surfaces, line, touching),
            None => point_time(surfaces, touching),
        });
        let is_solid = self.spec.bodies[contact.body].kind.motion() == RigidMotion::Spatial;
        let force = |(body, radiation): (usize, Option<Radiation>)| {
            let radiation = match line {
                Some(line) if is_solid => radiation.map(|radiation| radiation.along(line.length)),
                _ => radiation,
            };
            let (scale, duration, of_force, frequency) = match known {
                Some((scale, duration)) => {
                    let all = pulse_frequency(duration);
                    let radiated = radiation.filter(|_| self.is_pulse(contact.body, scale));
                    let radiated = radiated.map_or(all, |r| r.frequency(1.0 / inverse_mass, duration));
                    (scale, duration, rounded_up(all), rounded_up(all.min(radiated)))
                }
                None => {
                    let duration = self.wave_time(body);
                    let frequency = if is_solid { FLAT_SOLID } else { FLAT } / duration;
                    (TimeScale::Flat, duration, frequency, frequency)
                }
            };
            let time = ForceTime { contact: contact.name.clone(), scale, duration, speed, frequency };
            BodyForce { body, time, of_force, radiation }
        };
        contact.bodies().zip(radiation).map(force).collect()
    }

    /// Whether the force of a touch on `body` is a single pulse, and the share of its energy that
    /// waves take is known: not about an axis of symmetry.
    fn is_pulse(&self, body: usize, scale: TimeScale) -> bool {
        let is_axial = self.spec.bodies[body].kind.motion() == RigidMotion::Axial;
        scale == TimeScale::Hertz || (scale == TimeScale::Line && !is_axial)
    }

    /// The line along which the bodies of `contact` touch, if they do.
    fn line(&self, contact: &ContactSpec, meeting: &Meeting) -> Option<TouchLine> {
        let (surfaces, size) = (meeting.surfaces.as_ref()?, self.size(contact.body));
        if let Some(length) = self.thickness(contact.body) {
            let curvature = surfaces.iter().map(LocalSurface::in_plane).sum();
            return Some(TouchLine { length, curvature, size });
        }
        let (curvature, across) = across_line(surfaces, size).filter(|_| meeting.miss <= FACING)?;
        let pose = &self.poses[contact.body];
        let is_axisymmetric = self.spec.bodies[contact.body].kind.motion() == RigidMotion::Axial;
        let length = if is_axisymmetric {
            // A circle about the axis.
            let at = pose.rotation.inverse_transform_vector(&(meeting.points[0] - pose.position));
            2.0 * PI * at.x.hypot(at.y)
        } else {
            let along = meeting.normal.cross(&across).try_normalize(0.0)?;
            contact
                .bodies()
                .map(|body| extent(self.spec, self.poses, body, &along))
                .fold(f64::INFINITY, f64::min)
        };
        (length > SHORTEST_LINE * size && length.is_finite()).then_some(TouchLine { length, curvature, size })
    }

    /// Estimate of the first impact of `contact`.
    pub(super) fn impact(&self, contact: &ContactSpec) -> Impact {
        let meeting = self.meeting(contact);
        let bodies = contact.bodies().zip(meeting.points);
        let partners: Vec<Partner> =
            bodies.map(|(body, point)| self.partner(body, point, &meeting.normal)).collect();
        let sum = |of: fn(&Partner) -> f64| partners.iter().map(of).sum::<f64>();
        let (inverse_mass, mobility) = (sum(|p| p.inverse_mass), sum(|p| p.mobility));
        let radiation = partners.iter().map(|p| p.radiation).collect();
        Impact { speed: self.speed(&partners, &meeting), meeting, inverse_mass, mobility, radiation }
    }

    /// Thickness of a plane model.
    pub(super) fn thickness(&self, body: usize) -> Option<f64> {
        self.spec.bodies[body].kind.thickness()
    }

    /// Where the partners meet; if no touch is found, at the origins of their frames.
    fn meeting(&self, contact: &ContactSpec) -> Meeting {
        let mut found = match contact.spheres() {
            Some((own, target)) => self.meeting_of_spheres((contact.body, own), target),
            None => self.meeting_of_surfaces(contact),
        };
        // Of rigid bodies the material given for Hertz's law counts.
        let surfaces = found.as_mut().and_then(|meeting| meeting.surfaces.as_mut());
        if let (Some(law), Some(surfaces)) = (contact.law.hertz(), surfaces) {
            surfaces
                .iter_mut()
                .zip(law.solids())
                .for_each(|(surface, of)| surface.compliance = of.compliance());
        }
        found.unwrap_or_else(|| {
            let origin = self.poses[contact.body].position;
            let other = contact.target.body().map_or(origin, |b| self.poses[b].position);
            let points = [origin, other];
            Meeting { surfaces: None, miss: 0.0, normal: Vector3::z(), points }
        })
    }

    fn meeting_of_spheres(
        &self,
        (body, own): (usize, &HertzSphere),
        target: Target<(usize, &HertzSphere)>,
    ) -> Option<Meeting> {
        let centre = |sphere: &HertzSphere, body: usize| match &sphere.centre {
            Place::Point(point) => Some(self.in_space(body, point)),
            Place::Area(area) => Some(self.in_space(body, &area.centre)),
            Place::Marker(_) => None,
        };
        let surface = |s: &HertzSphere| LocalSurface::sphere(s.radius, 0.0);
        let at = centre(own, body)?;
        match target {
            Target::Body((body, sphere)) => {
                let to = centre(sphere, body)?;
                let normal = (at - to).try_normalize(0.0)?;
                let points = [at - normal * own.radius, to + normal * sphere.radius];
                Some(Meeting { surfaces: Some([surface(own), surface(sphere)]), miss: 0.0, normal, points })
            }
            Target::Plane(half_space) => {
                let normal = half_space.normal.into_inner();
                let touching = at - normal * own.radius;
                let surfaces = Some([surface(own), LocalSurface::plane(0.0)]);
                Some(Meeting { surfaces, miss: 0.0, normal, points: [touching, half_space.foot(&touching)] })
            }
        }
    }

    fn meeting_of_surfaces(&self, contact: &ContactSpec) -> Option<Meeting> {
        let sites = self.sites?;
        let view = |body: usize, site: &SurfacePlace| self.view(body, site);
        let own = view(contact.body, &sites.contact_body)?;
        let at = self.in_space(contact.body, &own.point);
        let target = match contact.target {
            Target::Body(target) => target,
            Target::Plane(plane) => {
                let (surfaces, normal) =
                    (Some([own.surface, LocalSurface::plane(0.0)]), plane.normal.into_inner());
                let miss = own.outward.angle(&-normal);
                return Some(Meeting { surfaces, miss, normal, points: [at, plane.foot(&at)] });
            }
        };
        let site = sites.target?;
        let facing = view(target, &site)?;
        // What is nearest may be an edge of several sides of a mesh, or where a line of a face
        // ends, of which any face may have been found.
        let is_mesh = |body: usize| self.spec.bodies[body].kind.brings_mesh();
        let has_mesh = is_mesh(contact.body) || is_mesh(target);
        let (own, facing) = if !has_mesh || own.outward.angle(&-facing.outward) <= FACING {
            (own, facing)
        } else {
            let turned = self.facing(contact.body, &sites.contact_body, &-facing.outward);
            let own = turned.unwrap_or(own);
            let turned = self.facing(target, &site, &-own.outward);
            (own, turned.unwrap_or(facing))
        };
        Some(Meeting {
            surfaces: Some([own.surface, facing.surface]),
            miss: own.outward.angle(&-facing.outward),
            normal: (facing.outward - own.outward).try_normalize(0.0)?,
            points: [at, self.in_space(target, &facing.point)],
        })
    }

    /// The surface of a body at a place.
    fn view(&self, body: usize, site: &SurfacePlace) -> Option<SurfaceView> {
        let kind = &self.spec.bodies[body].kind;
        let compliance = kind.slowest_material().map_or(0.0, plane_compliance);
        SurfaceView::new(self.touches.surface(body)?.as_ref(), compliance, &self.poses[body].rotation, site)
    }

    /// The view of the surface at `site`, on the face that meets there whose normal is nearest to
    /// the `direction` in space.
    fn facing(&self, body: usize, site: &SurfacePlace, direction: &Vector3<f64>) -> Option<SurfaceView> {
        let surface = self.touches.surface(body)?;
        let in_body = self.poses[body].rotation.inverse_transform_vector(direction);
        let direction = surface.motion().components(in_body.as_ref());
        self.view(body, &surface.turned_to(site, &direction.into()))
    }

    fn in_space(&self, body: usize, point: &[f64; 3]) -> Vector3<f64> {
        let pose = &self.poses[body];
        pose.position + pose.rotation * self.spec.bodies[body].kind.motion().in_space(point)
    }

    /// A partner that touches at `point` of space, as if it hung on no joint.
    fn partner(&self, body: usize, point: Vector3<f64>, normal: &Vector3<f64>) -> Partner {
        let pose = &self.poses[body];
        let Inertia { motion, mass, centre, inertia, mobility, radiation } = self
            .touches
            .measured(body, || Inertia::of(&self.spec.bodies[body].kind, self.spec.is_held(body)));
        let (arm, from_centre) = (point - pose.position, point - pose.position - pose.rotation * centre);
        let axes = pose.rotation.to_rotation_matrix().into_inner();
        let inertia = axes * inertia * axes.transpose();
        let inverse_mass = inverse_effective_mass(motion, mass, &inertia, &from_centre, normal);
        let velocity = pose.velocity + (pose.rotation * pose.angular_velocity_in_body).cross(&arm);
        Partner { inverse_mass, mobility, radiation, velocity }
    }

    /// Speed at which the places that meet approach each other, with what gravity adds over the gap:
    /// along the normal of the touch, where one is known. If they are at rest, or do not approach,
    /// that of the fastest body.
    fn speed(&self, partners: &[Partner], meeting: &Meeting) -> f64 {
        let velocity = |i: usize| partners.get(i).map_or_else(Vector3::zeros, |p| p.velocity);
        let gap = (meeting.points[0] - meeting.points[1]).norm();
        let falling = (2.0 * self.spec.settings.gravity.norm() * gap).sqrt();
        let relative = velocity(0) - velocity(1);
        let closing = match self.sites {
            Some(_) => (-relative.dot(&meeting.normal)).max(0.0),
            None => relative.norm(),
        };
        let known = |speed: &f64| speed.is_finite() && *speed > 0.0;
        // Looks at all bodies and measures those that turn: only where nothing closes.
        let fastest = || {
            let spin = |(i, p): (usize, &BodyState)| match p.angular_velocity_in_body.norm() {
                0.0 => p.velocity.norm(),
                spin => p.velocity.norm() + spin * self.size(i),
            };
            self.poses.iter().enumerate().map(spin).fold(0.0, f64::max)
        };
        Some(closing.hypot(falling))
            .filter(known)
            .or_else(|| Some(fastest()).filter(known))
            .unwrap_or(UNKNOWN_SPEED)
    }

    /// Longest way through a body \[m\].
    pub(super) fn size(&self, body: usize) -> f64 {
        self.touches.size(body)
    }

    /// Time of a wave there and back through a body; infinite without waves.
    fn wave_time(&self, body: usize) -> f64 {
        slowest_bar(&self.spec.bodies[body].kind).map_or(f64::INFINITY, |c| 2.0 * self.size(body) / c)
    }
}

/// Speed of the slowest waves along bars of the body's materials [m/s]; none of a body that has
/// none.
fn slowest_bar(body: &BodyKind) -> Option<f64> {
    body.slowest_material().map(Material::bar_speed)
}

/// The inertia of a body and its impedance against waves.
#[derive(Clone)]
struct Inertia {
    motion: RigidMotion,
    /// [kg].
    mass: f64,
    centre: Vector3<f64>,
    /// About the centre [kg m²].
    inertia: Matrix3<f64>,
    /// Inverse impedance `L / (rho c V)` of a bar as long as the body [s/kg].
    mobility: f64,
    radiation: Option<Radiation>,
}

impl Inertia {
    fn unknown(motion: RigidMotion) -> Self {
        let (mass, centre, inertia) = (f64::INFINITY, Vector3::zeros(), Matrix3::identity());
        Self { motion, mass, centre, inertia, mobility: 0.0, radiation: None }
    }

    /// The inertia of a body, infinite if it `is_held`; unknown of one from a file, on which no
    /// contact acts.
    fn of(body: &BodyKind, is_held: bool) -> Self {
        let unknown = Self::unknown(body.motion());
        if let Some(rigid) = body.rigid() {
            let mass = if is_held { f64::INFINITY } else { rigid.mass };
            let inertia = if is_held { Matrix3::zeros() } else { rigid.inertia };
            return Self { mass, centre: rigid.centre_of_mass, inertia, ..unknown };
        }
        let (Some(found), Some(slowest)) = (mass_properties(body), body.slowest_material()) else {
            return unknown;
        };
        // The moments of a density: its volume is the mass.
        let mass = found.volume;
        let [longest, length] = wave_lengths(body);
        Self {
            mass,
            centre: Vector3::from(found.centre()),
            inertia: Matrix3::from(found.central_inertia()),
            mobility: length / (mass * slowest.bar_speed()),
            radiation: Some(Radiation::new(slowest, mass / slowest.density(), longest, body.thickness())),
            ..unknown
        }
    }
}

/// Moments of the density of a body with elements; none if it has none, or if they are folded.
pub fn mass_properties(body: &BodyKind) -> Option<MassProperties> {
    if let Some(meshed) = body.meshed() {
        let materials = meshed.materials().ok()?;
        let density = |e: usize| materials.on(e).density();
        return MassProperties::of_space(&meshed.space(), meshed.mesh.model(), &density).ok();
    }
    let elastic = body.elastic()?;
    Some(MassProperties::of(&elastic.shape, &elastic.model).ok()?.times(elastic.material.density()))
}

/// Lengths of the ways of waves through a body: the longest straight one, and the longest one along
/// the body \[m\].
fn wave_lengths(body: &BodyKind) -> [f64; 2] {
    let Some(of) = body.geometry() else { return [body.diagonal().unwrap_or(0.0); 2] };
    let longest = lengths(of.shape).into_iter().fold(0.0, f64::max);
    let is_plane = of.model.thickness().is_some();
    [longest, if is_plane { longest.max(length_along(of.shape)) } else { longest }]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_neglected_share_of_half_a_sine_is_what_it_says() {
        // |F|^2 = (2 pi cos(w/2) / (pi^2 - w^2))^2 of a pulse of length and height one; the whole integral is pi/2.
        let power = |w: f64| (2.0 * PI * (0.5 * w).cos() / (PI * PI - w * w)).powi(2);
        let start = 2.0 * PI * pulse_frequency(1.0);
        let (n, end) = (2_000_000, 4000.0);
        let step = (end - start) / f64::from(n);
        let tail: f64 = (0..n).map(|i| power(start + (f64::from(i) + 0.5) * step) * step).sum();
        let share = tail / (0.5 * PI);
        // The closed form has the mean of cos^2 and w^-4 for the whole tail: next terms are
        // (pi/w)^2 = 0.8 % and the first swing of the cosine, a tenth.
        assert!((share / NEGLECTED - 1.0).abs() < 0.15, "{share}");
    }
}
