//! Bodies of finite elements in scenarios: against CalculiX and bodies of splines, faults, runs, resumption, cache, pictures.

use crate::blocks;
use crate::support::scenarios;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::support::bar::{ALUMINIUM, CLAMP, CLAMPED_BRICKS, HINGE, HINGED_BRICKS, OTHER_HINGE};
use crate::support::scenarios::{run, system_frequencies};
use crate::writers::{Form, gmsh};
use fbimpact::commands::scenario_file;
use fbimpact::scenario::{Fault, Scenario};
use fbimpact::simulate::modes;
use fe_mesh::ElementKind;

const WORLD: &str = "[simulation]\nend_time = 1e-3\n";

/// The bar of `tests/cantilever.rs` as a mesh of 20 × 3 × 2 hexahedra in millimetres.
const BAR: &str = r#"
[bodies.beam]
model = "mesh"
file = "bar.msh"
units = "mm"
material = "aluminium"
reduction = { method = "modal", modes = 20 }
"#;

/// Files that all tests read.
fn files() -> &'static Path {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY.get_or_init(|| {
        let directory = scenarios::folder("meshed");
        let bar = |[x, y, z]: [f64; 3]| [300.0 * x, 30.0 * (y - 0.5), 10.0 * (z - 0.5)];
        let write = |name: &str, kind, n, form| {
            std::fs::write(directory.join(name), gmsh(&blocks::block(kind, n, bar), form)).unwrap();
        };
        write("bar.msh", ElementKind::Hex20, [20, 3, 2], Form::Binary41);
        for (kind, name) in
            [(ElementKind::Tet10, "tet10"), (ElementKind::Hex20, "hex20"), (ElementKind::Wedge15, "wedge15")]
        {
            let block = |[x, y, z]: [f64; 3]| [90.0 * x, 30.0 * (y - 0.5), 20.0 * (z - 0.5)];
            for n in [1, 2, 4] {
                let bytes = gmsh(&blocks::block(kind, [3 * n, n, n], block), Form::Text22);
                std::fs::write(directory.join(format!("{name}_{n}.msh")), bytes).unwrap();
            }
        }
        for kind in [ElementKind::Pyramid13, ElementKind::Pyramid14] {
            let block = |[x, y, z]: [f64; 3]| [90.0 * x, 30.0 * (y - 0.5), 20.0 * (z - 0.5)];
            for n in [1, 2, 4] {
                let name = kind.name();
                let write = |name: String, mesh| {
                    std::fs::write(directory.join(name), gmsh(&mesh, Form::Binary41)).unwrap();
                };
                write(format!("{name}_{n}.msh"), blocks::block(kind, [3 * n, n, n], block));
                write(format!("mixed_{name}_{n}.msh"), blocks::mixed(kind, [3 * n, n, n], block));
            }
        }
        directory
    })
}

fn parse(text: &str, set: &[&str]) -> Result<Scenario, Vec<Fault>> {
    scenarios::parse(files(), text, set)
}

fn valid(text: &str, set: &[&str]) -> Scenario {
    scenarios::valid(files(), text, set)
}

/// Messages of the faults of a scenario.
fn faults(text: &str, set: &[&str]) -> String {
    parse(text, set).unwrap_err().iter().map(|f| format!("{f}\n")).collect()
}

fn free_frequencies(text: &str, set: &[&str]) -> Vec<f64> {
    modes(&valid(text, set), None, 1).unwrap().bodies[0].frequencies.clone()
}

#[test]
fn a_mesh_that_is_written_to_a_file_is_the_same_body() {
    let clamped = format!("{WORLD}{ALUMINIUM}{BAR}{CLAMP}");
    let own = system_frequencies(&valid(&clamped, &[]));
    std::fs::write(files().join("clamped.toml"), &clamped).unwrap();
    for (file, how, reduction) in [
        ("full.h5", &["--full"][..], "reduction = { method = \"modal\", modes = 20 }\n"),
        ("reduced.h5", &[], ""),
    ] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
        let export = program.current_dir(files()).args(["export-body", "clamped.toml", "--body", "beam"]);
        let done = export.args(how).args(["-o", file]).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        let body = format!("[bodies.beam]\nmodel = \"imported\"\nfile = \"{file}\"\n{reduction}");
        let clamp = CLAMP.replace("face = \"x-\"", "marker = \"x-\"");
        let found = system_frequencies(&valid(&format!("{WORLD}{body}{clamp}"), &[]));
        for (found, own) in found.iter().zip(&own).take(10) {
            // Modes are right to 1e-9 or so.
            assert!((found / own - 1.0).abs() < 1e-8, "{file}: {found} {own}");
        }
    }
}

