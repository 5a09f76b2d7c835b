//! Contact that goes on along its bodies, over several zones: against the same contact that stays where it is.

use adaptive::record::warning::WarningKind;
use adaptive::record::{Sample, TransferDirection, TrialOutcome};
use adaptive::run::recording::Recording;
use adaptive::store::ModelCache;
use fbimpact::simulate::simulate_with;

use crate::support::scenarios::{folder, run, valid};

/// A disc of 20 mm and its partner, `target`, pressed by their weight from the touch on, of which `gravity` is the part along the way.
/// The disc moves at `speed` and rolls, if it is to `roll`.
fn disc(
    target: &str,
    [gravity, weight]: [f64; 2],
    speed: f64,
    roll: bool,
    friction: f64,
    end: f64,
) -> Recording {
    let spin = if roll { -speed / 20e-3 } else { 0.0 };
    let text = format!(
        "[simulation]\nend_time = {end:?}\ngravity = [{gravity:?}, {:?}, 0.0]\n\
[bodies.disc]\nmodel = \"plane-strain\"\nmaterial = \"aluminium\"\nthickness = 20e-3\ngeometry = {{ shape = \"disc\", radius = 20e-3 }}\n\
damping = {{ modal = 0.3 }}\nposition = [0.0, 20e-3, 0.0]\nvelocity = [{speed:?}, 0.0, 0.0]\nangular_velocity = [0.0, 0.0, {spin:?}]\n\
{target}\n[contacts.touch]\ncontact_body = \"disc\"\ntarget_body = \"target\"\nfriction = {friction:?}\n",
        -weight
    );
    run(&valid(&folder("travelling"), &text, &["output.impact_interval=0.0", "output.free_interval=1e-6"]))
}

const FLOOR: &str =
    "[bodies.target]\nmodel = \"rigid\"\ngeometry = { shape = \"plane\" }\nnormal = [0.0, 1.0, 0.0]";
const BLOCK: &str = "[bodies.target]\nmodel = \"plane-strain\"\nmaterial = \"aluminium\"\nthickness = 20e-3\ndamping = { modal = 0.3 }\n\
geometry = { shape = \"rectangle\", size = [30e-3, 10e-3] }\n\
[joints.foot]\ntype = \"fixed\"\nparent = { body = \"ground\", point = [0.0, -10e-3, 0.0] }\nchild = { body = \"target\", face = \"y-\" }";

/// How often another zone took over.
fn zones(recording: &Recording) -> usize {
    recording.trials.iter().filter(|trial| trial.outcome == TrialOutcome::Accepted).count()
}

/// Largest difference of the normal forces of two runs at the instants of the first, as a share of its peak force.
fn difference(one: &Recording, other: &Recording) -> f64 {
    let times: Vec<f64> = other.samples.iter().map(|sample| sample.time).collect();
    let force = |k: usize| other.samples[k].contacts[0].normal_force;
    let at = |time: f64| {
        let k = times.partition_point(|t| *t < time).clamp(1, times.len() - 1);
        let share = (time - times[k - 1]) / (times[k] - times[k - 1]);
        force(k - 1) * (1.0 - share) + force(k) * share
    };
    let differences =
        one.samples.iter().map(|sample| (sample.contacts[0].normal_force - at(sample.time)).abs());
    differences.fold(0.0, f64::max) / one.impacts[0].peak_force
}

/// Largest jump of the energy where another zone takes over, as a share of what the contact holds at rest.
fn largest_jump(recording: &Recording) -> f64 {
    let held =
        recording.samples.iter().map(|s| s.energies.elastic_high + s.energies.penalty).fold(0.0, f64::max);
    let jumps = recording.transfers.iter().filter(|t| t.direction == TransferDirection::CoarseToFine);
    jumps.map(|t| (t.energy_after - t.energy_before).abs()).fold(0.0, f64::max) / held
}

/// Largest change of the friction in the step after another zone took over, as a share of its largest value.
fn largest_loss(recording: &Recording) -> f64 {
    let friction = |k: usize| recording.samples[k].contacts[0].friction_force[0];
    let largest = (0..recording.samples.len()).map(|k| friction(k).abs()).fold(0.0, f64::max);
    let after = |time: f64| recording.samples.partition_point(|sample| sample.time <= time);
    let changes = recording.transfers.iter().filter(|t| t.direction == TransferDirection::CoarseToFine);
    let changes = changes.map(|t| after(t.time)).filter(|k| (1..recording.samples.len()).contains(k));
    changes.map(|k| (friction(k) - friction(k - 1)).abs()).fold(0.0, f64::max) / largest
}

