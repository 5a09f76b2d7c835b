//! Where two bodies of a Hertz contact are nearest, and how they are curved there.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::{BodyState, Motion};
use nalgebra::{Matrix3, Vector3};

use super::moment::{Bent, StiffnessChange, stiffness_change};
use crate::hertz_contact::sphere::Sphere;
use crate::law::{HertzEllipse, HertzPair, LineLaw, TouchLaw};
use crate::search::{BodySurface, Detector, LocalShape, SearchWorkspace, Site};
use crate::solver_fault::SolverFault;
use crate::{ContactError, Target};

/// Cosine of the angle between the normal of a surface and the line to the other body below which
/// an edge is nearest: 8 degrees, for faces that only approximate a smooth surface.
const ALONG: f64 = 0.99;
/// Distance from the axis of an axisymmetric body, over its size, below which a place is its pole.
const POLE: f64 = 1e-6;
/// Semi-axis of the contact over the size of a body above which the contact is one along a line.
const LONG: f64 = 0.25;

/// The bodies of a contact.
#[derive(Debug, Clone)]
pub(super) enum Geometry {
    /// A sphere and a sphere or a plane.
    Spheres { sphere: Sphere, target: Target<Sphere>, pair: HertzPair, ellipse: HertzEllipse },
    /// Any surfaces, or a surface and a plane.
    Surfaces { surfaces: Detector, compliance: f64, slice: Option<Slice> },
}

/// What plane bodies are to the law of their contact along a line.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slice {
    /// To which the compliance belongs \[m\].
    pub thickness: f64,
    /// On whose logarithm the approach depends (Eq. C.105) \[m\].
    pub size: f64,
}

/// Where two bodies are nearest, in space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Touch {
    pub gap: f64,
    /// Unit normal towards the contact body.
    pub normal: Vector3<f64>,
    /// On the contact body and on the target.
    pub points: [Vector3<f64>; 2],
    /// On pieces of their surfaces.
    pub places: Option<[Site; 2]>,
}

impl Touch {
    pub fn unknown() -> Self {
        let nowhere = Vector3::repeat(f64::NAN);
        Self { gap: f64::NAN, normal: nowhere, points: [nowhere; 2], places: None }
    }
}

/// How two bodies are curved where they touch, in space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Curved {
    pub law: TouchLaw,
    /// Directions of the larger and the smaller axis.
    pub axes: [Vector3<f64>; 2],
    /// Curvatures of both bodies; none of spheres, which are curved alike everywhere.
    pub bending: Option<[Matrix3<f64>; 2]>,
}

impl Geometry {
    pub fn spheres(sphere: Sphere, target: Target<Sphere>, pair: HertzPair) -> Result<Self, ContactError> {
        let curvature = 1.0 / pair.radius;
        let ellipse =
            HertzEllipse::new(curvature, curvature, 1.0 / pair.modulus).ok_or(ContactError::RigidPair)?;
        Ok(Self::Spheres { sphere, target, pair, ellipse })
    }

