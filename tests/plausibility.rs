//! What no result may do, seen as a user sees it: overlaps at the start, energy from nothing, motion beyond all bounds; and what a
//! result says about itself.

use std::fmt::Write as _;
use std::path::Path;

use crate::support::fbimpact;

/// Radius of the spheres \[m\].
const RADIUS: f64 = 0.01;

/// A scenario with a steel sphere "a" at the height `z`, falling at `speed`, of the model `model`, and what else is given.
fn sphere_scenario(model: &str, z: f64, speed: f64, rest: &str) -> String {
    format!(
        "[simulation]\nend_time = 1e-6\n[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\ndensity = 7850.0\n\
         [bodies.a]\nmodel = \"{model}\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"sphere\", radius = {RADIUS} }}\n\
         position = [0.0, 0.0, {z:?}]\nvelocity = [0.0, 0.0, {:?}]\n{rest}",
        -speed
    )
}

const FLOOR: &str = "[bodies.b]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\nnormal = [0.0, 0.0, 1.0]\n\
                     [contacts.c]\ncontact_body = \"a\"\ntarget_body = \"b\"\n";

/// A second sphere of radius `radius` whose centre is at the height `z`.
fn second(model: &str, radius: f64, z: f64, law: &str) -> String {
    format!(
        "[bodies.b]\nmodel = \"{model}\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"sphere\", radius = {radius} }}\n\
         position = [0.0, 0.0, {z:?}]\n[contacts.c]\ncontact_body = \"a\"\ntarget_body = \"b\"\n{law}"
    )
}

/// Runs the scenario `text` in `folder` with the changes `set`: exit code, complaint, and `info --json` of the result if there is one.
fn run(folder: &Path, text: &str, set: &[&str]) -> (i32, String, Option<serde_json::Value>) {
    let (scenario, output) = (folder.join("s.toml"), folder.join("s.h5"));
    std::fs::write(&scenario, text).expect("written");
    let _ = std::fs::remove_file(&output);
    run_file(&scenario, &output, set)
}

fn run_file(scenario: &Path, output: &Path, set: &[&str]) -> (i32, String, Option<serde_json::Value>) {
    let (scenario, file) = (scenario.display().to_string(), output.display().to_string());
    let mut arguments = vec!["run", "--no-cache", &scenario, "-o", &file];
    arguments.extend(set.iter().flat_map(|s| ["--set", s]));
    let (code, _, complaint) = fbimpact(&arguments);
    let info = output.exists().then(|| {
        let (code, text, err) = fbimpact(&["info", "--json", &file]);
        assert_eq!(code, 0, "{err}");
        serde_json::from_str(&text).expect("JSON")
    });
    (code, complaint, info)
}

fn scratch() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary directory")
}

/// Identifiers of the warnings in `info`.
fn identifiers(info: &serde_json::Value) -> Vec<&str> {
    let warnings = info["warnings"].as_array().expect("a list");
    warnings.iter().map(|w| w["identifier"].as_str().expect("a text")).collect()
}

/// Components of the place in brackets after `before` in `text`.
fn vector_after(text: &str, before: &str) -> [f64; 3] {
    let (_, rest) = text.split_once(before).unwrap_or_else(|| panic!("no \"{before}\" in {text}"));
    let (inside, _) = rest.trim_start().trim_start_matches('[').split_once(']').expect("brackets");
    let mut list = inside.split(", ").map(|x| x.parse().expect("a number"));
    std::array::from_fn(|_| list.next().expect("three components"))
}

/// What a refusal says of the overlap, without the move: out of the inside of a body there are many.
fn overlap_told(complaint: &str) -> Option<&str> {
    complaint.split_once("overlap by").and_then(|(_, told)| told.split("; move").next())
}

