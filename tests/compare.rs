//! `fbimpact compare` and `thin`, run as programs on results of real runs.

use std::path::{Path, PathBuf};

use result_files::tables::ImpactRow;

use crate::support::fbimpact as output;
use tempfile::TempDir;

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn scratch() -> TempDir {
    tempfile::tempdir().expect("a temporary directory")
}

/// Runs a scenario to `<directory>/<name>.h5`.
fn run(directory: &TempDir, name: &str, scenario: &str, more: &[&str]) -> PathBuf {
    let path = directory.path().join(format!("{name}.h5"));
    let scenario = format!("{}/scenarios/{scenario}.toml", env!("CARGO_MANIFEST_DIR"));
    let (code, _, err) = output(&[&["run", &scenario, "-q", "-o", text(&path)], more].concat());
    assert_eq!(code, 0, "{err}");
    path
}

fn sphere(directory: &TempDir, name: &str) -> PathBuf {
    run(directory, name, "sphere_on_plane", &[])
}

fn compare(new: &Path, reference: &Path, more: &[&str]) -> (i32, String, String) {
    output(&[&["compare", text(new), text(reference)], more].concat())
}

/// A copy of `from` changed by `edit`.
fn edited(from: &Path, name: &str, edit: impl Fn(&hdf5::File)) -> PathBuf {
    let path = from.with_file_name(format!("{name}.h5"));
    std::fs::copy(from, &path).expect("copied");
    // Without a lock, which programs started by other tests meanwhile would inherit and keep.
    let unlocked = hdf5::File::with_options().with_fapl(|p| p.file_locking(false)).open_rw(&path);
    let file = unlocked.expect("opens");
    edit(&file);
    file.close().expect("closed");
    path
}

fn scaled(file: &hdf5::File, name: &str, factor: f64) {
    let dataset = file.dataset(name).expect("there");
    let values: Vec<f64> = dataset.read_raw::<f64>().expect("numbers").iter().map(|x| factor * x).collect();
    dataset.write_raw(&values).expect("written");
}

#[test]
fn rerun_with_other_thread_count_agrees() {
    let directory = scratch();
    for scenario in ["sphere_on_plane", "rotating_disc"] {
        let a = run(&directory, "one", scenario, &["--threads", "1"]);
        let b = run(&directory, "two", scenario, &["--threads", "2"]);
        let (code, out, err) = compare(&b, &a, &[]);
        assert_eq!((code, err.as_str()), (0, ""), "{out}");
        assert!(out.contains("agrees: ") && !out.contains("differs"), "{out}");
    }
}

#[test]
fn other_steps_are_no_difference() {
    let directory = scratch();
    let a = sphere(&directory, "a");
    // A third of the steps.
    let b = run(&directory, "b", "sphere_on_plane", &["--set", "simulation.impact.rtol=1e-6"]);
    let (code, out, _) = compare(&b, &a, &[]);
    assert_eq!(code, 0, "{out}");
    assert!(out.starts_with("scenario: simulation.impact.rtol is 0.000001"), "{out}");
    assert_eq!(compare(&b, &a, &["--rtol", "1e-9"]).0, 1);
}

#[test]
fn half_a_per_cent_of_peak_force_is_found() {
    let directory = scratch();
    let a = sphere(&directory, "a");
    let series = edited(&a, "series", |file| scaled(file, "contacts/impact/normal_force", 1.005));
    let table = edited(&a, "table", |file| {
        let dataset = file.dataset("impacts").expect("there");
        let mut rows: Vec<ImpactRow> = dataset.read_raw().expect("rows");
        rows[0].peak_force *= 0.995;
        dataset.write_raw(&rows).expect("written");
    });
    // F ~ v^1.2 (Hertz).
    let speed = 0.1 * 1.005_f64.powf(1.0 / 1.2);
    let rerun = run(
        &directory,
        "rerun",
        "sphere_on_plane",
        &["--set", &format!("bodies.ball.velocity=[0,0,-{speed}]")],
    );
    for (file, name) in [
        (&series, "contacts/impact/normal_force "),
        (&table, "impacts/impact/1/peak_force "),
        (&rerun, "impacts/impact/1/peak_force "),
    ] {
        let (code, out, err) = compare(file, &a, &[]);
        assert_eq!(code, 1, "{out}");
        let row = out.lines().find(|l| l.starts_with(name)).unwrap_or_else(|| panic!("{name} in {out}"));
        assert!(row.contains("differs"), "{row}");
        assert!(err.starts_with("differs from the reference in "), "{err}");
    }
}

