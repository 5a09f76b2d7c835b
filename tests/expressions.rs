//! `fbimpact metric` and `collect --column`: one grammar, values, faults, tables; ranges and pairs of `scripts/sweep.sh`.
#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use crate::support::{fbimpact, simulate};
use hdf5::File;
use serde_json::Value;
use tempfile::TempDir;

/// Results that all tests read.
struct Results {
    _folder: TempDir,
    ball: PathBuf,
    pair: PathBuf,
}

static RESULTS: LazyLock<Results> = LazyLock::new(|| {
    let folder = TempDir::new().unwrap();
    let ball = simulate(
        folder.path(),
        "sphere_on_plane.toml",
        "ball.h5",
        &["output.points.low={body=\"ball\",marker=\"bottom\",stress=true}"],
    );
    let pair = simulate(folder.path(), "sphere_rod_sphere.toml", "pair.h5", &[]);
    Results { _folder: folder, ball, pair }
});

fn metric(file: &Path, expressions: &[&str]) -> Value {
    let file = file.display().to_string();
    let (code, out, err) = fbimpact(&[&["metric", &file], expressions].concat());
    assert_eq!(code, 0, "{err}");
    serde_json::from_str(&out).unwrap()
}

fn number(file: &Path, expression: &str) -> f64 {
    metric(file, &[expression])[expression]["value"].as_f64().unwrap_or_else(|| panic!("{expression}"))
}

fn refused(file: &Path, expression: &str) -> String {
    let file = file.display().to_string();
    let (code, out, err) = fbimpact(&["metric", &file, expression]);
    assert!(code == 2 && out.is_empty(), "{expression}: {out}{err}");
    err
}

fn stored(file: &Path, path: &str) -> Vec<f64> {
    File::open(file).unwrap().dataset(path).unwrap().read_raw().unwrap()
}

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-14 * b.abs() // round-off, and a digit that a reader of JSON misses
}

#[test]
fn values_are_those_of_the_datasets() {
    let ball = &RESULTS.ball;
    let (time, velocity) = (stored(ball, "time"), stored(ball, "bodies/ball/velocity"));
    let force = stored(ball, "contacts/impact/normal_force");
    let n = time.len();
    for (expression, expected) in [
        ("time[-1]", time[n - 1]),
        ("impacts.duration[0] - (impacts[0].end - impacts[0].start)", 0.0),
        ("phases[-1].duration - phases[-1].end + phases[-1].start", 0.0),
        ("bodies.ball.velocity[-1].z", velocity[3 * n - 1]),
        ("bodies.ball.velocity.z[-1]", velocity[3 * n - 1]),
        ("bodies.ball.velocity[-1][2]", velocity[3 * n - 1]),
        ("bodies.ball.velocity[10][-1]", velocity[32]),
        ("max(contacts.impact.normal_force)", force.iter().fold(0.0, |m: f64, f| m.max(*f))),
        ("count(contacts.impact.normal_force[5:8])", 3.0),
        ("sum(contacts.impact.normal_force[5:8])", force[5] + force[6] + force[7]),
        ("-2 * scenario.bodies.ball.velocity.z ^ 2", -0.02),
        ("scenario.simulation.end_time", 1e-4),
        ("scenario.bodies.ball.discretisation.refine[0].elements", 32.0),
        ("abs(-3) + 2 * (4 - 1) / 6", 4.0),
        ("bodies.ball.eigenfrequencies[0]", stored(ball, "bodies/ball/eigenfrequencies")[0]),
        ("stress.axis.von_mises[-1]", *stored(ball, "stress/axis/von_mises").last().unwrap()),
        ("points.\"low\".stress[3].tt", stored(ball, "points/low/stress")[20]),
    ] {
        let found = number(ball, expression);
        assert!(is_near(found, expected), "{expression}: {found:e} {expected:e}");
    }
    // What the run tells of the impact follows from the series, too: the largest of the stored steps is below the peak between them.
    let peak = number(ball, "max(contacts.impact.normal_force) / impacts[0].peak_force");
    assert!(peak < 1.0 && peak > 0.9999, "{peak}");
    let when = number(ball, "time_of_max(contacts.impact.normal_force) - impacts.peak_time[0]");
    assert!(when.abs() < 3e-7, "{when:e}"); // a step
    // The trapezoidal rule over a hundred steps and more.
    let impulse = number(ball, "integral(contacts.impact.normal_force) / impacts[0].impulse");
    assert!((impulse - 1.0).abs() < 1e-4, "{impulse}");
    let restitution = number(ball, "-bodies.ball.velocity[-1].z / bodies.ball.velocity[0].z");
    assert!((restitution - 1.0).abs() < 1e-4, "{restitution}");
}

