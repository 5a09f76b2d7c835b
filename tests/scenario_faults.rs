//! Every key of the scenario, one by one: a wrong type, an impossible value and an unknown name are located faults, and
//! so is a missing key. Property tests mutate valid scenarios: nothing panics, every fault has a line.

use std::path::Path;

use fbimpact::scenario::keys::{Bound, Key, Kind, Need, Range};
use fbimpact::scenario::{self, Fault, Override, Scenario, tables};
use proptest::prelude::*;

const SPHERE: &str = include_str!("../scenarios/sphere_on_plane.toml");
const ROD: &str = include_str!("../scenarios/rod_on_plane.toml");
const PENDULUMS: &str = include_str!("../scenarios/rigid_double_pendulums.toml");
const PAIRS: &str = include_str!("../scenarios/sphere_rod_sphere.toml");
const BEAM: &str = include_str!("../scenarios/spinning_beam.toml");
/// What the property tests mutate.
const TEXTS: [&str; 6] = [SPHERE, ROD, PENDULUMS, PAIRS, BEAM, ALL_SHAPES];

/// A scenario in which every shape, every form of a quantity over time and every kind of request stands once.
const ALL_SHAPES: &str = r#"
[simulation]
end_time = 1.0
[materials.m]
youngs_modulus = 1e11
poissons_ratio = 0.3
density = 1e3
[bodies]
sphere = { material = "m", geometry = { shape = "sphere", radius = 1.0, net = "cube" } }
ellipsoid = { material = "m", geometry = { shape = "ellipsoid", semi_axes = [1.0, 2.0, 3.0] } }
rod = { model = "axisymmetric", material = "m", geometry = { shape = "rod", radius = 1.0, length = 2.0 }, discretisation = { refine = [{ marker = "start", width = 0.1 }] }, markers = { extra = { point = [0.5, 1.0] } } }
rod-spherical-end = { model = "axisymmetric", material = "m", geometry = { shape = "rod-spherical-end", radius = 1.0, length = 2.0 } }
cylinder = { material = "m", geometry = { shape = "cylinder", radius = 1.0, length = 2.0 } }
hollow-cylinder = { material = "m", geometry = { shape = "hollow-cylinder", inner_radius = 1.0, outer_radius = 2.0, length = 2.0 } }
tube-sector = { material = "m", geometry = { shape = "tube-sector", inner_radius = 1.0, outer_radius = 2.0, length = 2.0, angle = 1.0 } }
cone = { material = "m", geometry = { shape = "cone", radius = 1.0, end_radius = 0.5, length = 2.0 } }
capsule = { material = "m", geometry = { shape = "capsule", radius = 1.0, length = 3.0 } }
rounded-cylinder = { model = "axisymmetric", material = "m", geometry = { shape = "rounded-cylinder", radius = 1.0, length = 2.0, crown_radius = 3.0, fillet_radius = 0.1 } }
torus = { material = "m", geometry = { shape = "torus", radius = 1.0, tube_radius = 0.2 } }
rounded-box = { material = "m", geometry = { shape = "rounded-box", size = [1.0, 2.0, 3.0], fillet_radius = 0.2 } }
plate-with-hole = { material = "m", geometry = { shape = "plate-with-hole", size = [1.0, 2.0], hole_radius = 0.2, thickness = 0.1 } }
l-beam = { material = "m", geometry = { shape = "l-beam", width = 1.0, height = 2.0, thickness = 0.1, length = 3.0 } }
t-beam = { material = "m", geometry = { shape = "t-beam", width = 1.0, height = 2.0, flange_thickness = 0.1, web_thickness = 0.2, length = 3.0 } }
gear-tooth = { material = "m", geometry = { shape = "gear-tooth", module = 1.0, teeth = 20, inner_radius = 7.0, width = 1.0 } }
box = { material = "m", geometry = { shape = "box", size = [1.0, 2.0, 3.0] } }
rectangle = { model = "plane-stress", thickness = 0.1, material = "m", geometry = { shape = "rectangle", size = [1.0, 2.0] } }
disc = { model = "plane-strain", material = "m", geometry = { shape = "disc", radius = 1.0 } }
nurbs = { model = "plane-strain", material = "m", geometry = { shape = "nurbs", degrees = [1, 1], knots = [[0, 0, 1, 1], [0, 0, 1, 1]], control_points = [[0, 0], [1, 0], [0, 1], [1, 1]], weights = [1, 1, 1, 1] } }
several = { model = "plane-strain", material = "m", geometry = { shape = "nurbs", patches = [{ degrees = 1, knots = [[0, 0, 1, 1], [0, 0, 1, 1]], control_points = [[0, 0], [1, 0], [0, 1], [1, 1]], weights = [1, 1, 1, 1] }, { degrees = 1, knots = [[0, 0, 3, 3], [0, 0, 1, 1]], control_points = [[1, 0], [2, 0], [1, 1], [2, 1]] }], faces = { ends = ["0:xi-", "1:xi+"] } } }
plane = { model = "rigid", geometry = { shape = "plane" } }
row = { model = "rigid", mass = 1.0, inertia = [1.0, 1.0, 1.0], copies = { arrangement = "row", count = 2, step = [1.0, 0.0, 0.0] } }
grid = { model = "rigid", mass = 1.0, inertia = [1.0, 1.0, 1.0], copies = { arrangement = "grid", counts = [2, 1], spacing = [1.0, 0.0, 0.0] } }
circle = { model = "rigid", mass = 1.0, inertia = [1.0, 1.0, 1.0], copies = { arrangement = "ring", count = 2 } }
random = { model = "rigid", mass = 1.0, inertia = [1.0, 1.0, 1.0], copies = { arrangement = "random", count = 2, from = [0.0, 0.0, 0.0], to = [1.0, 1.0, 1.0], distance = 0.1 } }
arm = { model = "rigid", mass = 1.0, centre_of_mass = [0.0, 0.1, 0.0], inertia = [1.0, 1.0, 1.0], orientation_deg = [0, 90, 0] }
wheel = { model = "rigid", motion = "planar", thickness = 0.1, material = "m", geometry = { shape = "disc", radius = 1.0 } }
piston = { model = "rigid", motion = "axial", mass = 1.0 }
leg = { material = "m", geometry = { shape = "cylinder", radius = 0.1, length = 2.0 }, frame = "tangent", geometric_stiffening = true, damping = { modal = [0.1, 0.2] }, reduction = { static_answers = false } }
[joints.j]
type = "cylindrical"
axis = [0.0, 1.0, 1.0]
reference = [1.0, 0.0, 0.0]
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "arm", point = [0.0, 0.0, 0.0] }
stiffness = [1.0, 2.0]
drives = [{ coordinate = 0, curve = { kind = "harmonic", amplitude = 1.0, frequency = 2.0 } }]
motions = [{ coordinate = 1, curve = 0.5 }]
friction = [1.0, 1.0]
stops = [{ coordinate = 0, upper = 1.0, stiffness = 1.0 }]
[joints.knee]
type = "universal"
axis = [1.0, 0.0, 0.0]
second_axis = [0.0, 1.0, 0.0]
parent = { body = "arm", point = [0.0, 1.0, 0.0] }
child = { body = "leg", marker = "start" }
coordinates = [0.1, 0.2]
[joints.loop]
type = "spherical"
parent = { body = "arm", point = [0.0, 2.0, 0.0] }
child = { body = "leg", marker = "end" }
closes_loop = true
[gears.g]
first = "knee"
first_coordinate = 0
second = "j"
second_coordinate = 1
ratio = 2.0
[loads]
l = { body = "arm", point = [0.0, 0.0, 0.0], force_x = 1.0, following = true }
constant = { body = "leg", marker = "end", force_z = { kind = "constant", value = 1.0 } }
polynomial = { body = "leg", marker = "end", force_z = { kind = "polynomial", coefficients = [1.0, 2.0] } }
harmonic = { body = "leg", marker = "end", force_z = { kind = "harmonic", amplitude = 1.0, frequency = 2.0, phase_deg = 30.0, offset = 1.0 } }
spin-up = { body = "leg", marker = "end", force_z = { kind = "spin-up", rate = 1.0, duration = 2.0 } }
table = { body = "leg", marker = "end", force_z = { kind = "table", times = [0.0, 1.0], values = [0.0, 2.0] } }
[contacts.c]
contact_body = "rod"
target_body = "plane"
[contacts.pair]
contact_body = "rod-spherical-end"
target_body = "rod"
penalty = { initial = 1e16, search = "until-converged", tolerance = 1e-3 }
interval = { width = 0.01, elements = 16, target_utilisation = 0.8, division = "printed" }
[output.points.p]
body = "rod"
marker = "end"
[output.stress.s]
body = "rod"
from = "start"
to = [0.0, 1.0]
"#;

