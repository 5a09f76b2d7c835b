//! From surface points to the contact submodel.

use crate::common::Random;
use contact_qs::{DofLookup, InterfaceCompliance, PressureMean, SurfacePoint, contact_submodel};
use faer::Mat;
use ffr_dynamics::body::{Dof, RigidMotion};

/// Four control points of an axisymmetric model; the first stands on the axis and has no radial degree of freedom.
fn dofs() -> Vec<Dof> {
    let all = (0..4_u32).flat_map(|node| [0, 1].map(|component| Dof { node, component }));
    all.filter(|d| d.node != 0 || d.component != 0).collect()
}

fn points() -> Vec<SurfacePoint> {
    let point = |r: f64, functions: &[(u32, f64)], on_rim| SurfacePoint {
        position: [r, -0.01, 0.0],
        area: 1e-9,
        functions: functions.to_vec(),
        on_rim,
        pressure: PressureMean::Area,
        facing: None,
    };
    vec![point(0.0, &[(0, 1.0)], false), point(1e-5, &[(0, 0.25), (1, 0.5), (2, 0.25)], true)]
}

#[test]
fn shapes_and_compliance_are_brought_to_the_points() {
    let mut random = Random::new(1);
    let (shapes, g) = (random.matrix(7, 3), random.semidefinite(5, 5, 1e-8));
    // Unknowns 0..5 belong to nodes 0, 1, 2; listed in another order.
    let interface = [4, 0, 2, 1, 3];
    let submodel = contact_submodel(
        RigidMotion::Axial,
        &points(),
        &DofLookup::new(&dofs()),
        shapes.as_ref(),
        Some(InterfaceCompliance { dofs: &interface, compliance: g.as_ref() }),
    )
    .unwrap();
    assert_eq!(submodel.points, [[0.0, 0.0, -0.01], [1e-5, 0.0, -0.01]]);
    assert_eq!(submodel.rim, [1]);
    // Dense N over all unknowns: rows (point, component), node 0 has unknown 0 (axial), node 1: 1, 2, node 2: 3, 4.
    let n = Mat::from_fn(4, 7, |row, dof| match (row, dof) {
        (1, 0) => 1.0,
        (2, 1) | (3, 2) => 0.5,
        (2, 3) | (3, 0 | 4) => 0.25,
        _ => 0.0,
    });
    let order = Mat::from_fn(7, 5, |dof, b| if interface[b] == dof { 1.0 } else { 0.0 });
    let expected = &n * &order * &g * order.transpose() * n.transpose();
    // Identities up to round-off.
    let compliance = submodel.compliance.of_points(&submodel.interface);
    assert!((&compliance - &expected).norm_max() < 1e-15 * g.norm_max() * 10.0);
    assert!((&submodel.low - &n * &shapes).norm_max() < 1e-15);
    assert_eq!(compliance, compliance.transpose().to_owned());
    assert_eq!(submodel.interface.row(0), []);
}

#[test]
fn rigid_shapes_move_every_point_alike() {
    let axial = Mat::from_fn(7, 1, |dof, _| f64::from(dofs()[dof].component));
    let submodel =
        contact_submodel(RigidMotion::Axial, &points(), &DofLookup::new(&dofs()), axial.as_ref(), None)
            .unwrap();
    assert!(!submodel.is_quasistatic());
    for i in 0..2 {
        assert_eq!((submodel.low[(2 * i, 0)], submodel.low[(2 * i + 1, 0)]), (0.0, 1.0));
    }
}

#[test]
fn data_that_do_not_fit_are_refused_with_their_numbers() {
    let shapes = Mat::zeros(7, 1);
    let lookup = DofLookup::new(&dofs());
    let build = |points: &[SurfacePoint], dofs: &[usize], g: &Mat<f64>, shapes: &Mat<f64>| {
        let interface = InterfaceCompliance { dofs, compliance: g.as_ref() };
        match contact_submodel(RigidMotion::Axial, points, &lookup, shapes.as_ref(), Some(interface)) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("a submodel"),
        }
    };
    let g = Mat::<f64>::identity(5, 5);
    let interface = [0, 1, 2, 3, 4];
    assert!(build(&points(), &interface[..4], &g, &shapes).contains("5 x 5, must be 4 x 4"));
    let reason = build(&points(), &[0, 1, 2, 3, 5], &g, &shapes);
    assert!(reason.contains("unknown 4") && reason.contains("not in the interface"), "{reason}");
    assert!(build(&points(), &[0, 1, 2, 3, 9], &g, &shapes).contains("9 of 7"));
    assert!(build(&points(), &interface, &g, &Mat::zeros(3, 1)).contains("of 3 "));
    assert!(build(&[], &interface, &g, &shapes).contains("no contact point"));
    let mut bad = points();
    bad[1].functions[0].1 = f64::NAN;
    assert!(build(&bad, &interface, &g, &shapes).contains("NaN"));
    let mut bad = points();
    bad[0].area = -1.0;
    assert!(build(&bad, &interface, &g, &shapes).contains("area"));
}