#[test]
fn metrics_have_units_and_components() {
    let found = metric(
        &RESULTS.ball,
        &[
            "v=bodies.ball.velocity[-1]",
            "r=bodies.ball.rotation[0]",
            "f=contacts.impact.normal_force[:2]",
            "tries.interval_widths[0]",
            "e=bodies.ball.velocity[-1].z/scenario.bodies.ball.velocity[2]",
            "q=time/time[-1]",
        ],
    );
    assert_eq!(
        (&found["v"]["unit"], &found["v"]["components"]),
        (&"m/s".into(), &serde_json::json!(["x", "y", "z"]))
    );
    assert_eq!(
        (&found["r"]["value"], &found["r"]["components"][0]),
        (&serde_json::json!([1.0, 0.0, 0.0, 0.0]), &"w".into())
    );
    assert_eq!((found["f"]["value"].as_array().unwrap().len(), &found["f"]["unit"]), (2, &"N".into()));
    assert_eq!(found["tries.interval_widths[0]"]["value"][0], 0.24e-3);
    // The unit of a value of the scenario is not known.
    assert!(found["e"]["unit"].is_null());
    assert_eq!(found["q"]["unit"], "–");
}

#[test]
fn impacts_are_taken_by_contact() {
    let pair = &RESULTS.pair;
    assert!(is_near(
        number(pair, "contacts.second.impacts[0].peak_force"),
        number(pair, "impacts.peak_force[1]")
    ));
    assert!(is_near(number(pair, "count(contacts.first.impacts.start)"), 1.0));
    let jump = number(pair, "max(abs(transfers.energy_after - transfers.energy_before)) / energies.total[0]");
    assert!(jump < 1e-6, "{jump:e}");
}

#[test]
fn faults_name_the_place_and_what_there_is() {
    for (expression, words) in [
        ("bodies.bal.velocity", &["column 8", "no \"bal\" in bodies", "there are ball"][..]),
        ("forces", &["column 1", "no \"forces\" in the result", "contacts"]),
        ("bodies", &["a group of ball"]),
        ("bodies.ball.velocity[999999]", &["column 21", "0 to", "-1 to"]),
        ("bodies.ball.velocity.w", &["no component \"w\"", "x, y, z"]),
        ("impacts", &["a table", "peak_force"]),
        (
            "impacts[0].force",
            &["no column \"force\"", "peak_force", "restitution, ", "uncertainty, duration"],
        ),
        ("tries.duration", &["no column \"duration\""]),
        ("impacts.contact", &["texts"]),
        ("time-1", &["column 1", "a minus sign has a space"]),
        ("time + stress.axis.von_mises", &["do not fit together"]),
        ("integral(stress.axis.von_mises)", &["every stored instant"]),
        ("scenario.bodies.ball.radius", &["no \"radius\" in the scenario", "geometry"]),
        ("scenario.title", &["string", "not a number"]),
        ("pressure.impact.pressure", &["there is no \"pressure\""]),
        ("max(time", &["column 9", "\")\""]),
        ("time time", &["column 6", "too much"]),
        ("scenario.bodies.ball.velocity[7]", &["[7]", "0 to 2"]),
    ] {
        let err = refused(&RESULTS.ball, expression);
        assert!(words.iter().all(|word| err.contains(word)), "{expression}: {err}");
    }
    let (code, _, err) = fbimpact(&["metric", "nowhere.h5", "time"]);
    assert!(code == 6 && err.contains("nowhere.h5"), "{err}");
}

/// Rows of a CSV table without line ends in its cells, the names of its columns first.
fn table_rows(path: &Path) -> Vec<Vec<String>> {
    let split = |line: &str| {
        let (mut cells, mut quoted) = (vec![String::new()], false);
        for c in line.chars() {
            match c {
                '"' => quoted = !quoted,
                ',' if !quoted => cells.push(String::new()),
                c => cells.last_mut().unwrap().push(c),
            }
        }
        cells
    };
    std::fs::read_to_string(path).unwrap().lines().map(split).collect()
}

/// Cells of a column, if there is one.
fn cells(path: &Path, column: &str) -> Option<Vec<String>> {
    let rows = table_rows(path);
    let at = rows[0].iter().position(|name| name == column)?;
    Some(rows[1..].iter().map(|row| row[at].clone()).collect())
}

