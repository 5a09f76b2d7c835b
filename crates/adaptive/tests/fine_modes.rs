//! Fine models with low-frequency modes of their own, and both ways to transfer the state ([A] 4.4).

use crate::impacts::{ALUMINIUM, STEEL, Trace, body, contact, finished, spec, sphere};
use adaptive::model::RunModel;
use adaptive::spec::GaugeRequest;
use adaptive::spec::LowModes;
use adaptive::spec::TransferMethod;
use adaptive::spec::{
    Area, Attachment, ContactLaw, ContactSpec, CoordinateSpec, Coupling, Extent, JointSpec, Place, PointSpec,
    RunSpec, Target, TransferSpec, Treatment,
};
use ffr_dynamics::system::JointKind;
use iga_core::nurbs::primitives::axisymmetric;
use nalgebra::{UnitQuaternion, Vector3};

const RADIUS: f64 = 10e-3; // m
const LENGTH: f64 = 1.0; // m
const SPEED: f64 = 0.1; // m/s
const METHODS: [TransferMethod; 2] = [TransferMethod::MassOrthogonal, TransferMethod::Printed];

/// `spec` with fine models that have modes of their own.
fn with_own_modes(spec: &RunSpec, method: TransferMethod) -> RunSpec {
    let mut spec = spec.clone();
    let set = |contact: &mut ContactSpec| match &mut contact.law {
        ContactLaw::Surface(law) => law.transfer = TransferSpec { modes: LowModes::Fine, method },
        ContactLaw::Hertz(_) => panic!("contacts of surfaces"),
    };
    spec.contacts.iter_mut().for_each(set);
    spec
}

/// Jumps of the energy at transfers, relative to the energy at the start.
fn jumps(trace: &Trace) -> Vec<f64> {
    let start = trace.samples[0].energies.total();
    trace.transfers.iter().map(|t| (t.energy_after - t.energy_before) / start).collect()
}

/// Compares impacts: peaks to `limit`, times to as much of the duration.
fn same_impacts(own: &Trace, default: &Trace, limit: f64) {
    assert_eq!(own.impacts.len(), default.impacts.len());
    for (a, b) in own.impacts.iter().zip(&default.impacts) {
        assert_eq!(a.contact, b.contact);
        assert!((a.peak_force / b.peak_force - 1.0).abs() < limit, "{a:?} {b:?}");
        let duration = b.end - b.start;
        assert!((a.start - b.start).abs().max((a.end - b.end).abs()) < limit * duration, "{a:?} {b:?}");
    }
    let counts = |t: &Trace| t.trials.len();
    assert_eq!(counts(own), counts(default));
}

/// Relative jump of the energy of a transfer that is permitted (claim 2 of docs/verification.md); 1e-9 come out.
const JUMP: f64 = 1e-5;
/// Momentum that a transfer may create, relative to that at the start: the mass of a NURBS body from the fine model's finer
/// quadrature differs by 2e-9.
const MOMENTUM: f64 = 1e-8;
/// The same of the transfer as printed, which takes the modes of both models for orthogonal to each other: what it leaves is
/// quadratic in their difference, 4e-4 as in the frequencies, whatever the body does at the instant.
const MOMENTUM_PRINTED: f64 = 4e-4 * 4e-4;

/// Momentum that a transfer by `method` may create.
fn momentum_limit(method: TransferMethod) -> f64 {
    match method {
        TransferMethod::MassOrthogonal => MOMENTUM,
        TransferMethod::Printed => MOMENTUM_PRINTED,
    }
}

