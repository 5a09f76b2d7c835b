//! Widths of contact intervals by Hertz's theory: for the closing motion, or for the peak force of
//! a preview.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::system::free_body::invariants::centre_of_mass;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use contact_qs::law::Solid;
use contact_qs::search::SurfaceSite;
use contact_qs::{ContactError, HertzContact};
use iga_core::elasticity::Model;

use super::{AdaptiveContact, WIDEST, flexible};
use crate::body::fine::refined::ELEMENTS;
use crate::error::AdaptiveError;
use crate::spec::Place;
use crate::system::body::{BodyModel, FlexibleModel};
use crate::touch::detection::{Nearest, Search};
use crate::touch::hertz::local_surface::{SurfaceView, plane_compliance};
use crate::touch::hertz::preview::{HertzPoint, StandIn};
use crate::touch::hertz::{
    HertzLaw, HertzPrediction, ImpactLaw, LineLaw, LocalSurface, StraightLine, half_extents, hertz_impact,
    interval_width, inverse_effective_mass, widths_along,
};
use crate::touch::parts::Touch;

/// Width of a first interval that cannot be predicted (flat on flat), as a share of the body's
/// size.
const BLIND_WIDTH: f64 = 0.05;
/// Part of the extent of a face by which its middle may miss half of it where the face begins at the axis.
const FROM_AXIS: f64 = 1e-6;
/// Least approach of two bodies that places on them can tell, in units of the round-off of their
/// size.
const LEAST_APPROACH: f64 = 64.0 * f64::EPSILON;
/// Least width across a line of contact, as a share of the body's size, for bodies that hardly
/// approach each other.
const LEAST_ACROSS: f64 = 1e-6;

impl AdaptiveContact {
    /// Widths by Hertz's theory for the peak force `peak`, or for the closing motion in `states`,
    /// and the least that they are to be: those of the smallest approach that round-off lets the
    /// bodies see.
    pub(super) fn predicted_widths(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        nearest: &Nearest,
        peak: Option<f64>,
    ) -> PredictedWidths {
        let blind = BLIND_WIDTH * flexible(&bodies[self.body]).body.size();
        let known = self.partners(bodies, states, nearest).and_then(|p| self.hertz_widths(bodies, &p, peak));
        known.unwrap_or(PredictedWidths { widths: [blind; 2], least: [0.0; 2], across: None })
    }

    /// The line along which smooth faces touch in the motions `states`: its direction in space, and half of the width of the contact
    /// along it at the force `peak`, or for the closing motion \[m\]; none of other touches.
    pub(super) fn line_of_touch(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        nearest: &Nearest,
        peak: Option<f64>,
    ) -> Option<(Vector3<f64>, f64)> {
        let Partners { own, other, normal } = self.partners(bodies, states, nearest)?;
        let (speed, inverse_mass) =
            ((other.velocity - own.velocity).dot(&normal), own.inverse_mass + other.inverse_mass);
        // The preview of a line that is not quite straight is one of a long ellipse.
        let exact = self.straight_line(bodies, [&own, &other], |_| 0.0);
        let peak = peak.filter(|_| exact.is_some());
        let half = |law: &LineLaw| half_width(law, peak, inverse_mass, speed);
        let line = exact.or_else(|| self.straight_line(bodies, [&own, &other], half))?;
        let half = half(&line.law);
        Some((own.outward.cross(&line.across).try_normalize(0.0)?, half))
    }

    /// Widths of a zone about the flat face of the target that touches as `touch` says, such that its rim lies in the
    /// midst between points of the zone, which then have the area of the face (Eq. C.102).
    pub(super) fn widths_about(&self, bodies: &[BodyModel], touch: &Touch) -> PredictedWidths {
        let (given, body) = (&self.law.interval, &flexible(&bodies[self.body]).body);
        let elements = given.elements_or(ELEMENTS);
        let is_odd = body.longest_elements().first().is_some_and(|element| element.degree % 2 == 1);
        let most = (given.target_utilisation * elements as f64).floor().max(1.0);
        // Points stand on the ends of elements if the degree is odd, else in their middles.
        let first = if (elements % 2 == 0) == is_odd { 1.0 } else { 2.0 };
        let about_middle = first + 2.0 * (0.5 * (most - first)).round().max(0.0);
        let from_axis = if is_odd { most + 0.5 } else { most };
        let widths = touch.extents.map(|extent| {
            // Half of the extent away from the axis lies its middle.
            let is_from_axis = body.motion() == RigidMotion::Axial
                && touch.nearest.contact.point.x <= 0.5 * extent * (1.0 + FROM_AXIS);
            extent * elements as f64 / if is_from_axis { from_axis } else { about_middle }
        });
        PredictedWidths { widths, least: [0.0; 2], across: None }
    }

