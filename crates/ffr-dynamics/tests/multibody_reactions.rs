//! Reactions of joints against the balance of every body, node by node, and against closed forms.

use crate::dynamics_support::block;
use crate::tree::{GRAVITY, KINDS, STENCIL, STEP, Tree, moved, node_velocities, tree};
use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::force::{BodyState, GeneralisedForce};
use ffr_dynamics::integration::{Integrator, OdeSystem, StepSettings};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, Bearing, BodySpec, CoordinateForce, FreeDirections, Friction, GROUND, JointKind, JointSpec,
    LoadSpec, Multibody, Stop, SystemSpec, TimeFunction,
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Time of all evaluations, at which prescribed motions and drives act.
const TIME: f64 = 0.3;

/// Force, moment about the frame and modal forces that the accelerations of the nodes, weight and elastic forces ask for.
fn wanted(tree: &mut Tree) -> Vec<GeneralisedForce> {
    let y = tree.y.clone();
    let mut rates = vec![0.0; y.len()];
    tree.system.rhs(TIME, &y, &mut rates).unwrap();
    let ends = STENCIL.map(|(at, weight)| {
        let h = at * STEP;
        (weight / STEP, node_velocities(tree, TIME + h, &moved(&y, &rates, h)))
    });
    let states: Vec<BodyState> = tree.system.body_states(TIME, &y).to_vec();
    let mut all = Vec::new();
    for (b, (sample, state)) in tree.samples.iter().zip(&states).enumerate() {
        let n = sample.body.nodes.len();
        let mut sum = GeneralisedForce::zeros(sample.data.n_modes());
        for a in 0..n {
            let force: Vector3<f64> = (0..n)
                .map(|c| {
                    let acceleration: Vector3<f64> = ends.iter().map(|(w, v)| v[b][c] * *w).sum();
                    (acceleration - GRAVITY) * sample.mass[(a, c)]
                })
                .sum();
            let local = state.rotation.inverse_transform_vector(&force);
            sum.force += force;
            sum.torque_in_body += (sample.node(a) + sample.displacement(a, &state.elastic)).cross(&local);
            for (j, h) in sum.elastic.iter_mut().enumerate() {
                let mut unit = vec![0.0; sample.data.n_modes()];
                unit[j] = 1.0;
                *h += sample.displacement(a, &unit).dot(&local);
            }
        }
        for ((h, k), q) in sum.elastic.iter_mut().zip(&sample.data.modal_stiffness).zip(&state.elastic) {
            *h += k * q;
        }
        all.push(sum);
    }
    all
}

/// Largest difference between what the bodies need and what joints (and `loads`) give, as a share of the largest, with modal
/// forces counted as their generalised forces.
fn imbalance(tree: &mut Tree, loads: &[(usize, Marker, [Vector3<f64>; 2])]) -> f64 {
    let wanted = wanted(tree);
    tree.system.evaluate_accelerations(TIME, &tree.y).unwrap();
    let states: Vec<BodyState> = tree.system.last_evaluation().0.to_vec();
    let mut given: Vec<_> = tree.samples.iter().map(|s| GeneralisedForce::zeros(s.data.n_modes())).collect();
    let model = tree.system.model();
    let mut sites = Vec::new();
    for (i, body) in model.bodies.iter().enumerate() {
        let joint = &body.joint;
        sites.push((
            tree.system.reaction(i),
            (Some(i), &joint.child),
            (joint.parent.body, &joint.parent.marker),
        ));
    }
    for (k, joint) in model.loops.iter().enumerate() {
        let (child, parent) = (&joint.child, &joint.parent);
        let reaction = tree.system.loop_reaction(k);
        sites.push((reaction, (child.body, &child.marker), (parent.body, &parent.marker)));
    }
    let place =
        |(body, marker): (Option<usize>, &Marker)| body.map_or(marker.position, |b| marker.place(&states[b]));
    for (reaction, child, parent) in sites {
        if let (Some(b), marker) = child {
            marker.add_wrench(&states[b], &reaction.force, &reaction.moment, &mut given[b]);
        }
        if let (Some(b), marker) = parent {
            let arm = place(child) - place(parent);
            let moment = reaction.moment + arm.cross(&reaction.force);
            marker.add_wrench(&states[b], &-reaction.force, &-moment, &mut given[b]);
        }
    }
    for (body, marker, [force, moment]) in loads {
        marker.add_wrench(&states[*body], force, moment, &mut given[*body]);
    }
    let list = |f: &GeneralisedForce| -> Vec<f64> {
        f.force.iter().chain(f.torque_in_body.iter()).chain(&f.elastic).copied().collect()
    };
    let (mut worst, mut size): (f64, f64) = (0.0, 0.0);
    for (wanted, given) in wanted.iter().zip(&given) {
        for (a, b) in list(wanted).into_iter().zip(list(given)) {
            worst = worst.max((a - b).abs());
            size = size.max(a.abs());
        }
    }
    worst / size
}