#[test]
fn sphere_hits_a_plane_as_it_does_with_prolonged_modes() {
    let plane = Target::plane(Vector3::zeros(), Vector3::z());
    let ball = sphere("ball", RADIUS, ALUMINIUM, (RADIUS + 1e-6, -SPEED));
    let default = spec(vec![ball], vec![contact("floor", 0, plane)], 1.5e-4);
    let reference = finished(&default);
    for method in METHODS {
        let own = finished(&with_own_modes(&default, method));
        // The limit asked for is 0.5 %; frequencies differ by 4e-4 at most, and hardly take part.
        same_impacts(&own, &reference, 1e-4);
        let momentum = reference.samples[0].linear_momentum[2].abs();
        for (transfer, jump) in own.transfers.iter().zip(jumps(&own)) {
            assert!(jump.abs() < JUMP && transfer.momentum_change < MOMENTUM * momentum, "{transfer:?}");
        }
    }
}

/// Steel sphere, aluminium rod, gap of 1 um, steel sphere ([A] section 5); the rod hangs on ground by a weak spring at its middle.
fn sphere_rod_sphere() -> RunSpec {
    let rod = axisymmetric::rod(RADIUS, LENGTH).expect("a rod");
    let bodies = vec![
        sphere("left", RADIUS, STEEL, (-RADIUS, SPEED)),
        body("rod", rod, ALUMINIUM, [4, 200], 20, (0.0, 0.0)),
        sphere("right", RADIUS, STEEL, (LENGTH + RADIUS + 1e-6, 0.0)),
    ];
    let contacts = vec![contact("first", 0, Target::Body(1)), contact("second", 2, Target::Body(1))];
    let mut spec = spec(bodies, contacts, 4e-4);
    let point = [0.0, 0.5 * LENGTH, 0.0];
    let extent = Extent::Around { point, radius: 0.5 * RADIUS };
    let middle = Place::Area(Area { extent, centre: point, coupling: Coupling::Average });
    let rotation = UnitQuaternion::identity();
    spec.joints.push(JointSpec {
        name: "spring".into(),
        kind: JointKind::Axial,
        parent: Attachment { body: None, place: Place::Point([0.0, 0.0, 0.5 * LENGTH]), rotation },
        child: Attachment { body: Some(1), place: middle, rotation },
        positions: vec![0.0],
        velocities: vec![0.0],
        has_velocities: true,
        coordinates: vec![CoordinateSpec { stiffness: 1e5, ..CoordinateSpec::default() }],
        bearing: None,
    });
    let end = Place::Point([0.0, LENGTH, 0.0]);
    spec.points.push(PointSpec { name: "end".into(), body: 1, place: end, gauge: GaugeRequest::default() });
    spec
}

#[test]
fn sphere_rod_sphere_is_the_same_with_modes_of_the_fine_models() {
    let default = sphere_rod_sphere();
    let reference = finished(&default);
    assert_eq!(reference.impacts.len(), 2);
    for method in METHODS {
        let own = finished(&with_own_modes(&default, method));
        same_impacts(&own, &reference, 1e-4);
        let directions: Vec<&str> = own.transfers.iter().map(|t| t.direction.identifier()).collect();
        assert_eq!(directions, ["coarse to fine", "fine to coarse"].repeat(2));
        let limit = momentum_limit(method) * reference.samples[0].linear_momentum[2];
        for (transfer, jump) in own.transfers.iter().zip(jumps(&own)) {
            assert!(jump.abs() < JUMP && transfer.momentum_change < limit, "{transfer:?}");
        }
        // Jumps of transfers are no drift of the integration, which stays below 1e-6 with them.
        assert!(own.energy_drift() < 1e-6, "{:e}", own.energy_drift());
        // The transfer is a real one: coordinates differ in impacts, motions do not.
        let same = |f: &dyn Fn(&adaptive::record::Sample) -> f64| {
            let (a, b) = (f(own.last()), f(reference.last()));
            (a / b - 1.0).abs()
        };
        assert!(same(&|s| s.points[0].position[2] - LENGTH) < 1e-4);
        assert!(same(&|s| s.joints[0].positions[0]) < 1e-4);
        assert!(same(&|s| s.bodies[2].velocity[2]) < 1e-4);
    }
}

