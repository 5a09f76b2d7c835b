//! Meshes in the plane: what plane and axisymmetric models ask of them.

use iga_core::elasticity::Model;

use crate::element::jacobian::{cross, minus};
use crate::element::kind::ElementKind;
use crate::fault::MeshFault;
use crate::mesh::Mesh;
use crate::mesh::boundary::Face;
use crate::mesh::check::diagonal;
use crate::mesh::raw::{Elements, FaceSource, RawMesh};

/// Distance from the plane or the axis, as a share of the size of the part, within which a node lies
/// there: coordinates in files have at least six digits.
const ROUND_OFF: f64 = 1e-6;

/// Where the nodes of `kind` stand in an element whose corners turn the other way.
fn turned(kind: ElementKind) -> Vec<usize> {
    let n = kind.n_corners();
    let middles = (0..n).map(|i| 2 * n - 1 - i).chain([2 * n]);
    (0..n).map(|i| (n - i) % n).chain(middles).take(kind.n_nodes()).collect()
}

/// Moves the nodes of plane elements into `z = 0`, turns clockwise elements over, and lets the numbers of
/// sides follow.
///
/// # Errors
/// [`MeshFault::NotPlane`] with the node that is farthest from the first.
pub fn flatten(raw: &mut RawMesh) -> Result<(), MeshFault> {
    let Some(first) = raw.nodes.first().map(|x| x[2]) else { return Ok(()) };
    let away = |i: &usize| (raw.nodes[*i][2] - first).abs();
    let farthest = (0..raw.nodes.len()).max_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or_default();
    if away(&farthest) > ROUND_OFF * diagonal(&raw.nodes) {
        let (node, distance) = (raw.node_labels[farthest], away(&farthest));
        return Err(MeshFault::NotPlane { node, distance });
    }
    raw.nodes.iter_mut().for_each(|x| x[2] = 0.0);
    let (all, mut is_turned) = (std::mem::take(&mut raw.elements), Vec::with_capacity(raw.elements.len()));
    let mut elements = Elements::default();
    for element in all.iter() {
        let [a, b, c] = [0, 1, 2].map(|i| raw.nodes[element.nodes[i] as usize]);
        let is_clockwise = cross(&minus(&b, &a), &minus(&c, &a))[2] < 0.0;
        let order = if is_clockwise { turned(element.kind) } else { (0..element.nodes.len()).collect() };
        elements.push(element.kind, element.label, order.into_iter().map(|i| element.nodes[i]));
        is_turned.push(is_clockwise);
    }
    for (_, source) in &mut raw.faces {
        if let FaceSource::Sides(sides) = source {
            for (e, side) in sides.iter_mut().filter(|(e, _)| is_turned[*e as usize]) {
                *side = (elements.get(*e as usize).kind.n_corners() as u8 - 1).saturating_sub(*side);
            }
        }
    }
    raw.elements = elements;
    Ok(())
}

impl Mesh {
    /// The mesh as that of a body with the kinematics `model`. Of an axisymmetric one the sides on the axis
    /// `r = 0` are no surface.
    ///
    /// # Errors
    /// [`MeshFault::Dimension`] for solid elements of a plane model and plane ones of a solid;
    /// [`MeshFault::BeyondAxis`] for a node with a negative radius.
    pub fn of_model(mut self, model: Model) -> Result<Self, MeshFault> {
        if self.model.dimension() != model.dimension() {
            return Err(MeshFault::Dimension { is_plane: self.model.dimension() == 2 });
        }
        self.model = model;
        if let Some(stated) = self.stated.filter(|stated| !stated.is_of(&model)) {
            let note =
                format!("its elements are made for {}; they are computed by the body's model", stated.name());
            self.notes.push(note);
        }
        if model == Model::Axisymmetric {
            let near = ROUND_OFF * self.size();
            if let Some(i) = self.nodes.iter().position(|x| x[0] < -near) {
                return Err(MeshFault::BeyondAxis { node: self.node_labels[i], radius: self.nodes[i][0] });
            }
            self.nodes.iter_mut().filter(|x| x[0] <= near).for_each(|x| x[0] = 0.0);
            let (elements, nodes) = (&self.elements, &self.nodes);
            let is_off_axis = |face: &Face| {
                let element = elements.get(face.element as usize);
                let ends = element.kind.sides()[face.side as usize].iter();
                ends.into_iter().any(|&c| nodes[element.nodes[c as usize] as usize][0] > 0.0)
            };
            self.surface.retain(is_off_axis);
            self.faces.iter_mut().for_each(|(_, faces)| faces.retain(is_off_axis));
        }
        Ok(self)
    }

    /// Kinematics: of a mesh that has just been read solid, or plane strain of unit thickness.
    pub fn model(&self) -> &Model {
        &self.model
    }
}
