//! The keys of files that a body is made from.

use super::super::keys::{Choice, Key, Kind, Need};

/// The contents that a file must have.
pub(super) const FILE_SHA256: Key = Key::new(
    "file_sha256",
    Kind::Name,
    "",
    Need::Optional("any"),
    "SHA-256 that `file` must have, in hexadecimal digits; the resolved scenario of a result holds it.",
);

/// Units of length, for files that do not say theirs.
pub(super) const UNITS: &[Choice] = &[
    Choice::new("m", "metres"),
    Choice::new("cm", "centimetres"),
    Choice::new("mm", "millimetres"),
    Choice::new("in", "inches"),
];