#[test]
fn shift_of_an_impact_by_a_microsecond_is_found() {
    let directory = scratch();
    // 0.1 m/s: 0.1 um more to fall take 1 us longer.
    let at = |z: f64| format!("bodies.ball.position=[0,0,{z}]");
    let a = run(&directory, "a", "sphere_on_plane", &["--set", &at(10.0005e-3)]);
    let b = run(&directory, "b", "sphere_on_plane", &["--set", &at(10.0006e-3)]);
    let (code, out, _) = compare(&b, &a, &["--json"]);
    assert_eq!(code, 1, "{out}");
    let json: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(json["agrees"], false);
    assert_eq!(json["scenario_changes"].as_array().expect("a list").len(), 1);
    let quantities = json["quantities"].as_array().expect("a list");
    let find = |name: &str| quantities.iter().find(|q| q["name"] == name).expect("compared");
    for name in ["impacts/impact/1/start", "impacts/impact/1/end", "impacts/impact/1/peak_time"] {
        let q = find(name);
        assert_eq!(q["differs"], true, "{q}");
        // The end of the step in which contact is found lies within 1 ns of the touch.
        assert!((q["deviation"].as_f64().expect("a number") - 1e-6).abs() < 2e-8, "{q}");
    }
    assert_eq!(find("impacts/impact/1/duration")["differs"], false);
    assert_eq!(find("impacts/impact/1/peak_force")["differs"], false);
}

#[test]
fn missing_and_changed_datasets_are_differences_and_extra_ones_are_named() {
    let directory = scratch();
    let a = sphere(&directory, "a");
    let missing =
        edited(&a, "missing", |file| file.unlink("contacts/impact/normal_force").expect("unlinked"));
    let (code, out, _) = compare(&missing, &a, &[]);
    assert_eq!(code, 1);
    assert!(out.contains("contacts/impact/normal_force: missing in the new result"), "{out}");
    let (code, out, _) = compare(&a, &missing, &[]);
    assert_eq!(code, 0, "{out}");
    assert!(out.contains("only in the new result: contacts/impact/normal_force\n"), "{out}");

    let replaced = |name: &str, rows: usize, width: usize| {
        edited(&a, name, |file| {
            file.unlink("momentum/linear").expect("unlinked");
            let dataset =
                file.new_dataset::<f64>().shape((rows, width)).create("momentum/linear").expect("made");
            let unit: hdf5::types::VarLenUnicode = "kg m/s".parse().expect("text");
            let attribute = dataset.new_attr::<hdf5::types::VarLenUnicode>().create("unit").expect("made");
            attribute.write_scalar(&unit).expect("written");
        })
    };
    let n = result_files::stored::summary::read(&a).expect("a result").n_samples;
    for (file, what) in [
        (replaced("narrow", n, 2), "linear: shape is "),
        (replaced("short", n - 1, 3), "linear: "),
        (replaced("zero", n, 3), "linear[2] "),
        (
            edited(&a, "unit", |f| unit(f, "energies/total", "mJ")),
            "total: unit is \"mJ\", the reference's is \"J\"",
        ),
        (edited(&a, "nan", |f| scaled(f, "energies/total", f64::NAN)), "energies/total "),
        (
            edited(&a, "status", |f| root(f, "status", "failed")),
            "status: failed, the reference's is complete",
        ),
    ] {
        let (code, out, _) = compare(&file, &a, &[]);
        assert!(code == 1 && out.contains(what), "{what}: {out}");
    }
}

fn unit(file: &hdf5::File, name: &str, unit: &str) {
    let attribute = file.dataset(name).and_then(|d| d.attr("unit")).expect("there");
    let unit: hdf5::types::VarLenUnicode = unit.parse().expect("text");
    attribute.write_scalar(&unit).expect("written");
}

fn root(file: &hdf5::File, name: &str, value: &str) {
    let value: hdf5::types::VarLenUnicode = value.parse().expect("text");
    file.attr(name).expect("there").write_scalar(&value).expect("written");
}

