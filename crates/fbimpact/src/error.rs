//! What can end the program, and the exit code that each case maps to.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adaptive::AdaptiveError;
use result_files::error::ResultError;
use result_files::expression::fault::ExpressionFault;
use result_files::file_fault::{Access, FileError, FileFault};
use result_files::percent::percent;
use result_files::toml_text::fault::Faults;

use crate::scenario::OverrideFault;
use crate::scenario::body_places::PlaceError;

/// Everything that ends a command without a result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AppError {
    /// The scenario is not valid.
    #[error("{0}")]
    Scenario(#[from] Faults),
    /// A model cannot be built from a valid scenario.
    #[error("model cannot be built: {0}")]
    Model(Box<AdaptiveError>),
    /// A body built again from a result has other modes than the run had.
    #[error(
        "model cannot be built: body \"{body}\": the modes that this version of the program finds are not those of the run, simulate again"
    )]
    OtherModes {
        /// Name of the body.
        body: String,
    },
    /// The run failed; what was computed is kept.
    #[error("run failed: {0}")]
    Run(Box<AdaptiveError>),
    /// The threads asked for cannot be started.
    #[error("{threads} threads cannot be started: {source}")]
    Threads {
        /// How many; 0 stands for all cores.
        threads: usize,
        /// What the system answered.
        source: rayon::ThreadPoolBuildError,
    },
    /// A report cannot be written as JSON.
    #[error("the report cannot be written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    /// Reading or writing failed.
    #[error(transparent)]
    Io(#[from] FileError),
    /// The user stopped the run.
    #[error("interrupted at t = {time:.9e} s, the results so far are in {0}; go on with: fbimpact run --resume {0}", output.display())]
    Interrupted {
        /// Time reached, in s.
        time: f64,
        /// Where the results are.
        output: PathBuf,
    },
    /// A result differs from its reference.
    #[error("differs from the reference in {differing} of {all} quantities")]
    Differs {
        /// Quantities that differ.
        differing: usize,
        /// Quantities compared.
        all: usize,
    },
    /// A result changes with its resolution by more than is allowed, or by how much is not known.
    #[error("not converged within {}", percent(*tolerance))]
    Unconverged {
        /// Change that is allowed, as a share.
        tolerance: f64,
    },
    /// The run that others were to be compared with did not complete.
    #[error("the scenario as it is: {message}")]
    Base {
        /// Exit code of the run.
        code: u8,
        /// Why.
        message: String,
    },
    /// The user stopped a run before there was anything to store.
    #[error("interrupted before the first instant, nothing is stored")]
    InterruptedEarly,
    /// The user stopped a run that was taken up before it had gone on; what was stored before stays.
    #[error("interrupted before the first instant; go on with: fbimpact run --resume {}", output.display())]
    InterruptedResumption {
        /// Where the results are.
        output: PathBuf,
    },
    /// The user stopped several runs.
    #[error("interrupted, the runs so far are in {}; the same command goes on with them", folder.display())]
    InterruptedRuns {
        /// Where the runs are.
        folder: PathBuf,
    },
    /// What ended a command for one of several scenarios.
    #[error("{}: {error}", path.display())]
    OfScenario {
        /// The scenario.
        path: PathBuf,
        /// What it was.
        error: Box<AppError>,
    },
    /// A command line that names a body which there is not.
    #[error("{option} {name}: no such body, the {holder} has {}", known.join(", "))]
    UnknownBody {
        /// Option of the command line.
        option: &'static str,
        /// Name given.
        name: String,
        /// What has the bodies: "scenario" or "result".
        holder: &'static str,
        /// Names of the bodies there are.
        known: Vec<String>,
    },
    /// A command line that asks for something else that cannot be.
    #[error(transparent)]
    Command(#[from] CommandFault),
}

/// Why a body has no such place.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlaceFault {
    /// Coordinates of another model.
    #[error("points of body \"{body}\" have {expected} coordinates")]
    Coordinates {
        /// Name of the body.
        body: String,
        /// How many they are.
        expected: usize,
    },
    /// No such place on the shape.
    #[error(transparent)]
    Shape(#[from] PlaceError),
    /// No such place on the model.
    #[error(transparent)]
    Model(#[from] Box<AdaptiveError>),
}

/// Why what a command line asks for cannot be.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CommandFault {
    /// Neither a scenario nor a result.
    #[error("name a scenario, or a result with --resume")]
    NothingToRun,
    /// A scenario has no stored states and deforms nothing.
    #[error("{option} is for results; a scenario is shown as it starts, leave the option out")]
    OptionForResult {
        /// The option.
        option: &'static str,
    },
    /// What has been run cannot be changed any more.
    #[error(
        "--set changes scenarios; a result is as its scenario was, leave the option out or name a scenario"
    )]
    SetOnResult,
    /// A manual page of a command that there is not.
    #[error("man {name}: no such command, there are {}", known.join(", "))]
    UnknownCommand {
        /// Name given.
        name: String,
        /// The commands there are.
        known: Vec<String>,
    },
    /// No mesh whose touch can be predicted.
    #[error(
        "no contact of a body with model \"mesh\" has a radius that Hertz's theory predicts; there must be one, with surfaces that are curved against each other"
    )]
    NoMeshTouched,
    /// Several meshes for one file of sizes.
    #[error("contacts touch the meshes of {}; choose one with --body", names.join(" and "))]
    SeveralMeshes {
        /// Names of the bodies.
        names: Vec<String>,
    },
    /// A path without a file name.
    #[error("{}: is no name for a file", path.display())]
    NoFileName {
        /// The path.
        path: PathBuf,
    },
    /// A table of an unknown kind.
    #[error("-o {}: must end in .csv or .h5", output.display())]
    TableEnding {
        /// The output.
        output: PathBuf,
    },
    /// A result that would be written over itself.
    #[error("-o {}: is the result itself", output.display())]
    OutputIsInput {
        /// The output.
        output: PathBuf,
    },
    /// More results than figures have styles for.
    #[error("{files} files in one figure cannot be told apart, name at most {most}")]
    TooManyFiles {
        /// Number of files.
        files: usize,
        /// Number of styles.
        most: usize,
    },
    /// A marker that is none.
    #[error("--marker {given}: {reason}; write NAME=NODES, as in hinge=1,2,5-9")]
    Marker {
        /// As given.
        given: String,
        /// What is wrong.
        reason: &'static str,
    },
    /// A body that has no full model to export.
    #[error("--body {name}: the body is {what}, name a flexible one with a shape")]
    NoFullModel {
        /// Name of the body.
        name: String,
        /// What it is.
        what: &'static str,
    },
    /// A body that has no shape to show.
    #[error("--bodies {name}: {reason}")]
    NoShape {
        /// Name of the body.
        name: String,
        /// Why it has none.
        reason: &'static str,
    },
    /// A result in which nothing has a shape.
    #[error("no body of the result has a shape, there is nothing to export")]
    NothingToExport,
    /// An expression that has no value.
    #[error("{option}: {fault}")]
    Expression {
        /// Option or command.
        option: &'static str,
        /// Why.
        fault: ExpressionFault,
    },
    /// Two columns of one name.
    #[error("the table has a column \"{name}\" already, choose another name")]
    ColumnTwice {
        /// The name.
        name: String,
    },
    /// A place on a body that there is not.
    #[error("{option} {given}: {fault}")]
    Place {
        /// Option of the command line.
        option: &'static str,
        /// As given.
        given: String,
        /// Why there is none.
        fault: Box<PlaceFault>,
    },
    /// A body at rest.
    #[error("--body {name}: is a plane at rest, name a body that moves")]
    NoMotion {
        /// Name of the body.
        name: String,
    },
    /// Modes of a rigid body.
    #[error("--modes: body {name} is rigid and has no elastic coordinates")]
    NoModes {
        /// Name of the body.
        name: String,
    },
    /// A range without a stored instant.
    #[error("no instant is stored from {from:e} s to {to:e} s, the result holds {first:e} s to {last:e} s")]
    NoInstant {
        /// Begin \[s\].
        from: f64,
        /// End \[s\].
        to: f64,
        /// First stored time \[s\].
        first: f64,
        /// Last stored time \[s\].
        last: f64,
    },
    /// A span of times without a stored instant.
    #[error(
        "--from {from} --to {to}: {label} has no stored state between them, it holds {first:e} s to {last:e} s"
    )]
    NoInstants {
        /// How the legend calls the result.
        label: String,
        /// Begin \[s\].
        from: f64,
        /// End \[s\].
        to: f64,
        /// First stored time \[s\].
        first: f64,
        /// Last stored time \[s\].
        last: f64,
    },
    /// Peaks of a result without impacts.
    #[error("--times peak: the result has no impacts, name times as A:B:STEP")]
    NoPeaks,
    /// A film of a kind that there is not.
    #[error("--movie {}: must end in .{}", movie.display(), endings.join(", ."))]
    MovieEnding {
        /// The film.
        movie: PathBuf,
        /// Ends there are.
        endings: &'static [&'static str],
    },
    /// Films are made by ParaView.
    #[error(
        "--movie needs pvpython, which comes with ParaView 5.10 or later: put its folder on PATH, or its path into {variable}; or leave --movie out, open the export in ParaView and save an animation there"
    )]
    NoPvpython {
        /// Variable of the environment that may name it.
        variable: &'static str,
    },
    /// A range beyond the stored times.
    #[error("--times {from}:{to}:{step}: the result holds {first:e} s to {last:e} s")]
    Times {
        /// Begin \[s\].
        from: f64,
        /// End \[s\].
        to: f64,
        /// Step \[s\].
        step: f64,
        /// First stored time \[s\].
        first: f64,
        /// Last stored time \[s\].
        last: f64,
    },
    /// A scenario key and value that cannot be read.
    #[error(transparent)]
    Override(#[from] OverrideFault),
}

