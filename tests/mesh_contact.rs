//! Contact of bodies of finite elements, on their own mesh and on elements that the program divides at the touch: against bodies of splines, against each
//! other, identities, faults.
//!
//! Balls fall at 10 m/s, where the contact radius is a tenth of theirs, so that meshes of a few thousand elements resolve it. What they are
//! compared with is the axisymmetric body of splines in the same impact.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use crate::balls::Ball;
use crate::blocks::block;
use crate::writers::{Form, gmsh};
use adaptive::record::warning::WarningKind;
use adaptive::record::{ImpactRecord, Sample};
use adaptive::run::recording::Recording;
use fbimpact::scenario::{self, Fault, Scenario};
use fbimpact::simulate::simulate;
use fe_mesh::ElementKind;

const WORLD: &str = r#"
[simulation]
end_time = 4.0e-5

[materials.aluminium]
youngs_modulus = 72.8e9
poissons_ratio = 0.33
density = 2789.0

[bodies.floor]
model = "rigid"
geometry = { shape = "plane" }

[contacts.impact]
contact_body = "upper"
target_body = "floor"
model = "quasistatic"
"#;

/// About 2.5 elements on the contact radius: contact begins when the first Gauss point touches, which shortens it by 3 % of the square of their
/// length over the radius, 0.5 %.
const FINE: Ball = Ball { radius: 10.0, across: [12, 4], layers: 5, growth: [1.45, 1.5] };
/// About one, enough for identities.
const COARSE: Ball = Ball { radius: 10.0, across: [6, 2], layers: 2, growth: [1.2, 1.5] };

/// Ten elements across, six on a quarter of the circumference: sides of 2.6 mm, where the contact radius is 1 mm. Curvature of sides of the length L errs by
/// (L/R)²/16 in their middles and five times as much at their corners, 2 %, and the force by a fifth of that.
const TEN: Ball = Ball { radius: 10.0, across: [6, 6], layers: 2, growth: [1.0, 1.0] };

/// Files that all tests read.
fn files() -> &'static Path {
    static DIRECTORY: OnceLock<PathBuf> = OnceLock::new();
    DIRECTORY.get_or_init(|| {
        let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mesh_contact");
        std::fs::create_dir_all(&directory).unwrap();
        let write =
            |name: &str, mesh| std::fs::write(directory.join(name), gmsh(&mesh, Form::Binary41)).unwrap();
        write("hex20.msh", FINE.mesh(ElementKind::Hex20));
        write("tet10.msh", FINE.mesh(ElementKind::Tet10));
        write("ten_hex20.msh", TEN.mesh(ElementKind::Hex20));
        write("ten_tet10.msh", TEN.mesh(ElementKind::Tet10));
        write("ten_hex8.msh", TEN.mesh(ElementKind::Hex8));
        let mut ellipsoid = TEN.mesh(ElementKind::Hex8);
        ellipsoid.nodes.iter_mut().for_each(|[x, y, _]| (*x, *y) = (1.3 * *x, 0.9 * *y));
        write("ellipsoid_hex8.msh", ellipsoid);
        let kinds = [ElementKind::Hex20, ElementKind::Pyramid13, ElementKind::Tet10];
        // Hexahedra above, tetrahedra where the plane is hit; and hexahedra but for the outermost elements there.
        write("ten_mixed.msh", TEN.mixed(kinds, |[_, _, z]| z > 0.0));
        write("ten_pyramids.msh", TEN.mixed(kinds, |[_, _, z]| z > -8.0));
        write("coarse_hex20.msh", COARSE.mesh(ElementKind::Hex20));
        write("coarse_tet10.msh", COARSE.mesh(ElementKind::Tet10));
        directory
    })
}

fn parse(text: &str) -> Result<Scenario, Vec<Fault>> {
    let path = files().join("case.toml");
    scenario::parse(&path, text.as_bytes(), &[]).map_err(|f| f.list().to_vec())
}

