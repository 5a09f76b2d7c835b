//! The command line.

use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand, ValueEnum};
use result_files::expression::named::{NamedExpression, column};

use crate::cache::{CacheSettings, DEFAULT_LIMIT};
use crate::process::provenance;
use crate::scenario::Override;

pub mod examples;
mod results;
mod runs;
pub mod tree;

use results::PROBE_COLUMNS;
pub use results::{CompareArguments, ExportArguments, PlotArguments, ProbeArguments, ReportArguments};
pub use runs::{
    ConvergeArguments, DropArguments, PartArguments, PointAt, RunArguments, RunsArguments, StaticArguments,
};

/// Impacts in flexible multibody systems.
#[derive(Debug, Parser)]
#[command(name = "fbimpact", version = provenance::VERSION, long_version = provenance::long_version())]
#[command(about, max_term_width = 100, arg_required_else_help = true)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Log and progress.
    #[command(flatten)]
    pub log: LogArguments,
}

/// Log and progress.
#[derive(Debug, Clone, Copy, Args)]
pub struct LogArguments {
    /// No progress; warnings and errors only (-qq: errors only)
    #[arg(short, long, global = true, action = clap::ArgAction::Count, conflicts_with = "verbose")]
    pub quiet: u8,
    /// More log (-vv: everything)
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    pub verbose: u8,
    /// Format of the log on standard error
    #[arg(long, global = true, value_name = "FORMAT", default_value = "text")]
    pub log_format: LogFormat,
}

/// Shown below `import-body --help`.
const IMPORT_FORMATS: &str = "\
Matrices are read as Matrix Market (coordinate real, symmetric or general), lines of row, column and
value (CalculiX .sti and .mas of *FREQUENCY, SOLVER=MATRIXSTORAGE; Abaqus FORMAT=COORDINATE), lines of
node, component, node, component and value (Abaqus FORMAT=MATRIX INPUT), or Nastran DMIG (punch file,
FILE:NAME where it has several). One triangle or both may be given.

Units: forces in newtons and times in seconds, whatever --units is; with m masses are in kilograms,
with mm in tonnes, as they are in the set N, mm, tonne, s.

Checked: symmetry to 1e-6 of the diagonal, no force against rigid motions, positive mass, markers that
follow rigid motions. The body must be free: write the matrices without supports.";

/// What `import-body` reads and writes.
#[derive(Debug, Clone, Args)]
pub struct ImportArguments {
    /// Stiffness matrix
    #[arg(long, value_name = "FILE[:NAME]")]
    pub stiffness: String,
    /// Mass matrix
    #[arg(long, value_name = "FILE[:NAME]")]
    pub mass: String,
    /// Nodes: lines of number, x, y and z, or an input file with *NODE
    #[arg(long, value_name = "FILE")]
    pub nodes: PathBuf,
    /// Order of unknowns: a line node.component for each row (CalculiX .dof); otherwise x, y and z
    /// of each node, the nodes rising
    #[arg(long, value_name = "FILE")]
    pub dof_map: Option<PathBuf>,
    /// Unit of length of nodes and matrices
    #[arg(long, value_name = "UNIT")]
    pub units: ImportUnit,
    /// Marker for joints, loads and output, which follows these nodes on average: NAME=1,2,5-9
    #[arg(long, value_name = "NAME=NODES")]
    pub marker: Vec<String>,
    /// Name of the body for messages
    #[arg(long, value_name = "NAME", default_value = "body")]
    pub name: String,
    /// Body file
    #[arg(short, long, value_name = "FILE.h5")]
    pub output: PathBuf,
    /// Replace an existing file, even one that is not of this program
    #[arg(long)]
    pub force: bool,
}

/// Unit of length of matrices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ImportUnit {
    /// N, m, kg, s.
    M,
    /// N, mm, tonne, s.
    Mm,
}

/// Format of a file of splines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SplineFormat {
    /// XML of G+Smo.
    Gismo,
    /// NURBS mesh of MFEM, version 1.0.
    Mfem,
}

