//! How bodies lie at the start: apart, touching, or refused (docs/theory.md section P).

use std::borrow::Cow;

use contact_qs::Plane;
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::system::force::BodyState;
use nalgebra::{Unit, Vector3};

use super::motion::fast_approach;
use crate::detection::{Detector, DetectorTarget, Nearest, Search};
use crate::error::AdaptiveError;
use crate::model::RunModel;
use crate::simulation::normal_motion;
use crate::spec::Target;
use crate::unsupported::Unsupported;
use crate::warning::{Warning, WarningKind};

/// Overlap as a share of the bodies' size that is round-off of their places: positions of some sizes are known to 1e-16 of
/// them, and shapes to 1e-12.
pub const ROUND_OFF: f64 = 1e-9;
/// Moves in search of a place where two bodies no longer overlap.
const MOVES: usize = 50;

/// How the bodies of a contact overlap.
struct Overlap {
    depth: f64,
    /// Deepest point in space \[m\].
    point: Vector3<f64>,
    /// By what the contact body has to be moved \[m\].
    shift: Vector3<f64>,
    /// Size of the bodies \[m\].
    size: f64,
}

/// Checks the start of a run: warnings of overlaps that the scenario allows. `searches` are those of the contacts, in their order.
///
/// # Errors
/// [`AdaptiveError::InitialOverlap`] if bodies overlap by more, [`AdaptiveError::BehindPlane`] or [`AdaptiveError::CentresCoincide`] if
/// they lie on the wrong side of each other; [`AdaptiveError::Implausible`] if they approach each other faster than waves.
pub fn check(
    model: &mut RunModel,
    searches: &mut [&mut Search],
) -> Result<Vec<(usize, Warning)>, AdaptiveError> {
    let y = model.initial.clone();
    let states = model.system.body_states(0.0, &y).to_vec();
    let mut warnings = Vec::new();
    for (i, search) in searches.iter_mut().enumerate() {
        let (mut normal, motion) = normal_motion(&mut model.system, 0.0, &y, i);
        let radii = model.contacts[i].radii;
        if radii.is_none() {
            normal = Watch::new(model, i, search)?.nearest(&states)?.normal;
        }
        let overlap = match radii {
            Some(radii) => of_spheres(model, i, radii, (&states, &y))?,
            None => of_surfaces(model, i, search, &states)?,
        };
        let facts = &model.contacts[i];
        if let Some(error) = fast_approach(&facts.name, 0.0, -motion.velocity.dot(&normal), facts.wave_speed)
        {
            return Err(error);
        }
        let Some(overlap) = overlap.filter(|o| o.depth > ROUND_OFF * o.size) else { continue };
        if overlap.depth > facts.allowed_overlap {
            return Err(refused(model, i, &overlap));
        }
        warnings.push((i, allowed(&facts.name, &overlap, facts.allowed_overlap)));
    }
    Ok(warnings)
}

fn allowed(name: &str, overlap: &Overlap, limit: f64) -> Warning {
    Warning {
        kind: WarningKind::InitialOverlap,
        subject: format!("contact \"{name}\""),
        time: 0.0,
        value: overlap.depth,
        limit,
        message: format!(
            "the bodies overlap by {:.3e} m at the start, which contacts.{name}.initial_overlap allows; the contact begins with the \
             energy of that overlap",
            overlap.depth
        ),
        remedy: format!("move the contact body by {} m to begin without", list(&overlap.shift)),
    }
}

fn refused(model: &RunModel, i: usize, overlap: &Overlap) -> AdaptiveError {
    let facts = &model.contacts[i];
    AdaptiveError::InitialOverlap {
        contact: facts.name.clone(),
        body: model.bodies[facts.body].name.clone(),
        depth: overlap.depth,
        place: list(&overlap.point),
        shift: list(&overlap.shift),
        allowed: facts.allowed_overlap,
    }
}

/// Components in brackets, to the digits that change something; zeros without sign.
fn list(v: &Vector3<f64>) -> String {
    let size = v.norm();
    let shown = |x: f64| if x.abs() <= 1e-9 * size { "0".to_owned() } else { format!("{x:.9e}") };
    format!("[{}, {}, {}]", shown(v.x), shown(v.y), shown(v.z))
}

/// The body of contact `i`, whose nearest point is `distance` behind the plane and comes out by `shift`.
fn behind_plane(model: &RunModel, i: usize, distance: f64, shift: &Vector3<f64>) -> AdaptiveError {
    let facts = &model.contacts[i];
    let (contact, body) = (facts.name.clone(), model.bodies[facts.body].name.clone());
    AdaptiveError::BehindPlane { contact, body, distance, shift: list(shift) }
}

/// A pair of surfaces and the search between them.
struct Watch<'a> {
    contact: &'a str,
    detector: Cow<'a, Detector>,
    search: &'a mut Search,
}

