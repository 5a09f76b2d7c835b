//! `fbimpact run --resume`: runs that are killed or interrupted, at whatever moment, end as those that are left alone.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use result_files::stored::summary::{self, Summary};
use result_files::stored::{Kind, Stored};

use fbimpact::results::OutputFile;

/// Kills of the second tier for each of the first one.
const MANY: u32 = 5;
/// Bodies share datasets.
const ARRAYS: &[&str] = &["--set", "output.arrays=true"];

fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
    // One thread: tests run side by side.
    command.args(arguments).env("RAYON_NUM_THREADS", "1").stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn fbimpact(arguments: &[&str]) -> (i32, String) {
    let output = program(arguments).output().expect("the program starts");
    let text = [output.stdout, output.stderr].concat();
    (output.status.code().expect("no signal"), String::from_utf8(text).expect("UTF-8"))
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn scenario(name: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    text(&root.join(format!("scenarios/{name}.toml"))).to_owned()
}

fn beside(path: &Path, ending: &str) -> PathBuf {
    PathBuf::from(format!("{}{ending}", path.display()))
}

/// Ends a process as the system does, without notice.
fn kill(mut child: Child) {
    child.kill().expect("it can be killed");
    child.wait().expect("it ends");
}

/// Waits until `path` is there.
fn wait_for(path: &Path) {
    let begin = Instant::now();
    while !path.exists() {
        assert!(begin.elapsed() < Duration::from_secs(60), "{} does not come", path.display());
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Numbers of a linear congruential generator (Knuth), between 0 and 1.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// Every number that is not a measured time agrees to the last bit.
fn assert_equal(new: &Path, reference: &Path) {
    let [a, b] = [new, reference].map(|p| Stored::open(p).unwrap_or_else(|e| panic!("{e}")));
    assert_eq!(a.time, b.time);
    assert_eq!(a.scenario, b.scenario);
    assert_eq!(a.entries.keys().collect::<Vec<_>>(), b.entries.keys().collect::<Vec<_>>());
    let bits = |s: &Stored, name: &str| {
        s.values(name).expect("readable").iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    };
    for (name, entry) in a.entries.iter().filter(|(name, _)| !name.starts_with("timings/")) {
        assert_eq!(entry, &b.entries[name], "{name}");
        assert!(entry.kind == Kind::Other || bits(&a, name) == bits(&b, name), "{name} differs");
    }
    let [a, b] = [new, reference].map(|p| without_clocks(summary::read(p).expect("readable")));
    // Where there is no restitution it is NaN, which equals nothing.
    assert_eq!(format!("{:?}", a.impacts), format!("{:?}", b.impacts));
    assert_eq!(a.phases, b.phases);
    assert_eq!(a.trials, b.trials);
    assert_eq!(a.events, b.events);
    assert_eq!(a.transfers, b.transfers);
    assert_eq!(a.attribute("status"), "complete");
    let (code, table) = fbimpact(&["compare", text(new), text(reference), "--rtol", "1e-14"]);
    assert_eq!(code, 0, "{table}");
}

fn without_clocks(mut s: Summary) -> Summary {
    s.phases.iter_mut().for_each(|p| p.wall_time = 0.0);
    s.trials.iter_mut().for_each(|t| (t.wall_time, t.cpu_time) = (0.0, 0.0));
    s
}

/// The arguments that run `scenario` from its start.
fn first<'a>(scenario: &'a str, output: &'a Path, options: &[&'a str]) -> Vec<&'a str> {
    [&["run", scenario, "-q", "-o", text(output)], options].concat()
}

/// Kills the run `kills` times at random moments, resumes it, which is killed as well every third time, and compares.
fn killed_runs_end_alike(name: &str, options: &[&str], kills: u32, seed: u64) {
    let directory = tempfile::tempdir().expect("a directory");
    let (scenario, reference) = (scenario(name), directory.path().join("reference.h5"));
    let begin = Instant::now();
    let (code, log) = fbimpact(&first(&scenario, &reference, options));
    assert_eq!(code, 0, "{log}");
    let mut duration = begin.elapsed().as_secs_f64();
    let mut random = Random(seed);
    let mut again = 0;
    for i in 0..kills {
        let output = directory.path().join(format!("{i}.h5"));
        let restart = beside(&output, ".restart");
        let mut arguments = first(&scenario, &output, options);
        loop {
            let child = program(&arguments).spawn().expect("the program starts");
            std::thread::sleep(Duration::from_secs_f64(duration * random.next()));
            kill(child);
            if output.exists() {
                // The machine is faster now.
                duration *= 0.7;
                std::fs::remove_file(&output).expect("removable");
                arguments = first(&scenario, &output, options);
                continue;
            }
            if !restart.exists() {
                continue; // it had not begun
            }
            arguments = vec!["run", "-q", "--resume", text(&output)];
            if (i + again) % 3 != 0 {
                break;
            }
            again += 1; // the resumed one, too
        }
        let (code, log) = fbimpact(&["run", "-q", "--resume", text(&output)]);
        assert_eq!(code, 0, "kill {i}: {log}");
        assert_equal(&output, &reference);
        std::fs::remove_file(&output).expect("removable");
        assert_eq!(std::fs::read_dir(directory.path()).expect("readable").count(), 1, "nothing else is left");
    }
}

