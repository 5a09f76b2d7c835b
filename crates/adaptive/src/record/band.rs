//! Bands: by how much the numbers of an impact may be off because of what a run is resolved to, and
//! why some have none (docs/theory/uncertainty.md).

use serde::{Deserialize, Serialize};

/// Bands of the numbers of an impact; NaN where there is none, never zero.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Band {
    /// Of the largest normal force \[N\].
    pub peak_force: f64,
    /// Of its time \[s\].
    pub peak_time: f64,
    /// Of the time from the first to the last contact \[s\].
    pub duration: f64,
    /// Of the impulse [N s].
    pub impulse: f64,
    /// Of the separating speed [m/s].
    pub separation_velocity: f64,
    /// Of the restitution.
    pub restitution: f64,
    /// The largest part of the band of the peak force or, where that has none, of the impulse, and its
    /// size \[N, N s\].
    pub largest: Option<(Source, f64)>,
    /// Why numbers have no band, if some have none.
    pub missing: Option<NoBand>,
}

impl Band {
    /// No band.
    pub fn none(missing: NoBand) -> Self {
        Self {
            peak_force: f64::NAN,
            peak_time: f64::NAN,
            duration: f64::NAN,
            impulse: f64::NAN,
            separation_velocity: f64::NAN,
            restitution: f64::NAN,
            largest: None,
            missing: Some(missing),
        }
    }

    /// Where the largest part comes from and what lowers it, and why numbers have no band: what is told
    /// of the band of an impact of the contact `contact`.
    pub fn note(&self, contact: &str) -> String {
        let largest = self.largest.map(|(source, part)| {
            let (of, unit, whole) = match self.peak_force.is_nan() {
                true => ("impulse", "N s", self.impulse),
                false => ("peak force", "N", self.peak_force),
            };
            let (name, lever) = (source.name(), source.lever(contact, (part, unit)));
            format!("{name}: {part:.1e} {unit} of the {whole:.1e} {unit} of the {of}; {lever}")
        });
        let missing = self.missing.map(|why| format!("no band of {}: {}", why.of(), why.reason()));
        [largest, missing].into_iter().flatten().collect::<Vec<_>>().join("; ")
    }
}

impl Default for Band {
    fn default() -> Self {
        Self::none(NoBand::Off)
    }
}

impl PartialEq for Band {
    /// Whether all numbers agree, those that are none among them.
    fn eq(&self, other: &Self) -> bool {
        let bits = |band: &Self| {
            let Self { peak_force, peak_time, duration, impulse, separation_velocity, restitution, .. } =
                *band;
            [peak_force, peak_time, duration, impulse, separation_velocity, restitution].map(f64::to_bits)
        };
        bits(self) == bits(other) && (self.largest, self.missing) == (other.largest, other.missing)
    }
}

/// What a part of a band comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Source {
    /// Penetration of the springs between the surfaces.
    Penalty,
    /// Points and elements across the contact.
    Zone,
    /// Frequencies of the modes on the mesh.
    Mesh,
    /// Modes left out.
    Modes,
    /// A force that rings about its mean.
    Ringing,
    /// Time steps.
    Steps,
    /// An open energy ledger: what detection, changes of models and factors leave.
    Ledger,
    /// Impacts before, from which bodies ring.
    Earlier,
}

impl Source {
    /// All sources.
    pub const ALL: [Self; 8] = [
        Self::Penalty,
        Self::Zone,
        Self::Mesh,
        Self::Modes,
        Self::Ringing,
        Self::Steps,
        Self::Ledger,
        Self::Earlier,
    ];

