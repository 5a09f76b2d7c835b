//! `fbimpact export SCENARIO.toml` and what `check` says of joints: places in space before any run.

use std::path::{Path, PathBuf};

use crate::support::fbimpact;
use crate::support::vtu::array;
use tempfile::TempDir;

const SCENARIOS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios");

/// An exported scenario: its folder, and block, name and file of every part.
struct Setup {
    _folder: TempDir,
    parts: Vec<(String, String, PathBuf)>,
    said: String,
}

impl Setup {
    fn new(scenario: &str, options: &[&str]) -> Self {
        let folder = TempDir::new().expect("a folder");
        let (file, target) = (format!("{SCENARIOS}/{scenario}.toml"), folder.path().display().to_string());
        let mut arguments = vec!["export", &file, "--vtk", &target];
        arguments.extend(options);
        let (code, out, said) = fbimpact(&arguments);
        assert_eq!(code, 0, "{said}");
        let text = std::fs::read_to_string(out.trim_end()).expect("the list of blocks");
        let value = |line: &str, key: &str| {
            let after = line.split(&format!("{key}=\"")).nth(1).expect("the key");
            after.split('"').next().expect("a value").to_owned()
        };
        let (mut block, mut parts) = (String::new(), Vec::new());
        for line in text.lines() {
            if line.starts_with("<Block ") {
                block = value(line, "name");
            } else if line.starts_with("<DataSet ") {
                parts.push((block.clone(), value(line, "name"), folder.path().join(value(line, "file"))));
            }
        }
        Self { _folder: folder, parts, said }
    }

    fn part(&self, block: &str, name: &str) -> &Path {
        let found = self.parts.iter().find(|(b, n, _)| b == block && n == name);
        &found.unwrap_or_else(|| panic!("{block}/{name} in {:?}", self.parts)).2
    }

    fn points(&self, block: &str, name: &str) -> Vec<[f64; 3]> {
        array(self.part(block, name), "Points").chunks(3).map(|p| [p[0], p[1], p[2]]).collect()
    }

    fn names(&self, block: &str) -> Vec<&str> {
        self.parts.iter().filter(|(b, _, _)| b == block).map(|(_, n, _)| n.as_str()).collect()
    }
}

fn is_near(a: &[f64; 3], b: [f64; 3]) -> bool {
    // Round-off of lengths below one metre.
    a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-14)
}

#[test]
fn pendulum_hangs_as_its_angles_say() {
    let setup = Setup::new("double_pendulum", &[]);
    assert_eq!(setup.names("bodies"), ["left_rod", "left_ball", "right_rod", "right_ball"]);
    let (s, c) = 20.0_f64.to_radians().sin_cos();
    let hinge = [-0.01 - 0.1 * s, 0.0, -0.1 * c];
    let points = setup.points("joints", "left_hinge");
    assert!(is_near(&points[0], hinge) && is_near(&points[1], hinge), "{points:?}");
    // The axis is that of the scenario, y, through the hinge.
    let [from, to] = [points[points.len() - 2], points[points.len() - 1]];
    assert!((from[0] - to[0]).abs() < 1e-15 && (from[2] - to[2]).abs() < 1e-15 && to[1] > from[1] + 1e-3);
    // The observed tip is the end of the rod.
    assert!(is_near(&setup.points("output", "tip")[0], hinge));
    let (s, c) = 21.14_f64.to_radians().sin_cos();
    let centre = [hinge[0] - 0.01 * s, 0.0, hinge[2] - 0.01 * c];
    assert!(is_near(&setup.points("frames", "left_ball")[0], centre));
    // The balls are nearest on the line between their centres, each 10 mm inside of it.
    let gap = array(setup.part("contacts", "balls.gap"), "gap [m]")[0];
    let other = [0.01, 0.0, -0.11];
    let apart = (0..3).map(|k| (centre[k] - other[k]).powi(2)).sum::<f64>().sqrt();
    // The search ends when places move by 1e-9 of the bodies; the distance is flat there.
    assert!((gap - (apart - 0.02)).abs() < 1e-10, "{gap}");
    assert!(array(setup.part("gravity", "gravity"), "gravity [m/s2]") == [0.0, 0.0, -9.81]);
    // Both bodies of the contact are marked, contact body and target.
    let side = |body: &str| array(setup.part("bodies", body), "side of balls")[0] as u8;
    assert_eq!((side("left_ball"), side("right_ball")), (1, 2));
}

