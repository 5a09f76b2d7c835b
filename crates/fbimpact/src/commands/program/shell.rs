//! `fbimpact completions` and `fbimpact man`.

mod completion_files;
mod manual;

use std::io::{IsTerminal, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use clap::CommandFactory;
use result_files::file::fault::{Access, FileFault};
use result_files::file::output::{Gate, Kind};

use crate::cli::Cli;
use crate::commands::print;
use crate::error::{AppError, CommandFault};

/// A manual page, by its title.
const PAGE: Kind = Kind::marked("a manual page of fbimpact", ".TH fbimpact");

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
    let page = page.map_err(|e| AppError::io("standard output", FileFault::Stream(e)))?;
    if !std::io::stdout().is_terminal() {
        return print(&page);
    }
    if is_shown(&page).unwrap_or(false) { Ok(()) } else { print(&manual::plain(words).unwrap_or(page)) }
}

/// Has the program `man` show a page on the terminal; whether it did.
fn is_shown(page: &str) -> std::io::Result<bool> {
    let mut man =
        Command::new("man").args(["-l", "-"]).stdin(Stdio::piped()).stderr(Stdio::null()).spawn()?;
    let input = man.stdin.take();
    // Who leaves the page before its end closes the pipe.
    let _ = input.map(|mut input| input.write_all(page.as_bytes()));
    Ok(man.wait()?.success())
}

/// Writes the manual pages of all commands into a folder, created if it does not exist; prints
/// their names.
///
/// # Errors
/// [`AppError::Io`] if they cannot be written.
pub fn manuals(folder: &Path, force: bool) -> Result<(), AppError> {
    std::fs::create_dir_all(folder).map_err(|e| AppError::system(folder, Access::Write, e))?;
    for words in manual::all() {
        let name = [&["fbimpact".to_owned()][..], &words].concat().join("-");
        let path = folder.join(format!("{name}.1"));
        let Some(page) = manual::page(&words) else { continue };
        let page = page.map_err(|e| AppError::io(&path, FileFault::Stream(e)))?;
        Gate::new([], force).write(&path, PAGE, |part| std::fs::write(part, page))?;
        print(&format!("{}\n", path.display()))?;
    }
    Ok(())
}
