//! Bodies in joints: two rigid double pendulums, a flexible pendulum; discs with friction.

use std::f64::consts::PI;
use std::sync::OnceLock;

use crate::blocks;
use crate::support::scenarios;
use crate::writers::{Form, gmsh};
use fe_mesh::ElementKind;

use super::support::{
    Table, Trace, assert_below, assert_close, interpolate, run, run_scenario, without_sizes,
};

/// Largest change of the total energy as a share of the largest kinetic energy.
///
/// Pendulums start with no energy at all, gravity's potential being counted from there.
fn drift(trace: &Trace) -> f64 {
    let start = trace.samples[0].energies.total();
    let change = trace.samples.iter().map(|s| (s.energies.total() - start).abs()).fold(0.0, f64::max);
    change / trace.samples.iter().map(|s| s.energies.kinetic).fold(0.0, f64::max)
}

/// Largest distance between the first observed points of two runs with the same stored times \[m\].
fn distance(a: &Trace, b: &Trace) -> f64 {
    assert_eq!(a.times(), b.times());
    let gap = |p: [f64; 3], q: [f64; 3]| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt();
    let pairs = a.samples.iter().zip(&b.samples);
    pairs.map(|(a, b)| gap(a.points[0].position, b.points[0].position)).fold(0.0, f64::max)
}

#[test]
fn rigid_double_pendulums_meet_three_times_with_hertz_peaks() {
    // Independent integration with Hertz's law: start [s], peak [N].
    const IMPACTS: [(f64, f64); 3] =
        [(166.818909e-3, 303.561), (500.507916e-3, 303.303), (834.188990e-3, 303.468)];
    const DURATION: f64 = 74.31e-6; // s
    const IMPULSE: f64 = 1.226e-2; // N s
    // Printed digits.
    const TIME_TOLERANCE: f64 = 1e-8;
    const PEAK_TOLERANCE: f64 = 5e-6;
    // Durations of the three differ by 2e-4, impulses by 7e-4.
    const MEAN_TOLERANCE: f64 = 1e-3;
    let trace = run("rigid_double_pendulums", &[]);
    assert_eq!((trace.impacts.len(), &trace.failure), (3, &None));
    for (impact, (start, peak)) in trace.impacts.iter().zip(IMPACTS) {
        assert_below("start", (impact.start - start).abs(), TIME_TOLERANCE);
        assert_close("peak force", impact.peak_force, peak, PEAK_TOLERANCE);
        assert_close("duration", impact.end - impact.start, DURATION, MEAN_TOLERANCE);
        assert_close("impulse", impact.impulse, IMPULSE, MEAN_TOLERANCE);
    }
    assert_below("energy drift", drift(&trace), 1e-6);
    // Both swing in the x-z plane.
    let out_of_plane = trace.history(|s| s.points.iter().map(|p| p.position[1].abs()).fold(0.0, f64::max));
    assert_below("out of plane", out_of_plane.into_iter().fold(0.0, f64::max), 1e-12);
}

#[test]
fn rigid_double_pendulum_without_contact_follows_its_reference() {
    // The right pendulum is out of the way. Rods agree with other programs to 1e-12 rad; steps here are allowed 1e-12.
    const ANGLE: f64 = 1e-9; // rad
    let set = [
        "joints.right_suspension.parent.point=[1.0,0,0]",
        "simulation.free.rtol=1e-12",
        "output.free_interval=20e-3",
    ];
    let trace = run("rigid_double_pendulums", &set);
    assert_eq!((trace.impacts.len(), &trace.failure), (0, &None));
    let table = Table::read("rigid_double_pendulum");
    let reference = [table.column("rod_rad"), table.column("sphere_rad")];
    assert_eq!(trace.samples.len(), reference[0].len());
    let joint = |name: &str| trace.layout.joints.iter().position(|j| j.name == name).expect("a joint");
    let (suspension, hinge) = (joint("left_suspension"), joint("left_hinge"));
    let mut off = 0.0_f64;
    for (i, sample) in trace.samples.iter().enumerate() {
        // Stored at multiples of the interval.
        assert!((sample.time - 20e-3 * i as f64).abs() < 1e-12, "{}", sample.time);
        let rod = sample.joints[suspension].positions[0];
        let sphere = rod + sample.joints[hinge].positions[0];
        off = off.max((rod - reference[0][i]).abs()).max((sphere - reference[1][i]).abs());
    }
    assert_below("angles", off, ANGLE);
}

