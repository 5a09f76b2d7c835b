//! Mass matrices unknown by unknown: the same inertia as node by node, and bodies of beam elements.

use crate::dynamics_support::block;
use crate::spinning;
use faer::Mat;
use faer::sparse::{SparseColMat, Triplet};
use ffr_dynamics::body::{
    AssembledBody, Dof, GeometricStiffening, MassMatrix, ReferenceLoad, RigidMotion, ShapeIntegrals,
    StandardInputData,
};
use ffr_dynamics::integration::{Integrator, Method, OdeSystem, StepSettings};
use ffr_dynamics::kinematics::{Marker, MarkerWeights};
use ffr_dynamics::reduction::{ElasticProblem, FixedInterfaceModes, RigidModes, craig_bampton};
use nalgebra::{UnitQuaternion, Vector3};

/// Round-off of sums over a few hundred entries.
const ROUND_OFF: f64 = 1e-12;

/// The same body with its mass unknown by unknown.
fn generalised(body: &AssembledBody) -> AssembledBody {
    let MassMatrix::PerComponent(mass) = &body.mass else { panic!("made so") };
    let number = |node: usize, component: u8| {
        body.dofs.iter().position(|d| d.node as usize == node && d.component == component)
    };
    let mut entries = Vec::new();
    for t in mass.triplet_iter() {
        for c in 0..body.motion.n_components() as u8 {
            if let (Some(i), Some(j)) = (number(t.row, c), number(t.col, c)) {
                entries.push(Triplet::new(i.max(j) as u32, i.min(j) as u32, *t.val));
            }
        }
    }
    let n = body.dofs.len();
    let mass = MassMatrix::General(SparseColMat::try_new_from_triplets(n, n, &entries).unwrap());
    AssembledBody { mass, ..body.clone() }
}

fn close(a: &[f64], b: &[f64], what: &str) {
    assert_eq!(a.len(), b.len(), "{what}");
    let scale = a.iter().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()));
    let worst = a.iter().zip(b).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(worst <= ROUND_OFF * scale, "{what}: {worst:e} of {scale:e}");
}

#[test]
fn inertia_is_the_same_whether_the_mass_is_given_node_by_node_or_not() {
    for motion in [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial] {
        let sample = block(motion, 4);
        let general = generalised(&sample.body);
        let [a, b] =
            [&sample.body, &general].map(|b| ShapeIntegrals::new(b, sample.shapes.as_ref()).unwrap());
        close(&[a.mass], &[b.mass], "mass");
        close(a.mass_moment.as_slice(), b.mass_moment.as_slice(), "mass moment");
        close(a.second_moment.as_slice(), b.second_moment.as_slice(), "second moment");
        close(&a.position_shape, &b.position_shape, "position_shape");
        close(&a.shape_shape, &b.shape_shape, "shape_shape");
        for j in 0..4 {
            // Momenta of elastic modes vanish: round-off of the root of the mass.
            assert!((a.shapes[j] - b.shapes[j]).norm() < ROUND_OFF * a.mass.sqrt());
        }
        assert!((a.modal_mass - b.modal_mass).norm_max() < ROUND_OFF);
        if motion != RigidMotion::Axial {
            for load in ReferenceLoad::all(motion) {
                let [x, y] = [&sample.body, &general].map(|b| b.reference_load(load).unwrap());
                close(&x, &y, "reference load");
            }
        }
    }
}

const LENGTH: f64 = 10.0;
const LINE_MASS: f64 = 1.2;
const ROTARY: f64 = 6e-4;
const AXIAL: f64 = 2.8e7;
const SHEAR: f64 = 1e7;
const BENDING: f64 = 1.4e4;
const N_ELEMENTS: usize = 60;

fn lower(n: usize, entries: &[(usize, usize, f64)]) -> SparseColMat<u32, f64> {
    let triplets: Vec<_> =
        entries.iter().filter(|e| e.0 >= e.1).map(|e| Triplet::new(e.0 as u32, e.1 as u32, e.2)).collect();
    SparseColMat::try_new_from_triplets(n, n, &triplets).unwrap()
}