#[test]
fn tolerance_file_decides_by_pattern_and_its_faults_have_lines() {
    let directory = scratch();
    let a = sphere(&directory, "a");
    let b = edited(&a, "b", |file| scaled(file, "energies/kinetic", 1.005));
    assert_eq!(compare(&b, &a, &[]).0, 1);
    let path = directory.path().join("tolerances.toml");
    let with = |content: &str| {
        std::fs::write(&path, content).expect("written");
        compare(&b, &a, &["--tolerances", text(&path)])
    };
    let (code, out, err) =
        with("[datasets]\n\"energies/kin*\" = { rtol = 0.01 }\n\"enrgies/*\" = { atol = 1 }\n");
    assert_eq!(code, 0, "{out}");
    assert!(err.contains("\"enrgies/*\"") && err.contains("matches nothing"), "{err}");
    assert_eq!(with("[datasets]\n\"energies/*\" = { compare = false }\n[features]\n\"final/**\" = { compare = false }\n").0, 0);
    assert_eq!(with("rtol = 0.006\n").0, 0);
    let (code, out, err) = with("rtol = 0.006\n[dataset]\n\"energies/*\" = { rtol = 1 }\n");
    assert_eq!((code, out.as_str()), (3, ""));
    assert!(
        err.contains("tolerances.toml:2:2: unknown key \"dataset\"") && err.contains("\"datasets\"?"),
        "{err}"
    );
    let (code, _, err) = compare(&b, &a, &["--tolerances", "no-such-file.toml"]);
    assert!(code == 6 && err.contains("no-such-file.toml"), "{err}");
    assert_eq!(compare(&b, &a, &["--rtol", "-1"]).0, 2);
}

#[test]
fn files_that_are_no_results_or_damaged_exit_with_6() {
    let directory = scratch();
    let a = sphere(&directory, "a");
    let bytes = std::fs::read(&a).expect("readable");
    let foreign = directory.path().join("foreign.h5");
    hdf5::File::create(&foreign).and_then(hdf5::File::close).expect("made");
    let scenario = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenarios/sphere_on_plane.toml");
    let mut bad = vec![foreign, scenario, directory.path().join("missing.h5"), directory.path().to_owned()];
    for (i, length) in [0, 1000, bytes.len() / 2, bytes.len() - 1].into_iter().enumerate() {
        let path = directory.path().join(format!("cut{i}.h5"));
        std::fs::write(&path, &bytes[..length]).expect("written");
        bad.push(path);
    }
    for path in &bad {
        for (new, reference) in [(path, &a), (&a, path)] {
            let (code, out, err) = compare(new, reference, &[]);
            assert_eq!((code, out.as_str()), (6, ""), "{err}");
            assert!(err.starts_with(&format!("error: {}: ", path.display())), "{err}");
        }
    }
}

#[test]
fn small_copy_agrees_with_its_source_and_finds_changes() {
    let directory = scratch();
    let a = sphere(&directory, "a");
    let small = directory.path().join("small.h5");
    let (code, _, err) = output(&["thin", text(&a), "-o", text(&small)]);
    assert_eq!(code, 0, "{err}");
    let size = std::fs::metadata(&small).expect("there").len();
    assert!(size < 40_000, "{size} bytes");
    // Single precision: 6e-8 of a value, and no value is larger than the peak.
    let (code, out, _) = compare(&a, &small, &["--rtol", "1e-6"]);
    assert_eq!(code, 0, "{out}");
    let changed = edited(&a, "b", |file| scaled(file, "contacts/impact/normal_force", 1.005));
    assert_eq!(compare(&changed, &small, &[]).0, 1);
    let (code, out, err) = output(&["info", text(&small)]);
    assert!(code == 0 && out.contains("impact           0.000000e0"), "{out}{err}");
    // The gate of outputs: an input is no output.
    assert_eq!(output(&["thin", text(&a), "-o", text(&a)]).0, 6);
    let other = directory.path().join("notes.txt");
    std::fs::write(&other, "mine").expect("written");
    assert_eq!(output(&["thin", text(&a), "-o", text(&other)]).0, 6);
    assert_eq!(std::fs::read_to_string(&other).expect("readable"), "mine");
}