fn parse(text: &[u8], set: &[String]) -> Result<Scenario, Vec<Fault>> {
    let overrides: Vec<Override> = set.iter().map(|s| s.parse().expect("valid --set")).collect();
    scenario::parse(Path::new("case.toml"), text, &overrides).map_err(|f| f.list().to_vec())
}

/// Calls `action` with the dotted path of every key, for names that `ALL_SHAPES` has.
fn each_key(keys: &'static [Key], path: &str, action: &mut dyn FnMut(&'static Key, &str)) {
    let join = |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    for key in keys {
        // A body has one patch or several.
        let name = join(key.name).replace("nurbs.geometry.patches", "several.geometry.patches");
        action(key, &name);
        match &key.kind {
            Kind::Table(keys) => each_key(keys, &name, action),
            Kind::Tables(keys) => each_key(keys, &format!("{name}[0]"), action),
            Kind::Named(keys) | Kind::NamedByFile(keys) => {
                let entry = match name.as_str() {
                    "materials" => "m",
                    "bodies" => "rod",
                    "contacts" => "c",
                    "joints" => "j",
                    "loads" => "l",
                    "gears" => "g",
                    name if name.ends_with(".markers") => "extra",
                    "output.points" => "p",
                    _ => "s",
                };
                each_key(keys, &format!("{name}.{entry}"), action);
            }
            Kind::Variants { variants, .. } => {
                for v in *variants {
                    // Not to be taken for a shape.
                    let body = if v.choice.name == "ring" { "circle" } else { v.choice.name };
                    each_key(v.keys, &format!("bodies.{body}.{}", key.name), action);
                }
            }
            Kind::NumberOrVariants { variants, .. } if name == "loads.l.force_z" => {
                for v in *variants {
                    each_key(v.keys, &format!("loads.{}.force_z", v.choice.name), action);
                }
            }
            _ => {}
        }
    }
}

