//! The legend: a flow of signs and words above the panels.

use plotters::element::{Circle, PathElement, Rectangle};
use plotters::style::{Color, ShapeStyle};

use super::text::{Area, broken, draw_error, text_style};
use crate::plot::PlotError;
use crate::plot::figure::{Entry, Shade, Sign};
use crate::plot::theme::{FREE, GRID, IMPACT, INK, LIMIT, LINE, TEXT, style, units};

/// Width of a sign \[px\].
const SIGN: f64 = 30.0;
/// Distance between sign and words, and between entries \[px\].
const GAP: f64 = 6.0;
const BETWEEN: f64 = 18.0;
/// Height of a row \[px\].
const ROW: f64 = 19.0;

/// Places of entries.
pub struct Flow {
    /// Left end in units, row, and the lines of the words.
    places: Vec<(i32, i32, Vec<String>)>,
    /// Height of all rows, in units.
    pub height: i32,
}

/// Arranges `entries` in rows that fit a figure of the width `width` in units.
pub fn flow(area: &Area<'_>, entries: &[Entry], width: i32) -> Result<Flow, PlotError> {
    let (left, right) = (units(12.0), width - units(12.0));
    let (mut x, mut row, mut places) = (left, 0, Vec::new());
    for entry in entries {
        let (width, _) = area.estimate_text_size(&entry.label, &text_style(TEXT)).map_err(draw_error)?;
        let width = units(SIGN + GAP) + width as i32;
        if x > left && x + width > right {
            (x, row) = (left, row + 1);
        }
        // Words that are wider than the figure go on below, and nothing stands beside them.
        let lines = if left + width > right {
            broken(area, &entry.label, TEXT, right - left - units(SIGN + GAP))?
        } else {
            vec![entry.label.clone()]
        };
        let further = lines.len().saturating_sub(1) as i32;
        places.push((x, row, lines));
        (x, row) = (x + width + units(BETWEEN), row + further);
    }
    let rows = if entries.is_empty() { 0 } else { row + 1 };
    Ok(Flow { places, height: rows * units(ROW) })
}

/// Draws `entries` below `top`.
pub fn draw(area: &Area<'_>, entries: &[Entry], flow: &Flow, top: i32) -> Result<(), PlotError> {
    for (entry, (x, row, lines)) in entries.iter().zip(&flow.places) {
        let y = top + row * units(ROW) + units(0.5 * ROW);
        sign(area, entry.sign, (*x, y))?;
        for (line, words) in lines.iter().enumerate() {
            let at = (x + units(SIGN + GAP), y - units(0.5 * TEXT) + line as i32 * units(ROW));
            area.draw_text(words, &text_style(TEXT), at).map_err(draw_error)?;
        }
    }
    Ok(())
}

fn sign(area: &Area<'_>, sign: Sign, (x, y): (i32, i32)) -> Result<(), PlotError> {
    let end = x + units(SIGN);
    let middle = (x + units(0.5 * SIGN), y);
    let line = |colour: ShapeStyle| PathElement::new(vec![(x, y), (end, y)], colour);
    match sign {
        Sign::Curve(i) => area.draw(&line(style(i).colour.stroke_width(units(LINE) as u32))),
        Sign::Limit => area.draw(&line(LIMIT.stroke_width(units(1.0) as u32))),
        Sign::Dot => area.draw(&Circle::new(middle, units(3.2), INK.filled())),
        Sign::Ring => area.draw(&Circle::new(middle, units(3.2), INK.stroke_width(units(1.3) as u32))),
        Sign::Shade(shade) => {
            let colour = if shade == Shade::Impact { IMPACT } else { FREE };
            let corners = [(x, y - units(5.5)), (end, y + units(5.5))];
            area.draw(&Rectangle::new(corners, colour.filled()))
                .and_then(|()| area.draw(&Rectangle::new(corners, GRID.stroke_width(units(0.6) as u32))))
        }
    }
    .map_err(draw_error)
}
