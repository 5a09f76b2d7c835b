//! Bodies, motions and a brute-force distance that shares no code with the search.

use std::f64::consts::PI;

use contact_qs::{DofLookup, SurfaceModel};
use faer::Mat;
use ffr_dynamics::body::{Dof, RigidMotion};
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::Face;
use iga_core::nurbs::patch::PointBasis;
use iga_core::nurbs::{Patch, Shape};
use iga_core::space::{PatchSpace, Space};
use iga_core::splines::knots::KnotVector;
use nalgebra::{UnitQuaternion, Vector3};

use crate::common::Random;

/// A body at `position`, undeformed unless told otherwise.
pub fn at(position: [f64; 3]) -> BodyState {
    BodyState { position: Vector3::from(position), ..BodyState::at_rest(0) }
}

pub fn random_rotation(random: &mut Random) -> UnitQuaternion<f64> {
    let axis = Vector3::new(random.next(), random.next(), random.next());
    UnitQuaternion::from_scaled_axis(axis * PI)
}

pub fn random_direction(random: &mut Random) -> Vector3<f64> {
    loop {
        let v = Vector3::new(random.next(), random.next(), random.next());
        if (0.1..1.0).contains(&v.norm()) {
            return v.normalize();
        }
    }
}

/// Refined patches of a shape, `elements` a direction.
pub fn refined(shape: &Shape, elements: usize) -> Vec<Patch> {
    let degrees: Vec<usize> = shape.patches[0].knots().iter().map(KnotVector::degree).collect();
    shape.refined(&degrees, &vec![elements; degrees.len()], &[]).unwrap().patches
}

pub fn rigid(motion: RigidMotion, shape: &Shape, elements: usize) -> SurfaceModel {
    SurfaceModel::rigid(motion, &refined(shape, elements)).unwrap()
}

/// A plane C: three quarters of a ring, open towards +x, as exact quadratic arcs.
pub fn c_shape(inner: f64, outer: f64) -> Shape {
    let half = PI / 4.0;
    let (mut points, mut weights) = (Vec::new(), Vec::new());
    // From -45 degrees clockwise to +45 degrees, so that the map is right-handed with the radius as second direction.
    for radius in [inner, outer] {
        for k in 0..7 {
            let angle = -PI / 4.0 - f64::from(k) * half;
            let middle = k % 2 == 1;
            let (length, weight) = if middle { (radius / half.cos(), half.cos()) } else { (radius, 1.0) };
            points.push([length * angle.cos(), length * angle.sin(), 0.0]);
            weights.push(weight);
        }
    }
    let third = 1.0 / 3.0;
    let around =
        KnotVector::new(2, vec![0.0, 0.0, 0.0, third, third, 2.0 * third, 2.0 * third, 1.0, 1.0, 1.0])
            .unwrap();
    let patch = Patch::new(vec![around, KnotVector::uniform(1, 1).unwrap()], points, weights).unwrap();
    Shape::from_patches(vec![patch]).unwrap()
}

/// A flexible body with smooth made-up modes, and the patches it has when deformed.
pub struct Flexible {
    pub model: SurfaceModel,
    space: PatchSpace,
    shapes: Mat<f64>,
    components: usize,
}

impl Flexible {
    pub fn new(motion: RigidMotion, shape: &Shape, elements: usize, n_modes: usize) -> Self {
        let space = PatchSpace::new(refined(shape, elements)).unwrap();
        let components = motion.n_components();
        let n_nodes = space.n_functions();
        let dofs: Vec<Dof> = (0..n_nodes * components)
            .map(|k| Dof { node: (k / components) as u32, component: (k % components) as u8 })
            .collect();
        let shapes = Mat::from_fn(dofs.len(), n_modes, |k, mode| {
            let p = space.control_points()[k / components];
            let (c, m) = ((k % components) as f64, mode as f64);
            ((1.0 + m) * p[0] + 2.0 * p[1] + c).sin() * (1.0 + m * p[2] + 0.5 * p[0]).cos()
        });
        let lookup = DofLookup::new(&dofs);
        let model = SurfaceModel::new(motion, space.patches(), &space, &lookup, shapes.as_ref()).unwrap();
        Self { model, space, shapes, components }
    }