/// A ball called `name` of the mesh `file` that starts touching the origin, above it for a positive `side`.
fn meshed(name: &str, file: &str, side: f64) -> String {
    format!(
        r#"
        [bodies.{name}]
        model = "mesh"
        file = "{file}.msh"
        units = "mm"
        material = "aluminium"
        reduction = {{ modes = 60 }}
        position = [0.0, 0.0, {}]
        velocity = [0.0, 0.0, {}]
        "#,
        10e-3 * side,
        -10.0 * side
    )
}

/// The same of splines, with the end of its axis at the touch.
fn splines(name: &str, model: &str, side: f64) -> String {
    let (geometry, refine) = match model {
        "axisymmetric" => ("{ degree = 3, elements = 8", "elements = 24"),
        _ => ("{ degree = 2, elements = 4", "elements = 8, ratio = 1.8"),
    };
    let point = if model == "axisymmetric" {
        format!("[0.0, {}]", -10e-3 * side)
    } else {
        format!("[0.0, 0.0, {}]", -10e-3 * side)
    };
    let width = if model == "axisymmetric" { 1.6e-3 } else { 3.2e-3 };
    format!(
        r#"
        [bodies.{name}]
        model = "{model}"
        material = "aluminium"
        geometry = {{ shape = "sphere", radius = 10.0e-3 }}
        discretisation = {geometry}, refine = [{{ point = {point}, width = {width}, {refine} }}] }}
        reduction = {{ modes = {} }}
        position = [0.0, 0.0, {}]
        velocity = [0.0, 0.0, {}]
        "#,
        if model == "axisymmetric" { 20 } else { 60 },
        10e-3 * side,
        -10.0 * side
    )
}

fn run(text: &str) -> Recording {
    let scenario = parse(text).unwrap_or_else(|faults| panic!("{faults:?}"));
    let mut recording = Recording::default();
    simulate(&scenario, &mut recording, 2).unwrap();
    recording
}

/// The impact of the ball of splines, which is that of two equal ones as well.
fn expected() -> &'static ImpactRecord {
    static IMPACT: OnceLock<ImpactRecord> = OnceLock::new();
    IMPACT.get_or_init(|| {
        let impact = run(&format!("{WORLD}{}", splines("upper", "axisymmetric", 1.0))).impacts[0];
        println!("splines: {:.3} N, {:.4} us", impact.peak_force, 1e6 * (impact.end - impact.start));
        impact
    })
}

/// Compares force, duration, ledger and momenta of `recording` with what `tolerances` on force and duration allow.
fn compare(name: &str, recording: &Recording, tolerances: [f64; 2]) {
    let (found, wanted) = (&recording.impacts[0], expected());
    let length = |i: &ImpactRecord| i.end - i.start;
    let (force, time) = (found.peak_force / wanted.peak_force - 1.0, length(found) / length(wanted) - 1.0);
    println!("{name}: {:.3} N ({force:+.2e}), duration {time:+.2e}", found.peak_force);
    // Claims of docs/verification.md.
    assert!(force.abs() < tolerances[0] && time.abs() < tolerances[1], "{name}: {force:e}, {time:e}");
    check_ledger(name, recording);
}

