//! `fbimpact collect`, `fbimpact new` and `scripts/sweep.sh`, run as a user would.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const PROGRAM: &str = env!("CARGO_BIN_EXE_fbimpact");

fn scratch() -> TempDir {
    tempfile::tempdir().expect("a temporary directory")
}

fn output(program: &str, directory: &Path, arguments: &[&str]) -> (i32, String, String) {
    let mut command = Command::new(program);
    command.args(arguments).current_dir(directory).env("FBIMPACT", PROGRAM).env("JOBS", "2");
    // `sbatch` of a test that has one stands in its folder.
    let path = std::env::var("PATH").unwrap_or_default();
    let output =
        command.env("PATH", format!("{}:{path}", directory.display())).output().expect("the program starts");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
}

fn fbimpact(directory: &Path, arguments: &[&str]) -> (i32, String, String) {
    output(PROGRAM, directory, arguments)
}

fn scenario() -> String {
    format!("{ROOT}/scenarios/sphere_on_plane.toml")
}

/// Rows of a CSV table by the names of the columns.
struct Csv {
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Csv {
    fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).expect("readable");
        let (mut rows, mut quoted) = (vec![vec![String::new()]], false);
        for c in text.chars() {
            let row = rows.last_mut().expect("one at least");
            match c {
                '"' => quoted = !quoted,
                ',' if !quoted => row.push(String::new()),
                '\n' if !quoted => rows.push(vec![String::new()]),
                c => row.last_mut().expect("one at least").push(c),
            }
        }
        rows.pop(); // behind the last line end
        let names = rows.remove(0);
        assert!(rows.iter().all(|r| r.len() == names.len()), "{text}");
        Self { names, rows }
    }

    fn column(&self, name: &str) -> Vec<&str> {
        let i =
            self.names.iter().position(|n| n == name).unwrap_or_else(|| panic!("{name} in {:?}", self.names));
        self.rows.iter().map(|r| r[i].as_str()).collect()
    }

    fn sorted(&self, name: &str) -> Vec<&str> {
        let mut cells = self.column(name);
        cells.sort_unstable();
        cells
    }
}

#[test]
fn sweep_survives_failed_runs_skips_finished_ones_and_can_be_extended() {
    let directory = scratch();
    let at = directory.path();
    let script = format!("{ROOT}/scripts/sweep.sh");
    let (speeds, stiffness) =
        ("bodies.ball.velocity=[0,0,-0.05] [0,0,-0.1]", "materials.aluminium.youngs_modulus=70e9 -1");
    let sweep = |grid: &[&str]| output(&script, at, &[&[scenario().as_str(), "out"], grid].concat());
    let (code, _, err) = sweep(&[speeds, stiffness]);
    assert_eq!(code, 1, "{err}");
    assert!(err.contains("2 of 4 runs failed"), "{err}");
    let csv = Csv::read(&at.join("out/table.csv"));
    assert_eq!(csv.sorted("status"), ["complete", "complete", "failed", "failed"]);
    assert_eq!(csv.sorted("exit_code"), ["0", "0", "3", "3"]);
    assert_eq!(csv.sorted("set.bodies.ball.velocity")[1..3], ["[0, 0, -0.05]", "[0, 0, -0.1]"]);
    assert_eq!(
        csv.sorted("set.materials.aluminium.youngs_modulus"),
        ["-1", "-1", "70000000000", "70000000000"]
    );
    let failed = csv.column("status").iter().position(|s| *s == "failed").expect("two failed");
    assert!(csv.column("message")[failed].contains("must be a number > 0"), "{:?}", csv.rows[failed]);

    let written = |at: &Path| {
        let files = std::fs::read_dir(at.join("out")).expect("readable").map(|e| e.expect("readable").path());
        let results = files.filter(|p| p.extension().is_some_and(|e| e == "h5") && !p.ends_with("table.h5"));
        let mut times: Vec<_> =
            results.map(|p| (p.clone(), p.metadata().and_then(|m| m.modified()).expect("a time"))).collect();
        times.sort();
        times
    };
    let before = written(at);
    assert_eq!(before.len(), 2);
    let (code, _, err) = sweep(&[speeds, "materials.aluminium.youngs_modulus=70e9"]);
    assert_eq!(code, 0, "{err}");
    assert_eq!(written(at), before, "finished runs are skipped");
    let (code, _, err) = sweep(&[
        "bodies.ball.velocity=[0,0,-0.05] [0,0,-0.1] [0,0,-0.2]",
        "materials.aluminium.youngs_modulus=70e9",
    ]);
    assert_eq!(code, 0, "{err}");
    assert_eq!(written(at).len(), 3);
    let csv = Csv::read(&at.join("out/table.csv"));
    let peaks: Vec<f64> = csv.column("impact[1].peak_force").iter().filter_map(|c| c.parse().ok()).collect();
    assert_eq!(peaks.len(), 3);
    // F ~ v^1.2 (Hertz): 22.3, 51.3 and 118 N.
    assert!(peaks.iter().any(|p| (p - 118.0).abs() < 1.0), "{peaks:?}");
    let table = result_files::file::hdf5_integrity::open(&at.join("out/table.h5")).expect("a table");
    let peak = table.dataset("runs/impact[1].peak_force").expect("a column");
    assert_eq!(peak.read_raw::<f64>().expect("numbers").iter().filter(|p| p.is_finite()).count(), 3);

    assert_eq!(sweep(&["novalue"]).0, 2);
    std::fs::write(at.join("out/scenario.path"), "of another one").expect("written");
    let (code, _, err) = sweep(&[speeds]);
    assert!(code == 2 && err.contains("was begun with"), "{err}");
    std::fs::create_dir(at.join("mine")).expect("made");
    std::fs::write(at.join("mine/plan"), "of a house").expect("written");
    let (code, _, err) = output(&script, at, &[&scenario(), "mine", speeds]);
    assert!(code == 2 && err.contains("of no sweep"), "{err}");
    assert_eq!(std::fs::read_to_string(at.join("mine/plan")).expect("there"), "of a house");
}

