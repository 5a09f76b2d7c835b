//! What the meaning of a contact's settings depends on.

use super::super::section::Section;
use super::places::BodyFacts;

/// What the meaning of a contact's settings depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactFacts<'a> {
    /// Contact model.
    pub model: &'a str,
    /// Whether the target is a body, and no plane at rest.
    pub is_pair: bool,
    /// Whether bodies do not penetrate: there is no penalty factor.
    pub is_exact: bool,
    /// How the penalty factor is found; empty if that is at fault.
    pub search: &'a str,
    /// Whether one of the bodies is.
    pub has_mesh: bool,
}

impl<'a> ContactFacts<'a> {
    /// Facts of the contact in `section`, unless what they follow from is at fault.
    pub fn of(root: &Section, section: &'a Section) -> Option<Self> {
        let model = section.text("model")?;
        let body = |key| section.text(key).and_then(|name| BodyFacts::find(root, name));
        let (own, target) = (body("contact_body"), body("target_body"));
        let is_mesh = |body: &Option<BodyFacts<'_>>| body.is_some_and(|b| b.mesh.is_some());
        let has_mesh = is_mesh(&own) || is_mesh(&target);
        let is_exact = model == "massless" || section.text("constraint") == Some("exact");
        let search = section.table("penalty").map_or("", |penalty| match penalty.item("search") {
            Some(_) => penalty.text("search").unwrap_or_default(),
            None if model == "adaptive" && !is_exact => "until-converged",
            None => "fixed",
        });
        let is_pair = target.is_some_and(|t| !t.is_plane());
        Some(Self { model, is_pair, is_exact, search, has_mesh })
    }

    /// Whether the program refines the contact zone by itself.
    pub fn is_refined(&self) -> bool {
        self.model == "adaptive" || self.is_pair && self.model != "coarse" && !self.has_mesh
    }
}
