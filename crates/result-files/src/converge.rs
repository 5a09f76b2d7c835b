//! How far a result depends on its resolution: runs of variants beside that of the scenario as it
//! is.
//!
//! [`variant`] says what can be varied, [`outcome`] reads what came out, [`peaks`] what of it is largest at the places asked for, [`difference`] compares, [`verdict`] judges and [`report`] shows it.
//! Which variants a scenario has, and how they run, is known to `fbimpact`.

pub mod variant;
mod motion;
pub mod peaks;
pub mod outcome;
pub mod difference;
pub mod verdict;
pub mod report;
