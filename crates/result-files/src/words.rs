//! What people read on a terminal: tables of a result, shares in percent, texts of files.

pub mod percent;
pub mod shown;
pub mod table;