/// Accelerations of 10 to 1e4 m/s² from differences of velocities of 5 m/s with a round-off of 1e-10 of 1 m/s²; modal forces are
/// sums over 12 nodes with shapes of 1/√kg.
const BALANCE: f64 = 1e-8;

#[test]
fn every_body_is_in_balance_with_the_reactions_of_its_joints() {
    for (i, kind) in KINDS.into_iter().enumerate() {
        let kinds = [kind, KINDS[(i + 4) % 9], KINDS[(i + 7) % 9]];
        let mut tree = tree(kinds, 70 + i as u64, |_| {});
        let rest = imbalance(&mut tree, &[]);
        assert!(rest < BALANCE, "{kinds:?}: {rest:e}");
    }
}

#[test]
fn reactions_contain_springs_dampers_stops_friction_drives_and_prescribed_motions() {
    let motion = |a: f64, w: f64| {
        TimeFunction::new(move |t| [a * (w * t).sin(), a * w * (w * t).cos(), -a * w * w * (w * t).sin()])
    };
    let kinds = [JointKind::Planar, JointKind::Universal, JointKind::Cylindrical];
    let (force, moment) = (Vector3::new(3.0, -50.0, 20.0), Vector3::new(1.0, 2.0, -4.0));
    let mut tree = tree(kinds, 5, |spec| {
        for (joint, k) in spec.joints.iter_mut().zip([1, 0, 1]) {
            let acting = CoordinateForce {
                stiffness: 2e3,
                rest: 0.1,
                damping: 7.0,
                stop: Some(Stop { lower: -0.1, upper: 0.1, stiffness: 1e3, damping: 0.1 }),
                friction: Some(Friction { force: 3.0, velocity: 0.1 }),
                drive: Some(TimeFunction::constant(11.0)),
                motion: None,
            };
            joint.coordinates = vec![acting; joint.kind.n_velocities()];
            joint.coordinates[k].motion = Some(motion(0.4, 5.0 + k as f64));
        }
        let parts = [force.x, force.y, force.z, moment.x, moment.y, moment.z];
        spec.loads.push(LoadSpec {
            name: "push".into(),
            at: Attachment::new("left", "a"),
            components: parts.map(|x| Some(TimeFunction::constant(x))),
            is_following: false,
        });
    });
    let marker = tree.system.marker("left", "a").unwrap().1.clone();
    let rest = imbalance(&mut tree, &[(1, marker, [force, moment])]);
    assert!(rest < BALANCE, "{rest:e}");
}

