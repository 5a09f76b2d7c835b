//! Gauss collocation: orders, energy, what is left of modes that are not resolved, and its linear systems by way of the tree.

use crate::dynamics_support::{Random, block};
use crate::free_motion::{free_system, state_vector};
use crate::small_equations::{ECCENTRICITY, Given, PERIHELION, distance, kepler_rate, slope};
use faer::c64;
use ffr_dynamics::body::{ModalDamping, RigidMotion};
use ffr_dynamics::integration::{
    DenseOutput, Integrator, KinematicBlock, Linearisation, Method, OdeSystem, StepSettings,
};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, BodySpec, CoordinateForce, ErrorScale, GROUND, JointKind, JointSpec, Multibody, SystemSpec,
};
use nalgebra::{UnitQuaternion, Vector3};

const OMEGA: f64 = std::f64::consts::TAU;

fn oscillator(omega: f64) -> impl FnMut(f64, &[f64], &mut [f64]) {
    move |_, y, dydt| dydt.copy_from_slice(&[y[1], -omega * omega * y[0]])
}

/// An oscillator whose position and velocity the method knows as such.
fn vibrating(omega: f64, tolerance: f64) -> Given<impl FnMut(f64, &[f64], &mut [f64])> {
    let mut system = Given::new(2, tolerance, oscillator(omega));
    system.blocks = vec![KinematicBlock::Vector { position: 0, velocity: 1, len: 1 }];
    system
}

#[test]
fn global_error_drops_with_order_eight() {
    let aphelion = [-(1.0 + ECCENTRICITY), 0.0, 0.0, -1.0 / PERIHELION[3]];
    let blocks = [Vec::new(), vec![KinematicBlock::Vector { position: 0, velocity: 2, len: 2 }]];
    for blocks in blocks {
        let errors = [16.0, 20.0, 24.0, 28.0].map(|n| {
            let h = std::f64::consts::PI / n;
            // The tolerance only steers the iterations here: far below the error of the steps.
            let mut system = Given::new(4, 1e-10, kepler_rate);
            system.blocks.clone_from(&blocks);
            let mut integrator =
                Integrator::new(Method::Gauss, StepSettings::fixed(h), 0.0, &PERIHELION, &system).unwrap();
            integrator.run(&mut system, std::f64::consts::PI, |_, _| true).unwrap();
            (h, distance(integrator.state(), &aphelion))
        });
        let measured = slope(&errors);
        // Within half an order, as steps of a quarter radian are not yet small.
        assert!((measured - 8.0).abs() < 0.5, "order {measured}, errors {errors:?}");
    }
}

#[test]
fn the_estimate_is_the_error_of_vibration_and_the_interpolant_has_order_six() {
    let (mut errors, mut interpolated) = (Vec::new(), Vec::new());
    for h in [0.24, 0.16, 0.12] {
        let mut system = vibrating(OMEGA, 1.0);
        let settings = StepSettings { initial_step: Some(h), max_step: h, ..StepSettings::default() };
        let mut integrator = Integrator::new(Method::Gauss, settings, 0.0, &[0.0, OMEGA], &system).unwrap();
        let step = integrator.step(&mut system, 1.0).unwrap();
        assert!((step.end - h).abs() < 1e-15);
        let exact = |t: f64| [(OMEGA * t).sin(), OMEGA * (OMEGA * t).cos()];
        let error = distance(integrator.state(), &exact(h));
        // They differ by powers of h ω, 0.7 to 1.5, over the 2 s + 3 = 11 of the next term.
        assert!((step.error / error - 1.0).abs() < 0.25, "{} {error:e}", step.error);
        let of_phase = |y: &[f64], t: f64| (OMEGA * (y[0] - exact(t)[0])).hypot(y[1] - exact(t)[1]);
        errors.push((h, of_phase(integrator.state(), h)));
        let (mut worst, mut y) = (0.0_f64, [0.0; 2]);
        for i in 1..20 {
            let t = h * f64::from(i) / 20.0;
            integrator.interpolate(t, &mut y);
            worst = worst.max(of_phase(&y, t));
        }
        interpolated.push((h, worst));
        integrator.interpolate(h, &mut y);
        assert!(distance(&y, integrator.state()) < 1e-13);
        integrator.interpolate(0.0, &mut y);
        assert!(distance(&y, &[0.0, OMEGA]) < 1e-13);
    }
    // h ω is 0.7 to 1.5: what follows the leading term shifts the slope by some hundredths.
    assert!((slope(&errors) - 9.0).abs() < 0.15, "{errors:?}");
    assert!((slope(&interpolated) - 6.0).abs() < 0.15, "{interpolated:?}");
}

