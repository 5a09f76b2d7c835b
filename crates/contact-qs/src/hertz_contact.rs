//! Hertz contact of two bodies with smooth surfaces, or of one and a plane, as a force element
//! (docs/theory.md Eqs. C.79 to C.90, of plane models C.104 to C.106).

mod levels;
mod moment;
pub(super) mod sphere;
mod geometry;
mod sliding;

use ffr_dynamics::data_error::DataError;
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::{BodyState, Findings, ForceElement, ForceEnergies, GeneralisedForce, Motion};
use nalgebra::Vector3;

use crate::contact_element::{Contact, ContactElement, ContactReport, Meeting};
use crate::law::{Friction, HertzPair, Solid};
use crate::search::{Detector, SearchWorkspace};
use crate::solver_fault::SolverFault;
use crate::{ContactError, Target};
use geometry::{Curved, Geometry, Slice, Touch};
use moment::StiffnessChange;
use sliding::{Frame, Sliding, SlidingFound, SlidingState};
use sphere::{Sphere, check_solid, hertz_pair};

/// Hertz contact: a force along the common normal of the closest places, which derives from a
/// potential, with Coulomb's friction on the contact ellipse. Forces and couples on the two bodies
/// are opposite and act in the same places of space, so that momentum stays. Energy is recorded as
/// `elastic_high`: it is the quasistatic elastic energy of the contact zone.
#[derive(Debug, Clone)]
pub struct HertzContact {
    geometry: Geometry,
    solids: [Solid; 2],
    sliding: Option<Sliding>,
}

/// Buffers of a Hertz contact.
#[derive(Debug, Clone, Default)]
pub struct HertzWorkspace {
    search: SearchWorkspace,
    /// Mode shapes of both bodies where they are nearest.
    shapes: [Vec<Vector3<f64>>; 2],
}

/// What an evaluation of a Hertz contact finds.
#[derive(Debug, Clone, Default)]
pub struct HertzFound {
    report: ContactReport,
    sliding: SlidingFound,
}

impl Findings for HertzFound {
    fn energies(&self) -> ForceEnergies {
        self.report.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.report.force
    }

    fn is_idle(&self) -> bool {
        self.report.n_active == 0
    }
}

impl HertzContact {
    /// Contact of `sphere`, on the contact body, with another one, or with a plane: a half space of
    /// `solid` ([`Solid::RIGID`] for a rigid one), which a sphere brings with it.
    ///
    /// # Errors
    /// [`ContactError::Data`] if a value is not positive, [`ContactError::RigidPair`] if both partners are rigid, [`ContactError::OneBody`] if both
    /// belong to one body.
    pub fn of_spheres(sphere: Sphere, target: Target<Sphere>, solid: Solid) -> Result<Self, ContactError> {
        sphere.validate()?;
        let (solid, radius) = match &target {
            Target::Plane(_) => (solid, f64::INFINITY),
            Target::Body(other) => {
                other.validate()?;
                (other.solid, other.radius)
            }
        };
        if target.as_ref().body().is_some_and(|other| other.body == sphere.body) {
            return Err(ContactError::OneBody { body: sphere.body });
        }
        check_solid(solid)?;
        let solids = [sphere.solid, solid];
        let pair = hertz_pair(solids, [sphere.radius, radius])?;
        Ok(Self { geometry: Geometry::spheres(sphere, target, pair)?, solids, sliding: None })
    }

    /// Contact of `surfaces` of `solids`, the contact body's first, which are wherever they touch
    /// smooth and curved against each other; a plane is a half space.
    ///
    /// # Errors
    /// [`ContactError`] as [`HertzContact::of_spheres`], or if the bodies move in different ways.
    pub fn of_surfaces(surfaces: Detector, solids: [Solid; 2]) -> Result<Self, ContactError> {
        if let Some(other) = surfaces.target.as_ref().body() {
            let [first, second] = [surfaces.own.model.motion(), other.model.motion()];
            if other.body == surfaces.own.body {
                return Err(ContactError::OneBody { body: other.body });
            }
            if first != second {
                return Err(ContactError::MixedModels { first, second });
            }
        }
        let compliance = compliance(&solids)?;
        let geometry = Geometry::Surfaces { surfaces, compliance, slice: None };
        Ok(Self { geometry, solids, sliding: None })
    }

