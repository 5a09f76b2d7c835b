//! Bodies of plane and axisymmetric finite elements: impacts against those of the same bodies of splines, on floors, on each other and on rigid bodies; rectangles of
//! bilinear elements, which are splines of degree one; what is refused; sections in pictures.

use crate::support::scenarios;
use crate::support::vtu::array;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use adaptive::record::ImpactRecord;

/// Rings of triangles of a disc of 10 mm: sides of 1.25 mm, where contacts are a tenth of that wide, and of one that is fine enough for a contact on its own sides.
pub const RINGS: usize = 8;
const FINE: usize = 24;

/// A disc of triangles with six nodes in millimetres, or the half of it at `x >= 0`, as an input file: six triangles about the middle, each cut into rings.
pub fn round(type_name: &str, is_half: bool, rings: usize) -> String {
    let sectors = if is_half { 3 } else { 6 };
    let (mut numbers, mut text) = (BTreeMap::new(), "*NODE\n".to_owned());
    let mut elements = String::new();
    // Places are counted in half rings and, along them, in parts of a sector.
    let mut node = |ring: usize, along: usize| -> usize {
        let around = sectors * ring;
        let along = if is_half || ring == 0 { along.min(around) } else { along % around };
        let next = numbers.len() + 1;
        *numbers.entry((ring, along)).or_insert_with(|| {
            let radius = 10.0 * ring as f64 / (2 * rings) as f64;
            let angle = (along as f64 / ring.max(1) as f64 - 1.5) * std::f64::consts::FRAC_PI_3;
            let (sin, cos) = angle.sin_cos();
            let x = if is_half && (along == 0 || along == around) { 0.0 } else { radius * cos };
            writeln!(text, "{next}, {x:e}, {:e}", radius * sin).unwrap();
            next
        })
    };
    let mut triangle = |s: usize, corners: [[usize; 2]; 3]| {
        let middle = |a: usize, b: usize| [0, 1].map(|d| (corners[a][d] + corners[b][d]) / 2);
        let all = [corners[0], corners[1], corners[2], middle(0, 1), middle(1, 2), middle(2, 0)];
        let nodes = all.map(|[ring, along]| node(ring, s * ring + along).to_string());
        let number = elements.lines().count() + 1;
        writeln!(elements, "{number}, {}", nodes.join(", ")).unwrap();
    };
    for s in 0..sectors {
        for ring in 0..rings {
            for k in 0..=ring {
                let [i, o, k] = [2 * ring, 2 * ring + 2, 2 * k];
                triangle(s, [[i, k], [o, k], [o, k + 2]]);
                if k < i {
                    triangle(s, [[i, k], [o, k + 2], [i, k + 2]]);
                }
            }
        }
    }
    format!("{text}*ELEMENT, TYPE={type_name}, ELSET=disc\n{elements}")
}

/// What a round body is made of.
#[derive(Clone, Copy, PartialEq)]
enum Made {
    Mesh,
    Splines,
    Rigid,
}

/// A steel disc, or ball, at the height `height` \[mm\], `speed` fast upwards \[m/s\].
fn body(name: &str, made: Made, is_ball: bool, [height, speed]: [f64; 2]) -> String {
    let at = |value: f64| if is_ball { [0.0, 0.0, value] } else { [0.0, value, 0.0] };
    let (model, shape, file) =
        if is_ball { ("axisymmetric", "sphere", "half.inp") } else { ("plane-strain", "disc", "disc.inp") };
    let shape = format!("geometry = {{ shape = \"{shape}\", radius = 10.0e-3 }}\n");
    let made_of = match made {
        Made::Mesh => format!("model = \"{model}\"\nfile = \"{file}\"\nunits = \"mm\"\n"),
        Made::Splines => format!("model = \"{model}\"\n{shape}"),
        Made::Rigid => {
            let motion = if is_ball { "axial" } else { "planar" };
            format!("model = \"rigid\"\nmotion = \"{motion}\"\n{shape}")
        }
    };
    format!(
        "[bodies.{name}]\nmaterial = \"steel\"\nposition = {:?}\nvelocity = {:?}\n{made_of}",
        at(1e-3 * height),
        at(speed)
    )
}

