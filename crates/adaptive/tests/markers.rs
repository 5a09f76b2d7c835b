//! Named points of the balls of the catalogue as markers.

use adaptive::body::field::Field;
use adaptive::body::splines::ElasticBody;
use adaptive::spec::{DiscretisationSpec, ElasticSpec, Place, ReductionSpec};
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::primitives::sphere::{SphereNet, sphere};
use nalgebra::UnitQuaternion;

/// Markers lie on poles and edges of the nets, where gradients do not exist; they follow the body as a whole all the same.
#[test]
fn every_marker_of_every_ball_follows_rigid_motions() {
    let steel = Material::new(210e9, 0.3, 7850.0).unwrap();
    for (net, degrees) in
        [(SphereNet::Spindle, vec![2, 2, 3]), (SphereNet::Cube, vec![4; 3]), (SphereNet::Shells, vec![4; 3])]
    {
        for n in [1, 4] {
            let elements = vec![n; 3];
            let discretisation =
                DiscretisationSpec { degrees: degrees.clone(), elements, knots: None, refine: Vec::new() };
            let reduction = ReductionSpec::Modal { modes: 6 };
            let shape = sphere(0.01, net).unwrap();
            let spec = ElasticSpec::new(shape, Model::Solid, steel, discretisation, reduction);
            let body = ElasticBody::build("ball", spec).unwrap();
            for (name, place) in &body.spec.shape.markers {
                let weights = body.marker_weights(&Place::Point(*place), UnitQuaternion::identity()).unwrap();
                let outcome = weights.check_rigid_motions(&body.assembled);
                assert!(outcome.is_ok(), "{net:?}, {n} elements, {name}: {outcome:?}");
            }
        }
    }
}
