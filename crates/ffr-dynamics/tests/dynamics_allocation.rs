//! A right-hand side, a step, an event search and the ledger allocate nothing.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use crate::dynamics_support::{Random, block};
use crate::free_motion::{free_system, state_vector};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use ffr_dynamics::force::active::ActiveForce;
use ffr_dynamics::integration::{CrossingSearch, DenseOutput, Integrator, Method, OdeSystem, StepSettings};
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, BodySpec, CoordinateForce, GROUND, JointKind, JointSpec, Multibody, SystemSpec,
};
use nalgebra::{UnitQuaternion, Vector3};

struct Counting;

thread_local! {
    static COUNT: Cell<u64> = const { Cell::new(0) };
}

#[expect(unsafe_code, reason = "a counting allocator cannot be written without")]
// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|c| c.set(c.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let _ = COUNT.try_with(|c| c.set(c.get() + 1));
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(work: impl FnOnce()) -> u64 {
    let before = COUNT.with(Cell::get);
    work();
    COUNT.with(Cell::get) - before
}

#[test]
fn steps_events_and_invariants_do_not_allocate() {
    assert!(allocations(|| drop(std::hint::black_box(vec![0.0; 10]))) > 0, "the counter counts");
    for (motion, method) in
        [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial].into_iter().flat_map(|motion| {
            [Method::DormandPrince, Method::TrBdf2, Method::Esdirk4, Method::Gauss]
                .map(|method| (motion, method))
        })
    {
        let sample = block(motion, 8);
        let start: BodyState = Random(2).state(&sample.data);
        let bodies = vec![("block", sample.data)];
        let mut system = free_system::<Box<dyn ActiveForce>>(bodies, Vector3::zeros(), Vec::new());
        let y = state_vector(&system, std::slice::from_ref(&start));
        let mut rates = vec![0.0; y.len()];
        assert_eq!(allocations(|| system.rhs(0.0, &y, &mut rates).unwrap()), 0);
        let mut integrator = Integrator::new(method, StepSettings::default(), 0.0, &y, &system).unwrap();
        let mut search = CrossingSearch::new(y.len(), 1e-12, 4);
        let mut between = y.clone();
        let count = allocations(|| {
            for _ in 0..20 {
                integrator.step(&mut system, 1.0).unwrap();
                let watched = |_: f64, y: &[f64]| y[7];
                search.first_crossing(&integrator, watched).unwrap();
                integrator.interpolate(integrator.interval().0, &mut between);
                system.invariants(0.0, &between);
                std::hint::black_box(system.body_states(0.0, &between));
            }
            integrator.restart(0.5, &between);
        });
        assert_eq!(count, 0, "{motion:?} {method:?}");
        assert_eq!(integrator.statistics().steps, 20);
    }
}

/// Two flexible bodies with a rigid one that closes a loop, on joints with springs.
fn machine() -> Multibody {
    let sample = block(RigidMotion::Spatial, 8);
    let marker = |name: &str, a: usize| {
        sample.marker(name, a, UnitQuaternion::identity(), |j| sample.nodal_rotation(a, j))
    };
    let body = |name: &str| BodySpec {
        name: name.to_string(),
        data: sample.data.clone(),
        markers: vec![marker("a", 0), marker("b", 11)],
    };
    let at = Attachment::new;
    let mut first = JointSpec::new("first", JointKind::Universal, at(GROUND, "a"), at("one", "a"));
    let spring = CoordinateForce { stiffness: 3.0, damping: 0.1, ..CoordinateForce::default() };
    first.coordinates = vec![spring.clone(), spring];
    let spec = SystemSpec {
        bodies: vec![body("one"), body("two")],
        ground: vec![Marker::rigid("a", Vector3::zeros(), UnitQuaternion::identity())],
        joints: vec![first, JointSpec::new("second", JointKind::Spherical, at("one", "b"), at("two", "a"))],
        loops: vec![JointSpec::new("last", JointKind::Planar, at(GROUND, "a"), at("two", "b"))],
        gravity: Vector3::z() * -9.81,
        ..SystemSpec::default()
    };
    Multibody::new(spec, Vec::new()).expect("the parts fit")
}

#[test]
fn multibody_systems_with_loops_do_not_allocate() {
    let mut system = machine();
    let mut y = system.rest();
    system.set_joint(&mut y, 0, &[0.4, 0.3], &[1.0, 2.0]).unwrap();
    system.set_joint(&mut y, 1, &[0.9, 0.3, -0.2, 0.1], &[0.5, 1.0, 0.0]).unwrap();
    system.assemble(0.0, &mut y).unwrap();
    for method in [Method::DormandPrince, Method::TrBdf2, Method::Esdirk4, Method::Gauss] {
        let mut integrator = Integrator::new(method, StepSettings::default(), 0.0, &y, &system).unwrap();
        let count = allocations(|| {
            for _ in 0..10 {
                integrator.step(&mut system, 1.0).unwrap();
                system.invariants(0.0, integrator.state());
                system.joint_energy(0.0, integrator.state());
                system.loop_residual(0.0, integrator.state());
                system.evaluate_accelerations(0.0, integrator.state()).unwrap();
                std::hint::black_box((system.reaction(1), system.loop_reaction(0)));
            }
        });
        assert_eq!(count, 0, "{method:?}");
        assert_eq!(integrator.statistics().steps, 10);
    }
}
