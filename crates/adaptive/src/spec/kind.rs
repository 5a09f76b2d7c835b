//! What a body is made from, and what of that all kinds answer alike.

use ffr_dynamics::body::RigidMotion;
use iga_core::elasticity::Material;
use iga_core::nurbs::jet::diagonal;

use super::body::{ElasticSpec, FlexibleSpec, Geometry, InitialMotion, MeshedSpec, RigidSpec, rigid_motion};
use super::imported::ImportedSpec;

/// A body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodySpec {
    /// Name.
    pub name: String,
    /// Its kind, with the specification of that kind.
    pub kind: BodyKind,
    /// Motion at the start. Of a body that is the child of a joint only the rotation counts, as the
    /// one with all joint coordinates at zero.
    pub motion: InitialMotion,
}

/// Elastic, rigid, or from a file.
#[derive(Debug, Clone, PartialEq)]
pub enum BodyKind {
    /// An elastic body.
    Elastic(Box<ElasticSpec>),
    /// A rigid body.
    Rigid(RigidSpec),
    /// A body from a file.
    Imported(ImportedSpec),
    /// An elastic body of finite elements.
    Meshed(Box<MeshedSpec>),
}

impl BodyKind {
    /// Rigid motions of the body.
    pub fn motion(&self) -> RigidMotion {
        match self {
            Self::Elastic(elastic) => rigid_motion(&elastic.model),
            Self::Rigid(rigid) => rigid.motion,
            Self::Imported(imported) => imported.motion(),
            Self::Meshed(meshed) => rigid_motion(meshed.mesh.model()),
        }
    }

    /// The exact shape, if it has one.
    pub fn geometry(&self) -> Option<Geometry<'_>> {
        match self {
            Self::Elastic(elastic) => Some(elastic.geometry()),
            Self::Rigid(rigid) => rigid.geometry(),
            Self::Imported(_) | Self::Meshed(_) => None,
        }
    }

    /// The material with the slowest waves; none of a rigid body, and of one from a file.
    pub fn slowest_material(&self) -> Option<&Material> {
        self.elastic().map(|elastic| &elastic.material).or_else(|| self.meshed()?.slowest_material())
    }

    /// The elastic body of splines, if it is one.
    pub fn elastic(&self) -> Option<&ElasticSpec> {
        if let Self::Elastic(elastic) = self { Some(elastic) } else { None }
    }

    /// The same, to be changed.
    pub fn elastic_mut(&mut self) -> Option<&mut ElasticSpec> {
        if let Self::Elastic(elastic) = self { Some(elastic) } else { None }
    }

    /// The body of finite elements, if it is one.
    pub fn meshed(&self) -> Option<&MeshedSpec> {
        if let Self::Meshed(meshed) = self { Some(meshed) } else { None }
    }

    /// The body from a file, if it is one.
    pub fn imported(&self) -> Option<&ImportedSpec> {
        if let Self::Imported(imported) = self { Some(imported) } else { None }
    }

    /// The rigid body, if it is one.
    pub fn rigid(&self) -> Option<&RigidSpec> {
        if let Self::Rigid(rigid) = self { Some(rigid) } else { None }
    }

    /// Whether it is rigid.
    pub fn is_rigid(&self) -> bool {
        self.rigid().is_some()
    }

    /// Whether it brings elements, which are reduced here.
    pub fn has_elements(&self) -> bool {
        self.elastic().is_some() || self.meshed().is_some()
    }

    /// Whether it brings a mesh of its own, which is refined at a touch at most.
    pub fn brings_mesh(&self) -> bool {
        self.meshed().is_some()
    }

    /// Whether it is of elements that are made here, from its shape.
    pub fn is_meshed_here(&self) -> bool {
        self.elastic().is_some()
    }

    /// Thickness of a plane model \[m\]; none of others.
    pub fn thickness(&self) -> Option<f64> {
        match self {
            Self::Elastic(elastic) => elastic.model.thickness(),
            Self::Meshed(meshed) => meshed.mesh.model().thickness(),
            Self::Imported(_) | Self::Rigid(_) => None,
        }
    }

    /// How it is reduced, held, damped and framed; none of a rigid body, and of one that comes
    /// reduced.
    pub fn flexible(&self) -> Option<&FlexibleSpec> {
        match self {
            Self::Elastic(elastic) => Some(&elastic.flexible),
            Self::Meshed(meshed) => Some(&meshed.flexible),
            Self::Imported(ImportedSpec::Full { flexible, .. }) => Some(flexible),
            Self::Imported(ImportedSpec::Reduced(_)) | Self::Rigid(_) => None,
        }
    }

    /// The same, to be changed.
    pub fn flexible_mut(&mut self) -> Option<&mut FlexibleSpec> {
        match self {
            Self::Elastic(elastic) => Some(&mut elastic.flexible),
            Self::Meshed(meshed) => Some(&mut meshed.flexible),
            Self::Imported(ImportedSpec::Full { flexible, .. }) => Some(flexible),
            Self::Imported(ImportedSpec::Reduced(_)) | Self::Rigid(_) => None,
        }
    }

    /// Its materials; none of a rigid body, and of one from a file.
    pub fn materials(&self) -> Vec<Material> {
        match self {
            Self::Elastic(elastic) => vec![elastic.material],
            Self::Meshed(meshed) => meshed
                .material
                .into_iter()
                .chain(meshed.groups.iter().map(|(_, material)| *material))
                .collect(),
            Self::Imported(_) | Self::Rigid(_) => Vec::new(),
        }
    }

    /// The least yield strength of its materials; infinite where none is known \[Pa\].
    pub fn yield_strength(&self) -> f64 {
        self.materials().iter().map(Material::yield_strength).fold(f64::INFINITY, f64::min)
    }

    /// The diagonal of the box about its control points or nodes \[m\]; none of a body without a
    /// shape.
    pub fn diagonal(&self) -> Option<f64> {
        if let Some(meshed) = self.meshed() {
            return Some(meshed.mesh.size());
        }
        if let Some(ImportedSpec::Full { body, .. }) = self.imported() {
            return Some(diagonal(&body.body().nodes));
        }
        let patches = self.geometry()?.shape.patches.iter();
        Some(diagonal(patches.flat_map(|patch| patch.control_points().iter())))
    }
}

impl BodySpec {
    /// The exact shape of the body, if it has one.
    pub fn geometry(&self) -> Option<Geometry<'_>> {
        self.kind.geometry()
    }

    /// The elastic body of splines, if it is one.
    pub fn elastic(&self) -> Option<&ElasticSpec> {
        self.kind.elastic()
    }
}
