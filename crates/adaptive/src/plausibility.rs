//! What no result may do: an energy ledger that opens, motion beyond all sizes and speeds of the scenario, bodies that overlap at the
//! start; and warnings of doubtful results (docs/theory.md section P).

pub mod contact_strain;
pub mod finding;
pub mod ledger;
pub mod linearity;
pub mod motion;
pub mod overlap;
pub mod resolution;
pub mod start;
pub mod watch;
pub mod units;
