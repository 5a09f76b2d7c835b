//! Stress in bodies that are refined during the run, against Hertz's half space on the axis of contact.

use crate::impacts::{
    ALUMINIUM, STEEL, Solid, Trace, contact, finished, law, soft_law, spec, sphere, try_run,
};
use adaptive::AdaptiveError;
use adaptive::record::StressRecord;
use adaptive::record::TrialOutcome;
use adaptive::spec::GaugeRequest;
use adaptive::spec::LowModes;
use adaptive::spec::{
    BodyKind, BodySpec, ContactLaw, DiscretisationSpec, ElasticSpec, InitialMotion, Place, PointSpec,
    ReductionSpec, RunSpec, StressInstant, StressSpec, SurfaceLaw, Target, Treatment,
};
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::primitives::sphere::{SphereNet, sphere as ball};
use nalgebra::{UnitQuaternion, Vector3};

const RADIUS: f64 = 10e-3; // m
const SPEED: f64 = 0.1; // m/s
/// Depth of the lines [m]: two contact radii, some 0.17 mm each.
const DEPTH: f64 = 0.35e-3;

/// A line from the surface point `from` inwards along `inwards`.
fn line(name: &str, body: usize, from: [f64; 3], inwards: [f64; 3], at: StressInstant) -> StressSpec {
    let to = std::array::from_fn(|c| from[c] + DEPTH * inwards[c]);
    StressSpec { name: name.into(), body, ends: [from, to], samples: 71, at }
}

/// A steel sphere flies up at an aluminium one.
fn pair(law: SurfaceLaw) -> RunSpec {
    let bodies = vec![
        sphere("left", RADIUS, STEEL, (-RADIUS - 1e-6, SPEED)),
        sphere("right", RADIUS, ALUMINIUM, (RADIUS, 0.0)),
    ];
    let pair = contact("impact", 0, Target::Body(1));
    let mut run =
        spec(bodies, vec![adaptive::spec::ContactSpec { law: ContactLaw::Surface(law), ..pair }], 1.5e-4);
    let at = StressInstant::PeakForce;
    run.stress.push(line("left", 0, [0.0, RADIUS, 0.0], [0.0, -1.0, 0.0], at));
    run.stress.push(line("right", 1, [0.0, -RADIUS, 0.0], [0.0, 1.0, 0.0], at));
    run
}

/// Largest pressure [Pa] and contact radius [m] of Hertz's theory at force `force` [N] (Johnson 4.22 to 4.24).
fn hertz(force: f64, radius: f64, solids: &[Solid]) -> (f64, f64) {
    let modulus = 1.0 / solids.iter().map(|s| (1.0 - s.poisson * s.poisson) / s.youngs).sum::<f64>();
    let a = (0.75 * force * radius / modulus).cbrt();
    (1.5 * force / (std::f64::consts::PI * a * a), a)
}

/// Radial and axial stress on the axis over the largest pressure, `depth` in contact radii (Johnson 3.45).
fn on_axis(depth: f64, poisson: f64) -> [f64; 2] {
    let axial = -1.0 / (1.0 + depth * depth);
    let radial = -(1.0 + poisson) * (1.0 - depth * (1.0 / depth).atan()) - 0.5 * axial;
    [radial, axial]
}

/// Largest deviation from the half space between 0.2 and 2 contact radii, over the largest pressure. `normal` and `lateral` pick the
/// stress components.
fn deviation(
    record: &StressRecord,
    (p0, a): (f64, f64),
    poisson: f64,
    (normal, lateral): (usize, usize),
) -> f64 {
    let first = Vector3::from(record.points[0]);
    let mut worst = 0.0_f64;
    for (point, stress) in record.points.iter().zip(&record.stress) {
        let depth = (Vector3::from(*point) - first).norm() / a;
        if (0.2..=2.0).contains(&depth) {
            let [radial, axial] = on_axis(depth, poisson);
            worst = worst.max((stress[normal] / p0 - axial).abs()).max((stress[lateral] / p0 - radial).abs());
        }
    }
    worst
}

