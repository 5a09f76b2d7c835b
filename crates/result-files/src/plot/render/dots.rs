//! Dots of a panel, and the bar that explains their colours.

use plotters::backend::SVGBackend;
use plotters::chart::ChartContext;
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::prelude::{Cartesian2d, Ranged};
use plotters::style::Color;

use super::axis::Scale;
use super::colours::colour;
use super::text::{Area, draw_error, text_style};
use crate::plot::PlotError;
use crate::plot::figure::Panel;
use crate::plot::theme::{INK, TEXT, style, units};

/// Smallest radius \[px\].
const SMALLEST: f64 = 1.6;
/// Distance of the bar from its panel, its width, and room for its labels \[px\].
const GAP: f64 = 12.0;
const WIDTH: f64 = 12.0;
const LABELS: f64 = 44.0;
/// Room right of a panel for its bar \[px\].
pub const BAR: f64 = GAP + WIDTH + LABELS;
/// Rectangles that the bar is made of.
const STEPS: i32 = 128;

/// Draws the dots of `panel`; lowest values first, so that high ones are not hidden.
pub fn draw<X, Y>(
    chart: &mut ChartContext<'_, SVGBackend<'_>, Cartesian2d<X, Y>>,
    panel: &Panel,
    (x, y): (&Scale, &Scale),
) -> Result<(), PlotError>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    let shades = panel.colours.as_ref().map(|axis| Scale::new(axis, panel.dots.iter().map(|d| &d.value), 5));
    let (pixels, _) = chart.plotting_area().dim_in_pixel();
    let unit = f64::from(pixels) / (x.range.1 - x.range.0);
    let mut dots = panel.dots.clone();
    dots.sort_by(|a, b| a.value.total_cmp(&b.value));
    for dot in dots {
        let (Some(at), Some(up)) = (x.at(dot.x), y.at(dot.y)) else { continue };
        let radius = x.length(dot.radius) * unit;
        let radius = (radius.round() as i32).max(units(SMALLEST));
        let fill = match &shades {
            Some(scale) => scale.at(dot.value).map_or(INK, |value| colour(part(scale, value))),
            None => style(0).colour,
        };
        chart.draw_series([Circle::new((at, up), radius, fill.filled())]).map_err(draw_error)?;
    }
    Ok(())
}

fn part(scale: &Scale, value: f64) -> f64 {
    (value - scale.range.0) / (scale.range.1 - scale.range.0)
}

/// Draws the bar of `panel` right of its axes, which end at `right` and reach from `top` to
/// `bottom` in the units of `area`.
pub fn bar(area: &Area<'_>, panel: &Panel, right: i32, (top, bottom): (i32, i32)) -> Result<(), PlotError> {
    let Some(axis) = &panel.colours else { return Ok(()) };
    let scale = Scale::new(axis, panel.dots.iter().map(|d| &d.value), 5);
    let (left, end) = (right + units(GAP), right + units(GAP + WIDTH));
    let height = |part: f64| bottom - (part * f64::from(bottom - top)).round() as i32;
    for step in 0..STEPS {
        let edge = |k: i32| f64::from(k) / f64::from(STEPS);
        let middle = 0.5 * (edge(step) + edge(step + 1));
        // Each reaches over the next one: no white lines between them.
        let corners = [(left, height(edge(step))), (end, height(edge((step + 2).min(STEPS))))];
        area.draw(&Rectangle::new(corners, colour(middle).filled())).map_err(draw_error)?;
    }
    let frame = Rectangle::new([(left, top), (end, bottom)], INK.stroke_width(units(0.8) as u32));
    area.draw(&frame).map_err(draw_error)?;
    for (value, label) in &scale.ticks {
        let y = height(part(&scale, *value));
        let mark =
            PathElement::new(vec![(end, y), (end + units(3.0), y)], INK.stroke_width(units(0.8) as u32));
        area.draw(&mark).map_err(draw_error)?;
        let at = (end + units(6.0), y - units(0.5 * TEXT));
        area.draw_text(label, &text_style(TEXT), at).map_err(draw_error)?;
    }
    let (width, _) = area.estimate_text_size(&scale.label, &text_style(TEXT)).map_err(draw_error)?;
    let at = (end + units(LABELS) - width as i32, top - units(TEXT + 6.0));
    area.draw_text(&scale.label, &text_style(TEXT), at).map_err(draw_error)
}
