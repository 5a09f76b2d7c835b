//! `fbimpact probe` from the outside: the same histories as the run stored, modes, formats, what it refuses.

use std::path::{Path, PathBuf};

use crate::support::{fbimpact, simulate};
use hdf5::File;
use serde_json::Value;
use tempfile::TempDir;

fn simulated(folder: &TempDir, scenario: &str, set: &[&str]) -> PathBuf {
    simulate(folder.path(), scenario, "run.h5", set)
}

pub fn probed(file: &Path, options: &[&str]) -> (Value, String) {
    let file = file.display().to_string();
    let mut arguments = vec!["probe", &file, "--json"];
    arguments.extend(options);
    let (code, out, err) = fbimpact(&arguments);
    assert_eq!(code, 0, "{err}");
    (serde_json::from_str(&out).unwrap(), err)
}

fn refused(file: &Path, options: &[&str]) -> (i32, String) {
    let file = file.display().to_string();
    let mut arguments = vec!["probe", &file];
    arguments.extend(options);
    let (code, out, err) = fbimpact(&arguments);
    assert_eq!(out, "", "{err}");
    (code, err)
}

/// Numbers of a history, row by row.
fn numbers(history: &Value) -> Vec<f64> {
    let flat = |row: &Value| match row {
        Value::Array(list) => list.iter().map(|x| x.as_f64().unwrap()).collect(),
        one => vec![one.as_f64().unwrap()],
    };
    history.as_array().unwrap().iter().flat_map(flat).collect()
}

/// Equal but for the last digit, which the reader of JSON may miss.
fn assert_same(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let is_same = |(a, b): (&f64, &f64)| (a - b).abs() <= 4.0 * f64::EPSILON * b.abs();
    assert!(found.iter().zip(expected).all(is_same), "{what}");
}

pub fn stored(file: &Path, path: &str) -> Vec<f64> {
    File::open(file).unwrap().dataset(path).unwrap().read_raw().unwrap()
}

/// Largest deviation of the probed point `n` from what the run stored of `name`, over the largest value.
pub fn deviation(probe: &Value, n: usize, (file, name): (&Path, &str), quantity: &str) -> f64 {
    let (found, expected) =
        (numbers(&probe["points"][n][quantity]), stored(file, &format!("points/{name}/{quantity}")));
    assert_eq!(found.len(), expected.len(), "{name} {quantity}");
    let largest = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    assert!(largest > 0.0, "{name} {quantity} is all zero");
    let worst = found.iter().zip(&expected).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs())) / largest;
    println!("{name} {quantity}: {worst:.1e}");
    worst
}

/// A zone that belongs to the model: the contact problem is the one of the run, and so is its solution, to the solver's tolerance of 1e-12 of
/// the forces.
#[test]
fn histories_are_those_of_the_run() {
    let folder = TempDir::new().unwrap();
    let set = [
        "output.points.low={body=\"ball\",point=[1e-4,-0.0099],stress=true,strain=true}",
        "output.points.top={body=\"ball\",marker=\"top\",stress=true}",
    ];
    let run = simulated(&folder, "sphere_on_plane.toml", &set);
    let (probe, err) = probed(&run, &["--body", "ball", "--point", "1e-4,-0.0099", "--marker", "top"]);
    assert_eq!(err, "");
    for quantity in ["position", "velocity", "stress", "strain", "von_mises"] {
        assert!(deviation(&probe, 0, (&run, "low"), quantity) < 1e-9, "{quantity}");
    }
    for quantity in ["position", "velocity", "stress"] {
        assert!(deviation(&probe, 1, (&run, "top"), quantity) < 1e-9, "{quantity}");
    }
    assert_eq!(probe["tensor_components"][2], "tt");
    assert_eq!(probe["units"]["stress"], "Pa");
    // A ball that does not turn: deformation is displacement less that of the frame.
    let point = &probe["points"][0];
    let frame = stored(&run, "bodies/ball/position");
    let (moved, bent) = (numbers(&point["displacement"]), numbers(&point["deformation"]));
    for i in 0..moved.len() {
        let of_frame = frame[i] - frame[i % 3];
        assert!((moved[i] - of_frame - bent[i]).abs() < 1e-15, "{i}"); // round-off of places of a centimetre
    }
    // A line of points is those points.
    let line = probed(&run, &["--body", "ball", "--line", "0,0:0,0.01:3", "--from", "9e-5"]).0;
    let points = probed(
        &run,
        &["--body", "ball", "--point", "0,0", "--point", "0,0.005", "--marker", "top", "--from", "9e-5"],
    )
    .0;
    for (n, name) in ["0 0", "0 0.005", "0 0.01"].into_iter().enumerate() {
        assert_eq!(line["points"][n]["name"], name);
        assert_eq!(line["points"][n]["stress"], points["points"][n]["stress"], "{name}");
    }
    // A few instants alone: what is before them tells the velocity.
    let time = stored(&run, "time");
    let (from, to) = (format!("{:?}", time[100]), format!("{:?}", time[110]));
    let part = probed(&run, &["--body", "ball", "--point", "1e-4,-0.0099", "--from", &from, "--to", &to]).0;
    assert_same(&numbers(&part["time"]), &time[100..=110], "time");
    for quantity in ["position", "displacement", "velocity", "stress"] {
        let width = numbers(&point[quantity]).len() / time.len();
        let whole = &numbers(&point[quantity])[100 * width..111 * width];
        let found = numbers(&part["points"][0][quantity]);
        let largest = whole.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        assert!(found.iter().zip(whole).all(|(a, b)| (a - b).abs() <= 1e-9 * largest), "{quantity}");
    }
}

