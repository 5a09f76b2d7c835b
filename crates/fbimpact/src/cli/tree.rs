//! The commands as they are shown: in groups, with examples and exit codes.

use std::fmt::Write;

use clap::{Command, CommandFactory};

use super::{Cli, examples};

/// Groups of commands, in the order in which a user meets them.
pub const GROUPS: [(&str, &[&str]); 5] = [
    ("Prepare", &["new", "check", "modes", "mesh-size"]),
    ("Simulate", &["run", "static", "converge", "drop"]),
    ("Look at results", &["report", "info", "plot", "probe", "metric", "export"]),
    ("Many results", &["compare", "thin", "collect"]),
    (
        "Bodies and the program",
        &["export-body", "import-body", "cache", "schema", "reference", "completions", "man", "help"],
    ),
];

/// Exit codes and what they mean.
pub const EXIT_CODES: [(&str, &str); 8] = [
    ("0", "success"),
    ("1", "comparison differs, or not converged"),
    ("2", "wrong command line"),
    ("3", "invalid scenario or tolerance file"),
    ("4", "model cannot be built"),
    ("5", "run failed; what was computed is kept and readable"),
    ("6", "input or output failed"),
    ("130", "interrupted; what was computed is kept and readable"),
];

/// Use of the standard streams, for help and manual pages.
pub const STREAMS: &str = "Standard output carries results only. Progress and log go to standard error.";

/// Columns of a help page.
const WIDTH: usize = 100;
/// Columns of the names of commands.
const NAMES: usize = 13;

/// The program with all its commands, as help and manual pages show it.
pub fn command() -> Command {
    let program = Cli::command();
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{}Options:\n{{options}}{{after-help}}",
        groups(&program)
    );
    let mut exit = String::from("Exit codes:\n");
    for (code, meaning) in EXIT_CODES {
        let _ = writeln!(exit, "{code:>5}  {meaning}");
    }
    let program = program.help_template(template).after_help(format!(
        "{exit}\n{STREAMS}\nExamples and options of a command: fbimpact COMMAND --help; manual pages: fbimpact man [COMMAND]"
    ));
    with_examples(program, "")
}

/// The commands of `program` in groups; `help` is made by the parser itself.
fn groups(program: &Command) -> String {
    let mut text = String::new();
    for (group, names) in GROUPS {
        let _ = writeln!(text, "{group}:");
        for name in names {
            let about = program.find_subcommand(name).and_then(Command::get_about).map(ToString::to_string);
            let about = about.unwrap_or_else(|| "Print this page, or that of a command".to_owned());
            for (i, line) in wrapped(&about, WIDTH - NAMES - 4).into_iter().enumerate() {
                let name = if i == 0 { *name } else { "" };
                let _ = writeln!(text, "  {name:<NAMES$}  {line}");
            }
        }
        text.push('\n');
    }
    text
}

/// Lines of at most `width` characters, broken at spaces.
fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().expect("one at least");
        if !line.is_empty() && line.chars().count() + 1 + word.chars().count() > width {
            lines.push(word.to_owned());
        } else {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

/// Adds examples to every command below `command`, whose own name below the program is `name`.
fn with_examples(mut command: Command, name: &str) -> Command {
    let below: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    for child in below {
        let path = if name.is_empty() { child.clone() } else { format!("{name} {child}") };
        command = command.mut_subcommand(child, |c| with_examples(c, &path));
    }
    if name.is_empty() {
        return command;
    }
    let mut text = command.get_after_help().map_or_else(String::new, |t| format!("{t}\n\n"));
    text.push_str("Examples:");
    for example in examples::of(name) {
        let _ = write!(text, "\n  # {}\n  {}", example.does, example.line);
    }
    command.after_help(text)
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    /// Words of a command line as a shell takes them, with single quotes.
    fn words(line: &str) -> Vec<String> {
        let mut words = vec![String::new()];
        let mut is_quoted = false;
        for c in line.chars() {
            match c {
                '\'' => is_quoted = !is_quoted,
                ' ' if !is_quoted => words.push(String::new()),
                c => words.last_mut().expect("one at least").push(c),
            }
        }
        words
    }

    /// Names of all commands below the program.
    fn names(command: &Command, above: &str) -> Vec<String> {
        let mut found = Vec::new();
        for child in command.get_subcommands().filter(|c| !c.is_hide_set()) {
            let name = format!("{above}{}", child.get_name());
            found.extend(names(child, &format!("{name} ")));
            found.push(name);
        }
        found
    }

    #[test]
    fn every_command_is_in_one_group_and_has_examples_that_are_command_lines_of_its_own() {
        let program = Cli::command();
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| *names).copied().collect();
        grouped.retain(|name| *name != "help");
        grouped.sort_unstable();
        let mut known: Vec<String> = program.get_subcommands().map(|c| c.get_name().to_owned()).collect();
        known.sort_unstable();
        assert_eq!(grouped, known);
        for name in names(&program, "") {
            let own = examples::of(&name);
            assert_eq!(own.len(), 2, "{name}");
            for example in own {
                let parsed = Cli::try_parse_from(words(example.line));
                assert!(parsed.is_ok(), "{}: {}", example.line, parsed.expect_err("refused"));
                assert!(example.line.starts_with(&format!("fbimpact {name}")), "{}", example.line);
            }
        }
        for (name, own) in examples::EXAMPLES {
            let is_known = name.is_empty() || names(&program, "").iter().any(|known| known == name);
            assert!(is_known && own[0] != own[1], "{name}");
        }
    }

    #[test]
    fn lines_of_the_help_are_no_wider_than_a_page() {
        let mut command = command();
        let help = command.render_long_help().to_string();
        assert!(help.lines().all(|line| line.chars().count() <= WIDTH), "{help}");
        assert_eq!(wrapped("a bc def", 4), ["a bc", "def"]);
    }
}