/// Kinematics of a mesh in the plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SectionModel {
    /// In (x, y), a metre thick unless the scenario says otherwise.
    PlaneStrain,
    /// The same without stress out of the plane.
    PlaneStress,
    /// Round about y, x being the radius.
    Axisymmetric,
}

/// Unit of length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LengthUnit {
    /// Metres.
    M,
    /// Centimetres.
    Cm,
    /// Millimetres.
    Mm,
    /// Inches.
    In,
}

impl LengthUnit {
    /// In metres.
    pub fn metres(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Cm => 1e-2,
            Self::Mm => 1e-3,
            Self::In => 0.0254,
        }
    }
}

/// Format of the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LogFormat {
    /// Lines for people.
    Text,
    /// One JSON object a line.
    Json,
}

/// Commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Simulate a scenario and write an HDF5 file
    Run(RunArguments),
    /// Find the pose in which a scenario is in static equilibrium, contacts among it, and print forces
    /// and reactions there
    Static(StaticArguments),
    /// Run a scenario with doubled modes, meshes and contact zones, tighter integration and higher
    /// penalty factors, and compare
    Converge(ConvergeArguments),
    /// Drop a part on a floor in many orientations, side by side, and report the worst first
    Drop(DropArguments),
    /// Validate scenarios and report all faults at once
    Check {
        /// Scenario files, - for standard input
        #[arg(required = true, value_name = "SCENARIO.toml")]
        scenarios: Vec<PathBuf>,
        /// Print what a run takes as well: degrees of freedom and memory of its models, those of
        /// the first touches included, a rough time, and the size of the result
        #[arg(long)]
        cost: bool,
        /// With --cost: print JSON
        #[arg(long, requires = "cost")]
        json: bool,
        /// With --cost: number of threads, 0 for all cores
        #[arg(long, default_value_t = 0, requires = "cost", value_name = "N")]
        threads: usize,
        /// Changes to the scenarios
        #[command(flatten)]
        set: SetArguments,
    },
    /// Print eigenfrequencies and sizes of every body's reduced model, or eigenfrequencies of the
    /// assembled system
    Modes {
        /// Scenario file
        #[arg(value_name = "SCENARIO.toml")]
        scenario: PathBuf,
        /// One body only
        #[arg(long, value_name = "NAME")]
        body: Option<String>,
        /// Eigenfrequencies of the assembled system at its initial pose instead, with the bodies
        /// that take part
        #[arg(long, conflicts_with = "body")]
        system: bool,
        /// With --system: bring elastic coordinates to rest first, as `simulation.static_start`
        /// does
        #[arg(long = "static", requires = "system")]
        is_static: bool,
        /// Print JSON
        #[arg(long)]
        json: bool,
        /// Number of threads, 0 for all cores
        #[arg(long, value_name = "N", default_value_t = 0)]
        threads: usize,
        /// Where models are kept
        #[command(flatten)]
        cache: CacheArguments,
        /// Changes to the scenario
        #[command(flatten)]
        set: SetArguments,
    },
    /// Say how fine meshes are to be where they are touched, and write sizes for Gmsh
    MeshSize {
        /// Scenario file
        #[arg(value_name = "SCENARIO.toml")]
        scenario: PathBuf,
        /// Name of a body with model "mesh"; needed for -o where several are touched
        #[arg(long, value_name = "NAME")]
        body: Option<String>,
        /// Gmsh script with a field of sizes
        #[arg(short, long, value_name = "SIZES.geo")]
        output: Option<PathBuf>,
        /// Replace an existing file, even one that is not of this program
        #[arg(long)]
        force: bool,
        /// Changes to the scenario
        #[command(flatten)]
        set: SetArguments,
    },
    /// Write a body of a scenario to a body file, to be used again or by another program
    ExportBody {
        /// Scenario file
        #[arg(value_name = "SCENARIO.toml")]
        scenario: PathBuf,
        /// Name of a flexible body, with --nurbs of any body with a shape
        #[arg(long, value_name = "NAME")]
        body: String,
        /// Body file, or with --nurbs a file of splines
        #[arg(short, long, value_name = "FILE")]
        output: PathBuf,
        /// Replace an existing file, even one that is not of this program
        #[arg(long)]
        force: bool,
        /// Write the unreduced matrices instead of the reduced body
        #[arg(long)]
        full: bool,
        /// Write the exact shape instead, as splines for another program
        #[arg(long, value_name = "FORMAT", conflicts_with = "full")]
        nurbs: Option<SplineFormat>,
        /// With --nurbs: unit of length of the file
        #[arg(long, value_name = "UNIT", default_value = "m", requires = "nurbs")]
        units: LengthUnit,
        /// Number of threads, 0 for all cores
        #[arg(long, value_name = "N", default_value_t = 0)]
        threads: usize,
        /// Changes to the scenario
        #[command(flatten)]
        set: SetArguments,
    },
    /// Make a body file from stiffness and mass matrices of another finite element program
    /// (docs/body-file.md)
    #[command(after_help = IMPORT_FORMATS)]
    ImportBody(ImportArguments),
    /// Print phases, impacts, reactions of joints, energy drift and timings of a result file
    Info {
        /// Result file
        #[arg(value_name = "OUT.h5")]
        file: PathBuf,
        /// Print JSON
        #[arg(long)]
        json: bool,
        /// Refuse a file with a dataset that claims more than the file holds
        #[arg(long)]
        check: bool,
    },
    /// Compare a result with a reference: datasets, impacts, final state
    Compare(CompareArguments),
    /// Write a small copy of a result, to be kept as a reference for `compare`
    Thin {
        /// Result file
        #[arg(value_name = "OUT.h5")]
        file: PathBuf,
        /// Small copy
        #[arg(short, long, value_name = "REFERENCE.h5")]
        output: PathBuf,
        /// Number of instants to keep, at most
        #[arg(long, value_name = "N", default_value_t = 200)]
        rows: usize,
        /// Replace an existing file, even one that is no result file
        #[arg(long)]
        force: bool,
    },
    /// Gather the results of many runs in one table, also of those that failed
    Collect {
        /// Results, or folders of results
        #[arg(required = true, value_name = "DIR|FILE")]
        runs: Vec<PathBuf>,
        /// Table
        #[arg(short, long, value_name = "TABLE.csv|TABLE.h5")]
        output: PathBuf,
        /// Replace an existing file, even one that is not of this program
        #[arg(long)]
        force: bool,
        /// One more column: a number, or a row of them, over the datasets of each result
        /// (docs/expressions.md); may be repeated
        #[arg(long, value_name = "NAME=EXPRESSION", value_parser = column)]
        column: Vec<NamedExpression>,
        /// One row per impact instead of one row per run
        #[arg(long)]
        long: bool,
    },
    /// Print values of expressions over the datasets of a result, as JSON
    Metric {
        /// Result file
        #[arg(value_name = "OUT.h5")]
        file: PathBuf,
        /// Expressions, such as "max(contacts.impact.normal_force)" or "v=bodies.ball.velocity[-1]"
        /// (docs/expressions.md)
        #[arg(required = true, value_name = "[NAME=]EXPRESSION", allow_hyphen_values = true)]
        expressions: Vec<NamedExpression>,
    },
    /// Show or clear the folder of models that are kept between runs
    Cache {
        /// What to do
        #[command(subcommand)]
        action: CacheAction,
    },
    /// Write a commented scenario to start from
    New {
        /// Name of the scenario; writes NAME.toml
        name: PathBuf,
        /// What it shows
        #[arg(short, long, value_name = "TEMPLATE", default_value = "drop")]
        template: Template,
        /// A part of one's own instead, a mesh or a shape (STEP), which falls on a floor: says what
        /// is in it; a shape is meshed by Gmsh and makes NAME.msh as well
        #[arg(long, value_name = "PART", conflicts_with = "template")]
        mesh: Option<PathBuf>,
        /// Kinematics of a mesh of triangles or quadrilaterals in the plane z = 0
        #[arg(long, value_name = "MODEL", requires = "mesh")]
        section: Option<SectionModel>,
        /// What it is
        #[command(flatten)]
        part: PartArguments,
        /// Replace existing files
        #[arg(long)]
        force: bool,
    },
    /// Draw figures of result files; several are compared
    Plot(PlotArguments),
    /// Write one page about results that opens in any browser: verdict, tables, figures, bodies in
    /// motion
    Report(ReportArguments),
    /// Write the moving, deformed bodies of a result for ParaView, or what a scenario describes
    /// before any run
    Export(ExportArguments),
    /// Print motion, stress and strain at points of a stored result over time, or coordinates of a
    /// body
    #[command(after_help = PROBE_COLUMNS)]
    Probe(ProbeArguments),
    /// Print the JSON schema of the scenario file, for editors
    Schema,
    /// Print the reference page of the scenario file, or the tables of that of the result file or
    /// of expressions
    Reference {
        /// Page
        #[arg(default_value = "scenario")]
        page: Page,
    },
    /// Print completions for a shell
    Completions {
        /// Shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, of the program or of one command
    Man {
        /// Command, such as run or cache info
        #[arg(value_name = "COMMAND")]
        command: Vec<String>,
        /// Write the pages of all commands into this folder, created if it does not exist
        #[arg(long, value_name = "DIR", conflicts_with = "command")]
        all: Option<PathBuf>,
        /// With --all: replace existing files, even those that are not of this program
        #[arg(long, requires = "all")]
        force: bool,
    },
}

