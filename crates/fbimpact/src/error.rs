//! What can end the program, and the exit code that each case maps to.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use adaptive::AdaptiveError;
use result_files::error::ResultError;
use result_files::expression::fault::ExpressionFault;
use result_files::file::fault::{Access, FileError, FileFault};
use result_files::toml_text::fault::Faults;
use result_files::words::percent::percent;
use result_files::words::shown::for_shell;

use crate::interchange::body_file::BodyFileError;
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
    /// Contacts whose bodies move away from each other, one sentence each.
    #[error("{0}")]
    NeverMet(String),
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
    /// A result that is asked for is not there.
    #[error("{} is missing, incomplete, or of another scenario, other files or another program", output.display())]
    NotCurrent {
        /// The result.
        output: PathBuf,
    },
    /// The user stopped the run.
    #[error("interrupted at t = {time:.9e} s, the results so far are in {}; go on with: fbimpact run --resume {}", output.display(), for_shell(output))]
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
    /// The user stopped a run that was taken up before it had gone on; what was stored before
    /// stays.
    #[error("interrupted before the first instant; go on with: fbimpact run --resume {}", for_shell(output))]
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
    /// Some of several runs are not complete.
    #[error("{failed} of {all} runs are not complete; what they told is in {}", folder.display())]
    FailedRuns {
        /// Number of those.
        failed: usize,
        /// Number of all.
        all: usize,
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
    /// A command line that asks for what cannot be.
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
    /// What follows an option, or a command, does not serve.
    #[error("{option} {given}: {reason}")]
    Argument {
        /// The option or command.
        option: &'static str,
        /// As given.
        given: String,
        /// What is wrong, and what to give.
        reason: String,
    },
    /// Arguments that do not serve together, or not with this file.
    #[error("{0}")]
    Request(Cow<'static, str>),
    /// An expression that has no value.
    #[error("{option}: {fault}")]
    Expression {
        /// Option or command.
        option: &'static str,
        /// Why.
        fault: ExpressionFault,
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
    /// A scenario key and value that cannot be read.
    #[error("{0}")]
    Override(String),
}

impl CommandFault {
    /// What follows `option` does not serve, for this reason.
    pub fn argument(option: &'static str, given: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Argument { option, given: given.into(), reason: reason.into() }
    }

    /// The arguments do not serve, for this reason.
    pub fn request(reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Request(reason.into())
    }

    /// The body that follows `option` is not among those of the `holder`, a scenario or result.
    pub fn unknown_body(option: &'static str, name: &str, holder: &str, known: &[String]) -> Self {
        Self::argument(option, name, format!("no such body, the {holder} has {}", known.join(", ")))
    }

    /// Two columns of one name.
    pub fn column_twice(name: &str) -> Self {
        Self::request(format!("the table has a column \"{name}\" already, choose another name"))
    }
}

impl From<BodyFileError> for AppError {
    fn from(error: BodyFileError) -> Self {
        Self::io(error.path, FileFault::contents(error.fault))
    }
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
            Self::Differs { .. } | Self::Unconverged { .. } | Self::NotCurrent { .. } => 1,
            Self::Command(_) => 2,
            Self::Scenario(_) => 3,
            Self::OfScenario { error, .. } => error.code(),
            Self::Model(_) | Self::OtherModes { .. } | Self::NeverMet(_) => 4,
            Self::Run(_) | Self::Threads { .. } | Self::Json(_) | Self::FailedRuns { .. } => 5,
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
