//! Manual pages: what the parser knows of a command, and sections that are the same for all.

use std::fmt::Write as _;
use std::io;

use clap::{Command, CommandFactory};
use clap_mangen::Man;

use crate::cli::{Cli, examples, tree};

/// Environment variables and what they do.
const ENVIRONMENT: [(&str, &str); 4] = [
    (
        "FBIMPACT_CACHE",
        "Folder of the models kept between runs, or \"off\". Without it fbimpact in XDG_CACHE_HOME, or in .cache of the home folder.",
    ),
    (
        "FBIMPACT_LOG",
        "What is logged, by part of the program, such as adaptive=trace,info; overrides -q and -v.",
    ),
    (
        "FBIMPACT_PVPYTHON",
        "The program pvpython of ParaView, for export --movie; without it the first on PATH.",
    ),
    (
        "NO_COLOR",
        "Is obeyed: log and results have no colours, whatever it is; its value also takes them from help and messages about the command line.",
    ),
];

/// Files and what they are.
const FILES: [(&str, &str); 5] = [
    ("SCENARIO.toml", "Scenario, with every key on the page of fbimpact reference."),
    ("OUT.h5", "Result in HDF5, with every dataset on the page of fbimpact reference results."),
    (
        "OUT.h5.part, OUT.h5.restart",
        "What a run that goes on, or was killed, has written, and what run --resume takes it up from.",
    ),
    ("fbimpact.schema.json", "Schema of the scenario for editors, written by fbimpact new."),
    ("~/.cache/fbimpact", "Models kept between runs, see fbimpact cache."),
];

/// The page of the command with these words below the program, of the program itself without any;
/// `None` if there is no such command.
pub fn page(words: &[String]) -> Option<io::Result<String>> {
    Some(render(&command(words)?, &words.join(" ")))
}

fn command(words: &[String]) -> Option<Command> {
    let mut command = Cli::command();
    command.build();
    for word in words {
        command = command.find_subcommand(word).filter(|c| is_documented(c))?.clone();
    }
    Some(command)
}

/// The same as plain text: what `--help` prints.
pub fn plain(words: &[String]) -> Option<String> {
    Some(command(words)?.render_long_help().to_string())
}

/// Words of all commands that have a page, the program itself first.
pub fn all() -> Vec<Vec<String>> {
    fn below(command: &Command, words: &[String], found: &mut Vec<Vec<String>>) {
        found.push(words.to_vec());
        for child in command.get_subcommands().filter(|c| is_documented(c)) {
            below(child, &[words, &[child.get_name().to_owned()]].concat(), found);
        }
    }
    let mut found = Vec::new();
    below(&Cli::command(), &[], &mut found);
    found
}

/// Names of the commands one below `words`.
pub fn names() -> Vec<String> {
    all().into_iter().filter(|words| !words.is_empty()).map(|words| words.join(" ")).collect()
}

fn is_documented(command: &Command) -> bool {
    !command.is_hide_set() && command.get_name() != "help"
}

fn render(command: &Command, name: &str) -> io::Result<String> {
    let notes = command.get_after_help().map(ToString::to_string);
    let man =
        Man::new(command.clone().after_help("")).source(concat!("fbimpact ", env!("CARGO_PKG_VERSION")));
    let mut page = Vec::new();
    man.render_title(&mut page)?;
    man.render_name_section(&mut page)?;
    man.render_synopsis_section(&mut page)?;
    man.render_description_section(&mut page)?;
    man.render_options_section(&mut page)?;
    if command.get_subcommands().any(is_documented) {
        man.render_subcommands_section(&mut page)?;
    }
    let mut text = String::from_utf8_lossy(&page).into_owned();
    if let Some(notes) = notes.filter(|_| !name.is_empty()) {
        let _ = write!(text, ".SH NOTES\n.nf\n{}\n.fi\n", escaped(&notes));
    }
    let _ = writeln!(text, ".SH EXIT STATUS");
    for (code, meaning) in tree::EXIT_CODES {
        entry(&mut text, code, meaning);
    }
    let _ = writeln!(text, ".PP\n{}", escaped(tree::STREAMS));
    let _ = writeln!(text, ".SH ENVIRONMENT");
    for (variable, meaning) in ENVIRONMENT {
        entry(&mut text, variable, meaning);
    }
    let _ = writeln!(text, ".SH FILES");
    for (file, meaning) in FILES {
        entry(&mut text, file, meaning);
    }
    let _ = writeln!(text, ".SH EXAMPLES");
    for example in examples::of(name) {
        let _ = writeln!(
            text,
            ".PP\n{}:\n.PP\n.nf\n.RS\n{}\n.RE\n.fi",
            escaped(example.does),
            escaped(example.line)
        );
    }
    let _ = writeln!(text, ".SH SEE ALSO\n{}", escaped(&see_also(name)));
    Ok(text)
}

/// Pages above and below a command, or beside it.
fn see_also(name: &str) -> String {
    let file = |words: &[String]| {
        let words: Vec<&str> = std::iter::once("fbimpact").chain(words.iter().map(String::as_str)).collect();
        format!("{}(1)", words.join("-"))
    };
    let own: Vec<String> = name.split(' ').filter(|w| !w.is_empty()).map(str::to_owned).collect();
    let is_near =
        |words: &Vec<String>| *words != own && (words.is_empty() || own.is_empty() || words[0] == own[0]);
    all().iter().filter(|words| is_near(words)).map(|words| file(words)).collect::<Vec<_>>().join(", ")
}

fn entry(text: &mut String, what: &str, meaning: &str) {
    let _ = writeln!(text, ".TP\n\\fB{}\\fR\n{}", escaped(what), escaped(meaning));
}

/// Text as it is: no escapes, requests or hyphens of roff.
fn escaped(text: &str) -> String {
    let line = |line: &str| {
        let line = line.replace('\\', "\\e").replace('-', "\\-");
        if line.starts_with(['.', '\'']) { format!("\\&{line}") } else { line }
    };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page_with_all_sections() {
        let pages = all();
        assert!(pages.len() > 20 && pages.contains(&vec!["cache".into(), "info".into()]), "{pages:?}");
        for words in pages {
            let page = page(&words).expect("a command").expect("a page");
            for section in ["NAME", "SYNOPSIS", "EXIT STATUS", "ENVIRONMENT", "FILES", "EXAMPLES", "SEE ALSO"]
            {
                let heading = [format!("\n.SH {section}\n"), format!("\n.SH \"{section}\"\n")];
                assert!(heading.iter().any(|h| page.contains(h)), "{words:?}: {section}\n{page}");
            }
            assert!(!page.contains(".SH EXTRA"), "{words:?}");
        }
        assert!(page(&["fly".to_owned()]).is_none() && page(&["help".to_owned()]).is_none());
    }

    #[test]
    fn text_is_no_request() {
        assert_eq!(escaped(".a -b\n'c\\d"), "\\&.a \\-b\n\\&'c\\ed");
    }
}