fn impact(folder: &Path, bodies: &str, is_ball: bool, keys: &str) -> ImpactRecord {
    let end = if is_ball { 1.2e-4 } else { 4e-5 };
    let contact = "[contacts.c]\ncontact_body = \"upper\"\ntarget_body = \"lower\"\n";
    let text = format!("[simulation]\nend_time = {end:e}\n{bodies}{contact}{keys}");
    let found = scenarios::run(&scenarios::valid(folder, &text, &[]));
    assert!(found.energy_drift() < 1e-5, "{:e}", found.energy_drift());
    found.impacts[0]
}

fn files(name: &str) -> std::path::PathBuf {
    let folder = scenarios::folder(name);
    std::fs::write(folder.join("disc.inp"), round("CPE6", false, RINGS)).unwrap();
    std::fs::write(folder.join("half.inp"), round("CAX6", true, RINGS)).unwrap();
    folder
}

/// Peak and duration within half a per cent, the impulse to more digits: it is that of the masses and the waves that stay.
fn check_alike(what: &str, found: &ImpactRecord, wanted: &ImpactRecord) {
    let duration = |i: &ImpactRecord| i.end - i.start;
    let error = |a: f64, b: f64| (a / b - 1.0).abs();
    let all = [
        error(found.peak_force, wanted.peak_force),
        error(duration(found), duration(wanted)),
        error(found.impulse, wanted.impulse),
    ];
    println!("{what}: {:.2} N, {:.2} N; {all:?}", found.peak_force, wanted.peak_force);
    assert!(all[0] < 5e-3 && all[1] < 5e-3 && all[2] < 3e-4, "{what}: {all:?}");
}

fn floor(is_ball: bool) -> String {
    let normal = if is_ball { "[0.0, 0.0, 1.0]" } else { "[0.0, 1.0, 0.0]" };
    format!("[bodies.lower]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\nnormal = {normal}\n")
}

#[test]
fn discs_and_balls_of_elements_fall_as_those_of_splines_do() {
    let folder = files("plane_meshes");
    for is_ball in [false, true] {
        let fall = |made| {
            let bodies = body("upper", made, is_ball, [10.0, -0.1]) + &floor(is_ball);
            impact(&folder, &bodies, is_ball, "")
        };
        check_alike(if is_ball { "ball" } else { "disc" }, &fall(Made::Mesh), &fall(Made::Splines));
    }
}

#[test]
fn discs_and_balls_of_elements_meet_each_other_as_those_of_splines_do() {
    meet_alike("plane_mesh_pair", &[("both", [Made::Mesh; 2], [Made::Splines; 2])]);
}

#[test]
#[ignore = "second tier: eight seconds"]
fn discs_and_balls_of_elements_meet_bodies_of_other_kinds_as_those_of_splines_do() {
    meet_alike(
        "plane_mesh_pairs",
        &[
            ("upper", [Made::Mesh, Made::Splines], [Made::Splines; 2]),
            ("lower", [Made::Splines, Made::Mesh], [Made::Splines; 2]),
            ("on a rigid one", [Made::Mesh, Made::Rigid], [Made::Splines, Made::Rigid]),
        ],
    );
}

/// Pairs of discs and of balls, upper and lower, with others to compare with; with friction where there is a tangent.
fn meet_alike(folder: &str, pairs: &[(&str, [Made; 2], [Made; 2])]) {
    let folder = files(folder);
    for is_ball in [false, true] {
        let meet = |[upper, lower]: [Made; 2]| {
            let bodies =
                body("upper", upper, is_ball, [10.0, -0.05]) + &body("lower", lower, is_ball, [-10.0, 0.05]);
            let bodies = if is_ball { bodies } else { bodies.replace("[0.0, -0.05,", "[0.02, -0.05,") };
            impact(&folder, &bodies, is_ball, if is_ball { "" } else { "friction = 0.2\n" })
        };
        for (what, pair, wanted) in pairs {
            check_alike(&format!("{what}, ball: {is_ball}"), &meet(*pair), &meet(*wanted));
        }
    }
}