/// Shear-deformable beam along `direction` (an angle) from `start`: two-node elements, shear integrated at the middle.
fn beam(start: [f64; 2], angle: f64) -> AssembledBody {
    let h = LENGTH / N_ELEMENTS as f64;
    let (c, s) = (angle.cos(), angle.sin());
    let mut stiffness = Vec::new();
    let mut mass = Vec::new();
    for e in 0..N_ELEMENTS {
        // Rows: strain, shear and curvature by the unknowns u_x u_y ϑ of both nodes.
        let strain = [-c / h, -s / h, 0.0, c / h, s / h, 0.0];
        let shear = [s / h, -c / h, -0.5, -s / h, c / h, -0.5];
        let curvature = [0.0, 0.0, -1.0 / h, 0.0, 0.0, 1.0 / h];
        for i in 0..6 {
            for j in 0..6 {
                let k = h
                    * (AXIAL * strain[i] * strain[j]
                        + SHEAR * shear[i] * shear[j]
                        + BENDING * curvature[i] * curvature[j]);
                stiffness.push((3 * e + i, 3 * e + j, k));
                if i % 3 == j % 3 {
                    let line = if i % 3 == 2 { ROTARY } else { LINE_MASS };
                    mass.push((3 * e + i, 3 * e + j, line * h * if i == j { 1.0 / 3.0 } else { 1.0 / 6.0 }));
                }
            }
        }
    }
    let nodes: Vec<[f64; 3]> =
        (0..=N_ELEMENTS).map(|i| [start[0] + c * h * i as f64, start[1] + s * h * i as f64, 0.0]).collect();
    let n = 3 * nodes.len();
    AssembledBody {
        name: "beam".into(),
        motion: RigidMotion::Planar,
        stiffness: lower(n, &stiffness),
        mass: MassMatrix::General(lower(n, &mass)),
        dofs: (0..n).map(|i| Dof { node: (i / 3) as u32, component: (i % 3) as u8 }).collect(),
        anchors: nodes.clone(),
        nodes,
    }
}

#[test]
fn beam_elements_have_the_inertia_of_a_beam() {
    let body = beam([0.5, -0.3], 0.4);
    let rigid = RigidModes::new(&body).unwrap();
    let found = rigid.mass_properties;
    let inertia = LINE_MASS * LENGTH.powi(3) / 12.0 + ROTARY * LENGTH;
    close(&[found.mass, found.inertia[2][2]], &[LINE_MASS * LENGTH, inertia], "mass and inertia");
    close(&found.centre, &[0.5 + 5.0 * 0.4f64.cos(), -0.3 + 5.0 * 0.4f64.sin(), 0.0], "centre");
    let force = body.stiffness_product(rigid.modes.as_ref());
    assert!(force.norm_max() < 1e-9 * AXIAL); // round-off of 1/h² terms
}

/// Standard input data in the frame of the hub, stiffened or not, with hub and tip.
fn held(is_stiffened: bool) -> (StandardInputData, Marker, Marker) {
    let body = beam([0.0; 2], 0.0);
    let (zero, upright) = (Vector3::zeros(), UnitQuaternion::identity());
    let hub = MarkerWeights::of_nodes(&body, zero, upright, &[0]).unwrap();
    let tip = MarkerWeights::of_nodes(&body, Vector3::x() * LENGTH, upright, &[N_ELEMENTS as u32]).unwrap();
    hub.check_rigid_motions(&body).unwrap();
    tip.check_rigid_motions(&body).unwrap();
    // Twenty modes of the clamped beam hold two axial ones, which carry 99.8 % of the extension.
    let basis = craig_bampton(&body, &[0, 1, 2], 6, FixedInterfaceModes::Exactly(20)).unwrap().basis;
    let stiffness: Vec<f64> = basis.omega.iter().map(|w| w * w).collect();
    let data = StandardInputData::new(&body, basis.shapes.as_ref(), &stiffness).unwrap();
    let [hub_marker, tip] =
        [("hub", &hub), ("tip", &tip)].map(|(n, w)| w.marker(n, basis.shapes.as_ref()).unwrap());
    let frame = hub_marker.tangent_frame(RigidMotion::Planar);
    let mut data = data.in_tangent_frame(&frame).unwrap();
    if is_stiffened {
        let shapes = frame.shifted_shapes(&body, basis.shapes.as_ref()).unwrap();
        data = data.with_geometric_stiffening(&stiffening(&body, &shapes, &hub)).unwrap();
    }
    let [hub, tip] = [hub_marker, tip].map(|m| m.in_tangent_frame(&frame).unwrap());
    (data, hub, tip)
}

