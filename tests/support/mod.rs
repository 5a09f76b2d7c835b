//! The built program as a user runs it.

pub mod bar;
pub mod damage;
pub mod impacts;
pub mod page;
pub mod scenarios;
pub mod steel_parts;
pub mod swings;
pub mod vtu;

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use assert_cmd::Command;

/// Exit code, standard output and standard error of the program.
pub fn fbimpact(arguments: &[&str]) -> (i32, String, String) {
    let run =
        Command::new(env!("CARGO_BIN_EXE_fbimpact")).args(arguments).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (run.status.code().expect("no signal"), text(run.stdout), text(run.stderr))
}

/// Code, standard output and standard error of `command`, which must end within a minute.
pub fn ended(command: &mut std::process::Command) -> (Option<i32>, String, String) {
    let piped = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = piped.spawn().expect("the program starts");
    // Read beside, for a full pipe would hold the program up.
    let [out, err]: [Box<dyn Read + Send>; 2] =
        [Box::new(child.stdout.take().expect("piped")), Box::new(child.stderr.take().expect("piped"))];
    let [out, err] = [out, err].map(|mut pipe| {
        std::thread::spawn(move || {
            let mut text = Vec::new();
            pipe.read_to_end(&mut text).expect("readable");
            String::from_utf8(text).expect("UTF-8")
        })
    });
    let begin = Instant::now();
    let code = loop {
        if let Some(status) = child.try_wait().expect("a child") {
            break status.code();
        }
        // Long after any of these commands is over, so that one that hangs fails.
        if begin.elapsed() > Duration::from_secs(60) {
            child.kill().expect("killed");
            panic!("{command:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    (code, out.join().expect("read"), err.join().expect("read"))
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
