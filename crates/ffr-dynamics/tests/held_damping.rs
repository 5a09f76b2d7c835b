//! Damping ratios of bodies that joints hold: those of the modes of the joined system (docs/theory.md Eq. F.29 to F.33).

use crate::dynamics_support::{Random, Sample, block};
use faer::{Mat, Side};
use ffr_dynamics::body::{DampingLaw, ModalDamping, RayleighDamping, RigidMotion, StandardInputData};
use ffr_dynamics::integration::{Integrator, Method, StepSettings};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, BodySpec, CoordinateForce, GROUND, JointKind, JointSpec, Multibody, OwnDamping, SystemModes,
    SystemSpec,
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Modes of the eigensolver, which are right to 1e-12, over a range of frequencies of ten.
const ROUND_OFF: f64 = 1e-9;

fn turn() -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -0.3, 0.9))
}

/// The block with markers at two corners, in the tangent frame of the first if asked for.
fn block_body(sample: &Sample, name: &str, is_tangent: bool) -> BodySpec {
    let marker = |name: &str, a: usize| sample.marker(name, a, turn(), |j| sample.nodal_rotation(a, j));
    let markers = vec![marker("a", 1), marker("b", 10)];
    let mut body = BodySpec { name: name.into(), data: sample.data.clone(), markers };
    if is_tangent {
        let frame = body.markers[0].tangent_frame(RigidMotion::Spatial);
        body.data = body.data.in_tangent_frame(&frame).unwrap();
        body.markers = body.markers.iter().map(|m| m.in_tangent_frame(&frame).unwrap()).collect();
    }
    body
}

fn rigid_body(name: &str, mass: f64) -> BodySpec {
    let data = StandardInputData::rigid(
        RigidMotion::Spatial,
        mass,
        Vector3::zeros(),
        Matrix3::identity() * mass * 1e-3,
    );
    let marker = |name: &str, x: f64| Marker::rigid(name, Vector3::x() * x, turn());
    BodySpec { name: name.into(), data: data.unwrap(), markers: vec![marker("a", 0.0), marker("b", 0.1)] }
}

fn own(data: &StandardInputData, law: &DampingLaw) -> OwnDamping {
    let free = data.modal_stiffness.iter().enumerate();
    let free = free.map(|(j, k)| 2.0 * law.ratio(j, k.sqrt()) * k.sqrt()).collect();
    OwnDamping { law: law.clone(), highest: f64::INFINITY, free, added: Vec::new() }
}

fn joint(name: &str, kind: JointKind, parent: (&str, &str), child: (&str, &str)) -> JointSpec {
    let at = |(body, marker): (&str, &str)| Attachment::new(body, marker);
    JointSpec::new(name, kind, at(parent), at(child))
}

struct Case {
    name: &'static str,
    bodies: Vec<BodySpec>,
    joints: Vec<JointSpec>,
    loops: Vec<JointSpec>,
}

/// Systems with one flexible body, "block", held by what the names say.
fn cases(sample: &Sample) -> Vec<Case> {
    let block = |is_tangent| block_body(sample, "block", is_tangent);
    let on_ground = |kind| vec![joint("j", kind, (GROUND, "pin"), ("block", "a"))];
    let case = |name, bodies, joints, loops| Case { name, bodies, joints, loops };
    let mut all: Vec<Case> = [
        ("fixed", JointKind::Fixed),
        ("revolute", JointKind::Revolute),
        ("prismatic", JointKind::Prismatic),
        ("cylindrical", JointKind::Cylindrical),
        ("spherical", JointKind::Spherical),
        ("universal", JointKind::Universal),
    ]
    .into_iter()
    .flat_map(|(name, kind)| [false, true].map(|t| case(name, vec![block(t)], on_ground(kind), vec![])))
    .collect();
    let tip = joint("tip", JointKind::Fixed, ("block", "b"), ("mass", "a"));
    all.push(case(
        "tip mass",
        vec![block(false), rigid_body("mass", 5.0)],
        [on_ground(JointKind::Fixed), vec![tip.clone()]].concat(),
        vec![],
    ));
    all.push(case("mass in flight", vec![block(false), rigid_body("mass", 1.0)], vec![tip], vec![]));
    let carried = joint("j", JointKind::Revolute, ("mass", "b"), ("block", "a"));
    let on_carrier = joint("c", JointKind::Prismatic, (GROUND, "pin"), ("mass", "a"));
    all.push(case(
        "on a carrier",
        vec![block(true), rigid_body("mass", 0.4)],
        vec![carried, on_carrier],
        vec![],
    ));
    for (name, kind) in [("two fixed", JointKind::Fixed), ("fixed and spherical", JointKind::Spherical)] {
        let closing = joint("l", kind, ("block", "b"), (GROUND, "far"));
        all.push(case(name, vec![block(false)], on_ground(JointKind::Fixed), vec![closing]));
    }
    let mut sprung = on_ground(JointKind::Revolute);
    sprung[0].coordinates = vec![CoordinateForce { stiffness: 3e3, ..CoordinateForce::default() }];
    all.push(case("torsion spring", vec![block(false)], sprung, vec![]));
    all
}