#[test]
fn bodies_that_overlap_at_the_start_are_refused_with_the_move_that_cures_it() {
    let folder = scratch();
    let cases = [
        ("plane 1 mm", sphere_scenario("axisymmetric", RADIUS - 1e-3, 0.1, FLOOR), 1e-3),
        ("plane 1 um", sphere_scenario("axisymmetric", RADIUS - 1e-6, 0.0, FLOOR), 1e-6),
        (
            "spheres 1 mm",
            sphere_scenario("axisymmetric", RADIUS - 1e-3, 0.1, &second("axisymmetric", RADIUS, -RADIUS, "")),
            1e-3,
        ),
        (
            "spheres 1 um",
            sphere_scenario("axisymmetric", RADIUS - 1e-6, 0.1, &second("axisymmetric", RADIUS, -RADIUS, "")),
            1e-6,
        ),
        (
            "Hertz",
            sphere_scenario(
                "rigid",
                RADIUS - 1e-4,
                0.1,
                &second("rigid", RADIUS, -RADIUS, "model = \"hertz\"\n"),
            ),
            1e-4,
        ),
        (
            "one inside the other, touching it from within",
            sphere_scenario("axisymmetric", -RADIUS, 0.1, &second("axisymmetric", 2.0 * RADIUS, 0.0, "")),
            2.0 * RADIUS,
        ),
    ];
    for (name, text, depth) in cases {
        let (code, complaint, info) = run(folder.path(), &text, &[]);
        assert_eq!(code, 4, "{name}: {complaint}");
        assert!(info.is_none(), "{name}: nothing was simulated");
        assert!(
            complaint.contains("contact \"c\"") && complaint.contains("overlap by"),
            "{name}: {complaint}"
        );
        let (_, told) = complaint.split_once("overlap by ").expect("told");
        let told: f64 = told.split(' ').next().and_then(|x| x.parse().ok()).expect("a number");
        // Seven digits are shown.
        assert!((told / depth - 1.0).abs() < 1e-5, "{name}: {told} instead of {depth}");
        assert!(complaint.contains("contacts.c.initial_overlap"), "{name}: {complaint}");
        if name != "Hertz" {
            // Known without any model; from a static start the models themselves are looked at.
            let scenario = folder.path().join("s.toml").display().to_string();
            let (code, _, checked) = fbimpact(&["check", &scenario]);
            assert_eq!((code, overlap_told(&checked)), (4, overlap_told(&complaint)), "{name}");
            let (code, later, _) = run(folder.path(), &text, &["simulation.static_start=true"]);
            assert_eq!((code, overlap_told(&later)), (4, overlap_told(&complaint)), "{name}");
        }
        // With the move the run begins.
        let shift = vector_after(&complaint, "move body \"a\" by");
        let start: Vec<f64> = (0..3).map(|d| vector_after(&text, "position =")[d] + shift[d]).collect();
        let moved = format!("bodies.a.position={start:?}");
        let (_, complaint, _) = run(folder.path(), &text, &[&moved, "simulation.end_time=3e-5"]);
        assert!(!complaint.contains("overlap by"), "{name} moved by {shift:?}: {complaint}");
    }
}

#[test]
fn round_off_is_no_overlap_and_a_larger_one_can_be_allowed() {
    let folder = scratch();
    let touching = sphere_scenario("axisymmetric", RADIUS - 1e-12, 0.1, FLOOR);
    let end = "simulation.end_time=3e-5";
    let (code, complaint, _) = run(folder.path(), &touching, &[end]);
    assert_eq!(code, 0, "{complaint}");
    let deeper = sphere_scenario("axisymmetric", RADIUS - 1e-7, 0.1, FLOOR);
    let (code, complaint, _) = run(folder.path(), &deeper, &["contacts.c.initial_overlap=0.5e-7"]);
    assert_eq!(code, 4, "{complaint}");
    let (code, complaint, info) = run(folder.path(), &deeper, &["contacts.c.initial_overlap=2e-7", end]);
    assert_eq!(code, 0, "{complaint}");
    let info = info.expect("a result");
    assert!(identifiers(&info).contains(&"initial-overlap"), "{info:#}");
}

