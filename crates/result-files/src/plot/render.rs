//! Draws a figure as SVG.

pub mod axis;
mod colours;
mod text;
mod dots;
mod legend;

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, ChartContext, LabelAreaPosition};
use plotters::drawing::IntoDrawingArea;
use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::prelude::{Cartesian2d, Ranged};
use plotters::style::{Color, TRANSPARENT, WHITE};

use super::PlotError;
use axis::Scale;

use super::curve::envelope::{Piece, pieces};
use super::figure::{Figure, Panel, Shade};

use super::theme::{
    FREE, GRID, IMPACT, INK, LIMIT, LINE, PANEL_HEIGHT, Page, SMALL_PANEL_HEIGHT, TEXT, TITLE, UNITS, style,
    tint, units, with_dashes,
};
use text::{Area, FONT_READY, broken, draw_error, text_style, width as width_of};

/// Length of division marks, and distance of labels from them \[px\].
const TICK: f64 = 4.0;
const PAD: f64 = 4.0;
/// Height of the title, of the labels below a panel, of its words in addition, and of the space
/// above it \[px\].
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
/// Height of the axes over their width at most, of a panel that stands alone and of one of several.
const TALLEST: f64 = 0.66;
const TALLEST_OF_SEVERAL: f64 = 0.6;
/// Room that the labels of an axis of ordinates take, as far as the height of panels depends on it
/// \[px\].
const Y_LABELS: f64 = 60.0;
/// Least distance of neighbouring labels of an axis \[px\].
const APART: f64 = 8.0;

/// A panel with the scales of its axes.
struct Scaled<'a> {
    panel: &'a Panel,
    x: Scale,
    y: Scale,
    /// What stands above the axes.
    heading: Vec<String>,
    /// Words along the axis of ordinates; empty where they stand above.
    y_words: String,
}

/// Sizes that all panels of a figure have in common, in units.
#[derive(Clone, Copy)]
struct Frame {
    width: i32,
    height: i32,
    /// Room left of the axes.
    left: i32,
}

impl<'a> Scaled<'a> {
    fn new(panel: &'a Panel, columns: usize, is_small: bool) -> Self {
        let ordinates = panel.curves.iter().flat_map(|c| &c.y).chain(&panel.limits);
        let ordinates = ordinates.chain(panel.dots.iter().map(|d| &d.y));
        let y = Scale::new(&panel.y, ordinates, if is_small { 4 } else { 6 });
        let y_words = y.label.clone();
        Self { panel, x: Self::x_scale(panel, 8 / columns.max(1)), y, heading: Vec::new(), y_words }
    }

    /// The scale of the abscissas with about `wanted` divisions.
    fn x_scale(panel: &Panel, wanted: usize) -> Scale {
        let abscissas = panel.curves.iter().flat_map(|c| &c.x).chain(panel.dots.iter().map(|d| &d.x));
        Scale::new(&panel.x, abscissas, wanted)
    }

    /// Takes fewer divisions of the axis of abscissas until their labels stand apart in a `frame`,
    /// and puts words that are too long for the axis of ordinates above it.
    fn fit(&mut self, area: &Area<'_>, frame: Frame) -> Result<(), PlotError> {
        let is_map = self.panel.colours.is_some();
        let right = if is_map { dots::BAR } else { RIGHT };
        let along = frame.width - frame.left - units(EDGE + right);
        let mut wanted = self.x.ticks.len();
        while wanted > 1 && !stand_apart(area, &self.x, along)? {
            wanted -= 1;
            self.x = Self::x_scale(self.panel, wanted);
            if self.panel.x.ticks.is_some() {
                self.x.keep_some(wanted);
            }
        }
        let up = frame.height - units(ABOVE_PANEL);
        let mut words = self.panel.title.clone();
        if !is_map && width_of(area, &self.y.label, TEXT)? > up {
            words =
                if words.is_empty() { self.y.label.clone() } else { format!("{words}: {}", self.y.label) };
            self.y_words.clear();
        }
        self.heading = broken(area, &words, TEXT, frame.width - frame.left - units(2.0 * EDGE))?;
        Ok(())
    }
}

/// Whether no two labels of `scale` touch on an axis that is `length` long.
fn stand_apart(area: &Area<'_>, scale: &Scale, length: i32) -> Result<bool, PlotError> {
    let (low, high) = scale.range;
    let mut end = f64::NEG_INFINITY;
    for (at, label) in &scale.ticks {
        let middle = (at - low) / (high - low) * f64::from(length);
        let half = 0.5 * f64::from(width_of(area, label, TEXT)?);
        if middle - half < end {
            return Ok(false);
        }
        end = middle + half + f64::from(units(APART));
    }
    Ok(true)
}

