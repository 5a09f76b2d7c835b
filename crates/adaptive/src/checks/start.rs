//! How bodies lie at the start: apart, touching, or refused (docs/theory.md part P).

use std::borrow::Cow;

use contact_qs::{Detector, Meeting, Sphere, Target};
use ffr_dynamics::force::BodyState;

use super::motion::fast_approach;
use super::resolution::{coarse_mesh, coarse_place};
use super::watch::{Shapes, WatchedPair};
use crate::error::AdaptiveError;
use crate::model::{ContactFacts, RunModel};
use crate::record::finding::Components;
use crate::record::warning::{Warning, WarningKind};
use crate::state::simulation::normal_motion;
use crate::system::body::BodyModel;
use crate::touch::detection::Search;
use crate::touch::overlap::{Overlap, Pair};

/// Checks the start of a run: warnings of overlaps that the scenario allows. `searches` are those
/// of the contacts, in their order.
///
/// # Errors
/// [`AdaptiveError::InitialOverlap`] if bodies overlap by more, [`AdaptiveError::BehindPlane`] or [`AdaptiveError::CentresCoincide`] if
/// they lie on the wrong side of each other; [`AdaptiveError::ImplausibleContact`] if they approach
/// each other faster than waves.
pub fn check(
    model: &mut RunModel,
    searches: &mut [&mut Search],
) -> Result<Vec<(usize, Warning)>, AdaptiveError> {
    let y = model.initial.clone();
    let states = model.system.body_states(0.0, &y).to_vec();
    let spins = |b: usize| Some((b, sudden_spin(model, b, &states[b])?));
    let mut warnings: Vec<(usize, Warning)> = (0..states.len()).filter_map(spins).collect();
    for (i, search) in searches.iter_mut().enumerate() {
        let (_, mut normal, motion) = normal_motion(&mut model.system, &y, i);
        let spheres = model.contacts[i].spheres.as_ref();
        let radius = |(own, other): &(Sphere, Target<Sphere>)| {
            (own.radius, other.as_ref().body().map_or(0.0, |other| other.radius))
        };
        let overlap = match spheres.map(radius) {
            Some(radii) => of_spheres(model, i, radii, (&states, &y))?,
            None => {
                let (pair, detector) = (pair(model, i), detector(model, i, search)?);
                let is_slow = detector.closing_speed_bound(&states) <= model.contacts[i].wave_speed;
                if is_slow && detector.least_gap(&states) > 0.0 {
                    None
                } else {
                    normal = pair.nearest(&detector, search, &states)?.normal;
                    pair.overlap(&detector, search, &states)?
                }
            }
        };
        let facts = &model.contacts[i];
        if let Some(error) = fast_approach(&facts.name, 0.0, -motion.along(&normal), facts.wave_speed) {
            return Err(error);
        }
        warnings.extend(
            facts.flexible_under_hertz.map(|body| (i, yields_twice(&facts.name, &model.bodies[body]))),
        );
        let Some(overlap) = overlap.filter(Overlap::is_real) else { continue };
        if overlap.depth > facts.allowed_overlap {
            return Err(pair(model, i).refused(&overlap));
        }
        warnings.push((i, allowed(&facts.name, &overlap, facts.allowed_overlap)));
    }
    Ok(warnings)
}

/// The warnings of bodies by themselves: of meshes too coarse for their modes, and for the places that
/// joints and loads hold; each with the index of its body.
pub fn of_bodies(model: &RunModel) -> Vec<(usize, Warning)> {
    let bodies = model.bodies.iter().enumerate();
    let found = bodies.flat_map(|(b, body)| {
        let known = model.known_errors.get(b).copied().flatten();
        [coarse_mesh(body, known), coarse_place(body)].into_iter().flatten().map(move |warning| (b, warning))
    });
    found.collect()
}

/// Strain `(ω a/c)²` by a spin at the start above which stress that rings with it is told; 2 MPa in
/// steel.
const STRAIN_OF_SPIN: f64 = 1e-5;

/// The warning of body `b`, in which stress is asked for and which starts undeformed in the motion
/// `state`, at a spin that strains it.
fn sudden_spin(model: &RunModel, b: usize, state: &BodyState) -> Option<Warning> {
    let (body, flexible) = (&model.bodies[b], model.bodies[b].flexible()?);
    let rate = state.angular_velocity_in_body.norm();
    let crossing = 0.5 * flexible.body.size() / flexible.body.slowest_material()?.bar_speed();
    let strain = (rate * crossing).powi(2);
    let is_undeformed = state.elastic.iter().all(|q| *q == 0.0) && !state.elastic.is_empty();
    (is_undeformed && strain > STRAIN_OF_SPIN && model.is_stress_asked(b)).then(|| Warning {
        kind: WarningKind::SuddenSpin,
        subject: format!("body \"{}\"", body.name),
        time: 0.0,
        value: strain,
        limit: STRAIN_OF_SPIN,
        message: format!(
            "it starts undeformed at {rate:.4e} rad/s, whose centrifugal force strains it by some {strain:.0e}: its stress rings between \
             none and twice that of the spin"
        ),
        remedy: "set simulation.static_start = true, or simulation.start = \"static\"".into(),
    })
}

/// The warning of the contact `name`, pressed at a start in equilibrium.
pub fn static_contact(name: &str) -> Warning {
    Warning {
        kind: WarningKind::StaticContact,
        subject: format!("contact \"{name}\""),
        time: 0.0,
        message: "its bodies touch at the start and are pressed together, and the equilibrium of simulation.static_start holds joints and \
                  does not know of the contact: the force sets in at once and rings between none and twice what it settles at"
            .into(),
        remedy: "set simulation.start = \"static\" in place of static_start, whose equilibrium has the contacts; or raise the load slowly".into(),
        ..Warning::default()
    }
}