impl Command {
    /// The one scenario that it is about.
    pub fn scenario(&self) -> Option<&Path> {
        match self {
            Self::Run(arguments) => arguments.scenario.as_deref(),
            Self::Static(arguments) => Some(&arguments.scenario),
            Self::Converge(arguments) => Some(&arguments.scenario),
            Self::Modes { scenario, .. }
            | Self::MeshSize { scenario, .. }
            | Self::ExportBody { scenario, .. } => Some(scenario),
            Self::Export(arguments) if arguments.is_of_scenario() => Some(&arguments.file),
            _ => None,
        }
    }
}

/// Scenarios to start from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Template {
    /// A ball falls on a rigid floor
    Drop,
    /// A hammer strikes a beam that is clamped at a face
    Hammer,
    /// A pendulum, bodies on joints, swings against a wall
    Pendulum,
    /// A part of finite elements is held at a bore and struck; writes NAME.msh as well
    Mesh,
    /// A ball strikes a row of balls
    Chain,
}

/// Reference pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Page {
    /// The scenario file.
    Scenario,
    /// The result file.
    Results,
    /// Functions of expressions.
    Expressions,
}

/// What to do with the folder of models.
#[derive(Debug, Clone, PartialEq, Subcommand)]
pub enum CacheAction {
    /// Print the folder, the number of models and their size
    Info(CacheArguments),
    /// Remove all models
    Clear(CacheArguments),
}

