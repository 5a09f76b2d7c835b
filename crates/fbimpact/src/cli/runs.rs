//! Arguments of commands that run scenarios.

use std::path::PathBuf;

use clap::Args;
use clap::builder::TypedValueParser;

use super::{CacheArguments, LengthUnit, SectionModel, SetArguments, positive, tolerance};
use crate::studies::orientations::{Ground, Toward};

/// Arguments of `run`.
#[derive(Debug, Args)]
pub struct RunArguments {
    /// Scenario file
    #[arg(value_name = "SCENARIO.toml", required_unless_present = "resume")]
    pub scenario: Option<PathBuf>,
    /// Result file [default: the scenario's name with .h5, in the working directory]
    #[arg(short, long, value_name = "OUT.h5")]
    pub output: Option<PathBuf>,
    /// Changes to the scenario.
    #[command(flatten)]
    pub set: SetArguments,
    /// Number of threads, 0 for all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Memory that the run may take in GB [default: most of what the machine has]; models that do
    /// not fit are refused before they are built
    #[arg(long, value_name = "GB", value_parser = positive)]
    pub memory: Option<f64>,
    /// Let an incomplete result, too, replace an existing file, even one that is no result file
    #[arg(long)]
    pub force: bool,
    /// Do nothing if the output is complete and of this very scenario, the files that it names and
    /// this program; go on with a run of them that was interrupted or killed
    #[arg(long, conflicts_with = "resume")]
    pub update: bool,
    /// With --update: only ask; exit code 1 if there is something to do
    #[arg(long, requires = "update")]
    pub dry_run: bool,
    /// Go on with the run that was to write this file, and was interrupted or killed
    #[arg(long, value_name = "OUT.h5", conflicts_with_all = ["scenario", "output", "set"])]
    pub resume: Option<PathBuf>,
    /// Stop as if interrupted when standard input ends, which it does with the process that started
    /// this one
    #[arg(long, hide = true)]
    pub until_eof: bool,
    /// Models kept between runs.
    #[command(flatten)]
    pub cache: CacheArguments,
}

/// Arguments of `static`.
#[derive(Debug, Args)]
pub struct StaticArguments {
    /// Scenario file
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// Result file, with this one state [default: the scenario's name with .static.h5, in the working
    /// directory]
    #[arg(short, long, value_name = "OUT.h5")]
    pub output: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Changes to the scenario.
    #[command(flatten)]
    pub set: SetArguments,
    /// Number of threads, 0 for all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Memory that it may take in GB [default: most of what the machine has]; models that do not fit are
    /// refused before they are built
    #[arg(long, value_name = "GB", value_parser = positive)]
    pub memory: Option<f64>,
    /// Replace an existing file, even one that is no result file
    #[arg(long)]
    pub force: bool,
    /// Models kept between runs.
    #[command(flatten)]
    pub cache: CacheArguments,
}

/// What a part from a file is.
#[derive(Debug, Clone, Args)]
pub struct PartArguments {
    /// Unit of length of a mesh, which its file does not say; shapes are read in mm
    #[arg(long, value_name = "UNIT")]
    pub units: Option<LengthUnit>,
    /// The part of the mesh that is the body, where it has several
    #[arg(long, value_name = "NAME")]
    pub part: Option<String>,
    /// Name of its material, such as steel, aluminium or glass (docs/scenario.md)
    #[arg(long, value_name = "NAME", default_value = "steel")]
    pub material: String,
    /// Longest side of the elements of a shape in mm [default: a twelfth of its diagonal]
    #[arg(long, value_name = "MM", value_parser = positive)]
    pub size: Option<f64>,
}

/// Arguments of `drop`.
#[derive(Debug, Args)]
pub struct DropArguments {
    /// A mesh or a shape (STEP), which falls on a rigid floor, or a scenario in which a body falls on
    /// something
    #[arg(value_name = "PART|SCENARIO.toml")]
    pub file: PathBuf,
    /// Height of the fall in metres
    #[arg(long, value_name = "M", value_parser = positive)]
    pub height: f64,
    /// Parts of the box around the body that are turned down, some of faces, edges and corners, or a
    /// number of directions spread over the sphere
    #[arg(long, value_name = "PARTS|N", default_value = "faces,edges,corners")]
    pub toward: Toward,
    /// A point of the body in metres, in the axes of its file, at which acceleration and stress are
    /// observed; may be repeated
    #[arg(long, value_name = "[NAME=]X,Y,Z", allow_hyphen_values = true)]
    pub at: Vec<PointAt>,
    /// What a part falls on: rigid, or a layer of a material on rigid ground with its thickness in
    /// metres, as aluminium:0.01; the floor of a scenario stands in it [default: rigid]
    #[arg(long, value_name = "rigid|MATERIAL:M")]
    pub on: Option<Ground>,
    /// Kinematics of a mesh of triangles or quadrilaterals in the plane z = 0
    #[arg(long, value_name = "MODEL")]
    pub section: Option<SectionModel>,
    /// What the part is
    #[command(flatten)]
    pub part: PartArguments,
    /// Folder of the runs and of their report, created if it does not exist; what it holds is not run
    /// again [default: the part's name with .drop, in the working directory]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Leave out the reports of the single runs
    #[arg(long)]
    pub no_reports: bool,
    /// Changes to the scenario.
    #[command(flatten)]
    pub set: SetArguments,
    /// How the runs are made.
    #[command(flatten)]
    pub runs: RunsArguments,
}

/// A point with a name.
#[derive(Debug, Clone, PartialEq)]
pub struct PointAt {
    /// Name; none if it is called by its number.
    pub name: Option<String>,
    /// Coordinates \[m\].
    pub point: [f64; 3],
}

impl std::str::FromStr for PointAt {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, point) = match text.split_once('=') {
            Some((name, point)) => (Some(name.trim().to_owned()), point),
            None => (None, text),
        };
        let numbers: Option<Vec<f64>> =
            point.split(',').map(|x| x.trim().parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let point = numbers.and_then(|numbers| numbers.try_into().ok());
        point
            .map(|point| Self { name, point })
            .ok_or_else(|| "must be X,Y,Z in metres, or NAME=X,Y,Z".to_owned())
    }
}

/// Arguments of `converge`.
#[derive(Debug, Args)]
pub struct ConvergeArguments {
    /// Scenario file
    #[arg(value_name = "SCENARIO.toml")]
    pub scenario: PathBuf,
    /// Largest relative change with which a result counts as converged
    #[arg(long, value_name = "R", default_value_t = 0.01, value_parser = tolerance)]
    pub tolerance: f64,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Folder of the runs, created if it does not exist; what it holds is not run again [default:
    /// the scenario's name with .converge, in the working directory]
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Changes to the scenario.
    #[command(flatten)]
    pub set: SetArguments,
    /// How the runs are made.
    #[command(flatten)]
    pub runs: RunsArguments,
}

/// How many runs are made.
#[derive(Debug, Args)]
pub struct RunsArguments {
    /// Number of threads of all runs together, 0 for all cores
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub threads: usize,
    /// Memory that all runs together may take in GB [default: most of what the machine has]; models
    /// that do not fit are refused before they are built
    #[arg(long, value_name = "GB", value_parser = positive)]
    pub memory: Option<f64>,
    /// Runs at a time, at most; fewer need less memory [default: as many as threads]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..).map(|n| n as usize))]
    pub jobs: Option<usize>,
    /// Models kept between runs.
    #[command(flatten)]
    pub cache: CacheArguments,
}
