//! Markers of an unreduced body: which unknowns move them, and how (docs/theory.md Eq. M.8).

use faer::{Mat, MatRef};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use super::marker_frame::Marker;
use crate::body::{AssembledBody, RigidMotion};
use crate::data_error::DataError;
use crate::error::DynamicsError;

/// Deviation from a rigid motion, as a share of its size, up to which a marker follows the body as
/// a whole.
const RIGIDITY: f64 = 1e-6;
/// Smallest moment of a set of nodes about its centre, as a share of the largest, that defines a
/// rotation.
const FLATNESS: f64 = 1e-12;

/// Displacement and rotation of a marker as linear functions of the unknowns of a body before
/// reduction.
///
/// The transposed relation says which forces on the unknowns a force and a moment at the marker
/// are.
#[derive(Debug, Clone, PartialEq)]
pub struct MarkerWeights {
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
    entries: Vec<(u32, [f64; 6])>,
}

impl MarkerWeights {
    /// A marker at `position` \[m\] with the undeformed orientation `rotation`, both in the body's
    /// frame. An entry names an unknown and the displacement along x, y, z and the rotation about
    /// x, y, z that a unit of it causes.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if a number is not finite or unknowns are not in rising order.
    pub fn new(
        position: Vector3<f64>,
        rotation: UnitQuaternion<f64>,
        entries: Vec<(u32, [f64; 6])>,
    ) -> Result<Self, DynamicsError> {
        let is_finite = position.iter().chain(rotation.coords.iter()).all(|v| v.is_finite())
            && entries.iter().flat_map(|(_, w)| w).all(|w| w.is_finite());
        if !is_finite {
            return Err(DataError::NotFinite { what: "position or weight of a marker".into() }.into());
        }
        if let Some(pair) = entries.windows(2).find(|w| w[0].0 >= w[1].0) {
            return Err(
                DataError::Unsorted { what: "the unknowns of a marker", number: pair[1].0 as usize }.into()
            );
        }
        Ok(Self { position, rotation, entries })
    }

    /// The marker that follows a set of nodes: its displacement and rotation are those of the rigid
    /// motion nearest to the nodes' displacements (least squares). A single node moves the marker;
    /// it turns it only by rotations among its own unknowns.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if there are no nodes, one does not exist or lacks an unknown, or they lie in one place or (solid models) in
    /// line and have no rotations.
    pub fn of_nodes(
        body: &AssembledBody,
        position: Vector3<f64>,
        rotation: UnitQuaternion<f64>,
        nodes: &[u32],
    ) -> Result<Self, DynamicsError> {
        let set = NodeSet::new(body, nodes)?;
        let (n_c, share) = (body.motion.n_components(), 1.0 / nodes.len() as f64);
        let turns = set.turns(body.motion)?;
        let mut entries = Vec::new();
        for (unknown, dof) in body.dofs.iter().enumerate() {
            if !set.contains[dof.node as usize] {
                continue;
            }
            let mut w = [0.0; 6];
            if body.motion == RigidMotion::Axial && dof.component == 0 {
                continue; // around the circumference radial displacements have no mean
            }
            let turn = if (dof.component as usize) < n_c {
                let direction = Vector3::ith(body.motion.direction(dof.component as usize), 1.0);
                let moved = direction * share;
                let arm = Vector3::from(body.nodes[dof.node as usize]) - set.centre;
                let turn = turns.map_or(Vector3::zeros(), |t| t * arm.cross(&direction));
                // The centre moves by the mean; the marker is rigidly joined to it.
                let at_marker = moved + turn.cross(&(position - set.centre));
                w[..3].copy_from_slice(at_marker.as_slice());
                turn
            } else if turns.is_none() {
                let axis = body.motion.rotation_axis(dof.component).unwrap_or(2);
                let turn = Vector3::ith(axis, share);
                w[..3].copy_from_slice(turn.cross(&(position - set.centre)).as_slice());
                turn
            } else {
                continue;
            };
            w[3..].copy_from_slice(turn.as_slice());
            entries.push((unknown as u32, w));
        }
        Self::new(position, rotation, entries)
    }

