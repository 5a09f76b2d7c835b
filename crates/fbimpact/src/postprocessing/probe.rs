//! Histories at material points of a result, and of the coordinates of its bodies, without a new
//! run.

pub mod places;
pub mod series;
pub mod table;
