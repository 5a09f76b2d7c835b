//! `fbimpact completions` and `fbimpact man`.

use clap::CommandFactory;

use super::print;
use crate::cli::Cli;
use crate::error::{AppError, CommandFault};
use crate::file_fault::FileFault;

/// Prints completions for a shell.
///
/// # Errors
/// [`AppError::Io`] if standard output cannot be written.
pub fn completions(shell: clap_complete::Shell) -> Result<(), AppError> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "fbimpact", &mut text);
    print(&String::from_utf8_lossy(&text))
}

/// Prints the manual page of the program or of one of its commands.
///
/// # Errors
/// [`AppError::Command`] for an unknown command, [`AppError::Io`] if standard output cannot be written.
pub fn manual(command: Option<&str>) -> Result<(), AppError> {
    let mut program = Cli::command();
    program.build();
    let page = match command {
        None => program,
        Some(name) => {
            let known = program.get_subcommands().filter(|c| !c.is_hide_set());
            let known = known.map(|c| c.get_name().to_owned()).collect();
            let unknown = || CommandFault::UnknownCommand { name: name.to_owned(), known };
            program.find_subcommand(name).cloned().ok_or_else(unknown)?
        }
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page)
        .render(&mut text)
        .map_err(|e| AppError::io("standard output", FileFault::Stream(e)))?;
    print(&String::from_utf8_lossy(&text))
}
