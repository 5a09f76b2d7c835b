//! Commands about the program: models that it keeps, completions, manual pages.

pub mod cache;
pub mod shell;