#[test]
fn killed_runs_of_a_sphere_on_a_plane_end_alike() {
    killed_runs_end_alike("sphere_on_plane", &[], 4, 1);
}

#[test]
fn killed_runs_with_refined_contacts_end_alike() {
    killed_runs_end_alike("sphere_rod_sphere", &[], 2, 2);
}

#[test]
fn killed_runs_of_rigid_pendulums_end_alike() {
    killed_runs_end_alike("rigid_double_pendulums", ARRAYS, 4, 3);
}

#[test]
#[ignore = "second tier: minutes"]
fn fifty_killed_runs_end_alike() {
    killed_runs_end_alike("sphere_on_plane", ARRAYS, 4 * MANY, 1);
    killed_runs_end_alike("sphere_rod_sphere", &[], 2 * MANY, 2);
    killed_runs_end_alike("rigid_double_pendulums", &[], 4 * MANY, 3);
}

#[cfg(unix)]
#[test]
fn interrupted_run_goes_on_and_replaces_its_result() {
    let directory = tempfile::tempdir().expect("a directory");
    let [output, reference] = ["a.h5", "b.h5"].map(|n| directory.path().join(n));
    let scenario = scenario("rigid_double_pendulums");
    let (code, log) = fbimpact(&["run", &scenario, "-q", "-o", text(&reference)]);
    assert_eq!(code, 0, "{log}");
    let child = program(&["run", &scenario, "-o", text(&output)]).spawn().expect("the program starts");
    wait_for(&beside(&output, ".restart"));
    std::thread::sleep(Duration::from_millis(60));
    let signal = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(signal.success());
    let ended = child.wait_with_output().expect("it ends");
    let log = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(130), "{log}");
    assert!(log.contains("--resume"), "the message tells how to go on: {log}");
    let stopped = summary::read(&output).expect("readable");
    assert_eq!((stopped.attribute("status"), stopped.resumptions), ("interrupted", 0));
    let (code, log) = fbimpact(&["run", "--resume", text(&output)]);
    assert_eq!(code, 0, "{log}");
    assert!(log.contains("is taken up at t = "), "{log}");
    assert_equal(&output, &reference);
    assert_eq!(summary::read(&output).expect("readable").resumptions, 1);
    let (code, info) = fbimpact(&["info", text(&output)]);
    assert!(code == 0 && info.contains("resumed once"), "{info}");
    assert!(!beside(&output, ".restart").exists() && !beside(&output, ".part").exists());
}

/// A steel ball on a steel beam between two hinges: fine models take most of the time.
#[cfg(unix)]
const STRUCK_BEAM: &str = r#"
[simulation]
end_time = 1.0e-3
[materials.steel]
youngs_modulus = 215.8e9
poissons_ratio = 0.3
density = 7960.0
[bodies.beam]
model = "solid"
material = "steel"
geometry = { shape = "box", size = [0.307, 0.01, 0.01] }
[bodies.ball]
model = "solid"
material = "steel"
geometry = { shape = "sphere", radius = 20.0e-3 }
position = [0.0, 0.0, 0.025001]
velocity = [0.0, 0.0, -0.01]
[joints.left]
type = "revolute"
axis = [0.0, 1.0, 0.0]
parent = { body = "ground", point = [-0.1535, 0.0, 0.0] }
child = { body = "beam", face = "x-" }
[joints.right]
type = "revolute"
axis = [0.0, 1.0, 0.0]
parent = { body = "ground", point = [0.1535, 0.0, 0.0] }
child = { body = "beam", face = "x+" }
closes_loop = true
[contacts.touch]
contact_body = "ball"
target_body = "beam"
"#;

