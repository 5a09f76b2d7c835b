//! The figures of `plot`, as a drawing and as data that a page draws and zooms.

use std::collections::HashMap;

use result_files::file::fault::FileFault;
use result_files::plot::curve::thin::thinned;
use result_files::plot::data::ResultData;
use result_files::plot::figure::{Entry, Figure, Panel, Shade, Sign};
use result_files::plot::figures::Kind;
use result_files::plot::render;
use result_files::plot::render::axis::Scale;
use result_files::plot::theme::{Page, style};
use serde_json::{Value, json};

use super::encode::{Array, Blob};
use super::html::escaped;
use crate::error::AppError;

/// Divisions that labels are made for; a page makes its own.
const DIVISIONS: usize = 6;
/// Bits of ordinates.
const BITS: u32 = 16;
/// Parts of a curve of a drawing that are told apart: what stands where there are no scripts, and
/// on paper.
const COLUMNS: usize = 220;
/// Name of the blob.
const BLOB: &str = "charts";

/// Figures of a report.
#[derive(Debug, Default)]
pub struct Charts {
    /// Their places in the page, each with its drawing.
    pub html: String,
    /// What the page draws.
    pub data: Vec<Value>,
    /// Numbers of the curves.
    pub blob: Blob,
}

/// The figures of `files` that have something to show.
///
/// # Errors
/// [`AppError::Io`] if one cannot be drawn.
pub fn charts(files: &[ResultData]) -> Result<Charts, AppError> {
    let mut charts = Charts { blob: Blob::new(BLOB.into()), ..Charts::default() };
    let mut abscissas = HashMap::new();
    for kind in Kind::USUAL {
        // What has no data has no figure.
        for figure in kind.figures(files).unwrap_or_default() {
            let number = charts.data.len();
            let svg = render::svg(&small(&figure), Page::default())
                .map_err(|e| AppError::io(format!("figure {}", figure.name), FileFault::contents(e)))?;
            let is_live = figure.panels.iter().all(|panel| panel.dots.is_empty());
            let class = if is_live { "live" } else { "still" };
            charts.html += &format!(
                "<figure class=\"{class}\" id=\"figure-{number}\"><figcaption>{}</figcaption><div class=\"drawing\">{svg}</div></figure>\n",
                escaped(&figure.title)
            );
            let panels: Vec<Value> = match is_live {
                true => figure.panels.iter().map(|p| charts.panel(p, &mut abscissas)).collect(),
                false => Vec::new(),
            };
            let legend: Vec<Value> = figure.legend.iter().map(legend).collect();
            charts.data.push(json!({
                "name": figure.name, "columns": figure.columns, "panels": panels, "legend": legend,
            }));
        }
    }
    Ok(charts)
}

/// `figure` with curves that a drawing of a page shows.
fn small(figure: &Figure) -> Figure {
    let mut figure = figure.clone();
    let curves = figure.panels.iter_mut().flat_map(|panel| &mut panel.curves);
    for curve in curves.filter(|curve| curve.marks.is_empty()) {
        (curve.x, curve.y) = thinned(&curve.x, &curve.y, COLUMNS);
    }
    figure
}

fn legend(entry: &Entry) -> Value {
    let sign = match entry.sign {
        Sign::Curve(i) => return json!({ "sign": "curve", "style": pen(i), "label": entry.label }),
        Sign::Shade(Shade::Impact) => "impact",
        Sign::Shade(Shade::Free) => "free",
        Sign::Dot => "dot",
        Sign::Ring => "ring",
        Sign::Limit => "limit",
    };
    json!({ "sign": sign, "label": entry.label })
}

/// Colour and dashes of the style `i`.
fn pen(i: usize) -> Value {
    let style = style(i);
    let colour = style.colour;
    json!({ "colour": format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2), "dashes": style.dashes })
}

impl Charts {
    fn panel(&mut self, panel: &Panel, abscissas: &mut HashMap<Vec<u64>, Array>) -> Value {
        let x = Scale::new(&panel.x, panel.curves.iter().flat_map(|c| &c.x), DIVISIONS);
        let ordinates = panel.curves.iter().flat_map(|c| &c.y).chain(&panel.limits);
        let y = Scale::new(&panel.y, ordinates, DIVISIONS);
        let place = |scale: &Scale, v: f64| scale.at(v).unwrap_or(f64::NAN);
        let curves: Vec<Value> = panel
            .curves
            .iter()
            .map(|curve| {
                let xs: Vec<f64> = curve.x.iter().map(|v| place(&x, *v)).collect();
                let ys: Vec<f64> = curve.y.iter().map(|v| place(&y, *v)).collect();
                // Most curves of a result share their instants.
                let key: Vec<u64> = xs.iter().map(|v| v.to_bits()).collect();
                let xs = abscissas.entry(key).or_insert_with(|| self.blob.finely(&xs)).clone();
                let ys = self.blob.quantised_range(&ys, BITS);
                json!({ "style": pen(curve.style), "x": xs, "y": ys, "marks": curve.marks })
            })
            .collect();
        let bands = panel.bands.iter().filter_map(|(from, to, shade)| {
            let kind = if *shade == Shade::Impact { "impact" } else { "free" };
            Some(json!([x.at(*from)?, x.at(*to)?, kind]))
        });
        let axis = |scale: &Scale, is_log: bool| json!({ "label": scale.label, "range": [scale.range.0, scale.range.1], "log": is_log });
        let (mut abscissa, ordinate) = (axis(&x, panel.x.is_log), axis(&y, panel.y.is_log));
        abscissa["ticks"] = json!(panel.x.ticks);
        // Where a second and the time zero lie, for times.
        abscissa["second"] = json!(x.at(1.0).zip(x.at(0.0)).map(|(a, b)| [b, a - b]));
        json!({
            "title": panel.title,
            "x": abscissa,
            "y": ordinate,
            "curves": curves,
            "bands": bands.collect::<Vec<Value>>(),
            "limits": panel.limits.iter().filter_map(|v| y.at(*v)).collect::<Vec<f64>>(),
        })
    }
}