#[test]
fn vibration_keeps_its_energy_whatever_the_step() {
    for omega in [10.0, 1e3, 1e5, 1e7] {
        let mut system = vibrating(omega, 1e-13 * omega);
        let mut integrator =
            Integrator::new(Method::Gauss, StepSettings::fixed(1e-2), 0.0, &[0.6, 0.8 * omega], &system)
                .unwrap();
        integrator.run(&mut system, 10.0, |_, _| true).unwrap();
        let y = integrator.state();
        let energy = y[0] * y[0] + (y[1] / omega).powi(2);
        // Round-off of a thousand steps of some thirty sums, with rates that are h ω times as large as what they change.
        let round_off = 30.0 * f64::EPSILON * 1e3 * (1e-2 * omega).max(1.0);
        assert!((energy - 1.0).abs() < round_off, "{omega:e}: {:e}", energy - 1.0);
    }
}

#[test]
fn the_interpolant_of_an_unresolved_mode_stays_near_the_amplitude() {
    for omega in [3e2, 1e3, 1e4, 1e6] {
        let mut system = vibrating(omega, 1e9);
        let mut integrator =
            Integrator::new(Method::Gauss, StepSettings::fixed(1e-2), 0.0, &[1.0, 0.0], &system).unwrap();
        integrator.step(&mut system, 1.0).unwrap();
        let mut y = [0.0; 2];
        for i in 0..=50 {
            integrator.interpolate(2e-4 * f64::from(i), &mut y);
            // Stages alternate in sign; between them a polynomial of degree five overshoots by half.
            assert!(y[0].abs() < 1.5 && y[1].abs() < 1.5 * omega, "{omega:e}: {y:?}");
        }
    }
}

#[test]
fn forces_that_change_with_time_and_quadratures_are_integrated() {
    // x'' = -100 x + cos 3 t, and the work of the force.
    let rate = |t: f64, y: &[f64], d: &mut [f64]| {
        d.copy_from_slice(&[y[1], -100.0 * y[0] + (3.0 * t).cos(), (3.0 * t).cos() * y[1]]);
    };
    let mut system = Given::new(3, 1e-10, rate);
    system.blocks = vec![KinematicBlock::Vector { position: 0, velocity: 1, len: 1 }];
    let mut integrator =
        Integrator::new(Method::Gauss, StepSettings::default(), 0.0, &[0.0; 3], &system).unwrap();
    integrator.run(&mut system, 2.0, |_, _| true).unwrap();
    let y = integrator.state();
    let exact = ((6.0_f64).cos() - (20.0_f64).cos()) / 91.0;
    let energy = 0.5 * y[1] * y[1] + 50.0 * y[0] * y[0];
    // The tolerance of a step times some twenty steps.
    assert!((y[0] - exact).abs() < 1e-8 && (y[2] - energy).abs() < 1e-8, "{y:?}");
}