    pub fn kind(&self) -> &'static str {
        let is_on_plane = self.body(1).is_none();
        match self {
            Self::Spheres { .. } if is_on_plane => "sphere-plane",
            Self::Spheres { .. } => "sphere-sphere",
            Self::Surfaces { .. } if is_on_plane => "surface-plane",
            Self::Surfaces { .. } => "surface-surface",
        }
    }

    pub fn pair(&self) -> Option<HertzPair> {
        match self {
            Self::Spheres { pair, .. } => Some(*pair),
            Self::Surfaces { .. } => None,
        }
    }

    /// Index of the contact body (0) or the target (1); none of a plane.
    pub fn body(&self, side: usize) -> Option<usize> {
        match (self, side) {
            (Self::Spheres { sphere, .. }, 0) => Some(sphere.body),
            (Self::Spheres { target, .. }, _) => target.as_ref().body().map(|sphere| sphere.body),
            (Self::Surfaces { surfaces, .. }, _) => surface(surfaces, side).map(|surface| surface.body),
        }
    }

    /// Size of the smaller body \[m\].
    pub fn size(&self) -> f64 {
        match self {
            Self::Spheres { sphere, target, .. } => {
                2.0 * target.as_ref().body().map_or(sphere.radius, |other| other.radius.min(sphere.radius))
            }
            Self::Surfaces { surfaces, .. } => surfaces.least_size(),
        }
    }

    /// Mode shapes of both bodies, of spheres at their centres, of surfaces zeros.
    pub fn shapes(&self) -> [Vec<Vector3<f64>>; 2] {
        match self {
            Self::Spheres { sphere, target, .. } => {
                let other = target.as_ref().body().map_or_else(Vec::new, |other| other.centre.shapes.clone());
                [sphere.centre.shapes.clone(), other]
            }
            Self::Surfaces { surfaces, .. } => {
                let zeros = |of: &BodySurface| vec![Vector3::zeros(); of.model.n_modes()];
                [0, 1].map(|side| surface(surfaces, side).map_or_else(Vec::new, zeros))
            }
        }
    }

    /// Replaces `shapes` by the mode shapes where the bodies are nearest; those of spheres stay
    /// what they are at the centres.
    pub fn shapes_at(&self, touch: &Touch, shapes: &mut [Vec<Vector3<f64>>; 2]) {
        let (Self::Surfaces { surfaces, .. }, Some(places)) = (self, &touch.places) else { return };
        for (side, shapes) in shapes.iter_mut().enumerate() {
            if let Some(surface) = surface(surfaces, side) {
                surface.model.shapes_at(&places[side], shapes);
            }
        }
    }

    /// Where the bodies are nearest; the gap is NaN where the centres of two spheres coincide.
    pub fn touch(&self, bodies: &[BodyState], search: &mut SearchWorkspace) -> Result<Touch, ContactError> {
        match self {
            Self::Spheres { sphere, target, .. } => {
                let found = sphere.nearest(target.as_ref(), bodies);
                let touch = |(gap, normal, points)| Touch { gap, normal, points, places: None };
                Ok(found.map_or_else(Touch::unknown, touch))
            }
            Self::Surfaces { surfaces, .. } => {
                let found = surfaces.followed(bodies, search)?;
                let points = found.sites.map(|site| site.point);
                Ok(Touch { gap: found.gap, normal: found.normal, points, places: Some(found.places) })
            }
        }
    }

    /// The way that the frames of rigid bodies may move against each other before spheres on them touch, however they
    /// turn: a centre beside the origin of its frame by `a` moves by `2 a` more at most \[m\]. None of other bodies.
    pub fn clearance(&self, bodies: &[BodyState]) -> Option<f64> {
        let Self::Spheres { sphere, target, .. } = self else { return None };
        let spheres = [Some(sphere), target.as_ref().body()];
        let centres = || spheres.iter().flatten().map(|sphere| &sphere.centre);
        let turned: f64 = centres().map(|centre| 2.0 * centre.position.norm()).sum();
        if centres().any(|centre| !centre.shapes.is_empty()) {
            return None;
        }
        sphere.nearest(target.as_ref(), bodies).map(|(gap, ..)| gap - turned)
    }

    /// How the bodies are curved where they touch.
    pub fn curved(&self, motion: Motion<'_>, touch: &Touch) -> Result<Curved, SolverFault> {
        let (surfaces, compliance, slice, places) = match (self, &touch.places) {
            (Self::Spheres { ellipse, .. }, _) => {
                let axes = tangents(&touch.normal);
                return Ok(Curved { law: TouchLaw::Point(*ellipse), axes, bending: None });
            }
            (Self::Surfaces { surfaces, compliance, slice }, Some(places)) => {
                (surfaces, *compliance, *slice, places)
            }
            (Self::Surfaces { .. }, None) => {
                return Err(SolverFault::HertzGap { gap: touch.gap, time: motion.time });
            }
        };
        let no_point = |why| SolverFault::NoHertzPoint { why, time: motion.time };
        let at = |side: usize, place: &Site, sign: f64| {
            let Some(surface) = surface(surfaces, side) else { return Ok(Matrix3::zeros()) };
            let state = &motion.bodies[surface.body];
            let shape =
                surface.model.local_shape(place).ok_or_else(|| no_point("a place without curvature"))?;
            // The end of a face may be found as that of another one.
            let beside = || {
                let outward = state.rotation.inverse_transform_vector(&touch.normal) * sign;
                let there = surface.model.turned_to(place, &outward, ALONG)?;
                shape_in_space(&surface.model.local_shape(&there)?, surface, state, touch, sign)
            };
            shape_in_space(&shape, surface, state, touch, sign)
                .or_else(beside)
                .ok_or_else(|| no_point("an edge, a rim or a place beside the axis"))
        };
        let (mine, theirs) = (at(0, &places[0], -1.0)?, at(1, &places[1], 1.0)?);
        let (small, large, axes) = principal(&(mine + theirs), &touch.normal);
        let law = match slice {
            Some(Slice { thickness, size }) => {
                LineLaw::new(large, compliance, size, thickness).map(TouchLaw::Line)
            }
            None => HertzEllipse::new(small, large, compliance).map(TouchLaw::Point),
        };
        let law = law.ok_or_else(|| {
            no_point(match slice {
                Some(_) => "surfaces that lie in each other or are flat on each other",
                None => "surfaces that touch along a line or lie in each other",
            })
        })?;
        let size = slice.map_or_else(|| self.size(), |slice| slice.size.min(self.size()));
        let axes_of_contact = law.semi_axes(law.at(-touch.gap).0);
        if axes_of_contact[0].max(axes_of_contact[1]) > LONG * size {
            return Err(no_point("a contact longer than a quarter of the smaller body"));
        }
        Ok(Curved { law, axes, bending: Some([mine, theirs]) })
    }

    /// What the change of the stiffness over the surfaces exerts; none of spheres.
    pub fn stiffness_change(
        &self,
        bodies: &[BodyState],
        touch: &Touch,
        curved: &Curved,
        semi_axes: [f64; 2],
        force: f64,
    ) -> Option<StiffnessChange> {
        let (Self::Surfaces { surfaces, slice, .. }, Some(places), Some(mut bending)) =
            (self, &touch.places, curved.bending)
        else {
            return None;
        };
        if surfaces.own.model.motion() == RigidMotion::Axial {
            return None; // on one axis nothing rolls
        }
        let [a, b] = curved.axes;
        if slice.is_some() {
            // Across their plane nothing moves, whatever the curvature there.
            bending[0] += a * a.transpose() * (bending[0].norm() + bending[1].norm());
        }
        let spread = a * a.transpose() * semi_axes[0].powi(2) + b * b.transpose() * semi_axes[1].powi(2);
        let slopes = [0, 1].map(|side| {
            let Some(surface) = surface(surfaces, side) else { return Vector3::zeros() };
            let turn = bodies[surface.body].rotation.to_rotation_matrix().into_inner();
            turn * surface.model.bending_slope(&places[side], &(turn.transpose() * spread * turn))
        });
        let share = 0.5 * curved.law.mean_square() * force;
        stiffness_change(
            &Bent { normal: touch.normal, spread, bending: &bending, slopes, axes: curved.axes },
            share,
        )
    }
}