    /// Name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Penalty => "penalty",
            Self::Zone => "zone",
            Self::Mesh => "mesh",
            Self::Modes => "modes",
            Self::Ringing => "ringing",
            Self::Steps => "steps",
            Self::Ledger => "ledger",
            Self::Earlier => "earlier impacts",
        }
    }

    /// What lowers its part `part` in an impact of the contact `contact`, and to what: that of springs falls with their stiffness,
    /// that of a zone with the square of its elements, that of a mesh as fast at least.
    fn lever(self, contact: &str, (part, unit): (f64, &str)) -> String {
        let quarter = format!("{:.1e} {unit}", 0.25 * part);
        match self {
            Self::Penalty => {
                let tenth = 0.1 * part;
                format!("ten times its contacts.{contact}.penalty.initial makes that {tenth:.1e} {unit}")
            }
            Self::Zone => format!("twice its contacts.{contact}.interval.elements makes that {quarter}"),
            Self::Mesh => {
                format!("twice the discretisation.elements of its bodies makes that {quarter} or less")
            }
            Self::Modes | Self::Ringing => "more reduction.modes of its bodies lower it".into(),
            Self::Steps => "a smaller simulation.impact.rtol lowers it".into(),
            Self::Ledger => "a smaller simulation.impact.rtol and a finer contact zone lower it".into(),
            Self::Earlier => "what lowers their bands lowers it".into(),
        }
    }
}

/// Why numbers of an impact have no band.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum NoBand {
    /// Bands are switched off.
    Off,
    /// A hit of a stop.
    Stop,
    /// Nothing but the modes yields at the touch.
    Coarse,
    /// An edge or a corner touches.
    Edge,
    /// The run, or the phase with contact, ended while force acted.
    Unended,
    /// It goes on from an earlier phase, whose force is not kept.
    Continued,
    /// Other contacts or changing loads act on its bodies, or joints hold them in a large system or one that is driven.
    OtherForces,
    /// A body has modes that are not told apart from its rigid motion, or whose mesh is not known.
    ModesOfFile,
    /// One force along one normal on the modes does not give what the run did.
    NotOneForce,
    /// The linear motion after the last impact does not show the largest value.
    NotLinear,
    /// A largest value that no impact went before.
    NoImpact,
    /// Much of it rings from an earlier impact without bands.
    Earlier,
    /// The joint belongs to a system whose joints close loops.
    Loop,
}

impl NoBand {
    /// Which numbers it takes the band from.
    fn of(self) -> &'static str {
        match self {
            Self::Edge => "peak force, its time and duration",
            _ => "any number",
        }
    }

    /// The reason in words.
    pub fn reason(self) -> &'static str {
        match self {
            Self::Off => "bands are switched off",
            Self::Stop => "stops of joints have none",
            Self::Coarse => {
                "nothing but the modes yields at the touch, and how far the surfaces would is not known"
            }
            Self::Edge => "an edge or a corner touches, and how far that yields follows the elements",
            Self::Unended => "force acted when the run or its phase ended",
            Self::Continued => "the impact goes on from a phase whose force is not kept",
            Self::OtherForces => {
                "other contacts or changing loads act on its bodies, or they hang in a large system or one with prescribed motions"
            }
            Self::ModesOfFile => "the mesh of a body from a file is not known",
            Self::NotOneForce => {
                "one force along one normal on masses and modes does not repeat the impact, as where it moves, rolls or turns its bodies"
            }
            Self::NotLinear => {
                "the linear motion after the impact does not show it, as after large turns or further touches"
            }
            Self::NoImpact => "no impact went before",
            Self::Earlier => "it rings from an earlier impact without bands",
            Self::Loop => "what joints transmit where some close loops is not known mode by mode",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_band_is_empty_and_says_why() {
        let none = Band::none(NoBand::Coarse);
        assert!(none.peak_force.is_nan() && none.restitution.is_nan());
        assert!(none.note("c").starts_with("no band of any number: nothing but"), "{}", none.note("c"));
    }

    #[test]
    fn the_largest_part_is_told_with_its_lever() {
        let band =
            Band { peak_force: 2.0, largest: Some((Source::Zone, 1.6)), missing: None, ..Band::default() };
        let told = "zone: 1.6e0 N of the 2.0e0 N of the peak force; twice its contacts.c.interval.elements makes that 4.0e-1 N";
        assert_eq!(band.note("c"), told);
    }
}