    /// Undeformed position in the body's frame \[m\].
    pub fn position(&self) -> Vector3<f64> {
        self.position
    }

    /// Undeformed rotation from the marker's frame to the body's frame.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        self.rotation
    }

    /// Unknowns with the displacement and the rotation that a unit of each causes.
    pub fn entries(&self) -> &[(u32, [f64; 6])] {
        &self.entries
    }

    /// The marker of the body reduced to the modes `shapes` (n × n_q).
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if an unknown has no row.
    pub fn marker(&self, name: &str, shapes: MatRef<'_, f64>) -> Result<Marker, DynamicsError> {
        self.check_size(shapes.nrows())?;
        let mut rows = vec![[0.0; 6]; shapes.ncols()];
        for (j, row) in rows.iter_mut().enumerate() {
            for (unknown, w) in &self.entries {
                let u = shapes[(*unknown as usize, j)];
                row.iter_mut().zip(w).for_each(|(r, w)| *r += w * u);
            }
        }
        let vectors = |first: usize| -> Vec<Vector3<f64>> {
            rows.iter().map(|r| Vector3::from_column_slice(&r[first..first + 3])).collect()
        };
        Marker::flexible(name, self.position, self.rotation, &vectors(0), &vectors(3))
    }

    /// Forces on the `n` unknowns by unit forces and moments at the marker: a column for each rigid
    /// motion of the model, in the order of [`crate::reduction::RigidModes`] (n × 1, 3 or 6).
    ///
    /// # Errors
    /// [`DynamicsError::Data`] if there are fewer unknowns than the marker names.
    pub fn forces(&self, motion: RigidMotion, n: usize) -> Result<Mat<f64>, DynamicsError> {
        self.check_size(n)?;
        let columns = motion.directions();
        let mut forces = Mat::zeros(n, columns.len());
        for (unknown, w) in &self.entries {
            columns.iter().enumerate().for_each(|(j, c)| forces[(*unknown as usize, j)] = w[*c]);
        }
        Ok(forces)
    }

    /// Checks that the marker follows rigid motions of `body`: translations as they are, rotations
    /// with its lever.
    ///
    /// # Errors
    /// [`DynamicsError::Data`] with the motion that it does not follow.
    pub fn check_rigid_motions(&self, body: &AssembledBody) -> Result<(), DataError> {
        self.check_motions(body, 6)
    }

    /// As [`MarkerWeights::check_rigid_motions`] for the displacements alone.
    ///
    /// # Errors
    /// As there.
    pub fn check_rigid_displacements(&self, body: &AssembledBody) -> Result<(), DataError> {
        self.check_motions(body, 3)
    }

    /// Checks the first `n` of displacements and rotations.
    fn check_motions(&self, body: &AssembledBody, n: usize) -> Result<(), DataError> {
        self.check_size(body.dofs.len())?;
        let size = body.nodes.iter().flatten().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
        for c in body.motion.directions().iter().copied() {
            let field = body.rigid_field(c);
            let mut found = [0.0; 6];
            for (unknown, w) in &self.entries {
                found.iter_mut().zip(w).for_each(|(f, w)| *f += w * field[*unknown as usize]);
            }
            let mut expected = [0.0; 6];
            expected[c] = 1.0;
            if c >= 3 {
                let moved = Vector3::ith(c - 3, 1.0).cross(&self.position);
                expected[..3].copy_from_slice(moved.as_slice());
            }
            let scale = if c < 3 { [1.0, 1.0 / size] } else { [size, 1.0] };
            let is_followed =
                body.motion.directions().iter().filter(|&&d| d < n).all(|&d| {
                    (found[d] - expected[d]).abs() <= RIGIDITY * scale[d / 3].max(f64::MIN_POSITIVE)
                });
            if !is_followed {
                let motion = ["translation along x", "translation along y", "translation along z"]
                    .into_iter()
                    .chain(["rotation about x", "rotation about y", "rotation about z"])
                    .nth(c)
                    .unwrap_or_default();
                let (found, expected) = (Box::new(found), Box::new(expected));
                return Err(DataError::MarkerNotRigid {
                    position: self.position.into(),
                    motion,
                    found,
                    expected,
                });
            }
        }
        Ok(())
    }

    fn check_size(&self, n: usize) -> Result<(), DataError> {
        match self.entries.last() {
            Some((last, _)) if *last as usize >= n => Err(DataError::Index {
                what: "unknowns of a marker".into(),
                number: *last as usize,
                count: n,
            }),
            _ => Ok(()),
        }
    }
}

