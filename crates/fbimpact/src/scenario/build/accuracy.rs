//! The level of what the program chooses.

use adaptive::spec::Accuracy;

use super::super::section::Section;

/// The level that the scenario asks for; the usual one where the key is at fault.
pub fn accuracy(root: &Section) -> Accuracy {
    root.choice("accuracy").unwrap_or_default()
}

/// Change of the peak force at which the search in `penalty` ends: the one given, else that of the
/// level.
pub fn peak_tolerance(root: &Section, penalty: &Section) -> f64 {
    penalty.number("tolerance").unwrap_or_else(|| accuracy(root).peak_tolerance())
}
