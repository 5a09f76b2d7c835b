//! Pairs of bodies for the tests: random zones on exact shapes, and real elastic bodies.
#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    reason = "each test file uses its part; a failure is a failed test"
)]

pub mod caps;
pub mod elastic;

use contact_qs::quasistatic::Method;
use contact_qs::quasistatic::compliance::sparse_rows::SparseRows;
use contact_qs::zone::points::{DofLookup, InterfaceCompliance, PressureMean, SurfacePoint};
use contact_qs::{ContactSubmodel, SurfacePair, SurfacePairSettings, TargetFace, TargetSurface};
use faer::Mat;
use ffr_dynamics::body::{Dof, RigidMotion};
use ffr_dynamics::force::active::{Active, ActiveForce};
use ffr_dynamics::force::{BodyState, ForceElement, GeneralisedForce, Motion};
use iga_core::nurbs::Face;
use iga_core::nurbs::Shape;
use iga_core::nurbs::local::parameter_at_distance;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::primitives::{axisymmetric, plane, sphere};
use iga_core::space::{PatchSpace, Space};
use iga_core::surface::{BodySurface, FacePoint, greville_points};
use nalgebra::{UnitQuaternion, Vector3};

use crate::common::Random;

/// Radius of all targets.
pub const RADIUS: f64 = 0.1;
pub const N_MODES: usize = 3;
pub const N_POINTS: usize = 5;

pub const MOTIONS: [RigidMotion; 3] = [RigidMotion::Axial, RigidMotion::Planar, RigidMotion::Spatial];
pub const DEPTH: f64 = 2e-3;

/// Which bodies are quasistatic, with a penalty factor that suits.
pub const CASES: [([bool; 2], f64); 5] = [
    ([true, true], 1e10),
    ([true, true], f64::INFINITY),
    ([true, false], 1e10),
    ([false, true], 1e10),
    ([false, false], 1e9),
];

/// Forces of the pair on three bodies, and its energy.
pub fn evaluate(pair: &mut Active<SurfacePair>, bodies: &[BodyState]) -> (Vec<GeneralisedForce>, f64) {
    let mut forces = forces(3, N_MODES);
    if let Err(e) = pair.evaluate(Motion::new(0.0, bodies), &mut forces) {
        panic!("{e} {:?}", pair.state().gaps());
    }
    let energies = pair.energies();
    (forces, energies.elastic_high + energies.penalty)
}

/// Central difference of the potential along a change of the bodies.
pub fn slope(
    pair: &mut Active<SurfacePair>,
    bodies: &[BodyState],
    h: f64,
    shift: impl Fn(&mut [BodyState], f64),
) -> f64 {
    let mut at = |step: f64| {
        let mut moved = bodies.to_vec();
        shift(&mut moved, step);
        evaluate(pair, &moved).1
    };
    (at(h) - at(-h)) / (2.0 * h)
}

/// A round body of the wanted model.
pub fn round(motion: RigidMotion, radius: f64) -> Shape {
    match motion {
        RigidMotion::Axial => axisymmetric::sphere(radius).unwrap().refined(&[2, 2], &[6, 6], &[]),
        RigidMotion::Planar => plane::disc(radius).unwrap().refined(&[2, 2], &[6, 6], &[]),
        RigidMotion::Spatial => {
            sphere::sphere(radius, sphere::SphereNet::Spindle).unwrap().refined(&[2, 2, 3], &[4, 4, 4], &[])
        }
    }
    .unwrap()
}

/// Direction of the target's surface where contact is made, in the model's components and in space. It keeps off the
/// singular lines of the nets.
pub fn upwards(motion: RigidMotion) -> ([f64; 3], Vector3<f64>) {
    match motion {
        RigidMotion::Axial => ([0.0, 1.0, 0.0], Vector3::z()),
        RigidMotion::Planar => ([0.0, 1.0, 0.0], Vector3::y()),
        RigidMotion::Spatial => {
            let v = Vector3::new(0.15, 0.2, 0.97).normalize();
            (v.into(), v)
        }
    }
}

/// The surface point farthest in direction `up`, on the faces of `shape`.
pub fn highest(shape: &Shape, motion: RigidMotion, up: &[f64; 3]) -> (Face, FacePoint) {
    let surface = BodySurface::new(&shape.patches, motion == RigidMotion::Axial);
    let point = surface.lowest(&shape.patches, &up.map(|x| -x)).unwrap();
    (surface.faces()[point.face], point)
}