/// Zones refined in the run are built again about the stored places; every step is stored, so that velocities are differences over the same
/// instants.
#[test]
fn histories_beside_zones_refined_in_the_run_are_those_of_the_run() {
    let folder = TempDir::new().unwrap();
    let set = [
        "simulation.end_time=1.7e-4",
        "output.phase_states=1e9",
        "output.points.near={body=\"rod\",point=[1e-4,2e-4],stress=true,strain=true}",
        "output.points.middle={body=\"rod\",point=[0.0,0.5],stress=true}",
    ];
    let run = simulated(&folder, "sphere_rod_sphere.toml", &set);
    let (probe, err) = probed(&run, &["--body", "rod", "--point", "1e-4,2e-4", "--point", "0,0.5"]);
    assert_eq!(err, "");
    // The contact problem depends on stored positions, whose round-off is 1e-16 of a metre beside overlaps of some 1e-7: 1e-9 of the forces, and of
    // velocities by the quotient of a contact time and a step, a hundred, more.
    for (quantity, limit) in [("position", 1e-9), ("stress", 1e-6), ("strain", 1e-6), ("velocity", 1e-4)] {
        assert!(deviation(&probe, 0, (&run, "near"), quantity) < limit, "{quantity}");
    }
    for (quantity, limit) in [("position", 1e-9), ("stress", 1e-6), ("velocity", 1e-4)] {
        assert!(deviation(&probe, 1, (&run, "middle"), quantity) < limit, "{quantity}");
    }
}

/// A beam that swings: positions in space, stress in its own axes.
#[test]
fn bodies_that_turn_are_probed_in_their_axes() {
    let folder = TempDir::new().unwrap();
    let set = ["simulation.end_time=0.05", "output.points.p={body=\"beam\",point=[0.0,0.0,0.3],stress=true}"];
    let text = std::fs::read_to_string("scenarios/flexible_pendulum.toml").unwrap();
    let body = text.lines().find_map(|l| l.strip_prefix("[bodies.")?.strip_suffix(']')).unwrap().to_owned();
    let set = set.map(|s| s.replace("\"beam\"", &format!("\"{body}\"")));
    let run = simulated(&folder, "flexible_pendulum.toml", &set.each_ref().map(String::as_str));
    let (probe, _) = probed(&run, &["--body", &body, "--point", "0,0,0.3"]);
    for quantity in ["position", "velocity", "stress"] {
        assert!(deviation(&probe, 0, (&run, "p"), quantity) < 1e-12, "{quantity}"); // the same sums
    }
    let (modes, _) = probed(&run, &["--body", &body, "--modes"]);
    for (name, path) in [
        ("time", "time".to_owned()),
        ("elastic_coordinates", format!("bodies/{body}/elastic_coordinates")),
        ("elastic_velocities", format!("bodies/{body}/elastic_velocities")),
        ("eigenfrequencies", format!("bodies/{body}/eigenfrequencies")),
    ] {
        assert_same(&numbers(&modes[name]), &stored(&run, &path), name);
    }
}