/// A block that is pushed by a force from a file beside the scenario: a run takes milliseconds.
fn pushed_block(scenario: &Path) {
    let text = "[simulation]\nend_time = 1e-3\n[bodies.block]\nmodel = \"rigid\"\nmass = 0.5\ninertia = [1e-4, 1e-4, 1e-4]\n\
                [loads.push]\nbody = \"block\"\npoint = [0.0, 0.0, 0.0]\n\
                force_x = { kind = \"table\", file = \"push.csv\", interpolation = \"linear\" }\n";
    std::fs::write(scenario, text).expect("written");
    std::fs::write(scenario.with_file_name("push.csv"), "t,F\n0,0\n1,10\n").expect("written");
}

/// Names that a shell, `xargs`, Slurm, TOML or a terminal may take for something else.
const HOSTILE: [&str; 9] = [
    "my drop",
    "o'neill",
    "x;touch RAN;",
    "$(touch RAN)",
    "`touch RAN`",
    "-rf {} %j",
    "a\nb\"c",
    "\\x && touch RAN #",
    "ö*?[a]",
];

#[test]
fn sweeps_take_any_name_for_a_name() {
    let slurm = "#!/bin/sh\nfor word; do case $last in --wrap) wrap=$word ;; esac; last=$word\n\
                 case $word in --array=*) n=${word#--array=1-} n=${n%%%*} ;; esac; done\n\
                 for SLURM_ARRAY_TASK_ID in $(seq ${n:-1}); do export SLURM_ARRAY_TASK_ID; sh -c \"$wrap\" >&2; done; echo 7\n";
    for (script, hostile) in ["sweep.sh", "sweep_slurm.sh"].iter().flat_map(|s| HOSTILE.map(|h| (s, h))) {
        let directory = scratch();
        let at = directory.path();
        std::fs::write(at.join("sbatch"), slurm).expect("written");
        std::fs::set_permissions(at.join("sbatch"), std::os::unix::fs::PermissionsExt::from_mode(0o755))
            .expect("made");
        let (name, folder) = (format!("{hostile}.toml"), format!("out {hostile}"));
        pushed_block(&at.join(&name));
        let script = format!("{ROOT}/scripts/{script}");
        let (code, _, err) = output(&script, at, &[&name, &folder, "bodies.block.mass=1 2"]);
        assert_eq!(code, 0, "{script} {hostile}: {err}");
        let csv = Csv::read(&at.join(&folder).join("table.csv"));
        assert_eq!(csv.column("set.bodies.block.mass"), ["1", "2"], "{script} {hostile}");
        assert_eq!(csv.column("status"), ["complete"; 2], "{script} {hostile}");
        assert!(!at.join("RAN").exists() && !at.join(&folder).join("RAN").exists(), "{script} {hostile}");
    }
}

