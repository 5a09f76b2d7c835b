//! Contacts: pairs of bodies that exist, and settings that go together.

pub(super) mod facts;
mod checks;

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use adaptive::adaptivity::interval::least_utilisation;
use adaptive::spec::{
    Accuracy, ContactLaw, ContactSpec, HertzPartner, HertzSpec, HertzSphere, IntervalSpec, PenaltySearch,
    Place, PointRule, SurfaceLaw, Target, TransferSpec, Treatment,
};
use contact_qs::law::penalty::DEFAULT_STIFFNESS_RATIO;
use contact_qs::law::{Friction, Solid};
use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::broyden::BroydenSettings;
use ffr_dynamics::body::RigidMotion;

use super::super::section::Section;
use super::super::tables::{BodyModel, Search, ShapeName, Solver};
use super::accuracy::{accuracy, peak_tolerance};
use super::bodies::parts::{solid, yield_strength};
use super::built_bodies::BuiltBodies;
use super::places::{BodyFacts, body_index};
use checks::{check_bodies, check_hertz, check_settings};
use facts::ContactFacts;

/// All contacts; `None` if one of them, or one of its bodies, is at fault.
pub fn contacts(root: &Section, bodies: &BuiltBodies) -> Option<Vec<ContactSpec>> {
    let list = root.named("contacts");
    let mut pairs: HashMap<[usize; 2], &str> = HashMap::with_capacity(list.len());
    let mut built = Vec::with_capacity(list.len());
    for (name, section) in list {
        let Some((pair, law)) = contact(root, section) else { continue };
        let sorted = [pair[0].min(pair[1]), pair[0].max(pair[1])];
        match pairs.entry(sorted) {
            Entry::Occupied(same) => {
                let message = format!("contact \"{}\" has the same pair of bodies already", same.get());
                section.fault("contact_body", message);
            }
            Entry::Vacant(place) => _ = place.insert(name),
        }
        let spec = bodies.index(pair[0]).zip(target(bodies, pair[1])).zip(law);
        built.extend(spec.map(|((body, target), law)| ContactSpec {
            name: name.to_owned(),
            body,
            target,
            law,
            damping: section.number("damping").unwrap_or_default(),
            initial_overlap: section.number("initial_overlap").unwrap_or_default(),
        }));
    }
    if built.len() < list.len() {
        return None;
    }
    check_interface_modes(root, bodies, &built);
    Some(built)
}

/// Faults numbers of fixed-interface modes of bodies that have no interface: contacts that the
/// program refines, and coarse ones, need none.
fn check_interface_modes(root: &Section, bodies: &BuiltBodies, contacts: &[ContactSpec]) {
    let has_interface = |contact: &ContactSpec| {
        contact.law.surface().is_some_and(|law| law.treatment.interface_modes().is_some())
    };
    for (i, (_, section)) in root.named("bodies").iter().enumerate() {
        let reduction = section.table("reduction").filter(|table| table.given("fixed_interface_modes"));
        let (Some(reduction), Some(body)) = (reduction, bodies.index(i)) else { continue };
        if !contacts.iter().any(|contact| contact.acts_on(body) && has_interface(contact)) {
            let message = "nothing depends on it: only contacts of the models \"quasistatic\", \"massless\", \"damped\" and \"dynamic\" \
                 have an interface, and none of them is on this body; leave it out";
            reduction.fault("fixed_interface_modes", message);
        }
    }
}

/// What body `body` of the file is as a target.
fn target(bodies: &BuiltBodies, body: usize) -> Option<Target> {
    if let Some(plane) = bodies.plane(body) {
        return Some(Target::Plane(*plane));
    }
    bodies.index(body).map(Target::Body)
}

/// Contact and target body of the file, and the law, if the bodies can obey it.
fn contact(root: &Section, section: &Section) -> Option<([usize; 2], Option<ContactLaw>)> {
    let contact_body = body_index(root, section, "contact_body");
    let target_body = body_index(root, section, "target_body");
    if contact_body.is_some() && contact_body == target_body {
        let message = "must differ from contact_body, a body does not touch itself";
        return section.refuse("target_body", message);
    }
    let facts = ContactFacts::of(root, section)?;
    let law = match facts.model.treatment() {
        None => {
            check_hertz(root, section);
            hertz(root, section)
        }
        Some(treatment) => {
            check_bodies(root, section);
            check_settings(section, &facts);
            Some(ContactLaw::Surface(surface(root, section, (treatment, &facts))?))
        }
    };
    Some(([contact_body?, target_body?], law))
}

