//! `fbimpact converge`, run as a user would: what it varies, what it names, how it ends, what it does not run again.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

use serde_json::Value;
use tempfile::TempDir;

const ROOT: &str = env!("CARGO_MANIFEST_DIR");
const PROGRAM: &str = env!("CARGO_BIN_EXE_fbimpact");

/// A rigid ball with Hertz' law on a rigid plane: nothing but the integration can be varied.
const HERTZ: &str = r#"
[simulation]
end_time = 2e-4
[materials.steel]
youngs_modulus = 210e9
poissons_ratio = 0.3
density = 7850.0
[bodies.ball]
model = "rigid"
material = "steel"
geometry = { shape = "sphere", radius = 0.01 }
position = [0.0, 0.0, 0.010001]
velocity = [0.0, 0.0, -0.1]
[bodies.floor]
model = "rigid"
geometry = { shape = "plane" }
normal = [0.0, 0.0, 1.0]
[contacts.tip]
model = "hertz"
contact_body = "ball"
target_body = "floor"
"#;

/// A flexible rod on a rigid plane.
const ROD: &str = r#"
[simulation]
end_time = 4e-4
[materials.aluminium]
youngs_modulus = 72.8e9
poissons_ratio = 0.33
density = 2789.0
[bodies.rod]
model = "axisymmetric"
material = "aluminium"
geometry = { shape = "rod-spherical-end", radius = 0.01, length = 0.5 }
reduction = { modes = 20 }
velocity = [0.0, 0.0, -0.3]
[bodies.rod.discretisation]
degree = 2
elements = [2, 20]
refine = [{ marker = "start", width = 0.72e-3, elements = 16 }]
[bodies.floor]
model = "rigid"
geometry = { shape = "plane" }
normal = [0.0, 0.0, 1.0]
[contacts.tip]
model = "quasistatic"
contact_body = "rod"
target_body = "floor"
"#;

struct Folder(TempDir);

impl Folder {
    /// A folder with the scenario `text` in `case.toml`.
    fn with(text: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("case.toml"), text).expect("written");
        Self(folder)
    }

    fn at(&self) -> &Path {
        self.0.path()
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(PROGRAM);
        command.args(arguments).current_dir(self.at()).env("FBIMPACT_CACHE", self.at().join("models"));
        command
    }

    /// Exit code, standard output and standard error.
    fn fbimpact(&self, arguments: &[&str]) -> (i32, String, String) {
        let output = self.command(arguments).output().expect("the program starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
        (output.status.code().expect("no signal"), text(output.stdout), text(output.stderr))
    }

    /// Exit code and report of a study.
    fn study(&self, arguments: &[&str]) -> (i32, Value) {
        let all = [&["converge", "case.toml", "--json", "--threads", "2"], arguments].concat();
        let (code, out, err) = self.fbimpact(&all);
        let report = serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {out}{err}"));
        (code, report)
    }

    /// Results of the study with the times at which they were written.
    fn results(&self) -> Vec<(PathBuf, SystemTime)> {
        let files = std::fs::read_dir(self.at().join("case.converge")).expect("readable");
        let paths = files.map(|e| e.expect("readable").path());
        let results = paths.filter(|p| p.extension().is_some_and(|e| e == "h5"));
        let mut all: Vec<_> =
            results.map(|p| (p.clone(), p.metadata().and_then(|m| m.modified()).expect("a time"))).collect();
        all.sort();
        all
    }
}

fn variant<'a>(report: &'a Value, name: &str) -> &'a Value {
    let all = report["variants"].as_array().expect("a list");
    all.iter().find(|v| v["name"] == name).unwrap_or_else(|| panic!("{name} in {report:#}"))
}

fn sentence(report: &Value) -> &str {
    report["verdict"].as_str().expect("a sentence")
}

