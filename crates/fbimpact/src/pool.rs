//! Threads of the program.

use crate::error::AppError;

/// A pool of `threads` threads.
///
/// # Errors
/// [`AppError::Run`] if they cannot be started.
pub fn pool(threads: usize) -> Result<rayon::ThreadPool, AppError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|e| AppError::Run(format!("no pool of {threads} threads: {e}")))
}
