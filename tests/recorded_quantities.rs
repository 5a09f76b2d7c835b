//! Quantities that a run records beside the motion: work of driven joints, pressure, energy of overlaps, restitution.

use crate::support::scenarios::{self, run};
use adaptive::run::recording::Recording;
use std::path::Path;

fn recorded(folder: &Path, text: &str) -> Recording {
    run(&scenarios::valid(folder, text, &[]))
}

/// A body of the mass `mass` \[kg\] on a slider that moves to and fro; `friction` \[N\].
fn shaken(mass: f64, (amplitude, frequency): (f64, f64), end: f64, friction: &str) -> Recording {
    let text = format!(
        "[simulation]\nend_time = {end}\n[bodies.t]\nmodel = \"rigid\"\nmass = {mass}\ninertia = [1.0, 1.0, 1.0]\n\
         [joints.j]\ntype = \"prismatic\"\naxis = [0, 1, 0]\nparent = {{ body = \"ground\" }}\n\
         child = {{ body = \"t\", point = [0, 0, 0] }}\n\
         motion = {{ kind = \"harmonic\", amplitude = {amplitude}, frequency = {frequency} }}\n{friction}"
    );
    recorded(Path::new("."), &text)
}

#[test]
fn a_driven_joint_supplies_what_its_body_has_at_any_frequency() {
    for frequency in [50.0, 2e3, 4e3, 9e3, 11e3, 20e3] {
        let found = shaken(1.0, (1e-4, frequency), 0.02, "");
        let largest = found.samples.iter().map(|s| s.energies.kinetic).fold(0.0, f64::max);
        let start = found.samples[0].energies.total();
        let open = found.samples.iter().map(|s| (s.energies.total() - start).abs()).fold(0.0, f64::max);
        // A ledger that closes by as much is called right in the documents.
        assert!(open < 1e-5 * largest, "{frequency} Hz: open by {:e} of the largest energy", open / largest);
    }
}

#[test]
fn friction_of_a_driven_joint_takes_its_force_times_the_way() {
    for (frequency, end) in [(500.0, 0.05), (2e3, 0.05), (2e3, 0.0513), (7e3, 0.02)] {
        let found = shaken(1e-6, (1e-5, frequency), end, "friction = 1.0\n");
        let turns = (4.0 * frequency * end).floor();
        let rest = (std::f64::consts::TAU * frequency * end).sin().abs();
        // Four amplitudes a period; within the last quarter from or towards the middle.
        let way = 1e-5 * (turns + if (turns as u64).is_multiple_of(2) { rest } else { 1.0 - rest });
        let lost = found.samples.last().map_or(0.0, |s| s.energies.dissipated);
        // About each turn friction is less while the velocity is below that of its transition.
        assert!((lost / way - 1.0).abs() < 1e-3, "{frequency} Hz: {lost:e} J on {way:e} m");
    }
}

#[test]
fn plane_bodies_press_each_other_over_the_smaller_thickness() {
    let pressed = |[contact, target]: [&str; 2]| {
        let text = format!(
            "[simulation]\nend_time = 4e-5\n[bodies.b]\nmodel = \"plane-stress\"\nthickness = 0.01\nmaterial = \"steel\"\n\
             geometry = {{ shape = \"disc\", radius = 0.005 }}\nposition = [0, 0.015001, 0]\nvelocity = [0, -0.2, 0]\n\
             [bodies.h]\nmodel = \"plane-stress\"\nthickness = 0.03\nmaterial = \"steel\"\n\
             geometry = {{ shape = \"rectangle\", size = [0.06, 0.02] }}\n\
             [contacts.c]\ncontact_body = \"{contact}\"\ntarget_body = \"{target}\"\n"
        );
        let found = recorded(Path::new("."), &text);
        let contacts = found.samples.iter().map(|s| &s.contacts[0]);
        let peak =
            contacts.clone().max_by(|a, b| a.normal_force.total_cmp(&b.normal_force)).expect("it touches");
        (peak.normal_force, peak.contact_area)
    };
    let [thin, thick] = [pressed(["b", "h"]), pressed(["h", "b"])];
    assert!((thin.0 / thick.0 - 1.0).abs() < 1e-2, "{thin:?} {thick:?}");
    // An element row of some ten in contact.
    assert!((thin.1 / thick.1 - 1.0).abs() < 0.15, "{thin:?} {thick:?}");
}

