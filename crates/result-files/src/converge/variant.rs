//! What can be varied, and a run in which it is.

/// What can be varied.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Parameter {
    /// Number of modes of bodies.
    Modes,
    /// Elements of bodies outside of contact zones.
    Mesh,
    /// Elements across contact zones.
    Zone,
    /// Permitted error and length of time steps.
    Tolerance,
    /// Penalty factor.
    Penalty,
}

impl Parameter {
    /// All, in the order of tables.
    pub const ALL: [Self; 5] = [Self::Modes, Self::Mesh, Self::Zone, Self::Tolerance, Self::Penalty];

    /// Name of the variant, and the key of the scenario's table `resolution`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Modes => "modes",
            Self::Mesh => "mesh",
            Self::Zone => "zone",
            Self::Tolerance => "tolerance",
            Self::Penalty => "penalty",
        }
    }

    /// What the variant has that the scenario has not.
    pub fn change(self) -> &'static str {
        match self {
            Self::Modes => "twice the modes",
            Self::Mesh => "twice the elements in each direction",
            Self::Zone => "twice the elements across the contact zone",
            Self::Tolerance => "a tenth of the integration tolerance and half the longest steps",
            Self::Penalty => "ten times the penalty factor",
        }
    }
}

/// A run beside that of the scenario as it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Variant {
    /// Name, and that of its files.
    pub name: String,
    /// What is varied.
    pub parameters: Vec<Parameter>,
    /// Bodies or contacts that are; none of a tolerance and of several parameters.
    pub subjects: Vec<String>,
    /// Changes of the scenario, `KEY=VALUE`.
    pub set: Vec<String>,
}
