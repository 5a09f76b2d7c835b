//! Bodies of splines of one's own: control nets in tables, and what can be said of such a body
//! before it is built.

use ffr_dynamics::body::RigidMotion;
use iga_core::nurbs::{Patch, joining};
use iga_core::splines::knots::KnotVector;

use crate::scenario::body_source::GivenPatches;
use crate::scenario::section::Section;
use crate::scenario::tables::BodyModel;

/// Parametric directions of the shape of a body; none if what they follow from is at fault.
pub fn directions(body: &Section) -> Option<usize> {
    Some(match body.choice("model")? {
        BodyModel::Rigid if body.choice::<RigidMotion>("motion")? != RigidMotion::Spatial => 2,
        model => BodyModel::dimension(model),
    })
}

/// Number of patches of the body whose geometry, of splines, is `geometry`.
fn n_patches(geometry: &Section) -> usize {
    let of_file = geometry.spline_file().map(|source| source.given.patches.len());
    of_file.unwrap_or_else(|| geometry.tables("patches").len()).max(1)
}

/// Names of the faces of the body whose geometry, of splines, is `geometry`: those of patches,
/// interfaces among them, and the user's.
pub fn face_names(geometry: &Section, directions: usize) -> Vec<String> {
    let own = geometry.name_lists("faces").iter().map(|(name, _)| name.clone());
    let of_file = geometry.spline_file().into_iter().flat_map(|source| &source.given.faces);
    let of_file = of_file.map(|(name, _)| name.clone());
    joining::face_names(n_patches(geometry), directions).into_iter().chain(of_file).chain(own).collect()
}

/// The patches of a table with `patches`, or with the keys of a single one.
pub fn patches(section: &Section, directions: usize) -> Option<GivenPatches> {
    let mut built = Vec::new();
    if section.item("patches").is_none() {
        built.push(single(section, directions)?);
    } else {
        let list = section.tables("patches");
        if list.is_empty() {
            section.fault("patches", "must hold one patch at least");
        }
        let before = section.faults.len();
        built.extend(list.iter().filter_map(|table| patch(table, directions)));
        if list.is_empty() || built.len() < list.len() || section.faults.len() > before {
            return None;
        }
    }
    Some(GivenPatches { patches: built, joined: Vec::new(), faces: Vec::new() })
}

/// The patch whose keys stand beside the shape, or alone in a file.
fn single(section: &Section, directions: usize) -> Option<Patch> {
    let mut complete = true;
    for key in ["degrees", "knots", "control_points"] {
        if section.item(key).is_none() {
            let message = "required key is missing for shape \"nurbs\" without \"file\" and \"patches\"";
            section.fault(key, message);
            complete = false;
        }
    }
    if complete { patch(section, directions) } else { None }
}

/// A patch from the keys of `section`, which are there.
fn patch(section: &Section, directions: usize) -> Option<Patch> {
    let degrees = per_direction(section, "degrees", directions)?;
    let lists = section.lists("knots")?;
    if lists.len() != directions {
        let message = format!("{} knot vectors, the model has {directions} directions", lists.len());
        return section.refuse("knots", message);
    }
    let (mut knots, mut expected) = (Vec::with_capacity(directions), 1);
    for (i, (&degree, list)) in degrees.iter().zip(lists).enumerate() {
        match KnotVector::new(degree, list.clone()) {
            Ok(vector) => knots.push(vector),
            Err(error) => {
                return section.refuse("knots", format!("direction {i}: {error}"));
            }
        }
        expected *= list.len() - degree - 1;
    }
    let points = section.lists("control_points")?;
    let fits = points.len() == expected && points.iter().all(|p| p.len() == directions);
    if !fits {
        let message = format!(
            "{} control points, degrees and knots ask for {expected} with {directions} coordinates each",
            points.len()
        );
        return section.refuse("control_points", message);
    }
    let weights = match section.item("weights") {
        Some(_) => section.numbers("weights")?.to_vec(),
        None => vec![1.0; expected],
    };
    if weights.len() != expected {
        let message = format!("{} weights, there are {expected} control points", weights.len());
        return section.refuse("weights", message);
    }
    let points = points.iter().map(|p| padded(p)).collect();
    Patch::new(knots, points, weights)
        .map_err(|error| section.fault("control_points", error.to_string()))
        .ok()
}

/// One entry per direction from a single integer or a list.
pub fn per_direction(section: &Section, key: &str, directions: usize) -> Option<Vec<usize>> {
    let counts = section.counts(key)?;
    match counts.len() {
        1 => Some(vec![counts[0]; directions]),
        n if n == directions => Some(counts),
        n => section.refuse(key, format!("{n} entries, the model has {directions} directions")),
    }
}

/// A point with two or three coordinates as one with three.
pub fn padded(x: &[f64]) -> [f64; 3] {
    std::array::from_fn(|i| x.get(i).copied().unwrap_or(0.0))
}