#[test]
fn predicted_zone_is_that_of_hertz() {
    let setup = Setup::new("sphere_on_plane", &[]);
    let force = array(setup.part("contacts", "impact.zone"), "predicted peak force [N]")[0];
    // Hertz impact of a sphere on a rigid plane: F = k^(2/5) (5/4 m v²)^(3/5), k = 4/3 √r E*.
    let (r, v, m) = (0.01_f64, 0.1_f64, 4.0 / 3.0 * std::f64::consts::PI * 1e-6 * 2789.0);
    let stiffness = 4.0 / 3.0 * r.sqrt() * 72.8e9 / (1.0 - 0.33 * 0.33);
    let hertz = stiffness.powf(0.4) * (1.25 * m * v * v).powf(0.6);
    // The same law; the mass of the exact shape by quadrature.
    assert!((force / hertz - 1.0).abs() < 1e-9, "{force} against {hertz}");
    let touched = (0.75 * force * r * (1.0 - 0.33 * 0.33) / 72.8e9).cbrt();
    let circle = setup.points("contacts", "impact.zone");
    assert!((circle[0][0].hypot(circle[0][1]) / touched - 1.0).abs() < 1e-12);
    // The plane is the floor, z = 0.
    assert!(setup.points("contacts", "impact.plane").iter().all(|p| p[2].abs() < 1e-16));
    // Exact cells of the shape alone: no model is built, no displacement written.
    let head = std::fs::read(setup.part("bodies", "ball")).expect("a file");
    let head = String::from_utf8_lossy(&head).into_owned();
    assert!(head.contains("RationalWeights=\"RationalWeights\"") && !head.contains("displacement"));
    assert!(array(setup.part("bodies", "ball"), "velocity [m/s]").chunks(3).all(|v| v[2] < -0.0999));
}

#[test]
fn meshes_loads_and_open_loops_are_shown() {
    let setup = Setup::new("connecting_rod", &[]);
    assert_eq!(setup.names("joints"), ["shaft", "pin", "wrist", "cylinder"]);
    assert!(array(setup.part("bodies", "rod"), "types").iter().all(|t| *t as u8 == 25), "20-node hexahedra");
    assert_eq!(array(setup.part("loads", "gas"), "force at the start [N]"), [-200.0, 0.0, 0.0]);
    assert!(is_near(&setup.points("joints", "wrist")[0], [0.1, 0.0, 0.0]));
    // A cylinder that the rod cannot reach: the loop stays open, shown as given.
    let open = Setup::new("connecting_rod", &["--set", "joints.cylinder.parent.point=[0.1,0.5,0.0]"]);
    assert!(
        open.said.contains("joint coordinates as given") && open.said.contains("cylinder"),
        "{}",
        open.said
    );
    let apart = array(open.part("joints", "cylinder"), "held directions apart [m]")[0];
    assert!((apart - 0.5).abs() < 1e-14, "{apart}");
}

#[test]
fn check_tells_where_joints_are_and_which_loops_are_open() {
    let file = format!("{SCENARIOS}/connecting_rod.toml");
    let (code, _, said) = fbimpact(&["check", &file]);
    assert_eq!(code, 0, "{said}");
    let line = "joint \"wrist\", revolute between rod and piston: at (0.1, 0, 0) m, axis (0, 0, 1)\n";
    assert!(said.contains(line), "{said}");
    let (code, _, said) = fbimpact(&["check", &file, "--set", "joints.cylinder.parent.point=[0.1,0.01,0.0]"]);
    assert_eq!(code, 0, "{said}");
    assert!(
        said.contains("its sides are 1.000000e-2 m apart; the bodies are moved until they meet"),
        "{said}"
    );
    let (code, _, said) = fbimpact(&["check", &file, "--set", "joints.cylinder.parent.point=[0.1,0.5,0.0]"]);
    assert_eq!(code, 4, "{said}");
    assert!(
        said.contains("5.000000e-1 m apart, the parent's at (0.1, 0.5, 0), the child's at (0.1, 0, 0)"),
        "{said}"
    );
}

#[test]
fn options_that_have_no_meaning_are_refused() {
    let file = format!("{SCENARIOS}/sphere_on_plane.toml");
    let folder = TempDir::new().expect("a folder");
    let target = folder.path().display().to_string();
    for option in [&["--every", "2"][..], &["--times", "0:1:1"], &["--scale", "5"], &["--bodies", "ball"]] {
        let (code, _, said) = fbimpact(&[&["export", &file, "--vtk", &target], option].concat());
        assert!(code == 2 && said.contains(&format!("{} is for results", option[0])), "{code} {said}");
    }
    let (code, _, said) = fbimpact(&["export", "r.h5", "--vtk", &target, "--set", "title=\"x\""]);
    assert!(code == 2 && said.contains("--set changes scenarios"), "{code} {said}");
}