fn outside(range: &Range) -> Vec<String> {
    let beyond = |b: Bound, sign: f64| match b {
        Bound::Open(x) => format!("{x:?}"),
        Bound::Closed(x) => format!("{:?}", x + sign * x.abs().max(1.0)),
    };
    let bad = ["nan", "inf", "-inf", "1e999"].map(str::to_owned);
    bad.into_iter().chain([beyond(range.min, -1.0), beyond(range.max, 1.0)]).collect()
}

/// Values of a wrong type and impossible ones for a key.
fn bad_values(kind: &Kind) -> Vec<String> {
    let lists = |range: &Range, n: usize| -> Vec<String> {
        outside(range).iter().map(|x| format!("[{}]", vec![x.as_str(); n].join(","))).collect()
    };
    let mut values: Vec<String> = vec!["1979-05-27".into()];
    if !matches!(kind, Kind::Boolean) {
        values.push("true".into());
    }
    values.extend(match kind {
        Kind::Text => vec!["1".into(), "[]".into(), "{}".into()],
        Kind::Name => vec!["\"\"".into(), "\" \"".into(), "3".into(), "[1]".into()],
        Kind::Number(range) => [outside(range), vec!["\"1\"".into(), "[1]".into(), "{}".into()]].concat(),
        Kind::Boolean => vec!["1".into(), "\"true\"".into(), "[]".into(), "[true]".into()],
        Kind::Numbers(range) => {
            [outside(range), lists(range, 1), lists(range, 3), vec!["[]".into(), "\"1\"".into(), "{}".into()]]
                .concat()
        }
        Kind::Symmetric(range) => {
            let rows =
                ["1", "[]", "[1,2]", "[[1,2],[3,4],[5,6]]", "[[1,0,0],[0,1,0],[0,0,nan]]", "[1,2,[3]]"];
            [lists(range, 3), rows.map(str::to_owned).to_vec()].concat()
        }
        Kind::NumberOrVariants { range, .. } => {
            let forms = ["\"1\"", "[1]", "{}", "{ kind = 1 }", "{ kind = \"no\" }"];
            [outside(range), forms.map(str::to_owned).to_vec()].concat()
        }
        Kind::Integer(min, max) => {
            vec![
                format!("{}", *min as i64 - 1),
                format!("{}", max + 1),
                "1.5".into(),
                "-1".into(),
                "\"1\"".into(),
            ]
        }
        Kind::Counts(min, max) => vec![
            format!("{}", *min as i64 - 1),
            format!("{}", max + 1),
            "[]".into(),
            "[1]".into(),
            "[1,2,3,4]".into(),
            "[0,0,0]".into(),
            "[1.5,2.0]".into(),
            "\"two\"".into(),
        ],
        Kind::Choice(_) => {
            vec!["\"no-such-choice\"".into(), "1".into(), "[]".into()]
        }
        Kind::Vector(n, range) => [lists(range, *n), vec!["1".into(), "[]".into(), "[1]".into()]].concat(),
        Kind::Rotation => {
            vec!["[1]".into(), "[nan,0,0]".into(), "[2,0,0,0]".into(), "[0,0,0,0]".into(), "1".into()]
        }
        Kind::Point(range) => [lists(range, 2), lists(range, 3), vec!["[1]".into(), "1".into()]].concat(),
        Kind::List(range) => [lists(range, 4), vec!["1".into(), "[\"a\"]".into(), "[1]".into()]].concat(),
        Kind::Lists(_) => {
            vec!["1".into(), "[1]".into(), "[[nan],[nan]]".into(), "[[0.5]]".into(), "[[\"a\"]]".into()]
        }
        Kind::Points(_) => vec!["1".into(), "[[1]]".into(), "[[nan,0]]".into(), "[[0,0]]".into()],
        Kind::Place(_) => vec!["\"no-such-marker\"".into(), "[1]".into(), "[nan,0]".into(), "1".into()],
        Kind::ChoiceOrNumber(_, range) => [outside(range), vec!["\"never\"".into(), "[]".into()]].concat(),
        Kind::Table(_) | Kind::Variants { .. } => vec!["1".into(), "[]".into(), "\"a\"".into()],
        Kind::Named(_) => vec!["1".into(), "[]".into(), "{ a = 1 }".into(), "{ \"a/b\" = {} }".into()],
        Kind::NamedByFile(_) => vec!["1".into(), "[]".into(), "{ a = 1 }".into(), "{ \"\" = {} }".into()],
        Kind::Tables(_) => vec!["1".into(), "{}".into(), "[1]".into()],
        Kind::Choices(_) => {
            ["1", "\"x\"", "[]", "[1]", "[\"never\"]", "[\"x\", \"x\"]"].map(str::to_owned).to_vec()
        }
        Kind::NameLists => [
            "1",
            "[]",
            "{ a = 1 }",
            "{ a = [] }",
            "{ a = [1] }",
            "{ a = [\"no-such-face\"] }",
            "{ \"a/b\" = [\"xi-\"] }",
        ]
        .map(str::to_owned)
        .to_vec(),
    });
    values
}

