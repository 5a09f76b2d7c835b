//! Two solid balls with contact zones as fine as a real run's and a made-up compliance of half-space type.
#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    reason = "tests and benchmarks use their parts; a failure is a failed test"
)]

use std::f64::consts::PI;

use contact_qs::quasistatic::Method;
use contact_qs::zone::points::{DofLookup, InterfaceCompliance, SurfacePoint};
use contact_qs::{
    ContactSubmodel, SurfacePair, SurfacePairSettings, TargetFace, TargetSurface, contact_submodel,
};
use faer::Mat;
use ffr_dynamics::body::{Dof, RigidMotion};
use ffr_dynamics::force::BodyState;
use iga_core::nurbs::primitives::sphere::{SphereNet, sphere};
use iga_core::nurbs::{RefinementWindow, Shape};
use iga_core::space::{PatchSpace, Space};

use super::{collocate, highest, zone};

/// Radius of both balls \[m\].
pub const RADIUS: f64 = 0.01;
pub const N_MODES: usize = 20;
/// Steel \[Pa\].
const YOUNG: f64 = 2.1e11;
const POISSON: f64 = 0.3;

/// A ball whose zone of `elements` squared elements lies at its top (+1) or bottom (-1), `width` either side of it.
pub struct Cap {
    shape: Shape,
    space: PatchSpace,
    part: TargetFace,
    lookup: DofLookup,
    points: Vec<SurfacePoint>,
    interface: Vec<usize>,
    compliance: Mat<f64>,
    shapes: Mat<f64>,
}

impl Cap {
    pub fn new(up: f64, width: f64, elements: usize, n_modes: usize) -> Self {
        let motion = RigidMotion::Spatial;
        // Off the symmetries of the net.
        let (sin, cos) = (0.6 * up).sin_cos();
        let turn = [[1.0, 0.0, 0.0], [0.0, cos, -sin], [0.0, sin, cos]];
        let coarse = sphere(RADIUS, SphereNet::Spindle).unwrap().rotated(&turn).unwrap();
        let (_, pole) = highest(&coarse, motion, &[0.0, 0.0, up]);
        let window = RefinementWindow {
            centre: pole.point,
            half_width: [width; 3],
            elements: [elements; 3],
            ratio: 3.0,
        };
        let shape = coarse.refined(&[2, 2, 3], &[4, 4, 4], &[window]).unwrap();
        let (face, pole) = highest(&shape, motion, &[0.0, 0.0, up]);
        let space = PatchSpace::new(shape.patches.clone()).unwrap();
        let part = zone(&shape, face, &pole.xi, width);
        let points = collocate(&space, &shape, &part);
        let mut nodes: Vec<u32> = points.iter().flat_map(|p| &p.functions).map(|f| f.0).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let all: Vec<Dof> = (0..space.control_points().len() as u32)
            .flat_map(|node| (0..3).map(move |component| Dof { node, component }))
            .collect();
        let interface: Vec<usize> = nodes.iter().flat_map(|n| (0..3).map(|c| 3 * *n as usize + c)).collect();
        let places = space.control_points();
        let spacing = 2.0 * width / elements as f64;
        let compliance = Mat::from_fn(interface.len(), interface.len(), |i, j| {
            let (p, q) = (places[interface[i] / 3], places[interface[j] / 3]);
            let r = (0..3).map(|c| (p[c] - q[c]).powi(2)).sum::<f64>().sqrt();
            // A point load spread over about an element; positive definite as a mixture of exp(-k r).
            let size = (1.0 - POISSON * POISSON) / (PI * YOUNG * (r + 0.3 * spacing));
            if i % 3 == j % 3 { size } else { 0.0 }
        });
        let shapes = Mat::from_fn(all.len(), n_modes, |i, k| {
            let p = places[i / 3].map(|x| x / RADIUS);
            let phase = (0.7 * k as f64 + 1.1 * (i % 3) as f64 + p[k % 3] * (1.0 + 0.2 * k as f64)).sin();
            6.0 * phase
        });
        let lookup = DofLookup::new(&all);
        Self { shape, space, part, lookup, points, interface, compliance, shapes }
    }

    fn interface(&self) -> InterfaceCompliance<'_> {
        InterfaceCompliance { dofs: &self.interface, compliance: self.compliance.as_ref() }
    }

    pub fn submodel(&self) -> ContactSubmodel {
        let shapes = self.shapes.as_ref();
        contact_submodel(RigidMotion::Spatial, &self.points, &self.lookup, shapes, Some(self.interface()))
            .unwrap()
    }

    pub fn target(&self) -> TargetSurface {
        TargetSurface::flexible(
            RigidMotion::Spatial,
            &self.space,
            &self.shape.patches,
            &[self.part],
            &self.lookup,
            self.shapes.as_ref(),
            Some(self.interface()),
        )
        .unwrap()
    }
}

/// Contact body 0 above target 1: zones of `elements` squared elements, `width` either side of the poles.
pub fn caps(width: f64, elements: usize, penalty: f64) -> SurfacePair {
    caps_with(N_MODES, width, elements, penalty)
}

/// The same with bodies of `n_modes` modes.
pub fn caps_with(n_modes: usize, width: f64, elements: usize, penalty: f64) -> SurfacePair {
    let settings =
        SurfacePairSettings { contact_body: 0, target_body: Some(1), penalty, method: Method::ActiveSet };
    let (own, target) = (Cap::new(-1.0, width, elements, n_modes), Cap::new(1.0, width, elements, n_modes));
    SurfacePair::new(own.submodel(), target.target(), settings).unwrap()
}

/// The balls pressed together by `approach`.
pub fn pressed(approach: f64) -> Vec<BodyState> {
    let mut bodies = vec![BodyState::at_rest(N_MODES); 2];
    bodies[0].position.z = 2.0 * RADIUS - approach;
    bodies
}