/// Compares the pressure at the largest force of a contact of equal balls, or of one and a rigid plane, with Hertz': its largest value, its error within 0.6 of the
/// contact radius as the root of the mean of squares, both over the largest pressure, and the area under pressure.
fn check_pressure(name: &str, recording: &Recording, [highest, scatter, area]: [f64; 3]) {
    let force = |s: &Sample| s.contacts[0].normal_force;
    let sample = recording.samples.iter().max_by(|a, b| force(a).total_cmp(&force(b))).unwrap();
    let modulus = 72.8e9 / (1.0 - 0.33 * 0.33);
    let radius = (0.75 * force(sample) * 10e-3 / modulus).cbrt();
    let (circle, points) = (std::f64::consts::PI * radius * radius, &sample.pressures[0]);
    let largest = 1.5 * force(sample) / circle;
    let peak = points.iter().map(|p| p.pressure).fold(0.0, f64::max) / largest - 1.0;
    let inner = points.iter().map(|p| (p.position[0].hypot(p.position[1]) / radius, p.pressure / largest));
    let inner: Vec<f64> =
        inner.filter(|(r, _)| *r < 0.6).map(|(r, p)| (p - (1.0 - r * r).sqrt()).powi(2)).collect();
    let error = (inner.iter().sum::<f64>() / inner.len() as f64).sqrt();
    let under = points.iter().map(|p| p.area).sum::<f64>() / circle - 1.0;
    let sum = points.iter().map(|p| p.area * p.pressure).sum::<f64>() / force(sample) - 1.0;
    println!("{name}: pressure {peak:+.3}, scatter {error:.3}, area {under:+.3}");
    assert!(peak.abs() < highest && error < scatter && under.abs() < area, "{name}");
    // Sums over some hundred points.
    assert!(sum.abs() < 1e-12, "{name}: {sum:e}");
}

/// The largest change of the energy, relative to that at the start.
fn check_ledger(name: &str, recording: &Recording) {
    let start = recording.samples[0].energies.total();
    let changes = recording.samples.iter().map(|s| (s.energies.total() / start - 1.0).abs());
    let drift = changes.fold(0.0, f64::max);
    println!("{name}: ledger {drift:.1e}");
    // Claim of docs/verification.md.
    assert!(drift < 1e-5, "{name}: {drift:e}");
}

/// Two balls that hit each other keep their momenta: forces are equal, opposite and on one line.
fn check_momenta(name: &str, recording: &Recording) {
    let scale = 11.7e-3 * 10.0;
    let change = |now: &[f64; 3], start: &[f64; 3]| {
        now.iter().zip(start).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs())) / scale
    };
    let first = &recording.samples[0];
    for sample in &recording.samples {
        let linear = change(&sample.linear_momentum, &first.linear_momentum);
        let angular = change(&sample.angular_momentum, &first.angular_momentum) / 10e-3;
        // A thousand evaluations add up to the round-off of sums over some hundred points.
        assert!(linear < 1e-11 && angular < 1e-11, "{name}: {linear:e}, {angular:e}");
    }
}

#[test]
fn a_ball_of_hexahedra_hits_a_plane_as_one_of_splines_does() {
    compare("hex20", &run(&format!("{WORLD}{}", meshed("upper", "hex20", 1.0))), [5e-3, 1e-2]);
}

/// The upper ball of the mesh `upper` hits the lower one of the mesh `lower`.
fn pair(upper: &str, lower: &str) -> Recording {
    let world = WORLD.replace("target_body = \"floor\"", "target_body = \"lower\"");
    run(&format!("{world}{}{}", meshed("upper", upper, 1.0), meshed("lower", lower, -1.0)))
}

#[test]
fn meshed_balls_hit_each_other_and_keep_their_momenta() {
    check_momenta("hexahedra on tetrahedra", &pair("coarse_hex20", "coarse_tet10"));
}

#[test]
#[ignore = "second tier: half a dozen seconds"]
fn meshed_balls_keep_their_momenta_in_the_other_role() {
    check_momenta("tetrahedra on hexahedra", &pair("coarse_tet10", "coarse_hex20"));
}

#[test]
#[ignore = "second tier: four minutes"]
fn meshed_balls_hit_each_other_as_one_hits_a_plane() {
    for [upper, lower] in [["hex20", "tet10"], ["tet10", "hex20"]] {
        let (recording, name) = (pair(upper, lower), format!("{upper} on {lower}"));
        compare(&name, &recording, [1e-2, 1e-2]);
        check_momenta(&name, &recording);
    }
}