/// What Snakemake puts into lines for a shell is a number and the name of a run; all else stands in the environment, quoted. The Python package's
/// tests run it with such names where it is installed.
#[test]
fn snakemake_hands_no_name_to_a_shell() {
    let text = std::fs::read_to_string(format!("{ROOT}/scripts/Snakefile")).expect("readable");
    let shells: Vec<&str> = text.split("shell:").skip(1).filter_map(|s| s.split("\n\n").next()).collect();
    let filled = |what: &str| shells.iter().map(|shell| shell.matches(what).count()).sum::<usize>();
    assert_eq!((shells.len(), ["{threads}", "{wildcards.run}", "{"].map(filled)), (2, [1, 1, 2]));
    assert!(text.contains("{{run,run-[0-9a-f]+}}"), "names of runs have no other characters");
    let is_quoted = |shell: &str, at: usize| shell[..at].matches('"').count() % 2 == 1;
    assert!(shells.iter().all(|shell| shell.match_indices('$').all(|(at, _)| is_quoted(shell, at))));
}

/// The scenario, a file that it names, the program: what has changed runs again, and nothing else does.
#[test]
fn rows_of_a_sweep_are_of_the_scenario_and_its_files_as_they_are() {
    let directory = scratch();
    let at = directory.path();
    pushed_block(&at.join("push.toml"));
    let script = format!("{ROOT}/scripts/sweep.sh");
    let speed = || {
        let column = "v=bodies.block.velocity[-1].x";
        let words = ["push.toml", "out", "bodies.block.mass=1 2"];
        let (code, _, err) = output(&script, at, &words);
        assert_eq!(code, 0, "{err}");
        assert_eq!(fbimpact(at, &["collect", "out", "-o", "t.csv", "--column", column]).0, 0);
        let csv = Csv::read(&at.join("t.csv"));
        let hashes = ["scenario_sha256", "inputs_sha256"]
            .map(|c| csv.column(c).into_iter().map(str::to_owned).collect::<Vec<_>>());
        let v = csv.column("v")[0].parse::<f64>().expect("a number");
        (v, hashes, err.matches("complete in").count())
    };
    let (first, hashes, runs) = speed();
    assert_eq!(runs, 2);
    assert_eq!((hashes[0][0].len(), hashes[1][0].len()), (64, 64), "{hashes:?}");
    assert!(hashes[0][0] == hashes[0][1] && hashes[1][0] != hashes[1][1], "{hashes:?}");
    assert_eq!(speed(), (first, hashes.clone(), 0), "nothing has changed");
    std::fs::write(at.join("push.csv"), "t,F\n0,0\n1,20\n").expect("written");
    let (second, others, runs) = speed();
    // Twice the force, twice the speed: round-off of the integration is left.
    assert!(runs == 2 && (second / first - 2.0).abs() < 1e-9, "{first} {second}");
    assert!(others[0] == hashes[0] && others[1] != hashes[1], "{hashes:?} {others:?}");
    let text = std::fs::read_to_string(at.join("push.toml")).expect("there");
    std::fs::write(at.join("push.toml"), text.replace("1e-3", "2e-3")).expect("written");
    let (third, _, runs) = speed();
    assert!(runs == 2 && third > 3.0 * second, "{second} {third}");
    std::fs::write(at.join("push.toml"), text.replace("1e-3", "2e-3") + "# a remark\n").expect("written");
    assert_eq!(speed().2, 0, "the same scenario in other words");
}

