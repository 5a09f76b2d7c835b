//! Arguments of commands that read results.

use std::path::PathBuf;

use clap::Args;
use clap::builder::TypedValueParser;
use result_files::plot::figures::Kind;
use result_files::plot::labels::Labels;
use result_files::plot::theme::WIDTH;

use super::{CacheArguments, SetArguments, tolerance};
use crate::postprocessing::probe::places::{Coordinates, Line};
use crate::postprocessing::vtk::times::Times;

/// Arguments of `plot`.
#[derive(Debug, Args)]
pub struct PlotArguments {
    /// Result files, drawn into the same figures
    #[arg(required = true, value_name = "OUT.h5")]
    pub files: Vec<PathBuf>,
    /// Folder for the figures, created if it does not exist
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    pub output: PathBuf,
    /// Replace existing files, even those that are not of this program
    #[arg(long)]
    pub force: bool,
    /// Write SVG, for print and for the web; also if no format is named
    #[arg(long)]
    pub svg: bool,
    /// Write PNG
    #[arg(long)]
    pub png: bool,
    /// Write PDF, for LaTeX; text becomes outlines
    #[arg(long)]
    pub pdf: bool,
    /// Only figures of this kind; may be repeated
    #[arg(long, value_name = "KIND")]
    pub figure: Vec<Kind>,
    /// What legends of several results show: names of the files, or values of the scenarios that
    /// differ
    #[arg(long, value_name = "WHAT", default_value = "names")]
    pub labels: Labels,
    /// First time in seconds [default: the first stored]
    #[arg(long, value_name = "T", value_parser = finite)]
    pub from: Option<f64>,
    /// Last time in seconds [default: the last stored]
    #[arg(long, value_name = "T", value_parser = finite)]
    pub to: Option<f64>,
    /// Width of the figures in millimetres; text keeps its size
    #[arg(long, value_name = "MM", default_value_t = WIDTH, value_parser = page_width)]
    pub width: f64,
    /// Leave out the titles, for captions of one's own
    #[arg(long)]
    pub no_title: bool,
}

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportArguments {
    /// Result files, told side by side
    #[arg(required = true, value_name = "OUT.h5")]
    pub files: Vec<PathBuf>,
    /// Page, - for standard output
    #[arg(short, long, value_name = "REPORT.html", default_value = "report.html")]
    pub output: PathBuf,
    /// Replace an existing file, even one that is not of this program
    #[arg(long)]
    pub force: bool,
    /// Only these bodies in motion
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub bodies: Vec<String>,
    /// Size in megabytes, up to which bodies in motion are stored
    #[arg(long, value_name = "MB", default_value_t = 5.0, value_parser = megabytes)]
    pub max_size: f64,
    /// Leave out the bodies in motion; no models are built then
    #[arg(long, conflicts_with = "bodies")]
    pub no_3d: bool,
    /// Solve the contact zones at the peaks again however large their models are: that takes about as
    /// long and as much memory as building them took in the run
    #[arg(long, conflicts_with = "no_3d")]
    pub contact_stress: bool,
    /// How several results are called: names of the files, or values of the scenarios that differ
    #[arg(long, value_name = "WHAT", default_value = "names")]
    pub labels: Labels,
    /// Number of threads, 0 for all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Models kept between runs.
    #[command(flatten)]
    pub cache: CacheArguments,
}

/// Arguments of `export`.
#[derive(Debug, Args)]
pub struct ExportArguments {
    /// Result file, or a scenario
    #[arg(value_name = "OUT.h5|SCENARIO.toml")]
    pub file: PathBuf,
    /// Folder for the series OUT.pvd, or SCENARIO.vtm, and its VTU files, created if it does not
    /// exist
    #[arg(long, value_name = "DIR")]
    pub vtk: PathBuf,
    /// Replace existing files, even those that are not of this program
    #[arg(long)]
    pub force: bool,
    /// Factor on the elastic displacement in the drawn shape
    #[arg(long, value_name = "F", default_value_t = 1.0, allow_negative_numbers = true, value_parser = finite)]
    pub scale: f64,
    /// Write linear cells, which every reader knows, instead of exact rational Bézier cells
    #[arg(long)]
    pub plain: bool,
    /// Revolve axisymmetric bodies by so many degrees instead of writing their section
    #[arg(long, value_name = "DEGREES", num_args = 0..=1, default_missing_value = "360", value_parser = degrees)]
    pub revolve: Option<f64>,
    /// Stored states nearest to these times in seconds, or to the peak of every impact
    #[arg(long, value_name = "A:B:STEP|peak", conflicts_with = "every")]
    pub times: Option<Times>,
    /// Every N-th stored state [default: as many that at most 200 are written]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..).map(|n| n as usize))]
    pub every: Option<usize>,
    /// Only these bodies
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub bodies: Vec<String>,
    /// Film what is written as well, by pvpython of ParaView: .avi or .ogv (.mp4 on Windows), or
    /// .png for single pictures
    #[arg(long, value_name = "FILE")]
    pub movie: Option<PathBuf>,
    /// Number of threads, 0 for all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Models kept between runs.
    #[command(flatten)]
    pub cache: CacheArguments,
    /// Changes to the scenario.
    #[command(flatten)]
    pub set: SetArguments,
}

