//! What bodies and their fine models are drawn by.

use super::mesh::MeshGeometry;
use super::splines::BodyGeometry;

/// What a body is drawn by.
pub enum ShownGeometry {
    /// Elements of splines.
    Splines(Box<BodyGeometry>),
    /// Finite elements.
    Mesh(Box<MeshGeometry>),
}

/// How a fine model is drawn; none if it has the elements of the body itself.
pub type ZoneGeometry = Option<ShownGeometry>;
