//! Frequencies that the mesh puts off (docs/theory/uncertainty.md Eq. U.7).

use super::replay::{Bodies, Mode};

/// The same bodies with the frequencies that a finer mesh would give.
pub fn finer(bodies: &Bodies) -> Bodies {
    Bodies { modes: bodies.modes.iter().copied().map(Mode::on_finer_mesh).collect(), ..*bodies }
}
