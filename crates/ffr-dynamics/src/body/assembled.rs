//! What a discretised elastic body hands over: sparse matrices, control points, constraints.

use faer::sparse::SparseColMat;
use nalgebra::Vector3;

/// The rigid motions that a body model can perform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RigidMotion {
    /// Axisymmetric model in `(r, z)`: translation along the axis, which is component 1 of the
    /// model and `z` in space.
    Axial,
    /// Plane model in `(x, y)`: two translations and the rotation about `z`.
    Planar,
    /// Solid model: three translations, three rotations.
    Spatial,
}

impl RigidMotion {
    /// Number of rigid modes: 1, 3 or 6.
    pub fn count(self) -> usize {
        match self {
            Self::Axial => 1,
            Self::Planar => 3,
            Self::Spatial => 6,
        }
    }

    /// Displacement components of the model: 2 or 3.
    pub fn n_components(self) -> usize {
        if self == Self::Spatial { 3 } else { 2 }
    }

    /// Number of rotations that a node may have among its unknowns, after its displacements: 0, 1
    /// or 3.
    pub fn n_rotations(self) -> usize {
        match self {
            Self::Axial => 0,
            Self::Planar => 1,
            Self::Spatial => 3,
        }
    }

    /// Axis in space (0 to 2) of a component that is a rotation; none for displacements.
    pub fn rotation_axis(self, component: u8) -> Option<usize> {
        let rotation = usize::from(component).checked_sub(self.n_components())?;
        (rotation < self.n_rotations()).then_some(if self == Self::Planar { 2 } else { rotation })
    }

    /// The rigid motions as directions: translations along x, y, z are 0 to 2, rotations about them
    /// 3 to 5.
    pub fn directions(self) -> &'static [usize] {
        match self {
            Self::Axial => &[2],
            Self::Planar => &[0, 1, 5],
            Self::Spatial => &[0, 1, 2, 3, 4, 5],
        }
    }

    /// Direction in space of displacement component `c` of the model.
    pub fn direction(self, c: usize) -> usize {
        if self == Self::Axial { [0, 2][c] } else { c }
    }

    /// A point or vector of the body's frame from its components in the model, `(x, y, z)`,
    /// `(x, y, 0)` or `(r, z, 0)`: the half plane of an axisymmetric model lies in `x` and `z`.
    pub fn in_space(self, components: &[f64; 3]) -> Vector3<f64> {
        let mut vector = Vector3::zeros();
        for (c, &x) in components.iter().enumerate().take(self.n_components()) {
            vector[self.direction(c)] = x;
        }
        vector
    }

    /// Components in the model of a point or vector of the body's frame; what a flat model does not
    /// have is left out.
    pub fn components(self, vector: &[f64; 3]) -> [f64; 3] {
        std::array::from_fn(|c| if c < self.n_components() { vector[self.direction(c)] } else { 0.0 })
    }
}

/// One unknown: displacement component `component` of control point `node`, or a rotation of a node
/// of a beam or shell.
///
/// Components count displacements first, then rotations: `u_x u_y ϑ_z` of plane models,
/// `u_x u_y u_z ϑ_x ϑ_y ϑ_z` of solid ones. Rotations need a [`MassMatrix::General`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dof {
    /// Index of the control point.
    pub node: u32,
    /// Component of the model, `0..n_components` a displacement,
    /// `n_components..n_components + n_rotations` a rotation.
    pub component: u8,
}

/// Consistent mass matrix, lower triangle.
#[derive(Debug, Clone)]
pub enum MassMatrix {
    /// Node by node matrix `m_AB = ∫ ρ R_A R_B dV`, the same for every displacement component
    /// \[kg\].
    PerComponent(SparseColMat<u32, f64>),
    /// Unknown by unknown matrix, for models of other programs and those with rotations.
    General(SparseColMat<u32, f64>),
}

/// A linear elastic body before reduction.
///
/// Unknowns are numbered `0..dofs.len()`; constrained components (zero radial displacement on an
/// axis) have no number.
#[derive(Debug, Clone)]
pub struct AssembledBody {
    /// Name for messages.
    pub name: String,
    /// Rigid motions of the model.
    pub motion: RigidMotion,
    /// Stiffness matrix `K`, lower triangle, unknown by unknown [N/m].
    pub stiffness: SparseColMat<u32, f64>,
    /// Consistent mass matrix `M`.
    pub mass: MassMatrix,
    /// The unknowns, sorted by node, then component.
    pub dofs: Vec<Dof>,
    /// Control points in the model's own components: `(x, y, z)`, `(x, y, 0)` or `(r, z, 0)` \[m\].
    pub nodes: Vec<[f64; 3]>,
    /// A place for each node such that coupled nodes are near each other; guides the elimination
    /// order.
    pub anchors: Vec<[f64; 3]>,
}
