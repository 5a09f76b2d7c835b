//! A tree of three bodies whose markers turn strongly with their modes, on joints of any kind.

use crate::dynamics_support::{Random, Sample, block};
use ffr_dynamics::body::RigidMotion;
use ffr_dynamics::kinematics::Marker;
use ffr_dynamics::system::{
    Attachment, BodySpec, FreeDirections, GROUND, JointKind, JointSpec, Multibody, SystemSpec,
};
use nalgebra::{UnitQuaternion, Vector3};

pub const GRAVITY: Vector3<f64> = Vector3::new(1.0, -2.0, -9.81);
/// Step of differences of fourth order. Markers turn at up to 100 rad/s, so that truncation is about (100 h)⁴ = 1e-12 and
/// round-off of velocities 1e-15 / h = 1e-10.
pub const STEP: f64 = 1e-5;
/// Places and weights of the differences.
pub const STENCIL: [(f64, f64); 4] =
    [(-2.0, 1.0 / 12.0), (-1.0, -2.0 / 3.0), (1.0, 2.0 / 3.0), (2.0, -1.0 / 12.0)];

pub const KINDS: [JointKind; 14] = [
    JointKind::Fixed,
    JointKind::Revolute,
    JointKind::Prismatic,
    JointKind::Cylindrical,
    JointKind::Universal,
    JointKind::Spherical,
    JointKind::Planar,
    JointKind::Free,
    JointKind::Axial,
    JointKind::Generic(FreeDirections([true, false, true, false, false, false])),
    JointKind::Generic(FreeDirections([false, true, false, true, false, false])),
    JointKind::Generic(FreeDirections([true, true, true, true, false, true])),
    JointKind::Generic(FreeDirections([false, false, true, false, true, true])),
    JointKind::Generic(FreeDirections([true, false, false, true, true, true])),
];

/// Ground - first -> root - second -> left; root - third -> right. Root and left are flexible, right is rigid.
pub struct Tree {
    pub samples: [Sample; 3],
    pub system: Multibody,
    pub y: Vec<f64>,
}

pub fn tree(kinds: [JointKind; 3], seed: u64, change: impl FnOnce(&mut SystemSpec)) -> Tree {
    let mut random = Random(seed);
    let samples = [6, 5, 0].map(|n| block(RigidMotion::Spatial, n));
    let names = ["root", "left", "right"];
    let turn = |random: &mut Random| UnitQuaternion::from_scaled_axis(2.0 * random.vector());
    let body = |i: usize, random: &mut Random| {
        let markers = [("a", 1), ("b", 10)].map(|(name, node)| {
            let rotation = turn(random);
            samples[i].marker(name, node, rotation, |_| 20.0 * random.vector())
        });
        BodySpec { name: names[i].into(), data: samples[i].data.clone(), markers: markers.to_vec() }
    };
    let bodies = (0..3).map(|i| body(i, &mut random)).collect();
    let places = [(GROUND, "a"), ("root", "b"), ("root", "a")];
    let joints = (0..3).map(|i| {
        let parent = Attachment::new(places[i].0, places[i].1);
        JointSpec::new(&format!("joint {i}"), kinds[i], parent, Attachment::new(names[i], "b"))
    });
    let ground = vec![Marker::rigid("a", random.vector(), turn(&mut random))];
    let joints = joints.collect();
    let mut spec = SystemSpec { bodies, ground, joints, gravity: GRAVITY, ..SystemSpec::default() };
    change(&mut spec);
    let system: Multibody = Multibody::new(spec, Vec::new()).unwrap();
    let mut y = system.rest();
    for i in 0..3 {
        let layout = system.model().bodies[i].layout;
        let mut numbers =
            |n: usize, scale: f64| -> Vec<f64> { (0..n).map(|_| scale * random.next()).collect() };
        let positions = numbers(layout.n_positions, 0.8);
        let velocities = numbers(layout.n_velocities, 4.0);
        system.set_joint(&mut y, i, &positions, &velocities).unwrap();
        let (elastic, rates) = (numbers(layout.n_modes, 5e-3), numbers(layout.n_modes, 1.0));
        system.set_elastic(&mut y, i, &elastic, &rates).unwrap();
    }
    Tree { samples, system, y }
}

pub fn moved(y: &[f64], rates: &[f64], h: f64) -> Vec<f64> {
    y.iter().zip(rates).map(|(y, r)| y + h * r).collect()
}

/// Velocities of all nodes of all bodies.
pub fn node_velocities(tree: &mut Tree, t: f64, y: &[f64]) -> Vec<Vec<Vector3<f64>>> {
    let states = tree.system.body_states(t, y);
    let velocities = |(s, b): (&Sample, _)| s.node_motion(b).into_iter().map(|(_, v)| v).collect();
    tree.samples.iter().zip(states).map(velocities).collect()
}
