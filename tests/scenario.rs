//! The scenario reader: valid files are read, every kind of fault is located, nothing panics.

use std::path::Path;

use adaptive::spec::Target;
use fbimpact::scenario::keys::{Key, Kind};
use fbimpact::scenario::{self, Fault, Override, Scenario, tables};

const SPHERE: &str = include_str!("../scenarios/sphere_on_plane.toml");
const ROD: &str = include_str!("../scenarios/rod_on_plane.toml");
const SHIPPED: [&str; 13] = [
    SPHERE,
    ROD,
    include_str!("../scenarios/cylinder_modes.toml"),
    include_str!("../scenarios/rigid_double_pendulums.toml"),
    include_str!("../scenarios/flat_rods.toml"),
    include_str!("../scenarios/flexible_pendulum.toml"),
    include_str!("../scenarios/rotating_disc.toml"),
    include_str!("../scenarios/oblique_discs.toml"),
    include_str!("../scenarios/sphere_rod_sphere.toml"),
    include_str!("../scenarios/spinning_beam.toml"),
    include_str!("../scenarios/double_pendulum.toml"),
    include_str!("../scenarios/double_pendulum/hertz.toml"),
    include_str!("../scenarios/double_pendulum/quasistatic.toml"),
];

fn parse(text: &str) -> Result<Scenario, Vec<Fault>> {
    parse_with(text, &[])
}

fn parse_with(text: &str, set: &[&str]) -> Result<Scenario, Vec<Fault>> {
    let overrides: Vec<Override> = set.iter().map(|s| s.parse().expect("valid --set")).collect();
    scenario::parse(Path::new("case.toml"), text.as_bytes(), &overrides).map_err(|f| f.list().to_vec())
}

fn faults(text: &str) -> Vec<Fault> {
    parse(text).expect_err("the scenario is at fault")
}

/// `SPHERE` with one piece of text replaced, which must be there.
fn sphere_with(old: &str, new: &str) -> String {
    assert!(SPHERE.contains(old), "{old} is part of the scenario");
    SPHERE.replacen(old, new, 1)
}

#[test]
fn shipped_scenarios_are_valid() {
    let sphere = parse(SPHERE).expect("valid");
    assert_eq!(sphere.bodies.len(), 2);
    assert_eq!(sphere.bodies[0].name, "ball");
    let ball = sphere.run.bodies[0].elastic().expect("the ball is flexible");
    assert!(ball.shape.faces.contains_key("surface"));
    assert_eq!(ball.discretisation.elements, [8, 8]);
    assert!(!sphere.wishes[0].elements);
    assert_eq!(parse(ROD).expect("valid").run.points[0].name, "far_end");
}

#[test]
fn resolved_scenario_reads_back_to_itself() {
    for text in SHIPPED {
        let first = parse(text).expect("valid");
        let mut second = parse(&first.source.resolved).unwrap_or_else(|f| panic!("{f:#?}"));
        assert_eq!(first.source.resolved, second.source.resolved);
        second.source = first.source.clone();
        assert_eq!(first, second);
    }
}

#[test]
fn defaults_of_the_key_tables_are_valid() {
    fn walk(keys: &[Key]) {
        for key in keys {
            if let Some(text) = key.need.default() {
                assert!(format!("x = {text}").parse::<toml::Table>().is_ok(), "default of {}", key.name);
            }
            match &key.kind {
                Kind::Table(keys) | Kind::Named(keys) | Kind::NamedByFile(keys) | Kind::Tables(keys) => {
                    walk(keys)
                }
                Kind::Variants { variants, .. } | Kind::NumberOrVariants { variants, .. } => {
                    variants.iter().for_each(|v| walk(v.keys))
                }
                _ => {}
            }
        }
    }
    walk(tables::SCENARIO);
}

#[test]
fn unknown_key_is_located_and_the_nearest_one_named() {
    let list = faults(&sphere_with("density", "densty"));
    let fault = list.iter().find(|f| f.key == "materials.aluminium.densty").expect("a fault at the key");
    assert_eq!(fault.suggestion.as_deref(), Some("density"));
    assert_eq!(fault.value.as_deref(), Some("2789.0"));
    let line = SPHERE.lines().position(|l| l.starts_with("density")).expect("there") + 1;
    assert_eq!(fault.line(), Some(line));
    // The key that was meant is missing then, at the head of its table.
    assert!(list.iter().any(|f| f.key == "materials.aluminium.density" && f.message.contains("missing")));
}

