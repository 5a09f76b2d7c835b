//! A checked mesh in metres, from a mesh as a file has it.

pub mod tie;
pub mod raw;
pub mod boundary;
pub mod pieces;
pub mod check;
mod straight;
pub mod plane;

use std::collections::HashMap;

use boundary::{ByCorners, Face, boundary, key};

use iga_core::elasticity::Model;

use crate::element::kind::SideKind;
use crate::fault::{MeshError, MeshFault, shown};
use raw::{Element, Elements, FaceSource, RawMesh, StatedModel};
use tie::{Joined, Tie};

/// A mesh of one part.
#[derive(Clone, PartialEq)]
pub struct Mesh {
    model: Model,
    stated: Option<StatedModel>,
    nodes: Vec<[f64; 3]>,
    node_labels: Vec<u64>,
    elements: Elements,
    surface: Vec<Face>,
    volumes: Vec<(String, Vec<u32>)>,
    faces: Vec<(String, Vec<Face>)>,
    notes: Vec<String>,
    ties: Vec<Tie>,
}

impl std::fmt::Debug for Mesh {
    /// Counts and names: a mesh is too long to be shown.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (nodes, elements) = (self.nodes.len(), self.elements.len());
        let faces: Vec<&str> = self.face_names().collect();
        f.debug_struct("Mesh")
            .field("nodes", &nodes)
            .field("elements", &elements)
            .field("faces", &faces)
            .finish_non_exhaustive()
    }
}

impl Mesh {
    /// Checks a mesh read from a file whose unit of length is `unit` metres; nodes of no element
    /// are left out with a note.
    ///
    /// # Errors
    /// [`MeshError::Mesh`] with the element that makes no body.
    pub fn new(mut raw: RawMesh, unit: f64) -> Result<Self, MeshError> {
        if !(unit > 0.0 && unit.is_finite()) {
            return Err(MeshFault::Unit { unit }.into());
        }
        let numbers = check::used_nodes(&raw.elements, &raw.node_labels, &mut raw.notes);
        raw.keep_nodes(&numbers);
        let dimension = raw.elements.iter().next().map_or(3, |e| e.kind.dimension());
        if dimension == 2 {
            plane::flatten(&mut raw)?;
        }
        let RawMesh { mut nodes, node_labels, elements, stated, volumes, faces, mut notes, ties } = raw;
        nodes.iter_mut().for_each(|x| *x = x.map(|x| unit * x));
        check::distinct_nodes(&elements, &node_labels)?;
        pieces::one_piece(&elements, &volumes, nodes.len())?;
        check::orders(&elements)?;
        let (surface, by_corners) = boundary(&elements)?;
        if surface.is_empty() {
            return Err(MeshFault::NoSurface.into());
        }
        straight::straighten(&elements, &mut nodes, &mut notes);
        check::orientation(&elements, &nodes, &mut notes)?;
        check::stiffness(&elements, &nodes, &mut notes);
        check::size(&nodes, &mut notes);
        let mut groups: Vec<(String, Vec<Face>)> = Vec::new();
        let mut places: HashMap<String, usize> = HashMap::new();
        for (name, source) in faces {
            let Found { faces, inside } = group(&elements, nodes.len(), (&surface, &by_corners), &source);
            if let (FaceSource::Corners(all), Some(inside)) = (&source, inside) {
                let n = all.len();
                notes.push(format!(
                    "{inside} of the {n} elements of group \"{name}\" are no sides of the surface"
                ));
            }
            // One name is one place, however many groups of the file have it.
            match places.get(&name) {
                Some(&place) => {
                    let all = &mut groups[place].1;
                    all.extend(faces);
                    all.sort_unstable();
                    all.dedup();
                }
                None => {
                    places.insert(name.clone(), groups.len());
                    groups.push((name, faces));
                }
            }
        }
        let model = if dimension == 2 { Model::PlaneStrain { thickness: 1.0 } } else { Model::Solid };
        Ok(Self { model, stated, nodes, node_labels, elements, surface, volumes, faces: groups, notes, ties })
    }

    /// The mesh with other elements of the same part, whose `surface` sides are rising, and no
    /// groups of elements.
    pub(crate) fn divided(
        model: Model,
        (nodes, elements): (Vec<[f64; 3]>, Elements),
        surface: Vec<Face>,
        faces: Vec<(String, Vec<Face>)>,
    ) -> Self {
        let node_labels = (1..=nodes.len() as u64).collect();
        let (stated, volumes, notes, ties) = (None, Vec::new(), Vec::new(), Vec::new());
        Self { model, stated, nodes, node_labels, elements, surface, volumes, faces, notes, ties }
    }

    /// Positions of the nodes \[m\].
    pub fn nodes(&self) -> &[[f64; 3]] {
        &self.nodes
    }

    /// Numbers of the nodes in the file.
    pub fn node_labels(&self) -> &[u64] {
        &self.node_labels
    }

    /// Elements.
    pub fn elements(&self) -> &Elements {
        &self.elements
    }

    /// Sides that bound the mesh.
    pub fn surface(&self) -> &[Face] {
        &self.surface
    }

    /// Groups of elements by name.
    pub fn volumes(&self) -> &[(String, Vec<u32>)] {
        &self.volumes
    }

    /// Groups of faces by name; those without a face on the surface are no places for anything.
    pub fn faces(&self) -> &[(String, Vec<Face>)] {
        &self.faces
    }

