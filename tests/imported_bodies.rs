//! Bodies from files in scenarios: what is read, faults, and motions equal to those of the bodies that were written.

use crate::support::scenarios;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::beam_file::{BENDING, LENGTH, LINE_MASS, write_beam};
use adaptive::record::Sample;
use adaptive::spec::ImportedSpec;
use adaptive::spec::{BodyKind, DampingSpec, FrameSpec, Place, ReductionSpec};
use assert_cmd::Command;
use fbimpact::commands::scenario_file;
use fbimpact::interchange::body_file::{BodyFile, read, write_reduced};
use fbimpact::scenario::{Fault, Scenario};
use fbimpact::simulate::modes;
use ffr_dynamics::interchange::ReducedModel;

/// A hinged beam from the file of another program.
const SWING: &str = r#"
[simulation]
end_time = 0.5
gravity = [0.0, -9.81, 0.0]
[bodies.beam]
model = "imported"
file = "beam.h5"
reduction = { method = "modal", modes = 8 }
[joints.hinge]
type = "revolute"
axis = [0.0, 0.0, 1.0]
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "beam", marker = "hinge" }
[output]
free_interval = 1e-3
points = { tip = { body = "beam", marker = "tip" } }
"#;

/// The same beam, reduced already.
const REDUCED: &str = r#"
[simulation]
end_time = 0.5
[bodies.rod]
model = "imported"
file = "reduced.h5"
[output]
points = { tip = { body = "rod", marker = "end" } }
"#;

/// Files that all tests read: the beam, and the rod of the flexible pendulum written by the program.
fn files() -> &'static Path {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY.get_or_init(|| {
        let directory = scenarios::folder("imported_bodies");
        write_beam(&directory.join("beam.h5"));
        std::fs::write(directory.join("text.h5"), "no HDF5").unwrap();
        for (name, flags) in [("reduced.h5", &[][..]), ("full.h5", &["--full"])] {
            let output = directory.join(name);
            let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
            command.arg("export-body").arg(pendulum_file()).args(["--body", "rod", "--output"]).arg(&output);
            command.args(flags).assert().success();
        }
        directory
    })
}

fn pendulum_file() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/flexible_pendulum.toml")
}

fn parse(text: &str, set: &[&str]) -> Result<Scenario, Vec<Fault>> {
    scenarios::parse(files(), text, set)
}

fn valid(text: &str, set: &[&str]) -> Scenario {
    scenarios::valid(files(), text, set)
}

/// Asserts that the only fault after each change is at the key and has the words.
fn assert_faults(text: &str, cases: &[(&[&str], &str, &str)]) {
    for (set, key, words) in cases {
        let faults = parse(text, set).expect_err(&format!("{set:?} is a fault"));
        assert_eq!(faults.len(), 1, "{set:?}: {faults:?}");
        assert_eq!(&faults[0].key, key, "{set:?}: {}", faults[0]);
        assert!(faults[0].to_string().contains(words), "{set:?}: {}", faults[0]);
    }
}

#[test]
fn full_files_are_reduced_as_the_scenario_says() {
    let set = [
        "bodies.beam.reduction={method=\"craig-bampton\",modes=6}",
        "bodies.beam.damping={modal=0.01}",
        "bodies.beam.frame=tangent",
    ];
    let spec = valid(SWING, &set).run;
    let BodyKind::Imported(ImportedSpec::Full { body, flexible }) = &spec.bodies[0].kind else {
        panic!("a full file")
    };
    assert_eq!(body.body().name, "beam");
    assert_eq!(flexible.reduction, ReductionSpec::CraigBampton { modes: 6, fixed_interface_modes: None });
    assert!(flexible.static_answers);
    assert_eq!(flexible.damping, DampingSpec::Modal(vec![0.01]));
    // A tangent frame follows the joint whose child the body is.
    assert_eq!(flexible.frame, FrameSpec::Tangent(Place::Marker("hinge".into())));
    assert_eq!(spec.points[0].place, Place::Marker("tip".into()));

    let set = ["bodies.beam.frame=tangent", "bodies.beam.frame_marker=tip"];
    let spec = valid(SWING, &set).run;
    let BodyKind::Imported(ImportedSpec::Full { flexible, .. }) = &spec.bodies[0].kind else {
        panic!("full")
    };
    assert_eq!(flexible.frame, FrameSpec::Tangent(Place::Marker("tip".into())));
}