    /// Contact along a line of the `surfaces` of plane bodies of `solids`, those of plane stress by [`Solid::of_plane_stress`], as
    /// thick as `thicknesses` say, the contact body's first; one without a thickness, and a plane, is as thick as the other (Eqs. C.104, C.105).
    ///
    /// # Errors
    /// As [`HertzContact::of_surfaces`]; [`ContactError::Data`] if a thickness is not positive.
    pub fn of_plane_surfaces(
        surfaces: Detector,
        solids: [Solid; 2],
        thicknesses: [Option<f64>; 2],
    ) -> Result<Self, ContactError> {
        let mut contact = Self::of_surfaces(surfaces, solids)?;
        let Geometry::Surfaces { surfaces, compliance, slice } = &mut contact.geometry else {
            return Ok(contact);
        };
        let [own, other] = [0, 1].map(|side| thicknesses[side].or(thicknesses[1 - side]).unwrap_or(1.0));
        if let Some(&value) = [own, other].iter().find(|t| !(**t > 0.0 && t.is_finite())) {
            let what = "the thickness of a plane body [m]".into();
            return Err(DataError::OutOfRange { what, value, range: "> 0 and finite" }.into());
        }
        let shares = [solids[0].compliance(), solids[1].compliance() * own / other];
        let width = surfaces.own.model.least_width();
        let widths =
            [width, surfaces.target.as_ref().body().map_or(width, |other| other.model.least_width())];
        *compliance = shares.iter().sum();
        let logarithm =
            shares.iter().zip(widths).map(|(share, width)| share * width.ln()).sum::<f64>() / *compliance;
        *slice = Some(Slice { thickness: own, size: logarithm.exp() });
        Ok(contact)
    }

    /// The same with friction of coefficient `coefficient`, of stick and slip alike.
    ///
    /// # Errors
    /// [`ContactError::Friction`] if the coefficient is negative or not finite.
    pub fn with_friction(mut self, coefficient: f64) -> Result<Self, ContactError> {
        Friction::new(coefficient).check()?;
        self.sliding = (coefficient > 0.0).then(|| Sliding::new(coefficient, self.geometry.size()));
        Ok(self)
    }

    /// Modulus and radius of two spheres, or of a sphere and a plane; none of other surfaces.
    pub fn pair(&self) -> Option<HertzPair> {
        self.geometry.pair()
    }

    /// Size of the smaller body, of spheres their diameter \[m\].
    pub fn size(&self) -> f64 {
        self.geometry.size()
    }

    /// Where the bodies are nearest in the motions `bodies`; the gap is NaN where that is not
    /// known.
    fn touch(&self, bodies: &[BodyState], workspace: &mut HertzWorkspace) -> Touch {
        self.geometry.touch(bodies, &mut workspace.search).unwrap_or_else(|_| Touch::unknown())
    }