#[test]
fn all_faults_are_reported_at_once() {
    let text = sphere_with("radius = 10.0e-3", "radius = -1")
        .replace("youngs_modulus = 72.8e9", "youngs_modulus = \"hard\"")
        .replace("contact_body = \"ball\"", "contact_body = \"bal\"")
        .replace("end_time = 1.0e-4", "end_time = nan");
    let keys: Vec<String> = faults(&text).into_iter().map(|f| f.key).collect();
    for key in [
        "simulation.end_time",
        "materials.aluminium.youngs_modulus",
        "bodies.ball.geometry.radius",
        "contacts.impact.contact_body",
    ] {
        assert!(keys.iter().any(|k| k == key), "{key} is among {keys:?}");
    }
}

#[test]
fn names_that_refer_to_nothing_are_faults() {
    let cases = [
        ("material = \"aluminium\"", "material = \"aluminum\"", "bodies.ball.material", Some("aluminium")),
        (
            "marker = \"bottom\"",
            "marker = \"botom\"",
            "bodies.ball.discretisation.refine[0].marker",
            Some("bottom"),
        ),
        ("target_body = \"floor\"", "target_body = \"flor\"", "contacts.impact.target_body", Some("floor")),
        ("body = \"ball\"\nfrom", "body = \"bell\"\nfrom", "output.stress.axis.body", Some("ball")),
        ("shape = \"sphere\"", "shape = \"shpere\"", "bodies.ball.geometry.shape", Some("sphere")),
    ];
    for (old, new, key, suggestion) in cases {
        let list = faults(&sphere_with(old, new));
        let fault = list.iter().find(|f| f.key == key).unwrap_or_else(|| panic!("{key} in {list:#?}"));
        assert_eq!(fault.suggestion.as_deref(), suggestion, "{key}");
    }
}

#[test]
fn overrides_reach_tables_arrays_and_new_keys() {
    let set = [
        "simulation.end_time=2e-4",
        "bodies.ball.velocity=[0,0,-0.2]",
        "bodies.ball.discretisation.refine[0].elements=32",
        "bodies.ball.discretisation.refine.0.ratio=2",
        "output.compression=gzip",
        "output.points.top.body=ball",
        "output.points.top.marker=top",
    ];
    let scenario = parse_with(SPHERE, &set).expect("valid");
    assert!((scenario.run.settings.end_time - 2e-4).abs() < 1e-18);
    assert!((scenario.run.bodies[0].motion.velocity[2] + 0.2).abs() < 1e-15);
    let ball = scenario.run.bodies[0].elastic().expect("flexible");
    assert_eq!(ball.discretisation.refine[0].elements, 32);
    assert_eq!(scenario.run.points[0].name, "top");
    for set in ["title.x=1", "bodies.ball.discretisation.refine[3].elements=2", "bodies.ball.velocity.x=1"] {
        let list = parse_with(SPHERE, &[set]).expect_err("at fault");
        assert!(list[0].to_string().starts_with(&format!("--set {set}")), "{}", list[0]);
    }
    assert!("no-equals-sign".parse::<Override>().is_err());
    assert!("a..b=1".parse::<Override>().is_err());
}

#[test]
fn degrees_and_radians_agree_and_exclude_each_other() {
    let rigid = "[bodies.tilted]\nmodel=\"rigid\"\nmass=1\ninertia=[1,1,1]\n";
    let plane = "[bodies.wall]\nmodel=\"rigid\"\ngeometry={shape=\"plane\"}\n[contacts.second]\ncontact_body=\"ball\"\n\
                 target_body=\"wall\"\nmodel=\"quasistatic\"\n";
    let text = format!("{SPHERE}\n{rigid}{plane}");
    let deg = parse_with(&text, &["bodies.tilted.orientation_deg=[90,0,0]"]).expect("valid");
    let rad = parse_with(&text, &["bodies.tilted.orientation=[1.5707963267948966,0,0]"]).expect("valid");
    let of = |scenario: &Scenario| scenario.run.bodies[1].motion.rotation;
    // Round-off of the factor pi / 180.
    assert!(of(&deg).angle_to(&of(&rad)) < 1e-15);
    let turned = parse_with(&text, &["bodies.wall.orientation_deg=[90,0,0]"]).expect("valid");
    let Target::Plane(plane) = turned.run.contacts[1].target else { panic!("a plane") };
    // A quarter turn about x takes z to -y; round-off of one rotation.
    assert!((plane.normal[1] + 1.0).abs() < 1e-15);
    let both = ["bodies.tilted.orientation=[1,0,0]", "bodies.tilted.orientation_deg=[90,0,0]"];
    assert!(parse_with(&text, &both).is_err());
}