/// Displacements of the tip of the spinning beam in the turning frame: times, axial, transverse \[s, m\].
fn tip(trace: &Trace) -> [Vec<f64>; 3] {
    const LENGTH: f64 = 10.0; // m
    let turned = |sample: &adaptive::record::Sample| {
        let ([x, y, _], (s, c)) = (sample.points[0].position, sample.joints[0].positions[0].sin_cos());
        [c * x + s * y - LENGTH, c * y - s * x]
    };
    [trace.times(), trace.history(|s| turned(s)[0]), trace.history(|s| turned(s)[1])]
}

#[test]
fn spinning_beam_follows_the_geometrically_exact_one() {
    assert_spin_up(&run("spinning_beam", &[]));
}

#[test]
fn spinning_beam_of_chosen_sizes_follows_the_geometrically_exact_one() {
    assert_spin_up(&run_scenario(&without_sizes("spinning_beam", &[])));
}

#[test]
fn spinning_beam_of_finite_elements_follows_the_geometrically_exact_one() {
    // The strip as a bar of its square section; brick elements of 20 nodes. In space the first mode along it, of which the extension
    // is made, is beyond the twentieth.
    let path = scenarios::folder("spinning_bricks");
    let section = 0.07745966692414834;
    let bar = |[x, y, z]: [f64; 3]| [10.0 * x - 5.0, section * (y - 0.5), section * (z - 0.5)];
    let mesh = blocks::block(ElementKind::Hex20, [40, 1, 1], bar);
    std::fs::write(path.join("beam.msh"), gmsh(&mesh, Form::Binary41)).expect("written");
    let strip = std::fs::read_to_string("scenarios/spinning_beam.toml").expect("a scenario");
    let own = ["model = \"plane", "thickness", "geometry", "#:schema"];
    let kept: Vec<&str> = strip.lines().filter(|line| !own.iter().any(|key| line.starts_with(key))).collect();
    let text = kept
        .join("\n")
        .replace(
            "[bodies.beam]\n",
            "[bodies.beam]\nmodel = \"mesh\"\nfile = \"beam.msh\"\nunits = \"m\"\n\
             reduction = { method = \"modal\", modes = 40 }\n",
        )
        .replace("marker = \"right\"", "point = [5.0, 0.0, 0.0]");
    assert_spin_up(&run_scenario(&scenarios::valid(&path, &text, &[])));
}

/// Asserts that `trace` is the spin-up of the reference.
fn assert_spin_up(trace: &Trace) {
    // A bound from the project: 1 % of the extremes.
    const SHARE: f64 = 1e-2;
    const EXTREME: f64 = -0.57384; // m
    const EXTENSION: f64 = 5.14e-4; // m
    assert_eq!(trace.failure, None);
    let [times, axial, transverse] = tip(trace);
    let table = Table::read("spinning_beam");
    let (at, curve) = (table.column("time_s"), table.column("transverse_m"));
    let off = at.iter().zip(&curve).map(|(&t, v)| (interpolate(&times, &transverse, t) - v).abs());
    assert_below("tip curve [m]", off.fold(0.0, f64::max), SHARE * EXTREME.abs());
    let extreme = transverse.iter().copied().fold(0.0, f64::min);
    assert_close("largest lag", extreme, EXTREME, SHARE);
    // A second after the spin-up only small vibrations are left.
    let steady: Vec<f64> = times.iter().zip(&axial).filter(|(t, _)| **t > 16.0).map(|(_, u)| *u).collect();
    assert_close("steady extension", steady.iter().sum::<f64>() / steady.len() as f64, EXTENSION, SHARE);
}

#[test]
fn spinning_beam_diverges_without_geometric_stiffening() {
    // Centrifugal forces exceed what the lowest mode, 3.8 rad/s, bears long before the final 6 rad/s.
    let set = ["bodies.beam.geometric_stiffening=false", "simulation.end_time=9.5"];
    let trace = run("spinning_beam", &set);
    let [times, _, transverse] = tip(&trace);
    let leaves = times.iter().zip(&transverse).find(|(_, v)| v.abs() > 10.0).map(|(t, _)| *t);
    // An unstable motion: its start depends on the model, its time much less.
    assert!(leaves.is_some_and(|t| (t - 9.2).abs() < 0.2), "{leaves:?}");
}