#[test]
fn scenario_with_every_shape_is_valid() {
    let scenario = parse(ALL_SHAPES.as_bytes(), &[]).unwrap_or_else(|f| panic!("{f:#?}"));
    assert_eq!(scenario.bodies.len(), 34);
    let again = parse(scenario.source.resolved.as_bytes(), &[]).unwrap_or_else(|f| panic!("{f:#?}"));
    assert_eq!(again.bodies, scenario.bodies);
    assert_eq!(again.run, scenario.run);
    assert_eq!(again.compression, scenario.compression);
}

/// Of the values of a key each third, of the next key the next third: keys of one kind try all of them.
#[test]
fn every_key_refuses_wrong_types_and_impossible_values() {
    refuse_values(|key, value| (key + value) % 3 == 0, 100);
}

#[test]
#[ignore = "second tier: half a minute"]
fn every_key_refuses_all_wrong_types_and_impossible_values() {
    refuse_values(|_, _| true, 400);
}

fn refuse_values(takes: impl Fn(usize, usize) -> bool, least: usize) {
    let (mut n, mut n_keys) = (0, 0);
    each_key(tables::SCENARIO, "", &mut |key, path| {
        n_keys += 1;
        for (_, value) in bad_values(&key.kind).into_iter().enumerate().filter(|(i, _)| takes(n_keys, *i)) {
            let set = format!("{path}={value}");
            let list = parse(ALL_SHAPES.as_bytes(), std::slice::from_ref(&set)).err();
            let list = list.unwrap_or_else(|| panic!("--set {set} is accepted"));
            let named =
                |f: &Fault| f.key.starts_with(path) && f.to_string().contains(&format!("--set {set}"));
            assert!(list.iter().any(named), "--set {set} is named: {list:#?}");
            n += 1;
        }
    });
    // The walk reaches every table.
    assert!(n > least, "{n} values tried");
}

