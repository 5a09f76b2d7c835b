//! Limits of a batch system: memory that is less than the machine's, signals that come before the time is over, outputs that cannot be.

#![cfg(target_os = "linux")]

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const PROGRAM: &str = env!("CARGO_BIN_EXE_fbimpact");
const PATIENCE: Duration = Duration::from_secs(120);

fn scenario(name: &str) -> String {
    format!("{}/scenarios/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

fn ended(output: Output) -> (Option<i32>, String) {
    (output.status.code(), String::from_utf8(output.stderr).expect("UTF-8"))
}

/// Runs a script of the shell in `at`, for which `$0` is the program and `$@` are `arguments`.
fn shell(at: &Path, script: &str, arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new("sh").args(["-c", script, PROGRAM]).args(arguments).current_dir(at).output();
    ended(output.expect("a shell"))
}

/// Runs the program in `at` under a limit, option and number of `ulimit`.
fn within(at: &Path, limit: &str, arguments: &[&str]) -> (Option<i32>, String) {
    shell(at, &format!("ulimit {limit} && exec \"$0\" \"$@\""), arguments)
}

/// A run of the rigid pendulums to `out.h5`; what `--set` sets follows.
fn pendulums() -> [String; 6] {
    ["run", "-q", &scenario("rigid_double_pendulums"), "-o", "out.h5", "--set"].map(str::to_owned)
}

#[test]
fn runs_within_few_addresses_are_complete_or_say_that_memory_ends() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut failed = 0;
    for name in ["sphere_on_plane", "rigid_double_pendulums"] {
        for mebibytes in [40, 60, 100, 150, 195, 300, 600] {
            let output = folder.path().join(format!("{name}-{mebibytes}.h5"));
            let arguments =
                ["run", "-q", "--threads", "2", "-o", output.to_str().expect("UTF-8"), &scenario(name)];
            let arguments = [&arguments[..], &["--set", "simulation.end_time=1e-3"]].concat();
            let (code, err) = within(folder.path(), &format!("-v {}", mebibytes << 10), &arguments);
            assert!(matches!(code, Some(0 | 4 | 5 | 6)), "{name}, {mebibytes} MiB: {code:?} {err}");
            assert!(!err.contains("panicked"), "{err}");
            if code == Some(4) {
                failed += 1;
                assert!(err.contains("error: memory ends") || err.contains("(--memory)"), "{err}");
            }
        }
    }
    assert!(failed > 0, "memory ends somewhere");
}

#[test]
fn a_factor_larger_than_the_addresses_left_is_refused_with_its_size() {
    let folder = tempfile::tempdir().expect("a folder");
    let arguments = ["run", "-q", &scenario("sphere_on_plane"), "-o", "out.h5", "--memory", "0.04"];
    let output = Command::new(PROGRAM).args(arguments).current_dir(folder.path()).output();
    let (code, err) = ended(output.expect("it starts"));
    assert_eq!(code, Some(4), "{err}");
    assert!(!err.contains(" 0.00 GB") && !err.contains(" 0 GB of"), "{err}");
}

#[test]
fn small_stacks_and_long_expressions_end_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let sum = format!("1{}", "+1".repeat(12_000));
    let run = pendulums();
    let run = [&run.each_ref().map(String::as_str)[..], &["simulation.end_time=1e-2"]].concat();
    for stack in ["-s 64", "-s 128", "-s 8192"] {
        for arguments in
            [&run[..], &["check", &scenario("sphere_on_plane")], &["metric", "out.h5", &sum], &["man", "run"]]
        {
            let (code, err) = within(folder.path(), stack, arguments);
            assert_eq!(code, Some(0), "{stack}, {}: {err}", arguments[0]);
        }
        let counted = "ulimit $2 && \"$0\" metric out.h5 \"$1\" | grep -q 12001";
        assert_eq!(shell(folder.path(), counted, &[&sum, stack]).0, Some(0));
    }
}

/// A run that is interrupted on a small stack closes its files as ever.
#[test]
fn a_run_on_a_small_stack_obeys_signals() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = "ulimit -s 64; \"$0\" run -q \"$1\" -o out.h5 --set simulation.end_time=1000.0 & \
        pid=$!; while [ ! -s out.h5.restart ]; do sleep 0.05; done; sleep 0.3; kill -TERM $pid; wait $pid";
    let (code, err) = shell(folder.path(), script, &[&scenario("rigid_double_pendulums")]);
    assert!(code == Some(130) && err.contains("go on with: fbimpact run --resume out.h5"), "{code:?} {err}");
}