/// The part of a face within `half` of its parameter ranges about a point.
pub fn part(shape: &Shape, face: Face, xi: &[f64; 3], half: f64) -> TargetFace {
    let mut part = TargetFace::whole(face, &shape.patches);
    for (d, u) in xi.iter().enumerate() {
        let width = part.bounds.upper[d] - part.bounds.lower[d];
        part.bounds.lower[d] = part.bounds.lower[d].max(u - half * width);
        part.bounds.upper[d] = part.bounds.upper[d].min(u + half * width);
    }
    part
}

/// The part of `face` within `width` of the point `xi` along the surface.
pub fn zone(shape: &Shape, face: Face, xi: &[f64; 3], width: f64) -> TargetFace {
    let patch = &shape.patches[face.id.patch];
    let mut part = TargetFace::whole(face, &shape.patches);
    let at = face.on_face(xi);
    for d in face.directions() {
        part.bounds.lower[d] = parameter_at_distance(patch, &at, d, -width);
        part.bounds.upper[d] = parameter_at_distance(patch, &at, d, width);
    }
    part
}

/// Greville points of the zone `part`.
pub fn collocate(space: &PatchSpace, shape: &Shape, part: &TargetFace) -> Vec<SurfacePoint> {
    let (mut basis, mut active) = (PointBasis::default(), Vec::new());
    let is_inside = |xi: &[f64; 3]| part.bounds.contains(xi, &[1e-9; 3], part.face.directions());
    let mut points = Vec::new();
    for p in greville_points(space, &shape.patches, &[part.face]).iter().filter(|p| is_inside(&p.xi)) {
        space.evaluate(p.element, &p.xi, 0, &mut basis);
        space.active_functions(p.element, &mut active);
        let functions = active.iter().zip(&basis.values).filter(|(_, v)| v.abs() > 0.0);
        points.push(SurfacePoint {
            position: p.point,
            area: p.area,
            functions: functions.map(|(&i, &v)| (i, v)).collect(),
            on_rim: false,
            pressure: p.function.map_or(PressureMean::Area, PressureMean::Function),
            facing: None,
        });
    }
    points
}

/// Target with random modes and a random compliance, so soft that all terms matter.
pub fn random_target(motion: RigidMotion, quasistatic: bool, seed: u64) -> TargetSurface {
    let mut random = Random::new(seed);
    let nc = motion.n_components();
    let shape = round(motion, RADIUS);
    let (face, top) = highest(&shape, motion, &upwards(motion).0);
    let space = PatchSpace::new(shape.patches.clone()).unwrap();
    let dofs: Vec<Dof> = space
        .control_points()
        .iter()
        .enumerate()
        .flat_map(|(node, p)| {
            let is_held = motion == RigidMotion::Axial && p[0].abs() < 1e-12;
            (0..nc)
                .filter(move |c| !(is_held && *c == 0))
                .map(move |c| Dof { node: node as u32, component: c as u8 })
        })
        .collect();
    let n = dofs.len();
    // Smooth fields, which keep the surface a surface: linear modes, quadratic fields behind the compliance.
    let points = space.control_points().to_vec();
    let fields = |random: &mut Random, count: usize, degree: usize| {
        let coefficients = random.matrix(10 * nc, count);
        Mat::from_fn(n, count, |i, k| {
            let (p, c) = (points[dofs[i].node as usize].map(|x| x / RADIUS), dofs[i].component as usize);
            let monomials = [
                1.0,
                p[0],
                p[1],
                p[2],
                p[0] * p[0],
                p[1] * p[1],
                p[2] * p[2],
                p[0] * p[1],
                p[0] * p[2],
                p[1] * p[2],
            ];
            let kept = if degree == 1 { 4 } else { 10 };
            let sum: f64 = (0..kept).map(|m| coefficients[(10 * c + m, k)] * monomials[m]).sum();
            if motion == RigidMotion::Axial && c == 0 { sum * p[0] } else { sum }
        })
    };
    let shapes = fields(&mut random, N_MODES, 1);
    let interface: Vec<usize> = (0..n).collect();
    let soft = fields(&mut random, 12, 2);
    let g = Mat::from_fn(n, n, |i, j| 1e-7 * (0..12).map(|k| soft[(i, k)] * soft[(j, k)]).sum::<f64>());
    let lookup = DofLookup::new(&dofs);
    let compliance = InterfaceCompliance { dofs: &interface, compliance: g.as_ref() };
    let parts = [part(&shape, face, &top.xi, 0.3)];
    let interface = quasistatic.then_some(compliance);
    TargetSurface::flexible(motion, &space, &shape.patches, &parts, &lookup, shapes.as_ref(), interface)
        .unwrap()
}