#[test]
fn loops_share_the_load_with_the_tree() {
    for kind in [JointKind::Spherical, JointKind::Planar, JointKind::Revolute, JointKind::Universal] {
        let mut tree = tree([JointKind::Free, JointKind::Spherical, JointKind::Spherical], 9, |spec| {
            let (parent, child) = (Attachment::new("right", "a"), Attachment::new("left", "a"));
            spec.loops.push(JointSpec::new("last", kind, parent, child));
            // One to ground as well, whose other side does not move.
            let (parent, child) = (Attachment::new(GROUND, "a"), Attachment::new("root", "b"));
            spec.loops.push(JointSpec::new("hook", JointKind::Spherical, parent, child));
        });
        let mut y = tree.y.clone();
        tree.system.assemble(TIME, &mut y).unwrap();
        tree.y = y;
        let rest = imbalance(&mut tree, &[]);
        assert!(rest < BALANCE, "{kind:?}: {rest:e}");
        let force = tree.system.loop_reaction(0).force.norm();
        assert!(force > 1.0, "the loop carries something: {force} N");
    }
}

/// Force and moment of a bearing on the child along its free directions, in the axes of the parent's marker, by what the joint transmits
/// (docs/theory.md Eq. M.17, M.18).
fn rubbed(kind: JointKind, bearing: &Bearing, reaction: [Vector3<f64>; 2], u: &[f64]) -> [f64; 2] {
    let [force, moment] = reaction;
    let couple = Vector3::z().cross(&moment) / bearing.length;
    let half = 0.5 * Vector3::new(force.x, force.y, 0.0);
    let supports = (half + couple).norm() + (half - couple).norm();
    let (mu, r, transition) = (bearing.coefficient, bearing.radius, bearing.velocity);
    match kind {
        JointKind::Revolute => {
            let load = r * supports + bearing.collar * force.z.abs();
            [0.0, -mu * load * r * u[0] / (r * u[0]).hypot(transition)]
        }
        JointKind::Prismatic => [-mu * (supports + moment.z.abs() / r) * u[0] / u[0].hypot(transition), 0.0],
        _ => {
            let slip = u[0].hypot(r * u[1]).hypot(transition);
            [-mu * supports * u[0] / slip, -mu * supports * r * r * u[1] / slip]
        }
    }
}

#[test]
fn bearings_in_trees_and_loops_rub_by_the_reactions_of_their_joints() {
    let bearing = Bearing { coefficient: 0.15, radius: 0.06, length: 0.4, collar: 0.08, velocity: 0.1 };
    let kinds = [
        [JointKind::Revolute, JointKind::Prismatic, JointKind::Cylindrical],
        [JointKind::Cylindrical, JointKind::Revolute, JointKind::Prismatic],
        [JointKind::Prismatic, JointKind::Spherical, JointKind::Revolute],
    ];
    for (seed, kinds) in kinds.into_iter().enumerate() {
        for has_loop in [false, true] {
            let mut tree = tree(kinds, 30 + seed as u64, |spec| {
                spec.joints.iter_mut().for_each(|joint| joint.bearing = Some(bearing));
                if has_loop {
                    let planar = JointKind::Generic(FreeDirections([true, false, true, true, true, true]));
                    let (parent, child) = (Attachment::new("right", "a"), Attachment::new("left", "a"));
                    spec.loops.push(JointSpec::new("last", planar, parent, child));
                }
            });
            if has_loop {
                let mut y = tree.y.clone();
                tree.system.assemble(TIME, &mut y).unwrap();
                tree.y = y;
            }
            let rest = imbalance(&mut tree, &[]);
            assert!(rest < BALANCE, "{kinds:?} {has_loop}: {rest:e}");
            let states: Vec<BodyState> = tree.system.last_evaluation().0.to_vec();
            let mut power = 0.0;
            for (i, kind) in kinds.into_iter().enumerate() {
                let reaction = tree.system.reaction(i);
                let u = tree.system.joint_coordinates(TIME, &tree.y, i).velocities;
                let parent = &tree.system.model().bodies[i].joint.parent;
                let axes =
                    parent.body.map_or(parent.marker.rotation, |b| parent.marker.orientation(&states[b]));
                let (force, moment) = (axes.inverse() * reaction.force, axes.inverse() * reaction.moment);
                // The solution of the loads, to round-off of the forces.
                let limit = 1e-12 * (force.norm() + moment.norm());
                if kind == JointKind::Spherical {
                    let load = bearing.coefficient * bearing.radius * force.norm();
                    let spin = bearing.radius * Vector3::from_column_slice(&u[..3]).norm();
                    let size = load * spin / spin.hypot(bearing.velocity);
                    assert!((moment.norm() - size).abs() < limit, "{moment} {size}");
                    power += size * spin / bearing.radius;
                    continue;
                }
                let [along, about] = rubbed(kind, &bearing, [force, moment], &u);
                let has = |direction: usize| kind.free_directions().0[direction];
                if has(2) {
                    assert!((force.z - along).abs() < limit, "{kind:?} {} {along}", force.z);
                }
                if has(5) {
                    assert!((moment.z - about).abs() < limit, "{kind:?} {} {about}", moment.z);
                }
                power -= if kind == JointKind::Revolute { about * u[0] } else { along * u[0] + about * u[1] };
            }
            let mut rates = vec![0.0; tree.y.len()];
            tree.system.rhs(TIME, &tree.y, &mut rates).unwrap();
            let booked = rates[tree.system.model().n_states()];
            assert!((booked / power - 1.0).abs() < 1e-12, "{booked} {power}");
            assert!(power > 0.0);
        }
    }
}

