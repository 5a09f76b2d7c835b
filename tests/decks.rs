//! Decks with several parts in scenarios: which one is the body, names of any characters, files that are included; what `check` says of a
//! mesh that a joint moves and holds.

use std::path::Path;
use std::process::Command;

use crate::blocks::block;
use crate::support::scenarios;
use crate::writers::inp;
use fbimpact::scenario::Scenario;
use fbimpact::simulate::modes;
use fe_mesh::ElementKind;

const PARTS: &str = r#"
[simulation]
end_time = 1e-3
[materials.light]
youngs_modulus = 1e11
poissons_ratio = 0.3
density = 1000.0
[bodies.rod]
model = "mesh"
file = "parts.inp"
units = "mm"
part = "Rod-2"
material = "light"
reduction = { modes = 1 }
"#;

/// A deck of a rod of 30 × 10 × 10 mm, which is there twice, and a block, whose elements stand in a file of their own.
fn write(folder: &Path) {
    let rod = inp(&block(ElementKind::Hex8, [3, 1, 1], |[x, y, z]| [30.0 * x, 10.0 * y, 10.0 * z]));
    let cube = inp(&block(ElementKind::Hex8, [1, 1, 1], |x| x.map(|c| 10.0 * c)));
    std::fs::write(folder.join("cube.inc"), cube).unwrap();
    let deck = format!(
        "*PART, NAME=Rod\n{rod}*ELSET, ELSET=\"Stahl, ä/2\"\n1\n*END PART\n*PART, NAME=Cube\n*INCLUDE, INPUT=cube.inc\n*END PART\n*ASSEMBLY, NAME=A\n\
         *INSTANCE, NAME=Rod-1, PART=Rod\n*END INSTANCE\n*INSTANCE, NAME=Rod-2, PART=Rod\n0., 0., 50.\n*END INSTANCE\n*INSTANCE, NAME=Cube-1, PART=Cube\n\
         *END INSTANCE\n*END ASSEMBLY\n"
    );
    std::fs::write(folder.join("parts.inp"), deck).unwrap();
}

fn mass(scenario: &Scenario) -> f64 {
    modes(scenario, None, 1).unwrap().bodies[0].mass
}

#[test]
fn a_part_of_a_deck_is_a_body_whose_groups_have_any_names() {
    let folder = scenarios::folder("decks");
    write(&folder);
    let valid = |set: &[&str]| scenarios::valid(&folder, PARTS, set);
    // 3 cm³ of 1 g/cm³; the cube 1 cm³.
    assert!((mass(&valid(&[])) / 3e-3 - 1.0).abs() < 1e-12);
    assert!((mass(&valid(&["bodies.rod.part=Cube"])) / 1e-3 - 1.0).abs() < 1e-12);
    for (set, words) in [
        (
            "bodies.rod.part=Rod",
            &["bodies.rod.file", "no part \"Rod\"", "\"Rod-1\", \"Rod-2\", \"Cube-1\""][..],
        ),
        ("bodies.rod.part=\"\"", &["bodies.rod.part", "must be a string"]),
    ] {
        let faults = scenarios::parse(&folder, PARTS, &[set]).unwrap_err();
        let text: String = faults.iter().map(|f| format!("{f}\n")).collect();
        assert!(words.iter().all(|w| text.contains(w)), "{set}: {text}");
    }
    // A third of the rod of another material, by a name that no path of a result could have.
    let named = format!("{PARTS}[bodies.rod.groups.\"Stahl, ä/2\"]\nmaterial = \"steel\"\n");
    let scenario = scenarios::valid(&folder, &named, &[]);
    let expected = (2.0 * 1000.0 + 7850.0) * 1e-6;
    assert!((mass(&scenario) / expected - 1.0).abs() < 1e-12, "{}", mass(&scenario));
    // As a result keeps it, it reads back to the same; what is included counts for the contents of the file.
    let resolved = scenario.source.resolved.clone();
    assert!(
        resolved.contains("[bodies.rod.groups.\"Stahl, ä/2\"]") && resolved.contains("part = \"Rod-2\""),
        "{resolved}"
    );
    assert_eq!(scenarios::valid(&folder, &resolved, &[]).source.resolved, resolved);
    let cube = std::fs::read_to_string(folder.join("cube.inc")).unwrap();
    std::fs::write(folder.join("cube.inc"), cube + "** another remark\n").unwrap();
    let faults = scenarios::parse(&folder, &resolved, &[]).unwrap_err();
    assert!(faults[0].to_string().contains("has changed"), "{}", faults[0]);
}

#[test]
fn check_tells_where_a_mesh_is_moved_and_held_and_refuses_a_touch_behind_it() {
    let folder = scenarios::folder("decks_checked");
    write(&folder);
    let check = |speed: f64, coupling: &str| {
        let text = format!(
            "{PARTS}[bodies.ball]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = {{ shape = \"sphere\", radius = \"5 mm\" }}\n\
             position = [15e-3, 0.0, 11e-3]\nvelocity = [0.0, 0.0, {speed}]\n[joints.fit]\ntype = \"fixed\"\n\
             parent = {{ body = \"ground\", point = [0.0, 0.0, 0.0] }}\nchild = {{ body = \"rod\", face = \"x-\"{coupling} }}\n\
             [contacts.blow]\ncontact_body = \"rod\"\ntarget_body = \"ball\"\n"
        );
        std::fs::write(folder.join("case.toml"), text).unwrap();
        let mut program = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
        let output = program.current_dir(&folder).args(["check", "case.toml"]).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, told) = check(-1.0, "");
    // The middle of the face, (0, 5, 55) mm in the assembly, is brought to the origin.
    let words = [
        "valid",
        "moves body \"rod\": the origin of its file is at (0, -0.005, -0.055) m",
        "by the mean motion",
        "coupling = \"rigid\"",
    ];
    assert!(code == Some(0) && words.iter().all(|w| told.contains(w)), "{told}");
    let (code, told) = check(-1.0, ", coupling = \"rigid\"");
    assert!(code == Some(0) && !told.contains("by the mean motion"), "{told}");
    let (code, told) = check(1.0, "");
    let words = ["refused", "contact \"blow\": its bodies never meet", "0.001 m apart", "at 1 m/s"];
    assert!(code == Some(4) && words.iter().all(|w| told.contains(w)), "{told}");
}