#[test]
fn a_wheel_presses_as_one_that_stands() {
    let standing = disc(FLOOR, [3.0, 9.81], 0.0, true, 0.3, 5e-4);
    let rolling = disc(FLOOR, [3.0, 9.81], 0.2, true, 0.3, 5e-4);
    assert_eq!((standing.impacts.len(), rolling.impacts.len()), (1, 1));
    assert!(zones(&standing) == 1 && zones(&rolling) >= 3, "{} zones", zones(&rolling));
    // Zones of 11 rows of elements under what presses have its force right to a per cent; the spin of 10 rad/s adds 1e-3 by the
    // radius that it lets grow.
    let off = difference(&standing, &rolling);
    assert!(off < 0.02, "{off}");
    // Each zone has its energy right to a per cent.
    let jump = largest_jump(&rolling);
    assert!(jump < 0.01, "{jump}");
    assert!(rolling.energy_drift() < 1e-6, "{}", rolling.energy_drift());
    // Friction goes on from zone to zone: a step changes it by a tenth or so of its largest value, while from nothing it would take
    // a contact's width, a third of a zone, to build up.
    let lost = largest_loss(&rolling);
    assert!(lost < 0.3, "{lost}");
    // It is a third of the part of the weight along the way.
    let gain = |recording: &Recording| {
        let last = recording.samples.last().unwrap();
        last.bodies[0].velocity[0] - recording.samples[0].bodies[0].velocity[0]
    };
    let ratio = gain(&rolling) / gain(&standing);
    assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    // Both slip a little while the weight sets in.
    assert!((gain(&rolling) / (2.0 / 3.0 * 3.0 * 5e-4) - 1.0).abs() < 0.03, "{}", gain(&rolling));
}

#[test]
fn zones_travel_on_both_bodies() {
    // Without friction the disc slides over the block: its own zone stays, that of the block travels.
    let standing = disc(BLOCK, [0.0, 1000.0], 0.0, false, 0.0, 1.5e-4);
    let sliding = disc(BLOCK, [0.0, 1000.0], 3.0, false, 0.0, 1.5e-4);
    assert!(zones(&standing) == 1 && zones(&sliding) >= 2, "{} zones", zones(&sliding));
    // As above; the block is softer by 1e-3 of the pair's approach where it has moved to.
    let off = difference(&standing, &sliding);
    assert!(off < 0.02, "{off}");
    assert!(largest_jump(&sliding) < 0.01, "{}", largest_jump(&sliding));
}

/// An eccentric disc that turns at 100 rad/s lifts a follower, which a spring presses on it.
const CAM: &str = "[simulation]\nend_time = 2.6e-3\nstart = \"static\"\n\
[bodies.cam]\nmodel = \"plane-strain\"\nmaterial = \"steel\"\nthickness = 0.01\ndamping = { modal = 0.3 }\n\
geometry = { shape = \"disc\", radius = 20e-3 }\n\
[bodies.follower]\nmodel = \"rigid\"\nmotion = \"planar\"\nmaterial = \"steel\"\nthickness = 0.01\n\
geometry = { shape = \"rectangle\", size = [30e-3, 10e-3] }\n\
[joints.shaft]\ntype = \"revolute\"\naxis = [0.0, 0.0, 1.0]\nparent = { body = \"ground\", point = [0.0, 0.0, 0.0] }\n\
child = { body = \"cam\", point = [2e-3, 0.0], radius = 5e-3 }\nmotion = { kind = \"polynomial\", coefficients = [0.0, 100.0] }\n\
[joints.guide]\ntype = \"prismatic\"\naxis = [0.0, 1.0, 0.0]\nparent = { body = \"ground\", point = [0.0, 25e-3, 0.0] }\n\
child = { body = \"follower\", point = [0.0, 0.0] }\nstiffness = 1e5\ndamping = 50.0\nrest = -2e-3\n\
[contacts.c]\ncontact_body = \"cam\"\ntarget_body = \"follower\"\ndamping = 0.5\n";