#[test]
fn resolved_scenario_holds_the_checksum_and_is_valid_again() {
    for (text, body) in [(SWING, "beam"), (REDUCED, "rod")] {
        let first = valid(text, &[]);
        let resolved = &first.source.resolved;
        assert!(resolved.contains("file_sha256 = \""), "{resolved}");
        let second = valid(resolved, &[]);
        assert_eq!(&second.source.resolved, resolved);
        // Each has read the file for itself.
        assert_eq!(second.bodies, first.bodies);
        assert_eq!((&second.run.joints, &second.run.settings), (&first.run.joints, &first.run.settings));
        let key = format!("bodies.{body}.file_sha256");
        let set = [&*format!("{key}=00ff")];
        assert_faults(resolved, &[(&set, &key, "has changed, it has ")]);
    }
}

#[test]
fn faults_of_full_files_name_key_and_remedy() {
    assert_faults(
        SWING,
        &[
            (&["bodies.beam.file=none.h5"], "bodies.beam.file", "none.h5: cannot be read: No such file"),
            (&["bodies.beam.file=."], "bodies.beam.file", "it is a folder, name a file"),
            (&["bodies.beam.file=text.h5"], "bodies.beam.file", "text.h5: cannot be opened as an HDF5 file"),
            (&["bodies.beam.material=m"], "bodies.beam.material", "not \"imported\" only"),
            (&["bodies.beam.thickness=0.1"], "bodies.beam.thickness", "planar rigid shapes only"),
            (
                &["bodies.beam.geometry={shape=\"disc\",radius=1.0}"],
                "bodies.beam.geometry",
                "not from a file only",
            ),
            (&["bodies.beam.discretisation.degree=3"], "bodies.beam.discretisation", "with a shape only"),
            (
                &["bodies.beam.geometric_stiffening=true"],
                "bodies.beam.geometric_stiffening",
                "with a shape or a mesh only",
            ),
            (&["bodies.beam.markers.m.point=[0,0]"], "bodies.beam.markers", "those of the file"),
            (&["bodies.beam.reduction.modes=61"], "bodies.beam.reduction.modes", "at most 60"),
            (
                &["output.points.tip.marker=tipp"],
                "output.points.tip.marker",
                "Known are \"hinge\" or \"tip\"",
            ),
            (&["joints.hinge.parent={body=\"ground\"}"], "joints.hinge.parent.point", "missing"),
            (&["joints.hinge.child.marker=x"], "joints.hinge.child.marker", "beam.h5, known are"),
            (&["output.points.p={body=\"beam\",point=[0,0]}"], "output.points.p.point", "name a marker"),
            (&["loads.l={body=\"beam\",point=[0,0],force_x=1.0}"], "loads.l.point", "name a marker"),
            (&["loads.l={body=\"beam\",marker=\"tip\",force_z=1.0}"], "loads.l.force_z", "plane"),
            (
                &["bodies.beam.frame=tangent", "bodies.beam.frame_point=[0,0]"],
                "bodies.beam.frame_point",
                "name a marker",
            ),
            (&["joints.hinge.type=spherical"], "joints.hinge.type", "plane"),
            (&["simulation.gravity=[0,0,1]"], "simulation.gravity", "in the plane"),
            (
                &["output.stress.s={body=\"beam\",from=\"hinge\",to=\"tip\"}"],
                "output.stress.s.body",
                "has no stress",
            ),
        ],
    );
    let unknown = parse(SWING, &["output.points.tip.marker=tipp"]).unwrap_err();
    assert_eq!(unknown[0].suggestion.as_deref(), Some("tip"));
    // Without the file nothing that depends on it is reported.
    let missing = SWING.replace("file = \"beam.h5\"\n", "");
    assert_faults(&missing, &[(&[], "bodies.beam.file", "required key is missing")]);
    // Files belong to bodies that are imported.
    let wall = "bodies.wall={model=\"rigid\",geometry={shape=\"plane\"},normal=[0,1,0],file=\"beam.h5\"}";
    assert_faults(SWING, &[(&[wall], "bodies.wall.file", "axisymmetric ones without \"geometry\" only")]);
}

#[test]
fn contacts_of_imported_bodies_are_refused() {
    let wall = "bodies.wall={model=\"rigid\",geometry={shape=\"plane\"},normal=[0,1,0]}";
    for model in ["dynamic", "adaptive", "hertz"] {
        let contact = format!("contacts.c={{contact_body=\"beam\",target_body=\"wall\",model=\"{model}\"}}");
        assert_faults(SWING, &[(&[wall, &contact], "contacts.c.contact_body", "has no surface")]);
    }
}

