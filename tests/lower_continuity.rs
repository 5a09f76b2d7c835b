//! Bodies of splines whose patches have lines of lower continuity inside, or close on themselves: contact there is as anywhere else (docs/decisions/0051).
//!
//! The places of one circle are the same touch. Rings of four quarter arcs in one patch have a seam at 0 and double knots at 90, 180 and 270 degrees; 33 degrees
//! lie inside an arc, farther from its ends than a zone is wide.

use crate::support::scenarios::{self, run};
use adaptive::run::recording::Recording;
use iga_core::files::write_gismo;
use iga_core::nurbs::Patch;
use iga_core::splines::knots::KnotVector;
use std::path::Path;

/// Difference of peak forces over the places of a circle: the meshes of a circle of rational arcs are not the same at every angle, and eight elements across a
/// zone leave some 1e-3 open (docs/decisions/0019).
const PLACES: f64 = 3e-3;
/// Inner and outer radius \[m\].
const RADII: [f64; 2] = [5e-3, 10e-3];

/// A ring in one patch around, of `depth` \[m\] or in the plane.
fn ring(depth: Option<f64>) -> Patch {
    const S: f64 = std::f64::consts::FRAC_1_SQRT_2;
    const CIRCLE: [[f64; 3]; 9] = [
        [1.0, 0.0, 1.0],
        [1.0, 1.0, S],
        [0.0, 1.0, 1.0],
        [-1.0, 1.0, S],
        [-1.0, 0.0, 1.0],
        [-1.0, -1.0, S],
        [0.0, -1.0, 1.0],
        [1.0, -1.0, S],
        [1.0, 0.0, 1.0],
    ];
    let around = vec![0.0, 0.0, 0.0, 0.25, 0.25, 0.5, 0.5, 0.75, 0.75, 1.0, 1.0, 1.0];
    let line = KnotVector::uniform(1, 1).expect("knots");
    let mut knots = vec![KnotVector::new(2, around).expect("knots"), line.clone()];
    let heights = depth.map_or_else(|| vec![0.0], |depth| vec![0.0, depth]);
    // In the plane outwards last would be left-handed.
    let radii = if depth.is_some() { RADII } else { [RADII[1], RADII[0]] };
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    for z in heights {
        for r in radii {
            for [x, y, w] in CIRCLE {
                points.push([r * x, r * y, z]);
                weights.push(w);
            }
        }
    }
    if depth.is_some() {
        knots.push(line);
    }
    Patch::new(knots, points, weights).expect("a ring")
}

/// The keys of a patch.
fn keys(patch: &Patch) -> String {
    let degrees: Vec<usize> = patch.knots().iter().map(KnotVector::degree).collect();
    let knots: Vec<&[f64]> = patch.knots().iter().map(KnotVector::knots).collect();
    let n = patch.dimension();
    let points: Vec<&[f64]> = patch.control_points().iter().map(|p| &p[..n]).collect();
    let weights = patch.weights();
    format!(
        "shape = \"nurbs\"\ndegrees = {degrees:?}\nknots = {knots:?}\nweights = {weights:?}\ncontrol_points = {points:?}"
    )
}

/// The keys of a file of G+Smo with the patch, which is written into `folder`.
fn gismo(folder: &Path, name: &str, patch: &Patch) -> String {
    let text = write_gismo(std::slice::from_ref(patch), 1e-3);
    std::fs::write(folder.join(name), text).expect("written");
    format!("shape = \"nurbs\"\nfile = \"{name}\"\nunits = \"mm\"")
}

/// A disc hits the plane ring `geometry` at `angle` degrees of it; `own`: the body with the contact points.
fn in_the_plane(folder: &Path, geometry: &str, angle: f64, own: &str) -> Recording {
    let other = if own == "ring" { "disc" } else { "ring" };
    let text = format!(
        "[simulation]\nend_time = 8e-5\nstop_after_impacts = 1\n\
         [bodies.ring]\nmodel = \"plane-strain\"\nthickness = 1.0\nmaterial = \"steel\"\norientation_deg = [0, 0, {}]\n\
         discretisation = {{ elements = [16, 3] }}\nreduction = {{ modes = 20 }}\n[bodies.ring.geometry]\n{geometry}\n\
         [bodies.disc]\nmodel = \"plane-strain\"\nthickness = 1.0\nmaterial = \"steel\"\ngeometry = {{ shape = \"disc\", radius = 5e-3 }}\n\
         position = [15.0001e-3, 0, 0]\nvelocity = [-0.2, 0, 0]\ndiscretisation = {{ elements = 8 }}\nreduction = {{ modes = 20 }}\n\
         [contacts.c]\ncontact_body = \"{own}\"\ntarget_body = \"{other}\"\n",
        -angle
    );
    run(&scenarios::valid(folder, &text, &[]))
}