#[test]
#[ignore = "second tier: ten seconds"]
fn a_cam_presses_its_follower_by_spring_and_inertia() {
    let recording = run(&valid(&folder("travelling"), CAM, &[]));
    assert!(zones(&recording) > 5, "{} zones", zones(&recording));
    assert!(recording.energy_drift() < 1e-6, "{}", recording.energy_drift());
    // Mean over a millisecond, some hundred periods of the ringing that the start leaves.
    let samples = recording.samples.windows(2).filter(|pair| pair[0].time > 1.2e-3 && pair[1].time < 2.6e-3);
    let (mut impulse, mut expected) = (0.0, 0.0);
    for pair in samples {
        let step = pair[1].time - pair[0].time;
        let law = |time: f64| {
            let (sin, cos) = (100.0 * time).sin_cos();
            7850.0 * 30e-3 * 10e-3 * 10e-3 * 20.0 * sin - 50.0 * 0.2 * cos + 1e5 * 2e-3 * (1.0 - sin)
        };
        impulse += 0.5 * step * (pair[0].contacts[0].normal_force + pair[1].contacts[0].normal_force);
        expected += 0.5 * step * (law(pair[0].time) + law(pair[1].time));
    }
    // The approach of the bodies, a micrometre, is 0.05 % of the lift; the ringing about the mean leaves as much again.
    assert!((impulse / expected - 1.0).abs() < 5e-3, "{}", impulse / expected);
}

/// A steel wheel of 50 mm that a guide moves at 1 m/s over a rail and a shaft turns, both by rule, with the creep `creep`; 100 kN/m press it.
fn driven_wheel(creep: f64) -> String {
    let body = |name: &str, shape: &str| {
        format!(
            "[bodies.{name}]\nmodel = \"plane-strain\"\nthickness = 0.02\nmaterial = \"steel\"\ndamping = {{ modal = 0.3 }}\n\
reduction = {{ modes = 8 }}\ngeometry = {{ {shape} }}\n"
        )
    };
    let rigid = |name: &str| {
        format!(
            "[bodies.{name}]\nmodel = \"rigid\"\nmotion = \"planar\"\nmass = 0.1\ninertia = [1e-4, 1e-4, 1e-4]\n"
        )
    };
    let joint = |name: &str, kind: &str, axis: &str, parent: &str, child: &str| {
        format!("[joints.{name}]\ntype = \"{kind}\"\n{axis}parent = {{ {parent} }}\nchild = {{ {child} }}\n")
    };
    let rule = |rate: f64| format!("motion = {{ kind = \"polynomial\", coefficients = [0.0, {rate:?}] }}\n");
    let centre = "point = [0.0, 0.0]";
    "[simulation]\nend_time = 6e-3\nstart = \"static\"\n".to_owned()
        + &body("rail", "shape = \"rectangle\", size = [0.08, 0.04]")
        + &body("wheel", "shape = \"disc\", radius = 0.05")
        + &rigid("slide")
        + &rigid("carrier")
        + &joint(
            "bed",
            "fixed",
            "",
            "body = \"ground\", point = [0.0, -0.02, 0.0]",
            "body = \"rail\", face = \"y-\"",
        )
        + &joint(
            "way",
            "prismatic",
            "axis = [1.0, 0.0, 0.0]\n",
            "body = \"ground\", point = [-0.005, 0.07, 0.0]",
            &format!("body = \"slide\", {centre}"),
        )
        + &rule(1.0)
        + &joint(
            "lift",
            "prismatic",
            "axis = [0.0, 1.0, 0.0]\n",
            &format!("body = \"slide\", {centre}"),
            &format!("body = \"carrier\", {centre}"),
        )
        + &joint(
            "shaft",
            "revolute",
            "axis = [0.0, 0.0, 1.0]\n",
            &format!("body = \"carrier\", {centre}"),
            &format!("body = \"wheel\", {centre}, radius = 0.03"),
        )
        + &rule(-(1.0 + creep) / 0.05)
        + &format!("[loads.press]\nbody = \"carrier\"\n{centre}\nforce_y = -2000.0\n")
        + "[contacts.touch]\ncontact_body = \"wheel\"\ntarget_body = \"rail\"\nfriction = 0.3\n[output]\nfree_interval = 2e-5\n"
}

