//! A flexible body of finite elements from its specification: matrices of its mesh.

use std::sync::Arc;

use contact_qs::zone::points::DofLookup;
use faer::sparse::SparseColMat;
use fe_mesh::fault::MeshFault;
use fe_mesh::{Mesh, MeshSpace};
use ffr_dynamics::body::{AssembledBody, Dof, MassMatrix};
use iga_core::SplineError;
use iga_core::elasticity::assembly::assemble;
use iga_core::elasticity::kinematics::PointState;
use iga_core::elasticity::{ElementMaterials, Material, MaterialField, Model};
use iga_core::extent::{Extent, ExtentPoint};
use iga_core::space::Space;

use crate::body::field::Field;
use crate::error::AdaptiveError;
use crate::spec::MeshedSpec;
use crate::spec::body::{dofs_of, rigid_motion};
use crate::surface::MeshSurface;

/// A body of finite elements before reduction.
pub struct MeshedBody {
    /// Name.
    pub name: String,
    /// What it was built from.
    pub spec: MeshedSpec,
    /// Displacements of its mesh.
    pub space: MeshSpace,
    /// Materials of its elements.
    pub materials: ElementMaterials,
    /// Matrices.
    pub assembled: AssembledBody,
    /// The number of the unknown of each function and component.
    pub lookup: DofLookup,
    /// Its undeformed surface.
    pub surface: Arc<MeshSurface>,
}

/// Number of elastic modes that a mesh has.
pub fn n_elastic_modes(mesh: &Mesh) -> usize {
    dofs_of(mesh.model(), mesh.nodes()).len().saturating_sub(rigid_motion(mesh.model()).count())
}

impl MeshedSpec {
    /// Displacements of the mesh.
    pub fn space(&self) -> MeshSpace {
        MeshSpace::new(self.mesh.clone(), self.mass_rule)
    }

    /// Materials of the elements.
    ///
    /// # Errors
    /// [`MeshFault`] for a group that does not exist, and for an element in none or several of them.
    pub fn materials(&self) -> Result<ElementMaterials, MeshFault> {
        let groups: Vec<_> = self.groups.iter().map(|(name, material)| (name.as_str(), *material)).collect();
        self.mesh.materials(&groups, self.material)
    }

    /// The material whose elastic constants a rigid part is compared with.
    fn first_material(&self) -> Option<&Material> {
        self.material.as_ref().or(self.groups.first().map(|(_, material)| material))
    }

    /// The softest material of the body, by the speed of its waves.
    pub fn slowest_material(&self) -> Option<&Material> {
        let speed = |m: &&Material| m.youngs_modulus() / m.density();
        let all = self.material.iter().chain(self.groups.iter().map(|(_, material)| material));
        all.min_by(|a, b| speed(a).total_cmp(&speed(b)))
    }
}

impl MeshedBody {
    /// Assembles the matrices, stiffened where parts of the body are rigid; `name` is that of the
    /// body.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`], [`AdaptiveError::Geometry`]; [`AdaptiveError::Unsupported`] for rigid parts with thousands of unknowns.
    pub fn build(name: &str, spec: MeshedSpec) -> Result<Self, AdaptiveError> {
        let materials =
            spec.materials().map_err(|source| AdaptiveError::Mesh { body: name.to_owned(), source })?;
        let space = spec.space();
        let assembled = assembled(name, &space, &materials)?;
        let lookup = DofLookup::new(&assembled.dofs);
        let surface = MeshSurface::of(&spec.mesh);
        let mut body = Self { name: name.to_owned(), spec, space, materials, assembled, lookup, surface };
        if !body.spec.flexible.rigid_areas.is_empty() {
            body.assembled.stiffness = body.held(body.assembled.stiffness.clone())?;
        }
        Ok(body)
    }

    /// A body of another name from `spec`, whose definition ([`crate::store::meshed_definition`])
    /// is this body's.
    pub fn copied(&self, name: &str, spec: MeshedSpec) -> Self {
        let assembled = AssembledBody { name: name.to_owned(), ..self.assembled.clone() };
        let (space, materials, lookup) = (spec.space(), self.materials.clone(), self.lookup.clone());
        let surface = Arc::clone(&self.surface);
        Self { name: name.to_owned(), spec, space, materials, assembled, lookup, surface }
    }