    /// Adds the force `force` on the contact body and its opposite on the target, both at `points`
    /// of space \[N\].
    fn push(
        &self,
        motion: Motion<'_>,
        points: [&Vector3<f64>; 2],
        shapes: &[Vec<Vector3<f64>>; 2],
        force: &Vector3<f64>,
        forces: &mut [GeneralisedForce],
    ) {
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let Some(body) = self.geometry.body(side) else { continue };
            let (state, sum) = (&motion.bodies[body], &mut forces[body]);
            let force = force * sign;
            let local = state.rotation.inverse_transform_vector(&force);
            let arm = state.rotation.inverse_transform_vector(&(points[side] - state.position));
            sum.force += force;
            sum.torque_in_body += arm.cross(&local);
            for (f, shape) in sum.elastic.iter_mut().zip(&shapes[side]) {
                *f += shape.dot(&local);
            }
        }
    }

    /// Adds a couple on the contact body and its opposite on the target \[N m\].
    fn turn(&self, motion: Motion<'_>, couple: &Vector3<f64>, forces: &mut [GeneralisedForce]) {
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let Some(body) = self.geometry.body(side) else { continue };
            let rotation = &motion.bodies[body].rotation;
            forces[body].torque_in_body += rotation.inverse_transform_vector(&(couple * sign));
        }
    }

    /// Normal force and what its stiffness changes by; records the energy.
    fn press(
        &self,
        motion: Motion<'_>,
        touch: &Touch,
        curved: &Curved,
        shapes: &[Vec<Vector3<f64>>; 2],
        report: &mut ContactReport,
        forces: &mut [GeneralisedForce],
    ) {
        let approach = -touch.gap;
        let (force, energy, _) = curved.law.at(approach);
        let axes = curved.law.semi_axes(force);
        let normal = touch.normal * force;
        self.push(motion, touch.points.each_ref(), shapes, &normal, forces);
        let change = self.geometry.stiffness_change(motion.bodies, touch, curved, axes, force);
        if let Some(StiffnessChange { force, couple }) = change {
            self.push(motion, [&touch.points[1]; 2], shapes, &force, forces);
            self.turn(motion, &couple, forces);
            report.force += force;
        }
        report.normal_force = force;
        report.force += normal;
        report.penetration = approach;
        report.n_active = 1;
        report.contact_area = curved.law.area(force);
        report.energies.elastic_high = energy;
    }
}

/// Sum of the compliances of both partners.
fn compliance(solids: &[Solid; 2]) -> Result<f64, ContactError> {
    solids.iter().try_for_each(|solid| check_solid(*solid))?;
    let sum = solids[0].compliance() + solids[1].compliance();
    if sum > 0.0 { Ok(sum) } else { Err(ContactError::RigidPair) }
}

impl ForceElement for HertzContact {
    type State = SlidingState;
    type Workspace = HertzWorkspace;
    type Found = HertzFound;

    fn start(&self) -> (SlidingState, HertzWorkspace, HertzFound) {
        let shapes = self.geometry.shapes();
        let n = self.sliding.as_ref().map_or(0, Sliding::n_levels);
        let state = SlidingState::new(n, &shapes);
        let found = HertzFound { report: ContactReport::default(), sliding: SlidingFound::new(n, &shapes) };
        (state, HertzWorkspace { search: SearchWorkspace::new(), shapes }, found)
    }

    fn evaluate(
        &self,
        motion: Motion<'_>,
        state: &mut SlidingState,
        workspace: &mut HertzWorkspace,
        found: &mut HertzFound,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        found.report = ContactReport::default();
        let touch = self.touch(motion.bodies, workspace);
        if !touch.gap.is_finite() {
            return Err(SolverFault::HertzGap { gap: touch.gap, time: motion.time }.into());
        }
        let is_touching = touch.gap < 0.0;
        if is_touching || self.sliding.is_some() {
            self.geometry.shapes_at(&touch, &mut workspace.shapes);
        }
        let curved = if is_touching {
            Some(self.geometry.curved(motion, &touch).map_err(EvaluationFailure::from)?)
        } else {
            None
        };
        if let Some(curved) = &curved {
            self.press(motion, &touch, curved, &workspace.shapes, &mut found.report, forces);
        }
        let Some(sliding) = &self.sliding else { return Ok(()) };
        let bodies = [0, 1].map(|side| self.geometry.body(side));
        let pressed = sliding::Pressed { touch: &touch, curved: curved.as_ref(), solids: &self.solids };
        sliding.evaluate((motion, bodies), &pressed, &workspace.shapes, (state, &mut found.sliding));
        if curved.is_some() {
            let SlidingFound { force, point, .. } = found.sliding;
            self.push(motion, [&point; 2], &workspace.shapes, &force, forces);
            sliding::record(&found.sliding, &mut found.report);
        }
        Ok(())
    }

