//! Time of one search for the minimum distance: fresh, and from the last answer.

use contact_qs::{SearchWorkspace, SurfaceModel, minimum_distance};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::Shape;
use iga_core::nurbs::primitives::{SphereNet, axisymmetric, plane, solid, sphere};
use nalgebra::{UnitQuaternion, Vector3};

fn main() {
    divan::main();
}

fn surface(
    motion: RigidMotion,
    shape: Result<Shape, iga_core::SplineError>,
    elements: usize,
) -> SurfaceModel {
    let shape = shape.expect("valid shape");
    let degrees: Vec<usize> = shape.patches[0].knots().iter().map(|k| k.degree()).collect();
    let fine = shape.refined(&degrees, &vec![elements; degrees.len()], &[]).expect("finer elements");
    SurfaceModel::rigid(motion, &fine.patches).expect("has faces")
}

fn pair(case: &str) -> ([SurfaceModel; 2], Vector3<f64>) {
    match case {
        "sphere-rod" => {
            let of = |shape, n| surface(RigidMotion::Axial, shape, n);
            let models = [of(axisymmetric::sphere(0.01), 32), of(axisymmetric::rod(0.005, 0.1), 64)];
            (models, Vector3::new(0.0, 0.0, 0.11))
        }
        "disc-disc" => {
            let of = |n| surface(RigidMotion::Planar, plane::disc(0.01), n);
            ([of(32), of(32)], Vector3::new(0.0142, 0.0142, 0.0))
        }
        "sphere-sphere" => {
            let of = |n| surface(RigidMotion::Spatial, sphere::sphere(0.01, SphereNet::Cube), n);
            ([of(8), of(8)], Vector3::new(0.01, 0.012, 0.0125))
        }
        _ => {
            let models = [
                surface(RigidMotion::Spatial, sphere::sphere(0.01, SphereNet::Cube), 8),
                surface(RigidMotion::Spatial, solid::hollow_cylinder(0.005, 0.02, 0.03), 8),
            ];
            (models, Vector3::new(0.013, 0.003, 0.0401))
        }
    }
}

/// A little motion between two searches, as between two looks at a step.
fn state(place: Vector3<f64>, motion: RigidMotion, k: u32) -> BodyState {
    let share = f64::from(k % 64) / 64.0;
    let mut state = BodyState { position: place * (1.0 + 1e-4 * share), ..BodyState::at_rest(0) };
    if motion == RigidMotion::Spatial {
        state.rotation =
            UnitQuaternion::from_scaled_axis(Vector3::new(0.3, 0.2, 0.1) + Vector3::x() * 1e-3 * share);
    }
    state
}

const CASES: [&str; 4] = ["sphere-rod", "disc-disc", "sphere-sphere", "sphere-ring"];

/// Searches at `share` of the place of the case, without the last answer if `is_cold`.
fn searches(bencher: divan::Bencher<'_, '_>, case: &str, share: f64, is_cold: bool) {
    let (models, place) = pair(case);
    let target = BodyState::at_rest(0);
    let mut ws = SearchWorkspace::new();
    let mut k = 0;
    bencher.bench_local(|| {
        k += 1;
        let moving = state(place * share, models[0].motion(), k);
        if is_cold {
            ws.forget();
        }
        minimum_distance([&models[0], &models[1]], [&moving, &target], &mut ws)
    });
}

/// The bodies overlap by about a hundredth of the way between their centres.
#[divan::bench(args = CASES)]
fn overlapping(bencher: divan::Bencher<'_, '_>, case: &str) {
    searches(bencher, case, 0.99, false);
}

#[divan::bench(args = CASES)]
fn warm(bencher: divan::Bencher<'_, '_>, case: &str) {
    searches(bencher, case, 1.0, false);
}

#[divan::bench(args = CASES)]
fn cold(bencher: divan::Bencher<'_, '_>, case: &str) {
    searches(bencher, case, 1.0, true);
}