#[test]
fn disc_leaves_with_the_velocities_of_gross_sliding() {
    // A bound from the project: 2 % of the velocities, 1 % of the rate of turn and of the work.
    const VELOCITY: f64 = 2e-2;
    const RATE: f64 = 1e-2;
    let trace = run("rotating_disc", &[]);
    let impact = trace.impact();
    let last = trace.samples.last().expect("samples");
    let mass = -trace.samples[0].linear_momentum[1] / 0.1;
    assert_close("v_x", last.linear_momentum[0] / mass, -0.06, VELOCITY);
    assert_close("v_y", last.linear_momentum[1] / mass, 0.1, VELOCITY);
    let after = || trace.samples.iter().filter(|s| s.time > impact.end);
    let mean = after().map(|s| s.bodies[0].angular_velocity[2]).sum::<f64>() / after().count() as f64;
    assert_close("mean rate of turn", mean, 1.618 * PI, RATE);
    let energy = |s: &adaptive::record::Sample| s.energies.total() - s.energies.dissipated;
    let lost = energy(&trace.samples[0]) - energy(last);
    assert_close("friction work over energy lost", last.energies.dissipated / lost, 1.0, RATE);
    // Gross sliding: the friction force is at its bound throughout.
    for sample in trace.samples.iter().filter(|s| s.contacts[0].normal_force > 1.0) {
        let [x, y, _] = sample.contacts[0].force;
        assert!((x / y + 0.3).abs() < 1e-9, "{x} {y}"); // round-off of forces at 48 points
    }
    // Half-width of the contact, one contact point either side less or more of 33 inside.
    let width = trace.samples.iter().map(|s| s.contacts[0].contact_area).fold(0.0, f64::max);
    assert_close("width of the contact", width, 0.92e-3, 6e-2);
}

#[test]
fn discs_that_slide_and_stick_on_each_other_keep_both_momenta_and_the_ledger() {
    // Sums of round-off over 200 steps.
    const MOMENTUM: f64 = 1e-12;
    // Tangents are those of the surface at the start of a step, whose strain changes by some 1e-4 in it.
    const RATIO: f64 = 1e-3;
    // The power of friction jumps where a point begins to slide: a step's work of one of 16 points, one in 130 steps.
    const DRIFT: f64 = 1e-4;
    let trace = run("oblique_discs", &[]);
    let impact = trace.impact();
    let size = |v: [f64; 3]| v[0].hypot(v[1]).hypot(v[2]);
    let change = |of: &dyn Fn(&adaptive::record::Sample) -> [f64; 3]| {
        let start = of(&trace.samples[0]);
        let away = |s| size([0, 1, 2].map(|c| of(s)[c] - start[c]));
        trace.samples.iter().map(away).fold(0.0, f64::max) / size(start)
    };
    assert_below("change of momentum", change(&|s| s.linear_momentum), MOMENTUM);
    assert_below("change of angular momentum", change(&|s| s.angular_momentum), MOMENTUM);
    assert_below("energy drift", trace.energy_drift(), DRIFT);
    let (mut n_sliding, mut n_stuck, mut n_back) = (0, 0, 0);
    for sample in trace.samples.iter().filter(|s| s.contacts[0].normal_force > 1.0) {
        let contact = &sample.contacts[0];
        let ratio = size(contact.friction_force) / contact.normal_force;
        assert!(ratio < 0.3 * (1.0 + RATIO), "{ratio} at {:e} s", sample.time);
        if contact.sliding_points == contact.active_points {
            assert_close("friction force over normal force", ratio, 0.3, RATIO);
            n_sliding += 1;
            n_back += usize::from(contact.friction_force[0] > 0.0);
        }
        n_stuck += usize::from(contact.sliding_points == 0);
    }
    // Sliding, sticking, sliding back.
    assert!(n_sliding > 40 && n_stuck > 10 && n_back > 5, "{n_sliding} {n_stuck} {n_back}");
    let (first, last) = (&trace.samples[0], trace.samples.last().expect("samples"));
    let energy = |s: &adaptive::record::Sample| s.energies.total() - s.energies.dissipated;
    let lost = energy(first) - energy(last);
    assert!(lost > 0.0 && impact.restitution > 0.95);
    assert_close("friction work over energy lost", last.energies.dissipated / lost, 1.0, 1e-3);
}

/// The flexible pendulum as shipped.
fn pendulum() -> &'static Trace {
    static RUN: OnceLock<Trace> = OnceLock::new();
    RUN.get_or_init(|| run("flexible_pendulum", &[]))
}

#[test]
fn flexible_pendulum_keeps_its_energy_and_its_plane() {
    assert_eq!(pendulum().failure, None);
    assert_below("energy drift", drift(pendulum()), 1e-6);
    let out_of_plane = pendulum().history(|s| s.points[0].position[1].abs());
    assert_below("out of plane", out_of_plane.into_iter().fold(0.0, f64::max), 1e-10);
    // Bending shortens the chord by far less than this.
    let lowest = pendulum().history(|s| s.points[0].position[2]).into_iter().fold(0.0, f64::min);
    assert_close("lowest point", lowest, -1.0, 1e-3);
}

