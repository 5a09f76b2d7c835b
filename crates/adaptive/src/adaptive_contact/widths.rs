//! Widths of contact intervals by Hertz's theory: for the closing motion, or for the peak force of a preview.

use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::invariants::centre_of_mass;
use ffr_dynamics::kinematics::marker::FlexiblePoint;
use ffr_dynamics::system::force::BodyState;
use iga_core::elasticity::Model;
use nalgebra::{Matrix3, Vector3};

use contact_qs::search::SurfaceSite;

use super::{AdaptiveContact, elastic};
use crate::detection::Nearest;
use crate::error::AdaptiveError;
use crate::local_surface::SurfaceView;
use crate::model::BodyModel;
use crate::predict::{
    HertzLaw, LocalSurface, half_extents, hertz_impact, interval_width, inverse_effective_mass, line_impact,
};
use crate::preview::{HertzPoint, PointImpact};
use crate::spec::{Place, Target};

/// Width of a first interval that cannot be predicted (flat on flat), as a share of the body's size.
const BLIND_WIDTH: f64 = 0.05;

impl AdaptiveContact {
    /// Widths by Hertz's theory for the peak force `peak`, or for the closing motion in `states`.
    pub(super) fn predicted_widths(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        nearest: &Nearest,
        peak: Option<f64>,
    ) -> [f64; 2] {
        let blind = BLIND_WIDTH * elastic(&bodies[self.body]).body.size();
        self.hertz_widths(bodies, states, nearest, peak).unwrap_or([blind; 2])
    }

    fn hertz_widths(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
        nearest: &Nearest,
        peak: Option<f64>,
    ) -> Option<[f64; 2]> {
        let Partners { own, other, normal } = self.partners(bodies, states, nearest)?;
        let speed = (other.velocity - own.velocity).dot(&normal);
        let inverse_mass = own.inverse_mass + other.inverse_mass;
        let target = self.law.interval.target_utilisation;
        let body = &elastic(&bodies[self.body]).body;
        if let Model::PlaneStrain { thickness } | Model::PlaneStress { thickness } = body.spec.model {
            let curvature = own.surface.curvatures[0] + other.surface.curvatures[0];
            let compliance = own.surface.compliance + other.surface.compliance;
            let (half, _) = line_impact(curvature, compliance, inverse_mass * thickness, speed, body.size())?;
            return Some([interval_width(half, target, false); 2]);
        }
        let surfaces = [own.surface, other.surface];
        let hertz = match peak {
            Some(force) => HertzLaw::new(&surfaces)?.at_force(force),
            None => hertz_impact(&surfaces, inverse_mass, speed)?,
        };
        let [a, b] = half_extents(&hertz, &own.tangents);
        let from_axis = body.spec.model == Model::Axisymmetric;
        Some([interval_width(a, target, from_axis), interval_width(b, target, from_axis)])
    }

    fn partners(&self, bodies: &[BodyModel], states: &[BodyState], nearest: &Nearest) -> Option<Partners> {
        let own = Partner::new(self.body, bodies, states, &nearest.contact)?;
        let other = match (self.target, &nearest.target) {
            (Target::Body(other), Some(site)) => Partner::new(other, bodies, states, site)?,
            _ => Partner::fixed(&nearest.normal, &nearest.contact.point),
        };
        // The line between touching points has no direction, their surfaces have one.
        let normal = (other.outward - own.outward).try_normalize(0.0)?;
        Some(Partners { own, other, normal })
    }

    /// A point contact with Hertz's law at the nearest points in the motions `states`, for a preview of the impact; none if
    /// the width is known already, or Hertz's law does not apply.
    ///
    /// # Errors
    /// [`AdaptiveError::Contact`] if the motions are not finite.
    pub fn preview(
        &self,
        bodies: &[BodyModel],
        states: &[BodyState],
    ) -> Result<Option<PointImpact>, AdaptiveError> {
        let model = elastic(&bodies[self.body]).body.spec.model;
        let is_plane = matches!(model, Model::PlaneStrain { .. } | Model::PlaneStress { .. });
        if is_plane || self.law.interval.width.is_some() {
            return Ok(None);
        }
        let nearest = self.nearest(states)?;
        let Some(Partners { own, other, normal }) = self.partners(bodies, states, &nearest) else {
            return Ok(None);
        };
        let Some(law) = HertzLaw::new(&[own.surface, other.surface]) else { return Ok(None) };
        Ok(Some(PointImpact::new(own.point, other.point, normal, &law, states)))
    }
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
        }
    }

    fn new(index: usize, bodies: &[BodyModel], states: &[BodyState], site: &SurfaceSite) -> Option<Self> {
        let (model, state) = (&bodies[index], &states[index]);
        let body = &elastic(model).body;
        let motion = body.assembled.motion;
        let SurfaceView { surface, tangents, outward, point } =
            SurfaceView::new(&body.spec, &state.rotation, site.face, &site.xi)?;
        let data = &model.data;
        let inverse_mass = if motion == RigidMotion::Axial {
            1.0 / data.mass
        } else {
            let c = data.mass_moment / data.mass;
            let steiner = Matrix3::identity() * c.norm_squared() - c * c.transpose();
            let axes = state.rotation.to_rotation_matrix().into_inner();
            let central = axes * (data.inertia() - steiner * data.mass) * axes.transpose();
            let arm = site.point - centre_of_mass(data, state);
            inverse_effective_mass(data.mass, &central, &arm, &outward)
        };
        let point = model.point(&Place::Point(point)).ok()?;
        let velocity = point.velocity(state);
        let point = HertzPoint { body: Some(index), point };
        Some(Self { surface, inverse_mass, velocity, tangents, outward, point })
    }
}
