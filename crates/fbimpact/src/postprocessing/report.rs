//! One page about results that opens in any browser: verdict, tables, figures that zoom, bodies in
//! motion.
//!
//! Everything stands in the file. Tables and drawings are HTML and SVG from here; scripts draw
//! figures and bodies from numbers in script elements, coded as [`encode`] says. A body in motion
//! is its surface once, with shapes (displacement and stress at the vertices) whose coordinates are
//! stored over time; `docs/report.md` has the format.

pub mod encode;
pub mod html;
pub mod surface;
pub mod frames;
pub mod nearest;
pub mod reduce;
pub mod motion;
pub mod charts;
pub mod tables;
pub mod page;
pub mod whole;