    fn hertz_widths(
        &self,
        bodies: &[BodyModel],
        Partners { own, other, normal }: &Partners,
        peak: Option<f64>,
    ) -> Option<PredictedWidths> {
        let speed = (other.velocity - own.velocity).dot(normal);
        let inverse_mass = own.inverse_mass + other.inverse_mass;
        let target = self.law.interval.target_utilisation;
        let body = flexible(&bodies[self.body]);
        let approach = LEAST_APPROACH * self.detector.size();
        if let Some(line) = self.straight_line(bodies, [own, other], |_| 0.0) {
            // Along it as far as the bodies go.
            let half = half_width(&line.law, peak, inverse_mass, speed);
            let across = interval_width(half, target, false).max(LEAST_ACROSS * body.body.size());
            let least = interval_width(
                line.law.half_width(ImpactLaw::Line(line.law).force(approach).0),
                target,
                false,
            );
            let tangents = directions(body, (&own.surface, &own.outward), own.tangents, Some(&line.across));
            let of = |across: f64, along: f64| {
                tangents.map(|tangent| if line.is_across(&tangent) { across } else { along })
            };
            let widths = of(across.max(least), WIDEST * body.body.size());
            return Some(PredictedWidths { widths, least: of(least, 0.0), across: Some(line.across) });
        }
        let law = self.impact_law(bodies, own, other)?;
        let (extents, least, from_axis) = match law {
            ImpactLaw::Line(law) => {
                let half = half_width(&law, peak, inverse_mass, speed);
                ([half; 2], [law.half_width(ImpactLaw::Line(law).force(approach).0); 2], false)
            }
            ImpactLaw::Point(law) => {
                let surfaces = [own.surface, other.surface];
                let hertz = match peak {
                    Some(force) => Some(law.at_force(force)),
                    None => hertz_impact(&surfaces, inverse_mass, speed),
                };
                let extents = |h: &HertzPrediction| half_extents(h, &own.tangents);
                let least = extents(&law.at_force(ImpactLaw::Point(law).force(approach).0));
                let from_axis = body.motion() == RigidMotion::Axial;
                (hertz.map_or([0.0; 2], |h| extents(&h)), least, from_axis)
            }
        };
        let least = least.map(|half| interval_width(half, target, from_axis));
        let predicted = extents.map(|half| interval_width(half, target, from_axis));
        let widths = std::array::from_fn(|d| predicted[d].max(least[d]));
        Some(PredictedWidths { widths, least, across: None })
    }

    /// Widths of the interval on the body `other` at `there`, whose face has directions of its own,
    /// for an interval of the `widths` given about `here` on the contact body, of a line with the direction across it \[m\].
    pub(super) fn target_widths(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        (here, across): (&SurfaceSite, Option<&Vector3<f64>>),
        widths: [f64; 2],
        (other, there): (usize, &SurfaceSite),
    ) -> [f64; 2] {
        let tangents = |body: usize, site: &SurfaceSite| {
            let body_model = flexible(&bodies[body]);
            let view = view(&bodies[body], &states[body], site)?;
            let tangents = directions(body_model, (&view.surface, &view.outward), view.tangents, across);
            (body_model.motion() == RigidMotion::Spatial).then_some(tangents)
        };
        match (tangents(self.body, here), tangents(other, there)) {
            (Some(own), Some(target)) => widths_along(widths, &own, &target),
            // Bodies of one direction along their surface.
            _ => widths,
        }
    }

    /// The law by which two bodies press each other; none for surfaces that are flat on each other.
    fn impact_law(&self, bodies: &[BodyModel], own: &Partner, other: &Partner) -> Option<ImpactLaw> {
        let body = flexible(&bodies[self.body]);
        let thickness = |of: &FlexibleModel| of.body.model().thickness();
        let surfaces = [own.surface, other.surface];
        let Some(own_thickness) = thickness(body) else {
            let line = || Some(ImpactLaw::Line(self.straight_line(bodies, [own, other], |_| 0.0)?.law));
            return HertzLaw::new(&surfaces).map(ImpactLaw::Point).or_else(line);
        };
        let curvature = own.surface.in_plane() + other.surface.in_plane();
        // A thin target yields more under the same force.
        let of_target = self.target.body().and_then(|target| bodies[target].flexible().and_then(thickness));
        let share = own_thickness / of_target.unwrap_or(own_thickness);
        let compliance = own.surface.compliance + share * other.surface.compliance;
        LineLaw::new(curvature, compliance, body.body.size(), own_thickness).map(ImpactLaw::Line)
    }