#[test]
fn collect_has_a_row_for_every_run_whatever_became_of_it() {
    let directory = scratch();
    let at = directory.path();
    let run = |name: &str, velocity: &str| {
        let set = format!("bodies.ball.velocity=[0,0,{velocity}]");
        let (code, _, err) = fbimpact(at, &["run", &scenario(), "-q", "-o", name, "--set", &set]);
        assert_eq!(code, 0, "{err}");
    };
    run("a.h5", "-0.05");
    run("b.h5", "-0.1");
    std::fs::write(at.join("c.h5"), "no HDF5").expect("written");
    std::fs::write(at.join("d.exit"), "5\n").expect("written");
    std::fs::write(at.join("e.set"), "bodies.ball.velocity=[0,0,-1.0]\n").expect("written");
    std::fs::write(at.join("notes.txt"), "not a run").expect("written");
    let bytes = std::fs::read(at.join("a.h5")).expect("readable");
    std::fs::write(at.join("f.h5"), &bytes[..bytes.len() / 2]).expect("written");
    let (code, out, err) = fbimpact(at, &["collect", ".", "missing.h5", "-o", "table.csv"]);
    assert_eq!((code, out.as_str()), (0, ""), "{err}");
    assert!(err.contains("7 runs, 2 complete"), "{err}");
    let csv = Csv::read(&at.join("table.csv"));
    let expected = ["complete", "complete", "unreadable", "failed", "missing", "unreadable", "missing"];
    assert_eq!(csv.column("status"), expected);
    let velocities = csv.column("set.bodies.ball.velocity");
    assert_eq!(velocities, ["[0, 0, -0.05]", "[0, 0, -0.1]", "", "", "[0, 0, -1]", "", ""]);
    let set: Vec<_> = csv.names.iter().filter(|n| n.starts_with("set.")).collect();
    assert_eq!(set, ["set.bodies.ball.velocity", "set.bodies.ball.velocity[2]"]);
    let peak: f64 = csv.column("impact[1].peak_force")[1].parse().expect("a number");
    // docs/verification.md: 52.08 N.
    assert!((peak - 52.08).abs() < 0.02);

    // The long form, and a table among the runs that is no run.
    assert_eq!(fbimpact(at, &["collect", ".", "-o", "long.h5", "--long"]).0, 0);
    assert_eq!(fbimpact(at, &["collect", ".", "-o", "long.csv", "--long"]).0, 0);
    let csv = Csv::read(&at.join("long.csv"));
    assert_eq!(csv.rows.len(), 6);
    assert_eq!(csv.column("contact")[..3], ["impact", "impact", ""]);

    for (arguments, expected) in [
        (&["collect", ".", "-o", "table.txt"][..], 2),
        (&["collect", ".", "-o", "no/such/table.csv"], 6),
        (&["collect", "nodir", "-o", "table.csv"], 6),
        (&["collect", "-o", "table.csv"], 2),
    ] {
        let (code, _, err) = fbimpact(at, arguments);
        assert_eq!(code, expected, "{arguments:?}: {err}");
    }
    std::fs::create_dir(at.join("empty")).expect("made");
    let (code, _, err) = fbimpact(at, &["collect", "empty", "-o", "table.csv"]);
    assert!(code == 6 && err.contains("holds no results"), "{err}");
}

/// Rows in the order of the values, vectors from ranges, their components as numbers; a failed run knows its own.
#[test]
fn rows_of_a_sweep_are_in_the_order_given_and_vectors_come_back_as_numbers() {
    let directory = scratch();
    let at = directory.path();
    let script = format!("{ROOT}/scripts/sweep.sh");
    let vectors = "bodies.ball.velocity=[0,0,-0.2]..[0,0,-0.1]/3 [0,1,-0.1]";
    let (code, _, err) = output(&script, at, &[&scenario(), "out", vectors]);
    assert_eq!(code, 1, "a ball that moves on its axis has no velocity across it: {err}");
    let csv = Csv::read(&at.join("out/table.csv"));
    assert_eq!(csv.column("set.bodies.ball.velocity[2]"), ["-0.2", "-0.15", "-0.1", "-0.1"]);
    assert_eq!(csv.column("set.bodies.ball.velocity[1]"), ["0", "0", "0", "1"]);
    assert!(!csv.names.contains(&"set.bodies.ball.velocity[0]".to_owned()), "{:?}", csv.names);
    assert_eq!(csv.column("set.bodies.ball.velocity")[1], "[0, 0, -0.15]");
    let table = result_files::file::hdf5_integrity::open(&at.join("out/table.h5")).expect("a table");
    let column = table.dataset("runs/set.bodies.ball.velocity[2]").expect("a column");
    assert_eq!(column.read_raw::<f64>().expect("numbers"), [-0.2, -0.15, -0.1, -0.1]);
    let (code, _, err) = output(&script, at, &[&scenario(), "out", "bodies.ball.velocity=[0,0]..[1,1,1]/2"]);
    assert!(code == 2 && err.contains("as many numbers"), "{err}");
}

#[test]
fn new_scenario_runs_and_is_never_overwritten() {
    let directory = scratch();
    let at = directory.path();
    let (code, out, err) = fbimpact(at, &["new", "mine"]);
    assert_eq!((code, out.as_str()), (0, ""), "{err}");
    let text = std::fs::read_to_string(at.join("mine.toml")).expect("there");
    assert!(text.starts_with("#:schema ./fbimpact.schema.json\n") && text.contains("fbimpact run mine.toml"));
    assert!(at.join("fbimpact.schema.json").is_file());
    let (code, _, err) = fbimpact(at, &["run", "mine.toml", "-o", "mine.h5"]);
    assert_eq!(code, 0, "{err}");
    let impacts = result_files::stored::summary::read(&at.join("mine.h5")).expect("a result").impacts;
    assert_eq!(impacts.len(), 1);
    // Hertz for a steel ball of 10 mm at 0.2 m/s on a rigid plane: 5/4 m v^2 / depth = 335 N; the ball is a little softer or stiffer.
    assert!((impacts[0].peak_force / hertz() - 1.0).abs() < 0.02, "{} N", impacts[0].peak_force);
    assert!(impacts[0].restitution > 0.99);

    std::fs::write(at.join("mine.toml"), "changed").expect("written");
    let (code, _, err) = fbimpact(at, &["new", "mine"]);
    assert!(code == 6 && err.contains("exists"), "{err}");
    assert_eq!(std::fs::read_to_string(at.join("mine.toml")).expect("there"), "changed");
    assert_eq!(fbimpact(at, &["new", "mine.toml", "--force"]).0, 0);
    assert_eq!(std::fs::read_to_string(at.join("mine.toml")).expect("there"), text);
    assert_eq!(fbimpact(at, &["new", "no/such/place"]).0, 6);
}