impl From<ResultError> for AppError {
    fn from(error: ResultError) -> Self {
        match error {
            ResultError::File(error) => Self::Io(error),
            ResultError::Tolerances(faults) => Self::Scenario(faults),
        }
    }
}

impl From<AdaptiveError> for AppError {
    fn from(error: AdaptiveError) -> Self {
        if error.is_model_error() { Self::model(error) } else { Self::Run(Box::new(error)) }
    }
}

impl AppError {
    /// The same with the name of the scenario, where the message has not got it.
    pub fn of_scenario(self, path: &Path) -> Self {
        match self {
            Self::Scenario(_) | Self::Io(_) => self,
            error => Self::OfScenario { path: path.to_owned(), error: Box::new(error) },
        }
    }

    /// A model that cannot be built.
    pub fn model(error: AdaptiveError) -> Self {
        Self::Model(Box::new(error))
    }

    /// What is wrong with the file `path`.
    pub fn io(path: impl Into<PathBuf>, fault: impl Into<FileFault>) -> Self {
        Self::Io(FileError::new(path, fault.into()))
    }

    /// What the system answered to an access of the file `path`.
    pub fn system(path: impl Into<PathBuf>, access: Access, source: std::io::Error) -> Self {
        Self::io(path, FileFault::system(access, source))
    }

    /// The documented exit code.
    pub fn code(&self) -> u8 {
        match self {
            Self::Differs { .. } | Self::Unconverged { .. } => 1,
            Self::UnknownBody { .. } | Self::Command(_) => 2,
            Self::Scenario(_) => 3,
            Self::OfScenario { error, .. } => error.code(),
            Self::Model(_) | Self::OtherModes { .. } => 4,
            Self::Run(_) | Self::Threads { .. } | Self::Json(_) => 5,
            Self::Io(_) => 6,
            Self::Interrupted { .. }
            | Self::InterruptedEarly
            | Self::InterruptedResumption { .. }
            | Self::InterruptedRuns { .. } => 130,
            Self::Base { code, .. } => *code,
        }
    }

    /// [`AppError::code`] as the process wants it.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.code())
    }
}
