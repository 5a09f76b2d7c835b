//! What a body is made from, and what of that all kinds answer alike.

use ffr_dynamics::body::RigidMotion;
use iga_core::elasticity::Material;
use iga_core::nurbs::jet::diagonal;

use super::body::{
    Area, ElasticSpec, FrameSpec, Geometry, InitialMotion, MeshedSpec, RigidSpec, rigid_motion,
};
use super::imported::ImportedSpec;
use super::reduction::{DampingSpec, ReductionSpec};

/// A body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodySpec {
    /// Name.
    pub name: String,
    /// What it is.
    pub kind: BodyKind,
    /// Motion at the start. Of a body that is the child of a joint only the rotation counts, as the one with all joint coordinates
    /// at zero.
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
            Self::Meshed(_) => RigidMotion::Spatial,
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
        match self {
            Self::Elastic(elastic) => Some(&elastic.material),
            Self::Meshed(meshed) => meshed.slowest_material(),
            Self::Rigid(_) | Self::Imported(_) => None,
        }
    }

    /// The elastic body of splines, if it is one.
    pub fn elastic(&self) -> Option<&ElasticSpec> {
        if let Self::Elastic(elastic) = self { Some(elastic) } else { None }
    }

    /// Whether it is rigid.
    pub fn is_rigid(&self) -> bool {
        matches!(self, Self::Rigid(_))
    }

    /// Whether it brings elements, which are reduced here.
    pub fn has_elements(&self) -> bool {
        matches!(self, Self::Elastic(_) | Self::Meshed(_))
    }

    /// Whether it brings a mesh of its own, which is refined at a touch at most.
    pub fn brings_mesh(&self) -> bool {
        matches!(self, Self::Meshed(_))
    }

    /// Whether it is of elements that are made here, from its shape.
    pub fn is_meshed_here(&self) -> bool {
        matches!(self, Self::Elastic(_))
    }

    /// Thickness of a plane model \[m\]; none of others.
    pub fn thickness(&self) -> Option<f64> {
        self.elastic()?.model.thickness()
    }

    /// How it is to be reduced; none of a rigid body, and of one that comes reduced.
    pub fn reduction(&self) -> Option<ReductionSpec> {
        match self {
            Self::Elastic(elastic) => Some(elastic.reduction),
            Self::Meshed(meshed) => Some(meshed.reduction),
            Self::Imported(ImportedSpec::Full { reduction, .. }) => Some(*reduction),
            Self::Imported(ImportedSpec::Reduced(_)) | Self::Rigid(_) => None,
        }
    }

    /// The same, to be changed.
    pub fn reduction_mut(&mut self) -> Option<&mut ReductionSpec> {
        match self {
            Self::Elastic(elastic) => Some(&mut elastic.reduction),
            Self::Meshed(meshed) => Some(&mut meshed.reduction),
            Self::Imported(ImportedSpec::Full { reduction, .. }) => Some(reduction),
            Self::Imported(ImportedSpec::Reduced(_)) | Self::Rigid(_) => None,
        }
    }

    /// Whether its basis is to have static answers to its joints and loads: reduced ones are as they are, and every mode leaves nothing out.
    pub fn has_static_answers(&self) -> bool {
        let is_wanted = match self {
            Self::Elastic(elastic) => elastic.static_answers,
            Self::Meshed(meshed) => meshed.static_answers,
            Self::Imported(ImportedSpec::Full { static_answers, .. }) => *static_answers,
            Self::Imported(ImportedSpec::Reduced(_)) | Self::Rigid(_) => false,
        };
        is_wanted && self.reduction() != Some(ReductionSpec::All)
    }

    /// Damping of its elastic coordinates; none of a rigid body, and of one that comes with its own.
    pub fn damping(&self) -> Option<&DampingSpec> {
        match self {
            Self::Elastic(elastic) => Some(&elastic.damping),
            Self::Meshed(meshed) => Some(&meshed.damping),
            Self::Imported(ImportedSpec::Full { damping, .. }) => Some(damping),
            Self::Imported(ImportedSpec::Reduced(_)) | Self::Rigid(_) => None,
        }
    }

    /// Damping and rigid parts of a body with elements, to be changed.
    pub fn held_mut(&mut self) -> Option<(&mut DampingSpec, &mut Vec<Area>)> {
        match self {
            Self::Elastic(elastic) => Some((&mut elastic.damping, &mut elastic.rigid_areas)),
            Self::Meshed(meshed) => Some((&mut meshed.damping, &mut meshed.rigid_areas)),
            Self::Imported(_) | Self::Rigid(_) => None,
        }
    }

    /// Reference frame of a body with elements, to be changed.
    pub fn frame_mut(&mut self) -> Option<&mut FrameSpec> {
        match self {
            Self::Elastic(elastic) => Some(&mut elastic.frame),
            Self::Meshed(meshed) => Some(&mut meshed.frame),
            Self::Imported(_) | Self::Rigid(_) => None,
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

    /// The diagonal of the box about its control points or nodes \[m\]; none of a body without a shape.
    pub fn diagonal(&self) -> Option<f64> {
        match self {
            Self::Meshed(meshed) => Some(meshed.mesh.size()),
            Self::Imported(ImportedSpec::Full { body, .. }) => Some(diagonal(&body.body().nodes)),
            Self::Elastic(_) | Self::Rigid(_) | Self::Imported(ImportedSpec::Reduced(_)) => {
                let patches = self.geometry()?.shape.patches.iter();
                Some(diagonal(patches.flat_map(|patch| patch.control_points().iter())))
            }
        }
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