#[test]
fn reduced_files_take_no_reduction() {
    assert_faults(
        REDUCED,
        &[
            (&["bodies.rod.reduction.modes=3"], "bodies.rod.reduction", "reduced already"),
            (&["bodies.rod.damping={modal=0.1}"], "bodies.rod.damping", "reduced already"),
            (&["bodies.rod.frame=buckens"], "bodies.rod.frame", "reduced already"),
            (&["bodies.rod.frame_marker=start"], "bodies.rod.frame_marker", "reduced already"),
            (
                &["bodies.rod.geometric_stiffening=false"],
                "bodies.rod.geometric_stiffening",
                "with a shape or a mesh only",
            ),
        ],
    );
}

#[test]
fn modes_of_imported_bodies_are_those_of_the_body_that_was_written() {
    let original = modes(&scenario_file::read(&pendulum_file(), &[]).unwrap(), None, 1).unwrap();
    let full = REDUCED.replace("reduced.h5", "full.h5");
    let full = valid(&full, &["bodies.rod.reduction={method=\"modal\",modes=19}"]);
    // The reduced file has the static answers to the hinge of the scenario that it comes from; here the rod flies.
    for (scenario, dofs, n) in [(valid(REDUCED, &[]), 0, 19 + 5), (full, original.bodies[0].n_dofs, 19)] {
        let found = &modes(&scenario, None, 1).unwrap().bodies[0];
        assert_eq!((found.n_dofs, found.n_elements), (dofs, 0));
        assert!((found.mass / original.bodies[0].mass - 1.0).abs() < 1e-12);
        assert_eq!(found.frequencies.len(), n);
        for (a, b) in found.frequencies.iter().zip(&original.bodies[0].frequencies) {
            // The same matrices: round-off of the eigenvalue solver.
            assert!((a / b - 1.0).abs() < 1e-9, "{a} {b}");
        }
    }
}

#[test]
fn points_of_a_reduced_file_are_for_output_only() {
    let BodyFile::Reduced(model) = read(&files().join("reduced.h5")).unwrap() else { panic!("reduced") };
    let mut parts = model.to_parts();
    parts.markers.retain(|m| m.name == "start");
    parts.points.retain(|(name, _)| name == "end");
    write_reduced(&files().join("points.h5"), &ReducedModel::new(parts).unwrap()).unwrap();
    let text = REDUCED.replace("reduced.h5", "points.h5");
    let spec = valid(&text, &["output.points.hub={body=\"rod\",marker=\"start\"}"]).run;
    assert_eq!(spec.points[0].place, Place::Marker("end".into()));
    let ball = |marker: &str| {
        format!(
            "joints.j={{type=\"spherical\",parent={{body=\"ground\",point=[0,0,0]}},\
             child={{body=\"rod\",marker=\"{marker}\"}}}}"
        )
    };
    valid(&text, &[&ball("start")]);
    assert_faults(&text, &[(&[&ball("end")], "joints.j.child.marker", "points.h5, known are \"start\"")]);
}

#[test]
fn bodies_of_one_kind_are_joined() {
    let other = |kind: &str| {
        format!(
            "bodies.ball={{model=\"rigid\",motion=\"{kind}\",mass=1.0,inertia=[1,1,1],markers={{m={{point=[0,0]}}}}}}"
        )
    };
    let joint = "joints.j={type=\"revolute\",axis=[0,0,1],parent={body=\"beam\",marker=\"tip\"},\
                 child={body=\"ball\",marker=\"m\"}}";
    valid(SWING, &[&other("planar"), joint]);
    let spatial = other("spatial").replace("[0,0]", "[0,0,0]");
    assert_faults(SWING, &[(&[&spatial, joint], "joints.j.parent.body", "only bodies of one kind")]);
}

#[test]
fn check_exits_with_3_and_results_name_the_elastic_coordinates() {
    let scenario = files().join("swing.toml");
    std::fs::write(&scenario, SWING).unwrap();
    let fbimpact = || Command::new(env!("CARGO_BIN_EXE_fbimpact"));
    fbimpact().arg("check").arg(&scenario).assert().success();
    let set = ["--set", "bodies.beam.file=none.h5"];
    let found = fbimpact().arg("check").arg(&scenario).args(set).assert().code(3);
    let text = String::from_utf8(found.get_output().stderr.clone()).unwrap();
    assert!(text.contains("bodies.beam.file") && text.contains("none.h5: cannot be read"), "{text}");

    let result = files().join("swing.h5");
    let short = ["--set", "simulation.end_time=0.01", "--force", "--output"];
    fbimpact().arg("run").arg(&scenario).args(short).arg(&result).assert().success();
    let found = fbimpact().arg("info").arg(&result).assert().success();
    let text = String::from_utf8(found.get_output().stdout.clone()).unwrap();
    // Eight modes, and the answers to the two forces of the hinge.
    assert!(text.contains("beam: 10 elastic coordinates"), "{text}");
    // Results do not take the place of the body.
    let over = ["--force", "--output"];
    let found = fbimpact().arg("run").arg(&scenario).args(over).arg(files().join("beam.h5")).assert().code(6);
    let text = String::from_utf8(found.get_output().stderr.clone()).unwrap();
    assert!(text.contains("is the file of body \"beam\""), "{text}");
    // An imported body cannot be exported again.
    let export = ["--body", "beam", "--output", "again.h5"];
    let found = fbimpact().arg("export-body").arg(&scenario).args(export).assert().failure();
    let text = String::from_utf8(found.get_output().stderr.clone()).unwrap();
    assert!(text.contains("from a file already"), "{text}");
}

