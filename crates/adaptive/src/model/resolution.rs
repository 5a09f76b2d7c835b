//! Factors on the resolution of a run, applied to its specification; which bodies and contacts they
//! act on.

use std::borrow::Cow;

use crate::body::fine::refined::ELEMENTS;
use crate::body::zone::at_start::is_about;
use crate::prepared::{PlannedContact, Prepared};
use crate::spec::{BodyKind, BodySpec, PenaltySearch, ReductionSpec, RefinementSpec, RunSpec, SurfaceLaw};

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

/// The bodies and contacts of a run that factors act on.
pub fn subjects(run: &Prepared<'_>) -> Subjects {
    let spec = run.spec();
    let bodies = |wanted: fn(&BodyKind) -> bool| {
        let named = spec.bodies.iter().filter(move |b| wanted(&b.kind));
        named.map(|b| b.name.clone()).collect()
    };
    let contacts = |wanted: &dyn Fn(PlannedContact<'_>, &SurfaceLaw) -> bool| {
        let named = run.contacts().filter(|c| c.spec.law.surface().is_some_and(|law| wanted(*c, law)));
        named.map(|c| c.spec.name.clone()).collect()
    };
    Subjects {
        modes: bodies(has_modes),
        mesh: bodies(|kind| kind.elastic().is_some()),
        zone: contacts(&|contact, law| has_zone(spec, contact, law)),
        penalty: contacts(&|_, law| has_penalty(law)),
    }
}

fn has_modes(kind: &BodyKind) -> bool {
    kind.flexible().is_some_and(|flexible| flexible.reduction != ReductionSpec::All)
}

fn has_zone(spec: &RunSpec, contact: PlannedContact<'_>, law: &SurfaceLaw) -> bool {
    let in_body = |(body, spec_of): (usize, &BodySpec)| {
        let refinements = spec_of.elastic().map_or(&[][..], |e| &e.discretisation.refine);
        refinements.iter().any(|r| is_zone_of(contact, body, r))
    };
    let is_given = law.interval.elements.is_some() || contact.at_touch().is_some();
    law.treatment.has_fine_zone() && (is_given || spec.bodies.iter().enumerate().any(in_body))
}

fn has_penalty(law: &SurfaceLaw) -> bool {
    law.search != PenaltySearch::UntilError && law.penalty.is_none_or(f64::is_finite)
}

/// Whether a contact whose law names no elements has its zone in `refinement` of body `body`.
fn is_zone_of(contact: PlannedContact<'_>, body: usize, refinement: &RefinementSpec) -> bool {
    let Some((law, sites)) = contact.from_start() else { return false };
    let is_given = !law.treatment.has_fine_zone() || law.interval.elements.is_some();
    !is_given && sites.on(contact.spec, body).any(|site| is_about(refinement, &site.point))
}

/// The specification of `run` with its factors applied.
pub fn refined<'a>(run: &Prepared<'a>) -> Cow<'a, RunSpec> {
    let spec = run.spec();
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
                let zone = zone_factor(run, index, refinement);
                factors.refinement(refinement, zone);
            }
        }
    }
    for (index, (contact, planned)) in fine.contacts.iter_mut().zip(run.contacts()).enumerate() {
        if let Some(law) = contact.law.surface_mut() {
            let usual = planned.at_touch().map(|law| law.interval.elements_or(ELEMENTS));
            spec.resolution.contact(index).apply(law, usual);
        }
    }
    Cow::Owned(fine)
}

/// The largest factor of the contacts that have their zone in `refinement` of body `body`; none if
/// it is no zone.
fn zone_factor(run: &Prepared<'_>, body: usize, refinement: &RefinementSpec) -> Option<usize> {
    let zones = run.contacts().enumerate().filter(|(_, contact)| is_zone_of(*contact, body, refinement));
    zones.map(|(i, _)| run.spec().resolution.contact(i).zone).max()
}