#[test]
fn converged_study_ends_with_0_and_runs_nothing_the_second_time() {
    let folder = Folder::with(HERTZ);
    let (code, report) = folder.study(&[]);
    assert_eq!((code, &report["converged"]), (0, &Value::Bool(true)), "{report:#}");
    assert!(sentence(&report).starts_with("converged within 1.0 %: the largest change is"), "{report:#}");
    let names: Vec<&str> =
        report["not_varied"].as_array().expect("a list").iter().filter_map(|p| p["name"].as_str()).collect();
    assert_eq!(names, ["modes", "mesh", "zone", "penalty"]);
    let change = &variant(&report, "tolerance")["impacts"][0];
    assert_eq!((&change["impact"], &change["contact"]), (&Value::from(1), &Value::from("tip")));
    let base = &report["base"]["impacts"][0];
    let moved = change["peak_force"]["value"].as_f64().zip(base["peak_force"].as_f64());
    let (new, old) = moved.expect("numbers");
    let relative = change["peak_force"]["change"].as_f64().expect("a number");
    assert!((relative - (new - old) / old).abs() < 1e-15, "{relative}");
    assert_eq!(variant(&report, "tolerance")["run"]["reused"], Value::Bool(false));

    let before = folder.results();
    assert_eq!(before.len(), 2, "{before:?}");
    let (code, again) = folder.study(&[]);
    assert_eq!((code, folder.results()), (0, before), "finished runs are not made again");
    assert_eq!(variant(&again, "tolerance")["run"]["reused"], Value::Bool(true));
    assert_eq!(again["verdict"], report["verdict"]);
    let stored = std::fs::read_to_string(folder.at().join("case.converge/converge.json")).expect("there");
    assert_eq!(serde_json::from_str::<Value>(&stored).expect("JSON"), again);

    // Another scenario is another study, in the same folder too.
    let (_, other) = folder.study(&["--set", "bodies.ball.velocity=[0,0,-0.2]"]);
    assert_eq!(other["base"]["run"]["reused"], Value::Bool(false));
    let (_, other) = folder.study(&["--set", "bodies.ball.velocity=[0,0,-0.2]", "--tolerance", "1e-14"]);
    assert_eq!(other["base"]["run"]["reused"], Value::Bool(true));
    assert!(sentence(&other).starts_with("the time integration limits"), "{}", sentence(&other));

    // The folder is one of runs as those of a sweep.
    let (code, _, err) = folder.fbimpact(&["collect", "case.converge", "-o", "table.csv"]);
    assert!(code == 0 && err.contains("2 runs, 2 complete"), "{err}");
    let table = std::fs::read_to_string(folder.at().join("table.csv")).expect("readable");
    assert!(table.contains("resolution.tolerance"), "{table}");
}

#[test]
fn changes_beyond_the_tolerance_end_with_1_and_a_table() {
    let folder = Folder::with(HERTZ);
    let (code, out, err) = folder.fbimpact(&["converge", "case.toml", "-q", "--tolerance", "1e-14"]);
    assert_eq!((code, err.as_str()), (1, "not converged within 1e-12 %\n"), "{out}");
    for words in [
        "impact 1, contact tip: at",
        "tolerance",
        "body ball: final velocity",
        "mesh: not varied, no body has a mesh",
    ] {
        assert!(out.contains(words), "{words} is in {out}");
    }
    assert!(out.lines().last().is_some_and(|l| l.starts_with("the time integration limits")), "{out}");
}

#[test]
fn a_flight_without_impact_is_judged_by_its_end() {
    let folder = Folder::with(&HERTZ.replace("velocity = [0.0, 0.0, -0.1]", "velocity = [0.0, 0.0, 0.1]"));
    let (code, report) = folder.study(&[]);
    assert_eq!(code, 0, "{report:#}");
    assert!(sentence(&report).contains("final velocity of body \"ball\""), "{}", sentence(&report));
    let (_, out, _) = folder.fbimpact(&["converge", "case.toml", "-q"]);
    assert!(out.contains("no impact, final motions and what is asked for are compared"), "{out}");
}

#[test]
fn a_coarse_mesh_is_named() {
    let folder = Folder::with(ROD);
    // Three elements along the rod, but for small ones at its end that grow as fast as they may.
    let coarse =
        ["bodies.rod.discretisation.elements=[1,3]", "bodies.rod.discretisation.refine[0].ratio=10.0"];
    let (code, report) = folder.study(&["--set", coarse[0], "--set", coarse[1], "--tolerance", "1e-3"]);
    assert_eq!(code, 1, "{report:#}");
    assert_eq!(report["limit"]["variant"], "mesh", "{report:#}");
    assert!(sentence(&report).starts_with("the mesh of body \"rod\" limits the "), "{}", sentence(&report));
    assert_eq!(variant(&report, "zone")["subjects"][0], "tip", "the refinement at the contact is its zone");
}

#[test]
fn too_few_modes_are_named_and_what_mattered_is_run_together() {
    let folder = Folder::with(ROD);
    let (code, report) = folder.study(&["--set", "bodies.rod.reduction.modes=1", "--tolerance", "1e-3"]);
    assert_eq!(code, 1, "{report:#}");
    let words = "the number of modes of body \"rod\" limits the ";
    assert!(sentence(&report).starts_with(words), "{}", sentence(&report));
    let together = variant(&report, "together");
    let parameters = together["parameters"].as_array().expect("a list");
    assert!(parameters.len() > 1 && parameters[0] == "modes", "{together:#}");
    // A variant is a scenario that can be run by itself.
    let set = variant(&report, "modes")["set"][0].as_str().expect("a change");
    let few = "bodies.rod.reduction.modes=1";
    let run = ["run", "case.toml", "-q", "-o", "alone.h5", "--set", few, "--set", set];
    assert_eq!(folder.fbimpact(&run).0, 0);
    let info = result_files::stored::summary::read(&folder.at().join("alone.h5")).expect("a result");
    assert_eq!(info.bodies, [("rod".to_owned(), 2)]);
    let peak = variant(&report, "modes")["impacts"][0]["peak_force"]["value"].as_f64().expect("a number");
    assert_eq!(info.impacts[0].peak_force.to_bits(), peak.to_bits(), "the same run");
}