/// Deflection of the tip of the pendulum from the tangent at its hinge, let go at the time zero, after `t` \[m\]: bending of Euler's and
/// Bernoulli's beam under the part of its weight that does not turn it.
fn released(t: f64) -> f64 {
    const BETAS: [f64; 5] = [3.926_602_312, 7.068_582_745, 10.210_176_12, 13.351_768_78, 16.493_361_43];
    // 1 m of steel, radius 10 mm: √(EI/ρA) = r/2 √(E/ρ).
    let speed = 5e-3 * (210e9f64 / 7850.0).sqrt();
    let mode = |beta: f64| {
        let (ratio, omega) = (beta.sin() / beta.sinh(), beta * beta * speed);
        let (tip, slope) = (2.0 * beta.sin(), beta * (1.0 + ratio));
        // ∫φ and ∫φ² of φ = sin βx + ratio sinh βx.
        let sum = (1.0 - beta.cos() + ratio * (beta.cosh() - 1.0)) / beta;
        let square = 0.5 * (1.0 - ratio * ratio);
        -9.81 * sum / (square * omega * omega) * (1.0 - (omega * t).cos()) * (tip - slope)
    };
    BETAS.into_iter().map(mode).sum()
}

#[test]
fn flexible_pendulum_bends_like_a_hinged_beam_when_it_is_let_go() {
    // Two thirds of a period of the first mode, in which it turns by half a milliradian; shear and rotary inertia take 0.1 % of its frequency.
    let set = ["simulation.end_time=10e-3", "output.free_interval=0.1e-3"];
    let runs = [
        ("shipped", run("flexible_pendulum", &set)),
        ("chosen", run_scenario(&without_sizes("flexible_pendulum", &set))),
    ];
    let extreme = (0..=100).map(|i| released(1e-4 * f64::from(i)).abs()).fold(0.0, f64::max);
    for (sizes, trace) in runs {
        assert!(trace.failure.is_none() && trace.samples.len() > 100, "{:?}", trace.failure);
        let off = trace.samples.iter().map(|sample| {
            let ([x, _, z], (s, c)) = (sample.points[0].position, sample.joints[0].positions[0].sin_cos());
            (s * x + c * z - released(sample.time)).abs()
        });
        // A bound from the project.
        assert_below(&format!("{sizes}: deflection off [m]"), off.fold(0.0, f64::max), 1e-2 * extreme);
    }
}

#[test]
fn tangent_and_mean_axis_frame_agree_in_tip_position() {
    let buckens = run("flexible_pendulum", &["bodies.rod.frame=buckens"]);
    assert_below("distance of the tips", distance(pendulum(), &buckens), 1e-5);
}

#[test]
fn gauss_collocation_agrees_in_tip_position_and_keeps_the_energy() {
    let gauss = run("flexible_pendulum", &["simulation.free.integrator=gauss"]);
    assert_below("distance of the tips", distance(pendulum(), &gauss), 1e-5);
    assert_below("energy drift", drift(&gauss), 1e-6);
}

#[test]
fn gauss_collocation_is_chosen_where_bodies_vibrate_on_joints() {
    let evaluations = |sets: &[&str]| {
        let sets = [&["simulation.end_time=0.005"], sets].concat();
        run("double_pendulum/hertz", &sets).phases.iter().map(|p| p.evaluations).sum::<u64>()
    };
    let chosen = evaluations(&[]);
    assert_eq!(chosen, evaluations(&["simulation.free.integrator=gauss"]));
    assert!(10 * chosen < evaluations(&["simulation.free.integrator=dormand-prince"]), "{chosen}");
}

#[test]
fn implicit_integrator_agrees_in_tip_position_and_shows_its_loss() {
    let implicit = run("flexible_pendulum", &["simulation.free.integrator=tr-bdf2"]);
    assert_below("distance of the tips", distance(pendulum(), &implicit), 1e-4);
    // Numerical damping takes energy away; it is booked, so that the ledger closes to round-off.
    let kinetic = implicit.samples.iter().map(|s| s.energies.kinetic).fold(0.0, f64::max);
    let removed = implicit.samples.last().expect("samples").energies.numerical / kinetic;
    assert!(removed > 0.0, "{removed}");
    assert_below("energy removed", removed, 1e-3);
    assert_below("energy drift", drift(&implicit), 1e-12);
}
