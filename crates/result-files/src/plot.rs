//! Figures from result files: drawn once as SVG, turned into pixels or PDF from there.
//!
//! A [`figure::Figure`] says what is shown; it knows nothing of pixels. [`render`] draws it. All
//! formats come from the same drawing and the same embedded font, so that they look alike on every
//! machine.

pub mod labels;
pub mod data;
pub mod ticks;
pub mod figure;
pub mod theme;
pub mod drawing;
pub mod curve;
pub mod figures;
pub mod render;

/// What can go wrong while drawing; files are the caller's.
#[derive(Debug, thiserror::Error)]
pub enum PlotError {
    /// The drawing library refused.
    #[error("the figure cannot be drawn: {0}")]
    Draw(String),
    /// The file cannot be made from the drawing.
    #[error("the figure cannot be converted: {0}")]
    Convert(String),
}
