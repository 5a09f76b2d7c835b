//! Completions of files by their endings, which the generator of completions does not know:
//! `fbimpact run` is offered scenarios, `fbimpact info` results. What an argument takes follows
//! from the name of its value, such as `OUT.h5|SCENARIO.toml`.

use std::fmt::Write;

use clap::{Arg, Command, CommandFactory};
use clap_complete::Shell;

use crate::cli::Cli;

/// The generated completions `text` of `shell` with files by their endings; those of other shells
/// as they are.
pub fn by_ending(shell: Shell, text: &str) -> String {
    match shell {
        Shell::Bash => bash(text),
        Shell::Zsh => zsh(text),
        Shell::Fish => fish(text),
        _ => text.to_owned(),
    }
}

/// What an argument takes, as its value is called.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Files {
    /// Files with these endings.
    Ending(Vec<String>),
    /// Folders.
    Folders,
}

/// What the value of an argument is; `None` if it is no file, or any.
fn files(argument: &Arg) -> Option<Files> {
    let names = argument.get_value_names()?;
    let mut endings = Vec::new();
    for name in names.iter().flat_map(|name| name.split('|')) {
        match name.split('.').collect::<Vec<_>>()[..] {
            ["DIR"] if names.len() == 1 && !names[0].contains('|') => return Some(Files::Folders),
            // A folder of results, or one of them.
            ["DIR"] => endings.push("h5".to_owned()),
            [_, ending] => endings.push(ending.to_owned()),
            _ => {}
        }
    }
    (!endings.is_empty()).then_some(Files::Ending(endings))
}

/// Commands without commands below them.
fn commands() -> Vec<Command> {
    let mut program = Cli::command();
    program.build();
    program.get_subcommands().filter(|c| c.get_name() != "help").cloned().collect()
}

/// What the first argument of `command` that is no option takes.
fn positional(command: &Command) -> Option<Files> {
    command.get_positionals().find_map(files)
}

/// Options of `command` with a value, as typed.
fn options(command: &Command) -> Vec<(Vec<String>, Option<Files>)> {
    let with_value = command.get_opts().filter(|a| a.get_action().takes_values());
    with_value
        .map(|a| {
            let long = a.get_long().map(|l| format!("--{l}"));
            let short = a.get_short().map(|s| format!("-{s}"));
            (long.into_iter().chain(short).collect(), files(a))
        })
        .collect()
}