/// A flexible body on springs, two more on it, one of them in a frame of its own with a full mass matrix, with damping.
fn tree() -> Multibody {
    let sample = block(RigidMotion::Spatial, 8);
    let marker = |name: &str, a: usize| {
        sample.marker(name, a, UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5), |j| {
            sample.nodal_rotation(a, j)
        })
    };
    let markers = || vec![marker("a", 0), marker("b", 11), marker("c", 7)];
    let mut damped = sample.data.clone();
    damped.modal_damping = ModalDamping::PerMode((0..8).map(|j| 3.0 + f64::from(j)).collect());
    let frame = markers()[0].tangent_frame(RigidMotion::Spatial);
    let tangent = sample.data.in_tangent_frame(&frame).unwrap();
    let tangent_markers: Vec<Marker> =
        markers().iter().map(|m| m.in_tangent_frame(&frame).unwrap()).collect();
    let body = |name: &str, data: &ffr_dynamics::body::StandardInputData, markers: Vec<Marker>| BodySpec {
        name: name.to_string(),
        data: data.clone(),
        markers,
    };
    let at = Attachment::new;
    let mut first = JointSpec::new("first", JointKind::Universal, at(GROUND, "a"), at("one", "a"));
    let spring = CoordinateForce { stiffness: 3e3, damping: 20.0, ..CoordinateForce::default() };
    first.coordinates = vec![spring.clone(), spring];
    let spec = SystemSpec {
        bodies: vec![
            body("three", &tangent, tangent_markers),
            body("one", &damped, markers()),
            body("two", &sample.data, markers()),
        ],
        ground: vec![Marker::rigid("a", Vector3::zeros(), UnitQuaternion::identity())],
        joints: vec![
            first,
            JointSpec::new("second", JointKind::Revolute, at("one", "b"), at("two", "a")),
            JointSpec::new("third", JointKind::Cylindrical, at("one", "c"), at("three", "a")),
        ],
        ..SystemSpec::default()
    };
    Multibody::new(spec, Vec::new()).unwrap()
}

/// Derivatives of all rates at rest by central differences, column by column: the accelerations are linear to the square of the step.
fn differences(system: &mut Multibody, y: &[f64], step: f64) -> Linearisation {
    let pairs: Vec<(usize, usize)> = system
        .kinematics()
        .iter()
        .flat_map(|block| match *block {
            KinematicBlock::Vector { position, velocity, len } => {
                (0..len).map(move |i| (position + i, velocity + i))
            }
            _ => panic!("no quaternions here"),
        })
        .collect();
    let mut derivative = Linearisation::new(pairs.len());
    for (j, &(position, velocity)) in pairs.iter().enumerate() {
        for (place, by_velocity) in [(position, false), (velocity, true)] {
            let mut sides = [1.0, -1.0].map(|sign| {
                let mut moved = y.to_vec();
                moved[place] += sign * step;
                let mut rates = vec![0.0; y.len()];
                system.rhs(0.0, &moved, &mut rates).unwrap();
                pairs.iter().map(|p| rates[p.1]).collect::<Vec<f64>>()
            });
            let [forth, back] = &mut sides;
            let column = if by_velocity {
                derivative.velocity_column_mut(j)
            } else {
                derivative.position_column_mut(j)
            };
            for (c, (f, b)) in column.iter_mut().zip(forth.iter().zip(back.iter())) {
                *c = (f - b) / (2.0 * step);
            }
        }
    }
    derivative
}

#[test]
fn the_tree_solves_the_systems_of_the_stages() {
    let mut system = tree();
    let mut y = system.rest();
    for (body, angles) in [(1, vec![0.0, 0.0]), (2, vec![0.7]), (0, vec![-0.4, 0.02])] {
        let rest = vec![0.0; angles.len()];
        system.set_joint(&mut y, body, &angles, &rest).unwrap();
    }
    let derivative = differences(&mut system, &y, 1e-6);
    let n = derivative.n_unknowns();
    let mut rates = vec![0.0; y.len()];
    system.rhs(0.0, &y, &mut rates).unwrap();
    assert!(system.hold());
    let motion: Vec<f64> = (0..n).map(|j| (1.0 + j as f64).sin()).collect();
    let known: Vec<c64> = (0..n).map(|j| c64::new((2.0 * j as f64).cos(), (3.0 * j as f64).sin())).collect();
    for weight in [c64::new(2e-5, 1e-5), c64::new(1e-3, 2e-3), c64::new(0.3, 0.1)] {
        let scale = c64::new(0.5, -0.8);
        let mut x = known.clone();
        assert!(system.factorise_held(1, weight));
        system.solve_held(1, &mut x, scale, &motion);
        // The residual of the system with the differences, as a share of its largest term.
        let (mut worst, mut size) = (0.0_f64, 0.0_f64);
        for i in 0..n {
            let mut residual = x[i] - known[i];
            for j in 0..n {
                let by_position = derivative.position_column(j)[i];
                let term = x[j] * (weight * derivative.velocity_column(j)[i] + weight * weight * by_position);
                residual -= term + scale * by_position * motion[j];
                size = size.max(term.norm()).max((scale * by_position * motion[j]).norm());
            }
            worst = worst.max(residual.norm());
        }
        // Differences leave the square of their step, 1e-12, and round-off over the step, 1e-10.
        assert!(worst < 1e-8 * size, "{weight}: {worst:e} of {size:e}");
    }
}