    /// The line along which two bodies without a thickness touch, as long as the shorter of them in its direction; none of other touches.
    /// `half_width` as [`StraightLine::new`] asks for it.
    fn straight_line(
        &self,
        bodies: &[BodyModel],
        [own, other]: [&Partner; 2],
        half_width: impl Fn(&LineLaw) -> f64,
    ) -> Option<StraightLine> {
        let body = &flexible(&bodies[self.body]).body;
        let of_length = |length: f64| {
            let line = StraightLine::new(&[own.surface, other.surface], (body.size(), length), &half_width);
            line.filter(|_| body.model().thickness().is_none())
        };
        let along = own.outward.cross(&of_length(body.size())?.across);
        let extent = |partner: &Partner| {
            let (index, rotation) = (partner.point.body?, partner.rotation);
            Some(bodies[index].undeformed()?.extent_along(&rotation.inverse_transform_vector(&along)))
        };
        of_length([own, other].into_iter().filter_map(extent).fold(body.size(), f64::min))
    }

    fn partners(&self, bodies: &[BodyModel], states: &[BodyState], nearest: &Nearest) -> Option<Partners> {
        let own = Partner::new(self.body, bodies, states, &nearest.contact)?;
        let other = match (self.target.body(), &nearest.target) {
            (Some(other), Some(site)) => Partner::new(other, bodies, states, site)?,
            _ => Partner::fixed(&nearest.normal, &nearest.contact.point),
        };
        // The line between touching points has no direction, their surfaces have one.
        let normal = (other.outward - own.outward).try_normalize(0.0)?;
        Some(Partners { own, other, normal })
    }

    /// Hertz's law of the pair wherever its surfaces are nearest, with the friction of the contact; rigid bodies do not yield. None of meshes, whose
    /// sides have no curvature of their own.
    ///
    /// # Errors
    /// [`ContactError`] if there is none.
    pub fn by_law(&self, bodies: &[BodyModel]) -> Result<Option<HertzContact>, ContactError> {
        let pair = [Some(self.body), self.target.body()].map(|body| bodies[body?].flexible());
        if pair.iter().flatten().any(|flexible| flexible.body.mesh().is_some()) {
            return Ok(None);
        }
        let solids = pair.map(|flexible| {
            let Some(material) = flexible.and_then(|of| of.body.slowest_material()) else {
                return Solid::RIGID;
            };
            let solid = Solid { young: material.youngs_modulus(), poisson: material.poissons_ratio() };
            match flexible.map(|of| of.body.model()) {
                Some(Model::PlaneStress { .. }) => solid.of_plane_stress(),
                _ => solid,
            }
        });
        let thicknesses = pair.map(|flexible| flexible.and_then(|of| of.body.model().thickness()));
        let surfaces = self.detector.clone();
        let law = match thicknesses {
            [None, None] => HertzContact::of_surfaces(surfaces, solids),
            thicknesses => HertzContact::of_plane_surfaces(surfaces, solids, thicknesses),
        };
        law?.with_friction(self.law.friction.as_ref().map_or(0.0, |friction| friction.coefficient)).map(Some)
    }

    /// A point contact with the law of the pair at the nearest points in the motions `states`, for
    /// a preview of the impact, closed as soon as they approach if it is touching and else when
    /// they meet; none if the width is known already, or an edge or flat faces touch.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if the motions are not finite, [`AdaptiveError::ContactModel`] if no contact point sees the touch.
    pub fn preview(
        &self,
        (bodies, is_touching): (&[BodyModel], bool),
        states: &[BodyState],
        search: &mut Search,
    ) -> Result<Option<StandIn>, AdaptiveError> {
        if self.law.interval.width.is_some() {
            return Ok(None);
        }
        let touch = self.touch(bodies, states, search)?;
        let nearest = touch.nearest;
        if self.whole_at(&touch, None)?.is_some() {
            return Ok(None);
        }
        let Some(Partners { own, other, normal }) = self.partners(bodies, states, &nearest) else {
            return Ok(None);
        };
        let Some(law) = self.impact_law(bodies, &own, &other) else { return Ok(None) };
        let gap = if is_touching { 0.0 } else { nearest.gap.max(0.0) };
        Ok(Some(StandIn::preview(own.point, other.point, normal, law, states, gap)))
    }
}