#[test]
fn csv_has_a_row_an_instant_and_point() {
    let folder = TempDir::new().unwrap();
    let run = simulated(&folder, "sphere_on_plane.toml", &["simulation.end_time=2e-5"]);
    let file = run.display().to_string();
    let (code, out, err) =
        fbimpact(&["probe", &file, "--body", "ball", "--point", "0,0", "--marker", "top", "--csv"]);
    assert_eq!(code, 0, "{err}");
    let n = stored(&run, "time").len();
    let rows: Vec<Vec<&str>> = out.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 1 + 2 * n);
    let columns = ["point", "time", "position_x", "position_y", "position_z", "displacement_x"];
    assert_eq!(rows[0][..6], columns);
    assert_eq!(
        rows[0][14..],
        "stress_rr,stress_zz,stress_tt,stress_rz,von_mises,strain_rr,strain_zz,strain_tt,strain_rz"
            .split(',')
            .collect::<Vec<_>>()
    );
    assert!(rows.iter().all(|row| row.len() == rows[0].len()));
    assert_eq!((rows[1][0], rows[n + 1][0], rows[1][4], rows[n + 1][4]), ("0 0", "top", "0.01", "0.02"));
    let (code, out, _) = fbimpact(&["probe", &file, "--body", "ball", "--modes"]);
    let header = out.lines().next().unwrap();
    assert!(code == 0 && header.starts_with("time,q1,q2") && header.ends_with("v6"), "{header}");
    assert_eq!(out.lines().count(), n + 1);
}

#[test]
fn what_there_is_not_is_refused_with_what_there_is() {
    let folder = TempDir::new().unwrap();
    let run = simulated(&folder, "sphere_on_plane.toml", &["simulation.end_time=2e-6"]);
    for (options, words) in [
        (&["--body", "disc", "--point", "0,0"][..], &["--body disc", "ball, floor"][..]),
        (&["--body", "floor", "--point", "0,0"], &["--body floor", "plane at rest"]),
        (&["--body", "ball", "--point", "0,0.02"], &["--point 0,0.02", "not in"]),
        (&["--body", "ball", "--point", "0,0,0.001"], &["--point 0,0,0.001", "2 coordinates"]),
        (&["--body", "ball", "--point", "a,b"], &["X,Y,Z"]),
        (&["--body", "ball", "--marker", "tip"], &["--marker tip", "top"]),
        (&["--body", "ball"], &["--point"]),
        (&["--body", "ball", "--point", "0,0", "--modes"], &["--modes"]),
        (&["--body", "ball", "--point", "0,0", "--from", "1"], &["no instant", "1e0 s"]),
        (&["--body", "ball", "--point", "0,0", "--csv", "--json"], &["--csv"]),
    ] {
        let (code, err) = refused(&run, options);
        assert_eq!(code, 2, "{options:?}: {err}");
        assert!(words.iter().all(|word| err.contains(word)), "{options:?}: {err}");
    }
    let (code, err) = refused(Path::new("nowhere.h5"), &["--body", "ball", "--modes"]);
    assert!(code == 6 && err.contains("nowhere.h5"), "{err}");
}

/// What friction leaves behind is not stored: the message says which contact, and motion by the coordinates stays.
#[test]
fn zones_that_cannot_be_solved_again_are_named() {
    let folder = TempDir::new().unwrap();
    let run = simulated(
        &folder,
        "sphere_on_plane.toml",
        &[
            "simulation.end_time=1.5e-5",
            "contacts.impact.friction=0.3",
            "output.points.top.body=ball",
            "output.points.top.marker=top",
        ],
    );
    let (probe, err) = probed(&run, &["--body", "ball", "--marker", "top"]);
    assert!(err.contains("contact \"impact\"") && err.contains("friction"), "{err}");
    // The top is far from the zone: it misses no more than the quasistatic displacement there, a thousandth of the overlap of some 2 µm.
    let n = probe["time"].as_array().unwrap().len();
    let (found, expected) = (numbers(&probe["points"][0]["position"]), stored(&run, "points/top/position"));
    assert!((0..3 * n).all(|i| (found[i] - expected[i]).abs() < 1e-8));
    let [pictures, page] =
        ["pictures", "page.html"].map(|name| folder.path().join(name).display().to_string());
    let file = run.display().to_string();
    for arguments in [["export", &file, "--vtk", &pictures], ["report", &file, "-o", &page]] {
        let (code, _, err) = fbimpact(&arguments);
        assert_eq!(code, 0, "{err}");
        assert!(err.contains("contact \"impact\" are left out"), "{arguments:?}: {err}");
    }
    let page = std::fs::read_to_string(page).unwrap();
    assert!(page.contains("Here local deformation and stress by contact &quot;impact&quot; are left out"));
    // Of a contact that did not touch there is nothing to leave out.
    let leaves =
        ["bodies.ball.velocity=[0,0,0.1]", "simulation.end_time=1e-6", "contacts.impact.friction=0.3"];
    let apart = simulated(&folder, "sphere_on_plane.toml", &leaves);
    let (_, err) = probed(&apart, &["--body", "ball", "--marker", "top"]);
    assert!(!err.contains("left out"), "{err}");
}

