//! What a run found doubtful about itself: every warning has a kind, a subject, its numbers and a remedy.
//!
//! A warning is given once for a kind and a subject, at the first instant at which it holds, so that it is the same however often
//! the run is taken up again.

use serde::{Deserialize, Serialize};

/// Kinds of warnings. Their numbers are stored in restart files.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum WarningKind {
    /// The modes kept end below the frequencies that an impact excites.
    #[default]
    FewModes,
    /// The mesh has too few elements for a wave of the highest mode kept.
    CoarseMesh,
    /// States are stored too rarely to show vibrations that the body carries.
    SparseOutput,
    /// A contact never closed.
    NeverClosed,
    /// The bodies overlap at the start, as the scenario allows.
    InitialOverlap,
    /// A disc or ball that a joint or load holds is too small for the elements there.
    CoarsePlace,
    /// The force of a contact was too small beside others to judge its zone and penalty factor by.
    MinorContact,
}

impl WarningKind {
    /// All kinds, in the order of their numbers.
    pub const ALL: [Self; 7] = [
        Self::FewModes,
        Self::CoarseMesh,
        Self::SparseOutput,
        Self::NeverClosed,
        Self::InitialOverlap,
        Self::CoarsePlace,
        Self::MinorContact,
    ];

    /// Name in logs and files.
    pub fn identifier(self) -> &'static str {
        match self {
            Self::FewModes => "few-modes",
            Self::CoarseMesh => "coarse-mesh",
            Self::SparseOutput => "sparse-output",
            Self::NeverClosed => "never-closed",
            Self::InitialOverlap => "initial-overlap",
            Self::CoarsePlace => "coarse-place",
            Self::MinorContact => "minor-contact",
        }
    }
}

/// A warning.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Warning {
    /// What it is about.
    pub kind: WarningKind,
    /// Body or contact, with its name.
    pub subject: String,
    /// When it first held \[s\].
    pub time: f64,
    /// The quantity that is doubtful, in the unit named in the message.
    pub value: f64,
    /// What it should have been at least, or at most.
    pub limit: f64,
    /// What was found, with numbers and units.
    pub message: String,
    /// What to change, with the keys of the scenario.
    pub remedy: String,
}

impl Warning {
    /// `identifier: subject: message; remedy`, a line of a log or file.
    pub fn line(&self) -> String {
        format!("{}: {}: {}; {}", self.kind.identifier(), self.subject, self.message, self.remedy)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_listed_in_the_order_of_their_numbers_and_have_names_of_their_own() {
        for (number, kind) in WarningKind::ALL.into_iter().enumerate() {
            assert_eq!(kind as usize, number);
            let same = WarningKind::ALL.iter().filter(|k| k.identifier() == kind.identifier());
            assert_eq!(same.count(), 1);
        }
    }

    #[test]
    fn a_line_holds_everything_in_order() {
        let warning = Warning {
            subject: "contact \"c\"".into(),
            message: "a is 1 m, less than 2 m".into(),
            remedy: "raise a".into(),
            ..Warning::default()
        };
        assert_eq!(warning.line(), "few-modes: contact \"c\": a is 1 m, less than 2 m; raise a");
    }
}
