//! `fbimpact cache`: what is in the folder of models, and removing it.

use result_files::file::fault::Access;

use crate::cache::{Contents, Folder};
use crate::cli::CacheAction;
use crate::error::AppError;

/// Shows or clears the folder that the arguments of `action` name.
///
/// # Errors
/// [`AppError::Io`] if the folder cannot be read or a file not be removed.
pub fn cache(action: &CacheAction) -> Result<(), AppError> {
    let (CacheAction::Info(arguments) | CacheAction::Clear(arguments)) = action;
    let settings = arguments.settings();
    let Some(folder) = settings.folder() else {
        return crate::commands::print("no cache\n");
    };
    let path = folder.path();
    let fail = |access| move |e: std::io::Error| AppError::system(path, access, e);
    match action {
        CacheAction::Info(_) => {
            crate::commands::print(&report(&folder, folder.contents().map_err(fail(Access::Read))?, ""))
        }
        CacheAction::Clear(_) => crate::commands::print(&report(
            &folder,
            folder.clear().map_err(fail(Access::Remove))?,
            " removed",
        )),
    }
}

fn report(folder: &Folder, contents: Contents, what: &str) -> String {
    let Contents { models, bytes } = contents;
    let noun = if models == 1 { "model" } else { "models" };
    format!(
        "{}\n{models} {noun}, {:.1} MiB{what}\n",
        folder.path().display(),
        bytes as f64 / f64::from(1 << 20)
    )
}
