//! What happens in a contact in the course of its touches: when it closes and opens, sticks, slips and rests (docs/theory.md
//! section Q.5).

use serde::{Deserialize, Serialize};

/// What a contact does from an instant on.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum EventKind {
    /// It closes.
    #[default]
    Touch,
    /// It opens.
    Release,
    /// No point slides.
    Stick,
    /// Some points slide and others do not.
    PartialSlip,
    /// All points slide.
    Slip,
    /// Its bodies stay where they are on each other (Eq. Q.10).
    Rest,
    /// They no longer do.
    Motion,
}

impl EventKind {
    /// Name in logs and files.
    pub fn identifier(self) -> &'static str {
        match self {
            Self::Touch => "touch",
            Self::Release => "release",
            Self::Stick => "stick",
            Self::PartialSlip => "partial slip",
            Self::Slip => "slip",
            Self::Rest => "rest",
            Self::Motion => "motion",
        }
    }
}

/// An event of a contact.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct EventRecord {
    /// Index of the contact.
    pub contact: u32,
    /// What happened.
    pub kind: EventKind,
    /// When \[s\].
    pub time: f64,
    /// Normal force at the end of the step in which it happened \[N\].
    pub normal_force: f64,
}