#[test]
fn motions_that_a_model_cannot_take_are_faults() {
    for (set, key) in [
        ("bodies.ball.velocity=[0.1,0,0]", "bodies.ball.velocity"),
        ("bodies.ball.angular_velocity=[0,0,1]", "bodies.ball.angular_velocity"),
        ("bodies.floor.velocity=[0,0,1]", "bodies.floor.velocity"),
        ("bodies.floor.normal=[1,0,1]", "bodies.floor.normal"),
        ("bodies.floor.normal=[0,0,0]", "bodies.floor.normal"),
        ("bodies.floor.material=aluminum", "bodies.floor.material"),
        ("simulation.gravity=[1,0,0]", "simulation.gravity"),
        ("bodies.ball.thickness=1", "bodies.ball.thickness"),
        ("bodies.ball.model=solid", "contacts"),
        ("bodies.ball.model=plane-strain", "bodies.ball.geometry.shape"),
        ("output.stress.axis.at=1.0", "output.stress.axis.at"),
        ("output.stress.axis.from=[0,0,0]", "output.stress.axis.from"),
        ("output.stress.axis.to=[0,0.011]", "output.stress.axis.to"),
        ("output.points.far={body=\"ball\",point=[0.0,0.011]}", "output.points.far.point"),
        ("contacts.impact.target_body=ball", "contacts.impact.target_body"),
        ("bodies.ball.reduction.method=modal", "contacts.impact.model"),
    ] {
        let outcome = parse_with(SPHERE, &[set]);
        if key == "contacts" {
            // A solid ball is fine as such, but the points of the stress line have two coordinates.
            let list = outcome.expect_err("points no longer fit");
            assert!(list.iter().all(|f| f.key.starts_with("output.stress")), "{list:#?}");
            continue;
        }
        let list = outcome.expect_err(set);
        assert!(list.iter().any(|f| f.key == key), "{set}: {list:#?}");
    }
}

#[test]
fn bytes_that_are_no_text_are_located() {
    let mut bytes = SPHERE.as_bytes().to_vec();
    let at = SPHERE.find("density").expect("there");
    bytes[at] = 0xff;
    let list = scenario::parse(Path::new("case.toml"), &bytes, &[]).expect_err("not UTF-8");
    let line = SPHERE[..at].matches('\n').count() + 1;
    assert_eq!(list.list()[0].line(), Some(line));
}

/// Numbers of a file are those of the lists, whatever stands around them, and the resolved scenario needs the file no more.
#[test]
fn tables_over_time_come_from_files() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(
        folder.path().join("push.csv"),
        "# measured\nt [s],force [N],other\n0,0,7\n0.5,2.5,7\n1,0,7\n",
    )
    .expect("written");
    let text = |force: &str| {
        format!(
            r#"
            simulation = {{ end_time = 1.0 }}
            [bodies.stone]
            model = "rigid"
            mass = 1.0
            inertia = [1.0, 1.0, 1.0]
            [loads.push]
            body = "stone"
            point = [0.0, 0.0, 0.0]
            force_z = {{ kind = "table", {force} }}
            "#
        )
    };
    let parse = |force: &str| {
        fbimpact::scenario::parse(&folder.path().join("case.toml"), text(force).as_bytes(), &[])
    };
    let lists = "times = [0.0, 0.5, 1.0], values = [0.0, 2.5, 0.0]";
    for (of_file, inline) in [
        ("file = \"push.csv\"", lists.to_owned()),
        (
            "file = \"push.csv\", value_column = \"force [N]\", periodic = true",
            format!("{lists}, periodic = true"),
        ),
        (
            "file = \"push.csv\", time_column = \"1\", value_column = \"3\"",
            "times = [0.0, 0.5, 1.0], values = [7, 7, 7]".into(),
        ),
    ] {
        let (found, expected) = (parse(of_file).expect("valid"), parse(&inline).expect("valid"));
        assert_eq!(found.run.loads, expected.run.loads, "{of_file}");
        assert_eq!(found.source.resolved, expected.source.resolved, "{of_file}");
    }
    for (force, words) in [
        ("file = \"none.csv\"", &["loads.push.force_z.file", "none.csv cannot be read"][..]),
        ("file = \"push.csv\", value_column = \"F\"", &["value_column", "t [s], force [N], other"]),
        ("file = \"push.csv\", times = [0.0, 1.0], values = [0.0, 1.0]", &["without `file`"]),
        ("times = [0.0, 1.0]", &["values", "required key is missing"]),
        ("times = [0.0, 1.0], values = [0.0, 1.0], value_column = \"F\"", &["with `file`"]),
        ("times = [0.0, 1.0], values = [0.0, 1.0], periodic = true", &["must end as they begin"]),
    ] {
        let faults = parse(force).expect_err(force);
        let said: String = faults.list().iter().map(|f| format!("{f}\n")).collect();
        assert!(words.iter().all(|word| said.contains(word)), "{force}: {said}");
    }
}