#[test]
fn every_table_refuses_unknown_keys() {
    each_key(tables::SCENARIO, "", &mut |key, path| {
        let table = match &key.kind {
            Kind::Table(_) => path.to_owned(),
            Kind::Tables(_) => format!("{path}[0]"),
            _ => return,
        };
        let list = parse(ALL_SHAPES.as_bytes(), &[format!("{table}.xyzzy=1")]).expect_err("unknown");
        assert!(list.iter().any(|f| f.key == format!("{table}.xyzzy")), "{table}: {list:#?}");
    });
}

#[test]
fn every_required_key_is_missed() {
    let mut n = 0;
    each_key(tables::SCENARIO, "", &mut |key, path| {
        if !matches!(key.need, Need::Required) || matches!(key.kind, Kind::Variants { .. }) {
            return;
        }
        let mut table: toml::Table = ALL_SHAPES.parse().expect("TOML");
        let parts: Vec<String> = path.replace("[0]", ".0").split('.').map(str::to_owned).collect();
        if !remove(&mut table, &parts) {
            return;
        }
        let list = parse(toml::to_string(&table).expect("TOML").as_bytes(), &[]).expect_err(path);
        let fault = list.iter().find(|f| f.key == path).unwrap_or_else(|| panic!("{path} in {list:#?}"));
        assert!(fault.message.contains("missing") && fault.line() > Some(0), "{fault}");
        n += 1;
    });
    assert!(n > 20, "{n} keys removed");
}

fn remove(table: &mut toml::Table, parts: &[String]) -> bool {
    let (first, rest) = parts.split_first().expect("a path is not empty");
    if rest.is_empty() {
        return table.remove(first).is_some();
    }
    match table.get_mut(first) {
        Some(toml::Value::Table(inner)) => remove(inner, rest),
        Some(toml::Value::Array(items)) => match items.first_mut() {
            Some(toml::Value::Table(inner)) => remove(inner, &rest[1..]),
            _ => false,
        },
        _ => false,
    }
}

