//! Makes equal what agrees to a few digits: control points, weights and knots of faces that are
//! one.

use std::collections::BTreeMap;

use super::compare::entries;
use super::{Parts, WELD};
use crate::SplineError;
use crate::nurbs::Patch;
use crate::nurbs::interface::FaceNet;
use crate::nurbs::interface::linked::linked_directions;
use crate::nurbs::jet::{diagonal, difference, norm};
use crate::nurbs::joining::fault::JoinFault;

/// Share of the size of the body up to which a difference is round-off and not worth a note.
const ROUND_OFF: f64 = 1e-12;

/// Makes control points, weights and knots of faces that are one equal to those of the patch that
/// comes first.
pub fn weld(parts: &mut Parts, notes: &mut Vec<String>) -> Result<(), JoinFault> {
    let scales = scales(parts);
    let first: Vec<usize> = parts
        .patches
        .iter()
        .scan(0, |next, p| {
            *next += p.n_functions();
            Some(*next - p.n_functions())
        })
        .collect();
    let mut points: Vec<[f64; 3]> = parts.patches.iter().flat_map(|p| p.control_points()).copied().collect();
    let scaled = parts.patches.iter().zip(&scales).flat_map(|(p, s)| p.weights().iter().map(move |w| w * s));
    let mut weights: Vec<f64> = scaled.collect();
    let mut parents: Vec<usize> = (0..points.len()).collect();
    for &(a, b, way) in &parts.ties {
        let [one, other] = [a, b].map(|f| {
            let id = parts.faces[f];
            entries(&parts.patches, id).map(|i| first[id.patch] + i).collect::<Vec<_>>()
        });
        let sizes = FaceNet::new(&parts.patches, parts.faces[a]).sizes();
        for (i, &p) in one.iter().enumerate() {
            let q = other[way.partner(sizes, i)];
            if (weights[p] - weights[q]).abs() > WELD * weights[p] {
                // Around a ring of patches the scales do not close.
                let difference = format!(
                    "their weights are in no fixed proportion, {} and {} at ({}, {}, {}) m",
                    weights[p], weights[q], points[p][0], points[p][1], points[p][2]
                );
                return Err(JoinFault::Mismatch { faces: parts.names(a, b), difference });
            }
            let (p, q) = (root(&parents, p), root(&parents, q));
            parents[p.max(q)] = p.min(q);
        }
    }
    let size = diagonal(&points);
    let mut farthest = 0.0_f64;
    for i in 0..points.len() {
        let r = root(&parents, i);
        farthest = farthest.max(norm(&difference(&points[i], &points[r])));
        (points[i], weights[i]) = (points[r], weights[r]);
    }
    if farthest > ROUND_OFF * size {
        notes.push(format!(
            "control points of faces that are one lie up to {farthest:.2e} m apart and were made equal"
        ));
    }
    let rebuild = |(i, patch): (usize, &Patch)| {
        let own = first[i]..first[i] + patch.n_functions();
        Patch::new(patch.knots().to_vec(), points[own.clone()].to_vec(), weights[own].to_vec())
            .map_err(|source| JoinFault::Patch { patch: i, source: Box::new(source) })
    };
    let patches: Vec<Patch> = parts.patches.iter().enumerate().map(rebuild).collect::<Result<_, _>>()?;
    parts.patches = same_knots(&patches)?;
    Ok(())
}

fn root(parents: &[usize], mut i: usize) -> usize {
    while parents[i] != i {
        i = parents[i];
    }
    i
}

/// Factors on the weights of each patch, which change nothing of it, by which the weights of shared
/// faces become equal.
fn scales(parts: &Parts) -> Vec<f64> {
    let mut scales = vec![None; parts.patches.len()];
    let weight = |f: usize, i: usize| {
        let id = parts.faces[f];
        entries(&parts.patches, id).nth(i).map_or(1.0, |e| parts.patches[id.patch].weights()[e])
    };
    let mut neighbours = vec![Vec::new(); parts.patches.len()];
    for &(a, b, way) in &parts.ties {
        let sizes = FaceNet::new(&parts.patches, parts.faces[a]).sizes();
        let ratio = weight(a, 0) / weight(b, way.partner(sizes, 0));
        neighbours[parts.faces[a].patch].push((parts.faces[b].patch, ratio));
        neighbours[parts.faces[b].patch].push((parts.faces[a].patch, 1.0 / ratio));
    }
    for start in 0..scales.len() {
        let mut next = vec![(start, 1.0)];
        while let Some((patch, scale)) = next.pop() {
            if scales[patch].is_none() {
                // Weights that are equal already stay to the bit.
                let scale = if f64::abs(scale - 1.0) < ROUND_OFF { 1.0 } else { scale };
                scales[patch] = Some(scale);
                next.extend(neighbours[patch].iter().map(|(other, ratio)| (*other, scale * ratio)));
            }
        }
    }
    scales.into_iter().map(|s| s.unwrap_or(1.0)).collect()
}

/// The patches with the knots of the first of all directions that are divided together.
fn same_knots(patches: &[Patch]) -> Result<Vec<Patch>, JoinFault> {
    let mut known = BTreeMap::new();
    let mut out = Vec::with_capacity(patches.len());
    for (i, (patch, links)) in patches.iter().zip(linked_directions(patches)).enumerate() {
        let knots = patch.knots().iter().zip(links).map(|(own, link)| {
            let first = known.entry(link.group).or_insert_with(|| own.clone());
            if link.is_reversed { first.reversed() } else { Ok(first.clone()) }
        });
        let rebuilt = knots
            .collect::<Result<Vec<_>, SplineError>>()
            .and_then(|knots| Patch::new(knots, patch.control_points().to_vec(), patch.weights().to_vec()));
        out.push(rebuilt.map_err(|source| JoinFault::Patch { patch: i, source: Box::new(source) })?);
    }
    Ok(out)
}
