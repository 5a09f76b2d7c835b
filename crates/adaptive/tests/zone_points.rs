//! Observed points in contact zones: they show the dent.

use crate::impacts::{ALUMINIUM, STEEL, contact, finished, law, spec, sphere};
use adaptive::model::RunModel;
use adaptive::record::Sample;
use adaptive::run::driver::resume;
use adaptive::run::recording::Recording;
use adaptive::spec::GaugeRequest;
use adaptive::spec::LowModes;
use adaptive::spec::{
    BodySpec, ContactLaw, ContactSpec, PenaltySearch, Place, PointSpec, RefinementSpec, RunSpec, SurfaceLaw,
    Target, Treatment,
};
use nalgebra::Vector3;

const RADIUS: f64 = 10e-3; // m
const SPEED: f64 = 0.1; // m/s

fn point(name: &str, body: usize, z: f64) -> PointSpec {
    PointSpec { name: name.into(), body, place: Place::Point([0.0, z, 0.0]), gauge: GaugeRequest::default() }
}

/// A steel sphere flies up at an aluminium one; the points that meet are observed, and the far pole of the first one.
fn pair(law: SurfaceLaw) -> RunSpec {
    let bodies = vec![
        sphere("left", RADIUS, STEEL, (-RADIUS - 1e-6, SPEED)),
        sphere("right", RADIUS, ALUMINIUM, (RADIUS, 0.0)),
    ];
    let pair = ContactSpec { law: ContactLaw::Surface(law), ..contact("impact", 0, Target::Body(1)) };
    let mut run = spec(bodies, vec![pair], 1.5e-4);
    run.points = vec![point("top", 0, RADIUS), point("bottom", 1, -RADIUS), point("far", 0, -RADIUS)];
    run
}

/// An aluminium sphere, refined at its lower pole, falls on a plane and has one model for the whole run.
fn on_plane() -> RunSpec {
    let BodySpec { name, mut kind, motion } = sphere("ball", RADIUS, ALUMINIUM, (RADIUS, -SPEED));
    if let adaptive::spec::BodyKind::Elastic(elastic) = &mut kind {
        elastic.discretisation.elements = vec![2, 2];
        elastic.discretisation.refine =
            vec![RefinementSpec { centre: [0.0, -RADIUS, 0.0], width: 0.3e-3, elements: 6, ratio: 2.0 }];
    }
    let law = SurfaceLaw {
        treatment: Treatment::Quasistatic,
        penalty: Some(1e18),
        search: PenaltySearch::Fixed,
        ..law()
    };
    let plane = Target::plane(Vector3::zeros(), Vector3::z());
    let contact = ContactSpec { law: ContactLaw::Surface(law), ..contact("impact", 0, plane) };
    let mut run = spec(vec![BodySpec { name, kind, motion }], vec![contact], 1.2e-4);
    run.points = vec![point("bottom", 0, -RADIUS)];
    run
}

fn z(sample: &Sample, point: usize) -> f64 {
    sample.points[point].position[2]
}

fn loaded(trace: &Recording) -> impl Iterator<Item = &Sample> {
    let peak = trace.samples.iter().map(|s| s.contacts[0].normal_force).fold(0.0, f64::max);
    trace.samples.iter().filter(move |s| s.contacts[0].normal_force > 0.1 * peak)
}

/// What bodies overlap by where they touch is what penalty springs need. Without the dent it is the whole approach.
fn surfaces_meet(trace: &Recording, overlap: impl Fn(&Sample) -> f64, approach: f64) {
    let mut worst = 0.0_f64;
    for sample in loaded(trace) {
        let allowed = 1.001 * sample.contacts[0].penetration + 1e-12;
        let found = overlap(sample);
        worst = worst.max(found.abs());
        // The pole is a contact point of its own; forces there vary by more than elsewhere, and it may be open by as much.
        assert!(found.abs() <= allowed, "{:e} s: {found:e} m, penetration {allowed:e} m", sample.time);
    }
    println!("overlap of the observed points {worst:.2e} m, approach {approach:.2e} m");
    assert!(worst < 0.05 * approach, "{worst:e} {approach:e}");
}

/// Velocities are the rates of positions: central differences over the stored steps, whose error is that of a step's square.
fn velocities_are_rates(trace: &Recording, point: usize, tolerance: f64) {
    let samples: Vec<&Sample> = loaded(trace).collect();
    let mut worst = 0.0_f64;
    for w in samples.windows(3) {
        let [h, k] = [w[1].time - w[0].time, w[2].time - w[1].time];
        let (a, b) = ((z(w[1], point) - z(w[0], point)) / h, (z(w[2], point) - z(w[1], point)) / k);
        let rate = (a * k + b * h) / (h + k);
        worst = worst.max((w[1].points[point].velocity[2] - rate).abs());
    }
    println!("point {point}: velocities and rates differ by {worst:.2e} m/s");
    assert!(worst < tolerance, "{worst:e}");
}

#[test]
fn poles_of_spheres_refined_during_the_run_meet() {
    for modes in [LowModes::Prolonged, LowModes::Fine] {
        let mut law = law();
        law.transfer.modes = modes;
        let trace = finished(&pair(law));
        let approach =
            loaded(&trace).map(|s| (s.bodies[0].position[2] + 2.0 * RADIUS - s.bodies[1].position[2]).abs());
        let approach = approach.fold(0.0, f64::max);
        surfaces_meet(&trace, |s| z(s, 0) - z(s, 1), approach);
        // The approach turns around at 0.1 m/s within some 40 steps.
        for point in [0, 1] {
            velocities_are_rates(&trace, point, 0.05 * SPEED);
        }
        // After the impact there is no dent: the pole moves with its modes alone, as the far one does.
        let last = trace.last();
        let swing = last.points[0].velocity[2] - last.points[2].velocity[2];
        assert!(swing.abs() < 0.1 * SPEED, "{swing:e}");
    }
}

#[test]
fn pole_of_a_sphere_with_one_model_for_the_whole_run_stays_on_the_plane() {
    let trace = finished(&on_plane());
    let approach = loaded(&trace).map(|s| RADIUS - s.bodies[0].position[2]).fold(0.0, f64::max);
    surfaces_meet(&trace, |s| -z(s, 0), approach);
    velocities_are_rates(&trace, 0, 0.05 * SPEED);
}

#[test]
fn points_of_a_run_taken_up_again_are_the_same_to_the_last_bit() {
    let run = pair(law());
    let whole = finished(&run);
    let mut points = whole.restarts.iter().map(|(point, _)| point);
    let point = points.find(|p| p.phase.start > 0.0).expect("the start of the impact");
    let mut model = RunModel::build(&run).unwrap_or_else(|e| panic!("{e}"));
    let mut rest = Recording::default();
    let end = resume(&mut model, &run.settings, point, &mut rest);
    assert!(end.is_ok(), "{end:?}");
    let n = whole.samples.len() - rest.samples.len();
    assert!(!rest.samples.is_empty() && n > 0);
    for (a, b) in whole.samples[n..].iter().zip(&rest.samples) {
        assert_eq!(a.points, b.points, "{:e} s", a.time);
    }
}