#[test]
fn nurbs_files_are_read_and_their_faults_located_in_them() {
    let directory = tempfile::tempdir().expect("a temporary directory");
    let net = "degrees = 1\nknots = [[0,0,1,1],[0,0,1,1]]\ncontrol_points = [[0,0],[1,0],[0,1],[1,1]]\n";
    let json = r#"{"degrees":1,"knots":[[0,0,1,1],[0,0,1,1]],"control_points":[[0,0],[1,0],[0,1],[1,1]]}"#;
    let text = |file: &str| {
        format!(
            "[simulation]\nend_time=1\n[materials.m]\nyoungs_modulus=1\npoissons_ratio=0\ndensity=1\n\
             [bodies.b]\nmodel=\"plane-strain\"\nmaterial=\"m\"\ngeometry={{shape=\"nurbs\",file=\"{file}\"}}\n"
        )
    };
    let case = directory.path().join("case.toml");
    let write =
        |name: &str, content: &str| std::fs::write(directory.path().join(name), content).expect("written");
    write("net.toml", net);
    write("net.json", json);
    for file in ["net.toml", "net.json"] {
        scenario::parse(&case, text(file).as_bytes(), &[]).unwrap_or_else(|f| panic!("{f}"));
    }
    write("net.toml", &net.replace("[1,1]]\n", "[1,-]]\n"));
    let faults = scenario::parse(&case, text("net.toml").as_bytes(), &[]).expect_err("syntax");
    assert!(faults.to_string().contains("net.toml:3:"), "{faults}");
    write("net.toml", &net.replace("[0,1],[1,1]]", "[0,1]]"));
    let faults = scenario::parse(&case, text("net.toml").as_bytes(), &[]).expect_err("too few points");
    assert!(
        faults.to_string().contains("net.toml:3:") && faults.to_string().contains("ask for 4"),
        "{faults}"
    );
    write("net.json", "{\"degrees\": 1,\n \"knots\": }");
    let faults = scenario::parse(&case, text("net.json").as_bytes(), &[]).expect_err("syntax");
    assert!(faults.to_string().contains("net.json:2:"), "{faults}");
    let faults = scenario::parse(&case, text("no.toml").as_bytes(), &[]).expect_err("no file");
    assert!(
        faults.to_string().contains("case.toml:10:") && faults.to_string().contains("no.toml"),
        "{faults}"
    );
}

#[test]
fn deep_nesting_is_a_fault_and_no_crash() {
    for text in [
        format!("a = {}1{}", "[".repeat(100_000), "]".repeat(100_000)),
        format!("a = {}", "{b=".repeat(100_000)),
        format!("{}a = 1", "a.".repeat(100_000)),
        format!("[{}a]\nb = 1", "a.".repeat(100_000)),
    ] {
        let list = parse(text.as_bytes(), &[]).expect_err("no scenario");
        assert!(list.iter().all(|f| f.line() > Some(0)));
    }
}

#[test]
fn of_many_faults_the_first_are_shown_and_all_are_counted() {
    let shown = |n: usize| {
        let text: String = (0..n).map(|i| format!("wrong{i} = 1\n")).collect();
        let faults = scenario::parse(Path::new("case.toml"), text.as_bytes(), &[]).expect_err("no scenario");
        let (all, text) = (faults.list().len(), faults.to_string());
        (all, text.matches("unknown key").count(), text.lines().last().map(str::to_owned).unwrap_or_default())
    };
    let (all, few, end) = shown(3);
    assert!(few == 3 && end == format!("{all} faults found"), "{few}, {end}");
    let (all, many, end) = shown(500);
    assert!(all >= 500 && many <= 20, "{all} {many}");
    assert_eq!(end, format!("{all} faults found, the first 20 are shown"));
}

/// What the program promises about any input.
fn check_promise(text: &[u8], set: &[String]) {
    if let Err(list) = parse(text, set) {
        assert!(!list.is_empty(), "a refusal has a reason");
        for fault in &list {
            assert!(fault.line().is_none_or(|l| l > 0), "{fault}");
            assert!(!fault.message.is_empty());
            // Rendering must not panic either.
            let _ = fault.to_string();
        }
    }
}