/// Hertz's law between the bodies of a contact; `None` if something of them is at fault.
fn hertz(root: &Section, section: &Section) -> Option<ContactLaw> {
    let body = |key| section.text(key).and_then(|name| BodyFacts::find(root, name));
    let (contact, target) = (body("contact_body")?, body("target_body")?);
    let yield_strength = [&contact, &target]
        .map(|body| yield_strength(root, body.section))
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    let target = if target.is_plane() {
        let solid = solid(root, target.section).unwrap_or(Solid::RIGID);
        HertzPartner { solid, sphere: None, thickness: None }
    } else {
        partner(root, &target)?
    };
    let (contact, friction) = (partner(root, &contact)?, section.number("friction")?);
    Some(ContactLaw::Hertz(HertzSpec { contact, target, friction, yield_strength }))
}

/// What touches of a body with a shape, which stands about the origin of its frame if it is a
/// sphere.
fn partner(root: &Section, body: &BodyFacts<'_>) -> Option<HertzPartner> {
    let solid = solid(root, body.section)?;
    if body.motion() == RigidMotion::Planar {
        let is_stress = body.components == BodyModel::PlaneStress;
        let solid = if is_stress { solid.of_plane_stress() } else { solid };
        return Some(HertzPartner { solid, sphere: None, thickness: body.section.number("thickness") });
    }
    let is_sphere = body.shape == Some(ShapeName::Sphere) && body.components == BodyModel::Solid;
    let sphere = if is_sphere {
        let radius = body.section.table("geometry")?.number("radius")?;
        Some(HertzSphere { centre: Place::Point([0.0; 3]), radius })
    } else {
        None
    };
    Some(HertzPartner { solid, sphere, thickness: None })
}

fn surface(
    root: &Section,
    section: &Section,
    (treatment, facts): (Treatment, &ContactFacts),
) -> Option<SurfaceLaw> {
    let accuracy = accuracy(root);
    let coefficient = section.number("friction")?;
    let (penalty, search) = penalty(root, section, facts)?;
    Some(SurfaceLaw {
        treatment,
        penalty,
        stiffness_ratio: DEFAULT_STIFFNESS_RATIO * accuracy.stiffness(),
        search,
        points: if facts.has_mesh { PointRule::Gauss } else { section.choice("points")? },
        method: match section.choice("solver")? {
            Solver::Broyden => Method::Broyden(BroydenSettings::default()),
            Solver::ActiveSet => Method::ActiveSet,
        },
        friction: (coefficient > 0.0).then(|| Friction::new(coefficient)),
        interval: interval(section.table("interval")?, accuracy)?,
        transfer: TransferSpec { modes: section.choice("modes")?, method: section.choice("transfer")? },
    })
}

fn interval(section: &Section, accuracy: Accuracy) -> Option<IntervalSpec> {
    let target_utilisation = section.number("target_utilisation")?;
    Some(IntervalSpec {
        width: section.number("width"),
        elements: section.integer("elements"),
        target_utilisation,
        min_utilisation: least_utilisation(target_utilisation),
        division: section.choice("division")?,
        accuracy,
    })
}

/// The penalty factor, infinite for the exact constraint, and how it is found.
fn penalty(root: &Section, section: &Section, facts: &ContactFacts) -> Option<(Option<f64>, PenaltySearch)> {
    if facts.is_exact {
        return Some((Some(f64::INFINITY), PenaltySearch::Fixed));
    }
    let penalty = section.table("penalty")?;
    let value = if penalty.given("initial") { Some(penalty.number("initial")?) } else { None };
    let search = match facts.search? {
        Search::UntilConverged => PenaltySearch::UntilConverged { tolerance: peak_tolerance(root, penalty) },
        Search::UntilError => PenaltySearch::UntilError,
        Search::Fixed => PenaltySearch::Fixed,
    };
    Some((value, search))
}
