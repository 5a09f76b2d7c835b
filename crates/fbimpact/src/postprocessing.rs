//! What is made from a result by building its models again: their motion, files for ParaView,
//! histories at points, pages for a browser.

pub mod replay;
pub mod probe;
pub mod vtk;
pub mod report;
pub mod drops;