#[test]
fn twenty_frequencies_are_those_of_calculix_on_the_same_mesh() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mesh_parts");
    let text = format!(
        "{WORLD}[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\ndensity = 7850.0\n\
         [bodies.beam]\nmodel = \"mesh\"\nunits = \"m\"\nmaterial = \"steel\"\nmass_points = \"as-stiffness\"\n\
         reduction = {{ method = \"modal\", modes = 20 }}\n"
    );
    for name in ["bar_hex20", "bar_tet10"] {
        let file = format!("bodies.beam.file={:?}", folder.join(format!("{name}.inp")).to_str().unwrap());
        let found = free_frequencies(&text, &[&file]);
        let reference = std::fs::read_to_string(folder.join(format!("{name}.frequencies"))).unwrap();
        let reference: Vec<f64> = reference.lines().map(|l| l.parse().unwrap()).collect();
        assert_eq!((found.len(), reference.len()), (20, 20));
        for (f, r) in found.iter().zip(&reference) {
            // CalculiX prints seven digits of the eigenvalue.
            assert!((f / r - 1.0).abs() < 1e-6, "{name}: {f}, {r}");
        }
        // Integrated exactly, the mass of tetrahedra is larger where functions vary: frequencies of this coarse mesh fall, none by more than the mesh is off.
        let exact = free_frequencies(&text, &[&file, "bodies.beam.mass_points=exact"]);
        for (f, r) in exact.iter().zip(&reference) {
            let share = f / r - 1.0;
            let allowed = if name == "bar_hex20" { -1e-6..1e-6 } else { -0.04..1e-9 };
            assert!(allowed.contains(&share), "{name}: {share}");
        }
    }
}

#[test]
fn frequencies_of_a_bar_converge_with_the_fourth_power_of_the_element() {
    let text = format!("{WORLD}{ALUMINIUM}{BAR}");
    // The same bar of splines of degree 3 on a fine mesh.
    let spline = format!(
        "{WORLD}{ALUMINIUM}[bodies.beam]\nmaterial = \"aluminium\"\n\
         geometry = {{ shape = \"box\", size = [0.09, 0.03, 0.02] }}\nreduction = {{ method = \"modal\", modes = 4 }}\n\
         discretisation = {{ degree = 4, elements = [12, 5, 4] }}\n"
    );
    let exact = free_frequencies(&spline, &[]);
    let kinds = ["tet10", "hex20", "wedge15", "pyramid13", "pyramid14", "mixed_pyramid13", "mixed_pyramid14"];
    for name in kinds {
        let errors: Vec<f64> = [1, 2, 4]
            .map(|n| {
                let file = format!("bodies.beam.file={name}_{n}.msh");
                let found = free_frequencies(&text, &[&file, "bodies.beam.reduction.modes=4"]);
                // Bending about the weak axis.
                found[0] / exact[0] - 1.0
            })
            .to_vec();
        println!("{name}: {errors:?}");
        // Half the size: 1/16 of the error in the limit. The coarsest mesh has one element over the thickness and is not near it.
        assert!(
            errors[2] > -1e-6 && errors[1] < errors[0] / 4.0 && errors[2] < errors[1] / 8.0,
            "{name}: {errors:?}"
        );
    }
}

/// The mesh with nodes in one place made one.
fn merged(mut raw: fe_mesh::mesh::raw::RawMesh) -> fe_mesh::mesh::raw::RawMesh {
    let mut places = std::collections::HashMap::new();
    let key = |p: &[f64; 3]| p.map(|x| (1e6 * x).round() as i64);
    let first: Vec<u32> =
        (0_u32..).zip(&raw.nodes).map(|(i, p)| *places.entry(key(p)).or_insert(i)).collect();
    raw.elements.renumber(&first);
    raw
}