#[test]
fn bodies_on_the_wrong_side_are_told_which_one_it_is() {
    let folder = scratch();
    let behind = sphere_scenario("axisymmetric", -3.0 * RADIUS, 0.1, FLOOR);
    let hertz = format!("{FLOOR}model = \"hertz\"\n");
    let rigid = sphere_scenario("rigid", -3.0 * RADIUS, 0.1, &hertz);
    for text in [behind, rigid] {
        let (code, complaint, _) = run(folder.path(), &text, &[]);
        assert_eq!(code, 4, "{complaint}");
        assert!(complaint.contains("behind the plane") && complaint.contains("normal"), "{complaint}");
    }
    let concentric = sphere_scenario("rigid", 0.0, 0.1, &second("rigid", RADIUS, 0.0, "model = \"hertz\"\n"));
    let (code, complaint, _) = run(folder.path(), &concentric, &[]);
    assert_eq!(code, 4, "{complaint}");
    assert!(complaint.contains("centres") && complaint.contains("coincide"), "{complaint}");
}

#[test]
fn spheres_faster_than_waves_are_refused() {
    let folder = scratch();
    let other = second("rigid", RADIUS, -RADIUS, "model = \"hertz\"\n");
    let text = sphere_scenario("rigid", 2.0 * RADIUS, 1e6, &other);
    let (code, complaint, _) = run(folder.path(), &text, &["simulation.end_time=1e-4"]);
    assert_eq!(code, 5, "{complaint}");
    // Waves in a steel bar: sqrt(210e9/7850) = 5172 m/s.
    assert!(complaint.contains("contact \"c\"") && complaint.contains("beyond 5.172e3 m/s"), "{complaint}");
}

#[test]
fn a_beam_that_inertia_forces_soften_stops_by_name() {
    let folder = scratch();
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/spinning_beam.toml");
    let set = ["bodies.beam.geometric_stiffening=false"];
    let (code, complaint, info) = run_file(&scenario, &folder.path().join("s.h5"), &set);
    assert_eq!(code, 5, "{complaint}");
    assert!(complaint.contains("body \"beam\"") && complaint.contains("elastic displacement"), "{complaint}");
    assert!(complaint.contains("geometric_stiffening"), "{complaint}");
    let info = info.expect("what was simulated is kept");
    assert_eq!(info["status"], "failed");
    // The model diverges near 9 s; 20 s were asked for.
    let end = info["end"].as_f64().expect("a time");
    assert!((6.0..15.0).contains(&end), "{end}");
}

/// Two coaxial rods with flat ends, one of which hits the other; modes of the free bodies alone.
fn flat_rods(penalty: &str) -> String {
    let mut text = String::from(
        "[simulation]\nend_time = 1.5e-4\n[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.0\ndensity = 7850.0\n",
    );
    for (name, rest) in [("one", "position = [0.0, 0.0, -0.2]\nvelocity = [0.0, 0.0, 0.1]\n"), ("two", "")] {
        let marker = if name == "one" { "end" } else { "start" };
        let _ = write!(
            text,
            "[bodies.{name}]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\n\
             geometry = {{ shape = \"rod\", radius = 5e-3, length = 0.2 }}\n{rest}reduction = {{ modes = 40 }}\n\
             discretisation = {{ elements = [4, 100], refine = [{{ marker = \"{marker}\", width = 5e-3, elements = 8 }}] }}\n"
        );
    }
    text + "[contacts.c]\ncontact_body = \"one\"\ntarget_body = \"two\"\nmodel = \"coarse\"\n" + penalty
}