#[test]
fn a_variant_that_fails_is_a_row_with_its_reason() {
    let folder = Folder::with(ROD);
    // Twice sixty is more than a factor may be.
    let sets = ["bodies.rod.reduction.modes=1", "resolution.modes=60", "simulation.end_time=2e-5"];
    let sets: Vec<&str> = sets.iter().flat_map(|s| ["--set", s]).collect();
    let (code, report) = folder.study(&sets);
    assert_eq!(code, 1, "{report:#}");
    let failed = variant(&report, "modes");
    assert_eq!(
        (&failed["run"]["exit_code"], &failed["run"]["status"]),
        (&3.into(), &"failed".into()),
        "{failed:#}"
    );
    let message = failed["run"]["message"].as_str().expect("a reason");
    assert!(message.contains(".modes = 120: must be an integer"), "{message}");
    assert!(sentence(&report).contains("modes could not be judged: "), "{}", sentence(&report));
    assert_eq!(variant(&report, "mesh")["run"]["status"], "complete");
}

#[test]
fn factors_act_on_what_is_in_force_and_mean_what_the_keys_mean() {
    let folder = Folder::with(ROD);
    let sizes = |sets: &[&str]| {
        let sets: Vec<&str> = sets.iter().flat_map(|s| ["--set", s]).collect();
        let (code, out, err) = folder.fbimpact(&[&["modes", "case.toml", "--json"], &sets[..]].concat());
        assert_eq!(code, 0, "{err}");
        let report: Value = serde_json::from_str(&out).expect("JSON");
        let rod = &report["bodies"][0];
        (rod["elements"].as_u64().expect("a number"), rod["frequencies"].as_array().expect("a list").clone())
    };
    let same = |factor: &str, keys: &[&str]| {
        let (a, b) = (sizes(&[factor]), sizes(keys));
        assert_eq!(a, b, "{factor} is as good as {keys:?}");
        assert_ne!(a, sizes(&[]), "{factor} changes something");
    };
    same("resolution.modes=2", &["bodies.rod.reduction.modes=40"]);
    same("resolution.bodies.rod.modes=2", &["bodies.rod.reduction.modes=40"]);
    // Elements twice as small next to each other differ by the root of the ratio.
    let (elements, ratio) = ("bodies.rod.discretisation.elements=[4,40]", 1.5_f64.powf(0.5));
    same("resolution.mesh=2", &[elements, &format!("bodies.rod.discretisation.refine[0].ratio={ratio:?}")]);
    same("resolution.zone=2", &["bodies.rod.discretisation.refine[0].elements=32"]);
    same("resolution.contacts.tip.zone=2", &["bodies.rod.discretisation.refine[0].elements=32"]);
    // An interval of the contact's own: then the refinement of the body is a part of its mesh.
    let own = "contacts.tip.interval={width=0.3e-3,elements=8}";
    let finer = "contacts.tip.interval={width=0.3e-3,elements=16}";
    assert_eq!(sizes(&[own, "resolution.zone=2"]), sizes(&[finer]));
    // Elements that the program chooses are doubled as well, in both directions.
    std::fs::write(folder.at().join("case.toml"), ROD.replace("elements = [2, 20]\n", "")).expect("written");
    let (chosen, doubled) = (sizes(&[]).0, sizes(&["resolution.mesh=2"]).0);
    assert!(doubled > 2 * chosen, "{chosen} {doubled}");
}

