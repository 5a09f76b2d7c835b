//! The fbimpact program as a library: command line, scenario, setup, run, results.

pub mod error;
pub mod scenario;
pub mod simulate;
