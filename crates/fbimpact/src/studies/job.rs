//! One run as a process of this program, and what an earlier call left of it.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::time::Instant;

use result_files::converge::outcome::Outcome;
use result_files::file::fault::Access;
use result_files::file::whole_file;

use crate::error::AppError;
use crate::results::restart_path;

/// A run to be made.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Job {
    /// Name, and that of its files.
    pub name: String,
    /// Changes of the scenario, `KEY=VALUE`.
    pub set: Vec<String>,
    /// SHA-256 of what the result follows from; none of a variant that is no valid scenario.
    pub inputs_sha256: Option<String>,
}

/// What every run is made with.
#[derive(Debug, Clone)]
pub struct Setting {
    /// This program.
    pub program: PathBuf,
    /// The scenario file.
    pub scenario: PathBuf,
    /// Folder of the results.
    pub folder: PathBuf,
    /// Further arguments: models kept between runs, memory.
    pub arguments: Vec<String>,
    /// Threads of a run.
    pub threads: usize,
}

/// A run that goes on. Ends as if interrupted when its standard input is closed.
pub struct Running {
    child: Child,
    input: Option<ChildStdin>,
    begin: Instant,
    /// Whether it goes on with a part that was left.
    pub is_taken_up: bool,
}

impl Setting {
    /// A file of the run `name`.
    fn file(&self, name: &str, ending: &str) -> PathBuf {
        self.folder.join(format!("{name}{ending}"))
    }

    /// The result of the run `name`.
    pub fn result(&self, name: &str) -> PathBuf {
        self.file(name, ".h5")
    }

    /// Starts `job`; what is left of another run of its name is removed unless it goes on from
    /// there.
    ///
    /// # Errors
    /// [`AppError::Io`] if files cannot be written or the program cannot be started.
    pub fn start(&self, job: &Job, is_taken_up: bool) -> Result<Running, AppError> {
        let result = self.result(&job.name);
        let _ = fs::remove_file(self.file(&job.name, ".exit"));
        if !is_taken_up {
            // What is not there need not be removed; what cannot be removed is replaced by the run.
            let _ = fs::remove_file(&result);
            let _ = fs::remove_file(restart_path(&result));
        }
        self.write(&job.name, ".set", &job.set.iter().map(|s| format!("{s}\n")).collect::<String>())?;
        let path = self.file(&job.name, ".log");
        let _ = fs::remove_file(&path);
        let log = File::create_new(&path).map_err(|e| AppError::system(&path, Access::Write, e))?;
        let mut command = Command::new(&self.program);
        command.arg("run");
        if is_taken_up {
            command.arg("--resume").arg(&result);
        } else {
            command.arg(&self.scenario).arg("-o").arg(&result);
            command.args(job.set.iter().flat_map(|s| ["--set", s]));
        }
        command.args(["--force", "--until-eof", "-q", "--threads", &self.threads.to_string()]);
        command.args(&self.arguments).stdin(Stdio::piped()).stdout(Stdio::null()).stderr(log);
        let started = command.spawn().map_err(|e| AppError::system(&self.program, Access::Start, e));
        started.map(|mut child| {
            let input = child.stdin.take();
            Running { child, input, begin: Instant::now(), is_taken_up }
        })
    }

    /// Writes down how `job` ended, and reads what came out.
    ///
    /// # Errors
    /// [`AppError::Io`] if files cannot be written or read.
    pub fn end(&self, job: &Job, status: ExitStatus) -> Result<Outcome, AppError> {
        if let Some(code) = status.code() {
            self.write(&job.name, ".exit", &format!("{code}\n"))?;
        }
        let mut outcome = Outcome::read(&self.result(&job.name))?;
        if status.code().is_none() {
            outcome.message = format!("ended by {status}; if memory ran out, try --jobs 1");
        }
        Ok(outcome)
    }

    fn write(&self, name: &str, ending: &str, text: &str) -> Result<(), AppError> {
        Ok(whole_file::write(&self.file(name, ending), text.as_bytes())?)
    }
}

impl Running {
    /// How the run ended, if it has.
    ///
    /// # Errors
    /// Those of the system.
    pub fn poll(&mut self) -> std::io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }

    /// Asks the run to store its state and end.
    pub fn stop(&mut self) {
        self.input = None;
    }

    /// Seconds since the start.
    pub fn elapsed(&self) -> f64 {
        self.begin.elapsed().as_secs_f64()
    }
}

/// Prepares the folder of the results, which the file `mark` in it tells: a new one, an empty one, or one of an earlier call.
///
/// # Errors
/// [`AppError::Io`] if it cannot be made or holds something else.
pub fn prepare(folder: &Path, mark: &str) -> Result<(), AppError> {
    let fail = |access| move |e: std::io::Error| AppError::system(folder, access, e);
    fs::create_dir_all(folder).map_err(fail(Access::Create))?;
    let path = folder.join(mark);
    if path.is_file() {
        return Ok(());
    }
    if fs::read_dir(folder).map_err(fail(Access::Read))?.next().is_some() {
        return Err(AppError::io(folder, format!("holds files and no {mark}, name a new folder with -o")));
    }
    Ok(whole_file::write(&path, b"{}\n")?)
}
