//! Rows of impacts and peaks mean what they say, however the run ends and whatever is stored.

use adaptive::record::PeakOf;

use super::{impacts, recorded};

const BAR: &str = r#"
[simulation]
end_time = 1.2e-4
[bodies.ball]
model = "plane-stress"
thickness = 0.01
material = "steel"
geometry = { shape = "disc", radius = 0.01 }
position = [-0.0100001, 0.0, 0.0]
velocity = [1.0, 0.0, 0.0]
[joints.j0]
type = "planar"
axis = [0.0, 0.0, 1.0]
reference = [1.0, 0.0, 0.0]
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "b1", face = "x-" }
[contacts.c]
contact_body = "ball"
target_body = "b1"
"#;

/// A bar rebounds as a bar, whether it is one body or two that are joined.
#[test]
fn bodies_that_are_fixed_to_each_other_rebound_as_one() {
    let bar = |name: &str, length: f64| {
        format!(
            "[bodies.{name}]\nmodel = \"plane-stress\"\nthickness = 0.01\nmaterial = \"steel\"\n\
             geometry = {{ shape = \"rectangle\", size = [{length:?}, 0.01] }}\n"
        )
    };
    let joint = "[joints.j]\ntype = \"fixed\"\nparent = { body = \"b1\", face = \"x+\" }\nchild = { body = \"b2\", face = \"x-\" }\n";
    let restitution = |text: &str| impacts(&recorded(text, &[]))[0].restitution;
    let whole = restitution(&(BAR.to_owned() + &bar("b1", 0.2)));
    let halves = restitution(&[BAR, &bar("b1", 0.1), &bar("b2", 0.1), joint].concat());
    println!("{whole} {halves}");
    // Of other elements and modes; by the motion of the half alone it was 17 % more.
    assert!((halves / whole - 1.0).abs() < 5e-3, "{whole} {halves}");
}

/// A row is that of the whole impact, whether the run goes on behind it or not; if it ends before, it has no ratio.
#[test]
fn a_run_that_ends_after_an_impact_has_its_whole_row() {
    let text = r#"
[simulation]
end_time = 1.6e-4
[bodies.a]
model = "plane-stress"
thickness = 0.005
material = "steel"
geometry = { shape = "disc", radius = 0.012 }
position = [0.0, 0.0120001, 0.0]
velocity = [0.0, -0.3, 0.0]
angular_velocity = [0.0, 0.0, 12.5]
[bodies.b]
model = "plane-stress"
thickness = 0.005
material = "aluminium"
geometry = { shape = "rectangle", size = [0.072, 0.012] }
position = [0.0, -0.006, 0.0]
[contacts.c]
contact_body = "a"
target_body = "b"
"#;
    let row = |set: &[&str]| impacts(&recorded(text, set))[0];
    let (long, stopped) = (row(&[]), row(&["simulation.stop_after_impacts=1"]));
    assert!(long.restitution > 0.8, "{long:?}");
    let same = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-12; // the same steps
    assert!(
        same(long.restitution, stopped.restitution) && same(long.impulse, stopped.impulse),
        "{long:?} {stopped:?}"
    );
    // Between the first touch of it, which lasts for 27 µs, and the second.
    let short = row(&["simulation.end_time=3.2e-5"]);
    assert!(short.restitution.is_nan() && short.end < 3.2e-5, "{short:?}");
}

/// A mass that meets two stops 8 and 10 ms after the start, one for each direction: `v t`.
#[test]
fn hits_of_stops_begin_where_they_are_met() {
    let text = r#"
[simulation]
end_time = 0.05
[bodies.m]
model = "rigid"
mass = 1.0
inertia = [1e-3, 1e-3, 1e-3]
[joints.s]
type = "planar"
axis = [0.0, 0.0, 1.0]
reference = [1.0, 0.0, 0.0]
parent = { body = "ground", point = [0.0, 0.0, 0.0] }
child = { body = "m", point = [0.0, 0.0, 0.0] }
velocities = [1.0, 0.5, 0.0]
[[joints.s.stops]]
coordinate = 0
upper = 0.01
stiffness = 1e6
[[joints.s.stops]]
coordinate = 1
upper = 0.004
stiffness = 2e6
"#;
    let rows = impacts(&recorded(text, &[]));
    // Undamped: half a period of a mass on a spring.
    for (row, (start, stiffness, speed)) in rows.iter().zip([(8e-3, 2e6_f64, 0.5), (10e-3, 1e6, 1.0)]) {
        let duration = std::f64::consts::PI / stiffness.sqrt();
        let errors = [
            row.start / start,
            (row.end - row.start) / duration,
            row.approach_velocity / speed,
            row.restitution,
        ];
        // Steps follow the force of a hit to 1e-6 (TR-BDF2).
        errors.iter().for_each(|ratio| assert!((ratio - 1.0).abs() < 1e-4, "{errors:?}"));
    }
    assert_eq!(rows.len(), 2);
}

