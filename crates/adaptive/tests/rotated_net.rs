//! Coarse models on turned nets: fields are carried over, regular places left alone.

use crate::bodies::{ball, wanted_at};
use adaptive::rotated_net::RotatedNet;
use faer::Mat;

#[test]
fn linear_fields_are_carried_to_a_net_turned_to_the_pole() {
    let coarse = ball();
    let net = RotatedNet::new(&coarse, &wanted_at(&coarse, [0.0, 0.01, 0.0], 1e-3)).unwrap().unwrap();
    // u = (1 + y, z, 2 x): nets hold linear fields exactly, their control values are those at the control points.
    let field = |p: &[f64; 3], c: usize| [1.0 + p[1], p[2], 2.0 * p[0]][c];
    let values = |body: &adaptive::elastic_body::ElasticBody| {
        let (dofs, nodes) = (&body.assembled.dofs, &body.assembled.nodes);
        Mat::from_fn(dofs.len(), 1, |i, _| field(&nodes[dofs[i].node as usize], dofs[i].component as usize))
    };
    let carried = net.prolong(&coarse.assembled, values(&coarse).as_ref());
    let exact = values(&net.body);
    let off = (0..exact.nrows()).map(|i| (carried[(i, 0)] - exact[(i, 0)]).abs()).fold(0.0, f64::max);
    // Both integrals use the same points; the mass matrix has a condition of some 1e4, places are found to 1e-9 of the size.
    assert!(off < 1e-7, "{off:e}");
}

#[test]
fn regular_places_keep_their_net() {
    let coarse = ball();
    assert!(RotatedNet::new(&coarse, &wanted_at(&coarse, [0.0099, 0.001, 0.0], 1e-3)).unwrap().is_none());
}