fn build(case: &Case, sample: &Sample) -> Multibody {
    let far = sample.node(10) - sample.node(1);
    let ground = vec![Marker::rigid("pin", Vector3::zeros(), turn()), Marker::rigid("far", far, turn())];
    let Case { bodies, joints, loops, .. } = case;
    let (bodies, joints, loops) = (bodies.clone(), joints.clone(), loops.clone());
    Multibody::new(SystemSpec { bodies, ground, joints, loops, ..SystemSpec::default() }, Vec::new()).unwrap()
}

fn damped(case: &Case, sample: &Sample, law: &DampingLaw) -> (Multibody, SystemModes) {
    let mut system = build(case, sample);
    let of_body = |b: &BodySpec| (b.data.n_modes() > 0).then(|| own(&b.data, law));
    let all: Vec<Option<OwnDamping>> = case.bodies.iter().map(of_body).collect();
    let y = system.rest();
    system.set_held_damping((0.0, &y), &all).unwrap();
    let modes = system.small_vibrations(0.0, &y).unwrap();
    (system, modes)
}

fn matrix(system: &Multibody, body: usize) -> Mat<f64> {
    let data = &system.model().bodies[body].data;
    let n = data.n_modes();
    match &data.modal_damping {
        ModalDamping::None => Mat::zeros(n, n),
        ModalDamping::PerMode(d) => Mat::from_fn(n, n, |i, j| if i == j { d[i] } else { 0.0 }),
        ModalDamping::Full(d) => d.clone(),
    }
}

fn smallest(matrix: &Mat<f64>) -> f64 {
    matrix.self_adjoint_eigenvalues(Side::Lower).unwrap().into_iter().fold(f64::INFINITY, f64::min)
}

#[test]
fn ratios_hold_however_one_body_is_held() {
    let sample = block(RigidMotion::Spatial, 9);
    let frequency = sample.data.modal_stiffness[0].sqrt() / std::f64::consts::TAU;
    let rayleigh = RayleighDamping::from_frequencies([0.1 * frequency, 3.0 * frequency], 0.03).unwrap();
    let list = vec![0.04, 0.01, 0.02, 0.005];
    let laws = [DampingLaw::Ratios(vec![0.02]), DampingLaw::Rayleigh(rayleigh), DampingLaw::Ratios(list)];
    for case in cases(&sample) {
        for law in &laws {
            let (system, found) = damped(&case, &sample, law);
            let mut number = 0;
            for mode in found.modes.iter().filter(|m| m.squared_frequency > 0.0) {
                let omega = mode.squared_frequency.sqrt();
                let ratio = mode.damping_ratio().unwrap();
                let expected = law.ratio(number, omega);
                if case.name == "torsion spring" {
                    // The spring takes its share of the energy and loses nothing: nearly all of the first mode's, 1e-3 of the next ones', of
                    // which the body has its ratio then.
                    let is_list = matches!(law, DampingLaw::Ratios(list) if list.len() > 1);
                    let is_right = if number == 0 {
                        ratio < 0.1 * expected
                    } else {
                        (ratio / expected - 1.0).abs() < 0.02
                    };
                    assert!(is_list || is_right, "{} {number}: {ratio} {expected}", case.name);
                    number += 1;
                    continue;
                }
                assert!(
                    (ratio / expected - 1.0).abs() < ROUND_OFF,
                    "{} mode {number} of {omega}: {ratio} for {expected}",
                    case.name
                );
                number += 1;
            }
            assert!(number > 0 || case.name == "torsion spring");
            let body = system.model().body_index("block").unwrap();
            let d = matrix(&system, body);
            assert!(smallest(&d) >= -1e-12 * d.norm_l2(), "{}: passive", case.name);
            // One ratio: never below that of the free body, whatever holds it (monotone root of a matrix); in a loop on what that leaves.
            if case.loops.is_empty()
                && matches!(law, DampingLaw::Ratios(list) if list.len() == 1)
                && case.name != "torsion spring"
            {
                let stiffness = &sample.data.modal_stiffness;
                let more = Mat::from_fn(9, 9, |i, j| {
                    d[(i, j)] - if i == j { 0.04 * stiffness[i].sqrt() } else { 0.0 }
                });
                assert!(smallest(&more) > -1e-9 * d.norm_l2(), "{}: {}", case.name, smallest(&more));
            }
        }
    }
}

