//! Values of the key `model` of bodies.

use super::super::keys::name_values;

/// Kinematics of a body, which say what the components of its points are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BodyModel {
    /// Flexible, in `(x, y, z)`.
    Solid,
    /// Flexible, in `(r, z)`.
    Axisymmetric,
    /// Flexible, in `(x, y)`.
    PlaneStrain,
    /// Flexible, in `(x, y)`.
    PlaneStress,
    /// From a body file.
    Imported,
    /// Of finite elements.
    Mesh,
    /// Rigid, or a plane at rest.
    Rigid,
}

name_values!(BodyModel {
    Solid: "solid", "three-dimensional, in (x, y, z)",
        elsewhere ["3d", "flexible", "elastic", "volume", "continuum", "beam", "shell", "plate", "truss"];
    Axisymmetric: "axisymmetric", "rotationally symmetric about z, in (r, z), of a shape or a mesh `file`; moves along z only",
        elsewhere ["axi", "rotational", "2d-axisymmetric"];
    PlaneStrain: "plane-strain", "plane strain in (x, y), of a shape or a mesh `file`";
    PlaneStress: "plane-stress", "plane stress in (x, y), of a shape or a mesh `file`";
    Imported: "imported", "from the body file `file`, reduced or to be reduced (docs/body-file.md)";
    Mesh: "mesh", "three-dimensional, of finite elements, from the mesh `file` of Gmsh, Abaqus, CalculiX or Nastran (docs/own_part.md)",
        elsewhere ["fem", "fe", "finite-element", "finite-elements"];
    Rigid: "rigid", "rigid; with the shape `plane` also at rest";
});

impl BodyModel {
    /// Number of coordinates and parametric directions of a body.
    pub fn dimension(self) -> usize {
        match self {
            Self::Solid | Self::Imported | Self::Mesh | Self::Rigid => 3,
            Self::Axisymmetric | Self::PlaneStrain | Self::PlaneStress => 2,
        }
    }
}
