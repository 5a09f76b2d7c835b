//! Frequencies that the mesh puts off (docs/theory/uncertainty.md Eq. U.7).

use super::replay::{Bodies, Mode};

/// The same bodies with the frequencies that a finer mesh would give: lower ones, for meshes that conform.
/// What a mode yields, `share²/stiffness`, grows with that.
pub fn finer(bodies: &Bodies) -> Bodies {
    let lower =
        |mode: &Mode| Mode { stiffness: mode.stiffness * (1.0 - mode.error).max(0.1).powi(2), ..*mode };
    Bodies { modes: bodies.modes.iter().map(lower).collect(), ..*bodies }
}
