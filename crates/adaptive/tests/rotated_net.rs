//! Coarse models on turned nets: fields are carried over, all places of a ball are one.

use crate::bodies::{ball, wanted_at};
use adaptive::fine_model::{FineMesh, FineSettings};
use adaptive::rotated_net::{NetRotation, RotatedNet};
use adaptive::spec::PointRule;
use faer::Mat;
use ffr_dynamics::body::AssembledBody;
use ffr_dynamics::reduction::FreeFlexibility;
use ffr_dynamics::reduction::problem::ElasticProblem;

#[test]
fn linear_fields_are_carried_to_a_net_turned_to_the_pole() {
    let coarse = ball();
    let turn = NetRotation::new(&coarse, &wanted_at(&coarse, [0.0, 0.01, 0.0], 1e-3)).unwrap().unwrap();
    let net = RotatedNet::new(&coarse, turn).unwrap();
    // u = (1 + y, z, 2 x): nets hold linear fields exactly, their control values are those at the control points.
    let field = |p: &[f64; 3], c: usize| [1.0 + p[1], p[2], 2.0 * p[0]][c];
    let (dofs, nodes) = (&coarse.assembled.dofs, &coarse.assembled.nodes);
    let turned = |p: &[f64; 3]| turn.rotation.map(|row| (0..3).map(|c| row[c] * p[c]).sum());
    let values = |node: &dyn Fn(usize) -> [f64; 3]| {
        Mat::from_fn(dofs.len(), 1, |i, _| field(&node(dofs[i].node as usize), dofs[i].component as usize))
    };
    let carried = net.prolong(&coarse.assembled, values(&|n| nodes[n]).as_ref());
    let exact = values(&|n| turned(&nodes[n]));
    let off = (0..exact.nrows()).map(|i| (carried[(i, 0)] - exact[(i, 0)]).abs()).fold(0.0, f64::max);
    // Both integrals use the same points; the mass matrix has a condition of some 1e4, places are found to 1e-9 of the size.
    assert!(off < 1e-7, "{off:e}");
}

#[test]
fn intervals_of_a_ball_are_one_wherever_they_lie() {
    let coarse = ball();
    let at = |point| NetRotation::new(&coarse, &wanted_at(&coarse, point, 1e-3)).unwrap().unwrap().wanted;
    let first = at([0.01, 0.0, 0.0]);
    for point in [[0.0099, 0.001, 0.0], [-0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.004, -0.005, 0.006]] {
        // To the last bit: it is what fine models are kept by.
        assert_eq!(at(point), first, "{point:?}");
    }
}

#[test]
fn the_flexibility_turned_with_the_net_is_that_of_the_turned_net() {
    let coarse = ball();
    let wanted = wanted_at(&coarse, [0.004, -0.005, 0.006], 1e-3);
    let settings = FineSettings { elements: 6, ..FineSettings::default() };
    let mesh = FineMesh::build(&coarse, &[wanted], &settings).unwrap();
    let unknowns = mesh.zone(0, PointRule::Gauss).unwrap().unknowns;
    let turn = mesh.turn(&coarse).expect("a ball is turned");
    let flexibility = |assembled: AssembledBody| {
        let problem = ElasticProblem::free(&assembled, &unknowns).unwrap();
        FreeFlexibility::new(&problem, &unknowns).unwrap()
    };
    let unturned = flexibility(mesh.assemble_unturned(&coarse).unwrap());
    let direct = flexibility(mesh.assemble(&coarse).unwrap());
    let none = coarse.reduce(&Default::default()).unwrap().basis.truncated(0);
    let turned = none.low_modes().take_out(unturned.compliance().clone(), &unknowns, Some(turn));
    let (size, off) = (direct.compliance().norm_max(), (&turned - direct.compliance()).norm_max());
    // Round-off of two factorisations, with a condition of 1e6 at most.
    assert!(off < 1e-9 * size, "{off:e} of {size:e}");
    assert!((unturned.compliance() - direct.compliance()).norm_max() > 1e-2 * size, "the frames differ");
}