#[test]
fn an_overlap_of_the_start_is_in_the_first_state() {
    let text = "[simulation]\nend_time = 1e-4\n[bodies.b]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\n\
                geometry = { shape = \"sphere\", radius = 0.01 }\nposition = [0, 0, 0.009999]\n\
                [bodies.p]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\n\
                [contacts.c]\ncontact_body = \"b\"\ntarget_body = \"p\"\ninitial_overlap = 2e-6\n";
    let found = recorded(Path::new("."), text);
    assert!(found.samples[0].time.abs() < f64::EPSILON && found.samples[1].time > 0.0);
    let start = found.samples[0].energies.total();
    assert!(start > 0.0);
    let open = found.samples.iter().map(|s| (s.energies.total() / start - 1.0).abs()).fold(0.0, f64::max);
    // As a ledger that closes in the documents.
    assert!(open < 1e-5, "{open:e}");
    // That the bodies never approach is no penetration: the penalty factor is compared and not raised for ever.
    let raised = found.trials.iter().filter(|t| t.reason.contains("penetration")).count();
    assert_eq!(raised, 0, "{:?}", found.trials.iter().map(|t| &t.reason).collect::<Vec<_>>());
}

#[test]
fn a_ball_that_spins_rebounds_as_fast_as_it_came() {
    let text = "accuracy = \"fast\"\n[simulation]\nend_time = \"0.1 ms\"\n[bodies.floor]\nmodel = \"rigid\"\n\
                geometry = { shape = \"plane\" }\n[bodies.ball]\nmodel = \"solid\"\nmaterial = \"steel\"\n\
                geometry = { shape = \"sphere\", radius = 0.01 }\nposition = [0, 0, 0.010001]\nvelocity = [0, 0, -0.5]\n\
                angular_velocity = [0, 300, 0]\ndiscretisation = { elements = [4, 4, 4] }\nreduction = { modes = 10 }\n\
                [contacts.c]\ncontact_body = \"ball\"\ntarget_body = \"floor\"\n\
                interval = { elements = 8 }\npenalty = { search = \"fixed\" }\n";
    let found = recorded(Path::new("."), text);
    let impact = &found.impacts[0];
    // A steel ball keeps all but 1e-3 of its velocity; the contact points beside the place at which it parts put it off by 2.5 %.
    assert!((impact.approach_velocity / 0.5 - 1.0).abs() < 5e-3, "{impact:?}");
    assert!((impact.restitution - 1.0).abs() < 5e-3, "{impact:?}");
}

#[test]
fn a_body_that_rests_at_every_stored_state_moves_in_between() {
    // 2 kg from rest under 1000 N sin(ωt): v = F/(mω) (1 - cos ωt), zero after whole periods.
    let text = "[simulation]\nend_time = 0.01\n[bodies.r]\nmodel = \"rigid\"\nmass = 2.0\ninertia = [1e-3, 1e-3, 1e-3]\n\
                [loads.l]\nbody = \"r\"\npoint = [0, 0, 0]\n\
                force_x = { kind = \"harmonic\", amplitude = 1000.0, frequency = 1e3 }\n";
    let pace = 1000.0 / (2.0 * std::f64::consts::TAU * 1e3);
    for (set, fastest) in [(&[][..], 2.0 * pace), (&["output.free_interval=1e-3"][..], 0.0)] {
        let found = run(&scenarios::valid(Path::new("."), text, set));
        let last = found.samples.last().expect("states");
        let (way, speeds) =
            (last.bodies[0].position[0], found.samples.iter().map(|s| s.bodies[0].velocity[0]));
        // Steps of a quarter of a period err by 2e-8 of the amplitude.
        assert!((way / (0.01 * pace) - 1.0).abs() < 1e-6, "{set:?}: {way}");
        assert!((speeds.fold(0.0, f64::max) - fastest).abs() < 1e-6 * pace, "{set:?}");
    }
}