/// Tension of the elements under the reference loads, and what it does to their slopes.
fn stiffening(body: &AssembledBody, shapes: &Mat<f64>, hub: &MarkerWeights) -> GeometricStiffening {
    let (n, h) = (body.dofs.len(), LENGTH / N_ELEMENTS as f64);
    let loads: Vec<Vec<f64>> =
        ReferenceLoad::all(body.motion).map(|load| body.reference_load(load).unwrap()).collect();
    let loads = Mat::from_fn(n, loads.len(), |i, j| loads[j][i]);
    let support = hub.forces(body.motion, n).unwrap();
    let moved =
        ElasticProblem::free(body, &[]).unwrap().held_at_point(loads.as_ref(), support.as_ref()).unwrap();
    let held = support.transpose() * &moved;
    assert!(held.norm_max() < 1e-9 * moved.norm_max(), "the hub does not move");
    // Axial load of a unit spin: extension of the tip in closed form.
    let tip = moved[(n - 3, 2)];
    let exact = LINE_MASS * LENGTH.powi(3) / (3.0 * AXIAL);
    assert!((tip - exact).abs() < 1e-3 * exact, "{tip:e} {exact:e}"); // h²/L² of linear elements
    let none = || Mat::zeros(shapes.ncols(), shapes.ncols());
    let mut all = GeometricStiffening {
        translation: std::array::from_fn(|_| none()),
        position: std::array::from_fn(|_| std::array::from_fn(|_| none())),
    };
    for (load, u) in ReferenceLoad::all(body.motion).zip(moved.col_iter()) {
        let mut entries = Vec::new();
        for e in 0..N_ELEMENTS {
            let tension = AXIAL * (u[3 * e + 3] - u[3 * e]) / h;
            for (i, j) in [(0, 0), (1, 0), (1, 1)] {
                let sign = if i == j { 1.0 } else { -1.0 };
                entries.push((3 * (e + i) + 1, 3 * (e + j) + 1, sign * tension / h));
            }
        }
        let modal = shapes.transpose() * (symmetric(&lower(n, &entries)) * shapes);
        match load {
            ReferenceLoad::Translation { direction } => all.translation[direction] = modal,
            ReferenceLoad::Position { coordinate, direction } => all.position[coordinate][direction] = modal,
        }
    }
    all
}

/// A symmetric matrix from its lower triangle.
fn symmetric(lower: &SparseColMat<u32, f64>) -> Mat<f64> {
    let lower = lower.to_dense();
    Mat::from_fn(lower.nrows(), lower.ncols(), |i, j| lower[(i.max(j), i.min(j))])
}

fn tip_motion(is_stiffened: bool) -> Vec<[f64; 3]> {
    let (data, hub, tip) = held(is_stiffened);
    let ground = vec![Marker::rigid("hub", Vector3::zeros(), UnitQuaternion::identity())];
    let mut system = spinning::prescribed(data, hub, ground, spinning::spin_up);
    let y = system.rest();
    assert_eq!(system.dimension(), y.len());
    let layout = system.model().bodies[0].layout;
    let settings = StepSettings { max_step: 0.05, ..StepSettings::default() };
    let mut integrator = Integrator::new(Method::TrBdf2, settings, 0.0, &y, &system).unwrap();
    let (point, mut curve) = (tip.point(), Vec::new());
    integrator
        .run(&mut system, 20.0, |_, at| {
            let moved = point.local_position(&at.state()[layout.elastic()]) - point.position;
            curve.push([at.time(), moved.x, moved.y]);
            moved.y.abs() < 2.0 * LENGTH
        })
        .unwrap();
    curve
}

#[test]
fn beam_body_follows_the_spin_up_reference() {
    let found = spinning::compare(&tip_motion(true));
    // Demanded are 2 %; found are -0.57438 m, 6.2e-4 m off at most, 5.131e-4 m.
    assert!((found.extreme + 0.574).abs() < 0.02 * 0.574, "{found:?}");
    assert!(found.off < 0.02 * 0.574, "{found:?}");
    assert!((found.extension - 5.14e-4).abs() < 0.02 * 5.14e-4, "{found:?}");
}

#[test]
fn beam_body_diverges_without_stiffening() {
    let curve = tip_motion(false);
    let leaves = curve.iter().find(|p| p[2].abs() > LENGTH).map(|p| p[0]);
    // The reference without stiffening leaves at 9.17 s.
    assert!(leaves.is_some_and(|t| (t - 9.17).abs() < 0.1), "{leaves:?}");
}
