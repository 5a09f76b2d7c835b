//! Units of length of files that do not say theirs.

use super::super::keys::Choice;

/// Their names.
pub(super) const UNITS: &[Choice] = &[
    Choice::new("m", "metres"),
    Choice::new("cm", "centimetres"),
    Choice::new("mm", "millimetres"),
    Choice::new("in", "inches"),
];