/// A bar of 60 × 10 × 10 mm as one mesh, and as two blocks whose ends are tied, the second moved in place as an instance.
fn write_tied(folder: &Path) {
    let of = |n: usize, length: f64| {
        inp(&block(ElementKind::Hex20, [n, 2, 2], |[x, y, z]| [length * x, 10.0 * y, 10.0 * z]))
    };
    std::fs::write(folder.join("one.inp"), of(12, 60.0)).unwrap();
    let half = of(6, 30.0);
    let deck = format!(
        "*PART, NAME=Left half\n{half}*SURFACE, NAME=End, TYPE=NODE\nx+,\n*END PART\n*PART, NAME=Right\n{half}*END PART\n*ASSEMBLY, NAME=A\n\
         *INSTANCE, NAME=\"Left half-1\", PART=Left half\n*END INSTANCE\n*INSTANCE, NAME=Right-1, PART=Right\n30., 0., 0.\n*END INSTANCE\n\
         *NODE\n900, 0., 0., 50.\n*NSET, NSET=Begin, INSTANCE=Right-1\nx-\n*SURFACE, NAME=Begin, TYPE=NODE\nBegin,\n\
         *NSET, NSET=Foot, INSTANCE=\"Left half-1\"\nx-\n*SURFACE, NAME=Foot, TYPE=NODE\nFoot,\n\
         *TIE, NAME=Glue, POSITION TOLERANCE=0.1\nBegin, \"Left half-1.End\"\n\
         *COUPLING, CONSTRAINT NAME=Hold, REF NODE=900, SURFACE=Foot\n*DISTRIBUTING\n*END ASSEMBLY\n"
    );
    std::fs::write(folder.join("tied.inp"), deck).unwrap();
}

#[test]
fn what_a_deck_ties_is_joined_in_the_scenario_that_is_written() {
    let folder = scenarios::folder("decks_tied");
    write_tied(&folder);
    let run = |arguments: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_fbimpact"));
        let output = program.current_dir(&folder).args(arguments).output().unwrap();
        let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {err}");
        (out, err)
    };
    let frequencies = |name: &str, set: &[&str]| -> Vec<f64> {
        let file = format!("{name}.toml");
        let (out, _) = run(&[&["modes", &file, "--system", "--json"], set].concat());
        let found: serde_json::Value = serde_json::from_str(&out).unwrap();
        let all = found["frequencies"].as_array().unwrap().iter().map(|f| f.as_f64().unwrap());
        all.filter(|f| *f > 1.0).take(4).collect()
    };
    run(&["new", "one", "--mesh", "one.inp", "--units", "mm", "--force"]);
    let (out, _) = run(&["new", "tied", "--mesh", "tied.inp", "--units", "mm", "--force"]);
    for words in [
        "body            left-half-1",
        "body            right-1",
        "\"Begin\" to \"Left half-1.End\"",
        "a support of body",
    ] {
        assert!(out.contains(words), "{words}: {out}");
    }
    let text = std::fs::read_to_string(folder.join("tied.toml")).unwrap();
    for words in
        ["[bodies.left-half-1]", "# *TIE \"Glue\" (line ", "[joints.tie-1]", "#[joints.hold-1]", "node 900"]
    {
        assert!(text.contains(words), "{words}: {text}");
    }
    let (_, told) = run(&["check", "tied.toml"]);
    // The second is moved with the first alone, by the gap to the floor; what is tied is named.
    let moved = "joint \"tie-1\" moves body \"right-1\": the origin of its file is at (0, 0, 0.00000";
    assert!(told.contains(moved) && told.contains("what the file ties is for joints"), "{told}");
    let modes = |coupling: &str| {
        let text = text.replace("0.005] }", &format!("0.005], coupling = {coupling:?} }}"));
        std::fs::write(folder.join("coupled.toml"), text).unwrap();
        frequencies(
            "coupled",
            &["--set", "bodies.left-half-1.reduction.modes=30", "--set", "bodies.right-1.reduction.modes=30"],
        )
    };
    let one = frequencies("one", &["--set", "bodies.part.reduction.modes=30"]);
    let [rigid, average] = ["rigid", "average"].map(modes);
    println!("one mesh {one:?}\nrigid {rigid:?}\naverage {average:?}");
    // Two of bending, torsion, bending. Faces that are held by their means bend as those of one mesh, but warp apart in torsion; rigid
    // ones do not warp at all.
    for (i, within) in [1e-4, 1e-4, 6e-3, 2e-3].into_iter().enumerate() {
        assert!((average[i] / one[i] - 1.0).abs() < within, "{i}: {average:?} {one:?}");
        assert!(rigid[i] > one[i] && rigid[i] < 1.02 * one[i], "{i}: {rigid:?} {one:?}");
    }
}
