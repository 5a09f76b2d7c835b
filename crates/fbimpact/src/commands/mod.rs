//! The commands. Each returns its result or an [`AppError`]; only [`crate::main_with`] maps that to an exit code.

pub mod check;
pub mod info;
pub mod modes;
pub mod run;

use std::io::Write;

use crate::error::AppError;

/// Writes to standard output; a reader that closed the pipe is no error.
///
/// # Errors
/// [`AppError::Io`] if writing fails for another reason.
pub fn print(text: &str) -> Result<(), AppError> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(AppError::io("standard output", e)),
        _ => Ok(()),
    }
}

/// Sets up the thread pool and returns the number of threads; 0 asks for all cores.
///
/// # Errors
/// [`AppError::Model`] if the threads cannot be started.
pub fn threads(wanted: usize) -> Result<usize, AppError> {
    // One thread in the linear algebra, all threads over elements and bodies: its barriers spin (docs/decisions).
    faer::set_global_parallelism(faer::Par::Seq);
    rayon::ThreadPoolBuilder::new()
        .num_threads(wanted)
        .build_global()
        .map_err(|e| AppError::Model(format!("{wanted} threads cannot be started: {e}")))?;
    Ok(rayon::current_num_threads())
}
