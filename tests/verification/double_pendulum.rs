//! Two flexible double pendulums ([A] section 6): the first impact; the whole second is in the long tier.

use super::support::{Trace, assert_below, assert_close, run, shipped};
use adaptive::record::TrialOutcome;
use adaptive::sizing::{Candidate, SizeRequest};

/// Shortly after the first impact.
const END: &str = "simulation.end_time=0.1675";

/// Change of the total energy during the first impact, relative to the kinetic energy when it began.
fn impact_drift(trace: &Trace) -> f64 {
    let impact = &trace.impacts[0];
    let inside = |t: f64| impact.start - 1e-6 <= t && t <= impact.end + 1e-6;
    let during: Vec<_> = trace.samples.iter().filter(|s| inside(s.time)).collect();
    let first = &during[0].energies;
    let change = during.iter().map(|s| (s.energies.total() - first.total()).abs());
    change.fold(0.0, f64::max) / first.kinetic
}

#[test]
#[ignore = "second tier: half a minute; the pendulum with Hertz' law is below"]
fn first_impact_of_the_double_pendulums_is_that_of_hertz_and_a_little_harder() {
    let (hertz, elastic) = (run("double_pendulum/hertz", &[END]), run("double_pendulum", &[END]));
    assert_eq!((hertz.impacts.len(), elastic.impacts.len()), (1, 1));
    let (hertz, impact) = (&hertz.impacts[0], &elastic.impacts[0]);
    // Independent program, rods as shear beams: 299.8 N; the limits stand in docs/verification.md.
    assert_close("peak with Hertz spheres", hertz.peak_force, 299.8, 5e-3);
    assert_close("start of the impact", impact.start, 166.82e-3, 0.1 / 166.82);
    assert_close("duration", impact.end - impact.start, 74e-6, 2e-2);
    // A ball is stiffer than the half space: 0.7 % at a contact radius of 1.7 % of the ball's, here 2.1 %.
    let harder = impact.peak_force / hertz.peak_force - 1.0;
    assert!((3e-3..1.2e-2).contains(&harder), "elastic spheres are harder by {harder}");
    assert_below("energy drift over the impact", impact_drift(&elastic), 1e-5);
    let accepted = elastic.trials.iter().filter(|t| t.outcome == TrialOutcome::Accepted).count();
    assert!(accepted == 1 && elastic.trials.len() <= 2, "{} trials", elastic.trials.len());
    // Frictionless contact forces in the plane of symmetry keep the motion in it, up to the error that the control of the step
    // allows: 1e-8 of the velocity in each of some 300 steps of the impact, times the momentum.
    let last = elastic.samples.last().expect("samples");
    let momentum = elastic.samples.iter().map(|s| s.linear_momentum[0].abs()).fold(0.0, f64::max);
    assert_below("motion out of the plane", last.linear_momentum[1].abs(), 300.0 * 1e-8 * momentum);
}

#[test]
fn first_impact_of_the_double_pendulums_with_hertz_law_is_that_of_an_independent_program() {
    let found = run("double_pendulum/hertz", &[END]);
    let [impact] = found.impacts[..] else { panic!("{} impacts", found.impacts.len()) };
    // Rods as shear beams: 299.8 N; the limits stand in docs/verification.md.
    assert_close("peak with Hertz spheres", impact.peak_force, 299.8, 5e-3);
    assert_close("start of the impact", impact.start, 166.82e-3, 0.1 / 166.82);
}

/// Half a cycle is lost between two impacts if the first bending frequency is off by 1e-3: the later impacts need it to 1e-5.
#[test]
fn bending_frequencies_of_the_rods_are_those_of_a_mesh_twice_as_fine() {
    let scenario = shipped("double_pendulum", &[]);
    let rod = scenario.run.bodies.iter().find(|b| b.name == "left_rod").and_then(|b| b.elastic());
    let rod = rod.expect("flexible");
    let candidate = Candidate::new("left_rod", rod, SizeRequest::default());
    let elements = &rod.discretisation.elements;
    let twice: Vec<usize> = elements.iter().map(|n| 2 * n).collect();
    // Four pairs of bending modes, up to 8 kHz; those above follow impacts of 74 µs statically.
    let of = |elements: &[usize]| candidate.spectrum(elements, 8).expect("modes").frequencies;
    for (found, finer) in of(elements).into_iter().zip(of(&twice)) {
        assert_close("frequency", found, finer, 1e-5);
    }
}
