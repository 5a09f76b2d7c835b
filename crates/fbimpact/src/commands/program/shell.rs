//! `fbimpact completions` and `fbimpact man`.

mod completion_files;
mod manual;

use std::path::Path;

use clap::CommandFactory;
use result_files::file::fault::{Access, FileFault};
use result_files::file::whole_file;

use crate::cli::Cli;
use crate::commands::{check_folder, print};
use crate::error::{AppError, CommandFault};

/// Prints completions for a shell.
///
/// # Errors
/// [`AppError::Io`] if standard output cannot be written.
pub fn completions(shell: clap_complete::Shell) -> Result<(), AppError> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "fbimpact", &mut text);
    print(&completion_files::by_ending(shell, &String::from_utf8_lossy(&text)))
}

/// Prints the manual page of the program or of one of its commands.
///
/// # Errors
/// [`AppError::Command`] for an unknown command, [`AppError::Io`] if standard output cannot be written.
pub fn manual(words: &[String]) -> Result<(), AppError> {
    let unknown = || {
        let reason = format!("no such command, there are {}", manual::names().join(", "));
        CommandFault::argument("man", words.join(" "), reason)
    };
    let page = manual::page(words).ok_or_else(unknown)?;
    print(&page.map_err(|e| AppError::io("standard output", FileFault::Stream(e)))?)
}

/// Writes the manual pages of all commands into a folder, created if it does not exist; prints
/// their names.
///
/// # Errors
/// [`AppError::Io`] if they cannot be written.
pub fn manuals(folder: &Path) -> Result<(), AppError> {
    std::fs::create_dir_all(folder).map_err(|e| AppError::system(folder, Access::Write, e))?;
    for words in manual::all() {
        let name = [&["fbimpact".to_owned()][..], &words].concat().join("-");
        let path = folder.join(format!("{name}.1"));
        check_folder(&path)?;
        let Some(page) = manual::page(&words) else { continue };
        let page = page.map_err(|e| AppError::io(&path, FileFault::Stream(e)))?;
        whole_file::write(&path, page.as_bytes()).map_err(|e| AppError::system(&path, Access::Write, e))?;
        print(&format!("{}\n", path.display()))?;
    }
    Ok(())
}