#[test]
fn observed_points_and_joints_go_on_smoothly_through_a_transfer() {
    let trace = finished(&with_own_modes(&sphere_rod_sphere(), TransferMethod::MassOrthogonal));
    let arrival = trace.impacts[1].start;
    let i = trace.samples.partition_point(|s| s.time <= arrival);
    let (before, after) = (&trace.samples[i - 1], &trace.samples[i]);
    let step = after.time - before.time;
    let [a, b] = [before, after].map(|s| s.points[0]);
    // The end of the rod comes with the wave; from the touch on its dent holds it back, so that it goes on by less than it would freely.
    let (moved, free) = (b.position[2] - a.position[2], step * a.velocity[2]);
    assert!(0.0 < moved && moved < free, "{a:?} {b:?}");
    let [q, p] = [before, after].map(|s| s.joints[0].positions[0]);
    assert!((p - q).abs() < 10e-3 * step + 1e-12, "{q:e} {p:e}");
    // Modes have the signs of the coarse ones.
    let largest = |s: &adaptive::record::Sample| {
        s.bodies[1].elastic_coordinates.iter().fold(0.0f64, |m, q| m.max(q.abs()))
    };
    for (x, y) in before.bodies[1].elastic_coordinates.iter().zip(&after.bodies[1].elastic_coordinates) {
        assert!((x - y).abs() < 0.1 * largest(before), "{x:e} {y:e}");
    }
}

#[test]
fn body_keeps_its_modes_when_a_second_pair_joins() {
    let ball = |name, z, v| sphere(name, RADIUS, STEEL, (z, v));
    for gap in [0.0, 1e-6] {
        let bodies = vec![
            ball("first", -2.0 * RADIUS, SPEED),
            ball("middle", 0.0, 0.0),
            ball("last", 2.0 * RADIUS + gap, 0.0),
        ];
        let contacts = vec![contact("front", 0, Target::Body(1)), contact("back", 1, Target::Body(2))];
        let default = spec(bodies, contacts, 2e-4);
        let reference = finished(&default);
        let own = finished(&with_own_modes(&default, TransferMethod::MassOrthogonal));
        assert!(reference.impacts[1].start < reference.impacts[0].end, "both at once");
        same_impacts(&own, &reference, 1e-3);
        assert!(own.energy_drift() < JUMP, "{:e}", own.energy_drift());
        assert!(jumps(&own).iter().all(|j| j.abs() < JUMP), "{:?}", jumps(&own));
        let momentum = own.samples[0].linear_momentum[2];
        assert!(own.momentum_change(momentum) < 10.0 * MOMENTUM, "{:e}", own.momentum_change(momentum));
    }
}

#[test]
fn own_modes_are_refused_where_a_body_has_one_model_for_the_whole_run() {
    let plane = Target::plane(Vector3::zeros(), Vector3::z());
    let ball = sphere("ball", RADIUS, ALUMINIUM, (RADIUS, -SPEED));
    let mut fixed = contact("floor", 0, plane);
    let ContactLaw::Surface(law) = &mut fixed.law else { panic!("a contact of surfaces") };
    (law.treatment, law.penalty) = (Treatment::Coarse, Some(1e17));
    let refusal = |spec: &RunSpec| match RunModel::build(spec) {
        Ok(_) => panic!("a model"),
        Err(error) => error.to_string(),
    };
    let alone = with_own_modes(&spec(vec![ball.clone()], vec![fixed.clone()], 1e-4), METHODS[0]);
    assert!(refusal(&alone).contains("modes = \"own\" is for contacts that the program refines"));
    let other = sphere("other", RADIUS, ALUMINIUM, (3.0 * RADIUS, -SPEED));
    let mut pair =
        with_own_modes(&spec(vec![ball, other], vec![contact("pair", 0, Target::Body(1))], 1e-4), METHODS[0]);
    pair.contacts.push(fixed);
    let refused = refusal(&pair);
    assert!(refused.contains("\"pair\"") && refused.contains("\"floor\""), "{refused}");
}
