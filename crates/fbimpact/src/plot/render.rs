//! Draws a figure as SVG.

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::drawing::IntoDrawingArea;
use plotters::element::{Circle, PathElement, Rectangle};
use plotters::prelude::{Cartesian2d, Ranged};
use plotters::style::{Color, TRANSPARENT, WHITE};

use super::PlotError;
use super::axis::Scale;
use super::dots;
use super::figure::{Figure, Panel, Shade};
use super::legend::{self, Area};
use super::text::{FONT_READY, draw_error, text_style};
use super::theme::{
    FREE, GRID, IMPACT, INK, LIMIT, LINE, PANEL_HEIGHT, Page, SMALL_PANEL_HEIGHT, TEXT, TITLE, UNITS, style,
    units, with_dashes,
};

/// Length of division marks, and distance of labels from them \[px\].
const TICK: f64 = 4.0;
const PAD: f64 = 4.0;
/// Height of the title, of the labels below a panel, of its words in addition, and of the space above it \[px\].
const TITLE_HEIGHT: f64 = 28.0;
const X_LABELS: f64 = 22.0;
const X_WORDS: f64 = 22.0;
const ABOVE_PANEL: f64 = 12.0;
/// Height of the title of a panel, which stands above its axes \[px\].
const PANEL_TITLE: f64 = 16.0;
/// Room at the left and lower edge of the figure \[px\].
const EDGE: f64 = 8.0;
/// Room right of a panel for half a label \[px\].
const RIGHT: f64 = 24.0;
/// Panels stand side by side if each has this width \[px\].
const NARROWEST: f64 = 250.0;

/// A panel with the scales of its axes.
struct Scaled<'a> {
    panel: &'a Panel,
    x: Scale,
    y: Scale,
}

impl<'a> Scaled<'a> {
    fn new(panel: &'a Panel, columns: usize, is_small: bool) -> Self {
        let abscissas = panel.curves.iter().flat_map(|c| &c.x).chain(panel.dots.iter().map(|d| &d.x));
        let x = Scale::new(&panel.x, abscissas, 8 / columns.max(1));
        let ordinates = panel.curves.iter().flat_map(|c| &c.y).chain(&panel.limits);
        let ordinates = ordinates.chain(panel.dots.iter().map(|d| &d.y));
        Self { panel, x, y: Scale::new(&panel.y, ordinates, if is_small { 4 } else { 6 }) }
    }
}

/// The drawing of `figure` on `page`.
///
/// # Errors
/// [`PlotError::Draw`] if the drawing library refuses.
pub fn svg(figure: &Figure, page: Page) -> Result<String, PlotError> {
    if !*FONT_READY {
        return Err(PlotError::Draw("the embedded font is not readable".into()));
    }
    let width = page.units();
    let columns = figure.columns.clamp(1, (width / units(NARROWEST)).max(1) as usize);
    let rows = figure.panels.len().div_ceil(columns);
    let has_map = figure.panels.iter().any(|panel| panel.colours.is_some());
    let is_small = rows > 1 && !has_map;
    let panel_height = units(f64::from(if is_small { SMALL_PANEL_HEIGHT } else { PANEL_HEIGHT }));
    let mut out = String::new();
    let (title, flow) = {
        // Text is measured before the height is known.
        let mut scratch = String::new();
        let area = SVGBackend::with_string(&mut scratch, (width as u32, width as u32)).into_drawing_area();
        let title = if page.has_title { broken(&area, &figure.title, width)? } else { Vec::new() };
        (title, legend::flow(&area, &figure.legend, width)?)
    };
    let above = if title.is_empty() { units(EDGE) } else { title.len() as i32 * units(TITLE_HEIGHT) };
    let height = above + flow.height + rows as i32 * panel_height + units(X_WORDS + EDGE);
    {
        let root = SVGBackend::with_string(&mut out, (width as u32, height as u32)).into_drawing_area();
        root.fill(&WHITE).map_err(draw_error)?;
        for (row, line) in title.iter().enumerate() {
            let at = (units(12.0), row as i32 * units(TITLE_HEIGHT) + units(7.0));
            root.draw_text(line, &text_style(TITLE), at).map_err(draw_error)?;
        }
        legend::draw(&root, &figure.legend, &flow, above)?;
        panels(&root, figure, (columns, is_small), (above + flow.height, panel_height, width))?;
        root.present().map_err(draw_error)?;
    }
    Ok(with_dashes(&sized(&out, width, height)))
}