fn junk() -> impl Strategy<Value = String> {
    prop_oneof![
        Just("nan".to_owned()),
        Just("-inf".to_owned()),
        Just("1e308".to_owned()),
        Just("-9223372036854775808".to_owned()),
        Just("99999999999999999999".to_owned()),
        Just("\"\"".to_owned()),
        Just("[]".to_owned()),
        Just("{}".to_owned()),
        Just("[[[]]]".to_owned()),
        Just("[{}]".to_owned()),
        Just("1979-05-27T07:32:00Z".to_owned()),
        any::<f64>().prop_map(|x| format!("{x:e}")),
        any::<i64>().prop_map(|x| x.to_string()),
        "\\PC{0,12}",
    ]
}

proptest! {
    // A case takes about 0.2 ms.
    #![proptest_config(ProptestConfig { cases: 600, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn changed_values_never_panic(which in 0..TEXTS.len(), line in any::<prop::sample::Index>(), value in junk()) {
        let text = TEXTS[which];
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let i = line.index(lines.len());
        if let Some((key, _)) = lines[i].clone().split_once('=') {
            lines[i] = format!("{key}= {value}");
        }
        check_promise(lines.join("\n").as_bytes(), &[]);
    }

    #[test]
    fn deleted_doubled_and_swapped_lines_never_panic(
        which in 0..TEXTS.len(), a in any::<prop::sample::Index>(), b in any::<prop::sample::Index>(), what in 0u8..3,
    ) {
        let mut lines: Vec<&str> = TEXTS[which].lines().collect();
        let (i, j) = (a.index(lines.len()), b.index(lines.len()));
        match what {
            0 => { lines.remove(i); }
            1 => lines.insert(j, lines[i]),
            _ => lines.swap(i, j),
        }
        check_promise(lines.join("\n").as_bytes(), &[]);
    }

    #[test]
    fn changed_bytes_never_panic(
        which in 0..TEXTS.len(), changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = TEXTS[which].as_bytes().to_vec();
        for (at, byte) in changes {
            let i = at.index(bytes.len());
            bytes[i] = byte;
        }
        check_promise(&bytes, &[]);
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        check_promise(&bytes, &[]);
    }

    #[test]
    fn overrides_never_panic(key in "[a-z_.\\[\\]0-9\"]{1,30}", value in junk()) {
        let text = format!("{key}={value}");
        if text.parse::<Override>().is_ok() {
            check_promise(SPHERE.as_bytes(), &[text]);
        }
    }

    #[test]
    fn overrides_of_real_keys_never_panic(which in any::<prop::sample::Index>(), value in junk()) {
        let mut paths = Vec::new();
        each_key(tables::SCENARIO, "", &mut |_, path| paths.push(path.to_owned()));
        let path = which.get(&paths);
        check_promise(ALL_SHAPES.as_bytes(), &[format!("{path}={value}")]);
    }
}

/// Those who know other programs are led on by their words.
#[test]
fn words_of_other_programs_are_answered_with_the_right_one() {
    let said = |text: &str| {
        let faults = scenario::parse(Path::new("words.toml"), text.as_bytes(), &[]).expect_err("a fault");
        faults.list().iter().map(|f| format!("{f}\n")).collect::<String>()
    };
    for (word, right) in [
        ("weld", "fixed"),
        ("hinge", "revolute"),
        ("Slider", "prismatic"),
        ("ball joint", "spherical"),
        ("cardan", "universal"),
        ("revolut", "revolute"),
    ] {
        let text = said(&ALL_SHAPES.replace("type = \"cylindrical\"", &format!("type = \"{word}\"")));
        assert!(text.contains(&format!("did you mean \"{right}\"?")), "{word}: {text}");
    }
    for (shape, word, right) in [
        ("box", "beam", "box"),
        ("hollow-cylinder", "pipe", "hollow-cylinder"),
        ("disc", "disk", "disc"),
        ("sphere", "ball", "sphere"),
        ("plane", "floor", "plane"),
    ] {
        let text = said(&ALL_SHAPES.replace(&format!("shape = \"{shape}\""), &format!("shape = \"{word}\"")));
        assert!(text.contains(&format!("did you mean \"{right}\"?")), "{word}: {text}");
    }
}