/// Contact on the mesh as it is, over a width that is given; two and a half sides on the contact radius make the force right to a per cent.
#[test]
fn a_contact_may_stay_on_the_mesh_as_it_is() {
    let folder = files("plane_mesh_static");
    std::fs::write(folder.join("half.inp"), round("CAX6", true, FINE)).unwrap();
    let fall = |made, keys: &str| {
        impact(&folder, &(body("upper", made, true, [10.0, -10.0]) + &floor(true)), true, keys)
    };
    let keys = "model = \"quasistatic\"\ninterval = { width = 3.0e-3 }\n";
    let (found, wanted) = (fall(Made::Mesh, keys), fall(Made::Splines, ""));
    assert!((found.peak_force / wanted.peak_force - 1.0).abs() < 0.01, "{found:?} {wanted:?}");
    assert!((found.impulse / wanted.impulse - 1.0).abs() < 0.001, "{found:?} {wanted:?}");
}

/// A rectangle of 40 by 10 mm in 8 by 2 bilinear elements, in metres.
fn rectangle() -> String {
    let mut text = "*NODE\n".to_owned();
    for k in 0..27 {
        let (i, j) = (k % 9, k / 9);
        writeln!(text, "{}, {:e}, {:e}", k + 1, 5e-3 * f64::from(i) - 0.02, 5e-3 * f64::from(j) - 5e-3)
            .unwrap();
    }
    text += "*ELEMENT, TYPE=CPS4, ELSET=bar\n";
    for k in 0..16 {
        let first = k % 8 + 9 * (k / 8) + 1;
        writeln!(text, "{}, {}, {}, {}, {}", k + 1, first, first + 1, first + 10, first + 9).unwrap();
    }
    text + "*NSET, NSET=left\n1, 10, 19\n*NSET, NSET=right\n9, 18, 27\n"
}

/// The rectangle, of elements or of splines of degree one on the same net.
fn bar(folder: &Path, is_mesh: bool, keys: &str) -> String {
    std::fs::write(folder.join("bar.inp"), rectangle()).unwrap();
    let made_of = if is_mesh {
        "file = \"bar.inp\"\nunits = \"m\""
    } else {
        "geometry = { shape = \"rectangle\", size = [40.0e-3, 10.0e-3] }\ndiscretisation = { degree = 1, elements = [8, 2] }"
    };
    format!(
        "[bodies.upper]\nmodel = \"plane-stress\"\nthickness = 5.0e-3\nmaterial = \"steel\"\nreduction = {{ modes = 20 }}\n{made_of}\n{keys}\n"
    )
}

/// Bilinear elements are splines of degree one, and have the same points on their whole surface.
#[test]
fn faces_and_corners_of_rectangles_meet_a_floor_as_those_of_splines_do() {
    let folder = scenarios::folder("plane_rectangles");
    for (what, turn) in [("face", 0.0_f64), ("corner", 30.0)] {
        let (sin, cos) = turn.to_radians().sin_cos();
        let keys = format!(
            "position = [0.0, {:e}, 0.0]\norientation_deg = [0.0, 0.0, {turn}]\nvelocity = [0.0, -0.1, 0.0]",
            0.02 * sin + 0.005 * cos + 1e-7
        );
        let fall = |is_mesh| impact(&folder, &(bar(&folder, is_mesh, &keys) + &floor(false)), false, "");
        let [a, b] = [true, false].map(fall);
        println!(
            "{what}: {:.8e} {:.8e} N, {:.8e} {:.8e} N s",
            a.peak_force, b.peak_force, a.impulse, b.impulse
        );
        // As of boxes of hexahedra: the same model but for round-off, which stiff springs make more of in single forces.
        assert!((a.impulse / b.impulse - 1.0).abs() < 1e-5, "{what}: {:e} {:e}", a.impulse, b.impulse);
        assert!(
            (a.peak_force / b.peak_force - 1.0).abs() < 1e-4,
            "{what}: {:e} {:e}",
            a.peak_force,
            b.peak_force
        );
    }
}