    pub fn deformed(&self, q: &[f64]) -> Vec<Patch> {
        let moved = |(index, patch): (usize, &Patch)| {
            let points = patch.control_points().iter().zip(self.space.functions(index));
            let points = points.map(|(p, &f)| {
                let mut p = *p;
                for (c, x) in p.iter_mut().enumerate().take(self.components) {
                    let row = f as usize * self.components + c;
                    *x += q.iter().enumerate().map(|(k, q)| q * self.shapes[(row, k)]).sum::<f64>();
                }
                p
            });
            Patch::new(patch.knots().to_vec(), points.collect(), patch.weights().to_vec()).unwrap()
        };
        self.space.patches().iter().enumerate().map(moved).collect()
    }
}

/// Faces of patches in space, evaluated point by point.
pub struct Sampled<'a> {
    patches: &'a [Patch],
    faces: Vec<Face>,
    motion: RigidMotion,
    state: &'a BodyState,
}

type Place = (usize, [f64; 2]);

impl<'a> Sampled<'a> {
    pub fn new(motion: RigidMotion, patches: &'a [Patch], state: &'a BodyState) -> Self {
        Self { patches, faces: Face::outer(patches, motion == RigidMotion::Axial), motion, state }
    }

    fn point(&self, (face, share): Place) -> Vector3<f64> {
        let face = &self.faces[face];
        let patch = &self.patches[face.id.patch];
        let (lower, upper) = patch.domain();
        let mut xi = [0.0; 3];
        for (d, s) in face.directions().zip(share) {
            xi[d] = lower[d] + s.clamp(0.0, 1.0) * (upper[d] - lower[d]);
        }
        let p = face.at(patch, &xi, &mut PointBasis::default()).point;
        let mut x = Vector3::zeros();
        for (c, value) in p.iter().enumerate().take(self.motion.n_components()) {
            x[self.motion.direction(c)] = *value;
        }
        self.state.position + self.state.rotation * x
    }

    fn samples(&self, n: usize) -> Vec<(Place, Vector3<f64>)> {
        let solid = self.motion == RigidMotion::Spatial;
        let mut all = Vec::new();
        for face in 0..self.faces.len() {
            for k in 0..if solid { n * n } else { n } {
                let share = [(k % n) as f64, (k / n) as f64].map(|i| i / (n - 1) as f64);
                all.push(((face, share), self.point((face, share))));
            }
        }
        all
    }
}

/// Distance by sampling with `n` points per direction, then by ever finer grids around the best pair of every two faces.
pub fn brute_force(a: &Sampled<'_>, b: &Sampled<'_>, n: usize) -> f64 {
    let n_faces = b.faces.len();
    let (first, second) = (a.samples(n), b.samples(n));
    let mut best = vec![(f64::INFINITY, first[0].0, second[0].0); a.faces.len() * n_faces];
    for (u, x) in &first {
        for (v, y) in &second {
            let square = (x - y).norm_squared();
            let kept = &mut best[u.0 * n_faces + v.0];
            if square < kept.0 {
                *kept = (square, *u, *v);
            }
        }
    }
    // Faces that cannot beat the best sample even if they come nearer by a sample's spacing are left out.
    let least = best.iter().map(|b| b.0).fold(f64::INFINITY, f64::min);
    let hopeful = best.into_iter().filter(|b| b.0.sqrt() < least.sqrt() + 0.2);
    hopeful.map(|start| zoom(a, b, n, start)).fold(f64::INFINITY, f64::min)
}

fn zoom(a: &Sampled<'_>, b: &Sampled<'_>, n: usize, mut best: (f64, Place, Place)) -> f64 {
    let mut width = 1.0 / (n - 1) as f64;
    while width > 1e-7 {
        let around = |of: &Sampled<'_>, (face, s): Place| {
            let steps = (0..9).map(move |k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0]);
            steps
                .map(|d| (face, [0, 1].map(|i| (s[i] + width * d[i]).clamp(0.0, 1.0))))
                .map(|place| (place, of.point(place)))
                .collect::<Vec<_>>()
        };
        let before = best.0;
        for (u, x) in &around(a, best.1) {
            for (v, y) in &around(b, best.2) {
                let square = (x - y).norm_squared();
                if square < best.0 {
                    best = (square, *u, *v);
                }
            }
        }
        if best.0 >= before {
            width *= 0.5;
        }
    }
    best.0.sqrt()
}