impl<'a> Watch<'a> {
    /// The surfaces of contact `i`.
    fn new(model: &'a RunModel, i: usize, search: &'a mut Search) -> Result<Self, AdaptiveError> {
        let facts = &model.contacts[i];
        if let Some(refinement) = &facts.refinement {
            let detector = Cow::Borrowed(&refinement.detector);
            return Ok(Self { contact: &facts.name, detector, search });
        }
        let surface = |body: usize| {
            model.bodies[body].surface()?.ok_or_else(|| {
                let what = Unsupported::NoSurface { body: model.bodies[body].name.clone() };
                AdaptiveError::unsupported_contact(&facts.name, what)
            })
        };
        let target = match facts.target {
            Target::Plane { point, normal } => {
                DetectorTarget::Plane(Plane { point, normal: Unit::new_normalize(normal) })
            }
            Target::Body(other) => DetectorTarget::Body(other, surface(other)?),
        };
        Ok(Self::of(&facts.name, Detector::new(facts.body, surface(facts.body)?, target), search))
    }

    /// Surfaces of a detector made for the purpose.
    fn of(contact: &'a str, detector: Detector, search: &'a mut Search) -> Self {
        // What it remembers belongs to other surfaces.
        search.forget();
        Self { contact, detector: Cow::Owned(detector), search }
    }

    fn nearest(&mut self, states: &[BodyState]) -> Result<Nearest, AdaptiveError> {
        let nearest = self.detector.nearest(states, self.search);
        nearest.map_err(|source| AdaptiveError::Contact { contact: self.contact.to_owned(), source })
    }
}

fn of_surfaces(
    model: &RunModel,
    i: usize,
    search: &mut Search,
    states: &[BodyState],
) -> Result<Option<Overlap>, AdaptiveError> {
    let facts = &model.contacts[i];
    let mut watch = Watch::new(model, i, search)?;
    let first = watch.nearest(states)?;
    let size = watch.detector.size();
    if first.gap >= -ROUND_OFF * size {
        return Ok(None);
    }
    if let (Target::Plane { point, normal }, Some(flexible)) =
        (facts.target, model.bodies[facts.body].flexible())
    {
        let back = DetectorTarget::Plane(Plane { point, normal: Unit::new_normalize(-normal) });
        let behind = Detector::new(facts.body, flexible.surface()?, back);
        let farthest = Watch::of(&facts.name, behind, &mut Search::new()).nearest(states)?.gap;
        if farthest >= 0.0 {
            return Err(behind_plane(model, i, farthest, &(first.normal * -first.gap)));
        }
    }
    // The deepest point leaves the other body first; others may follow.
    let (mut moved, mut shift) = (states.to_vec(), Vector3::zeros());
    let mut gap = first.gap;
    let (along, gain) = way_out(model, facts.body, &first.normal);
    for _ in 0..MOVES {
        if gap >= -0.5 * ROUND_OFF * size {
            break;
        }
        shift -= along * (gap / gain);
        moved[facts.body].position = states[facts.body].position + shift;
        gap = watch.nearest(&moved)?.gap;
    }
    Ok(Some(Overlap { depth: -first.gap, point: first.contact.point, shift, size }))
}

/// Direction in which a body can be moved along `normal`, and how much of a move that way counts.
fn way_out(model: &RunModel, body: usize, normal: &Vector3<f64>) -> (Vector3<f64>, f64) {
    /// Cosine below which a move hardly helps; the places found then tell how much more is needed.
    const LEAST: f64 = 0.2;
    let mut free = *normal;
    match model.bodies[body].data.motion {
        RigidMotion::Axial => (free.x, free.y) = (0.0, 0.0),
        RigidMotion::Planar => free.z = 0.0,
        RigidMotion::Spatial => {}
    }
    let along = free.try_normalize(1e-6).unwrap_or_else(|| match model.bodies[body].data.motion {
        RigidMotion::Axial => Vector3::z(),
        _ => Vector3::x(),
    });
    (along, along.dot(normal).max(LEAST))
}

fn of_spheres(
    model: &mut RunModel,
    i: usize,
    radii: [f64; 2],
    (states, y): (&[BodyState], &[f64]),
) -> Result<Option<Overlap>, AdaptiveError> {
    let (force, motion) = model.system.force_in_motion(0.0, y, i);
    let (gap, normal) = (force.contact.smallest_gap(motion), force.contact.normal(motion));
    let facts = &model.contacts[i];
    match facts.target {
        Target::Body(other) if !gap.is_finite() || !normal.x.is_finite() => {
            let bodies = [facts.body, other].map(|body| model.bodies[body].name.clone());
            let (contact, distance) = (facts.name.clone(), radii[0] + radii[1]);
            return Err(AdaptiveError::CentresCoincide { contact, bodies, distance });
        }
        Target::Plane { .. } if gap <= -2.0 * radii[0] => {
            return Err(behind_plane(model, i, -gap - 2.0 * radii[0], &(normal * -gap)));
        }
        _ => {}
    }
    let point = states[facts.body].position - normal * radii[0];
    Ok((gap < 0.0).then(|| Overlap { depth: -gap, point, shift: normal * -gap, size: radii[0] }))
}