/// Random contact points on a bowl about the target's top, with random modes and compliance.
pub fn random_points(motion: RigidMotion, quasistatic: bool, seed: u64) -> ContactSubmodel {
    let mut random = Random::new(seed);
    let nc = motion.n_components();
    let n_rows = N_POINTS * nc;
    let up = upwards(motion).1;
    let points = (0..N_POINTS)
        .map(|_| {
            let mut p = 0.02 * Vector3::new(random.next(), random.next(), random.next());
            match motion {
                RigidMotion::Axial => p = Vector3::new(p.x.abs() + 0.002, 0.0, p.z),
                RigidMotion::Planar => p.z = 0.0,
                RigidMotion::Spatial => {}
            }
            let across = p - up * p.dot(&up);
            // The points hang below their body's frame.
            (across - up * (0.05 - 0.05 * across.norm() + 0.05 * p.dot(&up))).into()
        })
        .collect();
    let dense = random.matrix(n_rows, n_rows);
    let g = random.semidefinite(n_rows, n_rows, 1e-7);
    let mut interface = SparseRows::new(n_rows);
    (0..n_rows).for_each(|row| interface.push((0..n_rows).map(|b| (b, dense[(row, b)]))));
    let c = &dense * &g * dense.transpose();
    ContactSubmodel {
        motion,
        points,
        areas: (0..N_POINTS).map(|_| 1e-4 * (1.5 + random.next())).collect(),
        low: random.matrix(n_rows, N_MODES),
        compliance: if quasistatic {
            Mat::from_fn(n_rows, n_rows, |i, j| 0.5 * (c[(i, j)] + c[(j, i)]))
        } else {
            Mat::zeros(0, 0)
        }
        .into(),
        interface,
        rim: vec![0],
        facing: Vec::new(),
        left_out: Vec::new(),
    }
}

/// Moment of the forces on all bodies about the origin.
pub fn moment(bodies: &[BodyState], forces: &[GeneralisedForce]) -> Vector3<f64> {
    let pairs = bodies.iter().zip(forces);
    pairs.map(|(b, f)| b.position.cross(&f.force) + b.rotation * f.torque_in_body).sum()
}

/// Contact body 2, target 0, a third body between them in the list.
pub fn random_pair(
    motion: RigidMotion,
    quasistatic: [bool; 2],
    penalty: f64,
    method: Method,
    seed: u64,
) -> SurfacePair {
    let settings = SurfacePairSettings { contact_body: 2, target_body: Some(0), penalty, method };
    let points = random_points(motion, quasistatic[0], seed);
    // Tight, so that gradients can be told to many digits.
    let target = random_target(motion, quasistatic[1], seed + 100);
    SurfacePair::new(points, target, settings).unwrap().with_tolerance(1e-12)
}

/// Both bodies turned and deformed, and pressed together by `depth`.
pub fn random_bodies(pair: &SurfacePair, motion: RigidMotion, depth: f64, seed: u64) -> Vec<BodyState> {
    use contact_qs::ContactElement;
    let mut random = Random::new(seed);
    let mut bodies = vec![BodyState::at_rest(N_MODES); 3];
    let common = match motion {
        RigidMotion::Axial => UnitQuaternion::identity(),
        RigidMotion::Planar => UnitQuaternion::from_axis_angle(&Vector3::z_axis(), random.next()),
        RigidMotion::Spatial => {
            UnitQuaternion::from_euler_angles(random.next(), random.next(), random.next())
        }
    };
    for body in &mut bodies {
        let tilt = 0.1 * Vector3::new(random.next(), random.next(), random.next());
        let tilt = match motion {
            RigidMotion::Axial => Vector3::zeros(),
            RigidMotion::Planar => Vector3::new(0.0, 0.0, tilt.z),
            RigidMotion::Spatial => tilt,
        };
        body.rotation = common * UnitQuaternion::from_scaled_axis(tilt);
        body.elastic.iter_mut().for_each(|q| *q = 1e-3 * random.next());
    }
    let up = common * upwards(motion).1;
    bodies[0].position = Vector3::new(0.0, 0.0, 0.2);
    if motion != RigidMotion::Axial {
        bodies[0].position += Vector3::new(0.3, -0.1, 0.0);
    }
    if motion == RigidMotion::Planar {
        bodies[0].position.z = 0.0;
    }
    bodies[2].position = bodies[0].position + up * (RADIUS + 0.05);
    let (state, mut workspace, _) = pair.start();
    for _ in 0..20 {
        let gap = pair.meeting(Motion::new(0.0, &bodies), &state, &mut workspace).gap;
        bodies[2].position -= up * (gap + depth);
    }
    bodies
}

pub fn forces(n: usize, n_modes: usize) -> Vec<GeneralisedForce> {
    vec![GeneralisedForce::zeros(n_modes); n]
}
