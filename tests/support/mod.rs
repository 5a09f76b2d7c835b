//! The built program as a user runs it.

pub mod bar;
pub mod damage;
pub mod impacts;
pub mod scenarios;
pub mod steel_parts;
pub mod swings;
pub mod vtu;

use std::path::{Path, PathBuf};

use assert_cmd::Command;

/// Exit code, standard output and standard error of the program.
pub fn fbimpact(arguments: &[&str]) -> (i32, String, String) {
    let run =
        Command::new(env!("CARGO_BIN_EXE_fbimpact")).args(arguments).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (run.status.code().expect("no signal"), text(run.stdout), text(run.stderr))
}

/// Runs the file `scenario` of `scenarios/` with the changes `set` and returns the result `name` in `folder`.
pub fn simulate(folder: &Path, scenario: &str, name: &str, set: &[&str]) -> PathBuf {
    let scenario = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenarios").join(scenario);
    let output = folder.join(name);
    let (scenario, file) = (scenario.display().to_string(), output.display().to_string());
    let mut arguments = vec!["run", "-q", &scenario, "-o", &file];
    arguments.extend(set.iter().flat_map(|s| ["--set", s]));
    let (code, _, err) = fbimpact(&arguments);
    assert_eq!(code, 0, "{err}");
    output
}
