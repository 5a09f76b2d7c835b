//! A repeated search must not allocate.

use crate::counting::allocations;
use contact_qs::search::plane_distance;
use contact_qs::{Plane, SearchWorkspace, SurfaceModel, minimum_distance};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::primitives::{SphereNet, solid, sphere};
use nalgebra::Vector3;

#[test]
fn repeated_searches_do_not_allocate() {
    let shapes = [sphere::sphere(0.5, SphereNet::Cube), solid::hollow_cylinder(0.3, 0.6, 1.0)];
    let models = shapes.map(|s| {
        let fine = s.unwrap();
        let degrees: Vec<usize> = fine.patches[0].knots().iter().map(|k| k.degree()).collect();
        SurfaceModel::rigid(RigidMotion::Spatial, &fine.refined(&degrees, &[3; 3], &[]).unwrap().patches)
            .unwrap()
    });
    let target = BodyState::at_rest(0);
    let plane = Plane { point: Vector3::zeros(), normal: Vector3::z_axis() };
    let mut ws = SearchWorkspace::new();
    let mut gaps = [f64::INFINITY, f64::NEG_INFINITY];
    // The first rounds fill the buffers, apart and overlapping.
    for round in 0..2 {
        let before = allocations();
        for k in 0..40 {
            let mut state = BodyState::at_rest(0);
            let allocated = allocations();
            state.position = Vector3::new(0.45, 0.0, 1.55 - 0.002 * f64::from(k));
            let gap = minimum_distance([&models[0], &models[1]], [&state, &target], &mut ws).unwrap().gap;
            gaps = [gaps[0].min(gap), gaps[1].max(gap)];
            plane_distance(&models[0], &state, &plane, &mut ws).unwrap();
            assert!(round == 0 || allocations() == allocated, "{k}");
        }
        assert!(round == 0 || allocations() == before);
    }
    assert!(gaps[0] < 0.0 && gaps[1] > 0.0, "{gaps:?} must be apart and overlap");
}