#[test]
fn what_cannot_be_studied_ends_as_documented() {
    let folder = Folder::with(ROD);
    let case = |arguments: &[&str]| folder.fbimpact(&[&["converge", "-q"], arguments].concat());
    let (code, _, err) = case(&["nothing.toml"]);
    assert!(code == 6 && err.contains("nothing.toml"), "{err}");
    let (code, _, err) = case(&["case.toml", "--set", "simulation.end_time=-1"]);
    assert!(code == 3 && err.contains("end_time"), "{err}");
    assert_eq!(case(&["case.toml", "--tolerance", "-1"]).0, 2);
    assert_eq!(case(&["case.toml", "--jobs", "0"]).0, 2);
    let (code, _, err) = case(&["case.toml", "--set", "resolution.bodies.rood.mesh=2"]);
    assert!(code == 3 && err.contains("nown are \"rod\" or \"floor\""), "{err}");
    // The scenario as it is has more modes than its mesh.
    let (code, _, err) = case(&["case.toml", "--set", "bodies.rod.reduction.modes=100000"]);
    assert!(code == 4 && err.contains("the scenario as it is: ") && err.contains("modes"), "{code} {err}");
    std::fs::create_dir(folder.at().join("mine")).expect("made");
    std::fs::write(folder.at().join("mine/notes.txt"), "kept").expect("written");
    let (code, _, err) = case(&["case.toml", "-o", "mine"]);
    assert!(
        code == 6 && err.contains("holds files and no converge.json, name a new folder with -o"),
        "{err}"
    );
}

#[test]
fn interrupted_study_keeps_its_runs_and_goes_on_with_them() {
    let folder = Folder::with(HERTZ);
    let scenario = format!("{ROOT}/scenarios/rigid_double_pendulums.toml");
    let arguments = |end: &'static str| {
        let set = ["--set", end, "--set", "output.free_interval=1e-4"];
        [&["converge", &scenario, "-o", "study", "--threads", "2"], &set[..]].concat()
    };
    let endless = arguments("simulation.end_time=1000.0");
    let mut child =
        folder.command(&endless).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("it starts");
    let restart = folder.at().join("study/tolerance.h5.restart");
    let begin = Instant::now();
    while restart.metadata().map_or(0, |m| m.len()) < 100_000 {
        assert!(begin.elapsed() < Duration::from_secs(120), "the runs store states");
        std::thread::sleep(Duration::from_millis(20));
    }
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-TERM", &id]).status().expect("kill").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    for name in ["base", "tolerance"] {
        let result = folder.at().join(format!("study/{name}.h5"));
        let summary = result_files::stored::summary::read(&result).expect("a result");
        assert_eq!(
            summary.attribute("status"),
            "interrupted",
            "{name}: the run was told and stored its state"
        );
    }
    // The same study goes on where its runs were.
    let mut again =
        folder.command(&endless).stderr(Stdio::piped()).stdout(Stdio::null()).spawn().expect("it starts");
    let log = folder.at().join("study/base.log");
    while folder.at().join("study/base.exit").exists() || !log.exists() {
        assert!(begin.elapsed() < Duration::from_secs(240), "the runs go on");
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_millis(300));
    // Runs whose parent dies stop as well.
    again.kill().expect("it can be killed");
    let said = again.wait_with_output().expect("it ends").stderr;
    let said = String::from_utf8_lossy(&said);
    assert!(said.contains("base goes on") && said.contains("tolerance goes on"), "{said}");
    let is_held = |name: &str| {
        let part = folder.at().join(format!("study/{name}.h5.part"));
        std::fs::File::open(part).is_ok_and(|f| f.try_lock().is_err())
    };
    while is_held("base") || is_held("tolerance") {
        assert!(begin.elapsed() < Duration::from_secs(360), "no run is left behind");
        std::thread::sleep(Duration::from_millis(20));
    }
}

#[test]
fn stress_that_is_asked_for_is_judged() {
    // The centrifugal force of a disc, of which free modes alone have too little at its centre.
    let disc = "[simulation]\nend_time = 2e-3\n[bodies.disc]\nmodel = \"plane-stress\"\nmaterial = \"steel\"\n\
        geometry = { shape = \"disc\", radius = 0.1 }\nangular_velocity = [0.0, 0.0, \"3000 rpm\"]\n\
        damping = { modal = 0.7 }\ndiscretisation = { degree = 3, elements = [4, 4] }\n\
        reduction = { modes = 20, static_answers = false }\n\
        [output.points.middle]\nbody = \"disc\"\npoint = [0.0, 0.0]\nstress = true\n";
    let folder = Folder::with(disc);
    let (code, report) = folder.study(&[]);
    assert_eq!(code, 1, "{report:#}");
    assert_eq!(report["limit"]["quantity"], "peak_von_mises", "{report:#}");
    assert_eq!(report["limit"]["where"], "at point \"middle\"");
    assert!(
        sentence(&report).contains("limits the largest stress at point \"middle\""),
        "{}",
        sentence(&report)
    );
    let peaks = report["base"]["peaks"].as_array().map_or(0, Vec::len);
    assert_eq!(peaks, 2, "displacement and stress: {report:#}");
    // With its static answer twice the modes change nothing that is asked for.
    let answered = Folder::with(&disc.replace(", static_answers = false", ""));
    let (_, report) = answered.study(&[]);
    let change = variant(&report, "modes")["largest_change"].as_f64().unwrap_or(1.0);
    assert!(change < 0.01, "{report:#}");
}
