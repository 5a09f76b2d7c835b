//! What people read on a terminal: tables of a result, numbers with bands, shares in percent, texts of files.

pub mod band;
pub mod percent;
pub mod shown;
pub mod table;