#[test]
#[ignore = "second tier: a minute"]
fn meshed_balls_and_balls_of_splines_hit_each_other_in_either_role() {
    for (own, target) in [("upper", "lower"), ("lower", "upper")] {
        let world = WORLD.replace("target_body = \"floor\"", &format!("target_body = \"{target}\""));
        let world = world.replace("contact_body = \"upper\"", &format!("contact_body = \"{own}\""));
        let text = format!("{world}{}{}", meshed("upper", "hex20", 1.0), splines("lower", "solid", -1.0));
        let recording = run(&text);
        let name = if own == "upper" { "mesh on splines" } else { "splines on mesh" };
        compare(name, &recording, [1e-2, 1e-2]);
        check_momenta(name, &recording);
    }
}

/// [`WORLD`] with elements that the program divides at the touch.
fn adaptive() -> String {
    WORLD.replace("model = \"quasistatic\"", "model = \"adaptive\"")
}

#[test]
#[ignore = "second tier: ten seconds; a mesh is divided in the first (mesh_stress, mesh_zones of adaptive)"]
fn a_coarse_ball_is_divided_where_it_hits_a_plane() {
    let recording = run(&format!("{}{}", adaptive(), meshed("upper", "ten_hex20", 1.0)));
    compare("ten hex20 across", &recording, [1e-2, 1e-2]);
    // Means over corners and what lies straight between them are (5/12) (h/a)^2 below the peak of a pressure like Hertz', 6 % with sides of a/2.6;
    // as much at the edge, where a side more or less is a fifth of the area.
    check_pressure("ten hex20 across", &recording, [0.1, 0.1, 0.2]);
    check_transfers(&recording);
}

/// What comes and goes at a touch keeps the state: the field of the dynamic modes is the same on both meshes.
fn check_transfers(recording: &Recording) {
    for transfer in &recording.transfers {
        assert!((transfer.energy_after / transfer.energy_before - 1.0).abs() < 1e-12, "{transfer:?}");
        assert!(transfer.momentum_change < 1e-12 * 11.7e-3 * 10.0, "{transfer:?}");
    }
    assert!(!recording.transfers.is_empty());
}

#[test]
#[ignore = "second tier: half a minute"]
fn pyramids_away_from_the_touch_leave_the_force_as_it_is() {
    let recording = run(&format!("{}{}", adaptive(), meshed("upper", "ten_mixed", 1.0)));
    // As of the ball of hexahedra or tetrahedra alone.
    compare("ten, mixed", &recording, [1e-2, 1e-2]);
}

#[test]
fn pyramids_at_the_touch_are_refused_by_number() {
    let text = format!("{}{}", adaptive(), meshed("upper", "ten_pyramids", 1.0));
    let mut recording = Recording::default();
    let fault = simulate(&parse(&text).unwrap(), &mut recording, 2).unwrap_err().to_string();
    let words = ["upper", "(pyramid13) at (", "no pyramids near the touch", "model = \"quasistatic\""];
    assert!(words.iter().all(|word| fault.contains(word)), "{fault}");
}

#[test]
#[ignore = "second tier: ten seconds; stress of given zones and of divided meshes is in the first (mesh_stress)"]
fn stress_over_time_below_the_touch_is_that_of_splines() {
    stress_below_the_touch(WORLD, "hex20");
}

#[test]
#[ignore = "second tier: ten seconds"]
fn stress_over_time_in_a_divided_mesh_is_that_of_splines() {
    stress_below_the_touch(&adaptive(), "ten_hex20");
}

