//! Threads of the program.

use crate::error::AppError;

/// A pool of `threads` threads.
///
/// # Errors
/// [`AppError::Threads`] if they cannot be started.
pub fn thread_pool(threads: usize) -> Result<rayon::ThreadPool, AppError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map_err(|source| AppError::Threads { threads, source })
}