#[test]
fn a_ring_with_curved_sides_is_that_of_splines() {
    let ring = |[a, r, z]: [f64; 3]| {
        let (sin, cos) = (-std::f64::consts::TAU * a).sin_cos();
        [(5.0 + 5.0 * r) * cos, (5.0 + 5.0 * r) * sin, 5.0 * z]
    };
    let spline = format!(
        "{WORLD}{ALUMINIUM}[bodies.beam]\nmaterial = \"aluminium\"\nreduction = {{ method = \"modal\", modes = 4 }}\n\
         geometry = {{ shape = \"hollow-cylinder\", inner_radius = 5e-3, outer_radius = 10e-3, length = 5e-3 }}\n\
         discretisation = {{ degree = 4, elements = [12, 3, 3] }}\n"
    );
    let first = |text: &str, set: &[&str]| {
        let report = modes(&valid(text, set), None, 1).unwrap();
        (report.bodies[0].mass, report.bodies[0].frequencies[0])
    };
    let (mass, frequency) = first(&spline, &[]);
    for (kind, name) in [(ElementKind::Tet10, "tet10"), (ElementKind::Hex20, "hex20")] {
        let errors: Vec<[f64; 2]> = [1, 2]
            .map(|n| {
                let raw = merged(blocks::block(kind, [8 * n, n, n], ring));
                let file = format!("ring_{name}_{n}.msh");
                std::fs::write(files().join(&file), gmsh(&raw, Form::Binary22)).unwrap();
                let set = [format!("bodies.beam.file={file}"), "bodies.beam.reduction.modes=4".to_owned()];
                let set: Vec<&str> = set.iter().map(String::as_str).collect();
                let (m, f) = first(&format!("{WORLD}{ALUMINIUM}{BAR}"), &set);
                [m / mass - 1.0, f / frequency - 1.0]
            })
            .to_vec();
        // Parabolas through arcs of 45° err by a⁴/480 of the area, 8e-4, of half of it by 1/16 of that. The first mesh has one element
        // over the thickness; its frequencies are not near the limit of 1/16.
        assert!(
            errors[0][0].abs() < 1e-3 && (14.0..18.0).contains(&(errors[0][0] / errors[1][0])),
            "{name}: {errors:?}"
        );
        assert!(errors[1][1].abs() < errors[0][1].abs() / 4.0, "{name}: {errors:?}");
    }
}

#[test]
fn a_clamped_bar_has_the_frequencies_of_calculix() {
    // CalculiX with the same elements: equal to the seven digits that it prints.
    let of = |joints: &str| system_frequencies(&valid(&format!("{WORLD}{ALUMINIUM}{BAR}{joints}"), &[]));
    let found = of(CLAMP);
    for (f, r) in found.iter().zip(CLAMPED_BRICKS) {
        assert!((f / r - 1.0).abs() < 1e-6, "{found:?}");
    }
    let found = of(&format!("{HINGE}{OTHER_HINGE}"));
    for (f, r) in found.iter().zip(HINGED_BRICKS) {
        assert!((f / r - 1.0).abs() < 1e-6, "{found:?}");
    }
}

#[test]
fn a_rigid_place_is_stiffer_than_an_averaged_one() {
    let first = |coupling: &str| {
        let set = format!("joints.clamp.child.coupling={coupling}");
        system_frequencies(&valid(&format!("{WORLD}{ALUMINIUM}{BAR}{CLAMP}"), &[&set]))[0]
    };
    // CalculiX on the same mesh with every node of the face held (docs/verification.md); a rigid part yields 1e-5 of what an elastic one does.
    let (average, rigid) = (first("average"), first("rigid"));
    assert!(rigid > average && (rigid / 92.1949 - 1.0).abs() < 1e-4, "{average}, {rigid}");
}

