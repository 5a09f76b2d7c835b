//! Buckens and tangent frames.