    /// Of the normal force, whose stiffness is the slope of the law; friction is left to differences.
    fn rates(
        &self,
        (motion, by_velocity): (Motion<'_>, bool),
        _: &mut SlidingState,
        workspace: &mut HertzWorkspace,
        found: &HertzFound,
        rates: &mut [GeneralisedForce],
    ) -> bool {
        let frames = [0, 1].map(|side| Frame(self.geometry.body(side).map(|body| &motion.bodies[body])));
        if by_velocity || found.is_idle() || frames.iter().all(Frame::is_at_rest) {
            return true;
        }
        let touch = self.touch(motion.bodies, workspace);
        let Some(curved) = self.geometry.curved(motion, &touch).ok().filter(|_| self.sliding.is_none())
        else {
            return false;
        };
        self.geometry.shapes_at(&touch, &mut workspace.shapes);
        let shapes = &workspace.shapes;
        let [own, other] = [0, 1].map(|side| frames[side].velocity(&touch.points[side], &shapes[side]));
        let (_, _, slope) = curved.law.at(-touch.gap);
        let force = touch.normal * (slope * touch.normal.dot(&(other - own)));
        self.push(motion, touch.points.each_ref(), shapes, &force, rates);
        true
    }

    fn clearance(&self, bodies: &[BodyState]) -> Option<f64> {
        self.geometry.clearance(bodies)
    }

    /// Friction counts slip from where the bodies stood when they touched.
    fn notes_motions(&self) -> bool {
        self.sliding.is_some()
    }

    fn save(&self, state: &mut SlidingState, found: &HertzFound) {
        if self.sliding.is_some() {
            state.accept(&found.sliding);
        }
    }

    fn restore(&self, _state: &mut SlidingState, found: &mut HertzFound) {
        found.sliding.discard();
    }
}

impl Contact for HertzContact {
    fn kind(&self) -> &'static str {
        self.geometry.kind()
    }

    fn bodies(&self) -> (usize, Option<usize>) {
        (self.geometry.body(0).unwrap_or(0), self.geometry.body(1))
    }

    fn penalty(&self) -> f64 {
        f64::INFINITY
    }

    fn n_points(&self) -> usize {
        1
    }

    fn point(&self, _: usize) -> Option<([f64; 3], f64)> {
        None
    }
}

impl ContactElement for HertzContact {
    fn report<'a>(&self, found: &'a HertzFound) -> &'a ContactReport {
        &found.report
    }

    fn meeting(&self, motion: Motion<'_>, _: &SlidingState, workspace: &mut HertzWorkspace) -> Meeting {
        let Touch { gap, normal, points, .. } = self.touch(motion.bodies, workspace);
        // In the middle of the overlap.
        Meeting { gap, normal, place: points[0] - normal * (0.5 * gap.min(0.0)) }
    }

    fn point_forces<'a>(&self, _: &'a SlidingState, _: &'a HertzFound) -> Option<&'a [f64]> {
        None
    }

    fn friction_forces(&self, _: &SlidingState, _: &HertzFound) -> Vec<Vector3<f64>> {
        Vec::new()
    }

    fn prescribe_friction(&self, _: Option<&[Vector3<f64>]>, _: &mut SlidingState, _: &HertzFound) {}

    fn set_penalty(&mut self, _: f64, _: &mut SlidingState) -> Result<(), ContactError> {
        Err(ContactError::NoPenalty { kind: self.kind() })
    }

    fn compliance_weight(
        &self,
        _: (Motion<'_>, f64),
        _: &mut SlidingState,
        _: &mut HertzWorkspace,
        _: &mut HertzFound,
    ) -> Result<Option<f64>, EvaluationFailure> {
        Ok(None)
    }

    fn interface_force(&self, _: usize, _: &HertzFound, _: &mut [f64]) -> bool {
        false
    }
}