/// The creep of a wheel that rolls with traction, and its parts that slide (Carter 1926): with half the width of contact `a` and the share
/// `q` of the bound of friction, `μ a/R (1 - √(1 - q))` and `1 - √(1 - q)`.
#[test]
fn a_wheel_that_rolls_with_traction_creeps_as_carter_says() {
    let (pressure, radius, modulus) = (1e5, 0.05, 210e9 / (2.0 * (1.0 - 0.09)));
    let half_width = f64::sqrt(4.0 * pressure * radius / (std::f64::consts::PI * modulus));
    let largest = 0.3 * half_width / radius;
    let creep = largest * (1.0 - f64::sqrt(0.5));
    let recording = run(&valid(&folder("travelling"), &driven_wheel(creep), &[]));
    assert!(zones(&recording) >= 3, "{} zones", zones(&recording));
    // Half an element a step: a hundred or two in a zone, which explicit steps cross in a thousand.
    let steps: u64 = recording.phases.iter().map(|phase| phase.steps).sum();
    assert!(steps < 500, "{steps}");
    let late =
        recording.samples.iter().filter(|sample| sample.time > 5.2e-3).map(|sample| &sample.contacts[0]);
    let (mut share, mut sliding, mut n) = (0.0, 0.0, 0.0);
    for contact in late {
        share += contact.friction_force[0].abs() / (0.3 * contact.normal_force);
        sliding += f64::from(contact.sliding_points) / f64::from(contact.active_points);
        n += 1.0;
    }
    let slides = 1.0 - f64::sqrt(1.0 - share / n);
    // Eleven rows of points; steps of half a row leave 1.5 %.
    assert!((largest * slides / creep - 1.0).abs() < 0.03, "{} of the friction's bound", share / n);
    // By whole rows, of which three slide.
    assert!((sliding / n - slides).abs() < 0.5 / 11.0, "{} {slides}", sliding / n);
}

/// A roller of 30 mm slides at 9 m/s over a simply supported beam of 1 m, of which `more` is said.
fn roller(more: &str, end: f64) -> String {
    let joint = |name: &str, x: f64, face: &str, more: &str| {
        format!(
            "[joints.{name}]\ntype = \"revolute\"\naxis = [0.0, 0.0, 1.0]\n{more}parent = {{ body = \"ground\", point = [{x:?}, 0.0, 0.0] }}\n\
child = {{ body = \"beam\", face = \"{face}\" }}\n"
        )
    };
    format!(
        "[simulation]\nend_time = {end:?}\ngravity = [0.0, -9.81, 0.0]\n\
[bodies.beam]\nmodel = \"plane-stress\"\nthickness = 0.02\nmaterial = \"steel\"\ngeometry = {{ shape = \"rectangle\", size = [1.0, 0.01] }}\n{more}\n\
[bodies.roller]\nmodel = \"rigid\"\nmotion = \"planar\"\nthickness = 0.02\nmaterial = \"steel\"\ngeometry = {{ shape = \"disc\", radius = 0.03 }}\n\
position = [-0.45, 0.035, 0.0]\nvelocity = [9.0, 0.0, 0.0]\n{}{}\
[contacts.touch]\ncontact_body = \"beam\"\ntarget_body = \"roller\"\n[output.points.middle]\nbody = \"beam\"\npoint = [0.0, 0.0]\n",
        joint("left", -0.5, "x-", ""),
        joint("right", 0.5, "x+", "closes_loop = true\n")
    )
}

/// Deflection of the middle of that beam at the instants `times` \[m\]: a mass on `n` sines of a beam after Euler and Bernoulli, between them a
/// spring that yields by some nanometres, by the rule of Runge and Kutta of fourth order.
fn moving_mass(n: usize, times: &[f64]) -> Vec<f64> {
    const PI: f64 = std::f64::consts::PI;
    const SPRING: f64 = 4e8;
    let (young, density, depth, breadth, gravity, speed) = (210e9, 7850.0, 0.01, 0.02, 9.81, 9.0);
    let (line, mass) = (density * depth * breadth, density * PI * 0.03 * 0.03 * breadth);
    let stiffness = young * breadth * f64::powi(depth, 3) / 12.0;
    let wave = |k: usize| (k + 1) as f64 * PI;
    // Coordinates and rates of the modes, of the mass; all downwards.
    let rates = |time: f64, y: &[f64]| -> Vec<f64> {
        let place = 0.05 + speed * time;
        let at = |k: usize| (wave(k) * place).sin();
        let under: f64 = (0..n).map(|k| at(k) * y[k]).sum();
        let force = SPRING * (y[2 * n] - under).max(0.0);
        let mut dy = y[n..2 * n].to_vec();
        dy.extend((0..n).map(|k| {
            let weight = gravity * 2.0 / wave(k) * (1.0 - wave(k).cos());
            2.0 * force * at(k) / line + weight - stiffness / line * wave(k).powi(4) * y[k]
        }));
        dy.extend([y[2 * n + 1], gravity - force / mass]);
        dy
    };
    let (mut y, mut time, step) = (vec![0.0; 2 * n + 2], 0.0, 2e-6);
    let middle = |y: &[f64]| (0..n).map(|k| (0.5 * wave(k)).sin() * y[k]).sum::<f64>();
    let mut last = 0.0;
    times
        .iter()
        .map(|&wanted| {
            while time < wanted {
                last = middle(&y);
                let along =
                    |k: &[f64], h: f64| -> Vec<f64> { y.iter().zip(k).map(|(y, k)| y + h * k).collect() };
                let k1 = rates(time, &y);
                let k2 = rates(time + 0.5 * step, &along(&k1, 0.5 * step));
                let k3 = rates(time + 0.5 * step, &along(&k2, 0.5 * step));
                let k4 = rates(time + step, &along(&k3, step));
                for (i, y) in y.iter_mut().enumerate() {
                    *y += step / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
                }
                time += step;
            }
            middle(&y) + (last - middle(&y)) * (time - wanted) / step
        })
        .collect()
}