impl ExportArguments {
    /// Whether a scenario is shown, as the name of the file says, and not a result.
    pub fn is_of_scenario(&self) -> bool {
        self.file.extension().is_some_and(|ending| ending == "toml")
    }
}

/// Shown below `probe --help`.
pub(super) const PROBE_COLUMNS: &str = "\
Columns, in SI units: position; displacement from the first stored instant; velocity; deformation, the
elastic displacement in the axes of the body; stress, von Mises stress and strain in the same axes
(flexible bodies with a shape or mesh, at single points). With --modes: coordinates q1, q2, … and their
rates v1, v2, …";

/// Arguments of `probe`.
#[derive(Debug, Args)]
pub struct ProbeArguments {
    /// Result file
    #[arg(value_name = "OUT.h5")]
    pub file: PathBuf,
    /// Name of the body
    #[arg(long, value_name = "NAME")]
    pub body: String,
    /// Point of the undeformed body in metres, in the components of its model; may be repeated
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, required_unless_present_any = ["marker", "line", "modes"])]
    pub point: Vec<Coordinates>,
    /// N points at equal distances from one to another point, ends included; may be repeated
    #[arg(long, value_name = "X,Y,Z:X,Y,Z:N", allow_hyphen_values = true)]
    pub line: Vec<Line>,
    /// Point by the name of a marker; may be repeated
    #[arg(long, value_name = "NAME")]
    pub marker: Vec<String>,
    /// Elastic coordinates of the body instead
    #[arg(long, conflicts_with_all = ["point", "line", "marker"])]
    pub modes: bool,
    /// First time in seconds [default: the first stored]
    #[arg(long, value_name = "T", value_parser = finite)]
    pub from: Option<f64>,
    /// Last time in seconds [default: the last stored]
    #[arg(long, value_name = "T", value_parser = finite)]
    pub to: Option<f64>,
    /// Print CSV, a row per instant and point; also if no format is named
    #[arg(long, conflicts_with = "json")]
    pub csv: bool,
    /// Print JSON, with units
    #[arg(long)]
    pub json: bool,
    /// Number of threads, 0 for all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Models kept between runs.
    #[command(flatten)]
    pub cache: CacheArguments,
}

/// Arguments of `compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// Result to judge
    #[arg(value_name = "NEW.h5")]
    pub new: PathBuf,
    /// Result to compare with
    #[arg(value_name = "REFERENCE.h5")]
    pub reference: PathBuf,
    /// Tolerance relative to the peak of the reference's dataset [default: 1e-3]
    #[arg(long, value_name = "R", value_parser = tolerance)]
    pub rtol: Option<f64>,
    /// Absolute tolerance, in the unit of each dataset [default: 0]
    #[arg(long, value_name = "A", value_parser = tolerance)]
    pub atol: Option<f64>,
    /// Tolerances of single datasets and features (docs/compare.md)
    #[arg(long, value_name = "FILE.toml")]
    pub tolerances: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

fn megabytes(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err("must be a number > 0".into()) }
}

fn finite(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if value.is_finite() { Ok(value) } else { Err("must be finite".into()) }
}

fn degrees(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if value > 0.0 && value <= 360.0 { Ok(value) } else { Err("must be above 0 and at most 360".into()) }
}

/// Widths from a narrow column, in which axes still have room, to a poster.
fn page_width(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|e| format!("{e}"))?;
    if (60.0..=1000.0).contains(&value) { Ok(value) } else { Err("must be from 60 to 1000 mm".into()) }
}
