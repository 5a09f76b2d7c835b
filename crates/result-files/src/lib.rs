//! Result files: what they hold, and what is made from them alone.
//!
//! Knows datasets with their units, tables, files that may be damaged, expressions over a result,
//! comparisons, tables of many runs, what a result changes by with its resolution, and figures.
//! Does not know keys of a scenario, models, runs, or the command line: a scenario is the text that
//! a result holds. What builds models again from that text (`vtk`, `probe`, bodies in motion) is in
//! `fbimpact` (docs/decisions/0058).

pub mod toml_text;
pub mod dataset;
pub mod tables;
pub mod words;
pub mod file;
pub mod error;
pub mod stored;
pub mod expression;
pub mod compare;
pub mod collect;
pub mod plot;
pub mod converge;