/// The title in lines that fit the width `width` in units; a word that does not has a line of its own.
fn broken(area: &legend::Area<'_>, title: &str, width: i32) -> Result<Vec<String>, PlotError> {
    let mut lines: Vec<String> = Vec::new();
    for word in title.split_whitespace() {
        let longer = lines.last().map(|line| format!("{line} {word}"));
        let fits = match &longer {
            Some(line) => {
                let (taken, _) = area.estimate_text_size(line, &text_style(TITLE)).map_err(draw_error)?;
                taken as i32 <= width - units(24.0)
            }
            None => false,
        };
        match (longer, lines.last_mut()) {
            (Some(longer), Some(last)) if fits => *last = longer,
            _ => lines.push(word.to_owned()),
        }
    }
    Ok(lines)
}

/// The drawing with its size in pixels; coordinates stay in units.
fn sized(svg: &str, width: i32, height: i32) -> String {
    let px = |n: i32| f64::from(n) / f64::from(UNITS);
    let library = format!("width=\"{width}\" height=\"{height}\"");
    svg.replacen(&library, &format!("width=\"{}\" height=\"{}\"", px(width), px(height)), 1)
}

fn panels(
    root: &Area<'_>,
    figure: &Figure,
    (columns, is_small): (usize, bool),
    (top, height, width): (i32, i32, i32),
) -> Result<(), PlotError> {
    let scaled: Vec<Scaled<'_>> = figure.panels.iter().map(|p| Scaled::new(p, columns, is_small)).collect();
    let mut widest = 0;
    for (_, label) in scaled.iter().flat_map(|s| &s.y.ticks) {
        let (width, _) = root.estimate_text_size(label, &text_style(TEXT)).map_err(draw_error)?;
        widest = widest.max(width as i32);
    }
    // Marks, labels, words along the axis.
    let left = widest + units(TICK + PAD + 2.0 * TEXT);
    let width = width / columns as i32;
    for (i, s) in scaled.iter().enumerate() {
        let (row, column) = (i / columns, i % columns);
        // The last panel of a column carries the words of its axis.
        let is_last = i + columns >= scaled.len();
        let (x, y) = (column as i32 * width, top + row as i32 * height);
        let extra = if is_last { units(X_WORDS) } else { 0 };
        let area = root.clone().shrink((x, y), (width as u32, (height + extra) as u32));
        draw_panel(&area, s, left, is_last)?;
    }
    Ok(())
}