/// Nodes that carry a marker.
struct NodeSet {
    contains: Vec<bool>,
    centre: Vector3<f64>,
    moment: Matrix3<f64>,
    has_rotations: bool,
}

impl NodeSet {
    fn new(body: &AssembledBody, nodes: &[u32]) -> Result<Self, DynamicsError> {
        if nodes.is_empty() {
            return Err(DataError::Count { what: "nodes of a marker".into(), found: 0, expected: 1 }.into());
        }
        let mut contains = vec![false; body.nodes.len()];
        for &node in nodes {
            match contains.get_mut(node as usize) {
                Some(slot) if !*slot => *slot = true,
                _ => {
                    let (what, count) = ("nodes of a marker".into(), body.nodes.len());
                    return Err(DataError::Index { what, number: node as usize, count }.into());
                }
            }
        }
        let at = |node: u32| Vector3::from(body.nodes[node as usize]);
        let centre = nodes.iter().map(|n| at(*n)).sum::<Vector3<f64>>() / nodes.len() as f64;
        let mut moment = Matrix3::zeros();
        for &node in nodes {
            let d = at(node) - centre;
            moment += Matrix3::identity() * d.norm_squared() - d * d.transpose();
        }
        let n_c = body.motion.n_components();
        let first = usize::from(body.motion == RigidMotion::Axial);
        let (mut displacements, mut rotations) = (0, 0);
        for dof in body.dofs.iter().filter(|d| contains.get(d.node as usize) == Some(&true)) {
            displacements += usize::from((first..n_c).contains(&dof.component.into()));
            rotations += usize::from(dof.component as usize >= n_c);
        }
        let needed = (n_c - first) * nodes.len();
        if displacements != needed {
            let what = format!("displacements of the {} nodes of a marker", nodes.len());
            return Err(DataError::Count { what, found: displacements, expected: needed }.into());
        }
        let has_rotations = rotations == body.motion.n_rotations() * nodes.len() && rotations > 0;
        Ok(Self { contains, centre, moment, has_rotations })
    }

    /// From the moment of displacements to the rotation; none where the nodes' own rotations are
    /// taken.
    fn turns(&self, motion: RigidMotion) -> Result<Option<Matrix3<f64>>, DynamicsError> {
        let eigen = self.moment.symmetric_eigenvalues();
        let is_resolved = match motion {
            RigidMotion::Axial => return Ok(Some(Matrix3::zeros())),
            RigidMotion::Planar => self.moment[(2, 2)] > 0.0,
            RigidMotion::Spatial => eigen.min() > FLATNESS * eigen.max(),
        };
        if !is_resolved {
            if self.has_rotations {
                return Ok(None);
            }
            return Err(DataError::NoRotation { marker: "the nodes of a marker", remedy: "add nodes" }.into());
        }
        let mut moment = self.moment;
        if motion == RigidMotion::Planar {
            moment = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, moment[(2, 2)]));
        }
        Ok(moment.try_inverse())
    }
}
