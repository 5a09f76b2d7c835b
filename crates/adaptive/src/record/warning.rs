//! What a run found doubtful about itself: every warning has a kind, a subject, its numbers and a
//! remedy.
//!
//! A warning is given once for a kind and a subject, at the first instant at which it holds, so
//! that it is the same however often the run is taken up again.

use serde::{Deserialize, Serialize};

/// Declares the kinds of warnings: each with the name that it has in logs and files and the
/// sentence that says what it means, for readers of this documentation and of `docs/results.md`
/// alike.
macro_rules! kinds {
    ($($(#[$attribute:meta])* $kind:ident = $identifier:literal: $meaning:literal,)*) => {
        /// Kinds of warnings.
        #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
        pub enum WarningKind {
            $(#[doc = $meaning] $(#[$attribute])* $kind,)*
        }

        impl WarningKind {
            /// All kinds, in the order of their numbers.
            pub const ALL: &'static [Self] = &[$(Self::$kind),*];

            /// Name in logs and files.
            pub fn identifier(self) -> &'static str {
                match self {
                    $(Self::$kind => $identifier,)*
                }
            }

            /// What it means, a sentence.
            pub fn meaning(self) -> &'static str {
                match self {
                    $(Self::$kind => $meaning,)*
                }
            }
        }
    };
}

kinds! {
    #[default]
    FewModes = "few-modes": "The modes kept end below the frequencies that an impact excites.",
    CoarseMesh = "coarse-mesh": "The mesh has too few elements for a wave of the highest mode kept.",
    SparseOutput = "sparse-output": "States are stored too rarely to show vibrations that the body carries.",
    NeverClosed = "never-closed": "A contact never closed.",
    InitialOverlap = "initial-overlap": "The bodies overlap at the start, as the scenario allows.",
    CoarsePlace = "coarse-place": "A disc or ball that a joint or load holds is too small for the elements there.",
    CoarseTouch = "coarse-touch": "The elements of a mesh are too large for a contact there, as Hertz's theory predicts it.",
    CoarseShape = "coarse-shape": "The sides of a mesh follow the part too roughly for a contact there, whatever their number becomes.",
    MinorContact = "minor-contact": "The force of a contact was too small beside others to judge its zone and penalty factor by.",
    SlowRise = "slow-rise": "The bodies have too few modes for flat faces: their force rises and falls over more than 2 % of the duration of the impact.",
    EdgeTouch = "edge-touch": "Bodies touch with an edge or a corner, where elements decide how far they yield.",
    YieldsTwice = "yields-twice": "Modes of a flexible body yield at the touch beside Hertz's law, which holds that already.",
    LargeTurn = "large-turn": "Deformation turns parts of a body so far that linear deformation ends.",
    LargeStrain = "large-strain": "A body strains so much that linear elasticity ends.",
    AxialLoad = "axial-load": "A body is loaded along itself by a share of its buckling load that changes how it bends.",
    FastSpin = "fast-spin": "A body spins so fast that centrifugal forces change its frequencies.",
    SpinStress = "spin-stress": "A body has a spin to whose centrifugal force its modes have no static answer.",
    LargeContactStrain = "large-contact-strain": "A contact presses so hard that linear elasticity ends there.",
    MovingContact = "moving-contact": "Contact moved along its interval so far that few elements touched at one instant.",
    SoftContact = "soft-contact": "More of the approach of two bodies is penetration than a contact may have: its penalty factor is too low.",
    CoarseZone = "coarse-zone": "So few points of a contact zone that is not refined in the run carried its force that their distance shows in it.",
    StaticContact = "static-contact": "Bodies that touch are pressed together at a start in equilibrium, which does not know of the force.",
    Unstable = "unstable": "The static equilibrium that a run begins in does not hold against small disturbances.",
    OutOfBalance = "out-of-balance": "Forces balance less well than they should in the static equilibrium that a run begins in.",
    SuddenSpin = "sudden-spin": "A body starts undeformed at a spin that strains it, so that its stress rings.",
    LocalStress = "local-stress": "Stress is asked for so near to a contact that what its law leaves out of it counts.",
    Yields = "yields": "A contact or a stress that is asked for exceeds what a material bears without yielding.",
    WideBand = "wide-band": "The band of a peak force is wider than the scenario wants it.",
    RingingForce = "ringing-force": "A force rings about its mean, as that of springs between flat faces that are stiffer than the modes kept follow, and its peak is too high.",
    ByLaw = "by-law": "Contact that rolls or slides through more zones than a run is to take goes on by Hertz's law, without zones and pressures.",
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
    fn kinds_have_names_of_their_own() {
        for kind in WarningKind::ALL {
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