/// A millimetre below the touch, a contact radius, on the ball's own mesh or on one that is divided during the run.
fn stress_below_the_touch(world: &str, mesh: &str) {
    let observed =
        |point: &str| format!("[output.points.below]\nbody = \"upper\"\npoint = {point}\nstress = true\n");
    let largest = |text: &str, component: usize| {
        let recording = run(text);
        let stresses = recording.samples.iter().map(|sample| sample.points[0].state.stress[component]);
        stresses.fold(0.0, f64::min)
    };
    let ball = splines("upper", "axisymmetric", 1.0);
    let wanted = largest(&format!("{WORLD}{ball}{}", observed("[0.0, -9.0e-3]")), 1);
    let ball = meshed("upper", mesh, 1.0);
    let found = largest(&format!("{world}{ball}{}", observed("[0.0, 0.0, -9.0e-3]")), 2);
    println!("{mesh}: {:.1} MPa, splines {:.1} MPa", 1e-6 * found, 1e-6 * wanted);
    // Quadratic elements of 0.4 contact radii: stress averaged at their nodes is off by the square of that over a small number, forces by 1 %.
    assert!((found / wanted - 1.0).abs() < 0.05, "{mesh}: {found:e} {wanted:e}");
}

#[test]
#[ignore = "second tier: a minute"]
fn a_coarse_ball_of_tetrahedra_is_divided_where_it_hits_a_plane() {
    let recording = run(&format!("{}{}", adaptive(), meshed("upper", "ten_tet10", 1.0)));
    compare("ten tet10 across", &recording, [1e-2, 1e-2]);
    // Sides of a/5: (5/12) (h/a)^2 is below 2 %, and contacts of a tenth of the ball's radius are another per cent from Hertz' theory.
    check_pressure("ten tet10 across", &recording, [0.05, 0.05, 0.1]);
}

#[test]
#[ignore = "second tier: minutes"]
fn coarse_balls_are_divided_where_they_hit_each_other() {
    let world = adaptive().replace("target_body = \"floor\"", "target_body = \"lower\"");
    for [upper, lower] in [["ten_hex20", "ten_tet10"], ["ten_tet10", "ten_hex20"]] {
        let (own, other) = (meshed("upper", upper, 1.0), meshed("lower", lower, -1.0));
        let (recording, name) = (run(&format!("{world}{own}{other}")), format!("{upper} on {lower}"));
        compare(&name, &recording, [1e-2, 1e-2]);
        check_momenta(&name, &recording);
    }
}

#[test]
#[ignore = "second tier: minutes"]
fn a_coarse_ball_and_one_of_splines_are_refined_where_they_hit_each_other_in_either_role() {
    let lower = splines("lower", "solid", -1.0);
    // Without the refinement from the start.
    let (before, after) = (lower.find(", refine").unwrap(), lower.find("}] }").unwrap());
    let lower = format!("{}{}", &lower[..before], &lower[after + 2..]);
    for (own, target) in [("upper", "lower"), ("lower", "upper")] {
        let world = adaptive().replace("target_body = \"floor\"", &format!("target_body = \"{target}\""));
        let world = world.replace("contact_body = \"upper\"", &format!("contact_body = \"{own}\""));
        let recording = run(&format!("{world}{}{lower}", meshed("upper", "ten_hex20", 1.0)));
        let name = if own == "upper" { "coarse mesh on splines" } else { "splines on coarse mesh" };
        compare(name, &recording, [1e-2, 1e-2]);
        check_momenta(name, &recording);
    }
}

/// Kinds of the warnings of a body of the mesh `file` that does not reach the floor.
fn warnings(world: &str, file: &str) -> Vec<WarningKind> {
    let world = world.replace("end_time = 4.0e-5", "end_time = 1.0e-9");
    let body = meshed("upper", file, 1.0).replace("0.01]", "0.0101]");
    run(&format!("{world}{body}")).warnings.iter().map(|w| w.kind).collect()
}