    /// `stiffness` with that of the rigid parts added, whose nodes have the first unknowns.
    ///
    /// # Errors
    /// As [`Field::stiffened`].
    pub fn held(&self, stiffness: SparseColMat<u32, f64>) -> Result<SparseColMat<u32, f64>, AdaptiveError> {
        match self.spec.first_material() {
            Some(material) => self.stiffened(stiffness, &self.spec.flexible.rigid_areas, material),
            None => Ok(stiffness),
        }
    }

    /// Nodes that move with the rigid parts.
    ///
    /// # Errors
    /// [`AdaptiveError::Mesh`] for a part that does not exist.
    pub fn rigid_nodes(&self) -> Result<Vec<u32>, AdaptiveError> {
        let mut nodes = Vec::new();
        for area in &self.spec.flexible.rigid_areas {
            for point in self.points_of(&area.extent)? {
                nodes.extend(self.space.functions_at(point.element, &point.xi).iter().map(|(node, _)| *node));
            }
        }
        Ok(nodes)
    }
}

/// Matrices of the displacements `space` of a mesh of the body `name`, of `materials`.
///
/// # Errors
/// [`AdaptiveError::Geometry`] if there are too many entries or an element is folded.
pub fn assembled(
    name: &str,
    space: &MeshSpace,
    materials: &ElementMaterials,
) -> Result<AssembledBody, AdaptiveError> {
    let model = space.mesh().model();
    let matrices = assemble(space, model, materials);
    let matrices = matrices.map_err(|source| AdaptiveError::Geometry { body: name.to_owned(), source })?;
    Ok(AssembledBody {
        name: name.to_owned(),
        motion: rigid_motion(model),
        stiffness: matrices.stiffness,
        mass: MassMatrix::PerComponent(matrices.mass),
        dofs: dofs_of(model, space.control_points()),
        anchors: space.anchors(),
        nodes: space.control_points().to_vec(),
    })
}

/// [`Field::points_of`] of `field` on the nodes of `mesh`.
pub fn points_of(field: &dyn Field, mesh: &Mesh, extent: &Extent) -> Result<Vec<ExtentPoint>, AdaptiveError> {
    part_of(mesh, extent).map_err(|source| AdaptiveError::Mesh { body: field.name().to_owned(), source })
}

/// The points of a part of the body of `mesh`.
///
/// # Errors
/// [`MeshFault`] if it has no such part.
pub fn part_of(mesh: &Mesh, extent: &Extent) -> Result<Vec<ExtentPoint>, MeshFault> {
    match extent {
        Extent::Face(name) => mesh.face_part(name),
        Extent::Around { point, radius } => mesh.around(point, *radius),
    }
}

/// [`Field::named_place`] of the same: a mesh has no points with names.
pub fn no_such_place(field: &dyn Field, mesh: &Mesh, marker: &str) -> AdaptiveError {
    let known = mesh.face_names().collect::<Vec<_>>().join(", ");
    let what = AdaptiveError::no_marker("mesh", marker, &known);
    AdaptiveError::unsupported_body(field.name(), what)
}

impl Field for MeshedBody {
    fn name(&self) -> &str {
        &self.name
    }

    fn space(&self) -> &dyn Space {
        &self.space
    }

    fn model(&self) -> &Model {
        self.spec.mesh.model()
    }

    fn materials(&self) -> &dyn MaterialField {
        &self.materials
    }

    fn dofs(&self) -> &[Dof] {
        &self.assembled.dofs
    }

    fn lookup(&self) -> &DofLookup {
        &self.lookup
    }

    fn locate(&self, place: &[f64; 3]) -> Result<(usize, [f64; 3]), AdaptiveError> {
        let found = self.spec.mesh.locate(place);
        found.map_err(|source| AdaptiveError::Mesh { body: self.name.clone(), source })
    }

    fn points_of(&self, extent: &Extent) -> Result<Vec<ExtentPoint>, AdaptiveError> {
        points_of(self, &self.spec.mesh, extent)
    }

    fn named_place(&self, marker: &str) -> Result<[f64; 3], AdaptiveError> {
        Err(no_such_place(self, &self.spec.mesh, marker))
    }

    fn unit_states(&self, e: usize, xi: &[f64; 3]) -> Result<Vec<(u32, Vec<PointState>)>, SplineError> {
        self.space.unit_states(&self.materials, e, xi)
    }
}
