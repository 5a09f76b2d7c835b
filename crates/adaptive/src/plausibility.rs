//! What no result may do: an energy ledger that opens, motion beyond all sizes and speeds of the scenario, bodies that overlap at the
//! start; and what a result should be told about (docs/theory.md section P).

pub mod ledger;
pub mod motion;
pub mod overlap;
pub mod resolution;
pub mod start;