/// A rod of 2 kg, its centre at (0, -0.6, 0.1) from the hinge about z at the origin.
fn pendulum(coordinates: Vec<CoordinateForce>) -> Multibody {
    let centre = Vector3::new(0.0, -0.6, 0.1);
    let steiner = Matrix3::identity() * centre.norm_squared() - centre * centre.transpose();
    let about_centre = Matrix3::from_diagonal(&Vector3::new(0.3, 0.01, 0.3));
    let data =
        StandardInputData::rigid(RigidMotion::Spatial, 2.0, centre, about_centre + steiner * 2.0).unwrap();
    let pin = || Marker::rigid("pin", Vector3::zeros(), UnitQuaternion::identity());
    let mut joint = JointSpec::new(
        "hinge",
        JointKind::Revolute,
        Attachment::new(GROUND, "pin"),
        Attachment::new("rod", "pin"),
    );
    joint.coordinates = coordinates;
    let spec = SystemSpec {
        bodies: vec![BodySpec { name: "rod".into(), data, markers: vec![pin()] }],
        ground: vec![pin()],
        joints: vec![joint],
        gravity: Vector3::new(0.0, -9.81, 0.0),
        ..SystemSpec::default()
    };
    Multibody::new(spec, Vec::new()).unwrap()
}

#[test]
fn compound_pendulum_pulls_at_its_hinge_as_the_closed_form_says() {
    let mut system = pendulum(Vec::new());
    let (m, s, g) = (2.0, 0.6, 9.81);
    let inertia = 0.3 + m * s * s;
    for (angle, rate) in [(0.0, 0.0), (0.4, 2.5), (-1.9, -7.0), (3.0, 0.3)] {
        let mut y = system.rest();
        system.set_joint(&mut y, 0, &[angle], &[rate]).unwrap();
        system.evaluate_accelerations(0.0, &y).unwrap();
        let reaction = system.reaction(0);
        let axis = Vector3::new(f64::sin(angle), -f64::cos(angle), 0.0); // from the hinge to the centre
        let across = Vector3::new(f64::cos(angle), f64::sin(angle), 0.0);
        let pull = -m * (g * f64::cos(angle) + s * rate * rate);
        let shear = m * g * f64::sin(angle) * (1.0 - m * s * s / inertia);
        let expected = axis * pull + across * shear;
        // Round-off of forces of up to 80 N.
        assert!((reaction.force - expected).norm() < 1e-12, "{reaction:?} {expected:?}");
        // The centre lies 0.1 m beside the plane of the hinge: the moment balances the force there, and is free about z.
        let arm = axis * s + Vector3::z() * 0.1;
        let acceleration = axis * (-s * rate * rate) - across * (m * g * s * s * f64::sin(angle) / inertia);
        let carried = arm.cross(&((acceleration + Vector3::y() * g) * m));
        assert!((reaction.moment.xy() - carried.xy()).norm() < 1e-12, "{reaction:?} {carried:?}");
        assert!(reaction.moment.z.abs() < 1e-13, "nothing acts about a free hinge: {reaction:?}");
    }
}

