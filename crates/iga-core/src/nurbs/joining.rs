//! A body of patches given one by one: neighbours are found by their control points, and what does
//! not fit is named (theory section S.3).
//!
//! Patches may stand in any order, be turned against each other in any way, have parameters over
//! any range, and be left-handed. Two faces are one where degrees, knots, control points and
//! weights agree; files carry six digits or more, so what agrees to [`WELD`] is made equal.
//! Everything else that touches is a fault: there displacements would tear.

pub mod fault;
mod compare;
mod meeting;
mod welding;

use std::collections::BTreeSet;

use super::interface::{FaceId, FaceNet, Way, coinciding_pairs};
use super::patch::PointBasis;
use super::{Patch, Shape};
use crate::nurbs::Face;
use fault::JoinFault;

/// Distance below which control points are one, as a share of the size of the smaller patch: six
/// digits are what text files of single precision carry.
pub const WELD: f64 = 1e-6;

/// A body, and what was done to the patches.
#[derive(Debug, Clone, PartialEq)]
pub struct Joined {
    /// Its shape, all parameters from 0 to 1.
    pub shape: Shape,
    /// Sentences for the user.
    pub notes: Vec<String>,
}

/// Names of the ends of the parametric directions.
const DIRECTIONS: [&str; 3] = ["xi", "eta", "zeta"];

/// The name of a face: `xi-` of a body of one patch, `2:xi-` of patch 2 (counted from 0) of
/// several.
pub fn face_name(id: FaceId, n_patches: usize) -> String {
    let end = if id.upper { "+" } else { "-" };
    let name = format!("{}{end}", DIRECTIONS[id.direction]);
    if n_patches == 1 { name } else { format!("{}:{name}", id.patch) }
}

/// Names of all faces of `n_patches` patches of `dimension` directions, of several also `surface`,
/// which are all outer ones.
pub fn face_names(n_patches: usize, dimension: usize) -> Vec<String> {
    let ends = |patch| {
        (0..dimension)
            .flat_map(move |direction| [false, true].map(|upper| FaceId { patch, direction, upper }))
    };
    let names = (0..n_patches).flat_map(ends).map(|id| face_name(id, n_patches));
    names.chain((n_patches > 1).then(|| SURFACE.to_owned())).collect()
}

/// Name of all outer faces of a body of several patches.
const SURFACE: &str = "surface";

/// Patches on the way to a body.
struct Parts {
    patches: Vec<Patch>,
    /// Whether the first direction of each runs against the one given.
    is_reversed: Vec<bool>,
    /// All faces, those collapsed to a line or point not.
    faces: Vec<FaceId>,
    /// Pairs of `faces` that are one, and how the first lies on the second.
    ties: Vec<(usize, usize, Way)>,
}

/// Joins `given` patches; `declared`: pairs of faces that must be joined.
///
/// # Errors
/// [`JoinFault`].
pub fn join(given: &[Patch], declared: &[[FaceId; 2]]) -> Result<Joined, JoinFault> {
    let mut notes = Vec::new();
    let (patches, is_reversed) = right_handed(given, &mut notes)?;
    let mut parts = Parts::new(patches, is_reversed)?;
    parts.check_ties()?;
    welding::weld(&mut parts, &mut notes)?;
    meeting::check(&parts)?;
    let tied: BTreeSet<[FaceId; 2]> = parts.ties.iter().map(|&(a, b, _)| parts.pair(a, b)).collect();
    for pair in declared {
        let mut ids = pair.map(|id| parts.turned(id));
        ids.sort_unstable();
        if !tied.contains(&ids) {
            return Err(JoinFault::NotJoined { faces: ids.map(|id| parts.name(id)) });
        }
    }
    parts.check_connected()?;
    let mut shape = Shape::from_patches(parts.patches.clone())
        .map_err(|source| JoinFault::Patch { patch: 0, source: Box::new(source) })?;
    let outer: Vec<FaceId> = shape.faces.values().flatten().copied().collect();
    shape.faces = outer.iter().map(|&id| (parts.name(id), vec![id])).collect();
    if parts.patches.len() > 1 {
        shape.faces.insert(SURFACE.to_owned(), outer);
    }
    Ok(Joined { shape, notes })
}