#[test]
fn energy_from_nothing_fails_the_run_and_keeps_what_was_simulated() {
    let folder = scratch();
    let text = flat_rods("penalty = { initial = 1e18 }\n");
    let (code, complaint, info) = run(folder.path(), &text, &[]);
    assert_eq!(code, 5, "{complaint}");
    assert!(complaint.contains("energy ledger is open"), "{complaint}");
    assert!(complaint.contains("simulation.energy_tolerance"), "{complaint}");
    let info = info.expect("what was simulated is kept");
    assert_eq!(info["status"], "failed");
    assert!(info["samples"].as_u64().is_some_and(|n| n > 1), "{info:#}");
    // The last state is the one that opened it.
    assert!(info["energy_drift"].as_f64().is_some_and(|d| d > 1e-3), "{info:#}");
}

/// A steel disc that spins and falls on a rigid plane with the coefficient of friction `friction`.
fn disc(friction: f64) -> String {
    format!(
        "[simulation]\nend_time = 5e-4\n[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\ndensity = 7850.0\n\
         [bodies.disc]\nmodel = \"plane-strain\"\nmaterial = \"steel\"\nthickness = 1.0\n\
         geometry = {{ shape = \"disc\", radius = 0.1 }}\nreduction = {{ modes = 10 }}\nposition = [0.0, 0.10001, 0.0]\n\
         velocity = [0.0, -0.1, 0.0]\nangular_velocity = [0.0, 0.0, 6.283185307179586]\n\
         discretisation = {{ degree = 3, elements = 8 }}\n[bodies.floor]\nmodel = \"rigid\"\n\
         geometry = {{ shape = \"plane\" }}\nnormal = [0.0, 1.0, 0.0]\n\
         [contacts.impact]\ncontact_body = \"disc\"\ntarget_body = \"floor\"\nfriction = {friction:?}\n\
         [output]\nfree_interval = 2e-6\n"
    )
}

#[test]
fn friction_that_the_solver_cannot_bear_fails_with_its_reason() {
    let folder = scratch();
    let (code, complaint, _) = run(folder.path(), &disc(30.0), &[]);
    assert_eq!(code, 5, "{complaint}");
    assert!(
        complaint.contains("energy ledger is open") && complaint.contains("coefficient of friction"),
        "{complaint}"
    );
}

/// A soft disc that spins and falls on a block that is softer still, with friction of 0.3.
const SOFT: &str = "[simulation]\nend_time = 0.0001733594526049251\n\
[materials.m1]\nyoungs_modulus = 24185198597.615078\npoissons_ratio = 0.44\ndensity = 3300.572908754612\n\
[materials.m2]\nyoungs_modulus = 1643942495.7717612\npoissons_ratio = 0.387\ndensity = 4053.209963431176\n\
[bodies.a]\nmodel = \"plane-stress\"\nmaterial = \"m1\"\nthickness = 1.0\nreduction = { modes = 6 }\n\
geometry = { shape = \"disc\", radius = 0.002472808179503362 }\nposition = [0.0, 0.002472808179503362, 0.0]\n\
velocity = [0.13329775500957303, -1.912107970857774, 0.0]\nangular_velocity = [0.0, 0.0, -577.6839828786113]\n\
[bodies.b]\nmodel = \"plane-stress\"\nmaterial = \"m2\"\nthickness = 1.0\nreduction = { modes = 6 }\n\
geometry = { shape = \"rectangle\", size = [0.011504050096130432, 0.006924206846290176] }\n\
position = [-0.0011401320979593187, -0.003462103423145088, 0.0]\n\
[contacts.c0]\ncontact_body = \"a\"\ntarget_body = \"b\"\nfriction = 0.3\n[output]\nfree_interval = 5.77864842016417e-07\n";

#[test]
fn friction_on_soft_bodies_leaves_the_ledger_closed() {
    let folder = scratch();
    for friction in ["0.3", "1.0"] {
        let (code, complaint, info) =
            run(folder.path(), SOFT, &[&format!("contacts.c0.friction={friction}")]);
        assert_eq!(code, 0, "{friction}: {complaint}");
        let drift = info.expect("a result")["energy_drift"].as_f64().expect("a number");
        // The power of sliding looks back over 3e-4 of the penetration and jumps where points begin to slide: a share of the
        // work of friction, a few per cent of the energy here.
        assert!(drift < 1e-4, "{friction}: {drift:e}");
    }
}

