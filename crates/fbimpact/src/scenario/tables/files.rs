//! The keys of files that a body is made from.

use super::super::keys::{Key, Kind, name_values};

/// The contents that a file must have.
pub(super) const FILE_SHA256: Key = Key::new("file_sha256", Kind::Name)
    .otherwise("any")
    .doc("SHA-256 that `file`, followed by the files that it includes, must have, in hexadecimal digits; the resolved scenario of a result holds it.");

/// Units of length, for files that do not say theirs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LengthUnit {
    /// Metres.
    Metre,
    /// Centimetres.
    Centimetre,
    /// Millimetres.
    Millimetre,
    /// Inches.
    Inch,
}

name_values!(LengthUnit {
    Metre: "m", "metres";
    Centimetre: "cm", "centimetres";
    Millimetre: "mm", "millimetres";
    Inch: "in", "inches";
});

impl LengthUnit {
    /// Its length \[m\].
    pub fn length(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 1e-2,
            Self::Millimetre => 1e-3,
            Self::Inch => 0.0254,
        }
    }
}
