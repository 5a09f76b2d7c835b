//! `fbimpact thin`: a small copy of a result, to be kept as a reference.

use std::path::Path;

use result_files::file::output::Gate;
use result_files::stored::Stored;
use result_files::stored::thin as copy;

use crate::error::AppError;
use crate::results::{OutputFile, RESULT, Status};

/// Writes a small copy of `file` to `output`.
///
/// # Errors
/// [`AppError::Io`] if the files cannot be read or written, or are the same.
pub fn thin(file: &Path, output: &Path, rows: usize, force: bool) -> Result<(), AppError> {
    let source = Stored::open(file)?;
    Gate::of_files([&file.to_owned()], force).check(output, RESULT)?;
    let target = OutputFile::claim(output, force)?;
    let part = target.part().to_owned();
    if let Err(error) = copy::write(&source, &part, rows) {
        target.discard();
        return Err(error.into());
    }
    let path = target.finish(Status::Complete)?;
    let size = std::fs::metadata(&path).map_or(0, |m| m.len());
    tracing::info!("{} written, {} kB", path.display(), size.div_ceil(1000));
    Ok(())
}