#[test]
fn a_result_says_what_it_leaves_out() {
    let folder = scratch();
    let scenario = "[simulation]\nend_time = 6e-4\n[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\ndensity = 7850.0\n\
         [bodies.rod]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\ngeometry = { shape = \"rod\", radius = 0.01, length = 1.0 }\n\
         position = [0.0, 0.0, 1e-6]\nvelocity = [0.0, 0.0, -0.1]\nreduction = { modes = 2 }\n\
         [bodies.ball]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\ngeometry = { shape = \"sphere\", radius = 0.01 }\n\
         position = [0.0, 0.0, -0.01]\n\
         [bodies.far]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\nnormal = [0.0, 0.0, 1.0]\nposition = [0.0, 0.0, -3.0]\n\
         [contacts.hit]\ncontact_body = \"ball\"\ntarget_body = \"rod\"\n\
         [contacts.never]\ncontact_body = \"ball\"\ntarget_body = \"far\"\n";
    let (code, complaint, info) = run(folder.path(), scenario, &["output.free_interval=1e-3"]);
    assert_eq!(code, 0, "{complaint}");
    let info = info.expect("a result");
    let found = identifiers(&info);
    for wanted in ["few-modes", "sparse-output", "never-closed"] {
        assert_eq!(found.iter().filter(|f| **f == wanted).count(), 1, "{wanted}: {info:#}");
    }
    let of = |kind: &str| {
        let list = info["warnings"].as_array().expect("a list");
        list.iter().find(|w| w["identifier"] == kind).cloned().unwrap_or_default()
    };
    assert_eq!(of("few-modes")["subject"], "body \"rod\"");
    assert!(of("few-modes")["remedy"].as_str().is_some_and(|r| r.contains("bodies.rod.reduction.modes")));
    assert_eq!(of("never-closed")["subject"], "contact \"never\"");
    assert!(of("sparse-output")["remedy"].as_str().is_some_and(|r| r.contains("output.free_interval")));
    // In the log, in the text of `info` and in the table of runs as well.
    let file = folder.path().join("s.h5").display().to_string();
    let (_, text, _) = fbimpact(&["info", &file]);
    assert!(text.contains("few-modes: body \"rod\": "), "{text}");
    assert!(complaint.contains("never-closed: contact \"never\": "), "{complaint}");
    let table = folder.path().join("runs.csv").display().to_string();
    let (code, _, err) = fbimpact(&["collect", &file, "-o", &table]);
    assert_eq!(code, 0, "{err}");
    let table = std::fs::read_to_string(table).expect("readable");
    assert!(table.contains("warnings") && table.contains("never-closed"), "{table}");

    // Left to the program, the interval shows what rings: the modes of the rod up to 5.2 kHz, its second.
    let (code, complaint, info) = run(folder.path(), scenario, &[]);
    assert_eq!(code, 0, "{complaint}");
    assert!(!identifiers(&info.expect("a result")).contains(&"sparse-output"));
    let file = result_files::file::hdf5_integrity::open(&folder.path().join("s.h5")).expect("an HDF5 file");
    let times = file.dataset("time").and_then(|d| d.read_1d::<f64>()).expect("numbers");
    let phases = file.dataset("phase").and_then(|d| d.read_1d::<u32>()).expect("numbers");
    // Free, impact, free.
    let after: Vec<f64> = times.iter().zip(&phases).filter(|(_, p)| **p == 2).map(|(t, _)| *t).collect();
    let longest = after.windows(2).map(|t| t[1] - t[0]).fold(0.0, f64::max);
    assert!(after.len() > 5 && longest < 0.5 / 5.2e3, "{longest:e}: {after:?}");
}

