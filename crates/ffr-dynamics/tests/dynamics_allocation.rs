//! A right-hand side, a step, an event search and the ledger allocate nothing.

#[expect(dead_code, reason = "other test binaries use the rest")]
mod dynamics_support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use dynamics_support::{Random, block};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::integration::{CrossingSearch, DenseOutput, Integrator, Method, OdeSystem, StepSettings};
use ffr_dynamics::system::{BodyState, ForceElement, FreeBodies, FreeBody};
use nalgebra::Vector3;

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
    for (motion, method) in [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial]
        .into_iter()
        .flat_map(|motion| [(motion, Method::DormandPrince), (motion, Method::TrBdf2)])
    {
        let sample = block(motion, 8);
        let start: BodyState = Random(2).state(&sample.data);
        let body = FreeBody { name: "block".to_string(), data: sample.data };
        let mut system =
            FreeBodies::<Box<dyn ForceElement>>::new(vec![body], Vector3::zeros(), Vec::new()).unwrap();
        let y = system.state_vector(std::slice::from_ref(&start)).unwrap();
        let mut rates = vec![0.0; y.len()];
        assert_eq!(allocations(|| system.rhs(0.0, &y, &mut rates).unwrap()), 0);
        let mut integrator = Integrator::new(method, StepSettings::default(), 0.0, &y, &system).unwrap();
        let mut search = CrossingSearch::new(y.len(), 1e-12, 4);
        let (mut between, mut state) = (y.clone(), start);
        let count = allocations(|| {
            for _ in 0..20 {
                integrator.step(&mut system, 1.0).unwrap();
                let watched = |_: f64, y: &[f64]| y[7];
                search.first_crossing(&integrator, watched).unwrap();
                integrator.interpolate(integrator.interval().0, &mut between);
                system.invariants(&between);
                system.read_body(&between, 0, &mut state);
            }
            integrator.restart(0.5, &between);
        });
        assert_eq!(count, 0, "{motion:?} {method:?}");
        assert_eq!(integrator.statistics().steps, 20);
    }
}
