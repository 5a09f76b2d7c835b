//! The reduced basis of a body and the damping of its coordinates.

/// Reduced basis of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReductionSpec {
    /// The first free eigenmodes.
    Modal {
        /// Number of elastic modes.
        modes: usize,
    },
    /// Craig-Bampton.
    CraigBampton {
        /// Number of low-frequency modes.
        modes: usize,
        /// Number of fixed-interface modes; `None`: enough for the low-frequency ones to be right.
        fixed_interface_modes: Option<usize>,
    },
    /// Every elastic mode of the model.
    All,
}

impl ReductionSpec {
    /// Number of elastic modes, where the method has one.
    pub fn modes(&self) -> Option<usize> {
        match self {
            Self::Modal { modes } | Self::CraigBampton { modes, .. } => Some(*modes),
            Self::All => None,
        }
    }

    /// Sets the number of elastic modes, where the method has one.
    pub fn set_modes(&mut self, n: usize) {
        if let Self::Modal { modes } | Self::CraigBampton { modes, .. } = self {
            *modes = n;
        }
    }
}

/// Damping of elastic coordinates.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum DampingSpec {
    /// None.
    #[default]
    None,
    /// Rayleigh damping: the damping ratio `ratio` at two frequencies \[Hz\] (\[B\] (26)-(28)).
    Rayleigh {
        /// The two frequencies \[Hz\].
        frequencies: [f64; 2],
        /// Damping ratio at both, 1 being critical.
        ratio: f64,
    },
    /// Damping ratios, one per mode; the last holds for all that follow.
    Modal(Vec<f64>),
    /// Structural damping: the loss factor, twice the ratio of every mode.
    Structural(f64),
}