/// A ball between two plates, where ten steps are longer than the flight from one to the other.
#[test]
fn impacts_that_are_far_apart_end_their_phases() {
    let plate = |name: &str, z: f64, normal: f64| {
        format!(
            "[bodies.{name}]\nmodel = \"rigid\"\ngeometry = {{ shape = \"plane\" }}\nposition = [0.0, 0.0, {z:?}]\n\
             normal = [0.0, 0.0, {normal:?}]\n[contacts.{name}]\ncontact_body = \"ball\"\ntarget_body = \"{name}_\"\nmodel = \"hertz\"\n"
        )
        .replace(&format!("[bodies.{name}]"), &format!("[bodies.{name}_]"))
    };
    let text = "[simulation]\nend_time = 2e-2\n[bodies.ball]\nmodel = \"rigid\"\nmaterial = \"steel\"\n\
                geometry = { shape = \"sphere\", radius = 5e-3 }\nvelocity = [0.0, 0.0, 1.0]\n"
        .to_owned();
    let recording = recorded(&(text + &plate("below", -5.5e-3, 1.0) + &plate("above", 5.5e-3, -1.0)), &[]);
    let mut rows = impacts(&recording);
    rows.retain(|row| row.end < 2e-2); // the end of the run cuts the last one off
    assert!(rows.len() >= 15, "{} rows", rows.len());
    let peak = rows[0].peak_force;
    // Parabolas through steps of 1e-8.
    rows.iter().for_each(|row| assert!((row.peak_force / peak - 1.0).abs() < 1e-3, "{row:?}"));
    assert!(recording.phases.len() >= 2 * rows.len() - 1, "{} phases", recording.phases.len());
}

/// A clamped strip that is shaken: largest moment at the clamp.
#[test]
fn peaks_of_reactions_do_not_depend_on_when_states_are_stored() {
    let text = "[simulation]\nend_time = 0.02\n\
[bodies.beam]\nmodel = \"plane-stress\"\nthickness = 0.025\nmaterial = \"aluminium\"\n\
geometry = { shape = \"rectangle\", size = [0.3, 8e-3] }\ndamping = { modal = 0.01 }\nreduction = { modes = 4 }\n\
[joints.clamp]\ntype = \"fixed\"\nparent = { body = \"ground\" }\nchild = { body = \"beam\", face = \"start\", coupling = \"rigid\" }\n\
[loads.push]\nbody = \"beam\"\npoint = [0.05, 0.004]\nradius = 3e-3\n\
force_y = { kind = \"harmonic\", amplitude = 100.0, frequency = 300.0 }\n";
    let peak = |interval: f64| {
        let recording = recorded(text, &[&format!("output.free_interval={interval:?}")]);
        let moments = recording.peaks.iter().find(|peak| peak.of == PeakOf::ReactionMoment).expect("a joint");
        let stored =
            recording.samples.iter().map(|s| nalgebra::Vector3::from(s.joints[0].reaction_moment).norm());
        (moments.value, stored.fold(0.0, f64::max))
    };
    let ((rare, shown), (often, all)) = (peak(3e-3), peak(1e-5));
    println!("{rare} N m of all steps, {shown} stored; {often}, {all}");
    // A step of the fourth order resolves a period by thirty and more: its ends miss a top by (π/30)²/2 at most.
    assert!((rare / all - 1.0).abs() < 6e-3 && (often / all - 1.0).abs() < 6e-3, "{rare} {often} {all}");
    assert!(shown < 0.97 * all, "{shown} {all}");
}