#[test]
fn spheres_refined_during_the_run_have_the_stress_of_hertz() {
    let trace = finished(&pair(soft_law()));
    let impact = trace.impacts[0];
    assert!(trace.trials.len() > 1, "trials that were given up leave no stress");
    let zone = hertz(impact.peak_force, 0.5 * RADIUS, &[STEEL, ALUMINIUM]);
    for (record, solid) in trace.stresses.iter().zip([STEEL, ALUMINIUM]) {
        assert!((record.time - impact.peak_time).abs() < 1e-6, "{:e} {:e}", record.time, impact.peak_time);
        // rr, zz of the axisymmetric model.
        let worst = deviation(record, zone, solid.poisson, (1, 0));
        println!("{}: {worst:.4} of {:.1} MPa", record.name, 1e-6 * zone.0);
        // The ball is finite: a/R is 0.03 for the relative radius, and the stress is off by some share of that.
        assert!(worst < 0.02, "{}: {worst}", record.name);
    }
    // Both bodies feel the same pressure at the surface.
    let surface = |i: usize| trace.stresses[i].stress[0][1];
    assert!((surface(0) / surface(1) - 1.0).abs() < 0.05, "{:e} {:e}", surface(0), surface(1));
}

/// Points on the lines of [`pair`], on the surface and below it, with their number on the line.
fn gauges() -> Vec<(PointSpec, usize)> {
    let gauge = GaugeRequest { strain: true, stress: true };
    let at = |body: usize, n: usize| {
        let depth = DEPTH * n as f64 / 70.0;
        let z = if body == 0 { RADIUS - depth } else { depth - RADIUS };
        (PointSpec { name: format!("{body}-{n}"), body, place: Place::Point([0.0, z, 0.0]), gauge }, n)
    };
    [(0, 0), (0, 20), (0, 70), (1, 0), (1, 13)].map(|(body, n)| at(body, n)).to_vec()
}

/// The history of stress at points and the line at one instant go different ways: rows of the flexibility at the points, and the displacement of
/// all unknowns.
#[test]
fn history_at_points_meets_the_line_at_its_instant() {
    let mut run = pair(law());
    run.points = gauges().into_iter().map(|(point, _)| point).collect();
    let trace = finished(&run);
    let record = &trace.stresses[0];
    let sample =
        trace.samples.iter().find(|s| s.time.to_bits() == record.time.to_bits()).expect("the instant");
    let largest = record.von_mises.iter().fold(0.0_f64, |m, s| m.max(*s));
    for ((point, n), found) in gauges().iter().zip(&sample.points) {
        let line = &trace.stresses[point.body];
        for (a, b) in found.state.stress.iter().zip(&line.stress[*n]) {
            // Round-off of two solutions with the flexibility, whose condition is some 1e6.
            assert!((a - b).abs() < 1e-9 * largest, "{}: {a:e} {b:e}", point.name);
        }
        // Hooke's law, round-off.
        let solid = [STEEL, ALUMINIUM][point.body];
        let [rr, zz, tt] = [0, 1, 2].map(|i| found.state.stress[i]);
        let strain = (zz - solid.poisson * (rr + tt)) / solid.youngs;
        assert!((found.state.strain[1] - strain).abs() < 1e-12 * largest / solid.youngs, "{}", point.name);
    }
    // Before the touch the sphere moves without stress.
    assert!(trace.samples[0].points.iter().all(|p| p.state.von_mises() < 1e-6 * largest));
}

#[test]
fn history_at_points_is_the_same_on_modes_of_the_fine_model() {
    let mut run = pair(law());
    run.stress.clear();
    run.points = gauges().into_iter().map(|(point, _)| point).collect();
    let peak = |run: &RunSpec| {
        let trace = finished(run);
        let of = |i: usize| trace.samples.iter().map(|s| s.points[i].state.stress[1]).fold(0.0_f64, f64::min);
        (0..run.points.len()).map(of).collect::<Vec<f64>>()
    };
    let prolonged = peak(&run);
    let mut law = law();
    law.transfer.modes = LowModes::Fine;
    run.contacts[0].law = ContactLaw::Surface(law);
    let own = peak(&run);
    println!("{prolonged:?} {own:?}");
    let largest = prolonged.iter().fold(0.0_f64, |m, s| m.min(*s)).abs();
    // Forces agree to 1e-4; steps of other modes meet the peak, a parabola in time, at other places.
    assert!(prolonged.iter().zip(&own).all(|(a, b)| (a - b).abs() < 2e-3 * largest));
}

#[test]
fn stress_at_an_instant_is_complete_in_an_impact_and_that_of_the_modes_outside() {
    let mut run = pair(law());
    let peak = finished(&run).impacts[0].peak_time;
    run.stress = [peak, 1.4e-4]
        .map(|at| line("left", 0, [0.0, RADIUS, 0.0], [0.0, -1.0, 0.0], StressInstant::Time(at)))
        .to_vec();
    let trace = finished(&run);
    assert!(trace.impacts[0].end < 1.3e-4, "the impact is over");
    let largest = |i: usize| trace.stresses[i].von_mises.iter().fold(0.0_f64, |m, s| m.max(*s));
    println!("{:.3e} Pa in the impact, {:.3e} Pa after it", largest(0), largest(1));
    assert!(largest(0) > 500.0 * largest(1));
}

