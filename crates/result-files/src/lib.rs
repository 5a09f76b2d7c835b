//! Result files: what they hold, and what is made from them alone.
//!
//! Knows datasets with their units, tables, files that may be damaged, expressions over a result,
//! comparisons, tables of many runs, what a result changes by with its resolution, and figures.
//! Does not know keys of a scenario, models, runs, or the command line: a scenario is the text that
//! a result holds. What builds models again from that text (`vtk`, `probe`, bodies in motion) is in
//! `fbimpact` (docs/decisions/0058).

pub mod percent;
pub mod shown_text;
pub mod error_text;
pub mod plain_file;
pub mod hdf5_integrity;
pub mod file_fault;
pub mod whole_file;
pub mod toml_text;
pub mod error;
pub mod scales;
pub mod dataset;
pub mod open;
pub mod tables;
pub mod stages;
pub mod chosen_sizes;
pub mod stored;
pub mod pressure_series;
pub mod reactions;
pub mod warnings;
pub mod summary;
pub mod text;
pub mod thin;
pub mod scenario_values;
pub mod expression;
pub mod compare;
pub mod collect;
pub mod converge;
pub mod plot;