#[test]
fn a_pendulum_swings_as_one_of_splines_does() {
    let rest = r#"
[simulation]
end_time = 0.1
gravity = [0.0, 0.0, -9.81]
[simulation.free]
integrator = "esdirk4"
max_step = 1e-3
[joints.hinge]
type = "revolute"
axis = [0.0, 1.0, 0.0]
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "beam", face = "x-" }
[loads.push]
body = "beam"
face = "x+"
force_y = 2.0
[output]
free_interval = 5e-3
"#;
    let mesh =
        format!("{rest}{ALUMINIUM}{BAR}[output.points]\ntip = {{ body = \"beam\", marker = \"x+\" }}\n");
    let spline = format!(
        "{rest}{ALUMINIUM}[bodies.beam]\nmaterial = \"aluminium\"\n\
         geometry = {{ shape = \"box\", size = [0.3, 0.03, 0.01] }}\nreduction = {{ method = \"modal\", modes = 20 }}\n\
         discretisation = {{ degree = 3, elements = [20, 3, 2] }}\n\
         [bodies.beam.markers]\nfar = {{ face = \"x+\" }}\n\
         [output.points]\ntip = {{ body = \"beam\", marker = \"far\" }}\n"
    );
    let path = |text: &str| {
        run(&valid(text, &[])).samples.iter().map(|s| (s.time, s.points[0].position)).collect::<Vec<_>>()
    };
    let (a, b) = (path(&mesh), path(&spline));
    assert_eq!(a.len(), b.len());
    let sideways = a.iter().map(|(_, p)| p[1].abs()).fold(0.0, f64::max);
    assert!(sideways > 1e-6, "it bends: {sideways}");
    for ((t, p), (_, q)) in a.iter().zip(&b) {
        // Deflections agree to the 1e-3 by which meshes err, the swing of 0.3 m to the tolerance of the steps.
        let distance = (0..3).map(|d| (p[d] - q[d]).powi(2)).sum::<f64>().sqrt();
        assert!(distance < 1e-5 + 2e-3 * sideways, "t = {t}: {p:?}, {q:?}");
    }
}

#[test]
fn faults_say_what_is_there() {
    let text = format!("{WORLD}{ALUMINIUM}{BAR}{CLAMP}");
    for (set, words) in [
        ("bodies.beam.file=none.msh", &["bodies.beam.file", "cannot be read"][..]),
        ("joints.clamp.child.face=top", &["unknown face", "x-", "z+"]),
        ("bodies.beam.groups.shaft.material=aluminium", &["no group \"shaft\" of elements", "all"]),
        ("bodies.beam.markers.a={point=[0.0,0.0,0.0],radius=0.1}", &["markers", "beyond the body"]),
        ("bodies.beam.reduction.modes=99999", &["must be at most"]),
        ("bodies.beam.units=ft", &["\"m\"", "\"in\""]),
        ("bodies.beam.thickness=1.0", &["thickness"]),
        ("bodies.beam.geometry={shape=\"sphere\",radius=1.0}", &["not from a file"]),
        ("output.stress.a={body=\"beam\",from=[0.0,0.0,0.0],to=[9.0,0.0,0.0]}", &["not in the body", "9"]),
        ("output.stress.a={body=\"beam\",from=\"x-\",to=[0.1,0.0,0.0]}", &["whole face"]),
    ] {
        let found = faults(&text, &[set]);
        assert!(words.iter().all(|w| found.contains(w)), "{set}: {found}");
    }
    let found = faults(&text.replace("units = \"mm\"\n", ""), &[]);
    assert!(found.contains("bodies.beam.units") && found.contains("does not say"), "{found}");
    let found = faults(&text.replace("face = \"x-\"", "point = [0.0, 0.0, 0.0]"), &[]);
    assert!(found.contains("carries no force") && found.contains("\"x-\""), "{found}");
    let contact = "[bodies.wall]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\n\
                   [contacts.a]\ncontact_body = \"beam\"\ntarget_body = \"wall\"\n";
    // The model that contacts have unless they name one needs nothing of the mesh.
    valid(&format!("{text}{contact}"), &[]);
    let found = faults(&format!("{text}{contact}modes = \"own\"\n"), &[]);
    assert!(found.contains("contacts.a.modes") && found.contains("\"prolonged\""), "{found}");
}

#[test]
fn groups_have_materials_of_their_own() {
    let text = format!(
        "{WORLD}{ALUMINIUM}[materials.lead]\nyoungs_modulus = 16e9\npoissons_ratio = 0.44\ndensity = 11340.0\n{BAR}"
    );
    let mass = |set: &[&str]| modes(&valid(&text, set), None, 1).unwrap().bodies[0].mass;
    let volume = 0.3 * 0.03 * 0.01;
    assert!((mass(&[]) / (2700.0 * volume) - 1.0).abs() < 1e-12);
    let lead = mass(&["bodies.beam.groups.all.material=lead"]);
    assert!((lead / (11340.0 * volume) - 1.0).abs() < 1e-12);
    let without = text.replace(
        "material = \"aluminium\"\n",
        "[bodies.beam.groups.all]\nmaterial = \"lead\"\n[bodies.beam.other]\n",
    );
    assert!(parse(&without, &[]).is_err(), "unknown key");
}