/// The warning of an equilibrium whose least squared frequency is `squared` [1/s²], negative; `body` moves most then.
pub fn unstable(body: &str, squared: f64) -> Warning {
    let time = 1.0 / (-squared).sqrt();
    Warning {
        kind: WarningKind::Unstable,
        subject: format!("body \"{body}\""),
        time: 0.0,
        value: squared,
        limit: 0.0,
        message: format!(
            "the equilibrium that the run begins in is not stable: a small disturbance, in which this body moves most, grows by e in {time:.3e} s"
        ),
        remedy: "give a pose nearer to the stable one, or hold the body".into(),
    }
}

/// The warning of an equilibrium in which the share `residual` of all forces, above `limit`, does not balance; `body` moves most by it.
pub fn out_of_balance(body: &str, residual: f64, limit: f64) -> Warning {
    Warning {
        kind: WarningKind::OutOfBalance,
        subject: format!("body \"{body}\""),
        time: 0.0,
        value: residual,
        limit,
        message: format!(
            "{residual:.1e} of the forces do not balance in the equilibrium that the run begins in, and further steps towards it gain nothing; this body moves most by what is left"
        ),
        remedy: "hold what rolls or slides freely, or start from the motion that is meant".into(),
    }
}

/// The warning of a contact by Hertz's law whose body `body` has modes that yield at the touch,
/// too.
fn yields_twice(name: &str, body: &BodyModel) -> Warning {
    let (n_modes, body) = (body.data.n_modes(), &body.name);
    Warning {
        kind: WarningKind::YieldsTwice,
        subject: format!("contact \"{name}\""),
        time: 0.0,
        value: n_modes as f64,
        limit: 0.0,
        message: format!(
            "the {n_modes} modes of body \"{body}\" yield at the touch beside Hertz's law, which holds that already: forces come out low, by \
             some per cent for compact solid bodies with few modes, by a tenth and more for plane ones, which their band does not hold"
        ),
        remedy: format!(
            "leave contacts.{name}.model out for the contact of the flexible bodies themselves, or take body \"{body}\" as rigid where its \
             vibration does not matter"
        ),
    }
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
        remedy: format!("move the contact body by {} m to begin without", Components(overlap.shift)),
    }
}

/// What contact `i` is between.
fn pair(model: &RunModel, i: usize) -> Pair<'_> {
    let facts = &model.contacts[i];
    let body = &model.bodies[facts.body];
    Pair {
        contact: &facts.name,
        body: facts.body,
        body_name: &body.name,
        motion: body.data.motion,
        allowed: facts.allowed_overlap,
    }
}

/// The surfaces of contact `i`; `search` forgets others where they are made for the purpose.
fn detector<'a>(
    model: &'a RunModel,
    i: usize,
    search: &mut Search,
) -> Result<Cow<'a, Detector>, AdaptiveError> {
    if let Some(refinement) = &model.contacts[i].refinement {
        return Ok(Cow::Borrowed(&refinement.detector));
    }
    search.forget();
    surfaces(model, i).map(Cow::Owned)
}

/// The pairs of the contacts of `model`, to be watched apart from what makes their forces.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] if a body has no surface.
pub fn watched_pairs(model: &RunModel) -> Result<Vec<WatchedPair>, AdaptiveError> {
    let search = Search::new();
    let pair = |(i, facts): (usize, &ContactFacts)| {
        let shapes = match (&facts.refinement, &facts.spheres) {
            (Some(_), _) => Shapes::Refined,
            (None, Some((own, other))) => Shapes::Spheres(own.clone(), other.clone()),
            (None, None) => Shapes::Lasting(Box::new(surfaces(model, i)?)),
        };
        Ok(WatchedPair::new(shapes, search.of_another_pair()))
    };
    model.contacts.iter().enumerate().map(pair).collect()
}

/// The surfaces of contact `i`, made for the purpose.
///
/// # Errors
/// [`AdaptiveError::Unsupported`] if a body has none.
fn surfaces(model: &RunModel, i: usize) -> Result<Detector, AdaptiveError> {
    let facts = &model.contacts[i];
    let surface = |body: usize| {
        model.bodies[body].surface()?.ok_or_else(|| {
            let what = AdaptiveError::no_surface(&model.bodies[body].name);
            AdaptiveError::unsupported_contact(&facts.name, what)
        })
    };
    Detector::of(facts.body, facts.target, surface)
}

fn of_spheres(
    model: &mut RunModel,
    i: usize,
    (radius, other_radius): (f64, f64),
    (states, y): (&[BodyState], &[f64]),
) -> Result<Option<Overlap>, AdaptiveError> {
    let (force, motion) = model.system.force_as_placed(y, i);
    let Meeting { gap, normal, .. } = force.contact.meeting(motion);
    let facts = &model.contacts[i];
    match facts.target.body() {
        Some(other) if !gap.is_finite() || !normal.x.is_finite() => {
            let bodies = [facts.body, other].map(|body| model.bodies[body].name.clone());
            let (contact, distance) = (facts.name.clone(), radius + other_radius);
            return Err(AdaptiveError::CentresCoincide { contact, bodies, distance });
        }
        None if gap <= -2.0 * radius => {
            return Err(pair(model, i).behind_plane(-gap - 2.0 * radius, &(normal * -gap)));
        }
        _ => {}
    }
    let point = states[facts.body].position - normal * radius;
    Ok((gap < 0.0).then(|| Overlap { depth: -gap, point, shift: normal * -gap, size: radius }))
}