#[test]
fn states_of_trials_given_up_are_no_stress_states() {
    let mut run = pair(soft_law());
    // The nearest step of either trial would do: only those of the accepted one are stored.
    run.stress = (1..=12)
        .map(|i| StressInstant::Time(f64::from(i) * 8.1e-6))
        .map(|at| line("left", 0, [0.0, RADIUS, 0.0], [0.0, -1.0, 0.0], at))
        .collect();
    let trace = finished(&run);
    assert!(trace.trials.iter().any(|t| t.outcome == TrialOutcome::Rejected));
    for record in &trace.stresses {
        let is_stored = trace.samples.iter().any(|s| s.time.to_bits() == record.time.to_bits());
        // Between impacts it is the time itself, of which there is one state.
        let is_asked = run.stress.iter().any(|request| request.at == StressInstant::Time(record.time));
        let is_free = !trace.impacts.iter().any(|i| (i.start..=i.end).contains(&record.time));
        assert!(is_stored || is_asked && is_free, "{:e}", record.time);
    }
}

/// A solid aluminium ball falls on a plane with a pole of its net below, so that its net is turned for the contact.
#[test]
#[ignore = "second tier: ten seconds; an axisymmetric ball is in the first"]
fn solid_ball_refined_about_a_pole_of_its_net_has_the_stress_of_hertz() {
    let material = Material::new(ALUMINIUM.youngs, ALUMINIUM.poisson, ALUMINIUM.density).expect("a material");
    let discretisation = DiscretisationSpec {
        degrees: vec![2, 2, 3],
        elements: vec![4, 4, 4],
        knots: None,
        refine: Vec::new(),
    };
    let reduction = ReductionSpec::CraigBampton { modes: 5, fixed_interface_modes: None };
    let shape = ball(RADIUS, SphereNet::Spindle).expect("a ball");
    let elastic = ElasticSpec::new(shape, Model::Solid, material, discretisation, reduction);
    let rotation = UnitQuaternion::from_euler_angles(std::f64::consts::FRAC_PI_2, 0.0, 0.0);
    let motion = InitialMotion {
        position: Vector3::z() * RADIUS,
        rotation,
        velocity: Vector3::z() * -SPEED,
        angular_velocity: Vector3::zeros(),
    };
    let body = BodySpec { name: "ball".into(), kind: BodyKind::Elastic(Box::new(elastic)), motion };
    let mut settings = law();
    settings.interval.elements = Some(12);
    let plane = Target::plane(Vector3::zeros(), Vector3::z());
    let contact =
        adaptive::spec::ContactSpec { law: ContactLaw::Surface(settings), ..contact("impact", 0, plane) };
    let mut run = spec(vec![body], vec![contact], 1e-4);
    let lowest = rotation.inverse() * -Vector3::z();
    run.stress.push(line("axis", 0, (RADIUS * lowest).into(), (-lowest).into(), StressInstant::PeakForce));
    let trace = finished(&run);
    let zone = hertz(trace.impacts[0].peak_force, RADIUS, &[ALUMINIUM]);
    // The axis of contact is y of the body, x lies across.
    let worst = deviation(&trace.stresses[0], zone, ALUMINIUM.poisson, (1, 0));
    println!("solid: {worst:.4} of {:.1} MPa", 1e-6 * zone.0);
    // Twelve elements across resolve the stress to some hundredths.
    assert!(worst < 0.04, "{worst}");
}

#[test]
fn stress_where_the_fine_model_moves_otherwise_is_refused() {
    let own = {
        let mut law = law();
        law.transfer.modes = LowModes::Fine;
        law
    };
    let mut damped = SurfaceLaw { treatment: Treatment::Damped, penalty: Some(1e17), ..law() };
    damped.interval.width = Some(3e-4);
    for law in [own, damped] {
        let error = try_run(&pair(law), &mut Trace::default()).expect_err("an error");
        let text = error.to_string();
        assert!(matches!(error, AdaptiveError::Unsupported { .. }) && error.is_model_error(), "{text}");
        assert!(text.contains("output.stress.left") && text.contains("\"impact\""), "{text}");
    }
    let mut run = pair(SurfaceLaw { treatment: Treatment::Damped, penalty: Some(1e17), ..law() });
    run.stress.clear();
    run.points.push(gauges().remove(0).0);
    let text = try_run(&run, &mut Trace::default()).expect_err("an error").to_string();
    assert!(text.contains("output.points.0-0") && text.contains("\"impact\""), "{text}");
}