/// Largest difference of the deflection in the middle from that of [`moving_mass`] with `n` modes, over the largest one.
fn off_moving_mass(recording: &Recording, n: usize) -> f64 {
    let times: Vec<f64> = recording.samples.iter().map(|sample| sample.time).collect();
    let expected = moving_mass(n, &times);
    let largest = expected.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
    let found = recording.samples.iter().map(|sample| -sample.points[0].position[1]);
    found.zip(&expected).map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max) / largest
}

/// The instant from which on the contact goes on by Hertz's law.
fn by_law(recording: &Recording) -> Option<f64> {
    let told = recording.warnings.iter().filter(|warning| warning.kind == WarningKind::ByLaw);
    let times: Vec<f64> = told.map(|warning| warning.time).collect();
    assert!(times.len() <= 1, "{times:?}");
    times.first().copied()
}

#[test]
fn contact_that_goes_far_goes_on_by_the_law() {
    let few = "reduction = { modes = 12 }\ndiscretisation = { degree = 3, elements = [24, 1] }";
    let scenario = valid(&folder("travelling"), &roller(few, 0.05), &[]);
    let recording = run(&scenario);
    let switched = by_law(&recording).expect("thousands of zones of some ten micrometres to go");
    let n_zones = recording.transfers.iter().filter(|t| t.site.is_some()).count();
    assert!(switched < 1e-3 && (3..60).contains(&n_zones), "{n_zones} zones until {switched:e} s");
    assert!(
        recording.transfers.iter().all(|t| t.time <= switched || t.site.is_none()),
        "no zone comes later"
    );
    // Twelve modes of the beam on its joints are those of sines to the third digit, and shear yields by 1e-4.
    let off = off_moving_mass(&recording, 12);
    assert!(off < 1e-3, "{off:e}");
    assert!(recording.energy_drift() < 1e-6, "{:e}", recording.energy_drift());
    // The roller lifts off now and then: where it does the run can be taken up, with the law.
    let (point, counts) = recording.restarts.last().expect("restart points");
    assert!(point.time > switched && point.contacts[0].is_by_law);
    let mut rest = Recording::default();
    simulate_with(&scenario, Some(point), &mut rest, 1, &ModelCache::default()).expect("taken up");
    let places =
        |samples: &[Sample]| -> Vec<[f64; 3]> { samples.iter().map(|s| s.points[0].position).collect() };
    assert_eq!(places(&rest.samples), places(&recording.samples[counts[0]..]));
    assert_eq!(by_law(&rest), None, "told once");
}

#[test]
#[ignore = "second tier: half a minute"]
fn a_roller_over_a_beam_is_a_moving_mass() {
    let recording = run(&valid(&folder("travelling"), &roller("", 0.1), &[]));
    assert!(by_law(&recording).is_some_and(|time| time < 1e-3));
    // Lift-offs are events of rounding, and the last ringing of the mass with it.
    let off = off_moving_mass(&recording, 24);
    assert!(off < 5e-3, "{off:e}");
    assert!(recording.energy_drift() < 1e-6, "{:e}", recording.energy_drift());
    let of_law = run(&valid(&folder("travelling"), &roller("", 0.1), &["contacts.touch.model=\"hertz\""]));
    assert!(
        by_law(&of_law).is_none() && off_moving_mass(&of_law, 24) < 5e-3,
        "{:e}",
        off_moving_mass(&of_law, 24)
    );
}
