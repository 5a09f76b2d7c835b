//! What a figure shows, apart from how it is drawn.

use super::ticks::Tick;

/// A figure: panels in rows, a title and a legend above them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Figure {
    /// Name of its file, without the end.
    pub name: String,
    /// Title.
    pub title: String,
    /// Number of panels in each row.
    pub columns: usize,
    /// Panels, row by row.
    pub panels: Vec<Panel>,
    /// Labels of the styles used, in order.
    pub legend: Vec<Entry>,
}

/// A line of the legend.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// What it explains.
    pub sign: Sign,
    /// Words.
    pub label: String,
}

/// Sign in a legend.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Sign {
    /// A curve of a style.
    Curve(usize),
    /// A shade.
    Shade(Shade),
    /// A filled dot.
    Dot,
    /// A ring.
    Ring,
    /// A limit.
    Limit,
}

/// Shades of time spans.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shade {
    /// Impact phase.
    Impact,
    /// Free phase.
    Free,
}

/// One pair of axes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Panel {
    /// Words in its upper left corner.
    pub title: String,
    /// Horizontal axis.
    pub x: Axis,
    /// Vertical axis.
    pub y: Axis,
    /// Curves.
    pub curves: Vec<Curve>,
    /// Shaded spans of x.
    pub bands: Vec<(f64, f64, Shade)>,
    /// Horizontal limits.
    pub limits: Vec<f64>,
    /// Dots.
    pub dots: Vec<Dot>,
    /// Values of the dots: their colours are explained beside the panel, which is square then.
    pub colours: Option<Axis>,
}

/// A dot.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Dot {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
    /// Radius in the unit of the abscissa; at least that of a small mark is drawn.
    pub radius: f64,
    /// What its colour shows.
    pub value: f64,
}

/// An axis.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// What is shown.
    pub quantity: String,
    /// Its unit, SI without prefix; empty for numbers.
    pub unit: String,
    /// Whether it is logarithmic.
    pub is_log: bool,
    /// Range; without one that of the curves with some space.
    pub range: Option<(f64, f64)>,
    /// Values that the range of the curves must hold.
    pub holds: Vec<f64>,
    /// Divisions; without any they are chosen.
    pub ticks: Option<Vec<Tick>>,
}

impl Axis {
    /// A linear axis.
    pub fn new(quantity: impl Into<String>, unit: impl Into<String>) -> Self {
        Self { quantity: quantity.into(), unit: unit.into(), ..Self::default() }
    }
}

/// A curve.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve {
    /// Number of its style.
    pub style: usize,
    /// Abscissas.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
    /// Marks at its points, filled or not; none: a plain line.
    pub marks: Vec<bool>,
}

/// Curves with a legend entry each, in the styles 0, 1, ….
pub fn entries<'a>(labels: impl IntoIterator<Item = &'a str>) -> Vec<Entry> {
    let entry = |(i, label): (usize, &str)| Entry { sign: Sign::Curve(i), label: label.to_owned() };
    labels.into_iter().enumerate().map(entry).collect()
}