/// State at the end, with the tolerance `relative`, and evaluations.
fn end(method: Method, system: &mut Multibody, y: &[f64], relative: f64, t_end: f64) -> (Vec<f64>, u64) {
    system.set_error_scale(ErrorScale { relative, ..ErrorScale::default() }).unwrap();
    let mut integrator = Integrator::new(method, StepSettings::default(), 0.0, y, system).unwrap();
    integrator.run(system, t_end, |_, _| true).unwrap();
    (integrator.state().to_vec(), integrator.statistics().evaluations)
}

/// Largest difference of two states, as a share of the largest entry of `b` in the same body's positions or velocities.
fn deviation(system: &Multibody, a: &[f64], b: &[f64]) -> f64 {
    let parts = system.model().bodies.iter().flat_map(|body| {
        let l = body.layout;
        [l.positions(), l.velocities(), l.elastic(), l.elastic_rates()]
    });
    let of_part = |range: std::ops::Range<usize>| {
        let size = b[range.clone()].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let worst = a[range.clone()].iter().zip(&b[range]).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
        if size > 0.0 { worst / size } else { 0.0 }
    };
    parts.map(of_part).fold(0.0, f64::max)
}

#[test]
fn bodies_that_tumble_and_ring_move_as_with_the_explicit_method() {
    for motion in [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial] {
        let data = block(motion, 8).data;
        let start = Random(4).state(&data);
        let mut system: Multibody = free_system(vec![("block", data)], Vector3::z() * -9.81, Vec::new());
        let y = state_vector(&system, std::slice::from_ref(&start));
        let (expected, _) = end(Method::DormandPrince, &mut system, &y, 1e-11, 0.02);
        let energy = |system: &mut Multibody, t: f64, y: &[f64]| {
            let now = system.invariants(t, y);
            now.kinetic + now.elastic + now.gravity
        };
        let before = energy(&mut system, 0.0, &y);
        let (found, _) = end(Method::Gauss, &mut system, &y, 1e-9, 0.02);
        // Some hundred steps with 1e-9 of the velocity each, of rates that are a hundred times smaller in elastic coordinates.
        assert!(deviation(&system, &found, &expected) < 1e-5, "{motion:?}");
        let after = energy(&mut system, 0.02, &found);
        assert!(((after - before) / before).abs() < 1e-7, "{motion:?}: {before} {after}");
    }
}

#[test]
fn a_swinging_tree_rings_as_with_the_explicit_method_at_fewer_evaluations() {
    let mut system = tree();
    let mut y = system.rest();
    for (body, angles, rates) in [
        (1, vec![0.2, -0.1], vec![3.0, 2.0]),
        (2, vec![0.7], vec![5.0]),
        (0, vec![-0.4, 0.02], vec![4.0, 0.3]),
    ] {
        system.set_joint(&mut y, body, &angles, &rates).unwrap();
    }
    let (expected, many) = end(Method::DormandPrince, &mut system, &y, 1e-10, 0.02);
    let (found, few) = end(Method::Gauss, &mut system, &y, 1e-8, 0.02);
    // As above; errors of vibration count by their displacement.
    assert!(deviation(&system, &found, &expected) < 1e-3, "{:e}", deviation(&system, &found, &expected));
    assert!(2 * few < many, "{few} {many}");
}