#[test]
fn a_place_that_its_elements_do_not_resolve_is_told() {
    let folder = scratch();
    let text = |coupling: &str, radius: f64, elements: &str, load: &str| {
        format!(
            "[simulation]\nend_time = 1e-6\n[materials.steel]\nyoungs_modulus = 210e9\npoissons_ratio = 0.3\ndensity = 7850.0\n\
             [bodies.plate]\nmodel = \"plane-stress\"\nthickness = 0.01\nmaterial = \"steel\"\n\
             geometry = {{ shape = \"rectangle\", size = [0.04, 0.02] }}\ndiscretisation = {{ degree = 2, elements = {elements} }}\n\
             [bodies.plate.markers]\npin = {{ point = [0.0, 0.0], radius = {radius:e}, coupling = \"{coupling}\" }}\n\
             [loads.push]\nbody = \"plate\"\nmarker = \"pin\"\n{load} = 1.0\n"
        )
    };
    // Elements over the radius: a half, 1.2, 2.5, 5, 20. On average forces want one, moments 2.24, rigid places 12 under forces.
    let cases = [
        ("average", 2e-3, "[10, 5]", "force_x", true),
        ("average", 2e-3, "[24, 12]", "force_x", false),
        ("average", 2e-3, "[24, 12]", "moment_z", true),
        ("average", 2e-3, "[50, 25]", "moment_z", false),
        ("rigid", 4e-3, "[50, 25]", "force_x", true),
        ("rigid", 8e-3, "[100, 50]", "force_x", false),
    ];
    for (coupling, radius, elements, load, is_told) in cases {
        let (code, complaint, info) = run(folder.path(), &text(coupling, radius, elements, load), &[]);
        assert_eq!(code, 0, "{complaint}");
        let info = info.expect("a result");
        assert_eq!(
            identifiers(&info).contains(&"coarse-place"),
            is_told,
            "{coupling} {elements} {load}: {info:#}"
        );
        assert_eq!(complaint.contains("coarse-place: body \"plate\": "), is_told, "{complaint}");
    }
    // A mesh that the program chooses has what the place needs.
    let text = text("average", 2e-3, "[10, 5]", "moment_z");
    let chosen = text.replace("discretisation = { degree = 2, elements = [10, 5] }\n", "");
    assert_ne!(text, chosen);
    let (code, complaint, info) = run(folder.path(), &chosen, &[]);
    assert_eq!((code, identifiers(&info.expect("a result"))), (0, vec![]), "{complaint}");
}

#[test]
fn every_model_finds_a_penalty_factor_of_its_own() {
    let folder = scratch();
    let text = "[simulation]\nend_time = 2e-5\n[materials.rubber]\nyoungs_modulus = 900.0\npoissons_ratio = 0.4\ndensity = 1100.0\n\
         [bodies.a]\nmodel = \"axisymmetric\"\nmaterial = \"rubber\"\ngeometry = { shape = \"sphere\", radius = 0.01 }\n\
         position = [0.0, 0.0, 0.01]\nvelocity = [0.0, 0.0, -1e-3]\nreduction = { modes = 10 }\n\
         discretisation = { elements = 6, refine = [{ point = [0.0, -0.01], width = 2e-3, elements = 6 }] }\n\
         [bodies.b]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\nnormal = [0.0, 0.0, 1.0]\n\
         [contacts.c]\ncontact_body = \"a\"\ntarget_body = \"b\"\n";
    for model in ["adaptive", "quasistatic", "damped", "dynamic", "coarse"] {
        let (code, complaint, info) = run(folder.path(), text, &[&format!("contacts.c.model=\"{model}\"")]);
        assert_eq!(code, 0, "{model}: {complaint}");
        let info = info.expect("a result");
        let penalty = info["tries"][0]["penalty_end"].as_f64().expect("a number");
        // A modulus of 1e3 Pa over lengths of 0.01 to 2 mm, with the ratio of 40: 1e7 to 1e11, where steel has 1e15 to 1e18.
        assert!((1e6..1e12).contains(&penalty), "{model}: {penalty:e}");
    }
}
