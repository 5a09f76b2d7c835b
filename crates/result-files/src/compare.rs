//! Two results compared: dataset by dataset on the reference's instants, then impacts and the final
//! state.
//!
//! Knows results by their paths and units only, so that datasets of later versions are compared
//! without a change here.

mod glob;
mod tolerance;
mod track;
mod align;
mod finding;
mod datasets;
mod features;
mod judge;
mod report;

pub use finding::{Deviation, Finding};
pub use judge::{Comparison, compare};
pub use tolerance::{DEFAULTS, Rules, Tolerance};