#[test]
fn rigid_bodies_have_a_motion_and_no_stress() {
    let folder = TempDir::new().unwrap();
    let run = simulated(&folder, "rigid_double_pendulums.toml", &["simulation.end_time=0.1"]);
    let text = std::fs::read_to_string("scenarios/rigid_double_pendulums.toml").unwrap();
    let body = text.lines().find_map(|l| l.strip_prefix("[bodies.")?.strip_suffix(']')).unwrap();
    let point = ["0,0,0", "0,0"].into_iter().find(|p| {
        let file = run.display().to_string();
        fbimpact(&["probe", &file, "--body", body, "--point", p]).0 == 0
    });
    let (probe, _) = probed(&run, &["--body", body, "--point", point.unwrap()]);
    // The origin of the frame.
    let position = stored(&run, &format!("bodies/{body}/position"));
    assert_same(&numbers(&probe["points"][0]["position"]), &position, "position");
    assert!(probe["points"][0]["stress"].is_null());
    let (code, err) = refused(&run, &["--body", body, "--modes"]);
    assert!(code == 2 && err.contains("rigid"), "{err}");
}

/// A body from a mesh that falls and turns, named relative to the scenario: the result is read from any folder, and beside the mesh where the
/// scenario is gone.
#[test]
fn results_of_bodies_from_files_are_read_from_any_folder() {
    const FALLING: &str = r#"
        [simulation]
        end_time = 2e-3
        gravity = [0.0, 0.0, -9.81]
        [materials.aluminium]
        youngs_modulus = 70e9
        poissons_ratio = 0.33
        density = 2700.0
        [bodies.part]
        model = "mesh"
        file = "part.inp"
        units = "m"
        material = "aluminium"
        reduction = { method = "modal", modes = 6 }
        [loads.push]
        body = "part"
        point = [0.065, 0.0, 0.006]
        radius = 0.004
        force_x = { kind = "harmonic", amplitude = 100.0, frequency = 2e3 }
        [output.points.p]
        body = "part"
        point = [0.064, 0.002, 0.005]
        stress = true
        strain = true
    "#;
    let folder = TempDir::new().unwrap();
    let (here, there) = (folder.path().join("here/models"), folder.path().join("there"));
    std::fs::create_dir_all(&here).unwrap();
    std::fs::create_dir_all(&there).unwrap();
    let mesh = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mesh_parts/bar_hex20.inp");
    std::fs::copy(&mesh, here.join("part.inp")).unwrap();
    std::fs::write(here.join("fall.toml"), FALLING).unwrap();
    let program = |at: &Path, arguments: &[&str]| {
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_fbimpact"));
        let run = { run }.args(arguments).current_dir(at).output().unwrap();
        let err = String::from_utf8(run.stderr).unwrap();
        assert!(run.status.success(), "{arguments:?}: {err}");
        String::from_utf8(run.stdout).unwrap()
    };
    program(&folder.path().join("here"), &["run", "-q", "models/fall.toml", "-o", "fall.h5"]);
    let options = ["--body", "part", "--point", "0.064,0.002,0.005", "--json"];
    let out = program(&there, &[&["probe", "../here/fall.h5"], &options[..]].concat());
    let probe: Value = serde_json::from_str(&out).unwrap();
    let file = folder.path().join("here/fall.h5");
    for quantity in ["position", "velocity", "stress", "strain"] {
        assert!(deviation(&probe, 0, (&file, "p"), quantity) < 1e-12, "{quantity}"); // the same sums
    }
    program(&there, &["export", "../here/fall.h5", "--vtk", "pictures", "--every", "1000"]);
    // Moved to where only the mesh is.
    std::fs::rename(&file, there.join("fall.h5")).unwrap();
    std::fs::rename(here.join("part.inp"), there.join("part.inp")).unwrap();
    std::fs::remove_file(here.join("fall.toml")).unwrap();
    let out = program(folder.path(), &[&["probe", "there/fall.h5"], &options[..]].concat());
    assert_eq!(serde_json::from_str::<Value>(&out).unwrap(), probe);
}