/// The same of a cylinder that falls on its end: `nr` by `nz` elements, points that integrate with the radius.
#[test]
fn the_end_of_a_cylinder_meets_a_floor_as_that_of_splines_does() {
    let folder = scenarios::folder("plane_cylinder");
    let (nr, nz) = (5, 10);
    let mut text = "*NODE\n".to_owned();
    for k in 0..(nr + 1) * (nz + 1) {
        let (i, j) = (k % (nr + 1), k / (nr + 1));
        writeln!(text, "{}, {:e}, {:e}", k + 1, 2e-3 * f64::from(i), 2e-3 * f64::from(j)).unwrap();
    }
    text += "*ELEMENT, TYPE=CAX4, ELSET=bar\n";
    for k in 0..nr * nz {
        let first = k % nr + (nr + 1) * (k / nr) + 1;
        let next = first + nr + 1;
        writeln!(text, "{}, {first}, {}, {}, {next}", k + 1, first + 1, next + 1).unwrap();
    }
    std::fs::write(folder.join("rod.inp"), text).unwrap();
    let fall = |is_mesh: bool| {
        let made_of = if is_mesh {
            "file = \"rod.inp\"\nunits = \"m\"".to_owned()
        } else {
            format!(
                "geometry = {{ shape = \"rod\", radius = 10.0e-3, length = 20.0e-3 }}\ndiscretisation = {{ degree = 1, elements = [{nr}, {nz}] }}"
            )
        };
        let rod = format!(
            "[bodies.upper]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\nreduction = {{ modes = 20 }}\nposition = [0.0, 0.0, 1e-7]\n\
             velocity = [0.0, 0.0, -0.1]\n{made_of}\n"
        );
        impact(&folder, &(rod + &floor(true)), true, "")
    };
    let [a, b] = [true, false].map(fall);
    println!("end: {:.8e} {:.8e} N, {:.8e} {:.8e} N s", a.peak_force, b.peak_force, a.impulse, b.impulse);
    // As above.
    assert!((a.impulse / b.impulse - 1.0).abs() < 1e-5, "{:e} {:e}", a.impulse, b.impulse);
    assert!((a.peak_force / b.peak_force - 1.0).abs() < 1e-4, "{:e} {:e}", a.peak_force, b.peak_force);
}

/// Held at a set of nodes as at the face of the shape: same frequencies of the system.
#[test]
fn plane_meshes_are_held_at_their_sets() {
    let folder = scenarios::folder("plane_held");
    let frequencies = |is_mesh: bool| {
        let face = if is_mesh { "left" } else { "x-" };
        let joint = format!(
            "[joints.hold]\ntype = \"fixed\"\nparent = {{ body = \"ground\" }}\nchild = {{ body = \"upper\", face = \"{face}\" }}\n"
        );
        let text = format!("[simulation]\nend_time = 1e-4\n{}{joint}", bar(&folder, is_mesh, ""));
        scenarios::system_frequencies(&scenarios::valid(&folder, &text, &[]))
    };
    let [meshed, splines] = [true, false].map(frequencies);
    // The same matrices and the same points of the face; modes are found to 1e-9.
    for (a, b) in meshed.iter().zip(&splines).take(6) {
        assert!((a / b - 1.0).abs() < 1e-6, "{a} {b}");
    }
}

#[test]
fn what_does_not_go_with_a_mesh_in_the_plane_is_told() {
    let folder = files("plane_mesh_faults");
    let faults = |text: &str| {
        let list =
            scenarios::parse(&folder, &format!("[simulation]\nend_time = 1e-4\n{text}"), &[]).unwrap_err();
        list.iter().map(|fault| format!("{}: {}\n", fault.key, fault.message)).collect::<String>()
    };
    let mesh = body("upper", Made::Mesh, false, [10.0, -0.1]);
    let both = faults(&(mesh.clone() + "geometry = { shape = \"disc\", radius = 1.0 }\n"));
    assert!(both.contains("bodies.upper.file") && both.contains("without \"geometry\""), "{both}");
    let fine = faults(&(mesh.clone() + "discretisation = { elements = 4 }\n"));
    assert!(fine.contains("bodies.upper.discretisation"), "{fine}");
    let solid = faults(&mesh.replace("plane-strain", "mesh"));
    assert!(solid.contains("its elements are plane") && solid.contains("\"plane-stress\""), "{solid}");
    let without = faults(&mesh.replace("units = \"mm\"\n", ""));
    assert!(without.contains("units"), "{without}");
    let half = faults(&mesh.replace("plane-strain", "axisymmetric").replace("0.01, 0.0]", "0.0, 0.01]"));
    assert!(half.contains("lies at x >= 0"), "{half}");
    let none = faults(&mesh.replace("file = \"disc.inp\"\nunits = \"mm\"\n", ""));
    assert!(none.contains("or \"file\", a mesh in the plane"), "{none}");
}

