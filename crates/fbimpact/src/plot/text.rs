//! Text of figures.

use std::sync::LazyLock;

use plotters::drawing::DrawingAreaErrorKind;
use plotters::style::{FontStyle, IntoFont, TextStyle, register_font};

use super::PlotError;
use super::theme::{FONT, FONT_DATA, INK, TEXT_FACTOR, units};

/// Whether the font could be read.
pub static FONT_READY: LazyLock<bool> =
    LazyLock::new(|| register_font(FONT, FontStyle::Normal, FONT_DATA).is_ok());

/// Text of `size` \[px\] in the ink of axes.
pub fn text_style(size: f64) -> TextStyle<'static> {
    (FONT, f64::from(units(size)) * TEXT_FACTOR).into_font().color(&INK)
}

/// An error of the drawing library.
pub fn draw_error<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> PlotError {
    PlotError::Draw(error.to_string())
}