fn draw_panel(area: &Area<'_>, s: &Scaled<'_>, left: i32, has_words: bool) -> Result<(), PlotError> {
    let is_map = s.panel.colours.is_some();
    // The bar of a map has its words at the height of the title.
    let title_height = if s.panel.title.is_empty() && !is_map { 0.0 } else { PANEL_TITLE };
    let x_labels = X_LABELS + if has_words { X_WORDS } else { 0.0 };
    let above = units(ABOVE_PANEL + title_height);
    let (width, height) = area.dim_in_pixel();
    let (from, bottom) = (units(EDGE) + left, height as i32 - units(x_labels));
    let (right, top) = if is_map {
        // Both directions to one scale.
        let side = (width as i32 - from - units(dots::BAR)).min(bottom - above);
        (width as i32 - from - side, bottom - side)
    } else {
        (units(RIGHT), above)
    };
    let mut chart = ChartBuilder::on(area)
        .margin_top(top)
        .margin_left(units(EDGE))
        .margin_right(right)
        .set_label_area_size(LabelAreaPosition::Left, left)
        .set_label_area_size(LabelAreaPosition::Bottom, units(x_labels))
        .build_cartesian_2d(s.x.clone(), s.y.clone())
        .map_err(draw_error)?;
    bands(&mut chart, s)?;
    chart
        .configure_mesh()
        .axis_style(INK.stroke_width(units(0.8) as u32))
        .bold_line_style(GRID.stroke_width(units(0.7) as u32))
        .max_light_lines(0)
        .light_line_style(TRANSPARENT)
        .x_labels(1000)
        .y_labels(1000)
        .x_desc(if has_words { s.x.label.as_str() } else { "" })
        .y_desc(s.y.label.as_str())
        .label_style(text_style(TEXT))
        .axis_desc_style(text_style(TEXT))
        .set_all_tick_mark_size(units(TICK))
        .draw()
        .map_err(draw_error)?;
    for limit in s.panel.limits.iter().filter_map(|y| s.y.at(*y)) {
        let line = PathElement::new(
            vec![(s.x.range.0, limit), (s.x.range.1, limit)],
            LIMIT.stroke_width(units(1.0) as u32),
        );
        chart.draw_series([line]).map_err(draw_error)?;
    }
    curves(&mut chart, s)?;
    dots::draw(&mut chart, s.panel, (&s.x, &s.y))?;
    dots::bar(area, s.panel, width as i32 - right, (top, bottom))?;
    if !s.panel.title.is_empty() {
        let at = (units(EDGE) + left, units(ABOVE_PANEL - 4.0) + top - above);
        area.draw_text(&s.panel.title, &text_style(TEXT), at).map_err(draw_error)?;
    }
    Ok(())
}

type Chart<'a, 'b, X, Y> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<X, Y>>;

fn bands<X, Y>(chart: &mut Chart<'_, '_, X, Y>, s: &Scaled<'_>) -> Result<(), PlotError>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    for &(from, to, shade) in &s.panel.bands {
        let colour = if shade == Shade::Impact { IMPACT } else { FREE };
        let (low, high) = s.x.range;
        let (Some(from), Some(to)) = (s.x.at(from), s.x.at(to)) else { continue };
        let (from, to) = (from.clamp(low, high), to.clamp(low, high));
        let corners = [(from, s.y.range.0), (to, s.y.range.1)];
        chart.draw_series([Rectangle::new(corners, colour.filled())]).map_err(draw_error)?;
    }
    Ok(())
}

fn curves<X, Y>(chart: &mut Chart<'_, '_, X, Y>, s: &Scaled<'_>) -> Result<(), PlotError>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    // Late curves lie on top: what coincides with an early one shows it in the gaps of its dashes.
    for curve in &s.panel.curves {
        let colour = style(curve.style).colour;
        let line = colour.stroke_width(units(LINE) as u32);
        let at = |(x, y): (&f64, &f64)| Some((s.x.at(*x)?, s.y.at(*y)?));
        let all: Vec<Option<(f64, f64)>> = curve.x.iter().zip(&curve.y).map(at).collect();
        // A value that is not finite interrupts the curve.
        for part in all.split(Option::is_none) {
            let part: Vec<(f64, f64)> = part.iter().flatten().copied().collect();
            if part.len() > 1 {
                chart.draw_series([PathElement::new(part, line)]).map_err(draw_error)?;
            }
        }
        let marks = all.iter().zip(&curve.marks).filter_map(|(at, filled)| at.map(|at| (at, *filled)));
        for (at, is_filled) in marks {
            chart.draw_series([Circle::new(at, units(3.2), WHITE.filled())]).map_err(draw_error)?;
            let mark = if is_filled { colour.filled() } else { colour.stroke_width(units(1.3) as u32) };
            chart.draw_series([Circle::new(at, units(3.2), mark)]).map_err(draw_error)?;
        }
    }
    Ok(())
}
