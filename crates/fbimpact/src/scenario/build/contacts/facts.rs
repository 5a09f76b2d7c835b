//! What the meaning of a contact's settings depends on.

use adaptive::spec::Treatment;

use crate::scenario::build::places::BodyFacts;
use crate::scenario::section::Section;
use crate::scenario::tables::{Constraint, ContactModel, Search};

/// What the meaning of a contact's settings depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactFacts {
    /// Contact model.
    pub model: ContactModel,
    /// Whether the target is a body, and no plane at rest.
    pub is_pair: bool,
    /// Whether bodies do not penetrate: there is no penalty factor.
    pub is_exact: bool,
    /// How the penalty factor is found; none if that is at fault.
    pub search: Option<Search>,
    /// Whether one of the bodies is.
    pub has_mesh: bool,
    /// Whether the contact body is rigid.
    pub is_rigid: bool,
}

impl ContactFacts {
    /// Facts of the contact in `section`, unless what they follow from is at fault.
    pub fn of(root: &Section, section: &Section) -> Option<Self> {
        let model: ContactModel = section.choice("model")?;
        let body = |key| section.text(key).and_then(|name| BodyFacts::find(root, name));
        let (own, target) = (body("contact_body"), body("target_body"));
        let is_rigid = own.is_some_and(|body| body.is_rigid);
        let is_mesh = |body: &Option<BodyFacts<'_>>| body.is_some_and(|b| b.mesh.is_some());
        let has_mesh = is_mesh(&own) || is_mesh(&target);
        let is_exact = model.is_massless() || section.choice("constraint") == Some(Constraint::Exact);
        let search = section.table("penalty").and_then(|penalty| match penalty.item("search") {
            Some(_) => penalty.choice("search"),
            None if model.is(Treatment::is_searched) && !is_exact => Some(Search::UntilConverged),
            None => Some(Search::Fixed),
        });
        let is_pair = target.is_some_and(|t| !t.is_plane());
        Some(Self { model, is_pair, is_exact, search, has_mesh, is_rigid })
    }

    /// Whether the program refines the contact zone by itself.
    pub fn is_refined(&self) -> bool {
        self.model.is(|of| of.is_searched() || self.is_pair && of.has_fine_zone() && !self.has_mesh)
    }
}