#[test]
fn bodies_in_flight_keep_the_ratios_of_their_free_modes() {
    let sample = block(RigidMotion::Spatial, 9);
    let law = DampingLaw::Ratios(vec![0.02, 0.01]);
    let case = Case {
        name: "free",
        bodies: vec![block_body(&sample, "block", false)],
        joints: vec![],
        loops: vec![],
    };
    let (system, _) = damped(&case, &sample, &law);
    // What the body came with, none, is left: its owner has set the damping of the free body already.
    assert_eq!(system.model().bodies[0].data.modal_damping, ModalDamping::None);
}

#[test]
fn ratios_of_a_chain_of_flexible_bodies_are_fitted_body_by_body() {
    let sample = block(RigidMotion::Spatial, 9);
    let bodies = || vec![block_body(&sample, "block", false), block_body(&sample, "second", false)];
    let joints = |second| {
        vec![
            joint("one", JointKind::Fixed, (GROUND, "pin"), ("block", "a")),
            joint("two", second, ("block", "b"), ("second", "a")),
        ]
    };
    for second in [JointKind::Fixed, JointKind::Revolute, JointKind::Spherical] {
        let case = Case { name: "chain", bodies: bodies(), joints: joints(second), loops: vec![] };
        let (system, found) = damped(&case, &sample, &DampingLaw::Ratios(vec![0.02]));
        let ratios: Vec<f64> = found.modes.iter().filter_map(|m| m.damping_ratio()).collect();
        // Six elastic deformations of each body move the joint; what is not to be had body by body is more, not less.
        assert!(ratios.iter().all(|r| *r > 0.02 * (1.0 - 1e-4) && *r < 0.025), "{second:?}: {ratios:?}");
        assert!(ratios[..6].iter().all(|r| *r < 0.02 * (1.0 + 1e-4)), "{second:?}: {ratios:?}");
        for body in 0..2 {
            let d = matrix(&system, body);
            assert!(smallest(&d) >= -1e-12 * d.norm_l2());
        }
        // One of them undamped has no damping, and the other one gives modes what it has of their energy.
        let mut system = build(&case, &sample);
        let y = system.rest();
        let law = DampingLaw::Ratios(vec![0.02]);
        system.set_held_damping((0.0, &y), &[Some(own(&sample.data, &law)), None]).unwrap();
        assert_eq!(system.model().bodies[1].data.modal_damping, ModalDamping::None);
        let found = system.small_vibrations(0.0, &y).unwrap();
        let ratios: Vec<f64> = found.modes.iter().filter_map(|m| m.damping_ratio()).collect();
        assert!(ratios.iter().all(|r| *r > 0.0 && *r < 0.0201), "{ratios:?}");
    }
}

/// A tumbling system loses what its damping takes, and no momentum: two blocks, joined to each other alone.
#[test]
fn momenta_and_ledger_stay_exact() {
    let sample = block(RigidMotion::Spatial, 9);
    let bodies = vec![block_body(&sample, "block", false), block_body(&sample, "second", true)];
    let joints = vec![joint("j", JointKind::Spherical, ("block", "b"), ("second", "a"))];
    let case = Case { name: "tumbling", bodies, joints, loops: vec![] };
    for method in [Method::DormandPrince, Method::Gauss, Method::TrBdf2] {
        let (mut system, _) = damped(&case, &sample, &DampingLaw::Ratios(vec![0.05]));
        let mut random = Random(5);
        let mut y = system.rest();
        for i in 0..2 {
            let layout = system.model().bodies[i].layout;
            y[layout.elastic_rates()].iter_mut().for_each(|r| *r = 0.2 * random.next());
            y[layout.velocities()].iter_mut().for_each(|v| *v = 2.0 * random.next());
        }
        system
            .set_error_scale(ffr_dynamics::system::ErrorScale { relative: 1e-8, ..Default::default() })
            .unwrap();
        let start = system.invariants(0.0, &y);
        let mut integrator = Integrator::new(method, StepSettings::default(), 0.0, &y, &system).unwrap();
        integrator.run(&mut system, 4e-3, |_, _| true).unwrap();
        let end_state = integrator.state().to_vec();
        let end = system.invariants(4e-3, &end_state);
        let lost = system.dissipated_work(&end_state);
        let energy = |i: &ffr_dynamics::system::free_body::invariants::Invariants| i.kinetic + i.elastic;
        assert!(lost > 1e-3 * energy(&start), "{method:?}: {lost} of {start:?}");
        // Error control of 1e-8 a step, some hundred steps.
        assert!((energy(&start) - energy(&end) - lost).abs() < 1e-6 * energy(&start), "{method:?}");
        assert!(
            (start.linear_momentum - end.linear_momentum).norm() < 1e-7 * start.linear_momentum.norm(),
            "{method:?}"
        );
        let spin = (start.angular_momentum - end.angular_momentum).norm();
        assert!(spin < 1e-7 * start.angular_momentum.norm(), "{method:?}: {spin}");
    }
}
