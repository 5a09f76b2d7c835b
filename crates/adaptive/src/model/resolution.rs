//! Factors on the resolution of a run, applied to its specification; which bodies and contacts they
//! act on.

use std::borrow::Cow;

use super::plan::{ContactPlan, plans};
use crate::body::fine::refined::ELEMENTS;
use crate::body::zone::at_start::is_about;
use crate::error::AdaptiveError;
use crate::spec::{
    BodyKind, BodySpec, ContactLaw, ContactSpec, PenaltySearch, ReductionSpec, RefinementSpec, RunSpec,
    SurfaceLaw, Treatment,
};
use crate::system::start;
use crate::touch::first::FirstTouches;

/// Names of the bodies and contacts that the factors of a [`crate::spec::Resolution`] act on.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Subjects {
    /// Bodies of which modes are kept.
    pub modes: Vec<String>,
    /// Bodies with a mesh.
    pub mesh: Vec<String>,
    /// Contacts with a zone of small elements.
    pub zone: Vec<String>,
    /// Contacts with a penalty factor that is not found as the highest possible.
    pub penalty: Vec<String>,
}

/// The bodies and contacts of `spec` that factors act on.
///
/// # Errors
/// [`AdaptiveError`] as a run, if motions at the start or places of contact cannot be found.
pub fn subjects(spec: &RunSpec) -> Result<Subjects, AdaptiveError> {
    let poses = start::poses(spec)?;
    let plans = plans(&FirstTouches::new(spec, &poses))?;
    let bodies = |wanted: fn(&BodyKind) -> bool| {
        let named = spec.bodies.iter().filter(move |b| wanted(&b.kind));
        named.map(|b| b.name.clone()).collect()
    };
    let contacts = |wanted: &dyn Fn(usize, &SurfaceLaw) -> bool| {
        let named = spec.contacts.iter().enumerate();
        let named = named.filter(|(i, c)| c.law.surface().is_some_and(|law| wanted(*i, law)));
        named.map(|(_, c)| c.name.clone()).collect()
    };
    Ok(Subjects {
        modes: bodies(has_modes),
        mesh: bodies(|kind| kind.elastic().is_some()),
        zone: contacts(&|i, law| has_zone(spec, &plans, i, law)),
        penalty: contacts(&|_, law| has_penalty(law)),
    })
}

fn has_modes(kind: &BodyKind) -> bool {
    kind.flexible().is_some_and(|flexible| flexible.reduction != ReductionSpec::All)
}

fn has_zone(spec: &RunSpec, plans: &[ContactPlan], contact: usize, law: &SurfaceLaw) -> bool {
    let in_body = |(body, spec_of): (usize, &BodySpec)| {
        let refinements = spec_of.elastic().map_or(&[][..], |e| &e.discretisation.refine);
        refinements.iter().any(|r| is_zone_of(&spec.contacts[contact], &plans[contact], body, r))
    };
    let is_given = law.interval.elements.is_some() || plans[contact] == ContactPlan::AtTouch;
    law.treatment != Treatment::Coarse && (is_given || spec.bodies.iter().enumerate().any(in_body))
}

fn has_penalty(law: &SurfaceLaw) -> bool {
    law.search != PenaltySearch::UntilError && law.penalty.is_none_or(f64::is_finite)
}

/// Whether a contact whose law names no elements has its zone in `refinement` of body `body`.
fn is_zone_of(contact: &ContactSpec, plan: &ContactPlan, body: usize, refinement: &RefinementSpec) -> bool {
    let (ContactPlan::FromStart(sites), Some(law)) = (plan, contact.law.surface()) else { return false };
    if law.treatment == Treatment::Coarse || law.interval.elements.is_some() {
        return false;
    }
    sites.on(contact, body).any(|site| is_about(refinement, &site.point))
}

/// `spec` with its factors applied.
pub fn refined<'a>(spec: &'a RunSpec, plans: &[ContactPlan]) -> Cow<'a, RunSpec> {
    if spec.resolution.is_identity() {
        return Cow::Borrowed(spec);
    }
    let mut fine = spec.clone();
    for (index, body) in fine.bodies.iter_mut().enumerate() {
        let factors = spec.resolution.body(index);
        if let Some(flexible) = body.kind.flexible_mut() {
            flexible.reduction = factors.reduction(flexible.reduction);
        }
        if let Some(elastic) = body.kind.elastic_mut() {
            factors.apply(elastic);
            for refinement in &mut elastic.discretisation.refine {
                let zone = zone_factor(spec, plans, index, refinement);
                factors.refinement(refinement, zone);
            }
        }
    }
    for (index, contact) in fine.contacts.iter_mut().enumerate() {
        if let ContactLaw::Surface(law) = &mut contact.law {
            let usual = (plans[index] == ContactPlan::AtTouch).then(|| law.interval.elements_or(ELEMENTS));
            spec.resolution.contact(index).apply(law, usual);
        }
    }
    Cow::Owned(fine)
}

/// The largest factor of the contacts that have their zone in `refinement` of body `body`; none if
/// it is no zone.
fn zone_factor(
    spec: &RunSpec,
    plans: &[ContactPlan],
    body: usize,
    refinement: &RefinementSpec,
) -> Option<usize> {
    let contacts = spec.contacts.iter().zip(plans).enumerate();
    let zones = contacts.filter(|(_, (contact, plan))| is_zone_of(contact, plan, body, refinement));
    zones.map(|(i, _)| spec.resolution.contact(i).zone).max()
}