#[test]
fn collected_columns_have_the_values_of_the_metrics() {
    let folder = TempDir::new().unwrap();
    let table = folder.path().join("table.csv");
    let (out, ball, pair) =
        (table.display().to_string(), RESULTS.ball.display().to_string(), RESULTS.pair.display().to_string());
    let (code, _, err) = fbimpact(&[
        "collect",
        &ball,
        &pair,
        "-o",
        &out,
        "--column",
        "v=bodies.ball.velocity[-1]",
        "--column",
        "peak = max(impacts.peak_force)",
    ]);
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("column v is empty in 1 of 2 results"), "{err}");
    let read = |name: &str| cells(&table, name).unwrap_or_else(|| panic!("{name}"));
    assert_eq!(read("v.z")[1], "");
    assert!(is_near(read("v.z")[0].parse().unwrap(), number(&RESULTS.ball, "bodies.ball.velocity[-1].z")));
    assert!(is_near(read("peak")[1].parse().unwrap(), number(&RESULTS.pair, "max(impacts.peak_force)")));
    // Points and energies without being asked for.
    let speed = number(&RESULTS.ball, "max(norm(points.low.velocity))");
    assert!(is_near(read("points.low.peak_speed")[0].parse().unwrap(), speed));
    let stress = number(&RESULTS.ball, "max(points.low.von_mises)");
    assert!(is_near(read("points.low.peak_von_mises")[0].parse().unwrap(), stress) && stress > 1e6);
    let far = number(&RESULTS.pair, "max(norm(points.right_end.position - points.right_end.position[0]))");
    assert!(is_near(read("points.right_end.peak_displacement")[1].parse().unwrap(), far));
    let kinetic = number(&RESULTS.ball, "energies.kinetic[-1]");
    assert!(is_near(read("energies.kinetic.final")[0].parse().unwrap(), kinetic));
    assert_eq!(cells(&table, "points.right_end.peak_von_mises"), None);
    // The same in HDF5, with units.
    let table = folder.path().join("table.h5");
    let (code, ..) = fbimpact(&[
        "collect",
        &ball,
        "-o",
        &table.display().to_string(),
        "--column",
        "v=bodies.ball.velocity[-1].z",
    ]);
    assert_eq!(code, 0);
    let column = File::open(&table).unwrap().dataset("runs/v").unwrap();
    let unit: hdf5::types::VarLenUnicode = column.attr("unit").unwrap().read_scalar().unwrap();
    assert_eq!(unit.as_str(), "m/s");
}

#[test]
fn columns_that_no_result_has_are_refused() {
    let folder = TempDir::new().unwrap();
    let table = folder.path().join("table.csv").display().to_string();
    let ball = RESULTS.ball.display().to_string();
    for (columns, words) in [
        (&["v=bodies.disc.velocity[-1]"][..], "no \"disc\" in bodies"),
        (&["v=time"], "take a row, such as [-1]"),
        (&["v=time[-1]", "v=time[0]"], "a column \"v\" already"),
        (&["run=time[-1]"], "a column \"run\" already"),
        (&["time[-1]"], "NAME=EXPRESSION"),
        (&["v=time["], "column 6"),
        (&["a b=time[0]"], "names have letters"),
    ] {
        let options: Vec<&str> = columns.iter().flat_map(|c| ["--column", c]).collect();
        let (code, _, err) = fbimpact(&[&["collect", &ball, "-o", &table][..], &options].concat());
        assert!(code == 2 && err.contains(words), "{columns:?}: {err}");
        assert!(!Path::new(&table).exists());
    }
}

fn sweep(folder: &Path, arguments: &[&str], collect: &str) -> (i32, String) {
    let root = env!("CARGO_MANIFEST_DIR");
    let mut command = Command::new(format!("{root}/scripts/sweep.sh"));
    command
        .current_dir(folder)
        .env("FBIMPACT", env!("CARGO_BIN_EXE_fbimpact"))
        .env("JOBS", "2")
        .env("RUNNER", "xargs");
    let scenario = format!("{root}/scenarios/sphere_on_plane.toml");
    let run = command.env("COLLECT", collect).arg(scenario).arg("out").args(arguments).output().unwrap();
    (run.status.code().unwrap(), String::from_utf8(run.stderr).unwrap())
}

#[test]
fn sweeps_take_ranges_pairs_and_columns() {
    let folder = TempDir::new().unwrap();
    let pairs = "bodies.ball.velocity&simulation.end_time=[0,0,-0.1]&2e-5 [0,0,-0.2]&1e-5";
    let (code, err) = sweep(
        folder.path(),
        &[pairs, "materials.aluminium.youngs_modulus=70e9..74e9/3"],
        "--column 'v=bodies.ball.velocity[-1].z'",
    );
    assert_eq!(code, 0, "{err}");
    assert!(
        err.contains("6 runs, 6 complete") && err.contains(": 6 of 6: ") && err.contains(" s left"),
        "{err}"
    );
    let table = folder.path().join("out/table.csv");
    let text = std::fs::read_to_string(&table).unwrap();
    assert_eq!(text.lines().count(), 7);
    let read = |name: &str| cells(&table, name).unwrap_or_else(|| panic!("{name}"));
    let ends = read("set.simulation.end_time");
    let mut speeds: Vec<(String, String)> = read("set.bodies.ball.velocity").into_iter().zip(ends).collect();
    speeds.sort();
    speeds.dedup();
    assert_eq!(
        speeds,
        [("[0, 0, -0.1]".to_owned(), "2e-5".to_owned()), ("[0, 0, -0.2]".into(), "1e-5".into())]
    );
    for modulus in ["70000000000", "72000000000", "74000000000"] {
        assert_eq!(text.matches(modulus).count(), 2, "{text}");
    }
    assert!(read("v").iter().all(|v| v.parse::<f64>().is_ok()));
    for (arguments, words) in [
        (&["a&b=1&2 3"][..], "'3' has 1 values, the keys a&b are 2"),
        (&["a=1", "a=2"], "'a' is given twice"),
        (&["a=1..2/0"], "has no values"),
        (&["a="], "is not KEY=VALUE"),
    ] {
        let (code, err) = sweep(folder.path(), arguments, "");
        assert!(code == 2 && err.contains(words), "{err}");
    }
}
