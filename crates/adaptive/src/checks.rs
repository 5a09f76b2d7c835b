//! What no result may do: an energy ledger that opens, motion beyond all sizes and speeds of the
//! scenario, bodies that overlap at the start; and warnings of doubtful results (docs/theory.md
//! part P). Knows models and records; no kind of body is named here.

pub mod contact_strain;
pub mod linearity;
pub mod motion;
pub mod resolution;
pub mod watch;
pub mod start;
pub mod units;