/// Height of a panel with a width, without its words \[px\].
fn panel_height(width: f64, has_map: bool, is_small: bool) -> f64 {
    let (most, part) = match (has_map, is_small) {
        (true, _) => (PANEL_HEIGHT, 1.0),
        (false, true) => (SMALL_PANEL_HEIGHT, TALLEST_OF_SEVERAL),
        (false, false) => (PANEL_HEIGHT, TALLEST),
    };
    let right = if has_map { dots::BAR } else { RIGHT };
    let title = if has_map { PANEL_TITLE } else { 0.0 };
    let axes = part * (width - Y_LABELS - EDGE - right);
    f64::from(most).min(axes + X_LABELS + ABOVE_PANEL + title)
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
    let px = |n: i32| f64::from(n) / f64::from(UNITS);
    let height = units(panel_height(px(width / columns as i32), has_map, is_small));
    let mut out = String::new();
    let (title, flow, scaled, frame) = {
        // Text is measured before the height is known.
        let mut scratch = String::new();
        let area = SVGBackend::with_string(&mut scratch, (width as u32, width as u32)).into_drawing_area();
        let most = width - units(24.0);
        let title = if page.has_title { broken(&area, &figure.title, TITLE, most)? } else { Vec::new() };
        let (scaled, frame) = fitted(&area, figure, columns, (width / columns as i32, height, is_small))?;
        (title, legend::flow(&area, &figure.legend, width)?, scaled, frame)
    };
    let panel_height = frame.height;
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
        panels(&root, &scaled, columns, (above + flow.height, frame))?;
        root.present().map_err(draw_error)?;
    }
    Ok(with_dashes(&sized(&out, width, height)))
}

/// The drawing with its size in pixels; coordinates stay in units.
fn sized(svg: &str, width: i32, height: i32) -> String {
    let px = |n: i32| f64::from(n) / f64::from(UNITS);
    let library = format!("width=\"{width}\" height=\"{height}\"");
    svg.replacen(&library, &format!("width=\"{}\" height=\"{}\"", px(width), px(height)), 1)
}

/// The panels of `figure` in frames of a width and height, which grows by what stands above the
/// axes in more than one line.
fn fitted<'a>(
    area: &Area<'_>,
    figure: &'a Figure,
    columns: usize,
    (width, height, is_small): (i32, i32, bool),
) -> Result<(Vec<Scaled<'a>>, Frame), PlotError> {
    let mut scaled: Vec<Scaled<'_>> =
        figure.panels.iter().map(|p| Scaled::new(p, columns, is_small)).collect();
    let mut widest = 0;
    for (_, label) in scaled.iter().flat_map(|s| &s.y.ticks) {
        widest = widest.max(width_of(area, label, TEXT)?);
    }
    // Marks, labels, words along the axis.
    let left = widest + units(TICK + PAD + 2.0 * TEXT);
    let mut frame = Frame { width, height, left };
    for s in &mut scaled {
        s.fit(area, frame)?;
    }
    let lines = scaled.iter().map(|s| s.heading.len()).max().unwrap_or(0);
    frame.height += units(PANEL_TITLE) * lines.saturating_sub(1) as i32;
    Ok((scaled, frame))
}

fn panels(
    root: &Area<'_>,
    scaled: &[Scaled<'_>],
    columns: usize,
    (top, frame): (i32, Frame),
) -> Result<(), PlotError> {
    let Frame { width, height, left } = frame;
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
    let title_height = PANEL_TITLE * s.heading.len().max(usize::from(is_map)) as f64;
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
        .y_desc(s.y_words.as_str())
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
    for (line, words) in s.heading.iter().enumerate() {
        let at = (units(EDGE) + left, units(ABOVE_PANEL - 4.0 + line as f64 * PANEL_TITLE) + top - above);
        area.draw_text(words, &text_style(TEXT), at).map_err(draw_error)?;
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
        let (across, up) = chart.plotting_area().dim_in_pixel();
        let pixel = |range: (f64, f64), n: u32| (range.1 - range.0) * f64::from(UNITS) / f64::from(n);
        let size = (pixel(s.x.range, across), pixel(s.y.range, up));
        // A value that is not finite interrupts the curve.
        for part in all.split(Option::is_none) {
            let part: Vec<(f64, f64)> = part.iter().flatten().copied().collect();
            for piece in pieces(&part, size) {
                match piece {
                    Piece::Line(points) if points.len() > 1 => {
                        chart.draw_series([PathElement::new(points, line)]).map_err(draw_error)?;
                    }
                    Piece::Line(_) => {}
                    Piece::Band { low, high } => {
                        let outline = high.iter().chain(low.iter().rev()).copied().collect::<Vec<_>>();
                        let fill = tint(colour).filled();
                        chart.draw_series([Polygon::new(outline, fill)]).map_err(draw_error)?;
                        for edge in [low, high] {
                            chart.draw_series([PathElement::new(edge, line)]).map_err(draw_error)?;
                        }
                    }
                }
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