#[test]
fn a_run_whose_files_may_not_grow_is_taken_up_when_they_may() {
    let folder = tempfile::tempdir().expect("a folder");
    let run = pendulums();
    let run = [&run.each_ref().map(String::as_str)[..], &["simulation.end_time=1.0"]].concat();
    // 2000 blocks of 512 bytes hold the first states.
    let (code, err) = within(folder.path(), "-f 2000", &run);
    assert!(code == Some(6) && err.contains("ulimit -f"), "{code:?} {err}");
    let (code, err) = shell(folder.path(), "exec \"$0\" run -q --resume out.h5", &[]);
    assert_eq!(code, Some(0), "{err}");
}

/// A run of the rigid pendulums in `at` that has stored states and goes on for long.
fn long_run(at: &Path) -> Child {
    let mut command = Command::new(PROGRAM);
    command.args(["run", "-q", &scenario("rigid_double_pendulums"), "-o", "out.h5"]);
    command.args(["--set", "simulation.end_time=1000.0"]).current_dir(at);
    let child = command.stderr(Stdio::piped()).spawn().expect("the program starts");
    let begin = Instant::now();
    let part = at.join("out.h5.part");
    let rows = || {
        let file = hdf5::File::with_options().with_fapl(|p| p.file_locking(false)).open(&part).ok()?;
        Some(file.dataset("time").ok()?.size())
    };
    while rows().is_none_or(|rows| rows < 100) {
        assert!(begin.elapsed() < PATIENCE, "the run stores states");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

#[test]
fn signals_of_batch_systems_end_a_run_with_its_result_stored() {
    let folder = tempfile::tempdir().expect("a folder");
    // A process started with SIGHUP ignored, as by `nohup`, leaves it so to those it starts.
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:")).expect("a mask");
    let ignores_hangup = u64::from_str_radix(ignored.trim(), 16).expect("a mask") & 1 != 0;
    for signal in ["USR1", "USR2", "XCPU", "HUP"] {
        if signal == "HUP" && ignores_hangup {
            continue;
        }
        let at = folder.path().join(signal);
        std::fs::create_dir(&at).expect("created");
        let child = long_run(&at);
        let id = child.id().to_string();
        assert!(Command::new("kill").args([&format!("-{signal}"), &id]).status().expect("kill").success());
        let (code, err) = ended(child.wait_with_output().expect("it ends"));
        assert_eq!(code, Some(130), "{signal}: {err}");
        assert!(err.contains("the results so far are in out.h5; go on with"), "{signal}: {err}");
        assert!(at.join("out.h5").exists() && at.join("out.h5.restart").exists(), "{signal}");
    }
}

#[test]
fn signals_that_the_process_was_told_to_ignore_do_not_end_a_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = "trap '' HUP; \"$0\" run -q \"$1\" -o out.h5 --set simulation.end_time=0.5 & \
        pid=$!; sleep 0.5; kill -HUP $pid; wait $pid";
    let (code, err) = shell(folder.path(), script, &[&scenario("rigid_double_pendulums")]);
    assert_eq!(code, Some(0), "{err}");
}

#[test]
fn outputs_that_the_last_rename_would_refuse_are_refused_before_any_work() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path();
    let long = ["--set", "simulation.end_time=1e5"];
    std::fs::create_dir(at.join("there")).expect("created");
    assert!(Command::new("mkfifo").arg(at.join("p.h5.part")).status().expect("mkfifo").success());
    std::fs::create_dir(at.join("d.h5.restart")).expect("created");
    let before = names(at);
    for (output, reason) in [
        ("out/", "is a directory, name a file with -o"),
        ("out/.", "is a directory, name a file with -o"),
        ("there", "is a directory, name a file with -o"),
        ("no/out.h5", "does not exist, create it or choose another one"),
        ("/dev/null", "is a device or pipe, name a file with -o"),
        ("/proc/out.h5", "cannot be written"),
        ("p.h5", "is a device or pipe, name a file with -o"),
        ("d.h5", "is a device or pipe, name a file with -o"),
    ] {
        let arguments = ["run", "-q", &scenario("rigid_double_pendulums"), "-o", output];
        let begin = Instant::now();
        let run = Command::new("timeout")
            .arg("60")
            .arg(PROGRAM)
            .args(arguments)
            .args(long)
            .current_dir(at)
            .output();
        let (code, err) = ended(run.expect("it starts"));
        assert!(code == Some(6) && err.contains(reason), "{output}: {code:?} {err}");
        assert!(begin.elapsed() < PATIENCE);
        assert_eq!(names(at), before, "{output} leaves nothing");
    }
}

fn names(at: &Path) -> Vec<PathBuf> {
    let mut names: Vec<PathBuf> =
        std::fs::read_dir(at).expect("a folder").map(|e| e.expect("there").path()).collect();
    names.sort();
    names
}