#[test]
fn a_body_is_told_of_where_its_shape_or_its_elements_limit_the_force() {
    let has = |world: &str, file, kind| warnings(world, file).contains(&kind);
    // Nodes of linear hexahedra, ten across, are too far apart for a smooth surface if they lie on no sphere, and normals of
    // their sides turn by 15 degrees.
    assert!(has(&adaptive(), "ellipsoid_hex8", WarningKind::CoarseShape));
    assert!(!has(&adaptive(), "ten_hex8", WarningKind::CoarseShape));
    assert!(!has(&adaptive(), "ten_hex20", WarningKind::CoarseShape));
    assert!(!has(&adaptive(), "ten_hex20", WarningKind::CoarseTouch));
    assert!(has(WORLD, "ten_hex20", WarningKind::CoarseTouch));
    assert!(!has(WORLD, "ten_hex8", WarningKind::CoarseShape));
}

#[test]
fn a_mesh_whose_pieces_fold_keeps_its_sides() {
    // On top of the element in the middle, ξ and η from -1 to 1, the line η = 0 is moved along η, by the more the nearer to ξ = 1/4: the element is
    // folded at (1/4, 1), where ∂y/∂η is 1 - 2·0.53, between the points at which meshes are looked at, a quarter of an element apart.
    let raw = block(ElementKind::Hex27, [3, 3, 1], |[x, y, z]| {
        let [xi, eta] = [x, y].map(|c| 6.0 * c - 3.0);
        let is_moved = eta.abs() < 1e-9 && xi.abs() < 1.001 && z > 0.999;
        let moved = if is_moved { 0.53 - 0.6 * (xi - 0.25).powi(2) } else { 0.0 };
        [30.0 * x, 30.0 * y + 5.0 * moved, 10.0 * z]
    });
    std::fs::write(files().join("folded.msh"), gmsh(&raw, Form::Binary41)).unwrap();
    let text = "[simulation]\nend_time = 1e-6\n[bodies.block]\nmodel = \"mesh\"\nfile = \"folded.msh\"\nunits = \"mm\"\nmaterial = \"steel\"\n\
                reduction = { modes = 4 }\n[bodies.ball]\nmodel = \"rigid\"\nmaterial = \"steel\"\ngeometry = { shape = \"sphere\", radius = 0.01 }\n\
                position = [0.01625, 0.0198, 0.02000001]\nvelocity = [0.0, 0.0, -1.0]\n[contacts.c]\ncontact_body = \"block\"\ntarget_body = \"ball\"\n";
    assert!(run(text).warnings.iter().any(|w| w.kind == WarningKind::EdgeTouch));
}

fn fault(text: &str, path: &str) -> String {
    let faults = parse(text).unwrap_err();
    let found = faults.iter().find(|f| f.key == path);
    found.unwrap_or_else(|| panic!("no fault at {path}: {faults:?}")).message.clone()
}

#[test]
fn what_a_mesh_does_not_do_is_refused_with_what_does() {
    let with = |line: &str| {
        let world = WORLD.replace("model = \"quasistatic\"", line);
        format!("{world}{}", meshed("upper", "hex20", 1.0))
    };
    let own = fault(&with("model = \"adaptive\"\nmodes = \"own\""), "contacts.impact.modes");
    assert!(own.contains("\"prolonged\""), "{own}");
    let exact = fault(&with("model = \"quasistatic\"\nconstraint = \"exact\""), "contacts.impact.constraint");
    let massless = fault(&with("model = \"massless\""), "contacts.impact.model");
    assert!(massless.contains("more points than the boundary has unknowns"), "{massless}");
    assert!(exact.contains("\"penalty\""), "{exact}");
    let printed = fault(
        &with("model = \"adaptive\"\ninterval = { division = \"printed\" }"),
        "contacts.impact.interval.division",
    );
    assert!(printed.contains("splines"), "{printed}");
    let points = fault(&with("model = \"quasistatic\"\npoints = \"gauss\""), "contacts.impact.points");
    assert!(points.contains("Gauss points"), "{points}");
    let modal =
        with("model = \"quasistatic\"").replace("{ modes = 60 }", "{ method = \"modal\", modes = 60 }");
    let modal = fault(&modal, "contacts.impact.model");
    assert!(modal.contains("craig-bampton"), "{modal}");
}