/// The surface of `body` at `site`; none where it has no curvatures.
fn view(body: &BodyModel, state: &BodyState, site: &SurfaceSite) -> Option<SurfaceView> {
    let material = body.flexible().and_then(|flexible| flexible.body.slowest_material());
    let (surface, compliance) = (body.undeformed()?, material.map_or(0.0, plane_compliance));
    SurfaceView::new(surface, compliance, &state.rotation, &surface.place(site.face, &site.xi))
}

/// Directions along the `surface` of `body` with the outward normal given, for a touch along a line: of a mesh that is curved alike in all
/// directions that across it and the line, of others `tangents` (see [`LocalShape::turned`](crate::surface::LocalShape::turned)).
fn directions(
    body: &FlexibleModel,
    (surface, outward): (&LocalSurface, &Vector3<f64>),
    tangents: [Vector3<f64>; 2],
    across: Option<&Vector3<f64>>,
) -> [Vector3<f64>; 2] {
    let [first, second] = surface.curvatures;
    let has_none = body.body.mesh().is_some() && (first - second).abs() <= 0.0;
    across.filter(|_| has_none).map_or(tangents, |across| [*across, outward.cross(across)])
}

/// Widths of a first interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PredictedWidths {
    /// Predicted \[m\].
    pub widths: [f64; 2],
    /// Least widths: in narrower intervals round-off decides which points touch; zero if they are
    /// not known \[m\].
    pub least: [f64; 2],
    /// Direction across a line, in space; none of other touches.
    pub across: Option<Vector3<f64>>,
}

/// Half of the width of a line contact at the force `peak`, or for bodies that close with `speed` \[m\].
fn half_width(law: &LineLaw, peak: Option<f64>, inverse_mass: f64, speed: f64) -> f64 {
    peak.map_or_else(|| law.half_width_of_impact(inverse_mass, speed), |force| law.half_width(force))
}

/// Both partners of an impact, and the normal from the target to the contact body.
struct Partners {
    own: Partner,
    other: Partner,
    normal: Vector3<f64>,
}

/// One partner of an impact as Hertz sees it.
struct Partner {
    surface: LocalSurface,
    inverse_mass: f64,
    velocity: Vector3<f64>,
    tangents: [Vector3<f64>; 2],
    /// Outward unit normal in the inertial frame.
    outward: Vector3<f64>,
    /// The material point.
    point: HertzPoint,
    /// Rotation of its frame.
    rotation: UnitQuaternion<f64>,
}

impl Partner {
    fn fixed(normal: &Vector3<f64>, point: &Vector3<f64>) -> Self {
        Self {
            surface: LocalSurface::plane(0.0),
            inverse_mass: 0.0,
            velocity: Vector3::zeros(),
            tangents: [Vector3::zeros(); 2],
            outward: *normal,
            point: HertzPoint { body: None, point: FlexiblePoint::rigid(*point) },
            rotation: UnitQuaternion::identity(),
        }
    }

    fn new(index: usize, bodies: &[BodyModel], states: &[BodyState], site: &SurfaceSite) -> Option<Self> {
        let (model, state) = (&bodies[index], &states[index]);
        let SurfaceView { surface, tangents, outward, point } = view(model, state, site)?;
        let data = &model.data;
        let c = data.mass_moment / data.mass;
        let steiner = Matrix3::identity() * c.norm_squared() - c * c.transpose();
        let axes = state.rotation.to_rotation_matrix().into_inner();
        let central = axes * (data.inertia() - steiner * data.mass) * axes.transpose();
        let arm = site.point - centre_of_mass(data, state);
        let inverse_mass = inverse_effective_mass(data.motion, data.mass, &central, &arm, &outward);
        let point = model.point(&Place::Point(point)).ok()?;
        let velocity = point.velocity(state);
        let point = HertzPoint { body: Some(index), point };
        let rotation = state.rotation;
        Some(Self { surface, inverse_mass, velocity, tangents, outward, point, rotation })
    }
}
