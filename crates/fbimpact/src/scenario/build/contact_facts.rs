//! What the meaning of a contact's settings depends on.

use super::super::section::Section;
use super::places::BodyFacts;

/// What the meaning of a contact's settings depends on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactFacts<'a> {
    /// Contact model.
    pub model: &'a str,
    /// Whether the target is a flexible body.
    pub is_pair: bool,
    /// How the penalty factor is found; empty if that is at fault.
    pub search: &'a str,
}

impl<'a> ContactFacts<'a> {
    /// Facts of the contact in `section`, unless what they follow from is at fault.
    pub fn of(root: &Section, section: &'a Section) -> Option<Self> {
        let model = section.text("model")?;
        let target = section.text("target_body").and_then(|name| BodyFacts::find(root, name));
        let search = section.table("penalty").map_or("", |penalty| match penalty.item("search") {
            Some(_) => penalty.text("search").unwrap_or_default(),
            None if model == "adaptive" && section.text("constraint") != Some("exact") => "until-converged",
            None => "fixed",
        });
        Some(Self { model, is_pair: target.is_some_and(|t| !t.is_rigid), search })
    }

    /// Whether the program refines the contact zone by itself.
    pub fn is_refined(&self) -> bool {
        self.model == "adaptive" || self.is_pair && self.model != "coarse"
    }
}