#[test]
fn prescribed_hinge_transmits_the_moment_that_the_motion_takes() {
    let motion = TimeFunction::new(|t| [1.5 * t * t, 3.0 * t, 3.0]);
    let spring = CoordinateForce { stiffness: 40.0, motion: Some(motion), ..CoordinateForce::default() };
    let mut system = pendulum(vec![spring]);
    let y = system.rest();
    system.evaluate_accelerations(0.5, &y).unwrap();
    let angle: f64 = 1.5 * 0.25;
    // The spring is a part of what the joint transmits; it does not add to what the motion asks for.
    let moment = (0.3 + 2.0 * 0.36) * 3.0 + 2.0 * 9.81 * 0.6 * angle.sin();
    assert!((system.reaction(0).moment.z - moment).abs() < 1e-13, "{:?}", system.reaction(0));
}

#[test]
fn clamped_body_in_static_start_rests_on_its_weight() {
    let sample = block(RigidMotion::Spatial, 8);
    let pin = sample.marker("pin", 0, UnitQuaternion::identity(), |j| sample.nodal_rotation(0, j));
    for kind in [JointKind::Fixed, JointKind::Spherical] {
        let joint =
            JointSpec::new("clamp", kind, Attachment::new(GROUND, "place"), Attachment::new("block", "pin"));
        let place = Vector3::new(0.2, 1.0, -3.0);
        let spec = SystemSpec {
            bodies: vec![BodySpec {
                name: "block".into(),
                data: sample.data.clone(),
                markers: vec![pin.clone()],
            }],
            ground: vec![Marker::rigid("place", place, UnitQuaternion::identity())],
            joints: vec![joint],
            gravity: GRAVITY,
            ..SystemSpec::default()
        };
        let mut system: Multibody = Multibody::new(spec, Vec::new()).unwrap();
        let mut y = system.rest();
        system.static_start(0.0, &mut y).unwrap();
        system.evaluate_accelerations(0.0, &y).unwrap();
        let reaction = system.reaction(0);
        if kind == JointKind::Spherical {
            assert!(reaction.moment.norm() < 1e-13, "nothing acts about a free joint: {reaction:?}");
            continue; // the block falls about its marker
        }
        let weight = GRAVITY * sample.data.mass;
        let centre = system.centre_of_mass(0.0, &y, 0);
        let moment = (centre - place).cross(&weight);
        // What the last correction of the static start leaves: 1e-12 of the deformation.
        assert!((reaction.force + weight).norm() < 1e-11 * weight.norm(), "{reaction:?}");
        assert!((reaction.moment + moment).norm() < 1e-11 * moment.norm(), "{reaction:?} {moment:?}");
    }
}