fn program(arguments: &[&str], folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
    command.args(arguments).current_dir(folder).env("XDG_CACHE_HOME", folder).env("HOME", folder);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

fn finished(arguments: &[&str], folder: &Path) -> String {
    let output = program(arguments, folder).output().unwrap();
    let text = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
    assert!(output.status.success(), "{arguments:?}: {text}");
    text
}

#[test]
fn a_killed_run_is_taken_up_from_another_folder_with_models_from_the_cache() {
    let place = tempfile::tempdir().unwrap();
    let (work, other) = (place.path().join("work"), place.path().join("other"));
    std::fs::create_dir_all(work.join("meshes")).unwrap();
    std::fs::create_dir_all(&other).unwrap();
    std::fs::copy(files().join("bar.msh"), work.join("meshes/bar.msh")).unwrap();
    let text = format!(
        "{WORLD}{ALUMINIUM}{BAR}{CLAMP}[loads.pull]\nbody = \"beam\"\nface = \"x+\"\nforce_z = 5.0\n"
    )
    .replace("\"bar.msh\"", "\"meshes/bar.msh\"")
    .replace("end_time = 1e-3", "end_time = 60e-3");
    std::fs::write(work.join("bar.toml"), text).unwrap();
    let whole = finished(&["run", "-q", "bar.toml", "-o", "whole.h5", "--cache-dir", "models"], &work);
    assert!(!whole.contains("error"), "{whole}");
    let models = std::fs::read_dir(work.join("models")).unwrap().count();
    assert!(models > 0, "modes are kept");
    let mut child =
        program(&["run", "-q", "bar.toml", "-o", "part.h5", "--cache-dir", "models"], &work).spawn().unwrap();
    let begin = Instant::now();
    while !work.join("part.h5.restart").exists() {
        assert!(begin.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(2));
    }
    std::thread::sleep(Duration::from_millis(100));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!work.join("part.h5").exists(), "too late to be killed");
    finished(&["run", "-q", "--resume", "../work/part.h5"], &other);
    let same = finished(&["compare", "part.h5", "whole.h5", "--rtol", "1e-14"], &work);
    assert!(!same.is_empty());
    // A file that has changed is refused.
    let mut child = program(&["run", "-q", "bar.toml", "-o", "again.h5"], &work).spawn().unwrap();
    while !work.join("again.h5.restart").exists() {
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    std::fs::copy(files().join("hex20_2.msh"), work.join("meshes/bar.msh")).unwrap();
    let output = program(&["run", "-q", "--resume", "again.h5"], &work).output().unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && text.contains("has changed"), "{text}");
}

#[test]
fn the_connecting_rod_turns_and_is_shown() {
    let place = tempfile::tempdir().unwrap();
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/connecting_rod.toml");
    let scenario = scenario.to_str().unwrap();
    finished(&["check", scenario], place.path());
    finished(&["run", "-q", scenario, "-o", "rod.h5"], place.path());
    let recording = run(&scenario_file::read(Path::new(scenario), &[]).unwrap());
    // x = r cos a + sqrt(l² - r² sin² a): 100 mm at the start, 60 mm at the other dead centre; the rod yields less than 10 µm under the load.
    let x = |s: &adaptive::record::Sample| s.points[0].position[0];
    let ends =
        recording.samples.iter().map(x).fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    // Samples lie 0.05 rad apart: the ends are met to r (1 + r/l) 0.025²/2.
    assert!((ends.0 - 0.06).abs() < 2e-5 && (ends.1 - 0.1).abs() < 2e-5, "{ends:?}");
    finished(&["export", "rod.h5", "--vtk", "out", "--bodies", "rod"], place.path());
    let folder = place.path().join("out/rod");
    let files: Vec<_> = std::fs::read_dir(folder).unwrap().collect();
    assert!(files.len() > 100, "{}", files.len());
}