/// Stored states.
fn run(scenario: &Scenario) -> Vec<Sample> {
    scenarios::run(scenario).samples
}

/// The flexible pendulum over 0.1 s in `frame`, with its rod, or with a rod from a file.
fn pendulum(frame: &str, file: Option<(&str, &[&str])>) -> Vec<Sample> {
    let mut text = std::fs::read_to_string(pendulum_file()).unwrap();
    let frame = format!("bodies.rod.frame={frame}");
    let mut set = vec!["simulation.end_time=0.1"];
    match file {
        None => set.push(&frame),
        Some((file, more)) => {
            let (head, tail) = text.split_once("model = \"solid\"").unwrap();
            let (_, tail) = tail.split_once("frame = \"tangent\"\n").unwrap();
            text = format!("{head}model = \"imported\"\nfile = \"{file}\"\n{tail}");
            set.extend(more);
        }
    }
    run(&valid(&text, &set))
}

/// Largest distance of the tips \[m\].
fn distance(a: &[Sample], b: &[Sample]) -> f64 {
    assert_eq!((a.len(), b.len()), (101, 101));
    let off = |(a, b): (&Sample, &Sample)| {
        let square = |c: usize| (a.points[0].position[c] - b.points[0].position[c]).powi(2);
        (0..3).map(square).sum::<f64>().sqrt()
    };
    let largest = a.iter().zip(b).map(off).fold(0.0, f64::max);
    // Half a metre per second squared times gravity's 3/2 at the tip: it has fallen by then.
    assert!(a[100].points[0].position[2] < -0.05);
    largest
}

#[test]
fn pendulum_with_a_reduced_rod_from_a_file_swings_as_the_original() {
    // The same data: round-off, seen through the step control.
    assert!(distance(&pendulum("tangent", None), &pendulum("", Some(("reduced.h5", &[])))) < 1e-9);
}

#[test]
fn pendulum_with_the_matrices_of_the_rod_from_a_file_swings_as_the_original() {
    let set = ["bodies.rod.reduction={method=\"modal\",modes=19}", "bodies.rod.frame=tangent"];
    // A bound from the project; modes of the doubly symmetric rod may come in other pairs.
    assert!(distance(&pendulum("tangent", None), &pendulum("", Some(("full.h5", &set)))) < 1e-6);
}

#[test]
fn beam_of_another_program_swings_and_keeps_its_energy() {
    let without = "bodies.beam.reduction={modes=8,static_answers=false}";
    for set in [&[][..], &[without], &["bodies.beam.frame=tangent"]] {
        let samples = run(&valid(SWING, set));
        let total = |s: &Sample| s.energies.total();
        let start = total(&samples[0]);
        let drift = samples.iter().map(|s| (total(s) - start).abs()).fold(0.0, f64::max);
        let fall = samples.iter().map(|s| s.energies.kinetic).fold(0.0, f64::max);
        assert!(drift <= 1e-6 * fall, "{drift:e} J of {fall} J");
        // It falls by less than the work of its weight over the way down, and turns about the hinge.
        assert!(fall > 1.0 && fall < 9.81 * LINE_MASS * LENGTH * 0.5 * LENGTH, "{fall}");
        let lowest = samples.iter().map(|s| s.points[0].position[1]).fold(0.0, f64::min);
        assert!(lowest < -0.5 * LENGTH, "{lowest}");
    }
}