/// Four hinges about z hold each other three times over out of the plane; what they carry in it is unique.
fn four_bar_linkage() -> (Multibody, Vec<f64>) {
    let bar = |name: &str, length: f64| {
        let centre = Vector3::new(0.5 * length, 0.0, 0.0);
        let about = Matrix3::from_diagonal(&Vector3::new(1e-4, 0.1, 0.1));
        let steiner = Matrix3::identity() * centre.norm_squared() - centre * centre.transpose();
        let data = StandardInputData::rigid(RigidMotion::Spatial, 1.0, centre, about + steiner).unwrap();
        let end =
            |name: &str, x: f64| Marker::rigid(name, Vector3::new(x, 0.0, 0.0), UnitQuaternion::identity());
        BodySpec { name: name.into(), data, markers: vec![end("a", 0.0), end("b", length)] }
    };
    let pin = |name: &str, x: f64| Marker::rigid(name, Vector3::new(x, 0.0, 0.0), UnitQuaternion::identity());
    let at = Attachment::new;
    let hinge = |name: &str, p: Attachment, c: Attachment| JointSpec::new(name, JointKind::Revolute, p, c);
    let spec = SystemSpec {
        bodies: vec![bar("crank", 0.5), bar("coupler", 1.2), bar("rocker", 0.9)],
        ground: vec![pin("left", 0.0), pin("right", 1.3)],
        joints: vec![
            hinge("one", at(GROUND, "left"), at("crank", "a")),
            hinge("two", at("crank", "b"), at("coupler", "a")),
            hinge("three", at("coupler", "b"), at("rocker", "a")),
        ],
        loops: vec![hinge("four", at(GROUND, "right"), at("rocker", "b"))],
        gravity: Vector3::new(0.0, -9.81, 0.0),
        ..SystemSpec::default()
    };
    let mut system: Multibody = Multibody::new(spec, Vec::new()).unwrap();
    let mut y = system.rest();
    for (body, angle, rate) in [(0, 1.2, 3.0), (1, -0.9, 0.0), (2, -1.8, 0.0)] {
        system.set_joint(&mut y, body, &[angle], &[rate]).unwrap();
    }
    system.assemble(0.0, &mut y).unwrap();
    (system, y)
}

#[test]
fn hinges_in_a_row_hold_a_four_bar_linkage_once() {
    let (mut system, y) = four_bar_linkage();
    let mut rates = vec![0.0; y.len()];
    system.rhs(0.0, &y, &mut rates).unwrap();
    assert_eq!(system.loop_constraints(), (5, 2));
    let (one, four) = (system.reaction(0), system.loop_reaction(0));
    // Rate of momentum and of angular momentum about the origin.
    let mut change = [Vector3::zeros(); 2];
    for (at, weight) in STENCIL {
        let momenta = system.invariants(0.0, &moved(&y, &rates, at * STEP));
        change[0] += momenta.linear_momentum * (weight / STEP);
        change[1] += momenta.angular_momentum * (weight / STEP);
    }
    let weight = Vector3::new(0.0, -9.81, 0.0);
    let mut torque = Vector3::zeros();
    for body in 0..3 {
        torque += system.centre_of_mass(0.0, &y, body).cross(&weight);
    }
    let force = one.force + four.force + weight * 3.0;
    let moment = one.moment + four.moment + Vector3::new(1.3, 0.0, 0.0).cross(&four.force) + torque;
    // Round-off of the differences, 1e-15 of momenta of a few kg m/s over the step.
    assert!((force - change[0]).norm() < 1e-9, "{force:?} {change:?}");
    assert!((moment - change[1]).norm() < 1e-9, "{moment:?} {change:?}");
    assert!(one.moment.z.abs() < 1e-12 && four.moment.z.abs() < 1e-12, "hinges are free");
}

#[test]
fn reactions_at_the_end_of_a_step_outlive_projections() {
    let (mut system, y) = four_bar_linkage();
    let mut integrator = Integrator::explicit(StepSettings::default(), 0.0, &y).unwrap();
    for _ in 0..20 {
        let end = integrator.step(&mut system, 1.0).unwrap().end;
        let state = integrator.state().to_vec();
        // Loops have been projected; what the run records of the state places the bodies again.
        system.invariants(end, &state);
        let kept = [system.reaction(0), system.reaction(2), system.loop_reaction(0)];
        system.evaluate_accelerations(end, &state).unwrap();
        let anew = [system.reaction(0), system.reaction(2), system.loop_reaction(0)];
        for (kept, anew) in kept.iter().zip(&anew) {
            // A projection moves the state by the error of a step, 1e-8.
            assert!((kept.force - anew.force).norm() < 1e-6 * anew.force.norm(), "{kept:?} {anew:?}");
        }
    }
}