/// Sends `signals` signals to runs of `scenario`, four to each, at random moments; every one is obeyed at once, and the runs end as one that
/// is left alone. Without the cache, so that every run builds its models.
#[cfg(unix)]
fn signalled_runs_end_alike(scenario: &str, signals: u32, seed: u64) {
    const IN_A_RUN: u32 = 4;
    let directory = tempfile::tempdir().expect("a directory");
    let [output, reference] = ["a.h5", "b.h5"].map(|n| directory.path().join(n));
    let begin = Instant::now();
    let (code, log) = fbimpact(&["run", scenario, "-q", "--no-cache", "-o", text(&reference)]);
    assert_eq!(code, 0, "{log}");
    let (duration, mut random) = (begin.elapsed().as_secs_f64(), Random(seed));
    let mut sent = 0;
    while sent < signals {
        let mut arguments = vec!["run", scenario, "-q", "--no-cache", "-o", text(&output)];
        for _ in 0..IN_A_RUN {
            let mut child = program(&arguments).spawn().expect("the program starts");
            std::thread::sleep(Duration::from_secs_f64(duration * random.next()));
            if child.try_wait().expect("its state").is_some() {
                break;
            }
            let signal = if sent % 2 == 0 { "-INT" } else { "-TERM" };
            let asked = Instant::now();
            let id = child.id().to_string();
            assert!(Command::new("kill").args([signal, &id]).status().expect("kill runs").success());
            let ended = child.wait_with_output().expect("it ends");
            let log = String::from_utf8_lossy(&ended.stderr);
            // Within a second; a machine that does other things, as one with tests side by side, needs more.
            assert!(asked.elapsed() < Duration::from_secs(2), "{signal} after {sent}: {:?}", asked.elapsed());
            sent += 1;
            match ended.status.code() {
                Some(0) => break, // it was about to end
                Some(130) => {}
                code => panic!("{signal}: {code:?} {log}"),
            }
            if beside(&output, ".restart").exists() {
                arguments = vec!["run", "-q", "--no-cache", "--resume", text(&output)];
            }
        }
        if !output.exists() || beside(&output, ".restart").exists() {
            let (code, log) = fbimpact(&arguments);
            assert_eq!(code, 0, "{log}");
        }
        assert_equal(&output, &reference);
        std::fs::remove_file(&output).expect("removable");
    }
}

#[cfg(unix)]
#[test]
#[ignore = "second tier: a quarter of an hour"]
fn fifty_signals_are_obeyed_at_once_and_the_runs_end_alike() {
    let directory = tempfile::tempdir().expect("a directory");
    let beam = directory.path().join("struck_beam.toml");
    std::fs::write(&beam, STRUCK_BEAM).expect("written");
    signalled_runs_end_alike(text(&beam), 25, 4);
    signalled_runs_end_alike(&scenario("double_pendulum"), 25, 5);
}

/// A run of `scenario` to `output`, killed when the first state is stored.
fn killed(scenario: &str, output: &Path) {
    let child = program(&["run", scenario, "-q", "-o", text(output)]).spawn().expect("the program starts");
    wait_for(&beside(output, ".restart"));
    std::thread::sleep(Duration::from_millis(30));
    kill(child);
    assert!(!output.exists(), "too late");
}

#[test]
fn what_cannot_be_resumed_is_told_and_left_as_it_is() {
    let directory = tempfile::tempdir().expect("a directory");
    let output = directory.path().join("a.h5");
    let resume = |expected: i32, words: &str| {
        let (code, log) = fbimpact(&["run", "--resume", text(&output)]);
        assert_eq!(code, expected, "{log}");
        assert!(log.contains(words), "{log}");
    };
    resume(6, "no such run");
    assert_eq!(std::fs::read_dir(directory.path()).expect("readable").count(), 0);

    let pendulums = scenario("rigid_double_pendulums");
    killed(&pendulums, &output);
    let (part, restart) = (beside(&output, ".part"), beside(&output, ".restart"));
    {
        let _running = OutputFile::claim_again(&output, false).expect("free");
        resume(6, "another run is writing this file");
    }
    let whole = std::fs::read(&restart).expect("readable");
    std::fs::write(&restart, &whole[..40]).expect("writable");
    resume(6, "is damaged");
    std::fs::write(&restart, b"something else, and long enough to be a header").expect("writable");
    resume(6, "is damaged or no restart file");
    let mut later = whole.clone();
    later[16] += 1;
    std::fs::write(&restart, &later).expect("writable");
    resume(6, "another version of the program");
    std::fs::remove_file(&restart).expect("removable");
    resume(6, "cannot be resumed without");
    assert!(part.exists(), "what was computed is kept");

    std::fs::write(&restart, &whole).expect("writable");
    // The part file has no say: its state is that of the last flush, or worse.
    std::fs::write(&part, b"damaged").expect("writable");
    let (code, log) = fbimpact(&["run", "-q", "--resume", text(&part)]);
    assert_eq!(code, 0, "{log}");
    resume(6, "is complete, there is nothing to resume");
}

#[test]
fn command_line_takes_a_scenario_or_a_result_to_resume() {
    for arguments in [
        &["run"][..],
        &["run", "a.toml", "--resume", "a.h5"],
        &["run", "--resume", "a.h5", "--set", "simulation.end_time=2.0"],
        &["run", "--resume", "a.h5", "-o", "b.h5"],
    ] {
        assert_eq!(fbimpact(arguments).0, 2, "{arguments:?}");
    }
}