/// A function around the generated one, which answers where a file is due.
fn bash(text: &str) -> String {
    let mut cases = String::new();
    let mut names = Vec::new();
    for command in commands() {
        let name = command.get_name().to_owned();
        for (typed, files) in options(&command) {
            let pattern: Vec<String> = typed.iter().map(|option| format!("{name}:{option}")).collect();
            let _ = writeln!(cases, "        {}) {} ;;", pattern.join("|"), action(files.as_ref()));
        }
        if let Some(files) = positional(&command) {
            let _ = writeln!(cases, "        {name}:*) {} ;;", action(Some(&files)));
        }
        names.push(name);
    }
    let generated = text.rsplit_once("\nif [[ \"${BASH_VERSINFO").map_or(text, |(before, _)| before);
    format!(
        r#"{generated}
# Files by their endings where a file is due; everything else as above.
_fbimpact_by_ending() {{
    local current="${{COMP_WORDS[COMP_CWORD]}}" previous="${{COMP_WORDS[COMP_CWORD-1]}}" word command='' endings='' ending
    for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
        case $word in {}) command=$word; break ;; esac
    done
    case $command:$previous in
{cases}    esac
    if [[ -z $endings || $current == -* ]]; then
        _fbimpact "$@"
        return
    fi
    local IFS=$'\n'
    COMPREPLY=($(compgen -d -- "$current"))
    for ending in ${{endings//,/$IFS}}; do
        [[ $ending == / ]] || COMPREPLY+=($(compgen -f -X "!*.$ending" -- "$current"))
    done
    compopt -o filenames 2>/dev/null
}}
complete -F _fbimpact_by_ending fbimpact
"#,
        names.join("|")
    )
}

/// What a case of the function for bash does.
fn action(files: Option<&Files>) -> String {
    match files {
        Some(Files::Ending(endings)) => format!("endings={}", endings.join(",")),
        Some(Files::Folders) => "endings=/".to_owned(),
        None => String::new(),
    }
}

/// `_files` with a pattern in place of what offers everything.
fn zsh(text: &str) -> String {
    let mut text = text.to_owned();
    for argument in commands().iter().flat_map(|c| c.get_arguments().cloned().collect::<Vec<_>>()) {
        let pattern = match files(&argument) {
            Some(Files::Ending(endings)) if endings.len() == 1 => format!("_files -g \"*.{}\"", endings[0]),
            Some(Files::Ending(endings)) => format!("_files -g \"*.({})\"", endings.join("|")),
            Some(Files::Folders) => "_files -/".to_owned(),
            None => continue,
        };
        let name = argument.get_value_names().map(|names| names.join(" ")).unwrap_or_default();
        // An option: [help]:VALUE:_action; any other argument: :id -- help:_action.
        let head = if argument.is_positional() {
            format!(":{} -- ", argument.get_id())
        } else {
            format!("]:{name}:")
        };
        let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
        let short = help.replace('\'', "'\\''").replace('[', "\\[").replace(']', "\\]").replace(':', "\\:");
        let before = if argument.is_positional() { format!("{head}{short}:") } else { head };
        for generated in ["_files", "_default"] {
            text = text.replace(&format!("{before}{generated}'"), &format!("{before}{pattern}'"));
        }
    }
    text
}

/// A rule for each command whose argument is a file; fish puts files with the ending first.
fn fish(text: &str) -> String {
    let mut text = text.to_owned();
    for command in commands() {
        let condition = format!("__fish_fbimpact_using_subcommand {}", command.get_name());
        if let Some(Files::Ending(endings)) = positional(&command) {
            let suffixes: Vec<String> =
                endings.iter().map(|e| format!("(__fish_complete_suffix .{e})")).collect();
            let _ =
                writeln!(text, "complete -c fbimpact -n \"{condition}\" -k -f -a \"{}\"", suffixes.join(" "));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(command: &str, argument: &str) -> Option<Files> {
        let found = commands().into_iter().find(|c| c.get_name() == command).expect("a command");
        let argument = found.get_arguments().find(|a| a.get_id() == argument).expect("an argument").clone();
        files(&argument)
    }

    #[test]
    fn names_of_values_tell_the_endings() {
        let endings = |list: &[&str]| Some(Files::Ending(list.iter().map(|e| (*e).to_owned()).collect()));
        assert_eq!(of("run", "scenario"), endings(&["toml"]));
        assert_eq!(of("run", "output"), endings(&["h5"]));
        assert_eq!(of("export", "file"), endings(&["h5", "toml"]));
        assert_eq!(of("collect", "runs"), endings(&["h5"]));
        assert_eq!(of("collect", "output"), endings(&["csv", "h5"]));
        assert_eq!(of("plot", "output"), Some(Files::Folders));
        assert_eq!(of("run", "threads"), None);
        assert_eq!(of("compare", "tolerances"), endings(&["toml"]));
    }

    #[test]
    fn every_file_of_the_completions_for_zsh_has_its_ending() {
        let mut text = Vec::new();
        clap_complete::generate(Shell::Zsh, &mut Cli::command(), "fbimpact", &mut text);
        let text = by_ending(Shell::Zsh, &String::from_utf8(text).expect("UTF-8"));
        let is_file = |line: &&str| line.contains(".toml:_") || line.contains(".h5:_");
        // The name of a new scenario is that of no file.
        for line in text.lines().filter(is_file).filter(|line| !line.contains(":name -- ")) {
            assert!(line.contains("_files -g"), "{line}");
        }
        assert!(text.contains("-- Scenario files, - for standard input:_files -g \"*.toml\"'"), "{text}");
    }
}
