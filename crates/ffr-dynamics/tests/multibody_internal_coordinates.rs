//! Force elements with internal coordinates, which the system integrates along with those of the bodies.

use ffr_dynamics::body::{RigidMotion, StandardInputData};
use ffr_dynamics::error::EvaluationFailure;
use ffr_dynamics::force::ForceEnergies;
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{Findings, ForceElement, GeneralisedForce, Motion};
use ffr_dynamics::integration::{Integrator, Method, OdeSystem, StepSettings};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, BodySpec, ErrorScale, GROUND, JointKind, JointSpec, Multibody, SystemSpec,
};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const MASS: f64 = 2.0;
const SMALL: f64 = 0.5;
const STIFFNESS: f64 = 800.0;
/// Frequency of two masses on a spring [rad/s].
fn omega() -> f64 {
    (STIFFNESS * (1.0 / MASS + 1.0 / SMALL)).sqrt()
}

/// A mass on a spring that hangs on the body 0 along x: its place is the element's own coordinate.
struct HangingMass;

/// What its spring does.
#[derive(Default)]
struct Pull {
    force: f64,
    energies: ForceEnergies,
    acceleration: [f64; 1],
}

impl Findings for Pull {
    fn energies(&self) -> ForceEnergies {
        self.energies
    }

    fn resultant(&self) -> Vector3<f64> {
        Vector3::x() * self.force
    }

    fn accelerations(&self) -> &[f64] {
        &self.acceleration
    }
}

impl ForceElement for HangingMass {
    type State = ();
    type Workspace = ();
    type Found = Pull;

    fn start(&self) -> ((), (), Pull) {
        Default::default()
    }

    fn evaluate(
        &self,
        motion: Motion<'_>,
        (): &mut (),
        (): &mut (),
        found: &mut Pull,
        forces: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        let stretch = motion.internal[0] - motion.bodies[0].position.x;
        found.force = STIFFNESS * stretch;
        found.energies = ForceEnergies {
            elastic_high: 0.5 * STIFFNESS * stretch * stretch,
            kinetic: 0.5 * SMALL * motion.internal[1] * motion.internal[1],
            ..ForceEnergies::default()
        };
        found.acceleration = [-found.force / SMALL];
        forces[0].force.x += found.force;
        Ok(())
    }

    fn n_coordinates(&self) -> usize {
        1
    }

    fn coordinate_speed(&self, internal: &[f64]) -> f64 {
        (SMALL / MASS).sqrt() * internal[1].hypot(omega() * internal[0])
    }
}

/// A force element without any, in front of the other one.
struct Nothing;

/// No force.
struct NoForce;

impl Findings for NoForce {
    fn energies(&self) -> ForceEnergies {
        ForceEnergies::default()
    }

    fn resultant(&self) -> Vector3<f64> {
        Vector3::zeros()
    }
}

impl ForceElement for Nothing {
    type State = ();
    type Workspace = ();
    type Found = NoForce;

    fn start(&self) -> ((), (), NoForce) {
        ((), (), NoForce)
    }

    fn evaluate(
        &self,
        _: Motion<'_>,
        (): &mut (),
        (): &mut (),
        _: &mut NoForce,
        _: &mut [GeneralisedForce],
    ) -> Result<(), EvaluationFailure> {
        Ok(())
    }
}

fn nothing() -> Box<dyn ActiveForce> {
    Box::new(Active::new(Nothing))
}

fn hanging_mass() -> Box<dyn ActiveForce> {
    Box::new(Active::new(HangingMass))
}

fn system(forces: Vec<Box<dyn ActiveForce>>) -> Multibody {
    let data =
        StandardInputData::rigid(RigidMotion::Spatial, MASS, Vector3::zeros(), Matrix3::identity()).unwrap();
    let marker = |name: &str| Marker::rigid(name, Vector3::zeros(), UnitQuaternion::identity());
    let spec = SystemSpec {
        bodies: vec![BodySpec { name: "block".into(), data, markers: vec![marker("centre")] }],
        joints: vec![JointSpec::new(
            "free",
            JointKind::Free,
            Attachment::new(GROUND, "origin"),
            Attachment::new("block", "centre"),
        )],
        ground: vec![marker("origin")],
        ..SystemSpec::default()
    };
    Multibody::new(spec, forces).unwrap()
}

#[test]
fn a_mass_that_an_element_carries_swings_as_the_closed_form_says() {
    // A step keeps the tolerance of its method; a thousand of them, and phase errors, add up to less than a hundred times that.
    for (method, relative, limit) in [(Method::DormandPrince, 1e-10, 1e-8), (Method::TrBdf2, 1e-8, 1e-4)] {
        let mut system = system(vec![nothing(), hanging_mass(), nothing()]);
        system.set_error_scale(ErrorScale { relative, ..ErrorScale::default() }).unwrap();
        let place = system.coordinates_of_force(1);
        assert_eq!((place.len(), place.end), (2, system.dimension()));
        assert!(system.coordinates_of_force(0).is_empty() && system.coordinates_of_force(2).is_empty());
        let mut y = system.rest();
        let stretch = 0.01;
        y[place.start] = stretch;
        let mut integrator = Integrator::new(method, StepSettings::default(), 0.0, &y, &system).unwrap();
        let energy = 0.5 * STIFFNESS * stretch * stretch;
        let end = 3.3 * std::f64::consts::TAU / omega();
        integrator.run(&mut system, end, |_, _| true).unwrap();
        let y = integrator.state();
        let (t, x) = (integrator.time(), y[place.start]);
        // The centre of mass of both rests where it was.
        let centre = SMALL * stretch / (MASS + SMALL);
        let exact = centre + stretch * MASS / (MASS + SMALL) * (omega() * t).cos();
        assert!((x - exact).abs() < limit * stretch, "{method:?}: {x} {exact}");
        let (states, x_body) = (system.body_states(t, y), exact - stretch * (omega() * t).cos());
        assert!((states[0].position.x - x_body).abs() < limit * stretch);
        let momentum = MASS * states[0].velocity.x + SMALL * y[place.start + 1];
        let size = SMALL * stretch * omega();
        assert!(momentum.abs() < 1e-10 * size, "{method:?}: {momentum:e}"); // equal and opposite forces
        system.evaluate_forces(t, y).unwrap();
        let energies = system.forces()[1].energies();
        let total = system.invariants(t, y).kinetic + energies.kinetic + energies.elastic_high;
        assert!((total / energy - 1.0).abs() < limit, "{method:?}: {total} {energy}");
        // The impulse on the body.
        let impulse = system.impulse(y, 1).x;
        let body = MASS * system.body_states(t, y)[0].velocity.x;
        assert!((impulse - body).abs() < 1e-10 * size, "{method:?}");
    }
}

#[test]
fn errors_of_own_coordinates_count() {
    let mut system = system(vec![hanging_mass()]);
    let y = system.rest();
    let mut error = vec![0.0; y.len()];
    assert!(system.error_norm(&y, &y, &error) < f64::MIN_POSITIVE);
    error[system.coordinates_of_force(0).start] = 1e-3;
    assert!(system.error_norm(&y, &y, &error) > 1.0);
}
