//! Two bodies that act on each other: nothing is lost between them, and refusals reach the integrator.

use crate::dynamics_support::{Random, block, rigid_rotor};
use crate::free_motion::{body_state, free_system, state_vector};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::error::{EvaluationFailure, EvaluationFault, FailureKind};
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, Findings, ForceElement, ForceEnergies, GeneralisedForce, Motion};
use ffr_dynamics::integration::{Integrator, StepSettings};
use ffr_dynamics::kinematics::FlexiblePoint;
use ffr_dynamics::system::{ErrorScale, Multibody};
use nalgebra::{UnitQuaternion, Vector3};

/// What a spring refuses with.
#[derive(Debug, thiserror::Error)]
#[error("the spring does not converge")]
struct NotConverged;

impl EvaluationFault for NotConverged {
    fn kind(&self) -> FailureKind {
        FailureKind::IterationLimit
    }
}

/// Spring and damper between a point of body 0 and a point of body 1. If asked to, it refuses 3 calls after the twentieth.
struct Spring {
    points: [FlexiblePoint; 2],
    stiffness: f64,
    damping: f64,
    refuses: bool,
}

/// What has been asked of a spring so far.
#[derive(Default)]
struct Calls {
    evaluations: u32,
    restores: u32,
    refusals: u32,
}

/// Force and energies of a spring.
#[derive(Default)]
struct Pull {
    energies: ForceEnergies,
    resultant: Vector3<f64>,
}

impl Findings for Pull {
    fn energies(&self) -> ForceEnergies {
        self.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        self.resultant
    }
}

impl ForceElement for Spring {
    type State = Calls;
    type Workspace = ();
    type Found = Pull;

    fn start(&self) -> (Calls, (), Pull) {
        Default::default()
    }

    fn evaluate(
        &self,
        Motion { bodies, .. }: Motion<'_>,
        calls: &mut Calls,
        (): &mut (),
        found: &mut Pull,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        calls.evaluations += 1;
        if self.refuses && calls.refusals < 3 && calls.evaluations > 20 {
            calls.refusals += 1;
            return Err(NotConverged.into());
        }
        let [first, second] = &self.points;
        let distance = second.position(&bodies[1]) - first.position(&bodies[0]);
        let rate = second.velocity(&bodies[1]) - first.velocity(&bodies[0]);
        // A damper along all three directions would turn the bodies: the force has to be along the distance.
        let direction = distance.normalize();
        let closing = rate.dot(&direction);
        found.resultant = self.stiffness * distance + self.damping * closing * direction;
        found.energies = ForceEnergies {
            penalty: 0.5 * self.stiffness * distance.norm_squared(),
            dissipated_power: self.damping * closing * closing,
            ..ForceEnergies::default()
        };
        first.add_force(&bodies[0], &found.resultant, &mut forces[0]);
        second.add_force(&bodies[1], &-found.resultant, &mut forces[1]);
        Ok(())
    }

    fn restore(&self, calls: &mut Calls, _: &mut Pull) {
        calls.restores += 1;
    }
}

/// A flexible block, tied to a rigid rotor.
fn pair(damping: f64, refuses: bool) -> (Multibody<Box<Active<Spring>>>, Vec<f64>) {
    let sample = block(RigidMotion::Spatial, 6);
    let corner = FlexiblePoint::from_rows(RigidMotion::Spatial, sample.node(3), sample.shapes.as_ref(), 9);
    let mut start = Random(9).state(&sample.data);
    start.position = Vector3::new(0.5, 0.0, 0.2);
    let mut other = BodyState::at_rest(0);
    other.rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.1, 2.0, -0.4));
    other.angular_velocity_in_body = Vector3::new(3.0, -1.0, 0.5);
    let bodies = vec![("block", sample.data), ("rotor", rigid_rotor())];
    let spring = Spring {
        points: [corner, FlexiblePoint::rigid(Vector3::new(-0.4, 0.3, 0.1))],
        stiffness: 5e3,
        damping,
        refuses,
    };
    let mut system = free_system(bodies, Vector3::zeros(), vec![Box::new(Active::new(spring))]);
    system.set_error_scale(ErrorScale { relative: 1e-10, ..ErrorScale::default() }).unwrap();
    let y = state_vector(&system, &[start, other]);
    (system, y)
}

#[test]
fn bodies_exchange_momentum_and_energy_without_loss() {
    for damping in [0.0, 20.0] {
        let (mut system, y) = pair(damping, false);
        system.evaluate_forces(0.0, &y).unwrap();
        let (before, spring) = (system.invariants(0.0, &y), system.forces()[0].energies().penalty);
        let first = body_state(&mut system, &y, 0).velocity;
        let mut integrator = Integrator::explicit(StepSettings::default(), 0.0, &y).unwrap();
        integrator.run(&mut system, 0.02, |_, _| true).unwrap();
        let y = integrator.state().to_vec();
        let after = system.invariants(0.0, &y);
        assert!((body_state(&mut system, &y, 0).velocity - first).norm() > 0.1, "they have pulled");
        // Tolerance 1e-10 per step, about a thousand steps, errors of one sign.
        const TOLERANCE: f64 = 1e-8;
        let linear = (after.linear_momentum - before.linear_momentum).norm();
        assert!(linear < TOLERANCE * before.linear_momentum.norm(), "{linear}");
        let angular = (after.angular_momentum - before.angular_momentum).norm();
        assert!(angular < TOLERANCE * before.angular_momentum.norm(), "{angular}");
        let energies = system.forces()[0].energies();
        let total = after.energy() + energies.penalty + system.dissipated_work(&y);
        let expected = before.energy() + spring;
        assert!((total - expected).abs() < 3.0 * TOLERANCE * expected, "{total} {expected}");
        assert_eq!(damping > 0.0, system.dissipated_work(&y) > 1e-3);
    }
}

#[test]
fn refusal_of_a_force_element_repeats_the_step_and_leaves_the_answer_alone() {
    let mut ends = Vec::new();
    for refuses in [false, true] {
        let (mut system, y) = pair(0.0, refuses);
        let mut integrator = Integrator::explicit(StepSettings::default(), 0.0, &y).unwrap();
        integrator.run(&mut system, 2e-3, |_, _| true).unwrap();
        ends.push(body_state(&mut system, integrator.state(), 0));
        let calls = system.forces()[0].state();
        assert_eq!(calls.refusals, if refuses { 3 } else { 0 });
        assert!(
            calls.restores >= calls.refusals && integrator.statistics().rejected >= u64::from(calls.refusals)
        );
    }
    assert!((ends[0].position - ends[1].position).norm() < 1e-10);
    assert!((ends[0].angular_velocity_in_body - ends[1].angular_velocity_in_body).norm() < 1e-8 * 20.0);
}