/// `fbimpact new --section` puts the section above its floor, in the axes of its model; the scenario is valid as it stands.
#[test]
fn new_writes_a_scenario_of_a_section() {
    let folder = files("plane_mesh_new");
    for (file, section, up) in [("disc.inp", "plane-stress", 1), ("half.inp", "axisymmetric", 2)] {
        let path = folder.join(format!("{section}.toml"));
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_fbimpact"))
            .arg("new")
            .arg(&path)
            .arg("--mesh")
            .arg(folder.join(file))
            .args(["--section", section, "--units", "mm", "--force"])
            .output()
            .unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let text = std::fs::read_to_string(&path).unwrap();
        let scenario = scenarios::valid(&folder, &text, &[]);
        let position = scenario.run.bodies[0].motion.position;
        // The gap is a ten-thousandth of the diagonal.
        assert!((position[up] - 0.01 - 1e-4 * scenario.run.bodies[0].kind.diagonal().unwrap()).abs() < 1e-9);
        assert!(scenario.run.bodies[0].motion.velocity[up] < 0.0);
    }
}

/// Pictures of a scenario: the section as it is, with VTK's triangles of six nodes, and turned around its axis, with the volume of the ball.
#[test]
fn sections_are_drawn_as_they_are_and_turned_around() {
    let folder = files("plane_mesh_pictures");
    let text = format!(
        "[simulation]\nend_time = 1e-4\n{}{}",
        body("upper", Made::Mesh, true, [10.0, -0.1]),
        floor(true)
    );
    std::fs::write(folder.join("ball.toml"), text).unwrap();
    let draw = |target: &str, more: &[&str]| {
        let (from, to) = (folder.join("ball.toml"), folder.join(target));
        let run = std::process::Command::new(env!("CARGO_BIN_EXE_fbimpact"))
            .arg("export")
            .arg(from)
            .arg("--vtk")
            .arg(&to)
            .args(more)
            .output()
            .unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let files = std::fs::read_dir(to.join("ball")).unwrap().map(|file| file.unwrap().path());
        let of_body =
            |path: &std::path::PathBuf| path.file_name().unwrap().to_string_lossy().contains("bodies");
        let file = files.into_iter().find(of_body).expect("the ball");
        ["types", "connectivity", "Points"].map(|name| array(&file, name))
    };
    let [types, connectivity, points] = draw("section", &[]);
    assert_eq!((types.clone(), connectivity.len()), (vec![22.0; types.len()], 6 * types.len()));
    let [wedges, of_wedges, around] = draw("around", &["--revolve"]);
    // Four linear parts a triangle, 24 sectors.
    assert_eq!(wedges, vec![13.0; 24 * 4 * types.len()]);
    assert_eq!(around.len(), 24 * points.len());
    let place = |n: f64| nalgebra::Vector3::from_column_slice(&around[3 * n as usize..][..3]);
    let volume = |of: &[f64]| {
        let p: Vec<_> = of.iter().map(|n| place(*n)).collect();
        let tetrahedron = |i: [usize; 4]| {
            let [a, b, c, d] = i.map(|i| p[i]);
            (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
        };
        tetrahedron([0, 1, 2, 3]) + tetrahedron([1, 2, 3, 4]) + tetrahedron([2, 3, 4, 5])
    };
    let total: f64 = of_wedges.as_chunks::<6>().0.iter().map(|of| volume(of)).sum();
    // A polygon of 24 corners in the circle, chords of 16 parts in its half.
    let wanted = 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
    assert!((total.abs() / wanted - 1.0).abs() < 0.02, "{total:e}");
}