#[test]
fn clamped_beam_of_another_program_sags_as_a_cantilever() {
    let set = [
        "joints.hinge.type=fixed",
        "simulation.static_start=true",
        "simulation.end_time=1e-4",
        "bodies.beam.reduction={method=\"all\"}",
        "bodies.beam.frame=tangent",
    ];
    let text = SWING.replace("axis = [0.0, 0.0, 1.0]\n", "");
    let samples = run(&valid(&text, &set));
    // Uniform load: w L⁴ / 8 EI; cubic elements are exact at their nodes.
    let sag = 9.81 * LINE_MASS * LENGTH.powi(4) / (8.0 * BENDING);
    for sample in &samples {
        let [x, y, _] = sample.points[0].position;
        // Conditioning of the matrices, 1e7 times round-off; linear bending does not shorten the beam.
        assert!((y / -sag - 1.0).abs() < 1e-8 && (x - LENGTH).abs() < 1e-8, "{x} {y} {sag}");
    }
}

#[test]
fn free_axisymmetric_body_takes_the_impulse_of_a_load() {
    const SOURCE: &str = r#"
        simulation = { end_time = 1.0 }
        materials.m = { youngs_modulus = 2e11, poissons_ratio = 0.3, density = 8e3 }
        [bodies.rod]
        model = "axisymmetric"
        material = "m"
        geometry = { shape = "rod", radius = 0.01, length = 0.2 }
        discretisation = { degree = 2, elements = [2, 8] }
    "#;
    const FLIGHT: &str = r#"
        simulation = { end_time = 1e-3 }
        [bodies.rod]
        model = "imported"
        file = "axial.h5"
        reduction = { method = "modal", modes = 4 }
        velocity = [0.0, 0.0, 0.5]
        [loads.push]
        body = "rod"
        marker = "end"
        force_z = 100.0
        [output.points.p]
        body = "rod"
        marker = "start"
    "#;
    let (source, file) = (files().join("axial.toml"), files().join("axial.h5"));
    std::fs::write(&source, SOURCE).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
    command.arg("export-body").arg(&source).args(["--full", "--body", "rod", "--output"]).arg(&file);
    command.assert().success();
    let samples = run(&valid(FLIGHT, &[]));
    let mass = 8e3 * std::f64::consts::PI * 0.01 * 0.01 * 0.2;
    let end = samples.last().unwrap();
    let expected = 0.5 * mass + 100.0 * 1e-3;
    // The constant force is integrated exactly up to the tolerance.
    assert!((end.linear_momentum[2] / expected - 1.0).abs() < 1e-8, "{:?} {expected}", end.linear_momentum);
    assert_faults(FLIGHT, &[(&["bodies.rod.velocity=[1,0,0]"], "bodies.rod.velocity", "along z")]);
}

/// A strip that turns, with the stiffening by its centrifugal force; its body and its places are left out.
fn turning_strip(folder: &Path, body: &str, hub: &str, tip: &str) -> Vec<Sample> {
    let text = format!(
        "[simulation]\nend_time = 0.1\n[bodies.b]\n{body}\n[joints.c]\ntype = \"revolute\"\naxis = [0, 0, 1]\n\
         parent = {{ body = \"ground\", point = [0, 0, 0] }}\nchild = {{ body = \"b\", {hub} }}\n\
         motion = {{ kind = \"spin-up\", rate = 60.0, duration = 0.1 }}\n\
         [loads.l]\nbody = \"b\"\n{tip}\nfollowing = true\nforce_y = 0.02\n"
    );
    std::fs::write(folder.join("strip.toml"), &text).unwrap();
    scenarios::run(&scenarios::valid(folder, &text, &[])).samples
}

#[test]
fn a_written_body_keeps_its_frame_and_its_stiffening() {
    let folder = scenarios::folder("written_frame");
    let strip = "material = \"aluminium\"\nmodel = \"plane-stress\"\nthickness = 0.02\n\
                 geometry = { shape = \"rectangle\", size = [0.4, 0.003] }\nreduction = { modes = 6 }\n\
                 frame = \"tangent\"\ngeometric_stiffening = true";
    let direct = turning_strip(&folder, strip, "face = \"x-\"", "face = \"x+\"");
    let mut command = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
    command.arg("export-body").arg(folder.join("strip.toml")).args(["--body", "b", "--output"]);
    command.arg(folder.join("strip.h5")).assert().success();
    let written = "model = \"imported\"\nfile = \"strip.h5\"";
    let again = turning_strip(&folder, written, "marker = \"x-\"", "marker = \"x+\"");
    assert_eq!(direct.len(), again.len());
    for (a, b) in direct.iter().zip(&again) {
        for (q, p) in a.bodies[0].elastic_coordinates.iter().zip(&b.bodies[0].elastic_coordinates) {
            // The same numbers: round-off of what the file keeps as it is. Without stiffening the tip goes twelve times as far.
            assert!((q - p).abs() <= 1e-12 * q.abs().max(1e-12), "{q} {p}");
        }
    }
}
