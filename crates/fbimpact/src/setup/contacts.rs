//! Contacts: surfaces against planes, Hertz pairs.

use adaptive::predict::DEFAULT_STIFFNESS_RATIO;
use adaptive::spec::{
    ContactLaw, ContactSpec, HertzSphere, IntervalSpec, PenaltySearch, Place as PlaceSpec, PointRule,
    SurfaceLaw, Target, Treatment, least_utilisation,
};
use contact_qs::law::Solid;
use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::broyden::BroydenSettings;
use nalgebra::Vector3;

use super::bodies::Bodies;
use crate::error::AppError;
use crate::scenario::{self, BodyKind, Geometry, RigidMass, Scenario};

/// A contact.
///
/// # Errors
/// [`AppError::Model`] naming the contact if its bodies do not fit.
pub fn contact(
    contact: &scenario::Contact,
    scenario: &Scenario,
    bodies: &Bodies,
) -> Result<ContactSpec, AppError> {
    let subject = format!("contacts.{}", contact.name);
    let target = &scenario.bodies[contact.target_body];
    let (name, body) = (contact.name.clone(), bodies.moving(contact.contact_body, &subject)?);
    let initial_overlap = contact.initial_overlap;
    let plane = match &target.kind {
        BodyKind::RigidPlane { normal, material } => {
            let target =
                Target::Plane { point: Vector3::from(target.position), normal: Vector3::from(*normal) };
            Some((target, material.as_ref()))
        }
        _ => None,
    };
    match (&contact.law, plane) {
        (scenario::ContactLaw::Surface(law), plane) => {
            let body = bodies.flexible(contact.contact_body, &subject)?;
            let target = match plane {
                Some((target, _)) => target,
                None => Target::Body(bodies.flexible(contact.target_body, &subject)?),
            };
            Ok(ContactSpec { name, body, target, law: ContactLaw::Surface(surface(law)), initial_overlap })
        }
        (scenario::ContactLaw::Hertz, plane) => {
            let sphere = |index: usize| hertz_sphere(&scenario.bodies[index], &subject);
            let other = if plane.is_some() { None } else { Some(sphere(contact.target_body)?) };
            let law = ContactLaw::Hertz {
                contact: sphere(contact.contact_body)?,
                target: other,
                plane: plane.and_then(|(_, material)| material).map_or(Solid::RIGID, solid),
            };
            let target = match plane {
                Some((target, _)) => target,
                None => Target::Body(bodies.moving(contact.target_body, &subject)?),
            };
            Ok(ContactSpec { name, body, target, law, initial_overlap })
        }
    }
}

fn surface(law: &scenario::SurfaceContact) -> SurfaceLaw {
    let (penalty, search) = match law.constraint {
        scenario::Constraint::Penalty { value, search } => (value, penalty_search(search)),
        scenario::Constraint::Exact => (Some(f64::INFINITY), PenaltySearch::Fixed),
    };
    SurfaceLaw {
        treatment: match law.model {
            scenario::ContactModel::Adaptive => Treatment::Adaptive,
            scenario::ContactModel::Quasistatic => Treatment::Quasistatic,
            scenario::ContactModel::Damped => Treatment::Damped,
            scenario::ContactModel::Dynamic => Treatment::Dynamic,
            scenario::ContactModel::Coarse => Treatment::Coarse,
        },
        penalty,
        stiffness_ratio: DEFAULT_STIFFNESS_RATIO,
        search,
        points: match law.points {
            scenario::ContactPoints::Greville => PointRule::Greville,
            scenario::ContactPoints::Gauss => PointRule::Gauss,
        },
        method: match law.solver {
            scenario::ContactSolver::ActiveSet => Method::ActiveSet,
            scenario::ContactSolver::Broyden => Method::Broyden(BroydenSettings::default()),
        },
        friction: law.friction,
        hand_over: law.hand_over,
        interval: IntervalSpec {
            width: law.interval.width,
            elements: law.interval.elements,
            target_utilisation: law.interval.target_utilisation,
            min_utilisation: least_utilisation(law.interval.target_utilisation),
            division: law.interval.division,
        },
    }
}

fn penalty_search(search: scenario::PenaltySearch) -> PenaltySearch {
    match search {
        scenario::PenaltySearch::Fixed => PenaltySearch::Fixed,
        scenario::PenaltySearch::UntilConverged { tolerance } => PenaltySearch::UntilConverged { tolerance },
        scenario::PenaltySearch::UntilError => PenaltySearch::UntilError,
    }
}

/// The sphere of a body, whose shape stands about the origin of its frame.
fn hertz_sphere(body: &scenario::Body, subject: &str) -> Result<HertzSphere, AppError> {
    let parts = match &body.kind {
        BodyKind::Elastic(elastic) => Some((&elastic.geometry, &elastic.material)),
        BodyKind::Rigid(rigid) => match &rigid.mass {
            RigidMass::Shape { geometry, material, .. } => Some((geometry, material)),
            RigidMass::Given { .. } => None,
        },
        BodyKind::RigidPlane { .. } | BodyKind::Imported(_) => None,
    };
    let Some((&Geometry::Sphere { radius, .. }, material)) = parts else {
        return Err(AppError::Model(format!("{subject}: body \"{}\" is no sphere", body.name)));
    };
    Ok(HertzSphere { centre: PlaceSpec::Point([0.0; 3]), radius, solid: solid(material) })
}

fn solid(material: &scenario::Material) -> Solid {
    Solid { young: material.youngs_modulus, poisson: material.poissons_ratio }
}