/// Peak force and impulse of the only impact.
fn peak(what: &str, recording: &Recording) -> [f64; 2] {
    let [impact] = &recording.impacts[..] else { panic!("{what}: {} impacts", recording.impacts.len()) };
    [impact.peak_force, impact.impulse]
}

fn assert_alike(what: &str, found: [f64; 2], expected: [f64; 2]) {
    let [force, impulse] = [0, 1].map(|i| found[i] / expected[i] - 1.0);
    println!("{what}: {:.3} N, {force:+.1e}; impulse {impulse:+.1e}", found[0]);
    assert!(force.abs() < PLACES && impulse.abs() < PLACES, "{what}: {found:?} {expected:?}");
}

#[test]
fn a_ring_is_hit_on_its_seam_and_its_double_knots_as_anywhere_else() {
    let (folder, patch) = (scenarios::folder("lower_continuity"), ring(None));
    let own = keys(&patch);
    let file = gismo(&folder, "ring.xml", &patch);
    let expected = peak("33", &in_the_plane(&folder, &own, 33.0, "disc"));
    for (geometry, angle, body) in [
        (&own, 0.0, "disc"),
        (&own, 0.0, "ring"),
        (&own, 90.0, "disc"),
        (&own, 1.0, "disc"),
        (&file, 90.0, "ring"),
    ] {
        let what = format!("{angle} degrees, points on the {body}");
        assert_alike(&what, peak(&what, &in_the_plane(&folder, geometry, angle, body)), expected);
    }
}

#[test]
#[ignore = "second tier: minutes"]
fn a_ring_is_hit_at_every_degree_alike() {
    let (folder, patch) = (scenarios::folder("lower_continuity_degrees"), ring(None));
    let geometries = [keys(&patch), gismo(&folder, "ring.xml", &patch)];
    let expected = peak("33", &in_the_plane(&folder, &geometries[0], 33.0, "disc"));
    // Half of the ring, about a double knot and about the seam.
    for k in -45..=135 {
        let geometry = &geometries[usize::from(k % 2 == 0)];
        let body = if k % 4 < 2 { "disc" } else { "ring" };
        let what = format!("{k} degrees, points on the {body}");
        assert_alike(&what, peak(&what, &in_the_plane(&folder, geometry, f64::from(k), body)), expected);
    }
}

#[test]
#[ignore = "second tier: minutes"]
fn a_tube_is_hit_by_a_ball_on_its_seam_and_its_double_knots_as_anywhere_else() {
    let (folder, patch) = (scenarios::folder("lower_continuity_tube"), ring(Some(0.02)));
    let geometries = [keys(&patch), gismo(&folder, "tube.xml", &patch)];
    // Twelve elements a zone: 57.16 to 57.23 N, 57.157 and 57.159 N at 0 and 33 degrees with sixteen. Of eight, zones are widened until four to five rows
    // carry the force, not the same at every place: 55.84 and 56.49 N, 2 % and 1 % low, with bands of 1.2 and 0.9 N.
    let hit = |geometry: &str, angle: f64| {
        let text = format!(
            "[simulation]\nend_time = 6e-5\n[bodies.tube]\nmaterial = \"steel\"\norientation_deg = [0, 0, {angle}]\n\
             discretisation = {{ elements = [16, 2, 4] }}\nreduction = {{ modes = 20 }}\n[bodies.tube.geometry]\n{geometry}\n\
             [bodies.ball]\nmaterial = \"steel\"\ngeometry = {{ shape = \"sphere\", radius = 5e-3 }}\n\
             position = [15.0001e-3, 0, 0.01]\nvelocity = [-0.2, 0, 0]\n\
             discretisation = {{ elements = [6, 6, 14] }}\nreduction = {{ modes = 20 }}\n\
             [contacts.c]\ncontact_body = \"ball\"\ntarget_body = \"tube\"\ninterval = {{ elements = 12 }}\n"
        );
        peak("tube", &run(&scenarios::valid(&folder, &text, &[])))
    };
    let expected = hit(&geometries[0], 33.0);
    for (geometry, angle) in [(0, 0.0), (0, 90.0), (1, 0.0), (1, 90.0), (0, 2.0), (0, 88.0)] {
        assert_alike(&format!("tube at {angle} degrees"), hit(&geometries[geometry], angle), expected);
    }
}
