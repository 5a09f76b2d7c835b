//! What the world does to a program: full disks, folders without permission, files cut off, kills, signals, two runs at once. Each
//! ends in a message that names file, cause and remedy, and no earlier file is lost.
#![cfg(unix)]

use std::fs::Permissions;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use tempfile::TempDir;

const PROGRAM: &str = env!("CARGO_BIN_EXE_fbimpact");
/// Long after anything in this file is over, so that a test that waits in vain fails instead of hanging.
const PATIENCE: Duration = Duration::from_secs(60);

fn scenario(name: &str) -> String {
    format!("{}/scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

fn ended(output: Output) -> (i32, String) {
    let code = output.status.code().expect("ended by itself, not by a signal");
    (code, String::from_utf8(output.stderr).expect("UTF-8"))
}

fn fbimpact(at: &Path, arguments: &[&str]) -> (i32, String) {
    ended(Command::new(PROGRAM).args(arguments).current_dir(at).output().expect("the program starts"))
}

/// Runs the program where no file may grow beyond `blocks` blocks of 512 bytes: writing then fails as on a full disk.
fn limited(at: &Path, blocks: usize, arguments: &[&str]) -> (i32, String) {
    let script = format!("ulimit -f {blocks}; exec \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &script, "sh", PROGRAM]).args(arguments).current_dir(at);
    // The output goes through pipes, which have no limit.
    ended(command.output().expect("a shell"))
}

fn scratch() -> TempDir {
    tempfile::tempdir().expect("a temporary directory")
}

/// A complete result.
static RESULT: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let folder = scratch();
    let (code, err) = fbimpact(folder.path(), &["run", "-q", &scenario("sphere_on_plane"), "-o", "ok.h5"]);
    assert_eq!(code, 0, "{err}");
    std::fs::read(folder.path().join("ok.h5")).expect("readable")
});

/// A folder with the result `ok.h5`.
fn with_result() -> TempDir {
    let folder = scratch();
    std::fs::write(folder.path().join("ok.h5"), &*RESULT).expect("written");
    folder
}

fn names(at: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(at).expect("readable").map(|e| e.expect("readable").file_name());
    let mut names: Vec<String> = entries.map(|n| n.into_string().expect("UTF-8")).collect();
    names.sort_unstable();
    names
}

/// The status of a result and its stored instants, by `info`; none if it cannot be read.
fn read(file: &Path) -> Option<(String, u64)> {
    let output =
        Command::new(PROGRAM).args(["info", "--json"]).arg(file).output().expect("the program starts");
    let value: serde_json::Value = serde_json::from_slice(&output.stdout).ok()?;
    Some((value["status"].as_str()?.to_owned(), value["samples"].as_u64()?))
}

fn info(file: &Path) -> (String, u64) {
    read(file).unwrap_or_else(|| panic!("{} cannot be read", file.display()))
}

#[test]
fn run_on_a_full_disk_names_file_and_remedy_and_keeps_the_flushed_rows_and_the_earlier_result() {
    let folder = with_result();
    let at = folder.path();
    // 4 blocks do not hold the empty file, 300 not the empty datasets; 1000 hold these, but not the rows.
    for blocks in [4, 300, 1000] {
        let run = ["run", "-q", &scenario("sphere_on_plane"), "-o", "ok.h5", "--force"];
        let (code, err) = limited(at, blocks, &run);
        assert_eq!(code, 6, "{blocks}: {err}");
        assert!(err.contains("ok.h5.part") && err.contains("name another folder"), "{err}");
        assert!(!err.contains("0x"), "no addresses: {err}");
        assert!(
            std::fs::read(at.join("ok.h5")).expect("readable") == *RESULT,
            "the earlier result is as it was"
        );
        // What got no flush at all is no file yet.
        if blocks >= 300 {
            assert_eq!(info(&at.join("ok.h5.part")).0, "running");
        }
    }
    let (code, err) = fbimpact(at, &["run", "-q", &scenario("sphere_on_plane"), "-o", "ok.h5"]);
    assert_eq!(code, 0, "with space again: {err}");
    assert_eq!((info(&at.join("ok.h5")).0.as_str(), names(at)), ("complete", vec!["ok.h5".to_owned()]));
}

#[test]
fn full_disk_leaves_no_half_written_file_of_any_command() {
    let sphere = scenario("sphere_on_plane");
    let commands: [(&[&str], &str, usize); 7] = [
        (&["thin", "ok.h5", "-o", "t.h5"], "t.h5", 8),
        (&["thin", "ok.h5", "-o", "t.h5"], "t.h5", 64),
        (&["collect", "ok.h5", "-o", "t.h5"], "t.h5", 4),
        (&["collect", "ok.h5", "-o", "t.csv"], "t.csv", 0),
        (&["plot", "ok.h5", "--figure", "forces"], "ok_forces.svg", 8),
        (&["export-body", &sphere, "--body", "ball", "--full", "-o", "t.h5"], "t.h5", 200),
        (&["new", "t"], "t.toml", 0),
    ];
    for (arguments, target, blocks) in commands {
        let folder = with_result();
        let at = folder.path();
        std::fs::write(at.join(target), "precious").expect("written");
        let (code, err) = limited(at, blocks, &[arguments, &["--force", "-q"]].concat());
        assert_eq!(code, 6, "{arguments:?}: {err}");
        assert!(err.contains(target) && err.contains("name another folder"), "{arguments:?}: {err}");
        let kept = std::fs::read_to_string(at.join(target)).expect("readable");
        assert_eq!(kept, "precious", "{arguments:?}");
        assert_eq!(names(at).len(), 2, "{arguments:?}: {:?}", names(at));
    }
    let folder = with_result();
    let (code, err) = limited(folder.path(), 8, &["export", "-q", "ok.h5", "--vtk", "v", "--every", "100"]);
    assert!(code == 6 && err.contains("name another folder"), "{err}");
    assert!(names(&folder.path().join("v/ok")).is_empty());
}

#[test]
fn full_standard_output_is_an_error() {
    let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") else { return };
    let folder = with_result();
    let mut command = Command::new(PROGRAM);
    let output = command
        .args(["info", "ok.h5"])
        .current_dir(folder.path())
        .stdout(Stdio::from(full))
        .stderr(Stdio::piped());
    let (code, err) = ended(output.spawn().and_then(Child::wait_with_output).expect("the program starts"));
    assert!(code == 6 && err.contains("standard output: No space left"), "{err}");
}

/// A command that runs the program as somebody for whom permissions count; none where that cannot be had.
fn bound_by_permissions(folder: &Path) -> Option<Command> {
    if std::fs::metadata(folder).expect("there").uid() != 0 {
        return Some(Command::new(PROGRAM));
    }
    // The administrator may write everywhere, nobody may not. The program may lie where nobody may not read.
    let copy = folder.join("program");
    std::fs::copy(PROGRAM, &copy).expect("copied");
    std::fs::set_permissions(folder, Permissions::from_mode(0o755)).expect("changed");
    let mut command = Command::new("setpriv");
    command.args(["--reuid=65534", "--regid=65534", "--clear-groups"]).arg(copy);
    let is_possible = Command::new(command.get_program()).args(command.get_args()).arg("--version").output();
    is_possible.is_ok_and(|o| o.status.success()).then_some(command)
}

#[test]
fn folder_without_permission_is_named_before_any_work_is_done() {
    let folder = scratch();
    let Some(command) = bound_by_permissions(folder.path()) else { return };
    let at = folder.path().join("closed");
    std::fs::create_dir(&at).expect("created");
    std::fs::write(at.join("ok.h5"), &*RESULT).expect("written");
    std::fs::copy(scenario("sphere_on_plane"), at.join("s.toml")).expect("copied");
    std::fs::set_permissions(&at, Permissions::from_mode(0o555)).expect("changed");
    let all: [&[&str]; 8] = [
        &["run", "s.toml"],
        &["run", "s.toml", "-o", "ok.h5"],
        &["thin", "ok.h5", "-o", "t.h5"],
        &["collect", "ok.h5", "-o", "t.csv"],
        &["collect", "ok.h5", "-o", "t.h5"],
        &["plot", "ok.h5"],
        &["export", "ok.h5", "--vtk", "v", "--every", "100"],
        &["new", "mine"],
    ];
    for arguments in all {
        let mut run = Command::new(command.get_program());
        run.args(command.get_args()).args(arguments).current_dir(&at);
        let (code, err) = ended(run.output().expect("the program starts"));
        assert_eq!(code, 6, "{arguments:?}: {err}");
        assert!(err.contains("ermission denied"), "{arguments:?}: {err}");
        assert_eq!(names(&at), ["ok.h5", "s.toml"], "{arguments:?}");
    }
    assert!(std::fs::read(at.join("ok.h5")).expect("readable") == *RESULT);
    std::fs::set_permissions(&at, Permissions::from_mode(0o755)).expect("changed");
}

#[test]
fn truncated_results_are_named_and_touch_nothing() {
    let folder = with_result();
    let at = folder.path();
    for length in [0, 1, 100, 2000, RESULT.len() / 2, RESULT.len() - 1] {
        std::fs::write(at.join("cut.h5"), &RESULT[..length]).expect("written");
        let commands: [&[&str]; 6] = [
            &["info", "cut.h5"],
            &["compare", "cut.h5", "ok.h5"],
            &["compare", "ok.h5", "cut.h5"],
            &["plot", "cut.h5", "-o", "figures"],
            &["export", "cut.h5", "--vtk", "vtk"],
            &["thin", "cut.h5", "-o", "t.h5"],
        ];
        for arguments in commands {
            let (code, err) = fbimpact(at, arguments);
            assert_eq!(code, 6, "{length} {arguments:?}: {err}");
            let cause = if length < 100 { "of another format" } else { "copy it again or repeat the run" };
            assert!(err.starts_with("error: cut.h5: ") && err.contains(cause), "{err}");
            assert_eq!(names(at), ["cut.h5", "ok.h5"], "{arguments:?}");
        }
        // One file that cannot be read does not keep the others out of a table.
        let (code, err) = fbimpact(at, &["collect", "-q", "cut.h5", "ok.h5", "-o", "t.csv"]);
        assert_eq!(code, 0, "{err}");
        let table = std::fs::read_to_string(at.join("t.csv")).expect("readable");
        std::fs::remove_file(at.join("t.csv")).expect("removed");
        assert!(table.contains("cut,unreadable") && table.contains("ok,complete"), "{table}");
    }
}

/// A run of hours in the folder `at`, once another process can read some of its states.
fn long_run(at: &Path) -> Child {
    let mut command = Command::new(PROGRAM);
    let set = ["--set", "simulation.end_time=1000.0"];
    command
        .args(["run", "-q", &scenario("rigid_double_pendulums"), "-o", "out.h5"])
        .args(set)
        .current_dir(at);
    let child = command.stderr(Stdio::piped()).spawn().expect("the program starts");
    let begin = Instant::now();
    while read(&at.join("out.h5.part")).is_none_or(|(_, samples)| samples < 100) {
        assert!(begin.elapsed() < PATIENCE, "the run stores states");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

fn send(child: &Child, signal: &str) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([signal, &id]).status().expect("kill").success());
}

#[test]
fn second_run_on_one_output_is_refused_and_the_first_goes_on() {
    let folder = scratch();
    let at = folder.path();
    let first = long_run(at);
    for force in [&[][..], &["--force"]] {
        let sphere = scenario("sphere_on_plane");
        let run = [&["run", "-q", &sphere, "-o", "out.h5"], force].concat();
        let (code, err) = fbimpact(at, &run);
        assert_eq!(code, 6, "{err}");
        assert!(err.contains("another run is writing this file, choose another name with -o"), "{err}");
    }
    send(&first, "-INT");
    let (code, err) = ended(first.wait_with_output().expect("it ends"));
    assert_eq!(code, 130, "{err}");
    assert!(err.contains("interrupted at t = ") && err.contains("out.h5"), "{err}");
    let (status, samples) = info(&at.join("out.h5"));
    assert!(status == "interrupted" && samples >= 100, "{status} {samples}");
    assert_eq!(names(at), ["out.h5", "out.h5.restart"]);
}

#[test]
fn runs_started_together_leave_one_whole_result() {
    let folder = scratch();
    let at = folder.path();
    let start = || {
        let mut command = Command::new(PROGRAM);
        command.args(["run", "-q", &scenario("sphere_on_plane"), "-o", "out.h5"]).current_dir(at);
        command.stderr(Stdio::piped()).spawn().expect("the program starts")
    };
    let runs: Vec<Child> = (0..4).map(|_| start()).collect();
    let ends: Vec<(i32, String)> =
        runs.into_iter().map(|r| ended(r.wait_with_output().expect("it ends"))).collect();
    assert!(ends.iter().any(|(code, _)| *code == 0), "{ends:?}");
    for (code, err) in ends {
        assert!(code == 0 || (code == 6 && err.contains("runs") | err.contains("another run")), "{err}");
    }
    assert_eq!((info(&at.join("out.h5")).0.as_str(), names(at)), ("complete", vec!["out.h5".to_owned()]));
}

#[test]
fn killed_run_leaves_a_readable_part_and_the_earlier_result() {
    let folder = scratch();
    let at = folder.path();
    std::fs::write(at.join("out.h5"), &*RESULT).expect("written");
    let mut run = long_run(at);
    send(&run, "-KILL");
    run.wait().expect("it ends");
    assert!(
        std::fs::read(at.join("out.h5")).expect("readable") == *RESULT,
        "the earlier result is as it was"
    );
    let (status, samples) = info(&at.join("out.h5.part"));
    assert!(status == "running" && samples >= 100, "{status} {samples}");
    // The readers take what is there.
    for arguments in
        [&["plot", "-q", "out.h5.part", "-o", "f"][..], &["thin", "-q", "out.h5.part", "-o", "t.h5"]]
    {
        let (code, err) = fbimpact(at, arguments);
        assert_eq!(code, 0, "{arguments:?}: {err}");
    }
    // The lock went with the process.
    let (code, err) = fbimpact(at, &["run", &scenario("sphere_on_plane"), "-o", "out.h5"]);
    assert!(code == 0 && err.contains("of a run that did not end is replaced"), "{err}");
    assert!(!at.join("out.h5.part").exists());
}

#[test]
fn terminated_run_is_interrupted_and_does_not_replace_a_result() {
    let folder = scratch();
    let at = folder.path();
    std::fs::write(at.join("out.h5"), &*RESULT).expect("written");
    let run = long_run(at);
    send(&run, "-TERM");
    let (code, err) = ended(run.wait_with_output().expect("it ends"));
    assert!(code == 130 && err.contains("out.h5.part"), "{err}");
    assert_eq!(info(&at.join("out.h5.part")).0, "interrupted");
    assert!(std::fs::read(at.join("out.h5")).expect("readable") == *RESULT);
}

/// Crossed cylinders that touch at once, with contact zones whose factors take many seconds.
const LARGE_ZONES: &str = r#"
simulation.end_time = 4e-5
[materials.steel]
youngs_modulus = 210e9
poissons_ratio = 0.3
density = 7850.0
[bodies.small]
material = "steel"
geometry = { shape = "cylinder", radius = 0.01, length = 0.03 }
discretisation = { degree = 2, elements = [4, 4, 4] }
reduction = { modes = 5 }
position = [-0.015, 0, 0.06]
orientation_deg = [0, 90, 0]
velocity = [0, 0, -0.1]
[bodies.big]
material = "steel"
geometry = { shape = "cylinder", radius = 0.05, length = 0.06 }
discretisation = { degree = 2, elements = [4, 4, 4] }
reduction = { modes = 5 }
position = [0, 0.03, 0]
orientation_deg = [90, 0, 0]
[contacts.c]
contact_body = "small"
target_body = "big"
interval.elements = 20
"#;

#[test]
fn signals_are_obeyed_while_a_fine_model_is_built_and_the_run_can_be_taken_up() {
    let folder = scratch();
    let at = folder.path();
    std::fs::write(at.join("s.toml"), LARGE_ZONES).expect("written");
    let run = ["run", "s.toml", "--no-cache", "-o", "out.h5"];
    let mut command = Command::new(PROGRAM);
    let run = command.args(run).current_dir(at).stderr(Stdio::piped()).spawn().expect("the program starts");
    let begin = Instant::now();
    while !at.join("out.h5.restart").exists() {
        assert!(begin.elapsed() < PATIENCE, "the run begins");
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(1500));
    let asked = Instant::now();
    send(&run, "-INT");
    let (code, err) = ended(run.wait_with_output().expect("it ends"));
    // Within a second, thrice that on a machine that does other things; the models take ten and more.
    assert!(asked.elapsed() < Duration::from_secs(3), "{:?}", asked.elapsed());
    assert!(code == 130 && err.contains("go on with: fbimpact run --resume"), "{err}");
    assert_eq!(
        (info(&at.join("out.h5")).0.as_str(), names(at)),
        ("interrupted", vec!["out.h5".into(), "out.h5.restart".into(), "s.toml".into()])
    );
    // Taken up, it builds the same models again.
    let resume = ["run", "--resume", "out.h5", "--no-cache"];
    let mut command = Command::new(PROGRAM);
    let run =
        command.args(resume).current_dir(at).stderr(Stdio::piped()).spawn().expect("the program starts");
    std::thread::sleep(Duration::from_millis(1500));
    send(&run, "-TERM");
    let (code, err) = ended(run.wait_with_output().expect("it ends"));
    assert!(code == 130 && err.contains("is taken up at t = 0"), "{err}");
    assert_eq!(names(at), ["out.h5", "out.h5.part", "out.h5.restart", "s.toml"]);
}

#[test]
fn a_log_that_nobody_takes_costs_no_run() {
    let folder = scratch();
    let at = folder.path();
    let run = ["run", "-v", &scenario("sphere_on_plane"), "-o", "out.h5"];
    // A full disk, and a reader that is gone.
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
    let status =
        Command::new(PROGRAM).args(run).current_dir(at).stderr(full).status().expect("the program starts");
    assert_eq!((status.code(), info(&at.join("out.h5")).0.as_str()), (Some(0), "complete"));
    std::fs::remove_file(at.join("out.h5")).expect("removed");
    let mut command = Command::new(PROGRAM);
    let mut child =
        command.args(run).current_dir(at).stderr(Stdio::piped()).spawn().expect("the program starts");
    drop(child.stderr.take());
    assert_eq!(child.wait().expect("it ends").code(), Some(0));
    assert_eq!(info(&at.join("out.h5")).0, "complete");
}

#[test]
fn output_goes_through_links_and_never_to_devices_or_names_that_hdf5_cannot_write() {
    use std::os::unix::ffi::OsStrExt;
    let folder = scratch();
    let at = folder.path();
    let sphere = scenario("sphere_on_plane");
    std::fs::create_dir(at.join("disk")).expect("created");
    std::os::unix::fs::symlink("disk/real.h5", at.join("link.h5")).expect("linked");
    let (code, err) = fbimpact(at, &["run", "-q", &sphere, "-o", "link.h5"]);
    assert_eq!(code, 0, "{err}");
    assert!(std::fs::symlink_metadata(at.join("link.h5")).expect("there").is_symlink());
    assert_eq!(
        (info(&at.join("disk/real.h5")).0.as_str(), names(&at.join("disk"))),
        ("complete", vec!["real.h5".to_owned()])
    );

    std::os::unix::fs::symlink("round.h5", at.join("round.h5")).expect("linked");
    let foreign = std::ffi::OsStr::from_bytes(b"bad\xff.h5");
    let cases = [
        ("/dev/null".as_ref(), "is a device or pipe"),
        ("round.h5".as_ref(), "is a link to itself"),
        (foreign, "is no name in UTF-8"),
    ];
    for (name, reason) in cases {
        let mut command = Command::new(PROGRAM);
        let run = command.args(["run", "-q", "--force", &sphere, "-o"]).arg(name).current_dir(at);
        let (code, err) = ended(run.output().expect("the program starts"));
        assert!(code == 6 && err.contains(reason), "{err}");
    }
    assert_eq!(names(at), ["disk", "link.h5", "round.h5"]);
}

#[test]
fn a_run_killed_before_anything_was_stored_starts_anew() {
    let folder = scratch();
    let at = folder.path();
    // Of a body without sizes, which are chosen before the run begins.
    let text = LARGE_ZONES.replace("discretisation = { degree = 2, elements = [4, 4, 4] }\n", "");
    std::fs::write(at.join("s.toml"), text).expect("written");
    let mut command = Command::new(PROGRAM);
    let run = ["run", "-q", "s.toml", "--no-cache", "-o", "out.h5"];
    let mut run = command.args(run).current_dir(at).spawn().expect("the program starts");
    let begin = Instant::now();
    while !at.join("out.h5.restart").exists() {
        assert!(begin.elapsed() < PATIENCE, "the run begins");
        std::thread::sleep(Duration::from_millis(1));
    }
    run.kill().expect("killed");
    run.wait().expect("it ends");
    // Short enough to see its end.
    let mut command = Command::new(PROGRAM);
    let resume = ["run", "--resume", "out.h5", "--no-cache"];
    let run =
        command.args(resume).current_dir(at).stderr(Stdio::piped()).spawn().expect("the program starts");
    std::thread::sleep(Duration::from_millis(1000));
    send(&run, "-INT");
    let (code, err) = ended(run.wait_with_output().expect("it ends"));
    assert!(code == 130 && err.contains("starts anew: no state was stored"), "{err}");
    // A run that is stopped before it begins leaves what an earlier one can be taken up from as it is.
    std::fs::write(at.join("next.h5.restart"), b"fbimpact restart\x01 of an earlier run").expect("written");
    let mut command = Command::new(PROGRAM);
    let run = ["run", "s.toml", "--no-cache", "-o", "next.h5"];
    let run = command.args(run).current_dir(at).stderr(Stdio::piped()).spawn().expect("the program starts");
    let begin = Instant::now();
    while !at.join("next.h5.part").exists() {
        assert!(begin.elapsed() < PATIENCE, "the run begins");
        std::thread::sleep(Duration::from_millis(1));
    }
    send(&run, "-TERM");
    let (code, err) = ended(run.wait_with_output().expect("it ends"));
    assert!(
        code == 130 && err.contains("nothing is stored"),
        "sizes take longer to choose than a signal: {err}"
    );
    let left: Vec<_> = names(at).into_iter().filter(|name| name.starts_with("next")).collect();
    assert_eq!(left, ["next.h5.restart"]);
    assert_eq!(
        std::fs::read(at.join("next.h5.restart")).expect("there"),
        b"fbimpact restart\x01 of an earlier run"
    );
}

#[test]
fn more_threads_than_the_machine_has_use_are_not_started() {
    let folder = scratch();
    let run = ["run", &scenario("rod_on_plane"), "--threads", "100000", "-o", "out.h5"];
    let (code, err) = fbimpact(folder.path(), &run);
    assert!(code == 0 && err.contains("in place of 100000"), "{err}");
}

#[test]
fn folder_removed_under_a_run_is_an_error_and_no_crash() {
    let folder = scratch();
    let at: PathBuf = folder.path().join("gone");
    std::fs::create_dir(&at).expect("created");
    let run = long_run(&at);
    std::fs::remove_dir_all(&at).expect("removed");
    send(&run, "-INT");
    let (code, err) = ended(run.wait_with_output().expect("it ends"));
    assert_eq!(code, 6, "{err}");
    assert!(err.contains("out.h5.part") && err.contains("final name"), "{err}");
}