/// Templates set nothing that the program chooses, are valid and small ones run, without a warning.
#[test]
fn every_template_leaves_to_the_program_what_it_chooses_and_runs_without_a_warning() {
    // What `docs/modelling.md` advises to leave out.
    let chosen = ["discretisation", "reduction", "interval", "penalty", "\"quasistatic\"", "zone"];
    let directory = scratch();
    let at = directory.path();
    // Impacts of the runs that take a few seconds of a debug-free build; None: `check` has to do.
    for (name, impacts) in
        [("drop", Some(1)), ("hammer", None), ("pendulum", Some(1)), ("mesh", None), ("chain", Some(3))]
    {
        let file = format!("{name}.toml");
        let (code, _, err) = fbimpact(at, &["new", name, "--template", name]);
        assert_eq!(code, 0, "{name}: {err}");
        let text = std::fs::read_to_string(at.join(&file)).expect("there");
        let keys = text.lines().filter(|l| !l.trim_start().starts_with('#'));
        let set: Vec<&str> = keys.filter(|line| chosen.iter().any(|key| line.contains(key))).collect();
        assert!(set.is_empty(), "{name} sets {set:?}");
        assert!(text.contains(&format!("fbimpact run {file}")) && !text.contains("NAME"), "{name}");
        let (code, _, err) = fbimpact(at, &["check", &file]);
        assert!(code == 0 && err.contains("valid") && !err.contains("WARN"), "{name}: {err}");
        if let Some(impacts) = impacts {
            let (code, _, err) = fbimpact(at, &["run", &file]);
            assert!(code == 0 && !err.contains("WARN"), "{name}: {err}");
            assert_eq!(err.matches("INFO impact at").count(), impacts, "{name}: {err}");
        }
    }
    // The mesh beside its scenario is never overwritten either, and nothing is written then.
    std::fs::remove_file(at.join("mesh.toml")).expect("removed");
    std::fs::write(at.join("mesh.msh"), "mine").expect("written");
    let (code, _, err) = fbimpact(at, &["new", "mesh", "--template", "mesh"]);
    assert!(code == 6 && err.contains("mesh.msh") && err.contains("exists"), "{err}");
    assert_eq!(std::fs::read_to_string(at.join("mesh.msh")).expect("there"), "mine");
    assert!(!at.join("mesh.toml").exists());
}

/// Peak force of an elastic sphere on a rigid plane (Hertz, docs/theory.md).
fn hertz() -> f64 {
    let (radius, modulus, speed): (f64, f64, f64) = (10e-3, 210e9 / (1.0 - 0.3 * 0.3), 0.2);
    let mass = 7850.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let stiffness = 4.0 / 3.0 * modulus * radius.sqrt();
    stiffness * (1.25 * mass * speed * speed / stiffness).powf(0.6)
}

#[test]
fn every_scenario_names_its_schema() {
    let files = std::fs::read_dir(Path::new(ROOT).join("scenarios")).expect("readable");
    let paths: Vec<PathBuf> = files.map(|e| e.expect("readable").path()).collect();
    for path in paths.iter().filter(|p| p.extension().is_some_and(|e| e == "toml")) {
        let text = std::fs::read_to_string(path).expect("readable");
        assert!(text.starts_with("#:schema ../docs/scenario.schema.json\n"), "{}", path.display());
    }
}

#[test]
fn manual_pages_name_program_and_command() {
    let directory = scratch();
    let (code, out, _) = fbimpact(directory.path(), &["man", "compare"]);
    assert!(code == 0 && out.contains("fbimpact\\-compare") && out.contains("tolerances"), "{out}");
    assert_eq!(fbimpact(directory.path(), &["man", "fly"]).0, 2);
    let (_, out, _) = fbimpact(directory.path(), &["man"]);
    assert!(out.contains("fbimpact\\-compare(1)") && out.contains("fbimpact\\-reference(1)"), "{out}");
}