/// The patches with parameters from 0 to 1, left-handed ones run through backwards in their first
/// direction.
fn right_handed(given: &[Patch], notes: &mut Vec<String>) -> Result<(Vec<Patch>, Vec<bool>), JoinFault> {
    let expected = given.first().ok_or(JoinFault::NoPatch)?.dimension();
    let (mut patches, mut is_reversed) = (Vec::with_capacity(given.len()), Vec::with_capacity(given.len()));
    for (i, patch) in given.iter().enumerate() {
        if patch.dimension() != expected {
            return Err(JoinFault::Directions { patch: i, found: patch.dimension(), expected });
        }
        let fail = |source| JoinFault::Patch { patch: i, source: Box::new(source) };
        let mut patch = patch.over_unit_ranges().map_err(fail)?;
        let middle = [0.43, 0.47, 0.53]; // inside an element of any that is not cut there
        let determinant = patch.jet(&middle, 1, &mut PointBasis::default()).determinant(expected);
        is_reversed.push(determinant < 0.0);
        if determinant < 0.0 {
            patch = patch.reversed(0).map_err(fail)?;
        }
        patch.check_orientation().map_err(fail)?;
        patches.push(patch);
    }
    let turned: Vec<String> =
        is_reversed.iter().enumerate().filter(|(_, r)| **r).map(|(i, _)| i.to_string()).collect();
    if !turned.is_empty() {
        notes.push(format!(
            "left-handed, and run through backwards in xi (faces keep their names): {} {}",
            if turned.len() == 1 { "patch" } else { "patches" },
            turned.join(", ")
        ));
    }
    Ok((patches, is_reversed))
}

impl Parts {
    fn new(patches: Vec<Patch>, is_reversed: Vec<bool>) -> Result<Self, JoinFault> {
        let mut faces = FaceId::all(&patches);
        faces.retain(|&id| !Face::new(&patches, id, false).is_collapsed(&patches[id.patch]));
        let nets: Vec<FaceNet> = faces.iter().map(|&id| FaceNet::new(&patches, id)).collect();
        let ties = coinciding_pairs(&nets, WELD);
        let parts = Self { patches, is_reversed, faces, ties };
        let mut partners = vec![Vec::new(); parts.faces.len()];
        for &(a, b, _) in &parts.ties {
            partners[a].push(b);
            partners[b].push(a);
        }
        if let Some((face, all)) = partners.iter().enumerate().find(|(_, all)| all.len() > 1) {
            let faces = std::iter::once(&face).chain(all).map(|&f| parts.name(parts.faces[f])).collect();
            return Err(JoinFault::Shared { faces });
        }
        Ok(parts)
    }

    /// The face that was given as `id`, or the other way round.
    fn turned(&self, id: FaceId) -> FaceId {
        let is_turned = id.direction == 0 && self.is_reversed.get(id.patch).copied().unwrap_or(false);
        FaceId { upper: id.upper != is_turned, ..id }
    }

    /// The name of a face, which is the one that it had as given.
    fn name(&self, id: FaceId) -> String {
        face_name(self.turned(id), self.patches.len())
    }

    fn pair(&self, a: usize, b: usize) -> [FaceId; 2] {
        let mut pair = [self.faces[a], self.faces[b]];
        pair.sort_unstable();
        pair
    }

    fn names(&self, a: usize, b: usize) -> [String; 2] {
        [a, b].map(|f| self.name(self.faces[f]))
    }

    /// Checks that faces whose control points agree are one spline, with the material on either
    /// side.
    fn check_ties(&self) -> Result<(), JoinFault> {
        for &(a, b, way) in &self.ties {
            if let Some(difference) = compare::splines(&self.patches, [self.faces[a], self.faces[b]], way) {
                return Err(JoinFault::Mismatch { faces: self.names(a, b), difference });
            }
            meeting::check_sides(self, a, b, way)?;
        }
        Ok(())
    }

    /// Checks that every patch can be reached from the first one through shared faces.
    fn check_connected(&self) -> Result<(), JoinFault> {
        let (mut is_reached, mut next) = (vec![false; self.patches.len()], vec![0]);
        let mut neighbours = vec![Vec::new(); self.patches.len()];
        for &(a, b, _) in &self.ties {
            let (a, b) = (self.faces[a].patch, self.faces[b].patch);
            neighbours[a].push(b);
            neighbours[b].push(a);
        }
        while let Some(patch) = next.pop() {
            if !std::mem::replace(&mut is_reached[patch], true) {
                next.extend(&neighbours[patch]);
            }
        }
        match is_reached.iter().position(|reached| !reached) {
            Some(patch) => Err(JoinFault::Apart { patch }),
            None => Ok(()),
        }
    }
}