#[test]
fn loads_supply_what_free_bodies_take_up_in_vibrations() {
    let rod = "[bodies.a]\nmodel = \"axisymmetric\"\nmaterial = \"steel\"\n\
               geometry = { shape = \"rod\", radius = 0.01, length = 0.1 }\nreduction = { modes = 10 }\n";
    let plate = "[bodies.a]\nmodel = \"plane-stress\"\nthickness = 0.01\nmaterial = \"steel\"\n\
                 geometry = { shape = \"rectangle\", size = [0.1, 0.02] }\n";
    let steps = "kind = \"table\", times = [0.0, 3e-4, 6e-4, 1e-3], values = [0.0, 1000.0, -1000.0, 0.0]";
    for (name, body, loads) in [
        ("pushed", rod.to_owned(), "[loads.l]\nbody = \"a\"\nface = \"z+\"\nforce_z = 1.0\n".to_owned()),
        (
            "pulled at both ends",
            rod.to_owned(),
            "[loads.l]\nbody = \"a\"\nface = \"z+\"\nforce_z = 1.0\n[loads.k]\nbody = \"a\"\nface = \"z-\"\nforce_z = -1.0\n"
                .to_owned(),
        ),
        (
            "pulled and damped",
            format!("{plate}velocity = [10, 0, 0]\ndamping = {{ modal = 0.05 }}\n"),
            "[loads.l]\nbody = \"a\"\nface = \"x+\"\nforce_x = 1e3\n[loads.k]\nbody = \"a\"\nface = \"x-\"\nforce_x = -1e3\n"
                .to_owned(),
        ),
        ("turned", plate.to_owned(), "[loads.l]\nbody = \"a\"\nface = \"x+\"\nmoment_z = 1.0\n".to_owned()),
        (
            "in steps",
            plate.to_owned(),
            format!("[loads.l]\nbody = \"a\"\nface = \"x+\"\nforce_x = {{ {steps}, interpolation = \"steps\" }}\n"),
        ),
        (
            "up and down while it turns",
            format!("{plate}angular_velocity = [0, 0, 300]\n"),
            format!("[loads.l]\nbody = \"a\"\nface = \"x+\"\nforce_x = {{ {steps}, interpolation = \"linear\" }}\n"),
        ),
    ] {
        for end in [1e-4, 1e-3] {
            let found = recorded(Path::new("."), &format!("[simulation]\nend_time = {end}\n{body}{loads}"));
            let largest = found.samples.iter().map(|s| s.energies.kinetic + s.energies.elastic_low);
            let (largest, start) = (largest.fold(0.0, f64::max), found.samples[0].energies.total());
            let open = found.samples.iter().map(|s| (s.energies.total() - start).abs()).fold(0.0, f64::max);
            // A ledger that closes by as much is called right in the documents.
            assert!(open <= 1e-5 * largest, "{name}, {end} s: open by {:e}", open / largest);
        }
    }
}

/// A body of 1 kg at 1 m/s on a slider with a stop.
fn on_a_slider(simulation: &str, stop: &str) -> Recording {
    recorded(
        Path::new("."),
        &format!(
            "[simulation]\n{simulation}\n[bodies.a]\nmodel = \"rigid\"\nmass = 1.0\ninertia = [1e-3, 1e-3, 1e-3]\n\
             [joints.j]\ntype = \"prismatic\"\naxis = [1, 0, 0]\nparent = {{ body = \"ground\", point = [0, 0, 0] }}\n\
             child = {{ body = \"a\", point = [0, 0, 0] }}\nvelocity = 1.0\nstop = {{ {stop} }}\n"
        ),
    )
}

