//! Elastic axisymmetric spheres with a quasistatic contact zone at a pole.
#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    reason = "tests and benchmarks use their parts; a failure is a failed test"
)]

use contact_qs::law::hertz::Solid;
use contact_qs::zone::points::{DofLookup, InterfaceCompliance, SurfacePoint};
use contact_qs::{ContactSubmodel, TargetFace, TargetSurface, contact_submodel};
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix, RigidMotion};
use ffr_dynamics::reduction::compliance::ResidualFlexibility;
use ffr_dynamics::reduction::modal::ReducedBasis;
use ffr_dynamics::reduction::problem::ElasticProblem;
use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::{Material, Model};
use iga_core::nurbs::{RefinementWindow, Shape};
use iga_core::space::{PatchSpace, Space};

use super::{collocate, highest, zone};

pub const ALUMINIUM: Solid = Solid { young: 7.28e10, poisson: 0.33 };
pub const STEEL: Solid = Solid { young: 2.1e11, poisson: 0.3 };

/// A reduced elastic body of revolution whose zone lies at the pole in direction `up` (+1 or -1).
pub struct ElasticSphere {
    pub space: PatchSpace,
    pub shape: Shape,
    pub part: TargetFace,
    pub lookup: DofLookup,
    pub basis: ReducedBasis,
    pub residual: ResidualFlexibility,
    pub points: Vec<SurfacePoint>,
    pub interface: Vec<usize>,
}

impl ElasticSphere {
    /// `width`: half-width of the zone \[m\]; `elements` in it.
    pub fn new(
        coarse: &Shape,
        solid: Solid,
        density: f64,
        up: f64,
        (width, elements): (f64, usize),
        n_modes: usize,
    ) -> Self {
        let motion = RigidMotion::Axial;
        let model = Model::Axisymmetric;
        let (_, pole) = highest(coarse, motion, &[0.0, up, 0.0]);
        let window = RefinementWindow {
            centre: pole.point,
            half_width: [width; 3],
            elements: [elements; 3],
            ratio: 1.5,
        };
        let shape = coarse.refined(&[3, 3], &[6, 6], &[window]).unwrap();
        let space = PatchSpace::new(shape.patches.clone()).unwrap();
        let material = Material::new(solid.young, solid.poisson, density).unwrap();
        let matrices = assemble(&space, &model, &material).unwrap();
        let dofs: Vec<Dof> = matrices.dofs.iter().map(|&(node, component)| Dof { node, component }).collect();
        let body = AssembledBody {
            name: "sphere".into(),
            motion,
            stiffness: matrices.stiffness,
            mass: MassMatrix::PerComponent(matrices.mass),
            nodes: space.control_points().to_vec(),
            anchors: space.anchors(),
            dofs,
        };
        let lookup = DofLookup::new(&body.dofs);
        let (face, pole) = highest(&shape, motion, &[0.0, up, 0.0]);
        let part = zone(&shape, face, &pole.xi, width);
        let points = collocate(&space, &shape, &part);
        let mut interface: Vec<usize> = points
            .iter()
            .flat_map(|p| &p.functions)
            .flat_map(|&(node, _)| [0, 1].into_iter().map(move |c| (node, c)))
            .filter_map(|(node, c)| lookup.number(node, c))
            .collect();
        interface.sort_unstable();
        interface.dedup();
        let problem = ElasticProblem::free(&body, &interface).unwrap();
        let modes = problem.lowest_modes(n_modes).unwrap();
        let basis = ReducedBasis::from_modes(modes, problem.rigid().unwrap().clone());
        let residual = ResidualFlexibility::new(&problem, &interface, &basis).unwrap();
        Self { space, shape, part, lookup, basis, residual, points, interface }
    }

    fn compliance(&self) -> InterfaceCompliance<'_> {
        InterfaceCompliance { dofs: &self.interface, compliance: self.residual.compliance().as_ref() }
    }

    pub fn submodel(&self) -> ContactSubmodel {
        let shapes = self.basis.shapes.as_ref();
        contact_submodel(RigidMotion::Axial, &self.points, &self.lookup, shapes, Some(self.compliance()))
            .unwrap()
    }

    /// The same zone as a target.
    pub fn target(&self) -> TargetSurface {
        let shapes = self.basis.shapes.as_ref();
        let (patches, parts) = (&self.shape.patches, [self.part]);
        let compliance = Some(self.compliance());
        TargetSurface::flexible(
            RigidMotion::Axial,
            &self.space,
            patches,
            &parts,
            &self.lookup,
            shapes,
            compliance,
        )
        .unwrap()
    }

    /// Elastic coordinates at rest under the modal forces `modal`.
    pub fn deflect(&self, modal: &[f64], elastic: &mut [f64]) {
        for ((q, f), omega) in elastic.iter_mut().zip(modal).zip(&self.basis.omega) {
            *q = f / (omega * omega);
        }
    }
}