    /// What the file has that was left out, and what the mesh is not good for.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// What the file joins, of all its parts.
    pub fn ties(&self) -> &[Tie] {
        &self.ties
    }

    /// The group of faces that `joined` names in this mesh, the part called `part` of a file; `None` if that is
    /// none of this part.
    pub fn joined_face(&self, part: &str, joined: &Joined) -> Option<&str> {
        let Joined::Group(name) = joined else { return None };
        let called = |name: &str| self.face_names().find(|face| face.eq_ignore_ascii_case(name));
        let own = || {
            let (owner, rest) = name.split_at_checked(part.len())?;
            called(rest.strip_prefix('.').filter(|_| owner.eq_ignore_ascii_case(part))?)
        };
        called(name).or_else(own)
    }

    /// Names of the groups of faces that have faces.
    pub fn face_names(&self) -> impl Iterator<Item = &str> {
        self.faces.iter().filter(|(_, faces)| !faces.is_empty()).map(|(name, _)| name.as_str())
    }

    /// The faces of group `name`.
    ///
    /// # Errors
    /// [`MeshFault::UnknownGroup`], [`MeshFault::NoSides`].
    pub fn face_group(&self, name: &str) -> Result<&[Face], MeshFault> {
        match self.faces.iter().find(|(n, _)| n == name) {
            Some((_, faces)) if faces.is_empty() => Err(MeshFault::NoSides { name: name.to_owned() }),
            Some((_, faces)) => Ok(faces),
            None => {
                let known = shown(self.face_names());
                Err(MeshFault::UnknownGroup { what: "faces", name: name.to_owned(), known })
            }
        }
    }

    /// The elements of group `name`.
    ///
    /// # Errors
    /// [`MeshFault::UnknownGroup`].
    pub fn volume_group(&self, name: &str) -> Result<&[u32], MeshFault> {
        let found = self.volumes.iter().find(|(n, _)| n == name);
        found.map(|(_, elements)| elements.as_slice()).ok_or_else(|| MeshFault::UnknownGroup {
            what: "elements",
            name: name.to_owned(),
            known: shown(self.volumes.iter().map(|(n, _)| n.as_str())),
        })
    }

    /// For every element the place in `groups` of the one that it is in, the number of groups for
    /// one in none of them if that `may_be`.
    ///
    /// # Errors
    /// [`MeshFault::UnknownGroup`]; [`MeshFault::Materials`] for an element that is in none or in several.
    pub fn by_group(&self, groups: &[&str], may_be: bool) -> Result<Vec<u16>, MeshFault> {
        let mut found = vec![(0usize, groups.len() as u16); self.elements.len()];
        for (i, name) in groups.iter().enumerate() {
            for &e in self.volume_group(name)? {
                let entry = &mut found[e as usize];
                *entry = (entry.0 + 1, i as u16);
            }
        }
        match found.iter().position(|(count, _)| *count != 1 && !(may_be && *count == 0)) {
            Some(e) => {
                let element = self.elements.get(e).label;
                Err(MeshFault::Materials { element, found: found[e].0 })
            }
            None => Ok(found.into_iter().map(|(_, group)| group).collect()),
        }
    }

    /// Kind and nodes of a face, in the order of the kind, right-handed about the outward normal.
    pub fn face(&self, face: Face) -> (SideKind, Vec<u32>) {
        let Element { kind, nodes, .. } = self.elements.get(face.element as usize);
        let (side, local) = kind.side_nodes(face.side as usize);
        (side, local.iter().map(|&k| nodes[k as usize]).collect())
    }

    /// Positions of `nodes` into `out` \[m\].
    pub fn places(&self, nodes: &[u32], out: &mut Vec<[f64; 3]>) {
        out.clear();
        out.extend(nodes.iter().map(|&n| self.nodes[n as usize]));
    }

    /// Length of the diagonal of the box around the nodes \[m\].
    pub fn size(&self) -> f64 {
        check::diagonal(&self.nodes)
    }
}

/// Faces of a group.
struct Found {
    faces: Vec<Face>,
    /// Surface elements that are no sides of the surface, if there are any.
    inside: Option<usize>,
}

fn group(
    elements: &Elements,
    n_nodes: usize,
    (surface, by_corners): (&[Face], &ByCorners),
    source: &FaceSource,
) -> Found {
    let mut inside = 0;
    let mut faces: Vec<Face> = match source {
        FaceSource::Corners(all) => {
            let found: Vec<Face> =
                all.iter().filter_map(|c| by_corners.get(&key(c.iter().copied()))).copied().collect();
            inside = all.len() - found.len();
            found
        }
        FaceSource::Sides(all) => {
            let face = |&(element, side): &(u32, u8)| {
                let face = Face { element, side };
                surface.binary_search(&face).is_ok().then_some(face)
            };
            all.iter().filter_map(face).collect()
        }
        FaceSource::Nodes(all) => {
            let mut is_in = vec![false; n_nodes];
            all.iter().for_each(|&n| is_in[n as usize] = true);
            let whole = |face: &&Face| {
                let element = elements.get(face.element as usize);
                let (_, local) = element.kind.side_nodes(face.side as usize);
                local.iter().all(|&k| is_in[element.nodes[k as usize] as usize])
            };
            surface.iter().filter(whole).copied().collect()
        }
    };
    faces.sort_unstable();
    faces.dedup();
    Found { faces, inside: (inside > 0).then_some(inside) }
}