#[test]
fn meetings_of_stops_count_as_impacts() {
    let found = on_a_slider(
        "end_time = 0.3\nstop_after_impacts = 3",
        "lower = -0.01, upper = 0.01, stiffness = 1e6, damping = 0.3",
    );
    assert_eq!(found.impacts.len(), 3);
    let (end, last) = (found.samples.last().map_or(0.0, |s| s.time), found.impacts[2].end);
    // A step of the free phase at most.
    assert!(end >= last && end < last + 1e-3, "{end} {last}");
    // Half a period of 6.28 ms on the stop, from 10 ms on: the run ends behind the peak of 1 m/s sqrt(k m).
    let open = on_a_slider("end_time = 0.0118", "upper = 0.01, stiffness = 1e6");
    let [hit] = &open.impacts[..] else { panic!("{:?}", open.impacts) };
    // Four instants a step and a parabola.
    assert!((hit.peak_force / 1000.0 - 1.0).abs() < 1e-3, "{}", hit.peak_force);
    assert!(hit.restitution.is_nan() && hit.separation_velocity.is_nan());
    assert!((hit.end - 0.0118).abs() < 1e-12);
}

#[test]
fn a_body_that_rests_on_its_stop_stays_there() {
    let text = |overlap: &str| {
        format!(
            "[simulation]\nend_time = 0.05\ngravity = [-9.81, 0, 0]\n[bodies.a]\nmodel = \"rigid\"\nmass = 1.0\n\
             inertia = [1e-3, 1e-3, 1e-3]\n[joints.j]\ntype = \"prismatic\"\naxis = [1, 0, 0]\n\
             parent = {{ body = \"ground\", point = [0, 0, 0] }}\nchild = {{ body = \"a\", point = [0, 0, 0] }}\n\
             displacement = -0.031\nstop = {{ lower = -0.03, stiffness = 9810.0{overlap} }}\n"
        )
    };
    let faults = scenarios::parse(Path::new("."), &text(""), &[]).err().unwrap_or_default();
    assert!(faults.iter().any(|f| f.key == "joints.j.stop.lower" && f.message.contains("initial_overlap")));
    // 0.031 - 0.03 is more in floating point.
    let found = recorded(Path::new("."), &text(", initial_overlap = 1e-3"));
    let [hit] = &found.impacts[..] else { panic!("{:?}", found.impacts) };
    // The given place is that of equilibrium to the last bit but one or two.
    assert!((hit.peak_force / 9.81 - 1.0).abs() < 1e-9 && hit.end >= 0.05, "{hit:?}");
}

#[test]
fn a_driven_joint_that_meets_its_stop_has_its_rows() {
    // A quarter and three quarters of a period at 20 mm and 30 Hz: once into the upper stop, once into the lower one.
    let beyond = shaken(1.0, (0.0, 30.0), 1e-3, "stop = { lower = 0.01, stiffness = 1e4 }\n");
    assert!(
        (beyond.impacts[0].peak_force / 100.0 - 1.0).abs() < 1e-12,
        "it begins beyond its stop, which cannot move it"
    );
    for (stop, middle) in [("upper = 0.01", 0.25), ("lower = -0.01", 0.75)] {
        let found = shaken(1.0, (0.02, 30.0), 1.0 / 30.0, &format!("stop = {{ {stop}, stiffness = 1e4 }}\n"));
        let [hit] = &found.impacts[..] else { panic!("{stop}: {:?}", found.impacts) };
        // 10 mm of compression; the parabola through instants of a step of a twentieth of a period.
        assert!((hit.peak_force / 100.0 - 1.0).abs() < 1e-3, "{stop}: {hit:?}");
        assert!((hit.peak_time * 30.0 - middle).abs() < 1e-3, "{stop}: {hit:?}");
        // The middle 120 degrees of a half wave; instants lie a quarter of a step apart.
        assert!(((hit.end - hit.start) * 30.0 - 1.0 / 3.0).abs() < 1.0 / 40.0, "{stop}: {hit:?}");
    }
}
