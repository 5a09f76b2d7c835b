//! Commands that look at results, at one or at many: numbers, figures, pages, files for others.

pub mod collect;
pub mod compare;
pub mod export;
pub mod info;
pub mod metric;
pub mod plot;
pub mod probe;
pub mod report;
pub mod thin;