/// Whether and where models are kept between runs.
#[derive(Debug, Clone, PartialEq, Args)]
pub struct CacheArguments {
    /// Build all models, and keep none for later runs
    #[arg(long, conflicts_with = "cache_dir")]
    pub no_cache: bool,
    /// Folder of models kept between runs [default: $FBIMPACT_CACHE, which may be "off", or
    /// fbimpact in the user's cache folder]
    #[arg(long, value_name = "DIR")]
    pub cache_dir: Option<PathBuf>,
    /// Size of that folder, above which the least recently used models are removed
    #[arg(long, value_name = "GIB", default_value_t = DEFAULT_LIMIT, value_parser = tolerance)]
    pub cache_limit: f64,
}

impl CacheArguments {
    /// What they ask for, otherwise the environment.
    pub fn settings(&self) -> CacheSettings {
        if self.no_cache {
            return CacheSettings::NONE;
        }
        CacheSettings::kept(self.cache_dir.clone(), self.cache_limit)
    }
}

/// `--set`.
#[derive(Debug, Args)]
pub struct SetArguments {
    /// Change a key of the scenario, such as bodies.ball.velocity=[0,0,-0.2]; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub set: Vec<Override>,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err("must be a number > 0".to_owned()),
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x >= 0.0 => Ok(x),
        _ => Err("must be a number >= 0".to_owned()),
    }
}