/// The surface of the contact body (0) or of the target (1), which a plane has not.
fn surface(surfaces: &Detector, side: usize) -> Option<&BodySurface> {
    if side == 0 { Some(&surfaces.own) } else { surfaces.target.as_ref().body() }
}

/// Curvature in space of the surface of a body; `sign`: of its outward normal along the common one.
/// `None` beside the axis of an axisymmetric body, and where an edge is nearest.
fn shape_in_space(
    shape: &LocalShape,
    surface: &BodySurface,
    state: &BodyState,
    touch: &Touch,
    sign: f64,
) -> Option<Matrix3<f64>> {
    let turn = state.rotation.to_rotation_matrix().into_inner();
    if (turn * shape.normal).dot(&touch.normal) * sign < ALONG {
        return None;
    }
    if surface.model.motion() == RigidMotion::Axial {
        let arm = touch.points[0] - state.position;
        if arm.x.hypot(arm.y) > POLE * surface.model.size() {
            return None;
        }
    }
    Some(turn * shape.bending * turn.transpose())
}

/// Two unit vectors across `normal` and each other.
pub(super) fn tangents(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    // The axis farthest from the normal.
    let axis = Vector3::ith(normal.iamin(), 1.0);
    let first = normal.cross(&axis).normalize();
    [first, normal.cross(&first)]
}

/// Smaller and larger curvature of the sum `bending` in the plane across `normal`, and their
/// directions.
fn principal(bending: &Matrix3<f64>, normal: &Vector3<f64>) -> (f64, f64, [Vector3<f64>; 2]) {
    let [s, t] = tangents(normal);
    let of = |a: &Vector3<f64>, b: &Vector3<f64>| a.dot(&(bending * b));
    let (mean, along, across) =
        (0.5 * (of(&s, &s) + of(&t, &t)), 0.5 * (of(&s, &s) - of(&t, &t)), 0.5 * (of(&s, &t) + of(&t, &s)));
    let spread = along.hypot(across);
    // Direction of the smaller curvature: half the angle of minus the deviator.
    let (sine, cosine) = if spread > 0.0 { (0.5 * (-across).atan2(-along)).sin_cos() } else { (0.0, 1.0) };
    let axes = [s * cosine + t * sine, t * cosine - s * sine];
    (mean - spread, mean + spread, axes)
}
