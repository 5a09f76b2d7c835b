//! Text of figures.

use std::sync::LazyLock;

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind};
use plotters::style::{FontStyle, IntoFont, TextStyle, register_font};

use crate::plot::PlotError;
use crate::plot::theme::{FONT, FONT_DATA, INK, TEXT_FACTOR, units};

/// Whether the font could be read.
pub static FONT_READY: LazyLock<bool> =
    LazyLock::new(|| register_font(FONT, FontStyle::Normal, FONT_DATA).is_ok());

/// Text of `size` \[px\] in the ink of axes.
pub fn text_style(size: f64) -> TextStyle<'static> {
    (FONT, f64::from(units(size)) * TEXT_FACTOR).into_font().color(&INK)
}

/// Drawing area of a figure.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Width of a line of `size` \[px\] in units.
pub fn width(area: &Area<'_>, line: &str, size: f64) -> Result<i32, PlotError> {
    let (width, _) = area.estimate_text_size(line, &text_style(size)).map_err(draw_error)?;
    Ok(width as i32)
}

/// `words` in lines of `size` \[px\] that are no wider than `most` in units; a word that is goes on
/// in the next line.
pub fn broken(area: &Area<'_>, words: &str, size: f64, most: i32) -> Result<Vec<String>, PlotError> {
    let mut lines: Vec<String> = Vec::new();
    let mut pieces = Vec::new();
    for word in words.split_whitespace() {
        pieces.push(String::new());
        for letter in word.chars() {
            let last = pieces.last_mut().map(|piece| format!("{piece}{letter}")).unwrap_or_default();
            match pieces.last_mut() {
                Some(piece) if piece.is_empty() || width(area, &last, size)? <= most => *piece = last,
                _ => pieces.push(letter.to_string()),
            }
        }
    }
    for word in pieces {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        let fits = match &longer {
            Some(line) => width(area, line, size)? <= most,
            None => false,
        };
        match (longer, lines.last_mut()) {
            (Some(longer), Some(last)) if fits => *last = longer,
            _ => lines.push(word),
        }
    }
    Ok(lines)
}

/// An error of the drawing library.
pub fn draw_error<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> PlotError {
    PlotError::Draw(error.to_string())
}
